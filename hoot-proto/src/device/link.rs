//! Packets that arrive: the table of hoot, section 4.1, from the check of the break on. The rows before it are the framing
//! [`Strict`](crate::Strict).

use arrayvec::ArrayVec;
use motion_core::time::Millis;
use motion_core::wire::{Bool, Message, Messages};

use super::input::read;
use super::{Answer, Contents, DeviceMachine, Event, Ignored, Output, Port, Quirks, Transmit};
use crate::frame::{Address, MAX_DATA, Selector, Table};
use crate::message::{CoreVersion, HostMessage, Motor, MotorContinuousSpeed, Text};
use crate::query::{AnyQuery, AnyReply};

/// Outcome of a request.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    /// The request is answered.
    Answered(Answer),
    /// The request is refused; firmware answers OK after that (hoot, sections 2.1 and 2.3).
    RefusedThenOk,
    /// The request is done, without an answer.
    Silent,
    /// The node has no such command.
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
    /// Acts on a packet and returns the packets to send.
    pub(super) fn received<'a>(
        &mut self,
        now: Millis,
        output: &mut Output<'a>,
        port: Port,
        to: Address,
        message: HostMessage<'a>,
    ) -> ArrayVec<Transmit<'a>, 2> {
        let selector = message.selector();
        let why = if selector.command == 0 && selector.table != Table::Core {
            Ignored::Noop
        } else if to == Address::BROADCAST {
            if self.broadcast(now, output, &message) {
                return ArrayVec::new();
            }
            Ignored::Broadcast
        } else if to != self.address(port) {
            let forward = |port: &Port| Transmit { port: *port, contents: Contents::Forward { to, message } };
            return port.beyond().iter().map(forward).take(2).collect();
        } else {
            let outcome = self.directed(now, output, selector, &message);
            match self.answers(now, &message, outcome) {
                Ok(answers) => {
                    let answers = answers.into_iter().flatten();
                    return answers.map(|answer| Transmit { port, contents: Contents::Answer(answer) }).collect();
                }
                Err(why) => why,
            }
        };
        output.event(Event::Ignored { port, to, message, why });
        ArrayVec::new()
    }

    /// Answers of an outcome, or why there is none.
    fn answers(
        &self,
        now: Millis,
        message: &HostMessage<'_>,
        outcome: Outcome,
    ) -> Result<[Option<Answer>; 2], Ignored> {
        let profile = self.options.profile();
        let twice = self.options.quirks().contains(Quirks::ANSWERS_TWICE);
        let second = match (outcome, message) {
            // The sheet's firmware does not end after this answer, and goes on into the next one.
            (Outcome::Answered(Answer::Value(AnyReply::MotorRunning(_))), message)
                if twice && profile.answers_running_twice() != Some(false) =>
            {
                let motor = Motor::new(message.selector().sub_address).unwrap_or_default();
                let next = AnyQuery::MotorContinuousSpeed(MotorContinuousSpeed { motor });
                if let Outcome::Answered(answer) = self.value(now, next) { Some(answer) } else { None }
            }
            (Outcome::RefusedThenOk, _) if twice => Some(Answer::Ok),
            _ => None,
        };
        match outcome {
            Outcome::Answered(answer) => Ok([Some(answer), second]),
            Outcome::Unknown if profile.is_silent() == Some(true) => Err(Ignored::Unknown),
            Outcome::RefusedThenOk | Outcome::Unknown => Ok([Some(Answer::Error), second]),
            Outcome::Silent => Err(Ignored::Silent),
        }
    }

    /// Carries out a broadcast and returns whether it exists. No broadcast is answered, and the sub-address says nothing.
    /// Source: hoot, section 2.5.
    fn broadcast(&mut self, now: Millis, output: &mut Output<'_>, message: &HostMessage<'_>) -> bool {
        let mut buffer = [0; MAX_DATA];
        let (message, _) = complete(message, &mut buffer, self.reads_long_lead_in());
        match message {
            HostMessage::BroadcastStart(_) => self.start(now, output),
            HostMessage::BroadcastStop(_) => self.stop(now, output),
            HostMessage::BroadcastPause(_) => self.pause(now, output),
            HostMessage::BroadcastAssignAddress(assign) if assign.new_address.is_node() => {
                self.move_to(output, assign.new_address);
            }
            _ => return false,
        }
        true
    }

    /// Takes another address, at all ports except USB.
    pub(super) fn move_to(&mut self, output: &mut Output<'_>, address: Address) {
        self.address = address;
        output.event(Event::Address(address));
    }

    /// Carries out a request to this node.
    fn directed(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        selector: Selector,
        message: &HostMessage<'_>,
    ) -> Outcome {
        let mut buffer = [0; MAX_DATA];
        let (message, is_short) = complete(message, &mut buffer, self.reads_long_lead_in());
        if selector.table != Table::Node || selector.command == 1 {
            return self.core(output, &message);
        }
        // Whatever the request is, and even if it is refused, a master is there (hoot, section 4.1).
        self.heard_until = Some(now.after(u64::from(self.options.dead_man()).saturating_add(1)));
        if self.gate_refuses(selector) || selector.sub_address > 4 {
            return Outcome::ERROR;
        }
        let is_motion = matches!(message, HostMessage::MotorMove(_) | HostMessage::MotorRun(_));
        if is_motion && is_short && !self.options.quirks().contains(Quirks::SHORT_MOVES) {
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

    fn reads_long_lead_in(&self) -> bool {
        self.options.profile().reads_long_lead_in() == Some(true)
    }

    /// Whether joystick mode refuses a command; a stop is carried out nevertheless (safety decision 2).
    pub(super) fn gate_refuses(&self, selector: Selector) -> bool {
        let is_stop = selector.sub_address == 0 && selector.command == 4;
        let is_open = is_stop && !self.options.quirks().contains(Quirks::REFUSES_STOP);
        self.controller.joystick_mode
            && self.options.profile().refuses_in_joystick_mode(selector) == Some(true)
            && !is_open
    }

    /// Whether the firmware does not answer the speed of runs, because a joystick does not listen (hoot, section 7).
    pub(super) fn is_silent_at_speed(&self) -> bool {
        self.controller.joystick_mode && self.options.profile().is_silent_at_speed() == Some(true)
    }

    /// Carries out a request of the core protocol, to which neither joystick mode nor the dead-man applies. Source: hoot,
    /// section 1.
    fn core(&mut self, output: &mut Output<'_>, message: &HostMessage<'_>) -> Outcome {
        let profile = self.options.profile();
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
                // Firmware takes 0 and 1 too, and cannot be reached from then on (safety decision 5).
                let is_node = assign.new_address.is_node();
                if is_node {
                    self.move_to(output, assign.new_address);
                }
                return Outcome::ok_if(is_node);
            }
            _ => return Outcome::ERROR,
        };
        Outcome::Answered(Answer::Value(value))
    }
}

/// A command with data of another length, as firmware reads it: surplus bytes are left out, missing bytes are zero. The
/// result says whether bytes were missing. Source: hoot, section 1.1.
fn complete<'b>(
    message: &HostMessage<'b>,
    buffer: &'b mut [u8; MAX_DATA],
    reads_long_lead_in: bool,
) -> (HostMessage<'b>, bool) {
    // The lead-in has two lengths, and each firmware reads one of them.
    let is_read = |message: &HostMessage<'_>| match message {
        HostMessage::MotorSetLeadIn(_) => !reads_long_lead_in,
        HostMessage::MotorSetLeadInLong(_) => reads_long_lead_in,
        message => !matches!(message, HostMessage::Other(_)),
    };
    if is_read(message) {
        return (*message, false);
    }
    let have = match message {
        HostMessage::MotorSetLeadIn(lead_in) => lead_in.encode_into(buffer).unwrap_or(0),
        HostMessage::MotorSetLeadInLong(lead_in) => lead_in.encode_into(buffer).unwrap_or(0),
        HostMessage::Other(other) => {
            for (place, byte) in buffer.iter_mut().zip(other.payload()) {
                *place = *byte;
            }
            other.payload().len().min(MAX_DATA)
        }
        _ => 0,
    };
    let (number, buffer) = (message.number(), &*buffer);
    // First without surplus bytes, from the longest on, and then with more and more zeros.
    for len in (0..=have).rev().chain(have.saturating_add(1)..=MAX_DATA) {
        if let Some(message) = buffer.get(..len).and_then(|data| read(number, data)).filter(is_read) {
            return (message, len > have);
        }
    }
    (HostMessage::other(number, buffer.get(..have).unwrap_or_default()), false)
}

/// A yes or a no, as queries answer it.
pub(super) fn yes(answer: bool) -> Bool {
    answer.into()
}
