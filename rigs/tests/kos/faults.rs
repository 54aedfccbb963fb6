//! The same with every fault on, over many seeds: what is told is true, and what is stopped stays so.

use kos_proto::device::motor::State;
use kos_proto::device::playback::State as Is;
use kos_proto::host::{self, Event as Said, Move, Options};
use kos_proto::message::MotorAddress;
use kos_proto::summary::Direction;
use kos_proto::trajectory::{Loop, Style, Trajectory};
use motion_core::time::Millis;
use rigs::Rig as _;
use rigs::faults::{Carrier, Faults};
use rigs::kos_device::Setup;
use rigs::kos_host::{Command, Event, StoredMove};

use crate::bench::{Bench, M1, M2, RANGES, TOLERANCE, go, lapse, live, planned};

/// Where the move ends.
const ENDS: [f64; 2] = [10.5, -11.0];
const SEEDS: std::ops::Range<u64> = 0..32;

/// A bench, and what is true of the rig, and was.
struct Watched {
    bench: Bench,
    /// Positions at which motors rested, as clients count.
    rested: [Vec<f32>; 2],
    /// Which motors had a range.
    ranges: [bool; 2],
    /// How often the move came to its end, and how often it was begun.
    ends: u32,
    begins: u32,
    last: Is,
    /// Where clients begin to count, as the rig counts; for what part of five seconds the move takes.
    zeros: [f64; 2],
    scale: f64,
}

/// Whether a move is played, and not only its begin gone to.
fn plays(state: Is) -> bool {
    state.runs() && !matches!(state, Is::HomingSetup | Is::HomingStart | Is::HomingRapid)
}

/// Something failed, and what it was; a lost line, most of all.
type Trouble = String;

impl Watched {
    fn new(stored: &StoredMove, seed: u64) -> Self {
        // A bad day, and a worse one.
        let all = Faults::all(Carrier::Stream);
        let worse = Faults { silence: 3.0, reset: 30.0, stall: 15.0, ..all };
        let faults = if seed.is_multiple_of(2) { all } else { worse };
        let bench = Bench::with(Setup::with_motors(2), Options::default(), None, faults, seed);
        let scale = Trajectory::new(&stored.data()).unwrap().play().move_time() / 5.0;
        let (rested, ranges, zeros) = (Default::default(), [false; 2], [0.0; 2]);
        Self { bench, rested, ranges, ends: 0, begins: 0, last: Is::Empty, zeros, scale }
    }

    fn tick(&mut self) {
        self.bench.pass(if self.bench.rests() { 5 } else { 1 });
        let (rig, now) = (&self.bench.scene.rig, self.bench.scene.now());
        let mut at_end = true;
        for ((index, motor), it) in [M1, M2].into_iter().enumerate().zip(rig.motors()) {
            let Some(drive) = rig.machine().motor(motor) else { continue };
            let position = drive.position().0;
            let place = it.at(now);
            if place.velocity == 0.0 && rig.moment().is_none() {
                self.zeros[index] = place.position - f64::from(position);
            }
            if place.velocity == 0.0 && self.rested[index].last() != Some(&position) {
                self.rested[index].push(position);
            }
            if let Some(moment) = rig.moment() {
                let should = planned(motor, self.zeros[index], moment / self.scale);
                let is = place.position;
                // After many tries the rig counts to some thousands, where an `f32` knows 2e-4.
                assert!((is - should).abs() < 1e-3, "motor {motor} at {moment} s: {is}, should be {should}");
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
    }

    /// The next event, which is true.
    fn event(&mut self) -> Option<Event> {
        let event = self.bench.event()?;
        match event {
            Event::Told(Said::MotorRests(motor, position)) => {
                let rested = &self.rested[usize::from(motor.0) - 1];
                let was = rested.iter().any(|place| f64::from(place - position.0).abs() < TOLERANCE);
                assert!(was, "motor {motor} never rested at {position}: {rested:?}");
            }
            Event::Told(Said::Calibrated(motor)) => {
                assert!(self.ranges[usize::from(motor.0) - 1], "motor {motor} had no range");
            }
            Event::Stopped => assert!(self.bench.rests(), "it was said to rest"),
            _ => {}
        }
        Some(event)
    }

    /// Waits until something is told; not for ever, and not if something fails.
    fn wait<T>(&mut self, wanted: &str, mut look: impl FnMut(&Event) -> Option<T>) -> Result<T, Trouble> {
        let until = self.bench.now() + 60_000;
        while self.bench.now() < until {
            while let Some(event) = self.event() {
                if let Some(found) = look(&event) {
                    return Ok(found);
                }
                if let Event::Told(
                    Said::Closed(_)
                    | Said::Refused(_)
                    | Said::Error(..)
                    | Said::CalibrationFailed(_)
                    | Said::Move(Move::Failed(_) | Move::Finished { .. }),
                ) = event
                {
                    return Err(format!("{event:?}"));
                }
            }
            self.tick();
        }
        Err(format!("{wanted} did not come"))
    }

    /// What a person does: ranges, then the move, to its end.
    fn attempt(&mut self, stored: &StoredMove) -> Result<(), Trouble> {
        for (motor, range) in [M1, M2].into_iter().zip(RANGES) {
            self.bench.send(host::Command::ResetAxis(motor));
            self.bench.send(host::Command::MarkBegin(motor));
            self.bench.send(host::Command::Bump(go(motor, range)));
            let rests =
                |event: &Event| matches!(event, Event::Told(Said::MotorRests(it, _)) if *it == motor).then_some(());
            self.wait("rest", rests)?;
            self.bench.send(host::Command::MarkEnd(motor));
            self.wait("range", |event| (*event == Event::Told(Said::Calibrated(motor))).then_some(()))?;
        }
        let ends = self.ends;
        self.bench.scene.command(Command::PlayDirect { stored: stored.clone(), way: Direction::Forward });
        self.wait("end", |event| (*event == Event::Told(Said::Move(Move::EndReached))).then_some(()))?;
        let over = Event::Told(Said::Move(Move::Finished { requested: false }));
        self.wait("word that it is over", |event| (*event == over).then_some(()))?;
        assert_eq!(self.ends, ends + 1, "it was said to be at its end");
        Ok(())
    }

    /// Stops everything, however long it takes; then nothing moves any more.
    fn recover(&mut self) {
        let until = self.bench.now() + 600_000;
        loop {
            assert!(self.bench.now() < until, "no stop is confirmed");
            let is_ready = |it: &Self| it.bench.scene.host.machine().state() == host::State::Ready;
            while !is_ready(self) {
                assert!(self.bench.now() < until, "no connection");
                self.tick();
                while self.event().is_some() {}
            }
            self.bench.send(host::Command::Stop);
            if self.wait("stop", |event| (*event == Event::Stopped).then_some(())).is_ok() {
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

/// Tries until the move was played to its end; how often it had to begin anew.
fn play(stored: &StoredMove, seed: u64) -> (u32, Watched) {
    let mut watched = Watched::new(stored, seed);
    watched.bench.scene.command(Command::Connect);
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
fn a_move_is_played_whatever_goes_wrong() {
    let (mut anew, mut begun, mut virtual_time) = (0, 0, 0);
    for seed in SEEDS {
        let (tries, watched) = play(&live(Loop::Once), seed);
        anew += tries;
        begun += watched.begins;
        virtual_time += watched.bench.now();
        assert!(watched.begins >= watched.ends && watched.begins <= tries + 1, "seed {seed}: a move began by itself");
    }
    println!("{anew} times begun anew, {begun} moves, {} s", virtual_time / 1000);
    assert!(anew > 30, "the faults are too rare to show anything: {anew}");
}

#[test]
fn a_lapse_is_shot_whatever_goes_wrong() {
    for seed in SEEDS {
        let style = if seed % 4 < 2 { Style::ShootMoveShoot } else { Style::Continuous };
        let (tries, watched) = play(&lapse(style, 8, 1), seed);
        let photos = watched.bench.scene.rig.photo_count();
        assert!((10..=10 * (u64::from(tries) + 1)).contains(&photos), "seed {seed}: {photos} photos, {tries} tries");
    }
}

#[test]
fn the_same_seed_gives_the_same_story() {
    let told = |seed| play(&live(Loop::Once), seed).1.bench.trace;
    let (one, same, other): (Vec<(Millis, String)>, _, _) = (told(3), told(3), told(4));
    assert_eq!(one, same);
    assert_ne!(one, other);
}
