//! The emergency stop: safety decision 2.
//!
//! A round sends a stop to each motor of each listed node and then to its controller, on a bus without a bridge behind a
//! broadcast (decision H-21), and then asks each motor whether it moves. Only a round in which each question was answered
//! by a no ends it: after a silence, a late answer could be taken for that of another motor.
//!
//! The sheet's firmware refuses these questions in joystick mode. So from the second round on each node is taken out of
//! it (decision H-26).

use motion_core::time::Millis;
use motion_core::wire::Bool;

use super::line::{Job, Line};
use super::{Dropped, Event, HostMachine, Nodes, Output, Request, Send, State};
use crate::frame::Address;
use crate::message::{
    AnySubAddress, BroadcastStop, HostMessage, Motor, MotorRunning, MotorStop, Reply, SetJoystickMode, Stop,
};
use crate::query::Query;
use crate::state::states;

states! {
    /// How far an emergency stop is.
    pub enum StopState {
        /// There is none.
        #[default]
        Calm,
        /// Stops are being sent.
        Stopping,
        /// Motors are being asked whether they move.
        Asking,
    }
}

/// Rounds after which the application is told that the stop is not confirmed.
const ROUNDS: u8 = 3;

/// An emergency stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Emergency {
    /// Rounds that are over, up to [`ROUNDS`].
    rounds: u8,
    /// The next packet of this round.
    step: usize,
    /// Whether the application was told that it is not confirmed.
    is_told: bool,
}

/// A packet of a round: first what stops, then, from the second round on, what ends joystick mode, then the questions.
///
/// Without a known node there is nothing better than a broadcast, bridge or not.
fn packet(nodes: &Nodes, bridge: bool, Emergency { rounds, step, .. }: Emergency) -> Option<Send> {
    let nodes = nodes.as_slice();
    let sub_address = AnySubAddress(0);
    let everybody = Send { to: Address::BROADCAST, message: HostMessage::BroadcastStop(BroadcastStop { sub_address }) };
    let broadcast = (!bridge || nodes.is_empty()).then_some(everybody);
    let stops = nodes.iter().flat_map(|&to| {
        let motors = Motor::ALL.map(|motor| HostMessage::MotorStop(MotorStop { motor }));
        motors.into_iter().chain([HostMessage::Stop(Stop {})]).map(move |message| Send { to, message })
    });
    let leave = HostMessage::SetJoystickMode(SetJoystickMode { joystick_mode: Bool::FALSE });
    let leaving = nodes.iter().filter(|_| rounds > 0).map(|&to| Send { to, message: leave });
    let questions = nodes.iter().flat_map(|&to| {
        Motor::ALL.map(|motor| Send { to, message: HostMessage::MotorRunning(MotorRunning { motor }) })
    });
    broadcast.into_iter().chain(stops).chain(leaving).chain(questions).nth(step)
}

impl HostMachine {
    /// How far an emergency stop is.
    #[must_use]
    pub fn stopping(&self) -> StopState {
        match self.next_packet() {
            _ if self.emergency.is_none() => StopState::Calm,
            Some(send) if send.message.query().is_none() => StopState::Stopping,
            _ => StopState::Asking,
        }
    }

    /// Drops everything, and begins to stop everything. Pressed again while motors are asked, it begins a new round;
    /// while stops are being sent it changes nothing, or the last nodes would never be reached.
    pub(super) fn emergency_stop(&mut self, output: &mut Output) {
        output.event(Event::Stopping);
        match self.stopping() {
            StopState::Calm => {
                self.drop_all(output, Dropped::Emergency);
                self.emergency = Some(Emergency::default());
                if self.line == Line::Offline {
                    self.tell_not_confirmed(output);
                }
            }
            StopState::Stopping => {}
            StopState::Asking => self.new_round(output),
        }
    }

    /// Ends all requests, whatever they wait for. The line is free for stops after the gap.
    pub(super) fn drop_all(&mut self, output: &mut Output, why: Dropped) {
        if let Line::Waiting(waiting) = self.line {
            if let Job::Request(Request { token, .. }) = waiting.job {
                output.event(Event::dropped(token, why, true));
            } else if let Job::Stop(stop) = waiting.job {
                self.stops.put_back(stop);
            }
        }
        if self.line != Line::Offline {
            self.line = Line::Idle;
        }
        self.stops.drop_all(output, why);
        for request in core::mem::take(&mut self.queue) {
            output.event(Event::dropped(request.token, why, false));
        }
        self.speeds.clear();
        self.kept.clear();
    }

    fn tell_not_confirmed(&mut self, output: &mut Output) {
        if let Some(emergency) = self.emergency.as_mut().filter(|emergency| !emergency.is_told) {
            emergency.is_told = true;
            output.event(Event::StopNotConfirmed { node: None });
        }
    }

    fn new_round(&mut self, output: &mut Output) {
        if self.line != Line::Offline {
            self.line = Line::Idle;
        }
        let Some(emergency) = &mut self.emergency else { return };
        emergency.step = 0;
        emergency.rounds = emergency.rounds.saturating_add(1).min(ROUNDS);
        if emergency.rounds == ROUNDS {
            self.tell_not_confirmed(output);
        }
    }

    /// The line has gone: nothing is known of the rig any more.
    pub(super) fn emergency_without_line(&mut self, output: &mut Output) {
        if let Some(emergency) = &mut self.emergency {
            emergency.step = 0;
        }
        self.tell_not_confirmed(output);
    }

    /// The next packet of an emergency stop. Without one the round is over, and so is the emergency.
    pub(super) fn send_emergency(&mut self, now: Millis, output: &mut Output) {
        // Where nobody can be asked, the rounds go on.
        if self.options.nodes.as_slice().is_empty() && self.next_packet().is_none() {
            self.new_round(output);
        }
        if let Some(send) = self.next_packet() {
            self.send(now, output, Job::Emergency(send));
            if self.line.state() == State::Quiet {
                self.next_step();
            }
        } else {
            self.emergency = None;
            output.event(Event::StopConfirmed);
        }
    }

    fn next_packet(&self) -> Option<Send> {
        self.emergency.and_then(|emergency| packet(&self.options.nodes, self.options.bridge, emergency))
    }

    fn next_step(&mut self) {
        if let Some(emergency) = &mut self.emergency {
            emergency.step = emergency.step.saturating_add(1);
        }
    }

    /// A packet of an emergency stop has its answer, or none.
    pub(super) fn emergency_ended(&mut self, now: Millis, output: &mut Output, send: &Send, answer: Option<Reply<'_>>) {
        let HostMessage::MotorRunning(query) = send.message else {
            self.next_step();
            // Stops follow each other as quickly as they may; the first question comes when all answers are in.
            self.line = match self.stopping() {
                StopState::Asking => Line::Settling(now.after(self.options.drain.into())),
                _ => Line::Idle,
            };
            return;
        };
        let rests = answer.and_then(|reply| query.decode_reply(reply).ok()).is_some_and(|answer| !answer.value.get());
        if rests { self.next_step() } else { self.new_round(output) }
    }

    /// The application gives up.
    pub(super) fn end_emergency(&mut self, now: Millis, output: &mut Output) {
        if self.emergency.take().is_some() {
            if self.line != Line::Offline {
                self.line = Line::Settling(now.after(self.options.drain.into()));
            }
            output.event(Event::EmergencyEnded);
        }
    }
}
