//! What the tests share: a master and a node, and short names for what is often said.

use hoot_proto::device::ProgramState;
use hoot_proto::host::{self, Command, Request, Token};
use hoot_proto::message::{
    self, CameraExposing, Direction, Easing, Milliseconds, Motor, MotorPosition, MotorRunning, ProgramMode, RunStatus,
    ShortShots, ShortSpan, Span, StepCount, Steps, StepsPerSecond, StepsPerSecondSquared,
};
use hoot_proto::program::Plan;
use hoot_proto::{Address, HostMessage};
use motion_core::time::Millis;
use motion_core::wire::Bool;
use rigs::faults::{Carrier, Faults};
use rigs::hoot_master::{Ended, Event, HootMaster};
use rigs::hoot_node::{HootNode, Setup};
use rigs::{Rig, Scene};

pub(crate) const NODE: Address = Address::DEFAULT;
pub(crate) const ONE: Motor = Motor::One;

/// A master and a rig, and what happened.
pub(crate) struct Stage<R> {
    pub(crate) scene: Scene<HootMaster, R>,
    /// What the master told beside the ends of requests, and when.
    pub(crate) told: Vec<(u64, host::Event)>,
    pub(crate) ended: Vec<Ended>,
    token: u32,
}

/// With a node as the options have it, on a line without faults.
pub(crate) fn stage(setup: Setup) -> Stage<HootNode> {
    Stage::new(HootNode::new(setup), Faults::NONE, 1)
}

impl<R: Rig> Stage<R> {
    pub(crate) fn new(rig: R, faults: Faults, seed: u64) -> Self {
        let scene = Scene::new(HootMaster::new(host::Options::default()), rig, Carrier::Serial, faults, seed);
        let mut stage = Self { scene, told: Vec::new(), ended: Vec::new(), token: 0 };
        stage.pass(10);
        stage
    }

    pub(crate) fn now(&self) -> u64 {
        self.scene.now().0
    }

    /// A millisecond passes.
    pub(crate) fn tick(&mut self) {
        let until = self.scene.now().after(1);
        let (told, ended) = (&mut self.told, &mut self.ended);
        self.scene.run(until, |scene, event| {
            match event {
                Event::Told(event) => told.push((scene.now().0, event)),
                Event::Ended(end) => ended.push(end),
                _ => {}
            }
            None::<()>
        });
    }

    pub(crate) fn pass(&mut self, millis: u64) {
        for _ in 0..millis {
            self.tick();
        }
    }

    /// Asks, and gives the number of the request.
    pub(crate) fn send_to(&mut self, to: Address, message: HostMessage<'static>) -> Token {
        self.token += 1;
        let token = Token(self.token);
        self.scene.command(Command::Request(Request { token, to, message }));
        token
    }

    /// Asks, and waits for the end.
    #[track_caller]
    pub(crate) fn ask_to(&mut self, to: Address, message: HostMessage<'static>) -> Ended {
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
    pub(crate) fn ask(&mut self, message: HostMessage<'static>) -> Ended {
        self.ask_to(NODE, message)
    }

    /// A request that is done.
    #[track_caller]
    pub(crate) fn ok(&mut self, message: HostMessage<'static>) -> Ended {
        let ended = self.ask(message);
        assert!(ended.is_done(), "{ended}");
        ended
    }

    #[track_caller]
    pub(crate) fn position(&mut self, motor: Motor) -> i32 {
        let query = MotorPosition { motor };
        self.ok(HostMessage::MotorPosition(query)).read(&query).unwrap().0
    }

    #[track_caller]
    pub(crate) fn is_running(&mut self, motor: Motor) -> bool {
        let query = MotorRunning { motor };
        self.ok(HostMessage::MotorRunning(query)).read(&query).unwrap().get()
    }

    /// Makes a motor ready to move.
    #[track_caller]
    pub(crate) fn enable(&mut self, motor: Motor, speed: f32) {
        for message in ready(motor, speed) {
            self.ok(message);
        }
    }

    /// Until the program of the node stands still.
    #[track_caller]
    pub(crate) fn emergency_stop(&mut self) {
        self.scene.command(Command::EmergencyStop);
        let before = self.told.len();
        for _ in 0..20_000 {
            if self.told[before.saturating_sub(1)..].iter().any(|(_, event)| *event == host::Event::StopConfirmed) {
                return;
            }
            self.tick();
        }
        panic!("never confirmed: {:?}", self.told);
    }
}

impl Stage<HootNode> {
    pub(crate) fn place(&self, motor: usize) -> f64 {
        self.scene.rig.motors()[motor].at(self.scene.now()).position
    }

    pub(crate) fn is_at_rest(&self) -> bool {
        self.scene.rig.motors().iter().all(rigs::motor::Motor::rests)
    }

    pub(crate) fn program(&self) -> ProgramState {
        self.scene.rig.machine().program().state()
    }

    /// Ticks until something is so.
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
        HostMessage::MotorSetEnable(message::MotorSetEnable { motor, enable: Bool::TRUE }),
        HostMessage::MotorSetContinuousAcceleration(message::MotorSetContinuousAcceleration { motor, acceleration }),
        set_speed(motor, speed),
    ]
}

pub(crate) fn set_speed(motor: Motor, speed: f32) -> HostMessage<'static> {
    let speed = StepsPerSecond(speed);
    HostMessage::MotorSetContinuousSpeed(message::MotorSetContinuousSpeed { motor, speed })
}

pub(crate) fn move_by(motor: Motor, steps: i32) -> HostMessage<'static> {
    let direction = Direction((steps > 0).into());
    HostMessage::MotorMove(message::MotorMove { motor, direction, steps: StepCount(steps.unsigned_abs()) })
}

pub(crate) fn run(motor: Motor) -> HostMessage<'static> {
    HostMessage::MotorRun(message::MotorRun { motor, direction: Direction(1) })
}

pub(crate) fn motor_stop(motor: Motor) -> HostMessage<'static> {
    HostMessage::MotorStop(message::MotorStop { motor })
}

pub(crate) fn joystick(on: Bool) -> HostMessage<'static> {
    HostMessage::SetJoystickMode(message::SetJoystickMode { joystick_mode: on })
}

pub(crate) fn dead_man(on: Bool) -> HostMessage<'static> {
    HostMessage::SetManualMove(message::SetManualMove { manual_move: on })
}

pub(crate) const START: HostMessage<'static> = HostMessage::Start(message::Start {});
pub(crate) const PAUSE: HostMessage<'static> = HostMessage::Pause(message::Pause {});
pub(crate) const STOP: HostMessage<'static> = HostMessage::Stop(message::Stop {});
pub(crate) const STATUS: HostMessage<'static> = HostMessage::RunStatus(RunStatus {});
pub(crate) const EXPOSING: HostMessage<'static> = HostMessage::CameraExposing(CameraExposing {});

/// What makes the planned move of a motor.
pub(crate) fn planned(motor: Motor, lead_in: u16, plan: Plan) -> Vec<HostMessage<'static>> {
    let Plan { start, stop, travel, acceleration, deceleration, easing, .. } = plan;
    let lead_in = ShortSpan(lead_in);
    vec![
        HostMessage::MotorSetProgramStart(message::MotorSetProgramStart { motor, position: start }),
        HostMessage::MotorSetProgramStop(message::MotorSetProgramStop { motor, position: stop }),
        HostMessage::MotorSetTravel(message::MotorSetTravel { motor, travel }),
        HostMessage::MotorSetProgramAcceleration(message::MotorSetProgramAcceleration { motor, acceleration }),
        HostMessage::MotorSetProgramDeceleration(message::MotorSetProgramDeceleration { motor, deceleration }),
        HostMessage::MotorSetEasing(message::MotorSetEasing { motor, easing }),
        HostMessage::MotorSetLeadIn(message::MotorSetLeadIn { motor, lead_in }),
    ]
}

pub(crate) fn mode(program_mode: ProgramMode) -> HostMessage<'static> {
    HostMessage::SetProgramMode(message::SetProgramMode { program_mode })
}

/// What makes a camera take so many photos.
pub(crate) fn photos(max_shots: u16, exposure: u32, interval: u32) -> Vec<HostMessage<'static>> {
    let (exposure_time, interval) = (Milliseconds(exposure), Milliseconds(interval));
    vec![
        HostMessage::CameraSetEnable(message::CameraSetEnable { enable: Bool::TRUE }),
        HostMessage::CameraSetExposureTime(message::CameraSetExposureTime { exposure_time }),
        HostMessage::CameraSetInterval(message::CameraSetInterval { interval }),
        HostMessage::CameraSetMaxShots(message::CameraSetMaxShots { max_shots: ShortShots(max_shots) }),
    ]
}

/// From 0 to 6000 in three seconds, as a smooth curve: half of it gains speed, half of it loses it.
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
