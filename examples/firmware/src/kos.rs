//! kOS device with three motors that count. It takes all commands, and forgets each move that is stored.

use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Ticker};
use embedded_io_async::{Read, Write};
use kos_proto::device::{CommandSession, DeviceMachine, Event, Next, Options, Report, SessionId, Source};
use kos_proto::message::{MotorAddress, Rotations};
use kos_proto::{Millis, Transport};

/// Number of motors.
const MOTORS: usize = 3;

/// Motor that counts hundredths of a rotation, one in a millisecond.
#[derive(Clone, Copy, Default)]
struct Counter {
    at: f32,
    to: f32,
    /// Whether the machine waits for the news that the motor rests.
    owes_rest: bool,
}

/// Greatest way in a millisecond.
const STEP: f32 = 0.01;

impl Counter {
    fn go(&mut self, to: f32) {
        (self.to, self.owes_rest) = (to, true);
    }

    /// Lets a millisecond pass. Returns what the motor has to report.
    fn tick(&mut self, motor: MotorAddress) -> Option<Report> {
        let left = self.to - self.at;
        self.at = if left.abs() > STEP { self.at + STEP.copysign(left) } else { self.to };
        if self.at != self.to {
            return Some(Report::At(motor, Rotations(self.at)));
        }
        core::mem::take(&mut self.owes_rest).then_some(Report::Arrived(motor, Rotations(self.at)))
    }
}

fn obey(event: &Event<'_>, motors: &mut [Counter; MOTORS]) {
    let each = motors.iter_mut().zip((1..).map(MotorAddress));
    match *event {
        Event::Move { motor, to, .. } => each.filter(|(_, of)| *of == motor).for_each(|(motor, _)| motor.go(to.0)),
        Event::StopMotor { motor, .. } => {
            each.filter(|(_, of)| *of == motor).for_each(|(motor, _)| motor.go(motor.at));
        }
        Event::StopAll => each.for_each(|(motor, _)| motor.go(motor.at)),
        Event::Home { motors, .. } => {
            each.filter(|(_, of)| motors.contains(*of)).for_each(|(motor, _)| motor.go(motor.at));
        }
        Event::MoveToFrame { .. } => each.for_each(|(motor, _)| motor.go(motor.at)),
        _ => {}
    }
}

/// Serves a client on a line, until the line has an error.
pub async fn serve<L: Read + Write>(line: &mut L) -> Result<(), L::Error> {
    const CLIENT: SessionId = SessionId(0);
    let mut motors = [Counter::default(); MOTORS];
    let mut session = CommandSession::new(DeviceMachine::new(Options::default()));
    let mut ticker = Ticker::every(Duration::from_millis(1));
    let (mut out, mut arrived) = ([0; 512], [0; 64]);
    let _ = session.report(Report::Started);
    let _ = session.link_up(CLIENT, Transport::Usb);
    loop {
        match session.poll(Millis(Instant::now().as_millis()), &Source::default(), &mut out) {
            Ok(Next::Transmit(_, message)) => line.write_all(message).await?,
            Ok(Next::Event(event)) => obey(&event, &mut motors),
            Ok(Next::Wait(_)) | Err(_) => match select(line.read(&mut arrived), ticker.next()).await {
                Either::First(read) => {
                    let bytes = &arrived[..read?];
                    let taken = session.receive(Millis(Instant::now().as_millis()), CLIENT, bytes);
                    debug_assert_eq!(taken, bytes.len(), "the session waits, and takes a piece");
                }
                Either::Second(()) => {
                    for (counter, motor) in motors.iter_mut().zip((1..).map(MotorAddress)) {
                        if let Some(report) = counter.tick(motor) {
                            let _ = session.report(report);
                        }
                    }
                }
            },
        }
    }
}
