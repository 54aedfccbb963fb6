//! The same with all that can go wrong: nothing is told as done that is not, and nothing moves behind a stop.

use std::collections::BTreeMap;

use dmc_proto::device::{Quirks, State};
use dmc_proto::host::{self, Failure, Stop};
use dmc_proto::message::{FrameNumber, Motor, RunFlags};
use examples::moves::Move;
use rigs::dmc_device::Setup;
use rigs::dmc_host::{Answer, Command, Event, Shot, Table};
use rigs::faults::{Carrier, Faults};

use super::runs::hold;
use super::stage::{Stage, jog, move_to, run, sample};

/// Milliseconds in which everything comes to rest that is told to.
const REST: u64 = 2000;

/// An application that goes through its list, come what may, and looks at the motors all the time.
struct Play {
    stage: Stage,
    sample: Move,
    table: Table,
    /// Milliseconds since the host held something for moving.
    quiet: u64,
    /// How often what was done, and failed.
    ended: BTreeMap<&'static str, (u32, u32)>,
}

impl Play {
    fn new(setup: Setup, faults: Faults, seed: u64) -> Self {
        let (sample, table) = sample("slide");
        let stage = Stage::new(setup, faults, seed);
        Self { stage, sample, table, quiet: 0, ended: BTreeMap::new() }
    }

    /// A millisecond. The motors of a run are where the move has them; and what the host takes for resting, rests.
    fn tick(&mut self) {
        self.stage.tick();
        hold(&self.stage, &self.sample);
        self.quiet = if self.stage.scene.host.may_move() { 0 } else { self.quiet + 1 };
        assert!(
            self.quiet < REST || self.stage.all_rest(),
            "moves at {:?}, and the host does not know",
            self.stage.now()
        );
    }

    fn wait<T>(&mut self, millis: u64, look: impl Fn(&Event) -> Option<T>) -> Option<T> {
        let mut looked = self.stage.told.len();
        for _ in 0..millis {
            self.tick();
            let found = self.stage.told[looked..].iter().find_map(|(_, event)| look(event));
            if found.is_some() {
                return found;
            }
            looked = self.stage.told.len();
        }
        None
    }

    fn pass(&mut self, millis: u64) {
        (0..millis).for_each(|_| self.tick());
    }

    /// Waits until the host is up.
    fn up(&mut self) {
        for _ in 0..100 {
            match self.stage.scene.host.state() {
                host::State::Up => return,
                host::State::Silent => self.stage.scene.command(Command::Greet),
                _ => {}
            }
            self.pass(1000);
        }
        panic!("it never comes up");
    }

    /// Asks for something, starts it when it is ready, and stops if it fails.
    fn doing(&mut self, what: &'static str, command: impl FnOnce(host::Token) -> Command) -> Result<Answer, Failure> {
        self.up();
        let token = self.stage.token();
        let looked = self.stage.told.len();
        self.stage.scene.command(command(token));
        let mut ended = None;
        for _ in 0..120_000 {
            for at in looked..self.stage.told.len() {
                match &self.stage.told[at].1 {
                    Event::Done(done, answer) if *done == token => ended = Some(Ok(answer.clone())),
                    Event::Failed(failed, failure) if *failed == token => ended = Some(Err(*failure)),
                    _ => {}
                }
            }
            if ended.is_some() {
                break;
            }
            self.tick();
            let is_ready = Event::Ready(token);
            if self.stage.told.last().is_some_and(|(when, event)| *event == is_ready && *when == self.stage.now()) {
                self.stage.scene.command(Command::Go);
            }
        }
        let ended = ended.expect("everything ends");
        let count = self.ended.entry(what).or_default();
        if ended.is_ok() {
            count.0 += 1;
        } else {
            count.1 += 1;
            self.stop();
        }
        ended
    }

    /// Stops until it is confirmed. Then everything comes to rest, and nothing begins.
    fn stop(&mut self) {
        self.stage.scene.command(Command::Stop(Stop::All));
        let stopped = |event: &Event| matches!(event, Event::Stopped(Stop::All)).then_some(());
        let confirmed = (0..60).any(|_| {
            if self.stage.scene.host.state() == host::State::Silent {
                self.stage.scene.command(Command::Greet);
            }
            self.wait(1000, stopped).is_some()
        });
        assert!(confirmed, "a stop is confirmed in the end");
        self.pass(REST);
        assert!(self.stage.all_rest());
        self.pass(500);
        assert!(self.stage.all_rest());
        assert!(matches!(self.stage.rig().state(), State::Idle | State::Locked));
    }

    /// The whole list, once.
    fn list(&mut self) {
        let table = self.table.clone();
        if self.doing("upload", |token| Command::Upload(token, table)).is_ok() {
            assert!(self.stage.rig().is_loaded());
            for frame in (1..=193).map(FrameNumber) {
                let stored = self.stage.rig().uploaded(Motor(1), frame).map(|steps| steps.0);
                assert_eq!(stored, self.table.steps(Motor(1), frame));
            }
        }
        let photos = self.stage.rig().photo_count();
        for (what, from, to) in [("run", 20, 80), ("back", 80, 50)] {
            let run = run(24_000, from, to, 300, RunFlags::empty());
            if self.doing(what, |token| Command::Begin(token, run)).is_ok() {
                assert_eq!(self.stage.rig().on_frame(), Some(FrameNumber(to)));
            }
        }
        let shot = Shot::of(FrameNumber(60), 200);
        if self.doing("shot", |token| Command::Shoot(token, shot)).is_ok() {
            assert_eq!(self.stage.rig().photo_count(), photos + 1);
            let photo = *self.stage.rig().photos().last().unwrap();
            assert_eq!((photo.frame, photo.until.map(|until| until.since(photo.at))), (Some(60), Some(200)));
        }
        if self.doing("move", |token| Command::Ask(token, move_to(2, 9000))).is_ok() {
            self.pass(300);
            self.stop();
        }
        if self.doing("jog", |token| Command::Ask(token, jog(1, 30, 0))).is_ok() {
            self.pass(300);
            self.stop();
        }
    }
}

#[test]
fn with_every_fault_nothing_is_told_that_is_not_so() {
    let mut ended: BTreeMap<&str, (u32, u32)> = BTreeMap::new();
    for seed in 0..24 {
        let quirks = if seed % 3 == 2 { Quirks::VENDOR } else { Quirks::empty() };
        let setup = Setup::default().with_quirks(quirks).with_frames(1000);
        let mut play = Play::new(setup, Faults::all(Carrier::Serial), seed);
        play.list();
        play.list();
        assert!(play.stage.held < 16_384, "{} bytes", play.stage.held);
        for (what, (done, failed)) in play.ended {
            let count = ended.entry(what).or_default();
            *count = (count.0 + done, count.1 + failed);
        }
    }
    println!("done and failed: {ended:?}");
    for what in ["upload", "run", "back", "shot", "move", "jog"] {
        assert!(ended[what].0 >= 5, "{what}: {ended:?}");
    }
    assert!(ended.values().map(|(_, failed)| failed).sum::<u32>() >= 10, "{ended:?}");
}

#[test]
fn the_same_seed_gives_the_same_hour() {
    let trace = |seed| {
        let mut play = Play::new(Setup::default().with_frames(1000), Faults::all(Carrier::Serial), seed);
        play.list();
        let places: Vec<_> = (1..=4).map(|motor| play.stage.at(motor).to_bits()).collect();
        (play.stage.told, places)
    };
    assert_eq!(trace(5), trace(5));
    assert_ne!(trace(5), trace(6));
}

#[test]
fn each_fault_alone_is_survived() {
    for name in ["loss", "duplication", "corruption", "garbage", "cutting", "delay", "silence", "reset=20", "stall=5"] {
        let faults = Faults::parse(name, Carrier::Serial).unwrap();
        let mut play = Play::new(Setup::default().with_frames(1000), faults, 11);
        play.list();
        let is_harmless = ["duplication", "cutting", "delay"].contains(&name);
        let failed = play.ended.values().map(|(_, failed)| failed).sum::<u32>();
        assert!(!is_harmless || failed == 0, "{name}: {:?}", play.ended);
    }
}
