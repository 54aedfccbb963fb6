//! Stage that the tests share: a master and a node, and short names for frequent messages.

use hoot_proto::device::ProgramState;
use hoot_proto::host::{self, Command, Request, StopTarget, Token};
use hoot_proto::message::{
    self, Direction, Easing, Milliseconds, Motor, MotorPosition, MotorRunning, ProgramMode, RunStatus, ShortShots,
    ShortSpan, Span, StepCount, Steps, StepsPerSecond, StepsPerSecondSquared,
};
use hoot_proto::program::Plan;
use hoot_proto::query::Answer;
use hoot_proto::{Address, HostMessage, Query};
use motion_core::time::Millis;
use motion_rigs::faults::{Carrier, Faults};
use motion_rigs::hoot_master::{Ended, Event, HootMaster};
use motion_rigs::hoot_node::{HootNode, Setup};
use motion_rigs::{Rig, Scene};

pub(crate) const NODE: Address = Address::DEFAULT;
pub(crate) const ONE: Motor = Motor::One;

/// Master and rig, and what happened.
pub(crate) struct Stage<R> {
    pub(crate) scene: Scene<HootMaster, R>,
    /// Events of the machine, except the ends of commands, with their times.
    pub(crate) events: Vec<(u64, host::Event<'static>)>,
    pub(crate) ended: Vec<Ended>,
    token: u32,
    /// Whether bits stay right. Only then no message becomes another one, which may move something.
    is_exact: bool,
}

/// Stage with one node, on a line without faults.
pub(crate) fn stage(setup: Setup) -> Stage<HootNode> {
    Stage::new(HootNode::new(setup), Faults::NONE, 1)
}

impl<R: Rig> Stage<R> {
    pub(crate) fn new(rig: R, faults: Faults, seed: u64) -> Self {
        let scene = Scene::new(HootMaster::new(host::Options::new()), rig, Carrier::Serial, faults, seed);
        let is_exact = faults.corruption == 0.0;
        let mut stage = Self { scene, events: Vec::new(), ended: Vec::new(), token: 0, is_exact };
        stage.pass(10);
        assert_eq!(stage.events.first().map(|(_, event)| *event), Some(host::Event::Ready { reconnected: false }));
        stage
    }

    pub(crate) fn now(&self) -> u64 {
        self.scene.now().0
    }

    /// Lets a millisecond pass. A motor moves only if the master knows that something may move.
    pub(crate) fn tick(&mut self) {
        let until = self.scene.now().after(1);
        let (events, ended) = (&mut self.events, &mut self.ended);
        self.scene.run(until, |scene, event| {
            match event {
                Event::Machine(event) => events.push((scene.now().0, event)),
                Event::Ended(end) => ended.push(end),
                _ => {}
            }
            None::<()>
        });
        assert!(!self.is_exact || self.is_at_rest() || self.may_move());
    }

    pub(crate) fn pass(&mut self, millis: u64) {
        for _ in 0..millis {
            self.tick();
        }
    }

    pub(crate) fn is_at_rest(&self) -> bool {
        self.scene.rig.motors().iter().all(motion_rigs::motor::Motor::rests)
    }

    /// Whether anything may still move, as the master knows.
    pub(crate) fn may_move(&self) -> bool {
        self.scene.host.machine().may_move()
    }

    /// Whether the machine has told this.
    pub(crate) fn has_event(&self, event: host::Event<'_>) -> bool {
        self.events.iter().any(|(_, told)| *told == event)
    }

    /// Gives a command to the master.
    pub(crate) fn command(&mut self, command: Command) -> Token {
        self.token += 1;
        let token = Token(self.token);
        self.scene.command((token, command));
        token
    }

    /// Sends a message to a node.
    pub(crate) fn send_to(&mut self, to: Address, message: impl Into<HostMessage<'static>>) -> Token {
        self.command(Command::Request(Request { to, message: message.into() }))
    }

    /// Sends a message to a node, and waits until the command ends.
    #[track_caller]
    pub(crate) fn ask_to(&mut self, to: Address, message: impl Into<HostMessage<'static>>) -> Ended {
        let message = message.into();
        let token = self.send_to(to, message);
        for _ in 0..30_000 {
            if let Some(at) = self.ended.iter().position(|ended| ended.token == token) {
                return self.ended.remove(at);
            }
            self.tick();
        }
        panic!("{message} never ended");
    }

    #[track_caller]
    pub(crate) fn ask(&mut self, message: impl Into<HostMessage<'static>>) -> Ended {
        self.ask_to(NODE, message)
    }

    /// Sends a message that the node must do.
    #[track_caller]
    pub(crate) fn ok(&mut self, message: impl Into<HostMessage<'static>>) -> Ended {
        let ended = self.ask(message);
        assert!(ended.is_done(), "{ended}");
        ended
    }

    /// Asks for a value that the node must answer.
    #[track_caller]
    pub(crate) fn read<Q, T>(&mut self, query: Q) -> T
    where
        Q: Into<HostMessage<'static>>,
        for<'a> Q: Query<Reply<'a> = Answer<T>>,
    {
        self.ok(query).read(&query).unwrap()
    }

    #[track_caller]
    pub(crate) fn position(&mut self, motor: Motor) -> i32 {
        self.read(MotorPosition { motor }).0
    }

    #[track_caller]
    pub(crate) fn is_running(&mut self, motor: Motor) -> bool {
        self.read(MotorRunning { motor }).get()
    }

    /// Makes a motor ready to move.
    #[track_caller]
    pub(crate) fn enable(&mut self, motor: Motor, speed: f32) {
        for message in ready(motor, speed) {
            self.ok(message);
        }
    }

    /// Makes an emergency stop, and waits until it is confirmed.
    #[track_caller]
    pub(crate) fn emergency_stop(&mut self) {
        let before = self.events.len();
        self.command(Command::EmergencyStop);
        let stopped = host::Event::Stopped(StopTarget::All);
        for _ in 0..20_000 {
            if self.events[before..].iter().any(|(_, event)| *event == stopped) {
                return;
            }
            self.tick();
        }
        panic!("the stop is never confirmed: {:?}", self.events);
    }
}

impl Stage<HootNode> {
    pub(crate) fn place(&self, motor: usize) -> f64 {
        self.scene.rig.motors()[motor].at(self.scene.now()).position
    }

    pub(crate) fn program(&self) -> ProgramState {
        self.scene.rig.machine().program().state()
    }

    /// Ticks until a condition is true.
    #[track_caller]
    pub(crate) fn until(&mut self, most: u64, mut is_so: impl FnMut(&mut Self) -> bool) {
        let end = self.now() + most;
        while !is_so(self) {
            assert!(self.now() < end, "not within {most} ms");
            self.tick();
        }
    }
}

pub(crate) fn ready(motor: Motor, speed: f32) -> [HostMessage<'static>; 3] {
    let acceleration = StepsPerSecondSquared(5000.0);
    [
        message::MotorSetEnable { motor, enable: true.into() }.into(),
        message::MotorSetContinuousAcceleration { motor, acceleration }.into(),
        set_speed(motor, speed).into(),
    ]
}

pub(crate) fn set_speed(motor: Motor, speed: f32) -> message::MotorSetContinuousSpeed {
    message::MotorSetContinuousSpeed { motor, speed: StepsPerSecond(speed) }
}

pub(crate) fn move_by(motor: Motor, steps: i32) -> message::MotorMove {
    message::MotorMove { motor, direction: Direction((steps > 0).into()), steps: StepCount(steps.unsigned_abs()) }
}

pub(crate) fn run(motor: Motor) -> message::MotorRun {
    message::MotorRun { motor, direction: Direction(1) }
}

pub(crate) fn motor_stop(motor: Motor) -> message::MotorStop {
    message::MotorStop { motor }
}

pub(crate) fn joystick(on: bool) -> message::SetJoystickMode {
    message::SetJoystickMode { joystick_mode: on.into() }
}

pub(crate) fn dead_man(on: bool) -> message::SetManualMove {
    message::SetManualMove { manual_move: on.into() }
}

pub(crate) fn enable_camera(on: bool) -> message::CameraSetEnable {
    message::CameraSetEnable { enable: on.into() }
}

pub(crate) const START: message::Start = message::Start {};
pub(crate) const PAUSE: message::Pause = message::Pause {};
pub(crate) const STOP: message::Stop = message::Stop {};
pub(crate) const STATUS: RunStatus = RunStatus {};

/// Messages that set the planned move of a motor.
pub(crate) fn planned(motor: Motor, lead_in: u16, plan: Plan) -> Vec<HostMessage<'static>> {
    let Plan { start, stop, travel, acceleration, deceleration, easing, .. } = plan;
    vec![
        message::MotorSetProgramStart { motor, position: start }.into(),
        message::MotorSetProgramStop { motor, position: stop }.into(),
        message::MotorSetTravel { motor, travel }.into(),
        message::MotorSetProgramAcceleration { motor, acceleration }.into(),
        message::MotorSetProgramDeceleration { motor, deceleration }.into(),
        message::MotorSetEasing { motor, easing }.into(),
        message::MotorSetLeadIn { motor, lead_in: ShortSpan(lead_in) }.into(),
    ]
}

pub(crate) fn mode(program_mode: ProgramMode) -> message::SetProgramMode {
    message::SetProgramMode { program_mode }
}

/// Messages that let a camera take a number of photos.
pub(crate) fn photos(max_shots: u16, exposure: u32, interval: u32) -> Vec<HostMessage<'static>> {
    vec![
        enable_camera(true).into(),
        message::CameraSetExposureTime { exposure_time: Milliseconds(exposure) }.into(),
        message::CameraSetInterval { interval: Milliseconds(interval) }.into(),
        message::CameraSetMaxShots { max_shots: ShortShots(max_shots) }.into(),
    ]
}

/// Plan from 0 to 6000 in three seconds, as a smooth curve: speed grows for half of it, and shrinks for the other half.
pub(crate) fn smooth() -> Plan {
    Plan {
        start: Steps(0),
        stop: Steps(6000),
        travel: Span(3000),
        acceleration: Span(1500),
        deceleration: Span(1500),
        easing: Easing::INVERSE_QUADRATIC,
    }
}

pub(crate) fn millis(now: u64) -> Millis {
    Millis(now)
}
