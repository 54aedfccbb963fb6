//! All faults together, over many seeds.
//!
//! hoot has no checksum, so a wrong bit can change a command or a value, and the node answers OK to it. So the tests ask
//! for the state afterwards, as users of the published sheet do.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use hoot_proto::host::{Command, Event, StopTarget};
use hoot_proto::message::{self, Bool, Motor, MotorPosition, ProgramMode, RunState, RunTime};
use hoot_proto::query::{Answer, AnyReply, Profile};
use hoot_proto::{HostMessage, Query};
use motion_rigs::Rig;
use motion_rigs::faults::{Carrier, Faults};
use motion_rigs::hoot_node::{HootNode, Setup};

use crate::world::{NODE, ONE, START, STATUS, STOP, Stage, dead_man, enable_camera, mode, planned, ready, run, smooth};

const SEEDS: u64 = 24;

fn troubled(seed: u64) -> Stage<HootNode> {
    Stage::new(HootNode::new(Setup::default()), Faults::all(Carrier::Serial), seed)
}

impl Stage<HootNode> {
    /// Asks up to four times.
    fn find<Q, T>(&mut self, query: Q) -> Option<T>
    where
        Q: Into<HostMessage<'static>>,
        for<'a> Q: Query<Reply<'a> = Answer<T>>,
    {
        (0..4).find_map(|_| self.ask(query).read(&query))
    }

    /// Sends a message that may be repeated, up to four times.
    fn put(&mut self, message: impl Into<HostMessage<'static>>) -> Option<()> {
        let message = message.into();
        (0..4).find_map(|_| self.ask(message).is_done().then_some(()))
    }

    /// Stores a planned move, reads it back, and plays it. `None` if the node does not confirm all of it.
    fn play(&mut self) -> Option<()> {
        self.put(STOP)?;
        self.put(dead_man(true))?;
        self.put(mode(ProgramMode::VIDEO))?;
        self.put(enable_camera(false))?;
        for message in ready(ONE, 1000.0).into_iter().chain(planned(ONE, 0, smooth())) {
            self.put(message)?;
        }
        let found: Option<Vec<String>> = [
            HostMessage::from(message::MotorEnable { motor: ONE }),
            message::MotorProgramStart { motor: ONE }.into(),
            message::MotorProgramStop { motor: ONE }.into(),
            message::MotorTravel { motor: ONE }.into(),
        ]
        .into_iter()
        .map(|query| (0..4).find_map(|_| self.ask(query).answer().map(|answer: AnyReply<'_>| answer.to_string())))
        .collect();
        let plan = smooth();
        let wanted = [Bool::TRUE.to_string(), plan.start.to_string(), plan.stop.to_string(), plan.travel.to_string()];
        if found? != wanted {
            return None;
        }
        let began = self.now();
        self.ask(START);
        loop {
            let state = self.find(STATUS)?;
            let gone = self.find(RunTime {})?;
            if state == RunState::STOPPED {
                let at = self.find(MotorPosition { motor: ONE })?;
                let is_done = gone.0 == 0 && at == plan.stop && self.now() - began >= 3000;
                return is_done.then_some(());
            }
            state.is_running(Profile::SHEET)?;
        }
    }

    /// Hashes the state of everything at this moment.
    fn look(&self, hasher: &mut DefaultHasher) {
        for motor in self.scene.rig.motors() {
            motor.at(self.scene.now()).position.to_bits().hash(hasher);
        }
        (self.scene.held(), self.scene.host.strays(), self.ended.len(), self.events.len()).hash(hasher);
    }
}

#[test]
fn a_move_is_done_or_an_emergency_stop_is_confirmed_and_then_everything_rests() {
    let mut done = 0;
    for seed in 0..SEEDS {
        let mut stage = troubled(seed);
        if stage.play().is_some() {
            done += 1;
            assert_eq!(stage.scene.rig.machine().motor(ONE).position(), smooth().stop, "seed {seed}");
            assert!(stage.is_at_rest(), "seed {seed}");
        } else {
            stage.emergency_stop();
            assert!(!stage.may_move(), "seed {seed}");
        }
        for _ in 0..2000 {
            assert!(stage.is_at_rest(), "seed {seed}");
            stage.tick();
        }
    }
    assert!((6..=SEEDS - 1).contains(&done), "{done} of {SEEDS} moves were done");
}

/// Three motors are stopped by the emergency stop of the master, or by the stop of the node.
#[test]
fn after_a_confirmed_stop_all_motors_rest() {
    let mut confirmed = 0;
    for seed in 100..100 + SEEDS {
        let mut stage = troubled(seed);
        for motor in Motor::ALL {
            for message in ready(motor, 3000.0) {
                let _ = stage.put(message);
            }
            stage.ask(run(motor));
        }
        if seed % 2 == 0 {
            stage.emergency_stop();
            confirmed += 1;
        } else if stage.ask(STOP).is_done() {
            confirmed += 1;
        } else {
            // The master tells that the stop is not confirmed, and stops each motor.
            assert!(stage.has_event(Event::StopNotConfirmed(StopTarget::Node(NODE))) && stage.may_move());
            stage.emergency_stop();
        }
        for _ in 0..1500 {
            assert!(stage.is_at_rest(), "seed {seed}");
            stage.tick();
        }
    }
    assert!(confirmed >= SEEDS * 3 / 4, "{confirmed} of {SEEDS}");
}

#[test]
fn an_emergency_stop_is_confirmed_in_the_end_although_the_line_fails_again_and_again() {
    for seed in 200..200 + SEEDS {
        let mut stage = troubled(seed);
        for message in ready(ONE, 2000.0) {
            let _ = stage.put(message);
        }
        stage.ask(run(ONE));
        stage.command(Command::EmergencyStop);
        for pull in 0..5 {
            stage.pass(150 * pull);
            if pull == 3 {
                stage.scene.reset();
            } else {
                stage.scene.unplug();
            }
        }
        stage.emergency_stop();
        assert!(stage.is_at_rest() && !stage.may_move(), "seed {seed}");
    }
}

#[test]
fn the_same_seed_gives_the_same_events() {
    let day = |seed| {
        let mut stage = troubled(seed);
        let _ = stage.play();
        let mut hasher = DefaultHasher::new();
        for _ in 0..500 {
            stage.look(&mut hasher);
            stage.tick();
        }
        (stage.now(), format!("{:?}{:?}", stage.events, stage.ended), hasher.finish())
    };
    assert_eq!(day(1), day(1));
    assert_ne!(day(1).2, day(2).2);
}
