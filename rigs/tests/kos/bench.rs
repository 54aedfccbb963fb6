//! Client and device in a scene, looked at from tick to tick.

use std::collections::VecDeque;

use kos_proto::device::motor::{Drive, State};
use kos_proto::device::playback;
use kos_proto::host::{self, Go, Move, Outcome, StopTarget, Token};
use kos_proto::message::{
    Direction, MotorAddress, Normalized, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds,
};
use kos_proto::trajectory::bezier::{Ease, Key, Segment};
use kos_proto::trajectory::{Delay, LiveMotion, Loop, MotorPlan, Plan, Play, Style, TimeLapseMotion, Way};
use motion_core::time::Millis;
use motion_rigs::faults::{Carrier, Faults};
use motion_rigs::kos_device::{KosDevice, Setup};
use motion_rigs::kos_host::{Command, Event, KosHost, StoredMove};
use motion_rigs::{Rig as _, Scene};

/// Greatest distance of a motor from the planned curve, in rotations.
///
/// Positions on the wire are `f32`: parts of the range are exact to 6e-8, and rotations up to 64 to 4e-6. This is the
/// sum of at most ten such roundings.
pub(crate) const TOLERANCE: f64 = 5e-5;

pub(crate) const M1: MotorAddress = MotorAddress(1);
pub(crate) const M2: MotorAddress = MotorAddress(2);

/// Length of the range of each motor. The range of the second motor goes backward.
pub(crate) const RANGES: [f64; 2] = [40.0, -12.0];

pub(crate) struct Bench {
    pub(crate) scene: Scene<KosHost, KosDevice>,
    /// Events of the client that no test has looked at.
    events: VecDeque<Event>,
    /// All events of the client, with their times.
    pub(crate) trace: Vec<(Millis, String)>,
    last: Token,
}

impl Bench {
    pub(crate) fn with(
        setup: Setup,
        options: host::Options,
        password: Option<&[u8]>,
        faults: Faults,
        seed: u64,
    ) -> Self {
        let (host, rig) = (KosHost::new(options, password), KosDevice::new(setup));
        let scene = Scene::new(host, rig, Carrier::Stream, faults, seed);
        Self { scene, events: VecDeque::new(), trace: Vec::new(), last: Token(0) }
    }

    /// Client that is ready, and its device.
    pub(crate) fn ready(setup: Setup) -> Self {
        let mut bench = Self::with(setup, host::Options::default(), None, Faults::NONE, 1);
        bench.connect();
        bench
    }

    /// Client that is ready, and a device of two motors whose ranges are marked.
    pub(crate) fn calibrated() -> Self {
        Self::ready(Setup::with_motors(2)).with_ranges()
    }

    pub(crate) fn with_ranges(mut self) -> Self {
        self.calibrate(M1, RANGES[0]);
        self.calibrate(M2, RANGES[1]);
        self
    }

    pub(crate) fn connect(&mut self) {
        self.command(Command::Connect);
        self.expect_event(|event| matches!(event, host::Event::Ready { .. }));
    }

    pub(crate) fn now(&self) -> u64 {
        self.scene.now().0
    }

    /// Lets a millisecond pass.
    pub(crate) fn tick(&mut self) {
        self.pass(1);
    }

    /// Lets some time pass, without a look at what happens meanwhile.
    pub(crate) fn pass(&mut self, millis: u64) {
        let until = self.scene.now().after(millis);
        let (events, trace) = (&mut self.events, &mut self.trace);
        self.scene.run(until, |scene, event| {
            trace.push((scene.now(), format!("{event:?}")));
            events.push_back(event);
            None::<()>
        });
    }

    pub(crate) fn event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// Waits for an event, for two minutes at most.
    pub(crate) fn wait<T>(&mut self, mut look: impl FnMut(&Event) -> Option<T>) -> T {
        for _ in 0..120_000 {
            while let Some(event) = self.event() {
                if let Some(found) = look(&event) {
                    return found;
                }
            }
            self.tick();
        }
        panic!("the event did not come: {:#?}", self.trace);
    }

    pub(crate) fn expect_event(&mut self, look: impl Fn(&host::Event<'_>) -> bool) {
        self.wait(|event| matches!(event, Event::Machine(event) if look(event)).then_some(()));
    }

    pub(crate) fn expect_move(&mut self, wanted: Move) {
        self.expect_event(|event| *event == host::Event::Move(wanted));
    }

    /// Gives a command, and returns its token.
    pub(crate) fn command(&mut self, command: Command) -> Token {
        self.last.0 += 1;
        self.scene.command((self.last, command));
        self.last
    }

    pub(crate) fn send(&mut self, command: host::Command) -> Token {
        self.command(Command::Machine(command))
    }

    /// Waits for the end of a command.
    pub(crate) fn end(&mut self, token: Token) -> Outcome<'static> {
        self.wait(|event| match event {
            Event::Machine(host::Event::Ended { token: ended, outcome }) if *ended == token => Some(*outcome),
            _ => None,
        })
    }

    /// Gives a command, and waits until it is done.
    pub(crate) fn done(&mut self, command: host::Command) {
        let token = self.send(command);
        assert_eq!(self.end(token), Outcome::Done(None), "{command:?}");
    }

    /// Stops everything, and waits until the device confirmed it.
    pub(crate) fn stop(&mut self) {
        self.send(host::Command::Stop);
        self.expect_event(|event| *event == host::Event::Stopped(StopTarget::All));
        assert!(self.rests() && !self.may_move());
    }

    /// Whether the client says that something may move because of it.
    pub(crate) fn may_move(&self) -> bool {
        self.scene.host.machine().may_move()
    }

    /// Whether all motors rest.
    pub(crate) fn rests(&self) -> bool {
        let now = self.scene.now();
        self.scene.rig.motors().iter().all(|motor| motor.at(now).velocity == 0.0)
    }

    /// Position of a motor, as the rig counts.
    pub(crate) fn at(&self, motor: MotorAddress) -> f64 {
        self.scene.rig.motors()[usize::from(motor.0) - 1].at(self.scene.now()).position
    }

    /// State of the range of a motor.
    pub(crate) fn calibration(&self, motor: MotorAddress) -> Option<State> {
        self.scene.rig.machine().motor(motor).map(Drive::state)
    }

    pub(crate) fn bump(&mut self, motor: MotorAddress, by: f64) {
        self.done(host::Command::Bump(go(motor, by)));
    }

    /// Marks a range that begins where the motor is.
    pub(crate) fn calibrate(&mut self, motor: MotorAddress, length: f64) {
        self.send(host::Command::ResetAxis(motor));
        self.expect_event(|event| *event == host::Event::Motors);
        self.send(host::Command::MarkBegin(motor));
        self.bump(motor, length);
        self.done(host::Command::MarkEnd(motor));
    }

    /// Stores a move, and waits until it can be played.
    pub(crate) fn load(&mut self, stored: StoredMove) {
        let token = self.command(Command::Load { stored, delay_return: false });
        assert_eq!(self.end(token), Outcome::Done(None));
    }

    /// Whether the motors follow the curves of the move now.
    pub(crate) fn plays(&self) -> bool {
        use playback::State;
        matches!(self.scene.rig.machine().playback(), State::Forward | State::Reverse | State::ForwardC)
    }
}

#[expect(clippy::cast_possible_truncation, reason = "positions on the wire are f32")]
pub(crate) fn go(motor: MotorAddress, position: f64) -> Go {
    let (speed, acceleration) = (RotationsPerSecond(20.0), RotationsPerSecondSquared(50.0));
    Go { motor, position: Rotations(position as f32), speed, acceleration }
}

/// Key frames of both motors, in rotations from the begin of the range.
pub(crate) fn keys() -> [Vec<Key>; 2] {
    let key = |time, position| Key { time, position, arrive: Ease::Flat(0.4), leave: Ease::Flat(0.4) };
    let through = Key { arrive: Ease::Linear, leave: Ease::Linear, ..key(2.0, -5.0) };
    [vec![key(0.0, 2.0), key(3.0, 38.0), key(5.0, 10.5)], vec![key(0.0, -1.0), through, key(5.0, -11.0)]]
}

/// Planned position of a motor, as the rig counts.
pub(crate) fn planned(motor: MotorAddress, begin: f64, seconds: f64) -> f64 {
    let keys = &keys()[usize::from(motor.0) - 1];
    let pair = keys.windows(2).rfind(|pair| pair[0].time <= seconds).unwrap_or(&keys[..2]);
    begin + Segment::between(&pair[0], &pair[1]).unwrap().position(seconds)
}

#[expect(clippy::cast_possible_truncation, reason = "positions on the wire are f32")]
pub(crate) fn stored(play: Play) -> StoredMove {
    let keys = keys();
    let range = |motor: usize| Rotations(RANGES[motor] as f32);
    let motors = [(M1, 0), (M2, 1)].map(|(motor, index)| {
        let scale = play.move_time() / 5.0;
        let keys: Vec<Key> = keys[index].iter().map(|key| Key { time: key.time * scale, ..*key }).collect();
        (motor, range(index), keys)
    });
    let plans: Vec<MotorPlan<'_>> = motors
        .iter()
        .map(|(motor, range, keys)| MotorPlan { motor: *motor, way: Way::Keys { range: *range, keys } })
        .collect();
    StoredMove::of(&Plan::new(play, &plans)).unwrap()
}

/// Live move of five seconds.
pub(crate) fn live(repeat: Loop) -> StoredMove {
    let home_speed = Normalized(0.2);
    stored(Play::Live(LiveMotion { duration: Seconds(5.0), repeat, delay: Delay::None, home_speed }))
}

/// Time lapse with the same key frames.
pub(crate) fn lapse(style: Style, photos: u32, around: u32) -> StoredMove {
    stored(Play::TimeLapse(TimeLapseMotion {
        style,
        interval: Seconds(0.4),
        exposure: Seconds(0.1),
        photos,
        photos_before: around,
        photos_after: around,
        delay: Delay::None,
        home_speed: Normalized(0.2),
    }))
}

pub(crate) fn play(bench: &mut Bench, stored: StoredMove) {
    bench.load(stored);
    bench.send(host::Command::Play);
    bench.expect_move(Move::Running(Direction::Forward));
}

/// Small whole number as `f64`.
pub(crate) fn number(number: impl TryInto<u32>) -> f64 {
    f64::from(number.try_into().ok().expect("a small number"))
}
