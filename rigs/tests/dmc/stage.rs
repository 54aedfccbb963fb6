//! Host and device on a line, the events of the host, and a check of the motors at each millisecond.

use dmc_proto::Token;
use dmc_proto::device::{Quirks, State};
use dmc_proto::host::{self, Outcome, StopTarget};
use dmc_proto::message::{
    FrameNumber, FramesPerSecond, HostMessage, JogSpeed, Milliseconds, Motor, MotorJog, MotorMove, MotorStatusRequest,
    Motors, RtRunMove, RunFlags, Scaled, Steps,
};
use motion_core::time::Millis;
use motion_move::Move;
use motion_rigs::device::Named;
use motion_rigs::dmc_device::{DmcDevice, Setup};
use motion_rigs::dmc_host::{Answer, Command, DmcHost, Event, Table};
use motion_rigs::faults::{Carrier, Faults};
use motion_rigs::{Rig as _, Scene};

pub(crate) struct Stage {
    pub(crate) scene: Scene<DmcHost, DmcDevice>,
    /// Events of the host, with their times.
    pub(crate) told: Vec<(Millis, Event)>,
    /// Number of events that `wait` has looked at.
    seen: usize,
    last: u32,
    /// Greatest number of bytes held on the line, in the host and in the device.
    pub(crate) held: usize,
    before: Vec<f64>,
    /// Whether the position of a motor gets another number at the moment.
    renames: bool,
}

impl Stage {
    pub(crate) fn new(setup: Setup, faults: Faults, seed: u64) -> Self {
        let scene = Scene::new(DmcHost::default(), DmcDevice::new(setup), Carrier::Serial, faults, seed);
        Self { scene, told: Vec::new(), seen: 0, last: 0, held: 0, before: Vec::new(), renames: false }
    }

    /// Stage without faults, whose host is ready.
    pub(crate) fn up(setup: Setup) -> Self {
        let mut stage = Self::new(setup, Faults::NONE, 1);
        assert!(stage.wait(5000, |event| is_ready(event).then_some(())).is_some());
        stage
    }

    pub(crate) fn now(&self) -> Millis {
        self.scene.now()
    }

    pub(crate) fn rig(&mut self) -> &mut DmcDevice {
        &mut self.scene.rig
    }

    /// Advances by a millisecond. No motor jumps, unless its power fails. If the host or the rig says that nothing may move,
    /// nothing moves.
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
        let know = self.scene.host.may_move() && self.scene.rig.machine().may_move();
        assert!(know || self.all_rest(), "at {now:?} a motor moves, and the host or the rig does not know");
        let held = self.scene.held() + self.scene.host.held() + self.scene.rig.held();
        self.held = self.held.max(held);
    }

    pub(crate) fn pass(&mut self, millis: u64) {
        for _ in 0..millis {
            self.tick();
        }
    }

    /// Runs until an event that `look` takes, or for a number of milliseconds.
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

    /// End of a command, which may have come already.
    pub(crate) fn end(&mut self, token: Token, millis: u64) -> Result<Answer, Outcome<'static>> {
        let mut looked = 0;
        for _ in 0..=millis {
            if let Some(end) = self.told[looked..].iter().find_map(|(_, event)| end_of(token, event)) {
                return end;
            }
            looked = self.told.len();
            self.tick();
        }
        panic!("{token:?} does not end in {millis} ms")
    }

    /// Sends a request, and waits for its end.
    pub(crate) fn ask(&mut self, message: impl Into<HostMessage<'static>>) -> Result<Answer, Outcome<'static>> {
        let (token, message) = (self.token(), message.into());
        self.renames = matches!(message, HostMessage::MotorResetPosition(_));
        self.scene.command(Command::Ask(token, message));
        let answer = self.end(token, 10_000);
        self.tick();
        self.renames = false;
        answer
    }

    /// Begins a sequence.
    pub(crate) fn begin(&mut self, message: impl Into<HostMessage<'static>>) -> Token {
        let token = self.token();
        self.scene.command(Command::Begin(token, message.into()));
        token
    }

    pub(crate) fn upload(&mut self, table: Table) -> Result<Answer, Outcome<'static>> {
        let token = self.token();
        self.scene.command(Command::Upload(token, table));
        self.end(token, 60_000)
    }

    /// Starts a run or a shot as soon as it is armed.
    pub(crate) fn start(&mut self, token: Token) {
        let armed = Event::Machine(host::Event::Armed(token));
        self.wait(60_000, |event| (*event == armed).then_some(())).expect("it is armed in time");
        assert_eq!(self.rig().machine().state(), State::Ready);
        assert!(self.all_rest());
        self.scene.command(Command::Go);
    }

    pub(crate) fn status(&mut self) -> Motors {
        match self.ask(MotorStatusRequest::default()) {
            Ok(Answer::Moving(motors)) => motors,
            other => panic!("{other:?}"),
        }
    }

    pub(crate) fn at(&self, motor: u8) -> f64 {
        let now = self.scene.now();
        self.scene.rig.motors()[usize::from(motor) - 1].at(now).position
    }

    /// Step on which a motor stands; `None` between two steps.
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

    /// Stops everything. Returns whether the stop is confirmed.
    pub(crate) fn stop(&mut self) -> bool {
        self.scene.command(Command::Stop(StopTarget::All));
        self.wait(5000, |event| (*event == STOPPED).then_some(())).is_some()
    }

    /// Waits until the host knows that nothing moves.
    pub(crate) fn rests(&mut self) -> bool {
        (0..3000).any(|_| {
            self.tick();
            !self.scene.host.may_move()
        })
    }
}

/// Setups of all devices that have a name, and their quirks.
pub(crate) fn devices() -> impl Iterator<Item = (Setup, Quirks)> {
    Setup::DEVICES.iter().map(|device| {
        let setup = Setup::default().with_device(device.name).expect("a name of the list");
        let quirks = setup.options.quirks();
        (setup, quirks)
    })
}

/// Frame on which a device rests after a run that ends at a frame.
pub(crate) fn end_frame(quirks: Quirks, frame: i32) -> FrameNumber {
    FrameNumber(frame + i32::from(quirks.contains(Quirks::RESTS_BEYOND)))
}

/// Event that a stop of everything is confirmed.
pub(crate) const STOPPED: Event = Event::Machine(host::Event::Stopped(StopTarget::All));

/// Whether the host is ready.
pub(crate) const fn is_ready(event: &Event) -> bool {
    matches!(event, Event::Machine(host::Event::Ready { .. }))
}

/// End of this command, if the event tells it.
pub(crate) fn end_of(token: Token, event: &Event) -> Option<Result<Answer, Outcome<'static>>> {
    match event {
        Event::Ended(ended, end) if *ended == token => Some(end.clone()),
        _ => None,
    }
}

pub(crate) fn move_to(motor: u8, position: i32) -> MotorMove<'static> {
    MotorMove { motor: Motor(motor), position: Steps(position), tail: &[] }
}

pub(crate) fn jog(motor: u8, percent: u16, destination: i32) -> MotorJog<'static> {
    let speed = JogSpeed(Scaled(percent * 100));
    MotorJog { motor: Motor(motor), speed, destination: Steps(destination), tail: &[] }
}

pub(crate) fn run(fps_x1000: u32, start: i32, end: i32, roll_ms: u32, flags: RunFlags) -> RtRunMove<'static> {
    RtRunMove {
        fps_x1000: FramesPerSecond(Scaled(fps_x1000)),
        start_frame: FrameNumber(start),
        end_frame: FrameNumber(end),
        pre_roll_ms: Milliseconds(roll_ms),
        post_roll_ms: Milliseconds(roll_ms),
        flags: Some(flags),
        ..RtRunMove::default()
    }
}

/// Sample move, and its steps for an upload, from frame 1 on.
pub(crate) fn sample(name: &str) -> (Move, Table) {
    let path = format!("{}/../examples/moves/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let sample = Move::read(path.as_ref()).unwrap();
    let mut table = Table::new(FrameNumber(1), sample.frames().count);
    for axis in sample.axes() {
        let Some(dmc) = axis.dmc() else { continue };
        let steps = axis.curve().steps(sample.frames(), dmc.scale).collect::<Result<Vec<_>, _>>().unwrap();
        table = table.with(Motor(dmc.motor), steps);
    }
    (sample, table)
}
