//! Host without its line: the machine, and the messages and the move that the machine does not keep.

use std::collections::{BTreeMap, VecDeque};

use dmc_proto::host::{
    self, Effect, Failure, HostMachine, Input, Options, Outcome, Progress, Refusal, Source, StopTarget, Transmit,
};
use dmc_proto::lint::Context;
use dmc_proto::message::{
    AckCode, DeviceMessage, GioCam, HostMessage, MotorConfigure, MotorFlags, MotorGetPosition, MotorStatusRequest,
    RtUploadMoveBegin,
};
use dmc_proto::upload::{self, MoveSource as _, SCRATCH, Section, SectionSize};
use dmc_proto::{EncodeError, Frame, Header, Item, Token};
use motion_core::time::Millis;
use tracing::{debug, info, warn};

use super::check::Check;
use super::limits::Limits;
use super::uses::{Uses, Waiting, lacking};
use super::{Answer, Command, Event, LINE, Positions, Shot, Table};
use crate::Outgoing;

/// Least of the tokens that the host uses for its own commands.
const FIRST_OWN: Token = Token(u32::MAX - 4);
/// Token of commands that the application gives without a token, and of the end of the configuration.
const OWN: Token = FIRST_OWN;
/// Token of the request that sets the uses of a motor before a command moves it.
const USES: Token = Token(u32::MAX - 3);
/// Token of the request that closes the shutter.
const SHUTTER: Token = Token(u32::MAX - 2);
/// Token of the question for positions at the end of a way.
const CHECK: Token = Token(u32::MAX - 1);
/// Token of the question whether motors still move after a stop.
const REST: Token = Token(u32::MAX);

/// End of a request that the device does not know.
const UNSUPPORTED: Outcome<'static> = Outcome::Refused(Refusal::Device(AckCode::ERR_UNSUPPORTED));

/// Greatest number of questions after a stop whether motors still move.
const QUESTIONS: u8 = 20;

/// Host without its line.
#[derive(Debug)]
pub(super) struct Core {
    pub(super) clock: Millis,
    pub(super) machine: HostMachine,
    machine_wake: Option<Millis>,
    /// Messages of the commands that have not ended.
    asked: BTreeMap<Token, Asked>,
    /// Move of the last upload.
    table: Table,
    /// Whether the device has that move. Otherwise nobody knows the move of the device.
    is_uploaded: bool,
    /// Positions of the motors that the device told last.
    pub(super) positions: Option<Positions>,
    /// Uses of the motors on this link.
    uses: Uses,
    limits: Limits,
    /// Commands that wait until their motors have their uses.
    waiting: VecDeque<Waiting>,
    /// Way that has ended, and is not yet known to be complete.
    check: Option<Check>,
    /// Time of the next question after a stop whether motors still move, and number of questions that are left.
    rest: Option<(Millis, u8)>,
    /// Whether the shutter is to be closed after a stop.
    pub(super) closes: bool,
    pub(super) out: VecDeque<Outgoing>,
    pub(super) events: VecDeque<Event>,
}

/// Message of a command.
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

/// Command of the machine for a message.
const fn given(message: HostMessage<'_>, is_sequence: bool) -> host::Command<'_> {
    if is_sequence { host::Command::Sequence(message) } else { host::Command::Request(message) }
}

impl Core {
    pub(super) fn new(options: Options) -> Self {
        Self {
            clock: Millis(0),
            machine: HostMachine::new(options),
            machine_wake: None,
            asked: BTreeMap::new(),
            table: Table::default(),
            is_uploaded: false,
            positions: None,
            uses: Uses::new(),
            limits: Limits::default(),
            waiting: VecDeque::new(),
            check: None,
            rest: None,
            closes: false,
            out: VecDeque::new(),
            events: VecDeque::new(),
        }
    }

    /// Gives an input to the machine and carries out its effects. Inputs that follow from them come after the last effect.
    pub(super) fn step(&mut self, input: Input<'_>) {
        let output = self.machine.advance(self.clock, input);
        self.machine_wake = output.wake;
        let mut next = Vec::new();
        for effect in output {
            match effect {
                Effect::Transmit(transmit) => self.transmit(transmit),
                Effect::Event(event) => next.extend(self.told(event)),
            }
        }
        for input in next {
            self.step(input);
        }
        self.go_on();
    }

    fn transmit(&mut self, transmit: Transmit) {
        let (mut scratch, mut bytes) = ([0; SCRATCH], [0; 1048]);
        let encoded = transmit.encode_into(
            |source| match source {
                // The machine asks only for messages of commands that have not ended. A question would do no harm.
                Source::Command(token) => {
                    self.asked.get(&token).map_or(MotorStatusRequest::default().into(), Asked::message)
                }
                Source::Section(section) => section.message(&self.table, &mut scratch),
            },
            &mut bytes,
        );
        match encoded {
            Ok(len) => {
                let bytes = &bytes[..len];
                if let Ok(Ok(message)) = Frame::decode(bytes).map(|frame| HostMessage::decode(&frame)) {
                    debug!("sends {message}");
                } else {
                    debug!(len, "sends zero bytes, which complete a frame that was cut off");
                }
                self.out.push_back(Outgoing::Bytes(LINE, bytes.to_vec()));
            }
            Err(error) => warn!(%error, "a request that cannot be sent"),
        }
    }

    /// Takes an event of the machine. Returns the input that follows from it.
    fn told(&mut self, event: host::Event<'_>) -> Option<Input<'static>> {
        debug!(?event);
        let next = match event {
            host::Event::Ended { token, outcome } => return self.ended(token, outcome),
            host::Event::NextSection { after, .. } => {
                let (size, table) = (SectionSize::default(), &self.table);
                let section = after.map_or_else(|| Section::first(table, size), |section| section.next(table, size));
                return Some(Input::Section(section));
            }
            // Late answers are of no use, except positions and inputs.
            host::Event::Unsolicited(_, message) => {
                if let Answer::Inputs(inputs) = self.heard(&message) {
                    self.events.push_back(Event::Inputs(inputs));
                }
                return None;
            }
            // This host sets the uses of a motor only before it moves it.
            host::Event::Greeted(_) => {
                self.uses.clear();
                self.limits.clear();
                // A device that was switched on has no move.
                self.is_uploaded &= self.machine.is_loaded() != Some(false);
                Some(Input::Command(OWN, host::Command::Configured))
            }
            host::Event::LinkDown => {
                self.rest = None;
                None
            }
            host::Event::HardStop(..) => {
                self.end_waiting(Outcome::Failed(Failure::HardStop));
                self.closes |= self.machine.may_have_shutter_open();
                self.close_later();
                None
            }
            host::Event::Ready { .. } => {
                self.close_later();
                None
            }
            host::Event::Stopped(target) => {
                // The machine itself sends a silent stop after a run or shot that failed.
                self.closes |= target == StopTarget::AllSilent && self.machine.may_have_shutter_open();
                self.rest = Some((self.clock, QUESTIONS));
                None
            }
            _ => None,
        };
        self.events.extend(event.to_static().map(Event::Machine));
        next
    }

    /// Keeps what a message of the device says.
    fn heard(&mut self, message: &DeviceMessage<'_>) -> Answer {
        match message {
            DeviceMessage::MotorStatus(status) => Answer::Moving(status.motor_status),
            DeviceMessage::GioIn(inputs) => Answer::Inputs(inputs.triggers),
            DeviceMessage::MotorGetPosition(told) => {
                let positions = told.positions.iter().map(|steps| steps.get()).collect();
                let positions = Positions { moment: told.move_time, positions };
                self.positions = Some(positions.clone());
                self.events.push_back(Event::Positions(positions.clone()));
                Answer::Positions(positions)
            }
            _ => Answer::Done,
        }
    }

    /// Takes the end of a command. Returns the command that follows from it.
    fn ended(&mut self, token: Token, outcome: Outcome<'_>) -> Option<Input<'static>> {
        let asked = self.asked.remove(&token);
        let message = asked.as_ref().map(Asked::message);
        let end = match (outcome, message) {
            (Outcome::Done(Some(message)), _) => Ok(self.heard(&message)),
            // Some devices tell positions beside an acknowledgement.
            (Outcome::Done(None), Some(HostMessage::MotorGetPosition(_))) => {
                Ok(self.positions.clone().map_or(Answer::Done, Answer::Positions))
            }
            (Outcome::Done(None), _) => Ok(Answer::Done),
            (other, _) => Err(other.to_static().unwrap_or(Outcome::NotConfirmed)),
        };
        if let Some(HostMessage::MotorConfigure(set)) = message {
            // A device that does not know uses has all its motors in use.
            match end {
                Ok(_) | Err(UNSUPPORTED) => self.uses.insert(set.motor, set.flags),
                Err(_) => self.uses.remove(&set.motor),
            };
        }
        if let (Some(HostMessage::MotorSetLimits(set)), Ok(_)) = (&message, &end) {
            self.limits.set(set);
        }
        match (token, end) {
            (USES, Err(outcome)) if outcome != UNSUPPORTED => self.end_waiting(outcome),
            (CHECK, end) => self.checked(end.is_ok()),
            (OWN, Err(Outcome::Refused(refusal))) => self.events.push_back(Event::Refused(refusal)),
            // Events tell what comes of a command without a token, and the machine keeps what the others are for.
            (OWN | SHUTTER | REST | USES, _) => {}
            (_, Ok(answer)) => {
                let check = message.as_ref().and_then(|message| Check::of(token, message));
                if check.is_some() && self.is_uploaded {
                    self.check = check;
                    return Some(self.ask(CHECK, MotorGetPosition::default().into()));
                }
                if let Some(HostMessage::RtUploadMoveBegin(_)) = message {
                    self.is_uploaded = true;
                }
                self.events.push_back(Event::Ended(token, Ok(answer)));
            }
            (_, Err(outcome)) => self.events.push_back(Event::Ended(token, Err(outcome))),
        }
        None
    }

    /// Ends all commands that wait. Their messages were not sent.
    fn end_waiting(&mut self, outcome: Outcome<'static>) {
        for Waiting { token, .. } in std::mem::take(&mut self.waiting) {
            self.asked.remove(&token);
            self.events.push_back(Event::Ended(token, Err(outcome)));
        }
    }

    /// Sends the commands that wait, as far as their motors have their uses. Otherwise sets the uses of the next motor.
    fn go_on(&mut self) {
        while !self.asked.contains_key(&USES)
            && let Some(&Waiting { token, is_sequence }) = self.waiting.front()
        {
            let Some(asked) = self.asked.get(&token).cloned() else {
                self.waiting.pop_front();
                continue;
            };
            let message = asked.message();
            let count = self.machine.device().map_or(0, |device| device.motor_count.min(32));
            let table = self.is_uploaded.then_some(&self.table);
            let input = if let Some((motor, flags)) = lacking(&self.uses, &message, table, count) {
                let is_outside = table.is_some_and(|table| !table.motors().contains(motor));
                if !is_sequence && is_outside && self.runs() && !flags.contains(MotorFlags::LIVE) {
                    // If the motor were enabled, it would take part in the run.
                    self.waiting.pop_front();
                    self.asked.remove(&token);
                    self.refuse(token, Refusal::Busy);
                    continue;
                }
                self.ask(USES, MotorConfigure { motor, flags, tail: &[] }.into())
            } else {
                self.waiting.pop_front();
                Input::Command(token, given(message, is_sequence))
            };
            self.step(input);
        }
    }

    /// Whether motors move together, or may begin to.
    fn runs(&self) -> bool {
        self.machine.is_armed() || self.machine.progress().is_some_and(|progress| progress != Progress::Uploads)
    }

    /// A way has ended, and the positions of its motors are known, or cannot be known.
    fn checked(&mut self, is_known: bool) {
        if let Some(check) = self.check.take() {
            let holds = is_known && check.holds(self.positions.as_ref(), &self.table);
            let end = if holds { Ok(Answer::Done) } else { Err(Outcome::NotConfirmed) };
            self.events.push_back(Event::Ended(check.token, end));
        }
    }

    /// Command of the host itself that sends a request.
    fn ask(&mut self, token: Token, message: HostMessage<'static>) -> Input<'static> {
        self.asked.insert(token, Asked::Message(message));
        Input::Command(token, host::Command::Request(message))
    }

    /// Closes the shutter within some seconds, if it is to be closed.
    fn close_later(&mut self) {
        if self.closes {
            self.rest = Some((self.clock, QUESTIONS));
        }
    }

    /// Closes the shutter, if a stop left it open.
    fn close_shutter(&mut self) {
        self.closes &= self.machine.may_have_shutter_open();
        if !self.closes || self.asked.contains_key(&SHUTTER) {
            return;
        }
        let input = self.ask(SHUTTER, GioCam::default().into());
        self.step(input);
    }

    pub(super) fn received(&mut self, item: Item<'_, Frame<'_>, Header>) {
        match item {
            Item::Frame(frame) => {
                let input = Input::received(&frame);
                if let Input::Received(_, message) = &input {
                    debug!("receives {message}");
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

    /// Time when something is due.
    pub(super) fn wake(&self) -> Option<Millis> {
        [self.machine_wake, self.rest.map(|(due, _)| due)].into_iter().flatten().min()
    }

    /// Does what is due.
    pub(super) fn due(&mut self) {
        if self.machine_wake.is_some_and(|wake| wake <= self.clock) {
            self.step(Input::Wake);
        }
        let Some((_, left)) = self.rest.take_if(|(due, _)| *due <= self.clock) else { return };
        self.close_shutter();
        self.closes &= left > 0;
        if left > 0 && (self.machine.may_move() || self.closes) {
            self.rest = Some((self.clock.after(self.machine.options().request_timeout().into()), left - 1));
            if self.machine.may_move() && !self.asked.contains_key(&REST) {
                let question = self.ask(REST, MotorStatusRequest::default().into());
                self.step(question);
            }
        }
    }

    pub(super) fn command(&mut self, command: Command) {
        match command {
            Command::Greet => self.step(Input::Command(OWN, host::Command::Greet)),
            Command::Go => self.step(Input::Command(OWN, host::Command::Go)),
            Command::EndStops => {
                self.step(Input::Command(OWN, host::Command::EndStops));
                self.close_later();
            }
            Command::Stop(target) => {
                info!(?target, "stop");
                let was_open = self.machine.may_have_shutter_open();
                self.step(Input::Command(OWN, host::Command::Stop(target)));
                self.end_waiting(Outcome::Failed(Failure::Stopped));
                // A stop of one motor leaves a shutter open that a request opened.
                let is_all = matches!(target, StopTarget::All | StopTarget::AllSilent);
                self.closes |= self.machine.may_have_shutter_open() && (is_all || !was_open);
                self.close_shutter();
            }
            Command::Ask(token, message) => match self.limits.within(message, self.positions.as_ref()) {
                Ok(message) => self.submit(token, &Asked::Message(message), false),
                Err(code) => self.refuse(token, Refusal::WouldBeRefused(code)),
            },
            Command::Begin(token, message) => self.submit(token, &Asked::Message(message), true),
            Command::Shoot(token, shot) => self.submit(token, &Asked::Shot(shot), true),
            Command::Upload(token, table) => match self.fits(&table) {
                Ok(begin) if !self.is_busy(token, true) => {
                    (self.table, self.is_uploaded) = (table, false);
                    self.submit(token, &Asked::Message(begin.into()), true);
                }
                Ok(_) => self.refuse(token, Refusal::Busy),
                Err(_) => self.refuse(token, Refusal::WouldBeRefused(AckCode::ERR_RANGE)),
            },
        }
    }

    /// Whether a command cannot be taken: its token is in use, or a sequence, or the check at its end, runs.
    fn is_busy(&self, token: Token, is_sequence: bool) -> bool {
        let is_taken = token >= FIRST_OWN || self.asked.contains_key(&token);
        let waits = self.waiting.iter().any(|waiting| waiting.is_sequence);
        is_taken || (is_sequence && (waits || self.check.is_some() || self.machine.progress().is_some()))
    }

    fn submit(&mut self, token: Token, asked: &Asked, is_sequence: bool) {
        let message = asked.message();
        // The request that closes the shutter after a stop could end a new photo.
        let is_closing = self.closes || self.asked.contains_key(&SHUTTER);
        if self.is_busy(token, is_sequence) || (is_closing && message.opens_shutter()) {
            return self.refuse(token, Refusal::Busy);
        }
        self.asked.insert(token, asked.clone());
        if message.conduct().may_move() {
            self.waiting.push_back(Waiting { token, is_sequence });
            self.go_on();
        } else {
            self.step(Input::Command(token, given(message, is_sequence)));
        }
    }

    fn refuse(&mut self, token: Token, refusal: Refusal) {
        self.events.push_back(Event::Ended(token, Err(Outcome::Refused(refusal))));
    }

    /// Message that begins the upload of a move, if the device can take the move.
    pub(super) fn fits(&self, table: &Table) -> Result<RtUploadMoveBegin<'static>, EncodeError> {
        upload::begin(table, &self.machine.device().map(Context::of).unwrap_or_default())
    }
}
