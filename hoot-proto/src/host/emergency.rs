//! The emergency stop: safety decision 2.
//!
//! A round sends a stop to each motor of each listed node and then to its controller; on a bus without a bridge, a broadcast
//! goes first (decision H-21). Then the round asks each motor whether it moves. An emergency stop ends only with a round in
//! which each question was answered by a no: after a silence, a late answer could be taken for that of another motor. A
//! program moves motors again that rest. So if a program may run, each stop of that round was answered by an OK too
//! (decision H-32).
//!
//! A node that may be deaf is sent one stop only. The round is then not whole, and another one follows (decision H-41). No
//! stop is repeated within the time to wait for an answer.
//!
//! The firmware of the published sheet refuses these questions in joystick mode. So from the second round on, each node is
//! told to leave it (decision H-26).

use motion_core::states;
use motion_core::time::Millis;

use super::event::{Event, Failure, Outcome, StopTarget};
use super::jobs::{Job, Pending};
use super::line::Line;
use super::{HostMachine, Nodes, Output, Transmit};
use crate::frame::Address;
use crate::message::{BroadcastStop, HostMessage, Motor, MotorRunning, MotorStop, Reply, SetJoystickMode, Stop};
use crate::query::Query;

states! {
    /// State of an emergency stop.
    #[derive(Default)]
    pub enum StopState {
        /// No emergency stop is under way.
        #[default]
        Calm,
        /// Stops are being sent.
        Stopping,
        /// Motors are being asked whether they move.
        Asking,
    }
}

/// Number of rounds after which the application is told that the stop is not confirmed.
const ROUNDS: u8 = 3;

/// An emergency stop.
#[expect(clippy::struct_excessive_bools, reason = "each is a fact of its own")]
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Emergency {
    /// Number of rounds that are over, up to [`ROUNDS`].
    rounds: u8,
    /// Index of the next packet of this round.
    step: usize,
    /// Whether a stop of this round was not answered by an OK that cannot be the answer to something else.
    is_unsure: bool,
    /// Whether a stop of this round was left out, because its node may be deaf.
    is_partial: bool,
    /// Whether stops were sent before, so that their answers can be counted.
    is_again: bool,
    /// Time before which no stop is repeated; `None` if stops may be sent.
    not_before: Option<Millis>,
    /// Whether the next round waits until answers to its stops can be told from others.
    is_patient: bool,
    /// Whether the application was told that the stop is not confirmed.
    is_told: bool,
}

motion_core::debug! { Emergency { rounds step is_unsure is_partial is_again not_before is_patient is_told } }

impl Emergency {
    /// Begins the round with its first packet.
    const fn restart(&mut self) {
        (self.step, self.is_unsure, self.is_partial, self.is_patient) = (0, false, false, false);
        self.is_again = true;
    }

    pub(super) fn set_back(self, by: Millis) -> Self {
        Self { not_before: self.not_before.map(|before| Millis(before.since(by))), ..self }
    }
}

/// A packet of a round: first the stops, then, from the second round on, the end of joystick mode, then the questions.
///
/// If no node is listed, a broadcast is all there is, with a bridge or without.
fn packet(nodes: &Nodes, bridge: bool, Emergency { rounds, step, .. }: Emergency) -> Option<Transmit> {
    let nodes = nodes.as_slice();
    let everybody = Transmit { to: Address::BROADCAST, message: BroadcastStop::default().into() };
    let broadcast = (!bridge || nodes.is_empty()).then_some(everybody);
    let stops = nodes.iter().flat_map(|&to| {
        let motors = Motor::ALL.map(|motor| HostMessage::from(MotorStop { motor }));
        motors.into_iter().chain([Stop {}.into()]).map(move |message| Transmit { to, message })
    });
    let leave = SetJoystickMode { joystick_mode: false.into() }.into();
    let leaving = nodes.iter().filter(|_| rounds > 0).map(|&to| Transmit { to, message: leave });
    let questions =
        nodes.iter().flat_map(|&to| Motor::ALL.map(|motor| Transmit { to, message: MotorRunning { motor }.into() }));
    broadcast.into_iter().chain(stops).chain(leaving).chain(questions).nth(step)
}

impl HostMachine {
    /// State of the emergency stop.
    #[must_use]
    pub fn stopping(&self) -> StopState {
        match self.next_packet() {
            _ if self.emergency.is_none() => StopState::Calm,
            Some(packet) if packet.message.query().is_none() => StopState::Stopping,
            _ => StopState::Asking,
        }
    }

    /// Ends all commands and begins to stop everything. Pressed again while motors are asked, it begins a new round; while
    /// stops are being sent it changes nothing, because the last nodes would never be reached (decision H-28).
    pub(super) fn emergency_stop(&mut self, now: Millis, output: &mut Output<'_>) {
        output.event(Event::Stopping);
        match self.stopping() {
            StopState::Calm => {
                // The second answer to something else could be taken for the answer to a stop.
                let is_unsure = matches!(self.line, Line::Settling(_) | Line::Quiet(_));
                self.drop_all(now, output, Failure::Stopped);
                self.emergency = Some(Emergency { is_unsure, ..Emergency::default() });
                if self.line == Line::Offline {
                    self.tell_not_confirmed(output);
                }
            }
            StopState::Stopping => {}
            StopState::Asking => {
                self.abandon(now);
                self.new_round(output);
            }
        }
    }

    /// Ends all commands, whatever they wait for. The line is free for stops after the gap.
    pub(super) fn drop_all(&mut self, now: Millis, output: &mut Output<'_>, why: Failure) {
        if let Some(waiting) = self.abandon(now) {
            self.give_up(output, &waiting, why);
        }
        if self.line != Line::Offline {
            self.line = Line::Idle;
        }
        self.drop_stops(output, why);
        for Pending { token, .. } in core::mem::take(&mut self.queue) {
            output.event(Event::Ended { token, outcome: Outcome::Failed(why) });
        }
        for speed in core::mem::take(&mut self.speeds) {
            output.event(Event::Ended { token: speed.token, outcome: Outcome::Failed(why) });
        }
        self.kept.clear();
    }

    fn tell_not_confirmed(&mut self, output: &mut Output<'_>) {
        if let Some(emergency) = self.emergency.as_mut().filter(|emergency| !emergency.is_told) {
            emergency.is_told = true;
            self.tell_not_stopped(output, StopTarget::All);
        }
    }

    fn new_round(&mut self, output: &mut Output<'_>) {
        let Some(emergency) = &mut self.emergency else { return };
        emergency.restart();
        emergency.rounds = emergency.rounds.saturating_add(1).min(ROUNDS);
        if emergency.rounds == ROUNDS {
            self.tell_not_confirmed(output);
        }
    }

    /// Begins the round anew, because nothing is known of the rig after the line went down.
    pub(super) fn emergency_without_line(&mut self, output: &mut Output<'_>) {
        if let Some(emergency) = &mut self.emergency {
            emergency.restart();
        }
        self.tell_not_confirmed(output);
    }

    /// Sends the next packet of an emergency stop, if it may be sent now. If there is none, the round is over, and so is the
    /// emergency stop if nothing of the listed nodes may move any more.
    pub(super) fn send_emergency(&mut self, now: Millis, output: &mut Output<'_>) {
        while let Some(mut emergency) = self.emergency {
            emergency.not_before = emergency.not_before.filter(|before| now < *before);
            self.emergency = Some(emergency);
            let Some(packet) = self.next_packet() else {
                self.round_is_over(output);
                continue;
            };
            let is_stop = packet.message.conduct().is_stop();
            let is_early = emergency.not_before.is_some() || emergency.is_patient && !self.believes_stops(&packet);
            if emergency.step == 0 && is_early {
                return;
            }
            if is_stop && !self.deaf.allows(&packet) {
                if packet.to == Address::BROADCAST && self.options.nodes().as_slice().is_empty() {
                    return;
                }
                self.emergency = Some(Emergency { is_partial: true, is_unsure: true, ..emergency });
                self.next_step();
            } else if !is_stop && emergency.is_partial {
                let may_stop = |to| self.deaf.allows(&Transmit { to, message: Stop {}.into() });
                if !self.options.nodes().as_slice().iter().copied().any(may_stop) {
                    return;
                }
                emergency.restart();
                self.emergency = Some(emergency);
            } else if packet.message.query().is_some() && !self.is_clear(&packet) {
                return;
            } else {
                if is_stop {
                    let not_before = Some(now.after(self.options.timeout().into()));
                    self.emergency = Some(Emergency { not_before, ..emergency });
                }
                self.send(now, output, Job::Emergency(packet));
                if matches!(self.line, Line::Quiet(_)) {
                    self.next_step();
                }
                return;
            }
        }
    }

    /// Acts when each motor has said that it rests, or when there is no motor to be asked.
    fn round_is_over(&mut self, output: &mut Output<'_>) {
        let nodes = self.options.nodes();
        let is_sure = self.emergency.is_some_and(|emergency| !emergency.is_unsure);
        // Without a listed node no motor can be asked, so the stops are repeated.
        if !nodes.as_slice().is_empty() && self.motion.all_rest(&nodes, is_sure) {
            self.emergency = None;
            output.event(Event::Stopped(StopTarget::All));
            return;
        }
        self.new_round(output);
        if let Some(emergency) = &mut self.emergency {
            emergency.is_patient = !nodes.as_slice().is_empty();
        }
    }

    /// Whether the answer to a stop of an emergency stop cannot be the answer to something else.
    pub(super) fn believes_stops(&self, stop: &Transmit) -> bool {
        self.believes(stop, self.emergency.is_some_and(|emergency| emergency.is_again))
    }

    fn next_packet(&self) -> Option<Transmit> {
        self.emergency.and_then(|emergency| packet(&self.options.nodes(), self.options.bridge(), emergency))
    }

    fn next_step(&mut self) {
        if let Some(emergency) = &mut self.emergency {
            emergency.step = emergency.step.saturating_add(1);
        }
    }

    /// Goes on after the answer to a packet of an emergency stop, or after the silence in its place.
    pub(super) fn emergency_answered(&mut self, output: &mut Output<'_>, packet: &Transmit, answer: Option<Reply<'_>>) {
        let Some(emergency) = &mut self.emergency else { return };
        let has_ended = if let HostMessage::MotorRunning(query) = packet.message {
            answer.and_then(|reply| query.decode_reply(reply).ok()).is_some_and(|answer| !answer.value.get())
        } else {
            let is_ok = answer.is_some_and(|reply| reply.is_ok());
            emergency.is_unsure |= packet.message.conduct().is_stop() && !is_ok;
            true
        };
        if has_ended { self.next_step() } else { self.new_round(output) }
    }

    /// Time before which an emergency stop repeats no stop.
    pub(super) fn emergency_not_before(&self) -> Option<Millis> {
        self.emergency.and_then(|emergency| emergency.not_before)
    }

    /// Gives up an emergency stop: it is not confirmed.
    pub(super) fn end_emergency(&mut self, now: Millis, output: &mut Output<'_>) {
        self.tell_not_confirmed(output);
        if self.emergency.take().is_some() {
            self.abandon(now);
        }
    }
}
