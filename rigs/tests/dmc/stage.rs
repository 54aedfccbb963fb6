//! A host and a device on a line, what the host was told, and a look at the motors at each millisecond.

use dmc_proto::device::State;
use dmc_proto::host::{Failure, Stop, Token};
use dmc_proto::message::{
    BloopOutputs, DmxChannel, FrameNumber, FramesPerSecond, HostMessage, JogSpeed, Milliseconds, Motor, MotorJog,
    MotorMove, Motors, RtRunMove, RunFlags, ShortMilliseconds, Steps,
};
use examples::moves::Move;
use motion_core::fixed::Scaled;
use motion_core::time::Millis;
use motion_core::wire::Bool;
use rigs::dmc_device::{DmcDevice, Setup};
use rigs::dmc_host::{Answer, Command, DmcHost, Event, Table};
use rigs::faults::{Carrier, Faults};
use rigs::{Rig as _, Scene};

pub(crate) const EMPTY: dmc_proto::message::Empty<'static> = dmc_proto::message::Empty { tail: &[] };

pub(crate) struct Stage {
    pub(crate) scene: Scene<DmcHost, DmcDevice>,
    /// All that the host told, and when.
    pub(crate) told: Vec<(Millis, Event)>,
    /// How much of it has been waited for.
    seen: usize,
    last: u32,
    /// Most bytes held on the line, in the host and in the device.
    pub(crate) held: usize,
    before: Vec<f64>,
    /// Whether a place gets another number just now.
    renames: bool,
}

impl Stage {
    pub(crate) fn new(setup: Setup, faults: Faults, seed: u64) -> Self {
        let scene = Scene::new(DmcHost::default(), DmcDevice::new(setup), Carrier::Serial, faults, seed);
        Self { scene, told: Vec::new(), seen: 0, last: 0, held: 0, before: Vec::new(), renames: false }
    }

    /// Without faults, and up.
    pub(crate) fn up(setup: Setup) -> Self {
        let mut stage = Self::new(setup, Faults::NONE, 1);
        assert!(stage.wait(5000, |event| matches!(event, Event::Up(_)).then_some(())).is_some());
        stage
    }

    pub(crate) fn now(&self) -> Millis {
        self.scene.now()
    }

    pub(crate) fn rig(&mut self) -> &mut DmcDevice {
        &mut self.scene.rig
    }

    /// A millisecond. No motor jumps in it, unless its power fails.
    pub(crate) fn tick(&mut self) {
        let told = &mut self.told;
        self.scene.run(self.scene.now().after(1), |scene, event| {
            told.push((scene.now(), event));
            None::<()>
        });
        let now = self.scene.now();
        let here: Vec<f64> = self.scene.rig.motors().iter().map(|motor| motor.at(now).position).collect();
        for (here, before) in here.iter().zip(&self.before) {
            let most = Setup::LIMITS.velocity / 1000.0 + 1.0;
            assert!((here - before).abs() <= most || *here == 0.0 || self.renames, "{before} to {here} at {now:?}");
        }
        self.before = here;
        let held = self.scene.held() + self.scene.host.held() + self.scene.rig.held();
        self.held = self.held.max(held);
    }

    pub(crate) fn pass(&mut self, millis: u64) {
        for _ in 0..millis {
            self.tick();
        }
    }

    /// Runs until the host tells something, and at most so many milliseconds.
    pub(crate) fn wait<T>(&mut self, millis: u64, mut look: impl FnMut(&Event) -> Option<T>) -> Option<T> {
        for _ in 0..=millis {
            while let Some((_, event)) = self.told.get(self.seen) {
                self.seen += 1;
                if let Some(found) = look(event) {
                    return Some(found);
                }
            }
            self.tick();
        }
        None
    }

    pub(crate) fn token(&mut self) -> Token {
        self.last += 1;
        Token(self.last)
    }

    /// How something ended, now or before.
    pub(crate) fn end(&mut self, token: Token, millis: u64) -> Result<Answer, Failure> {
        let mut looked = 0;
        for _ in 0..=millis {
            for (_, event) in &self.told[looked..] {
                match event {
                    Event::Done(done, answer) if *done == token => return Ok(answer.clone()),
                    Event::Failed(failed, failure) if *failed == token => return Err(*failure),
                    _ => {}
                }
            }
            looked = self.told.len();
            self.tick();
        }
        panic!("it does not end in {millis} ms")
    }

    /// Asks for something, and waits for how it ends.
    pub(crate) fn ask(&mut self, message: HostMessage<'static>) -> Result<Answer, Failure> {
        let token = self.token();
        self.renames = matches!(message, HostMessage::MotorResetPosition(_));
        self.scene.command(Command::Ask(token, message));
        let answer = self.end(token, 10_000);
        self.tick();
        self.renames = false;
        answer
    }

    /// Begins something that is followed to its end.
    pub(crate) fn begin(&mut self, message: HostMessage<'static>) -> Token {
        let token = self.token();
        self.scene.command(Command::Begin(token, message));
        token
    }

    pub(crate) fn upload(&mut self, table: Table) -> Result<Answer, Failure> {
        let token = self.token();
        self.scene.command(Command::Upload(token, table));
        self.end(token, 60_000)
    }

    /// Begins a run or shot, and starts it once it is ready. What it did until then is in `told`.
    pub(crate) fn start(&mut self, token: Token) -> Result<(), Failure> {
        let ready = self.wait(60_000, |event| match event {
            Event::Ready(ready) if *ready == token => Some(Ok(())),
            Event::Failed(failed, failure) if *failed == token => Some(Err(*failure)),
            _ => None,
        });
        ready.expect("it gets ready in time")?;
        assert_eq!(self.rig().state(), State::Ready);
        assert!(self.all_rest());
        self.scene.command(Command::Go);
        Ok(())
    }

    pub(crate) fn status(&mut self) -> Motors {
        match self.ask(HostMessage::MotorStatus(EMPTY)) {
            Ok(Answer::Moving(motors)) => motors,
            other => panic!("{other:?}"),
        }
    }

    pub(crate) fn at(&self, motor: u8) -> f64 {
        let now = self.scene.now();
        self.scene.rig.motors()[usize::from(motor) - 1].at(now).position
    }

    /// The step that a motor stands on, if it stands on one.
    pub(crate) fn steps(&self, motor: u8) -> Option<i32> {
        let at = self.at(motor);
        #[expect(clippy::cast_possible_truncation, reason = "within its travel")]
        let nearest = at.round() as i32;
        ((at - f64::from(nearest)).abs() < 1e-9).then_some(nearest)
    }

    pub(crate) fn all_rest(&self) -> bool {
        let now = self.scene.now();
        self.scene.rig.motors().iter().all(|motor| motor.at(now).velocity == 0.0 && motor.rests())
    }

    pub(crate) fn stop(&mut self) -> bool {
        self.scene.command(Command::Stop(Stop::All));
        self.wait(5000, |event| matches!(event, Event::Stopped(Stop::All)).then_some(())).is_some()
    }
}

pub(crate) fn move_to(motor: u8, position: i32) -> HostMessage<'static> {
    HostMessage::MotorMove(MotorMove { motor: Motor(motor), position: Steps(position), tail: &[] })
}

pub(crate) fn jog(motor: u8, percent: u16, destination: i32) -> HostMessage<'static> {
    let speed = JogSpeed(Scaled(percent * 100));
    HostMessage::MotorJog(MotorJog { motor: Motor(motor), speed, destination: Steps(destination), tail: &[] })
}

pub(crate) fn run(fps_x1000: u32, start: i32, end: i32, roll_ms: u32, flags: RunFlags) -> HostMessage<'static> {
    HostMessage::RtRunMove(RtRunMove {
        fps_x1000: FramesPerSecond(Scaled(fps_x1000)),
        start_frame: FrameNumber(start),
        end_frame: FrameNumber(end),
        pre_roll_ms: Milliseconds(roll_ms),
        post_roll_ms: Milliseconds(roll_ms),
        sync_dmx: Bool::FALSE,
        bloop_location: BloopOutputs::empty(),
        bloop_dmx_channel: DmxChannel(0),
        bloop_ms: ShortMilliseconds(0),
        flags: Some(flags),
        open_angle: None,
        close_angle: None,
        tail: &[],
    })
}

/// A sample move, and what is uploaded of it, from frame 1 on.
pub(crate) fn sample(name: &str) -> (Move, Table) {
    let path = format!("{}/../examples/moves/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let sample = Move::read(path.as_ref()).unwrap();
    let mut table = Table::new(FrameNumber(1), sample.frames.count);
    for axis in &sample.axes {
        let Some(dmc) = axis.dmc else { continue };
        let steps = axis.curve().steps(sample.frames, dmc.scale).collect::<Result<Vec<_>, _>>().unwrap();
        table = table.with(Motor(dmc.motor), steps);
    }
    (sample, table)
}
