//! Buttons of the page for DMC.

use dmc_proto::Token;
use dmc_proto::host::{self, Options, Outcome, State, StopTarget};
use dmc_proto::message::{HostMessage, JogSpeed, Motor, MotorGetPosition, MotorJog, MotorMove, Scaled, Steps};
use motion_core::time::Millis;
use motion_rigs::Host as _;
use motion_rigs::device::Named as _;
use motion_rigs::dmc_device::{DmcDevice, Setup};
use motion_rigs::dmc_host::{Answer, Command, DmcHost, Event};

use super::{Control, Held, Note, Scene, Stage};

/// Way of a short move, in steps.
const WAY: i32 = 2000;
/// Speed of a jog: a quarter of the greatest one, in hundredths of a percent.
const SPEED: JogSpeed = JogSpeed(Scaled(2500));

#[derive(Default)]
struct Dmc {
    last: u32,
    /// Question for the position at which a short move begins, and its motor.
    asked: Option<(Token, Motor)>,
}

pub(super) fn start(device: &str) -> Result<Box<dyn Stage>, String> {
    let setup = Setup::default().with_device(device).map_err(|error| error.to_string())?;
    let host = DmcHost::new(Options::default());
    Ok(Box::new(Scene::new(Dmc::default(), host, DmcDevice::new(setup), "dmc")?))
}

impl Dmc {
    fn ask(&mut self, host: &mut DmcHost, now: Millis, message: impl Into<HostMessage<'static>>) -> Token {
        self.last = self.last.wrapping_add(1) & 0x00FF_FFFF;
        let token = Token(self.last);
        host.command(now, Command::Ask(token, message.into()));
        token
    }
}

impl Control for Dmc {
    type Host = DmcHost;

    const ASKS: bool = false;
    const UNIT: &'static str = "steps";
    const SPAN: f64 = 20_000.0;

    fn jog(&mut self, host: &mut DmcHost, now: Millis, held: Held) {
        let destination = Steps(if held.forward { i32::MAX } else { i32::MIN });
        self.ask(host, now, MotorJog { motor: Motor(held.motor), speed: SPEED, destination, tail: &[] });
    }

    // Some devices end a jog by themselves after half a second, so it is repeated.
    fn alive(&mut self, host: &mut DmcHost, now: Millis, held: Held) {
        self.jog(host, now, held);
    }

    fn release(&mut self, host: &mut DmcHost, now: Millis, motor: u8) {
        host.command(now, Command::Stop(StopTarget::Motor(Motor(motor))));
    }

    fn go(&mut self, host: &mut DmcHost, now: Millis, motor: u8) {
        self.asked = Some((self.ask(host, now, MotorGetPosition::default()), Motor(motor)));
    }

    fn stop(&mut self, host: &mut DmcHost, now: Millis) {
        self.asked = None;
        host.stop_all(now);
    }

    fn event(&mut self, host: &mut DmcHost, now: Millis, event: Event) -> Note {
        match event {
            Event::Machine(host::Event::Stopped(StopTarget::All | StopTarget::AllSilent)) => {
                Note { stopped: Some(true), ..Note::line("the stop is confirmed") }
            }
            Event::Machine(event @ host::Event::StopNotConfirmed(_)) => {
                Note { stopped: Some(false), ..Note::line(event) }
            }
            Event::Machine(
                event @ (host::Event::Ready { .. }
                | host::Event::LinkDown
                | host::Event::Silent
                | host::Event::HardStop(..)),
            ) => Note::line(event),
            Event::Ended(token, Ok(Answer::Positions(all))) => {
                if let Some((_, motor)) = self.asked.take_if(|(asked, _)| *asked == token) {
                    let at = all.positions.get(usize::from(motor.0).saturating_sub(1)).copied().unwrap_or_default();
                    self.ask(host, now, MotorMove { motor, position: Steps(at.saturating_add(WAY)), tail: &[] });
                }
                Note::default()
            }
            Event::Ended(_, Err(outcome @ (Outcome::Refused(_) | Outcome::Failed(_)))) => Note::line(outcome),
            Event::Refused(refusal) => Note::line(format_args!("refused: {refusal}")),
            _ => Note::default(),
        }
    }

    fn is_ready(&self, host: &DmcHost) -> bool {
        host.machine().state() == State::Ready
    }
}
