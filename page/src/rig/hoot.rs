//! Buttons of the page for hoot.

use std::collections::VecDeque;

use hoot_proto::Address;
use hoot_proto::host::{self, Command, Options, Outcome, Request, StopTarget, Token};
use hoot_proto::message::{
    Bool, Direction, FirmwareVersion, HostMessage, Motor, MotorMove, MotorRun, MotorSetContinuousSpeed, MotorSetEnable,
    MotorStop, SetManualMove, StepCount, StepsPerSecond,
};
use motion_core::time::Millis;
use motion_rigs::Host as _;
use motion_rigs::device::Named as _;
use motion_rigs::hoot_master::{Event, HootMaster};
use motion_rigs::hoot_node::{HootNode, Setup};

use super::{Control, Held, Note, Scene, Stage};

const NODE: Address = Address::DEFAULT;
/// Way of a short move, in microsteps.
const WAY: StepCount = StepCount(2000);
/// Speed of jogs and short moves, in microsteps per second.
const SPEED: StepsPerSecond = StepsPerSecond(1000.0);

#[derive(Default)]
struct Hoot {
    last: u32,
    is_ready: bool,
    /// Commands that wait until the one before them has ended.
    queue: VecDeque<Command>,
    /// Command that has not ended.
    under_way: Option<Token>,
}

pub(super) fn start(device: &str) -> Result<Box<dyn Stage>, String> {
    let setup = Setup::default().with_device(device).map_err(|error| error.to_string())?;
    let host = HootMaster::new(Options::new());
    Ok(Box::new(Scene::new(Hoot::default(), host, HootNode::new(setup), "hoot")?))
}

impl Hoot {
    fn give(&mut self, host: &mut HootMaster, now: Millis, command: Command) -> Token {
        self.last = self.last.wrapping_add(1);
        let token = Token(self.last);
        host.command(now, (token, command));
        token
    }

    fn send(&mut self, host: &mut HootMaster, now: Millis, all: impl IntoIterator<Item = HostMessage<'static>>) {
        self.queue.extend(all.into_iter().map(|message| Command::Request(Request { to: NODE, message })));
        self.go_on(host, now);
    }

    fn go_on(&mut self, host: &mut HootMaster, now: Millis) {
        if self.under_way.is_none()
            && let Some(command) = self.queue.pop_front()
        {
            self.under_way = Some(self.give(host, now, command));
        }
    }
}

/// Messages that make a motor ready.
fn ready(motor: Motor) -> [HostMessage<'static>; 2] {
    [MotorSetEnable { motor, enable: Bool::TRUE }.into(), MotorSetContinuousSpeed { motor, speed: SPEED }.into()]
}

impl Control for Hoot {
    type Host = HootMaster;

    const ASKS: bool = false;
    const UNIT: &'static str = "microsteps";
    const SPAN: f64 = 10_000.0;

    fn jog(&mut self, host: &mut HootMaster, now: Millis, held: Held) {
        let Some(motor) = Motor::new(held.motor) else { return };
        self.give(host, now, Command::KeepAlive { to: NODE, on: true });
        let run = MotorRun { motor, direction: Direction(held.forward.into()) };
        let dead_man = SetManualMove { manual_move: Bool::TRUE };
        self.send(host, now, ready(motor).into_iter().chain([dead_man.into(), run.into()]));
    }

    // The master itself keeps the dead-man switch of the node from stopping the motor.
    fn alive(&mut self, _: &mut HootMaster, _: Millis, _: Held) {}

    fn release(&mut self, host: &mut HootMaster, now: Millis, motor: u8) {
        let Some(motor) = Motor::new(motor) else { return };
        self.queue.clear();
        // A stop overtakes everything.
        self.give(host, now, Command::Request(Request { to: NODE, message: MotorStop { motor }.into() }));
        self.give(host, now, Command::KeepAlive { to: NODE, on: false });
        self.send(host, now, [SetManualMove { manual_move: Bool::FALSE }.into()]);
    }

    fn go(&mut self, host: &mut HootMaster, now: Millis, motor: u8) {
        let Some(motor) = Motor::new(motor) else { return };
        let motion = MotorMove::new(motor, Direction(1), WAY).map(HostMessage::from);
        self.send(host, now, ready(motor).into_iter().chain(motion));
    }

    fn stop(&mut self, host: &mut HootMaster, now: Millis) {
        self.queue.clear();
        self.give(host, now, Command::EmergencyStop);
        self.give(host, now, Command::KeepAlive { to: NODE, on: false });
    }

    fn event(&mut self, host: &mut HootMaster, now: Millis, event: Event) -> Note {
        match event {
            Event::Ended(ended) => {
                if self.under_way.take_if(|token| *token == ended.token).is_some() {
                    self.go_on(host, now);
                }
                match ended.outcome() {
                    Outcome::Done(_) | Outcome::Sent => Note::default(),
                    _ => Note::line(&ended),
                }
            }
            Event::Machine(event) => {
                match event {
                    // There is no greeting: the first question shows whether a node answers.
                    host::Event::Ready { .. } => {
                        self.is_ready = true;
                        self.send(host, now, [FirmwareVersion {}.into()]);
                    }
                    host::Event::LinkDown => self.is_ready = false,
                    _ => {}
                }
                let stopped = match event {
                    host::Event::Stopped(StopTarget::All) => Some(true),
                    host::Event::StopNotConfirmed(StopTarget::All) => Some(false),
                    _ => None,
                };
                Note { stopped, ..Note::line(event) }
            }
            _ => Note::default(),
        }
    }

    fn is_ready(&self, _: &HootMaster) -> bool {
        self.is_ready
    }
}
