//! Hoot node with three motors that count steps.

use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Ticker};
use embedded_io_async::{Read, Write};
use hoot_proto::Millis;
use hoot_proto::device::{DeviceMachine, Event, Motion, Next, Options, Port, Session};
use hoot_proto::message::{Direction, Motor, Steps, StepsPerSecond};
use hoot_proto::program::Plan;

/// Motor that counts steps.
#[derive(Clone, Copy, Default)]
struct Counter {
    at: i32,
    motion: Course,
    /// Direction of the run, 1 or -1.
    way: i32,
    /// Part of a step that is left.
    rest: f32,
}

/// Motion that a motor makes.
#[derive(Clone, Copy, Default)]
enum Course {
    #[default]
    Rest,
    To(i32),
    /// Run with a speed in steps per second.
    Run(f32),
    /// Follow a plan, of which so many milliseconds are over.
    Along(Plan, u32),
}

impl Counter {
    fn obey(&mut self, motion: Motion) {
        let way = |direction: Direction| if direction.0 == 0 { -1 } else { 1 };
        self.motion = match motion {
            Motion::Stop => Course::Rest,
            Motion::By { direction, steps } => {
                let steps = i32::try_from(steps.0).unwrap_or(i32::MAX);
                Course::To(self.at.saturating_add(steps.saturating_mul(way(direction))))
            }
            Motion::To(Steps(to)) => Course::To(to),
            Motion::Run { direction, speed } => {
                self.way = way(direction);
                Course::Run(speed.0)
            }
            Motion::Speed(speed) => Course::Run(speed.0),
            Motion::Along { plan, elapsed } => Course::Along(plan, elapsed),
            Motion::Rebase { by: Steps(by) } => {
                self.at = self.at.wrapping_sub(by);
                match self.motion {
                    Course::To(to) => Course::To(to.wrapping_sub(by)),
                    Course::Along(mut plan, elapsed) => {
                        plan.start.0 = plan.start.0.wrapping_sub(by);
                        plan.stop.0 = plan.stop.0.wrapping_sub(by);
                        Course::Along(plan, elapsed)
                    }
                    other => other,
                }
            }
            _ => return,
        };
    }

    /// Number of whole steps in a millisecond, at a speed in steps per second.
    fn steps(&mut self, speed: f32) -> i32 {
        self.rest += speed / 1000.0;
        let whole = self.rest as i32;
        self.rest -= whole as f32;
        whole
    }

    /// Lets a millisecond pass. Moves have the speed that is set. Returns whether the motor has come to the end of its motion.
    fn tick(&mut self, StepsPerSecond(speed): StepsPerSecond) -> bool {
        let is_over = match self.motion {
            Course::Rest => false,
            Course::To(to) => {
                let left = to.wrapping_sub(self.at);
                self.at += left.signum() * left.abs().min(self.steps(speed.abs()));
                self.at == to
            }
            Course::Run(speed) => {
                self.at = self.at.wrapping_add(self.steps(speed).wrapping_mul(self.way));
                false
            }
            Course::Along(plan, elapsed) => {
                self.at = plan.at(elapsed + 1).0;
                self.motion = Course::Along(plan, elapsed + 1);
                elapsed + 1 >= plan.travel.0
            }
        };
        if is_over {
            self.motion = Course::Rest;
        }
        is_over
    }
}

/// Serves a master on a line, which is the port for USB, until the line has an error.
pub async fn serve<L: Read + Write>(line: &mut L) -> Result<(), L::Error> {
    let mut motors = [Counter::default(); 3];
    let mut session = Session::new(DeviceMachine::without_quirks(Options::new()));
    let mut ticker = Ticker::every(Duration::from_millis(1));
    let (mut out, mut arrived) = ([0; 42], [0; 64]);
    let _ = session.link_up(Port::Usb);
    loop {
        match session.poll(Millis(Instant::now().as_millis()), &mut out) {
            Ok(Next::Transmit(Port::Usb, packet)) => line.write_all(packet).await?,
            Ok(Next::Event(Event::Motor { motor, motion })) => motors[index(motor)].obey(motion),
            Ok(Next::Transmit(..) | Next::Event(_)) => {}
            Ok(Next::Wait(_)) | Err(_) => match select(line.read(&mut arrived), ticker.next()).await {
                Either::First(read) => {
                    let bytes = &arrived[..read?];
                    let taken = session.receive(Millis(Instant::now().as_millis()), Port::Usb, bytes);
                    debug_assert_eq!(taken, bytes.len(), "the session waits, and takes a piece");
                }
                Either::Second(()) => tick(&mut motors, &mut session),
            },
        }
    }
}

/// Lets a millisecond pass, and reports where the motors are.
fn tick(motors: &mut [Counter; 3], session: &mut Session<false>) {
    for (counter, motor) in motors.iter_mut().zip(Motor::ALL) {
        let before = counter.at;
        let arrived = counter.tick(session.machine().motor(motor).settings().speed);
        if counter.at != before {
            let _ = session.position(motor, Steps(counter.at));
        }
        if arrived {
            let _ = session.arrived(motor);
        }
    }
}

fn index(motor: Motor) -> usize {
    usize::from(motor.get() - 1)
}
