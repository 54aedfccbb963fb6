//! Packets that arrive: the table of hoot, section 4.1, from the check of the break on. The rows before it are the framing
//! [`Strict`](crate::Strict).

use motion_core::time::Millis;

use super::request::{DEVICE_ID, Reaction, Request, Response};
use super::{DeviceMachine, Effects, Event, Ignored, Port, Quirks, command};
use crate::frame::{Address, Selector, Table};
use crate::message::ValueType;

/// Outcome of a request.
#[derive(Clone, Copy)]
pub(super) enum Outcome {
    /// The request is answered.
    Answered(Response),
    /// The request is refused; firmware answers OK after that (hoot, sections 2.1 and 2.3).
    RefusedThenOk,
    /// The request is done, without an answer.
    Silent,
    /// The node has no such command.
    Unknown,
}

impl Outcome {
    pub(super) const OK: Self = Self::Answered(Response::OK);
    pub(super) const ERROR: Self = Self::Answered(Response::ERROR);

    pub(super) const fn ok_if(done: bool) -> Self {
        if done { Self::OK } else { Self::ERROR }
    }
}

impl<const QUIRKS: bool> DeviceMachine<QUIRKS> {
    /// Acts on a request, and returns what is to be sent.
    pub(super) fn received(
        &mut self,
        now: Millis,
        output: &mut Effects,
        port: Port,
        to: Address,
        request: &Request,
    ) -> [Option<Reaction>; 2] {
        let Selector { table, command, .. } = request.selector;
        let why = if command == 0 && table != Table::Core {
            Ignored::Noop
        } else if to == Address::BROADCAST {
            if self.broadcast(now, output, request) {
                return [None; 2];
            }
            Ignored::Broadcast
        } else if to != self.address(port) {
            let mut ports = port.beyond().iter();
            return [ports.next(), ports.next()].map(|port| port.copied().map(Reaction::Forward));
        } else {
            let outcome = self.directed(now, output, request);
            match self.answers(now, request.selector, outcome) {
                Ok(answers) => return answers.map(|answer| answer.map(|answer| Reaction::Answer(port, answer))),
                Err(why) => why,
            }
        };
        output.transmit(Reaction::Ignore(port, to, why));
        [None; 2]
    }

    /// Answers of an outcome, or why there is none.
    fn answers(&self, now: Millis, selector: Selector, outcome: Outcome) -> Result<[Option<Response>; 2], Ignored> {
        let profile = self.options.profile();
        let twice = self.has_quirk(Quirks::ANSWERS_TWICE);
        let is_running = matches!((selector.sub_address, selector.command), (1..=3, command::MotorRunning));
        let second = match outcome {
            // The sheet's firmware does not end after this answer, and goes on into the next one.
            Outcome::Answered(answer)
                if twice && is_running && answer.has_value() && profile.answers_running_twice() != Some(false) =>
            {
                let next = Selector { command: command::MotorContinuousSpeed, ..selector };
                if let Outcome::Answered(answer) = self.value(now, next) { Some(answer) } else { None }
            }
            Outcome::RefusedThenOk if twice => Some(Response::OK),
            _ => None,
        };
        match outcome {
            Outcome::Answered(answer) => Ok([Some(answer), second]),
            Outcome::Unknown if profile.is_silent() == Some(true) => Err(Ignored::Unknown),
            Outcome::RefusedThenOk | Outcome::Unknown => Ok([Some(Response::ERROR), second]),
            Outcome::Silent => Err(Ignored::Silent),
        }
    }

    /// Carries out a broadcast and returns whether it exists. No broadcast is answered, and the sub-address says nothing.
    /// Source: hoot, section 2.5.
    fn broadcast(&mut self, now: Millis, output: &mut Effects, request: &Request) -> bool {
        let Selector { table, command, .. } = request.selector;
        match command {
            _ if table != Table::Broadcast => return false,
            command::BroadcastStart => self.start(now, output),
            command::BroadcastStop => self.stop(now, output),
            command::BroadcastPause => self.pause(now, output),
            command::BroadcastAssignAddress => return self.move_to(output, request.get()),
            _ => return false,
        }
        true
    }

    /// Takes another address, at all ports except USB. Returns whether a node can have it: firmware takes 0 and 1 too, and
    /// cannot be reached from then on (safety decision 5).
    pub(super) fn move_to(&mut self, output: &mut Effects, address: Address) -> bool {
        if address.is_node() {
            self.address = address;
            output.event(Event::Address(address));
        }
        address.is_node()
    }

    /// Carries out a request to this node.
    fn directed(&mut self, now: Millis, output: &mut Effects, request: &Request) -> Outcome {
        let Selector { table, command, sub_address } = request.selector;
        if table != Table::Node || command == 1 {
            return self.core(output, request);
        }
        // Whatever the request is, and even if it is refused, a master is there (hoot, section 4.1).
        self.heard_until = Some(now.after(u64::from(self.options.dead_man()).saturating_add(1)));
        if self.gate_refuses(request.selector) || sub_address > 4 {
            return Outcome::ERROR;
        }
        if command >= command::FIRST_QUERY {
            return self.ask(now, request.selector);
        }
        match sub_address {
            0 => self.set_controller(now, output, request),
            4 => self.set_camera(now, output, request),
            _ => self.set_motor(now, output, request),
        }
    }

    pub(super) fn reads_long_lead_in(&self) -> bool {
        self.options.profile().reads_long_lead_in() == Some(true)
    }

    /// Whether joystick mode refuses a command; a stop is carried out nevertheless (safety decision 2).
    pub(super) fn gate_refuses(&self, selector: Selector) -> bool {
        let is_stop = selector.sub_address == 0 && selector.command == 4;
        let is_open = is_stop && !self.has_quirk(Quirks::REFUSES_STOP);
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
    fn core(&mut self, output: &mut Effects, request: &Request) -> Outcome {
        let Selector { table, command, .. } = request.selector;
        let version = match command {
            _ if table != Table::Core => return Outcome::ERROR,
            command::CoreProtocolVersion => 1,
            command::CoreDeviceId => return Outcome::Answered(Response::text(DEVICE_ID.0)),
            command::CoreDeviceVersion => self.options.version().0,
            command::CoreAssignAddress => return Outcome::ok_if(self.move_to(output, request.get())),
            _ => return Outcome::ERROR,
        };
        Outcome::Answered(Response::number(ValueType::UINT, version))
    }
}
