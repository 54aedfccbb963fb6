//! Moves with every fault, over many seeds: events are true, and motors that are stopped stay where they are.

use kos_proto::device::motor::State;
use kos_proto::device::playback::State as Is;
use kos_proto::host::{self, Event as MachineEvent, Move, Options, Outcome, StopTarget, Token};
use kos_proto::message::MotorAddress;
use kos_proto::trajectory::{Loop, Style, Trajectory};
use motion_core::time::Millis;
use motion_rigs::Rig as _;
use motion_rigs::faults::{Carrier, Faults};
use motion_rigs::kos_device::Setup;
use motion_rigs::kos_host::{Command, Event, StoredMove};

use crate::bench::{Bench, M1, M2, RANGES, TOLERANCE, go, lapse, live, planned};

/// Positions of both motors at the end of the move.
const ENDS: [f64; 2] = [10.5, -11.0];
const SEEDS: std::ops::Range<u64> = 0..32;

/// Bench, and the facts of the rig that events are compared with.
struct Watched {
    bench: Bench,
    /// Positions at which motors rested, as clients count.
    rested: [Vec<f32>; 2],
    /// Motors that had a range.
    ranges: [bool; 2],
    /// Number of times that the move came to its end, and that it was begun.
    ends: u32,
    begins: u32,
    last: Is,
    /// Position at which clients begin to count, as the rig counts.
    zeros: [f64; 2],
    /// Duration of the move in parts of five seconds.
    scale: f64,
    /// First command whose failure counts.
    since: Token,
}

/// Whether a move is played; not on the way to where it begins.
fn plays(state: Is) -> bool {
    state.runs() && !matches!(state, Is::HomingSetup | Is::HomingStart | Is::HomingRapid)
}

/// Event that ended an attempt, most often a lost connection.
type Trouble = String;

impl Watched {
    fn new(stored: &StoredMove, seed: u64) -> Self {
        // Odd seeds have more faults.
        let all = Faults::all(Carrier::Stream);
        let worse = Faults { silence: 3.0, reset: 30.0, stall: 15.0, ..all };
        let faults = if seed.is_multiple_of(2) { all } else { worse };
        let bench = Bench::with(Setup::with_motors(2), Options::default(), None, faults, seed);
        let scale = Trajectory::new(&stored.data()).unwrap().play().move_time() / 5.0;
        let (rested, ranges, zeros) = (Default::default(), [false; 2], [0.0; 2]);
        let since = Token(0);
        Self { bench, rested, ranges, ends: 0, begins: 0, last: Is::Empty, zeros, scale, since }
    }

    fn tick(&mut self) {
        self.bench.pass(if self.bench.rests() { 5 } else { 1 });
        let (rig, now) = (&self.bench.scene.rig, self.bench.scene.now());
        let mut at_end = true;
        for ((index, address), motor) in [M1, M2].into_iter().enumerate().zip(rig.motors()) {
            let Some(drive) = rig.machine().motor(address) else { continue };
            let position = drive.position().0;
            let place = motor.at(now);
            if place.velocity == 0.0 && rig.moment().is_none() {
                self.zeros[index] = place.position - f64::from(position);
            }
            if place.velocity == 0.0 && self.rested[index].last() != Some(&position) {
                self.rested[index].push(position);
            }
            if let Some(moment) = rig.moment() {
                let should = planned(address, self.zeros[index], moment / self.scale);
                let is = place.position;
                // After many attempts the positions are some thousands, where an `f32` is exact to 2e-4.
                assert!((is - should).abs() < 1e-3, "motor {address} at {moment} s: {is}, should be {should}");
            }
            self.ranges[index] |= drive.state() == State::Calibrated;
            at_end &= (f64::from(position) - ENDS[index]).abs() < 1e-3;
        }
        let state = rig.machine().playback();
        if state != self.last {
            self.begins += u32::from(plays(state) && !plays(self.last));
            self.ends += u32::from(plays(self.last) && state == Is::Empty && at_end);
        }
        self.last = state;
        assert!(self.bench.rests() || self.bench.may_move(), "motors move, and the client does not know it");
    }

    /// Next event, compared with the rig.
    fn event(&mut self) -> Option<Event> {
        let event = self.bench.event()?;
        match event {
            Event::Machine(MachineEvent::MotorRests(motor, position)) => {
                let rested = &self.rested[usize::from(motor.0) - 1];
                let was = rested.iter().any(|place| f64::from(place - position.0).abs() < TOLERANCE);
                assert!(was, "motor {motor} never rested at {position}: {rested:?}");
            }
            Event::Machine(MachineEvent::Stopped(StopTarget::All)) => {
                assert!(self.bench.rests(), "not everything rests");
            }
            _ => {}
        }
        Some(event)
    }

    /// Waits for an event, for a minute at most, and only until something fails.
    fn wait<T>(&mut self, wanted: &str, mut look: impl FnMut(&Event) -> Option<T>) -> Result<T, Trouble> {
        let until = self.bench.now() + 60_000;
        while self.bench.now() < until {
            while let Some(event) = self.event() {
                if let Some(found) = look(&event) {
                    return Ok(found);
                }
                let fails = match event {
                    Event::Machine(MachineEvent::Ended { token, outcome }) => {
                        token >= self.since && !matches!(outcome, Outcome::Done(_) | Outcome::Sent)
                    }
                    Event::Machine(
                        MachineEvent::LinkDown(_)
                        | MachineEvent::Error(..)
                        | MachineEvent::Move(Move::Failed(_) | Move::Finished { .. }),
                    ) => true,
                    _ => false,
                };
                if fails {
                    return Err(format!("{event:?}"));
                }
            }
            self.tick();
        }
        Err(format!("{wanted} did not come"))
    }

    /// Gives a command, and waits until it is done.
    fn done(&mut self, wanted: &str, command: host::Command) -> Result<(), Trouble> {
        let token = self.bench.send(command);
        let done = Event::Machine(MachineEvent::Ended { token, outcome: Outcome::Done(None) });
        self.wait(wanted, |event| (*event == done).then_some(()))
    }

    /// Marks the ranges, then plays the move to its end.
    fn attempt(&mut self, stored: &StoredMove) -> Result<(), Trouble> {
        for (index, motor) in [M1, M2].into_iter().enumerate() {
            self.bench.send(host::Command::ResetAxis(motor));
            self.bench.send(host::Command::MarkBegin(motor));
            self.done("rest", host::Command::Bump(go(motor, RANGES[index])))?;
            self.done("range", host::Command::MarkEnd(motor))?;
            assert!(self.ranges[index], "motor {motor} had no range");
        }
        let ends = self.ends;
        self.bench.command(Command::PlayDirect { stored: stored.clone() });
        self.wait("end", |event| (*event == Event::Machine(MachineEvent::Move(Move::EndReached))).then_some(()))?;
        let over = Event::Machine(MachineEvent::Move(Move::Finished { requested: false }));
        self.wait("report that the move is over", |event| (*event == over).then_some(()))?;
        assert_eq!(self.ends, ends + 1, "the move is not at its end");
        Ok(())
    }

    /// Stops everything, however long it takes, and checks that nothing moves after it.
    fn recover(&mut self) {
        let until = self.bench.now() + 600_000;
        loop {
            assert!(self.bench.now() < until, "no stop is confirmed");
            while self.bench.scene.host.machine().state() != host::State::Ready {
                assert!(self.bench.now() < until, "no connection");
                self.tick();
                while self.event().is_some() {}
            }
            self.since = self.bench.send(host::Command::Stop);
            let stopped = Event::Machine(MachineEvent::Stopped(StopTarget::All));
            if self.wait("stop", |event| (*event == stopped).then_some(())).is_ok() {
                break;
            }
        }
        let begins = self.begins;
        let places = [M1, M2].map(|motor: MotorAddress| self.bench.at(motor).to_bits());
        let calm = self.bench.now() + 3000;
        while self.bench.now() < calm {
            self.tick();
            assert!(self.bench.rests() && self.begins == begins);
            while self.event().is_some() {}
        }
        assert_eq!([M1, M2].map(|motor| self.bench.at(motor).to_bits()), places);
    }
}

/// Tries until the move was played to its end. Returns the number of attempts that failed.
fn play(stored: &StoredMove, seed: u64) -> (u32, Watched) {
    let mut watched = Watched::new(stored, seed);
    watched.bench.command(Command::Connect);
    let mut troubles = Vec::new();
    while troubles.len() < 100 {
        watched.recover();
        let Err(trouble) = watched.attempt(stored) else {
            watched.recover();
            return (u32::try_from(troubles.len()).unwrap(), watched);
        };
        troubles.push((watched.bench.scene.now(), trouble));
    }
    panic!("seed {seed}: {troubles:#?}");
}

#[test]
fn a_move_is_played_to_its_end_with_every_fault() {
    let (mut failed, mut begun, mut virtual_time) = (0, 0, 0);
    for seed in SEEDS {
        let (tries, watched) = play(&live(Loop::Once), seed);
        failed += tries;
        begun += watched.begins;
        virtual_time += watched.bench.now();
        assert!(
            watched.begins >= watched.ends && watched.begins <= tries + 1,
            "seed {seed}: a move began without a command"
        );
    }
    println!("{failed} attempts failed, {begun} moves, {} s", virtual_time / 1000);
    assert!(failed > 30, "the faults are too rare to show anything: {failed}");
}

#[test]
fn a_lapse_is_shot_to_its_end_with_every_fault() {
    for seed in SEEDS {
        let style = if seed % 4 < 2 { Style::ShootMoveShoot } else { Style::Continuous };
        let (tries, watched) = play(&lapse(style, 8, 1), seed);
        let photos = watched.bench.scene.rig.photo_count();
        assert!((10..=10 * (u64::from(tries) + 1)).contains(&photos), "seed {seed}: {photos} photos, {tries} tries");
    }
}

#[test]
fn the_same_seed_gives_the_same_events() {
    let told = |seed| play(&live(Loop::Once), seed).1.bench.trace;
    let (one, same, other): (Vec<(Millis, String)>, _, _) = (told(3), told(3), told(4));
    assert_eq!(one, same);
    assert_ne!(one, other);
}
