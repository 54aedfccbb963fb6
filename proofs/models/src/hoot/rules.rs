//! Rules of hoot, and the states that must be reached so that the rules mean something.

use hoot_proto::device::ProgramState;
use hoot_proto::host::{self, Event, Failure, NotTaken, Outcome, StopState, Token};
use hoot_proto::message::{HostMessage, Motor};
use motion_core::time::Millis;
use stateright::Property;

use super::{Flaw, Hoot, NODE, Packet, Way, Wish, World, place};

/// Broken rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Broken {
    /// A packet was sent before a stop, or the stop was not sent when the gap was over.
    StopWaits,
    /// A stop arrived, and a motion that it stops goes on.
    StopDisobeyed,
    /// A stop was confirmed, and a motion that it stops goes on.
    StopMistaken,
    /// A stop ended without a confirmation, and this was not reported.
    StopUntold,
    /// A program and the way home were active at once.
    TwoMoves,
    /// Two motion requests were unanswered at once.
    TwoMotions,
    /// A request that may not be repeated was sent again, or was sent without a wish.
    SentAgain,
    /// A request ended twice.
    EndedTwice,
    /// Node and rig do not agree on the motions.
    RigDiffers,
}

/// Whether a message may be sent again without the application: stops, and queries that change nothing (safety decision
/// 1).
fn may_come_again(message: &HostMessage<'_>) -> bool {
    let is_query = message.query().is_some() && !matches!(message, HostMessage::PowerCycled(_));
    is_stop(message) || is_query
}

/// Whether a message is a stop of safety decision 1.
fn is_stop(message: &HostMessage<'_>) -> bool {
    use HostMessage::{BroadcastPause, BroadcastStop, MotorStop, Pause, Stop};
    matches!(message, Stop(_) | Pause(_) | MotorStop(_) | BroadcastStop(_) | BroadcastPause(_))
}

/// Whether a message sets motors in motion, or redirects them.
fn is_motion(message: &HostMessage<'_>) -> bool {
    use HostMessage::{MotorMove, MotorRun, MotorSendHome, ReturnHome, Start};
    matches!(message, Start(_) | ReturnHome(_) | MotorSendHome(_) | MotorMove(_) | MotorRun(_))
}

impl World {
    /// Whether nothing moves that the stop stops.
    fn rests_after(&self, stop: &HostMessage<'_>) -> bool {
        match stop {
            HostMessage::MotorStop(stop) => self.rig[place(stop.motor)] == Way::Resting,
            _ => self.rig == [Way::Resting; 3],
        }
    }

    fn program_is_going(&self) -> bool {
        matches!(self.node.program().state(), ProgramState::Delay | ProgramState::Running)
    }

    /// The node has received a message. `refuses` means that it copies firmware that refuses the stop in joystick mode.
    pub(super) fn obeys(&mut self, message: &HostMessage<'_>, refuses: bool) {
        let is_refused = refuses && self.node.controller().joystick_mode && matches!(message, HostMessage::Stop(_));
        // A program would set the motor in motion again, whichever motor is stopped.
        let obeys = self.rests_after(message) && !self.program_is_going();
        if is_stop(message) && !is_refused && !obeys {
            self.break_rule(Broken::StopDisobeyed);
        }
    }

    pub(super) fn node_is_right(&mut self) {
        let moving = Motor::ALL.map(|motor| self.node.motor(motor).is_moving());
        if moving != self.rig.map(|way| way != Way::Resting) {
            self.break_rule(Broken::RigDiffers);
        }
        if self.program_is_going() && self.homing.contains(&true) {
            self.break_rule(Broken::TwoMoves);
        }
    }

    /// Checks the end of a stop.
    fn stop_ended(&mut self, stop: &HostMessage<'_>, outcome: &Outcome, events: &[Event]) {
        let is_told = events.iter().any(|event| matches!(event, Event::StopNotConfirmed { .. }));
        match outcome {
            Outcome::Done(_) if !self.rests_after(stop) => self.break_rule(Broken::StopMistaken),
            Outcome::Refused(_) | Outcome::Failed(Failure::Silence | Failure::NotTaken(NotTaken::Link)) if !is_told => {
                self.break_rule(Broken::StopUntold);
            }
            _ => {}
        }
    }
}

impl Hoot {
    pub(super) fn host_did(&self, world: &mut World, now: Millis, output: &host::Output) {
        for &send in &output.send {
            if world.stop_due.take().is_some() && !is_stop(&send.message) {
                world.break_rule(Broken::StopWaits);
            }
            self.send(world, now, send);
        }
        for event in &output.events {
            match event {
                Event::Ended { token: Token(at), outcome } => {
                    self.has_ended(world, *at, outcome, &output.events);
                    let is_silence = *outcome == Outcome::Failed(Failure::Silence);
                    let wish = self.wishes[*at as usize];
                    if let (Flaw::Resends, true, Wish::Request(message)) = (self.flaw, is_silence, wish) {
                        self.send(world, now, host::Send { to: NODE, message });
                    }
                }
                Event::Stopping => world.is_told = false,
                Event::StopNotConfirmed { node } => {
                    world.is_told |= node.is_none();
                    world.seen.not_confirmed = true;
                }
                Event::StopConfirmed => {
                    world.seen.confirmed = true;
                    if world.rig != [Way::Resting; 3] {
                        world.break_rule(Broken::StopMistaken);
                    }
                }
                Event::Unsolicited(_) => world.seen.unsolicited = true,
                _ => {}
            }
        }
        let motions =
            self.requests().filter(|(at, message)| is_motion(message) && world.open & world.sent & 1 << at != 0);
        if motions.count() > 1 {
            world.break_rule(Broken::TwoMotions);
        }
    }

    /// Requests of the application.
    fn requests(&self) -> impl Iterator<Item = (usize, HostMessage<'static>)> {
        self.wishes.iter().enumerate().filter_map(|(at, wish)| match *wish {
            Wish::Request(message) => Some((at, message)),
            Wish::Speed(motor, speed) => {
                let set = hoot_proto::message::MotorSetContinuousSpeed { motor, speed };
                Some((at, HostMessage::MotorSetContinuousSpeed(set)))
            }
            _ => None,
        })
    }

    fn send(&self, world: &mut World, now: Millis, message: host::Send) {
        self.was_sent(world, &message.message);
        world.to_node.send([Packet { message, by: now.after(self.delay), follows: false }]);
    }

    /// Records a sent message. All messages that may not be repeated differ from each other.
    fn was_sent(&self, world: &mut World, message: &HostMessage<'_>) {
        let wish = self.requests().find(|(_, wish)| wish == message).map_or(0, |(at, _)| 1 << at);
        let is_asked = world.used & wish != 0 && world.sent & wish == 0;
        let leaves_joystick = matches!(message, HostMessage::SetJoystickMode(set) if !set.joystick_mode.get())
            && world.host.stopping() != StopState::Calm;
        if !is_asked && !may_come_again(message) && !leaves_joystick {
            world.break_rule(Broken::SentAgain);
        }
        world.sent |= wish;
    }

    fn has_ended(&self, world: &mut World, at: u32, outcome: &Outcome, events: &[Event]) {
        let bit = 1 << at;
        let Wish::Request(message) = self.wishes[at as usize] else { return };
        if world.open & bit == 0 {
            world.break_rule(Broken::EndedTwice);
        }
        if self.flaw != Flaw::Forgets || is_stop(&message) {
            world.open &= !bit;
        }
        match outcome {
            Outcome::Done(_) => world.seen.done = true,
            Outcome::Refused(_) => world.seen.refused = true,
            Outcome::Failed(Failure::Silence) => world.seen.silence = true,
            _ => {}
        }
        if is_stop(&message) {
            world.stop_ended(&message, outcome, events);
        }
    }
}

/// Whether the master has no deadline, and no packet is in flight to it.
fn is_settled(world: &World) -> bool {
    world.is_quiet() && world.host_wake.is_none()
}

pub(super) fn properties() -> Vec<Property<Hoot>> {
    macro_rules! never {
        ($($name:literal $broken:ident)*) => {
            vec![$(Property::always($name, |_, world: &World| world.broken != Some(Broken::$broken)),)*]
        };
    }
    let mut all = never! {
        "a stop waits for nothing but the gap" StopWaits
        "a stop that arrives is obeyed in the same step" StopDisobeyed
        "motors that are confirmed to rest do not move" StopMistaken
        "a stop that is not confirmed is reported" StopUntold
        "one coordinated move at a time" TwoMoves
        "one unanswered motion request at a time" TwoMotions
        "a request that may not be repeated is sent once" SentAgain
        "a request ends once" EndedTwice
        "node and rig agree on the motions" RigDiffers
    };
    all.extend([
        Property::always("no request is forgotten", |_, world| {
            !is_settled(world) || world.open == 0 && world.host.pending() == 0
        }),
        Property::always("no emergency is forgotten", |_, world: &World| {
            let is_calm = world.host.stopping() == StopState::Calm;
            !is_settled(world) || is_calm || !world.is_up() && world.is_told
        }),
    ]);
    all.extend(witnesses());
    all
}

/// States that must be reached so that the rules mean something. Which of them, depends on the setup.
fn witnesses() -> Vec<Property<Hoot>> {
    macro_rules! some {
        ($($name:literal $seen:ident)*) => {
            vec![$(Property::sometimes($name, |_, world: &World| world.seen.$seen),)*]
        };
    }
    some! {
        "a request is done" done
        "a silence is reported" silence
        "a refusal is reported" refused
        "an emergency stop is confirmed" confirmed
        "a stop is not confirmed" not_confirmed
        "a reply belongs to no request" unsolicited
        "a motor arrives" arrived
        "a program ends" program_ended
    }
}
