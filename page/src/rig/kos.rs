//! Buttons of the page for kOS.

use kos_proto::host::{self, Go, Options, State, StopTarget, Token};
use kos_proto::message::{MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared};
use motion_core::time::Millis;
use motion_rigs::Host as _;
use motion_rigs::device::Named as _;
use motion_rigs::kos_device::{KosDevice, Setup};
use motion_rigs::kos_host::{Command, Event, KosHost};

use super::{Control, Held, Note, Scene, Stage};

/// Way of a short move, in rotations.
const WAY: f32 = 5.0;

#[derive(Default)]
struct Kos {
    last: u32,
}

pub(super) fn start(device: &str) -> Result<Box<dyn Stage>, String> {
    let setup = Setup::default().with_device(device).map_err(|error| error.to_string())?;
    let password = setup.password.clone();
    let host = KosHost::new(Options::default(), (!password.is_empty()).then_some(&password));
    Ok(Box::new(Scene::new(Kos::default(), host, KosDevice::new(setup), "kos")?))
}

impl Kos {
    fn give(&mut self, host: &mut KosHost, now: Millis, command: host::Command) {
        self.last = self.last.wrapping_add(1);
        host.command(now, (Token(self.last), Command::Machine(command)));
    }
}

/// A quarter of the greatest speed of a motor, and half of its greatest acceleration.
fn pace(host: &KosHost, motor: MotorAddress) -> Option<(f32, RotationsPerSecondSquared)> {
    let known = host.motor(motor)?;
    let acceleration = RotationsPerSecondSquared(known.max_max_acceleration.0 / 2.0);
    Some((known.max_max_setup_speed.0 / 4.0, acceleration))
}

impl Control for Kos {
    type Host = KosHost;

    const ASKS: bool = true;
    const UNIT: &'static str = "rev";
    const SPAN: f64 = 100.0;

    fn connect(&mut self, host: &mut KosHost, now: Millis) {
        host.command(now, (Token::default(), Command::Connect));
    }

    fn jog(&mut self, host: &mut KosHost, now: Millis, held: Held) {
        let motor = MotorAddress(held.motor);
        let Some((fast, acceleration)) = pace(host, motor) else { return };
        let speed = RotationsPerSecond(if held.forward { fast } else { -fast });
        self.give(host, now, host::Command::Jog { motor, speed, acceleration });
    }

    fn alive(&mut self, host: &mut KosHost, now: Millis, _: Held) {
        self.give(host, now, host::Command::Alive);
    }

    fn release(&mut self, host: &mut KosHost, now: Millis, motor: u8) {
        self.give(host, now, host::Command::StopMotor(MotorAddress(motor)));
    }

    fn go(&mut self, host: &mut KosHost, now: Millis, motor: u8) {
        let motor = MotorAddress(motor);
        let Some((fast, acceleration)) = pace(host, motor) else { return };
        let go = Go { motor, position: Rotations(WAY), speed: RotationsPerSecond(fast), acceleration };
        self.give(host, now, host::Command::Bump(go));
    }

    fn stop(&mut self, host: &mut KosHost, now: Millis) {
        // A host without a connection makes one for the stop.
        if matches!(host.machine().state(), State::Discovering | State::Disconnected) {
            self.connect(host, now);
        }
        self.give(host, now, host::Command::Stop);
    }

    fn event(&mut self, _: &mut KosHost, _: Millis, event: Event) -> Note {
        match event {
            Event::Machine(host::Event::Stopped(StopTarget::All)) => {
                Note { stopped: Some(true), ..Note::line("the stop is confirmed") }
            }
            Event::Machine(event @ host::Event::StopNotConfirmed(_)) => {
                Note { stopped: Some(false), ..Note::line(event) }
            }
            Event::Machine(host::Event::Ended { outcome, .. }) => match outcome {
                host::Outcome::Done(_) | host::Outcome::Sent => Note::default(),
                outcome => Note::line(outcome),
            },
            Event::Machine(event @ (host::Event::Ready { .. } | host::Event::LinkDown(_))) => Note::line(event),
            _ => Note::default(),
        }
    }

    fn is_ready(&self, host: &KosHost) -> bool {
        host.machine().state() == State::Ready
    }
}
