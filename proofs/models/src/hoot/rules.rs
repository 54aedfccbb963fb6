//! Rules of hoot, and the states that must be reached so that the rules mean something.

use hoot_proto::Effect;
use hoot_proto::device::ProgramState;
use hoot_proto::host::{self, Event, Outcome, Refusal, StopState, StopTarget, Token, Transmit};
use hoot_proto::message::{HostMessage, Motor, MotorSetContinuousSpeed};
use stateright::Property;

use super::{Flaw, Hoot, NODE, Way, Wish, World, place};

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
    /// A command ended twice.
    EndedTwice,
    /// The master said that nothing may move, and something moves because of it.
    MayMove,
    /// Node and rig do not agree on the motions.
    RigDiffers,
    /// Two packets wait at the node while a start blocks it.
    TwoWait,
}

/// Whether a message may be sent again without the application: stops, and queries that change nothing (safety decision
/// 1).
fn may_come_again(message: &HostMessage<'_>) -> bool {
    let is_query = message.query().is_some() && !matches!(message, HostMessage::PowerCycled(_));
    is_stop(message) || is_query
}

/// Whether a message is a stop of safety decision 1.
pub(super) fn is_stop(message: &HostMessage<'_>) -> bool {
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
        matches!(self.both.device.machine.program().state(), ProgramState::Delay | ProgramState::Running)
    }

    /// The node has received a message. `refuses` means that it copies firmware that refuses the stop in joystick mode.
    pub(super) fn obeys(&mut self, message: &HostMessage<'_>, refuses: bool) {
        let is_refused =
            refuses && self.both.device.machine.controller().joystick_mode && matches!(message, HostMessage::Stop(_));
        // A program would set the motor in motion again, whichever motor is stopped.
        let obeys = self.rests_after(message) && !self.program_is_going();
        if is_stop(message) && !is_refused && !obeys {
            self.break_rule(Broken::StopDisobeyed);
        }
    }

    /// The master knows that what moves may move, unless somebody else has set it in motion.
    fn master_is_right(&mut self) {
        let moves = self.rig != [Way::Resting; 3] || self.program_is_going();
        if moves && !self.is_foreign && !self.both.host.machine.may_move() {
            self.break_rule(Broken::MayMove);
        }
    }

    pub(super) fn node_is_right(&mut self) {
        let moving = Motor::ALL.map(|motor| self.both.device.machine.motor(motor).is_moving());
        if moving != self.rig.map(|way| way != Way::Resting) {
            self.break_rule(Broken::RigDiffers);
        }
        if self.program_is_going() && self.homing.contains(&true) {
            self.break_rule(Broken::TwoMoves);
        }
    }

    /// Checks the end of a stop. An emergency stop takes the place of others, and reports for itself.
    fn stop_ended(&mut self, stop: &HostMessage<'_>, outcome: &Outcome<'_>, output: &host::Output<'_>) {
        let is_told = output.events().any(|event| matches!(event, Event::StopNotConfirmed(_)));
        match outcome {
            Outcome::Done(_) if !self.rests_after(stop) => self.break_rule(Broken::StopMistaken),
            Outcome::Refused(Refusal::Device(_) | Refusal::NotConnected)
            | Outcome::Failed(_)
            | Outcome::NotConfirmed
                if !is_told && self.stopping() == StopState::Calm =>
            {
                self.break_rule(Broken::StopUntold);
            }
            _ => {}
        }
    }
}

impl Hoot {
    pub(super) fn host_did(&self, world: &mut World, output: &host::Output<'_>) {
        for effect in &output.effects {
            match effect {
                Effect::Transmit(transmit) => {
                    if world.stop_due.take().is_some() && !is_stop(&transmit.message) {
                        world.break_rule(Broken::StopWaits);
                    }
                    self.send(world, *transmit);
                }
                Effect::Event(Event::Ended { token: Token(at), outcome }) => {
                    self.has_ended(world, *at, outcome, output);
                    if let (Flaw::Resends, true, Wish::Request(message)) =
                        (self.flaw, is_silence(outcome), self.wishes[*at as usize])
                    {
                        self.send(world, Transmit { to: NODE, message });
                    }
                }
                Effect::Event(Event::Stopping) => world.is_told = false,
                Effect::Event(Event::StopNotConfirmed(target)) => {
                    world.is_told |= *target == StopTarget::All;
                    world.seen.not_confirmed = true;
                }
                Effect::Event(Event::Stopped(StopTarget::All)) => {
                    world.seen.confirmed = true;
                    if world.rig != [Way::Resting; 3] || world.program_is_going() {
                        world.break_rule(Broken::StopMistaken);
                    }
                }
                Effect::Event(Event::Unsolicited(_)) => world.seen.unsolicited = true,
                Effect::Event(_) => {}
            }
        }
        let motions =
            self.requests().filter(|(at, message)| is_motion(message) && world.open & world.sent & 1 << at != 0);
        if motions.count() > 1 {
            world.break_rule(Broken::TwoMotions);
        }
        world.master_is_right();
    }

    /// Requests of the application.
    fn requests(&self) -> impl Iterator<Item = (usize, HostMessage<'static>)> {
        self.wishes.iter().enumerate().filter_map(|(at, wish)| match *wish {
            Wish::Request(message) => Some((at, message)),
            Wish::Speed(motor, speed) => Some((at, MotorSetContinuousSpeed { motor, speed }.into())),
            _ => None,
        })
    }

    fn send(&self, world: &mut World, transmit: Transmit) {
        self.was_sent(world, &transmit.message);
        let due = world.both.now.after(self.delay);
        world.both.up.send(due, transmit);
        let longest = Some(world.both.now.after(super::DEAF));
        if world.deaf_until.is_some() {
            world.waits_until = longest;
        }
        if let HostMessage::Start(_) | HostMessage::BroadcastStart(_) = transmit.message {
            world.deaf_until = longest;
        }
        let message = transmit.message;
        if is_stop(&message) && self.requests().any(|(at, wish)| wish == message && world.used & 1 << at == 0) {
            world.stops.retain(|(stop, _)| *stop != message);
            world.stops.push((message, world.both.now));
        }
        if message.conduct().may_move() {
            let part = |message: &HostMessage<'_>| message.selector().sub_address;
            let moved = part(&message);
            world.stops.retain(|(stop, _)| part(stop) != 0 && moved != 0 && part(stop) != moved);
        }
        if let (Flaw::Hurries, HostMessage::Stop(_)) = (self.flaw, transmit.message) {
            world.both.up.send(due, transmit);
        }
    }

    /// Records a sent message. All messages that may not be repeated differ from each other.
    fn was_sent(&self, world: &mut World, message: &HostMessage<'_>) {
        let wish = self.requests().find(|(_, wish)| wish == message).map_or(0, |(at, _)| 1 << at);
        let is_asked = world.used & wish != 0 && world.sent & wish == 0;
        let leaves_joystick = matches!(message, HostMessage::SetJoystickMode(set) if !set.joystick_mode.get())
            && world.stopping() != StopState::Calm;
        if !is_asked && !may_come_again(message) && !leaves_joystick {
            world.break_rule(Broken::SentAgain);
        }
        world.sent |= wish;
    }

    fn has_ended(&self, world: &mut World, at: u32, outcome: &Outcome<'_>, output: &host::Output<'_>) {
        let bit = 1 << at;
        if world.open & bit == 0 {
            world.break_rule(Broken::EndedTwice);
        }
        let stop = match self.wishes[at as usize] {
            Wish::Request(message) => Some(message).filter(is_stop),
            _ => None,
        };
        if self.flaw != Flaw::Forgets || stop.is_some() {
            world.open &= !bit;
        }
        world.seen.silence |= is_silence(outcome);
        match outcome {
            Outcome::Done(_) => world.seen.done = true,
            Outcome::Refused(Refusal::Device(_)) => world.seen.refused = true,
            _ => {}
        }
        if let Some(stop) = stop {
            world.stop_ended(&stop, outcome, output);
        }
    }
}

/// Whether no clear answer came to what was sent.
fn is_silence(outcome: &Outcome<'_>) -> bool {
    matches!(outcome, Outcome::NotConfirmed | Outcome::Failed(host::Failure::NoAnswer))
}

/// Whether the master has no deadline, and no packet is in flight to it.
fn is_settled(world: &World) -> bool {
    world.is_quiet() && world.both.host.wake.is_none()
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
        "a command ends once" EndedTwice
        "the master knows that what moves may move" MayMove
        "node and rig agree on the motions" RigDiffers
        "two packets never wait at a deaf node" TwoWait
    };
    all.extend([
        Property::always("no command is forgotten", |_, world| {
            !is_settled(world) || world.open == 0 && world.both.host.machine.pending() == 0
        }),
        Property::always("no emergency is forgotten", |_, world: &World| {
            let is_calm = world.stopping() == StopState::Calm;
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
