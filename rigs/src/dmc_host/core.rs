//! The host behind its line: the machine, and what it only names.

use std::collections::{BTreeMap, VecDeque};

use dmc_proto::Item;
use dmc_proto::host::{self, Event as Told, Failure, HostMachine, Input, Name, Options, Outcome, Token};
use dmc_proto::lint::Context;
use dmc_proto::message::{AckCode, DeviceMessage, Empty, HostMessage, RtShootFrame, RtShootFrame2};
use dmc_proto::upload::{self, SCRATCH, Section, SectionSize};
use motion_core::machine::Machine;
use motion_core::time::Millis;
use tracing::{debug, info, warn};

use super::check::Check;
use super::safety::Safety;
use super::{Answer, Command, Event, LINE, Positions, Shot, Table};
use crate::Outgoing;

/// The tokens of what the host asks by itself.
pub(super) const SHUTTER: Token = Token(u32::MAX);
const CHECK: Token = Token(u32::MAX - 1);

/// The host behind its line.
#[derive(Debug)]
pub(super) struct Core {
    pub(super) clock: Millis,
    pub(super) machine: HostMachine,
    pub(super) wake: Option<Millis>,
    /// What was asked and has not ended.
    asked: BTreeMap<Token, Asked>,
    /// The move that is uploaded, and whether the device has it.
    table: Table,
    uploaded: bool,
    /// Where the motors were when they were told last.
    pub(super) positions: Option<Positions>,
    pub(super) safety: Safety,
    /// What is over, and not yet known to be done.
    check: Option<Check>,
    pub(super) out: VecDeque<Outgoing>,
    pub(super) events: VecDeque<Event>,
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

impl Core {
    pub(super) fn new(options: Options) -> Self {
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

    pub(super) fn step(&mut self, input: Input<'_>) {
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

    pub(super) fn received(&mut self, item: Item<'_, dmc_proto::Frame<'_>, dmc_proto::Header>) {
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

    pub(super) fn command(&mut self, command: Command) {
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
                        let code = AckCode::ERR_RANGE;
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
