//! kOS device with three motors that count. It obeys all commands by hand, and stores no moves.

use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Ticker};
use embedded_io_async::{Read, Write};
use kos_proto::device::{CommandSession, DeviceMachine, Event, Next, Options, Report, SessionId, Source};
use kos_proto::message::{MotorAddress, Rotations, RotationsPerSecond};
use kos_proto::{Millis, Transport};

/// Number of motors.
const MOTORS: usize = 3;

/// Motor that counts rotations.
#[derive(Clone, Copy, Default)]
struct Counter {
    at: f32,
    to: f32,
    /// Way in a millisecond, in rotations.
    step: f32,
    /// Whether the machine waits for the news that the motor rests.
    owes_rest: bool,
}

impl Counter {
    fn go(&mut self, to: Rotations, speed: RotationsPerSecond) {
        (self.to, self.step, self.owes_rest) = (to.0, speed.0.abs() / 1000.0, true);
    }

    fn stop(&mut self) {
        (self.to, self.owes_rest) = (self.at, true);
    }

    /// Lets a millisecond pass, and reports where the motor is.
    fn tick(&mut self, motor: MotorAddress, session: &mut CommandSession) {
        let left = self.to - self.at;
        self.at = if left.abs() > self.step { self.at + self.step.copysign(left) } else { self.to };
        let at = Rotations(self.at);
        if self.at != self.to {
            let _ = session.report(Report::At(motor, at));
        } else if self.owes_rest {
            self.owes_rest = session.report(Report::Arrived(motor, at)).is_err();
        }
    }
}

fn obey(event: &Event<'_>, motors: &mut [Counter; MOTORS]) {
    for (counter, of) in motors.iter_mut().zip((1..).map(MotorAddress)) {
        match *event {
            Event::Move { motor, to, speed, .. } if motor == of => counter.go(to, speed),
            Event::StopMotor { motor, .. } if motor == of => counter.stop(),
            Event::StopAll | Event::Reboot => counter.stop(),
            _ => {}
        }
    }
}

/// Serves a client on a line, until the line has an error.
pub async fn serve<L: Read + Write>(line: &mut L) -> Result<(), L::Error> {
    const CLIENT: SessionId = SessionId(0);
    let mut motors = [Counter::default(); MOTORS];
    let mut session = CommandSession::new(DeviceMachine::without_moves(Options::default()));
    let mut ticker = Ticker::every(Duration::from_millis(1));
    let (mut out, mut arrived) = ([0; 512], [0; 64]);
    let _ = session.report(Report::Started);
    let _ = session.link_up(CLIENT, Transport::Usb);
    loop {
        match session.poll(Millis(Instant::now().as_millis()), &Source::default(), &mut out) {
            Ok(Next::Transmit(_, message)) => line.write_all(message).await?,
            Ok(Next::Event(event)) => {
                let is_reboot = event == Event::Reboot;
                obey(&event, &mut motors);
                if is_reboot {
                    let _ = session.report(Report::Started);
                }
            }
            Ok(Next::Wait(_)) | Err(_) => match select(line.read(&mut arrived), ticker.next()).await {
                Either::First(read) => {
                    let bytes = &arrived[..read?];
                    let taken = session.receive(Millis(Instant::now().as_millis()), CLIENT, bytes);
                    debug_assert_eq!(taken, bytes.len(), "the session waits, and takes a piece");
                }
                Either::Second(()) => {
                    for (counter, motor) in motors.iter_mut().zip((1..).map(MotorAddress)) {
                        counter.tick(motor, &mut session);
                    }
                }
            },
        }
    }
}
