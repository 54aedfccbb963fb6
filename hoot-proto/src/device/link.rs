//! What becomes of a packet. The table of hoot, section 4.1, from the check of the break on; what stands before it is
//! the framing [`Strict`](crate::Strict).

use motion_core::time::Millis;
use motion_core::wire::{Bool, Messages};

use super::{Answer, DeviceMachine, Event, Forward, Ignored, Output, Port, Send};
use crate::frame::{Address, MAX_DATA, Selector, Table};
use crate::message::{CoreVersion, HostMessage, MotorContinuousSpeed, Text};
use crate::query::{AnyQuery, AnyReply, Gate};

/// How long a node blinks, and hears nothing, after its address has changed. Source: hoot, section 2.5.
const DEAF: u64 = 2500;

/// What became of a request.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    /// It is answered.
    Answered(Answer),
    /// It is refused; firmware says OK behind that (hoot, sections 2.1 and 2.3).
    RefusedThenOk,
    /// It is done, without a word.
    Silent,
    /// There is no such command.
    Unknown,
}

impl Outcome {
    pub(super) const OK: Self = Self::Answered(Answer::Ok);
    pub(super) const ERROR: Self = Self::Answered(Answer::Error);

    pub(super) const fn ok_if(done: bool) -> Self {
        if done { Self::OK } else { Self::ERROR }
    }
}

impl DeviceMachine {
    pub(super) fn received(
        &mut self,
        now: Millis,
        output: &mut Output,
        port: Port,
        to: Address,
        message: &HostMessage<'_>,
    ) {
        let selector = message.selector();
        if self.deaf_until.is_some() {
            output.event(Event::Ignored(Ignored::Deaf));
        } else if selector.command == 0 && selector.table != Table::Core {
            output.event(Event::Ignored(Ignored::Noop));
        } else if to == Address::BROADCAST {
            self.broadcast(now, output, message);
        } else if to != self.address(port) {
            output.event(Event::Forward(Forward { from: port, to }));
        } else {
            let outcome = self.directed(now, output, selector, message);
            self.answer(now, output, port, message, outcome);
        }
    }

    /// Sends what an outcome is answered with.
    fn answer(&self, now: Millis, output: &mut Output, port: Port, message: &HostMessage<'_>, outcome: Outcome) {
        let mut send = |answer| output.send(Send { port, answer });
        let twice = self.options.quirks.answers_twice;
        match outcome {
            Outcome::Answered(answer) => {
                send(answer);
                let twice = twice && self.options.profile.facts().answers_running_twice;
                if let (Answer::Value(_), HostMessage::MotorRunning(query), true) = (answer, message, twice) {
                    // The sheet's firmware has no end behind this answer, and goes on into the next one.
                    let next = AnyQuery::MotorContinuousSpeed(MotorContinuousSpeed { motor: query.motor });
                    if let Outcome::Answered(answer) = self.value(now, next) {
                        send(answer);
                    }
                }
            }
            Outcome::RefusedThenOk => {
                send(Answer::Error);
                if twice {
                    send(Answer::Ok);
                }
            }
            Outcome::Unknown if self.options.profile.facts().is_silent == Some(true) => {
                output.event(Event::Ignored(Ignored::Unknown));
            }
            Outcome::Unknown => send(Answer::Error),
            Outcome::Silent => output.event(Event::Ignored(Ignored::Silent)),
        }
    }

    /// The table of broadcasts: none is answered, and the sub-address says nothing. Source: hoot, section 2.5.
    fn broadcast(&mut self, now: Millis, output: &mut Output, message: &HostMessage<'_>) {
        let mut buffer = [0; MAX_DATA];
        let (message, _) = complete(message, &mut buffer);
        match message {
            HostMessage::BroadcastStart(_) => self.start(now, output),
            HostMessage::BroadcastStop(_) => self.stop(output),
            HostMessage::BroadcastPause(_) => self.pause(now, output),
            HostMessage::BroadcastAssignAddress(assign) if assign.new_address.is_node() => {
                self.move_to(now, output, assign.new_address);
            }
            _ => output.event(Event::Ignored(Ignored::Broadcast)),
        }
    }

    /// Takes another address, at all ports but USB.
    pub(super) fn move_to(&mut self, now: Millis, output: &mut Output, address: Address) {
        self.address = address;
        output.event(Event::Address(address));
        if self.options.quirks.is_deaf {
            self.deaf_until = Some(now.after(DEAF));
        }
    }

    fn directed(&mut self, now: Millis, output: &mut Output, selector: Selector, message: &HostMessage<'_>) -> Outcome {
        let mut buffer = [0; MAX_DATA];
        let (message, is_short) = complete(message, &mut buffer);
        if selector.table != Table::Node || selector.command == 1 {
            return self.core(now, output, &message);
        }
        // Whatever it is, and even if it is refused: somebody is there (hoot, section 4.1).
        self.heard_until = Some(now.after(u64::from(self.options.dead_man).saturating_add(1)));
        if self.gate_refuses(selector) || selector.sub_address > 4 {
            return Outcome::ERROR;
        }
        let is_motion = matches!(message, HostMessage::MotorMove(_) | HostMessage::MotorRun(_));
        if is_motion && is_short && !self.options.quirks.short_moves {
            return Outcome::ERROR;
        }
        if let Some(query) = message.query() {
            return self.ask(now, query);
        }
        match selector.sub_address {
            0 => self.set_controller(now, output, &message),
            4 => self.set_camera(now, output, &message),
            _ => self.set_motor(now, output, &message),
        }
    }

    /// Whether joystick mode leaves no room for it; a stop is taken all the same (safety decision 2).
    fn gate_refuses(&self, selector: Selector) -> bool {
        let is_stop = selector.sub_address == 0 && selector.command == 4;
        let gate = self.options.profile.facts().gate.unwrap_or(Gate::Sheet);
        let is_open = is_stop && !self.options.quirks.refuses_stop;
        self.controller.joystick_mode && gate.refuses(selector) && !is_open
    }

    /// Whether the firmware says nothing to the speed of runs, since a joystick does not listen (hoot, section 7).
    pub(super) fn is_silent_at_speed(&self) -> bool {
        self.controller.joystick_mode && self.options.profile.facts().gate == Some(Gate::Later)
    }

    /// The core protocol, which no joystick gate and no dead-man clock knows of. Source: hoot, section 1.
    fn core(&mut self, now: Millis, output: &mut Output, message: &HostMessage<'_>) -> Outcome {
        let profile = self.options.profile;
        let value = match message {
            HostMessage::CoreProtocolVersion(query) => {
                AnyReply::CoreProtocolVersion(query.answer(CoreVersion(1), profile))
            }
            HostMessage::CoreDeviceId(query) => AnyReply::CoreDeviceId(query.answer(Text(b"OMAXISVX"), profile)),
            HostMessage::CoreDeviceVersion(query) => {
                let version = u16::try_from(self.options.version().0).unwrap_or(u16::MAX);
                AnyReply::CoreDeviceVersion(query.answer(CoreVersion(version), profile))
            }
            HostMessage::CoreAssignAddress(assign) => {
                // Firmware takes 0 and 1 too, and cannot be reached any more (safety decision 5).
                let is_node = assign.new_address.is_node();
                if is_node {
                    self.move_to(now, output, assign.new_address);
                }
                return Outcome::ok_if(is_node);
            }
            _ => return Outcome::ERROR,
        };
        Outcome::Answered(Answer::Value(value))
    }
}

/// A command with data of another length, as firmware reads it: surplus bytes are left out, missing ones are zero. Says
/// whether there were any missing. Source: hoot, section 1.1.
fn complete<'b>(message: &HostMessage<'_>, buffer: &'b mut [u8; MAX_DATA]) -> (HostMessage<'b>, bool) {
    // What is no `Other` owns what it says; in bytes it is the same, so this is only a change of lifetime.
    let number = message.number();
    let have = match message {
        HostMessage::Other(other) => {
            let len = other.payload().len().min(MAX_DATA);
            for (place, byte) in buffer.iter_mut().zip(other.payload()) {
                *place = *byte;
            }
            len
        }
        typed => typed.encode_body(buffer).unwrap_or(0),
    };
    let buffer: &'b [u8; MAX_DATA] = buffer;
    let read = |len: usize| HostMessage::decode_body(number, buffer.get(..len)?).ok();
    let is_known = |message: &HostMessage<'_>| !matches!(message, HostMessage::Other(_));
    let shorter = (0..=have).rev().find_map(read).filter(is_known);
    let longer = || (have..=MAX_DATA).find_map(read).filter(is_known);
    match shorter {
        Some(message) => (message, false),
        None => longer().map_or_else(
            || (HostMessage::other(number, buffer.get(..have).unwrap_or_default()), false),
            |message| (message, true),
        ),
    }
}

/// A yes or no, as queries answer it.
pub(super) fn yes(answer: bool) -> Bool {
    answer.into()
}
