//! Everything goes wrong at once, over many seeds.
//!
//! hoot has no checksum: a wrong bit can make another command of a command, and another value of a value. So an OK is
//! worth little here, and what counts is what was asked for afterwards, as the sheet's users do it.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use hoot_proto::HostMessage;
use hoot_proto::host::{Command, Event as Told};
use hoot_proto::message::{self, Motor, MotorPosition, ProgramMode, RunState, RunStatus, RunTime};
use hoot_proto::query::{AnyReply, Profile};
use hoot_proto::{Query, query::Answer};
use motion_core::wire::Bool;
use rigs::Rig;
use rigs::faults::{Carrier, Faults};
use rigs::hoot_node::{HootNode, Setup};

use crate::world::{NODE, ONE, START, STATUS, STOP, Stage, dead_man, mode, planned, ready, smooth};

const SEEDS: u64 = 24;

fn troubled(seed: u64) -> Stage<HootNode> {
    Stage::new(HootNode::new(Setup::default()), Faults::all(Carrier::Serial), seed)
}

impl Stage<HootNode> {
    /// Asks up to four times.
    fn find<Q, T>(&mut self, query: Q, message: HostMessage<'static>) -> Option<T>
    where
        Q: Query,
        for<'a> Q: Query<Reply<'a> = Answer<T>>,
    {
        (0..4).find_map(|_| self.ask(message).read(&query))
    }

    /// Sets something that may be set twice, up to four times.
    fn put(&mut self, message: HostMessage<'static>) -> Option<()> {
        (0..4).find_map(|_| self.ask(message).is_done().then_some(()))
    }

    /// A planned move, stored, looked at and played: done only if the node says so of everything.
    fn play(&mut self) -> Option<()> {
        self.put(STOP)?;
        self.put(dead_man(Bool::TRUE))?;
        self.put(mode(ProgramMode::VIDEO))?;
        self.put(HostMessage::CameraSetEnable(message::CameraSetEnable { enable: Bool::FALSE }))?;
        for message in ready(ONE, 1000.0).into_iter().chain(planned(ONE, 0, smooth())) {
            self.put(message)?;
        }
        let found: Option<Vec<String>> = [
            HostMessage::MotorEnable(message::MotorEnable { motor: ONE }),
            HostMessage::MotorProgramStart(message::MotorProgramStart { motor: ONE }),
            HostMessage::MotorProgramStop(message::MotorProgramStop { motor: ONE }),
            HostMessage::MotorTravel(message::MotorTravel { motor: ONE }),
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
            let state = self.find(RunStatus {}, STATUS)?;
            let gone = self.find(RunTime {}, HostMessage::RunTime(RunTime {}))?;
            if state == RunState::STOPPED {
                let query = MotorPosition { motor: ONE };
                let at = self.find(query, HostMessage::MotorPosition(query))?;
                let is_done = gone.0 == 0 && at == plan.stop && self.now() - began >= 3000;
                return is_done.then_some(());
            }
            state.is_running(Profile::Sheet)?;
        }
    }

    /// What can be seen of everything at this moment.
    fn look(&self, hasher: &mut DefaultHasher) {
        for motor in self.scene.rig.motors() {
            motor.at(self.scene.now()).position.to_bits().hash(hasher);
        }
        (self.scene.held(), self.scene.host.strays(), self.ended.len(), self.told.len()).hash(hasher);
    }
}

/// A move is done, or it is not and an emergency stop is confirmed; and then everything rests, and goes on resting.
#[test]
fn what_is_done_is_done_and_what_is_not_is_stopped() {
    let mut done = 0;
    for seed in 0..SEEDS {
        let mut stage = troubled(seed);
        if stage.play().is_some() {
            done += 1;
            assert_eq!(stage.scene.rig.machine().motor(ONE).position(), smooth().stop, "seed {seed}");
            assert!(stage.is_at_rest(), "seed {seed}");
        } else {
            stage.emergency_stop();
            assert!(!stage.scene.host.may_move(), "seed {seed}");
        }
        for _ in 0..2000 {
            assert!(stage.is_at_rest(), "seed {seed}");
            stage.tick();
        }
    }
    assert!((6..=SEEDS - 1).contains(&done), "{done} of {SEEDS} moves were done");
}

/// Three motors run, and are stopped: by the button, or one by one. What was confirmed rests, from that moment on.
#[test]
fn a_confirmed_stop_is_a_stop() {
    let mut confirmed = 0;
    for seed in 100..100 + SEEDS {
        let mut stage = troubled(seed);
        for motor in Motor::ALL {
            for message in ready(motor, 3000.0) {
                let _ = stage.put(message);
            }
            stage.ask(crate::world::run(motor));
        }
        if seed % 2 == 0 {
            stage.emergency_stop();
            confirmed += 1;
        } else if stage.ask(STOP).is_done() {
            confirmed += 1;
        } else {
            // What nobody confirmed is told, and followed by a stop of each motor.
            assert!(stage.told.iter().any(|(_, told)| *told == Told::StopNotConfirmed { node: Some(NODE) }));
            stage.emergency_stop();
        }
        for _ in 0..1500 {
            assert!(stage.is_at_rest(), "seed {seed}");
            stage.tick();
        }
    }
    assert!(confirmed >= SEEDS * 3 / 4, "{confirmed} of {SEEDS}");
}

/// A master that is told to stop while the line is gone, again and again, stops in the end.
#[test]
fn pulled_and_reset_again_and_again() {
    for seed in 200..200 + SEEDS {
        let mut stage = troubled(seed);
        for message in ready(ONE, 2000.0) {
            let _ = stage.put(message);
        }
        stage.ask(crate::world::run(ONE));
        stage.scene.command(Command::EmergencyStop);
        for pull in 0..5 {
            stage.pass(150 * pull);
            if pull == 3 {
                stage.scene.reset();
            } else {
                stage.scene.unplug();
            }
        }
        stage.emergency_stop();
        assert!(stage.is_at_rest() && !stage.scene.host.may_move(), "seed {seed}");
    }
}

#[test]
fn the_same_seed_is_the_same_day() {
    let day = |seed| {
        let mut stage = troubled(seed);
        let _ = stage.play();
        let mut hasher = DefaultHasher::new();
        for _ in 0..500 {
            stage.look(&mut hasher);
            stage.tick();
        }
        (stage.now(), format!("{:?}{:?}", stage.told, stage.ended), hasher.finish())
    };
    assert_eq!(day(1), day(1));
    assert_ne!(day(1).2, day(2).2);
}
