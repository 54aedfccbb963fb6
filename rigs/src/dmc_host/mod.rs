//! What Dragonframe does with a DMC controller: asks, moves, uploads, runs, shoots, stops.
//!
//! It keeps what the crate's machine only names: the messages, and the data of a move. What it tells carries the answers,
//! so that an application needs to look at nothing else. A device is taken for configured as soon as it is known.

mod check;
mod safety;
mod table;
mod types;

use std::collections::{BTreeMap, VecDeque};
use std::mem;

use dmc_proto::host::{self, Event as Told, HostMachine, Input, Name, Options, Outcome, State};
use dmc_proto::lint::Context;
use dmc_proto::message::{
    CameraFlags, DeviceMessage, Empty, GioCam, Hi, HostMessage, RtShootFrame, RtShootFrame2, RtUploadMoveBegin,
};
use dmc_proto::upload::{self, SCRATCH, Section, SectionSize};
use dmc_proto::{EncodeError, Frames, Item};
use motion_core::machine::Machine;
use motion_core::time::Millis;
use tracing::{debug, info, warn};

use crate::{Host, LineId, Outgoing, Party};

pub use dmc_proto::host::{Failure, Progress, Stop, Token};
pub use table::Table;
pub use types::{Answer, Command, Event, Positions, Shot};

use check::Check;
use safety::Safety;

/// The only line.
const LINE: LineId = LineId(0);
/// Milliseconds without a byte, after which a frame that is not whole will not be.
const GAP: u64 = 250;

/// A host of DMC controllers. It takes its line as it is, and does not ask for it.
#[derive(Debug)]
pub struct DmcHost {
    is_open: bool,
    frames: Frames,
    gap: Option<Millis>,
    core: Core,
}

/// The tokens of what the host asks by itself.
const SHUTTER: Token = Token(u32::MAX);
const CHECK: Token = Token(u32::MAX - 1);

/// The host behind its line.
#[derive(Debug)]
struct Core {
    clock: Millis,
    machine: HostMachine,
    wake: Option<Millis>,
    /// What was asked and has not ended.
    asked: BTreeMap<Token, Asked>,
    /// The move that is uploaded, and whether the device has it.
    table: Table,
    uploaded: bool,
    /// Where the motors were when they were told last.
    positions: Option<Positions>,
    safety: Safety,
    /// What is over, and not yet known to be done.
    check: Option<Check>,
    out: VecDeque<Outgoing>,
    events: VecDeque<Event>,
}

/// What was asked.
#[derive(Debug, Clone)]
enum Asked {
    Message(HostMessage<'static>),
    Shot(Shot),
}

impl Asked {
    fn message(&self) -> HostMessage<'_> {
        match self {
            Self::Message(message) => *message,
            Self::Shot(shot) => shot.message(),
        }
    }
}

impl Shot {
    /// In the second form where the device has no first one.
    fn message(&self) -> HostMessage<'_> {
        let Self { frame, direction, exposure_ms, blur_x10, open_angle, close_angle, .. } = *self;
        if self.is_second_form {
            let motors = &self.motors;
            let shot = RtShootFrame2 { frame, exposure_ms, open_angle, close_angle, motors, tail: &[] };
            return HostMessage::RtShootFrame2(shot);
        }
        let motors = &self.motors;
        HostMessage::RtShootFrame(RtShootFrame { frame, direction, exposure_ms, blur_x10, motors, tail: &[] })
    }
}

impl DmcHost {
    /// A host that waits for its line to be open.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self { is_open: false, frames: Frames::new(), gap: None, core: Core::new(options) }
    }

    /// What the device said of itself.
    #[must_use]
    pub const fn device(&self) -> Option<Hi<'static>> {
        self.core.machine.device()
    }

    /// How far the connection is.
    #[must_use]
    pub const fn state(&self) -> State {
        self.core.machine.state()
    }

    /// How far the sequence is, if one runs.
    #[must_use]
    pub fn progress(&self) -> Option<Progress> {
        self.core.machine.progress()
    }

    /// Whether the device has a move that can be run; `None` if nobody knows.
    #[must_use]
    pub const fn is_loaded(&self) -> Option<bool> {
        self.core.machine.is_loaded()
    }

    /// Where the motors were when they were told last.
    #[must_use]
    pub const fn positions(&self) -> Option<&Positions> {
        self.core.positions.as_ref()
    }

    /// Whether something that was set in motion here is not known to rest, or may still begin. A shutter that is open
    /// counts as well.
    #[must_use]
    pub fn may_move(&self) -> bool {
        let machine = &self.core.machine;
        self.core.safety.may_move() || machine.is_armed() || machine.unconfirmed_stops().next().is_some()
    }

    /// Stops everything, and closes a shutter that was opened by hand.
    pub fn stop_all(&mut self, now: Millis) {
        let has_shutter_open = self.core.safety.has_shutter_open();
        self.command(now, Command::Stop(Stop::All));
        if has_shutter_open {
            let off = GioCam { flags: CameraFlags::empty(), tail: &[] };
            self.command(now, Command::Ask(SHUTTER, HostMessage::GioCam(off)));
        }
    }

    /// What speaks against the upload of a move to this device, before anything is sent.
    ///
    /// # Errors
    ///
    /// [`EncodeError`] says what does not fit.
    pub fn fits(&self, table: &Table) -> Result<RtUploadMoveBegin<'static>, EncodeError> {
        upload::begin(table, &self.device().map(Context::of).unwrap_or_default())
    }

    /// Bytes of input and output that it holds.
    #[must_use]
    pub fn held(&self) -> usize {
        let len = |outgoing: &Outgoing| if let Outgoing::Bytes(_, bytes) = outgoing { bytes.len() } else { 0 };
        self.frames.held() + self.core.out.iter().map(len).sum::<usize>()
    }
}

impl Default for DmcHost {
    fn default() -> Self {
        Self::new(Options::default())
    }
}

impl Core {
    fn new(options: Options) -> Self {
        Self {
            clock: Millis(0),
            machine: HostMachine::new(options),
            wake: None,
            asked: BTreeMap::new(),
            table: Table::default(),
            uploaded: false,
            positions: None,
            safety: Safety::default(),
            check: None,
            out: VecDeque::new(),
            events: VecDeque::new(),
        }
    }

    fn step(&mut self, input: Input<'_>) {
        let (machine, output) = self.machine.clone().step(self.clock, input);
        self.machine = machine;
        self.wake = output.wake;
        for send in &output.send {
            self.send(*send);
        }
        for told in output.events {
            self.tell(told, input);
        }
    }

    fn send(&mut self, send: host::Send) {
        let (mut scratch, mut bytes) = ([0; SCRATCH], [0; 1048]);
        let lost = HostMessage::MotorStatus(Empty { tail: &[] });
        let message = send.message(|name| match name {
            // What the machine names has been given to it, and has not ended.
            Name::Message(token) => self.asked.get(&token).map_or(lost, Asked::message),
            Name::Section(section) => section.message(&self.table, &mut scratch),
        });
        debug!("sends {message}");
        self.safety.sent(&send, &message);
        match message.encode_into(send.id, &mut bytes) {
            Ok(len) => self.out.push_back(Outgoing::Bytes(LINE, bytes[..len].to_vec())),
            Err(error) => warn!(%error, "a request that cannot be sent"),
        }
    }

    fn tell(&mut self, told: Told, input: Input<'_>) {
        debug!(?told);
        let event = match told {
            Told::Greeted => {
                self.step(Input::Command(host::Command::Configured));
                return;
            }
            Told::Up => match self.machine.device() {
                Some(device) => Event::Up(device),
                None => return,
            },
            Told::NoAnswer => Event::NoAnswer,
            Told::Closed => Event::Closed,
            Told::DeviceReset => {
                self.uploaded = false;
                Event::DeviceReset
            }
            Told::NextSection(behind) => {
                let (size, table) = (SectionSize::default(), &self.table);
                let section = behind.map_or_else(|| Section::first(table, size), |section| section.next(table, size));
                return self.step(Input::Section(section));
            }
            Told::Done(token, outcome) => return self.done(token, outcome, input),
            Told::Failed(token, failure) => {
                let asked = self.asked.remove(&token);
                self.safety.failed(token, asked.as_ref().map(Asked::message), failure);
                match token {
                    CHECK => return self.checked(Err(failure)),
                    SHUTTER => return,
                    _ => {}
                }
                Event::Failed(token, failure)
            }
            Told::Ready(token) => Event::Ready(token),
            Told::Started(token) => Event::Started(token),
            Told::PassEnded(token) => Event::PassEnded(token),
            Told::Stopped(stop) => {
                self.safety.stopped(stop);
                Event::Stopped(stop)
            }
            Told::StopNotConfirmed(stop) => Event::StopNotConfirmed(stop),
            Told::HardStop(reason, motor) => Event::HardStop(reason, motor),
            Told::Moving(motors) => {
                self.safety.status(motors);
                Event::Moving(motors)
            }
            Told::Unasked(_) => match input {
                Input::Received(_, DeviceMessage::GioIn(inputs)) => Event::Inputs(inputs.triggers),
                // Positions are told where they arrive.
                _ => return,
            },
            Told::Unreadable => Event::Unreadable,
            Told::Ignored => Event::Ignored,
            // Late answers are of no use.
            _ => return,
        };
        self.events.push_back(event);
    }

    fn done(&mut self, token: Token, outcome: Outcome, input: Input<'_>) {
        let answer = self.answer(token, outcome, input);
        let asked = self.asked.remove(&token);
        let message = asked.as_ref().map(Asked::message);
        self.safety.done(token, message, &answer);
        if token == SHUTTER {
            return;
        }
        if token == CHECK {
            let check = self.check.as_ref();
            let holds = check.map_or(Ok(()), |check| check.holds(self.positions.as_ref(), &self.table));
            return self.checked(holds);
        }
        let check = message.as_ref().and_then(|message| Check::of(token, message));
        if outcome == Outcome::Finished && check.is_some() && self.uploaded {
            self.check = check;
            return self.command(Command::Ask(CHECK, HostMessage::MotorGetPosition(Empty { tail: &[] })));
        }
        self.uploaded |= matches!(message, Some(HostMessage::RtUploadMoveBegin(_)));
        self.events.push_back(Event::Done(token, answer));
    }

    /// What was over is done, or not.
    fn checked(&mut self, end: Result<(), Failure>) {
        if let Some(Check { token, .. }) = self.check.take() {
            self.events.push_back(match end {
                Ok(()) => Event::Done(token, Answer::Done),
                Err(failure) => Event::Failed(token, failure),
            });
        }
    }

    fn answer(&self, token: Token, outcome: Outcome, input: Input<'_>) -> Answer {
        let asked = self.asked.get(&token).map(Asked::message);
        match (asked, input) {
            (_, Input::Received(_, DeviceMessage::MotorStatus(status))) if outcome == Outcome::Answered => {
                Answer::Moving(status.motor_status)
            }
            (_, Input::Received(_, DeviceMessage::GioIn(inputs))) if outcome == Outcome::Answered => {
                Answer::Inputs(inputs.triggers)
            }
            // Some devices tell positions beside an acknowledgement.
            (Some(HostMessage::MotorGetPosition(_)), _) => {
                self.positions.clone().map_or(Answer::Done, Answer::Positions)
            }
            _ => Answer::Done,
        }
    }

    fn received(&mut self, item: Item<'_, dmc_proto::Frame<'_>, dmc_proto::Header>) {
        match item {
            Item::Frame(frame) => {
                let input = Input::frame(&frame);
                if let Input::Received(_, message) = &input {
                    debug!("receives {message}");
                    if let DeviceMessage::MotorGetPosition(told) = message {
                        let positions = told.positions.iter().map(|steps| steps.get()).collect();
                        let positions = Positions { moment: told.move_time, positions };
                        self.positions = Some(positions.clone());
                        self.events.push_back(Event::Positions(positions));
                    }
                }
                self.step(input);
            }
            Item::Corrupt { why, .. } => {
                warn!(%why, "an answer arrived damaged");
                self.step(Input::Corrupt);
            }
            Item::Noise { bytes, why } => debug!(%why, len = bytes.len(), "noise"),
            Item::Fatal(why) => warn!(%why, "the stream cannot go on"),
        }
    }

    fn command(&mut self, command: Command) {
        let (token, asked, is_sequence) = match command {
            Command::Greet => return self.step(Input::Command(host::Command::Greet)),
            Command::Go => return self.step(Input::Command(host::Command::Go)),
            Command::EndStops => return self.step(Input::Command(host::Command::EndStops)),
            Command::Stop(stop) => {
                info!(?stop, "stop");
                return self.step(Input::Command(host::Command::Stop(stop)));
            }
            Command::Ask(token, message) => (token, Asked::Message(message), false),
            Command::Begin(token, message) => (token, Asked::Message(message), true),
            Command::Shoot(token, shot) => (token, Asked::Shot(shot), true),
            Command::Upload(token, table) => {
                let context = self.machine.device().map(Context::of).unwrap_or_default();
                match upload::begin(&table, &context) {
                    Ok(begin) if self.machine.progress().is_none() => {
                        (self.table, self.uploaded) = (table, false);
                        (token, Asked::Message(HostMessage::RtUploadMoveBegin(begin)), true)
                    }
                    begin => {
                        let code = dmc_proto::message::AckCode::ERR_RANGE;
                        let busy = if begin.is_ok() { Failure::Busy } else { Failure::WouldBeRefused(code) };
                        return self.events.push_back(Event::Failed(token, busy));
                    }
                }
            }
        };
        if self.asked.contains_key(&token) || (is_sequence && self.check.is_some()) {
            return self.events.push_back(Event::Failed(token, Failure::Busy));
        }
        self.safety.asked(token, &asked.message());
        self.asked.insert(token, asked.clone());
        let message = asked.message();
        self.step(Input::Command(if is_sequence {
            host::Command::Sequence(token, message)
        } else {
            host::Command::Request(token, message)
        }));
    }
}

impl Party for DmcHost {
    fn open(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE {
            self.is_open = true;
            self.frames.reset();
            self.core.step(Input::LinkUp);
        }
    }

    fn close(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE && mem::take(&mut self.is_open) {
            self.gap = None;
            self.core.out.clear();
            self.core.step(Input::LinkDown);
        }
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        self.advance(now);
        if line != LINE || !self.is_open {
            return;
        }
        let mut rest = bytes;
        while !rest.is_empty() {
            let taken = self.frames.push(rest);
            rest = &rest[taken..];
            while let Some(item) = self.frames.next() {
                self.core.received(item);
            }
        }
        self.gap = (self.frames.held() > 0).then(|| now.after(GAP));
    }

    fn advance(&mut self, now: Millis) {
        while let Some(next) = self.wake().filter(|next| *next <= now) {
            self.core.clock = self.core.clock.max(next);
            if self.gap.is_some_and(|gap| gap <= next) {
                self.gap = None;
                self.frames.gap();
                while let Some(item) = self.frames.next() {
                    self.core.received(item);
                }
            }
            if self.core.wake.is_some_and(|wake| wake <= next) {
                self.core.step(Input::Wake);
            }
        }
        self.core.clock = self.core.clock.max(now);
    }

    fn wake(&self) -> Option<Millis> {
        [self.core.wake, self.gap].into_iter().flatten().min()
    }

    fn poll(&mut self) -> Option<Outgoing> {
        self.core.out.pop_front()
    }
}

impl Host for DmcHost {
    type Command = Command;
    type Event = Event;

    fn command(&mut self, now: Millis, command: Command) {
        self.advance(now);
        self.core.command(command);
    }

    fn next_event(&mut self) -> Option<Event> {
        self.core.events.pop_front()
    }
}
