//! Host and device with all faults: nothing is reported as done that is not done, and nothing moves after a stop.

use std::collections::BTreeMap;

use dmc_proto::Token;
use dmc_proto::device::{Quirks, State};
use dmc_proto::host::{self, Outcome, StopTarget};
use dmc_proto::message::{FrameNumber, Motor, RunFlags};
use motion_move::Move;
use motion_rigs::device::Named;
use motion_rigs::dmc_device::Setup;
use motion_rigs::dmc_host::{Answer, Command, Event, Shot, Table};
use motion_rigs::faults::{Carrier, Faults};

use super::runs::hold;
use super::stage::{STOPPED, Stage, end_frame, end_of, jog, move_to, run, sample};

/// Time in which everything comes to rest after a stop, in milliseconds.
const REST: u64 = 2000;

/// Application that works through its list in spite of all faults, and checks the motors all the time.
struct Play {
    stage: Stage,
    sample: Move,
    table: Table,
    /// Number of times that each command was done, and was not.
    ended: BTreeMap<&'static str, (u32, u32)>,
    quirks: Quirks,
}

impl Play {
    fn new(setup: Setup, faults: Faults, seed: u64) -> Self {
        let (sample, table) = sample("slide");
        let quirks = setup.options.quirks();
        let stage = Stage::new(setup, faults, seed);
        Self { stage, sample, table, ended: BTreeMap::new(), quirks }
    }

    /// Advances by a millisecond. The motors of a run are where the move has them.
    fn tick(&mut self) {
        self.stage.tick();
        hold(&self.stage, &self.sample);
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

    /// Waits until the host is ready.
    fn up(&mut self) {
        for _ in 0..100 {
            match self.stage.scene.host.machine().state() {
                host::State::Ready => return,
                host::State::Silent => self.stage.scene.command(Command::Greet),
                _ => {}
            }
            self.pass(1000);
        }
        panic!("the host does not get ready");
    }

    /// Gives a command, starts its run or shot when it is armed, and stops if it is not done.
    fn doing(
        &mut self,
        name: &'static str,
        command: impl FnOnce(Token) -> Command,
    ) -> Result<Answer, Outcome<'static>> {
        self.up();
        let token = self.stage.token();
        let looked = self.stage.told.len();
        self.stage.scene.command(command(token));
        let armed = Event::Machine(host::Event::Armed(token));
        let mut ended = None;
        for _ in 0..120_000 {
            ended = self.stage.told[looked..].iter().find_map(|(_, event)| end_of(token, event));
            if ended.is_some() {
                break;
            }
            self.tick();
            if self.stage.told.last().is_some_and(|(when, event)| *event == armed && *when == self.stage.now()) {
                self.stage.scene.command(Command::Go);
            }
        }
        let ended = ended.expect("everything ends");
        let count = self.ended.entry(name).or_default();
        if ended.is_ok() {
            count.0 += 1;
        } else {
            count.1 += 1;
            self.stop();
        }
        ended
    }

    /// Stops, and waits until the stop is confirmed. Then everything comes to rest, and nothing begins.
    fn stop(&mut self) {
        self.stage.scene.command(Command::Stop(StopTarget::All));
        let stopped = |event: &Event| (*event == STOPPED).then_some(());
        let confirmed = (0..60).any(|_| {
            if self.stage.scene.host.machine().state() == host::State::Silent {
                self.stage.scene.command(Command::Greet);
            }
            self.wait(1000, stopped).is_some()
        });
        assert!(confirmed, "a stop is confirmed in the end");
        self.pass(REST);
        assert!(self.stage.all_rest());
        self.pass(500);
        assert!(self.stage.all_rest());
        assert!(matches!(self.stage.rig().machine().state(), State::Idle | State::Locked));
    }

    /// Works through the whole list once.
    fn list(&mut self) {
        let table = self.table.clone();
        if self.doing("upload", |token| Command::Upload(token, table)).is_ok() {
            assert!(self.stage.rig().machine().is_loaded());
            for frame in (1..=193).map(FrameNumber) {
                let stored = self.stage.rig().uploaded(Motor(1), frame).map(|steps| steps.0);
                assert_eq!(stored, self.table.steps(Motor(1), frame));
            }
        }
        let photos = self.stage.rig().photo_count();
        for (name, from, to) in [("run", 20, 80), ("back", 80, 50)] {
            let run = run(24_000, from, to, 300, RunFlags::empty());
            if self.doing(name, |token| Command::Begin(token, run.into())).is_ok() {
                assert_eq!(self.stage.rig().machine().on_frame(), Some(end_frame(self.quirks, to)));
            }
        }
        let shot = Shot::of(FrameNumber(60), 200);
        if self.doing("shot", |token| Command::Shoot(token, shot)).is_ok() {
            assert_eq!(self.stage.rig().photo_count(), photos + 1);
            let photo = *self.stage.rig().photos().last().unwrap();
            assert_eq!((photo.frame, photo.until.map(|until| until.since(photo.at))), (Some(60), Some(200)));
        }
        if self.doing("move", |token| Command::Ask(token, move_to(2, 9000).into())).is_ok() {
            self.pass(300);
            self.stop();
        }
        if self.doing("jog", |token| Command::Ask(token, jog(1, 30, 0).into())).is_ok() {
            self.pass(300);
            self.stop();
        }
    }
}

#[test]
fn with_all_faults_nothing_is_reported_that_is_not_so() {
    let mut ended: BTreeMap<&str, (u32, u32)> = BTreeMap::new();
    for seed in 0..24 {
        let device = &Setup::DEVICES[usize::try_from(seed).unwrap() % Setup::DEVICES.len()];
        let setup = Setup::default().with_device(device.name).unwrap().with_frames(1000);
        let mut play = Play::new(setup, Faults::all(Carrier::Serial), seed);
        play.list();
        play.list();
        assert!(play.stage.held < 16_384, "{} bytes", play.stage.held);
        for (name, (done, failed)) in play.ended {
            let count = ended.entry(name).or_default();
            *count = (count.0 + done, count.1 + failed);
        }
    }
    println!("done and not done: {ended:?}");
    for name in ["upload", "run", "back", "shot", "move", "jog"] {
        assert!(ended[name].0 >= 5, "{name}: {ended:?}");
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
fn with_each_fault_alone_everything_ends() {
    for name in ["loss", "duplication", "corruption", "garbage", "cutting", "delay", "silence", "reset=20", "stall=5"] {
        let faults = Faults::parse(name, Carrier::Serial).unwrap();
        let mut play = Play::new(Setup::default().with_frames(1000), faults, 11);
        play.list();
        let is_harmless = ["duplication", "cutting", "delay"].contains(&name);
        let failed = play.ended.values().map(|(_, failed)| failed).sum::<u32>();
        assert!(!is_harmless || failed == 0, "{name}: {:?}", play.ended);
    }
}
