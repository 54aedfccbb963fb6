//! Rules for messages of the master, with their sources.

use motion_core::lint::{Findings as _, Problem, Severity};
use motion_core::wire::{Bool, DecodeError, Messages, Other, trim_nuls};

use super::Rules;
use crate::frame::{Address, BREAK, Selector, Table};
use crate::message::{
    AnySubAddress, Direction, HostMessage, MAX_ARRIVING, Motor, MotorMove, Name, StartDelay, StepCount, StepRate,
    StepsPerSecond,
};
use crate::query::{DelayUnit, Profile};

/// Greatest step rate of any firmware, in steps per second.
const MAX_STEP_RATE: u16 = 10_000;
/// Step rates that firmware accepts.
const STEP_RATES: [u16; 5] = [1000, 2000, 4000, 5000, MAX_STEP_RATE];

impl Rules<'_> {
    /// Section 4.1; safety decision 2: a stop is never refused, whatever firmware does.
    pub(super) fn joystick(&mut self, selector: Selector) {
        if !self.context.joystick {
            return;
        }
        let is_stop = selector == Selector { table: Table::Node, command: 4, sub_address: 0 };
        match self.context.profile.refuses_in_joystick_mode(selector) {
            Some(false) => {}
            Some(true) if !is_stop => self.error("command", "refused in joystick mode"),
            _ => self.warning("command", "some firmware refuses it in joystick mode"),
        }
    }

    /// Section 3: the sheet demands a stop before other commands. No firmware does, so this is only a warning.
    pub(super) fn running(&mut self, Selector { table, command, sub_address }: Selector) {
        let sets = match sub_address {
            0 => !matches!(command, 0..=4 | 23),
            1..=3 => !matches!(command, 0 | 1 | 4),
            _ => command > 1,
        };
        if self.context.running && table == Table::Node && sets && command < 100 {
            self.warning("command", "the planned move runs; the sheet asks for a stop first");
        }
    }

    /// Section 1.1: command 0.
    pub(super) fn noop(&mut self) {
        self.warning("command", "nodes do not answer command 0, and bridges do not forward it");
    }

    /// Section 7: commands that some firmware does not have.
    pub(super) fn has(&mut self, has: Option<bool>) {
        if has == Some(false) {
            self.warning("command", "this firmware does not have the command: it refuses it, or does not answer");
        }
    }

    /// Decision H-42: commands that send a motor to a position. Of firmware of which nothing is known, nothing is said.
    pub(super) fn sends(&mut self, at_full_speed: Option<bool>) {
        if at_full_speed != Some(false) && self.context.profile != Profile::UNKNOWN {
            self.warning("motor", "firmware since 2014-11-03 goes at full speed, and forgets the speed that was set");
        }
    }

    /// Decision H-44: end limits.
    pub(super) fn limits(&mut self, holds: Option<bool>) {
        if holds == Some(false) {
            self.warning("motor", "this firmware keeps the end limit and does not stop there");
        }
    }

    /// Section 7: commands 25 and 26 of a motor.
    pub(super) fn step(&mut self, has: Option<bool>) {
        if has == Some(false) {
            self.error("command", "later firmware does not have steps: 25 sets the lead-out");
        }
    }

    /// Section 7: number of bytes of the lead-in.
    pub(super) fn width(&mut self, is_right: Option<bool>) {
        if is_right == Some(false) {
            self.error("lead_in", "this firmware reads another number of bytes");
        }
    }

    /// Safety decision 3.
    pub(super) fn arrives(&mut self, what: &'static str, number: u32) {
        self.found.range(what, number, 0, MAX_ARRIVING);
    }

    /// Section 2.1: firmware multiplies seconds by 1000, in 32 bits.
    pub(super) fn delay_in_seconds(&mut self, delay: StartDelay) {
        if delay.0.checked_mul(1000).is_none() {
            let severity = match self.context.profile.start_delay() {
                Some(DelayUnit::Seconds) => Severity::Error,
                _ => Severity::Warning,
            };
            self.found.note(severity, "start_delay", "in seconds, it does not fit into 32 bits of milliseconds");
        }
    }

    /// Every number except 0 means yes.
    pub(super) fn yes_or_no(&mut self, what: &'static str, answer: Bool) {
        if answer.0 > 1 {
            self.warning(what, "neither 0 nor 1");
        }
    }

    /// Section 2: values that firmware acknowledges and ignores.
    pub(super) fn ignored(&mut self, what: &'static str, name: Option<&'static str>) {
        if name.is_none() {
            self.warning(what, "the node acknowledges and ignores it");
        }
    }

    /// Section 2.1, command 11.
    pub(super) fn max_step_rate(&mut self, rate: StepRate) {
        self.ignored("max_step_rate", STEP_RATES.contains(&rate.0).then_some(""));
    }

    /// Section 2.3, command 7.
    pub(super) fn max_step_speed(&mut self, speed: StepRate) {
        self.ignored("max_step_speed", (1..=MAX_STEP_RATE).contains(&speed.0).then_some(""));
    }

    /// Section 1: a reader that searches for the next break would find this one.
    fn no_break(&mut self, what: &'static str, data: &[u8]) {
        if data.windows(BREAK.len()).any(|window| window == BREAK) {
            self.error(what, "contains a break, the start of a packet");
        }
    }

    /// Section 1.2.
    pub(super) fn name(&mut self, name: &Name) {
        self.no_break("name", name.as_bytes());
        if trim_nuls(name.as_bytes()).contains(&0) {
            self.warning("name", "the node keeps NULs inside, and many readers stop there");
        }
    }

    /// Safety decision 5.
    pub(super) fn new_address(&mut self, address: Address) {
        self.found.range("new_address", address.0, 2, u8::MAX);
    }

    pub(super) fn direction(&mut self, direction: Direction) {
        let (value, min, max) = (direction.0.into(), 0, 1);
        if value > max {
            self.found.push(Severity::Warning, "direction", Problem::Range { value, min, max });
        }
    }

    /// Safety decision 3.
    pub(super) fn motion(&mut self, message: MotorMove) {
        self.direction(message.direction);
        self.found.range("steps", message.steps.0, 1_u8, StepCount::MAX.0);
        self.still(message.motor);
    }

    /// Safety decision 8.
    pub(super) fn still(&mut self, motor: Motor) {
        if self.context.is_still(motor) {
            self.warning("motor", "nothing moves, because the continuous speed of the motor is 0");
        }
    }

    /// Section 2.3, command 13.
    pub(super) fn speed(&mut self, StepsPerSecond(speed): StepsPerSecond) {
        self.found.finite("speed", speed);
        if speed.is_finite() && !(-f32::from(MAX_STEP_RATE)..=f32::from(MAX_STEP_RATE)).contains(&speed) {
            self.warning("speed", "above the step rate of any firmware, which acknowledges and ignores it");
        }
    }

    /// Section 2.5; safety decision 4.
    pub(super) fn broadcast(&mut self, sub_address: AnySubAddress) {
        self.bridge();
        if sub_address.0 != 0 {
            self.warning("sub_address", "nodes ignore the sub-address of broadcasts");
        }
    }

    pub(super) fn bridge(&mut self) {
        if self.context.bridge {
            self.error("address", "a bridge does not forward broadcasts: address each node, with stops first");
        }
    }

    /// Behaviour of firmware: sections 1 and 2.5, and section 1.1 for a known command with data of another length.
    pub(super) fn other(&mut self, other: &Other<'_>) {
        let data = other.payload();
        self.length(data);
        self.no_break("data", data);
        let (Selector { table, command, .. }, _) = Selector::from_number(other.id()).split(data);
        if table == Table::Broadcast {
            self.bridge();
        }
        if table == Table::Node && command == 0 {
            self.noop();
        }
        match HostMessage::decode_body(other.id(), data) {
            Ok(_) if table == Table::Node && command == 1 => {
                self.error("data", "the data must begin with a command of the core protocol");
            }
            Ok(_) => {}
            Err(DecodeError::Truncated { .. }) => {
                self.error("data", "too short: the node reads missing bytes as zero");
            }
            Err(_) => self.warning("data", "longer than the data of the command: the node ignores the rest"),
        }
    }
}
