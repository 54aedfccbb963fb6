//! Devices against the hosts of the libraries, over lines in memory, after a message of each protocol was decoded and encoded. The
//! program prints OK, or the step that failed.

#![no_std]
#![no_main]

#[path = "../../../../proofs/wasm/src/messages.rs"]
mod messages;

use core::cell::RefCell;
use core::ffi::CStr;

use dmc_proto::message::MotorStopAll;
use dmc_proto::{Item, MessageId, SmallFrames};
use embassy_executor::Spawner;
use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::{Mutex, raw::CriticalSectionRawMutex};
use embassy_time::{Duration, Instant, Timer, with_timeout};
use embedded_io_async::{Read, Write};
use firmware::line::{End, Line};
use firmware::{board, dmc, hoot, kos};
use motion_core::machine::Token;
use motion_core::time::Millis;

/// Static stream. Its bytes are all zero, so that it takes no flash: CI checks that it is in `.bss`.
static FRAMES: Mutex<CriticalSectionRawMutex, RefCell<SmallFrames>> = Mutex::new(RefCell::new(SmallFrames::new()));

/// Finds the stop of all motors in the static stream.
fn finds_a_frame() -> bool {
    let mut bytes = [0; 64];
    let stop = dmc_proto::HostMessage::from(MotorStopAll::default());
    let Ok(len) = stop.encode_into(MessageId(1), &mut bytes) else { return false };
    FRAMES.lock(|frames| {
        let mut frames = frames.borrow_mut();
        frames.push(&bytes[..len]) == len
            && matches!(frames.next(), Some(Item::Frame(frame)) if frame.bytes().len() == len)
    })
}

/// Step that failed.
type Failed = &'static CStr;

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let _serial = board::start();
    if !finds_a_frame() {
        board::print(c"a static stream found no frame");
        board::exit(false)
    }
    for (failed, check) in messages::CHECKS {
        if check().is_none() {
            board::print(failed);
            board::exit(false)
        }
    }
    let lines: [Line; 3] = core::array::from_fn(|_| Line::new());
    let [(dmc_host_end, mut dmc_end), (master_end, mut node_end), (client_end, mut kos_end)] =
        lines.each_ref().map(Line::ends);
    let mut steps = [c"DMC: nothing happened", c"hoot: nothing happened", c"kOS: nothing happened"];
    let [dmc_step, hoot_step, kos_step] = &mut steps;
    let passed = [
        passes(dmc_host(dmc_host_end, dmc_step), dmc::serve(&mut dmc_end)).await,
        passes(hoot_master(master_end, hoot_step), hoot::serve(&mut node_end)).await,
        passes(kos_client(client_end, kos_step), kos::serve(&mut kos_end)).await,
    ];
    for (step, _) in steps.into_iter().zip(passed).filter(|(_, passed)| !passed) {
        board::print(step);
    }
    let is_ok = !passed.contains(&false);
    if is_ok {
        board::print(c"OK");
    }
    board::exit(is_ok)
}

/// Runs a host against a device, for ten seconds at most. Returns whether the host came to its end.
async fn passes(host: impl Future<Output = ()>, device: impl Future) -> bool {
    matches!(with_timeout(Duration::from_secs(10), select(host, device)).await, Ok(Either::First(())))
}

fn now() -> Millis {
    Millis(Instant::now().as_millis())
}

/// Waits for bytes, at most until a moment.
async fn wait(line: &mut End<'_>, until: Option<Millis>, bytes: &mut [u8]) -> usize {
    let until = until.map_or(Instant::MAX, |Millis(until)| Instant::from_millis(until));
    match select(line.read(bytes), Timer::at(until)).await {
        Either::First(Ok(len)) => len,
        Either::Second(()) => 0,
    }
}

/// Greets the device, moves a motor and stops it, uploads a move and runs it.
async fn dmc_host(mut line: End<'_>, step: &mut Failed) {
    use dmc_proto::DeviceMessage;
    use dmc_proto::host::{Event, Next, Options, Outcome, Session};
    use dmc_proto::message::{
        FrameNumber, FramesPerSecond, Milliseconds, Motor, MotorConfigure, MotorFlags, MotorGetPosition, MotorMove,
        Motors, RtRunMove, RtUploadMoveBegin, Steps,
    };
    use dmc_proto::upload::MoveSource;

    /// All four motors go ten steps in each of 50 frames.
    struct Ramp;
    impl MoveSource for Ramp {
        fn start_frame(&self) -> FrameNumber {
            FrameNumber(1)
        }
        fn frame_count(&self) -> u32 {
            50
        }
        fn motors(&self) -> Motors {
            MOTORS.into_iter().collect()
        }
        fn position(&self, _: Motor, index: u32) -> Steps {
            Steps(10 * index as i32)
        }
    }

    const MOTORS: [Motor; 4] = [Motor(1), Motor(2), Motor(3), Motor(4)];
    let (first, last) = (FrameNumber(1), FrameNumber(50));
    let position = |outcome: &Outcome<'_>| match outcome {
        Outcome::Done(Some(DeviceMessage::MotorGetPosition(answer))) => answer.positions.first().map(|at| at.get()),
        _ => None,
    };
    let mut session: Session = Session::new(Options::default());
    let (mut out, mut arrived) = ([0; 1048], [0; 64]);
    session.link_up();
    loop {
        let told = match session.poll(now(), &Ramp, &mut out) {
            Ok(Next::Transmit(frame)) => {
                let Ok(()) = line.write_all(frame).await;
                continue;
            }
            Ok(Next::Wait(until)) => {
                let len = wait(&mut line, until, &mut arrived).await;
                let _ = session.receive(now(), &arrived[..len]);
                continue;
            }
            Ok(Next::Event(event)) => event,
            Err(_) => break *step = c"DMC: a message cannot be written",
        };
        let given = match told {
            Event::Greeted(_) => {
                *step = c"DMC: greeted";
                for motor in MOTORS {
                    let enable = MotorConfigure { motor, flags: MotorFlags::ENABLED, tail: &[] };
                    let _ = session.request(Token(10 + u32::from(motor.0)), enable);
                }
                session.configured(Token(1))
            }
            Event::Ready { .. } => {
                *step = c"DMC: all motors are enabled";
                session.request(Token(3), MotorMove { motor: MOTORS[0], position: Steps(1000), tail: &[] })
            }
            Event::Ended { token: Token(3), outcome: Outcome::Done(_) } => {
                *step = c"DMC: the motor moves";
                Timer::after_millis(100).await;
                session.stop(Token(4))
            }
            Event::Stopped(_) => {
                *step = c"DMC: stopped";
                session.request(Token(5), MotorGetPosition::default())
            }
            Event::Ended { token: Token(5), ref outcome }
                if position(outcome).is_some_and(|at| (1..900).contains(&at)) =>
            {
                *step = c"DMC: the motor stands on its way";
                let upload = RtUploadMoveBegin { start_frame: first, end_frame: last, ..Default::default() };
                session.sequence(Token(6), upload)
            }
            Event::Ended { token: Token(6), outcome: Outcome::Done(_) } => {
                *step = c"DMC: the move is uploaded";
                let (fps_x1000, pre_roll_ms) =
                    (FramesPerSecond(motion_core::fixed::Scaled(100_000)), Milliseconds(100));
                let run =
                    RtRunMove { fps_x1000, start_frame: first, end_frame: last, pre_roll_ms, ..Default::default() };
                session.sequence(Token(7), run)
            }
            Event::Armed(Token(7)) => {
                *step = c"DMC: ready to run";
                session.go(Token(8))
            }
            Event::Ended { token: Token(7), outcome: Outcome::Done(_) } => {
                *step = c"DMC: the run is over";
                session.request(Token(9), MotorGetPosition::default())
            }
            Event::Ended { token: Token(9), ref outcome } if position(outcome) == Some(490) => {
                *step = c"DMC: the motor stands at the end of the move";
                if !session.may_move() {
                    return;
                }
                session.request(Token(9), MotorGetPosition::default())
            }

            _ => Ok(()),
        };
        if given.is_err() {
            *step = c"DMC: a command was not taken";
        }
    }
    core::future::pending().await
}

/// Asks for a position, moves the motor, and stops it on its way.
async fn hoot_master(mut line: End<'_>, step: &mut Failed) {
    use hoot_proto::host::{Event, Next, Options, Outcome, Session};
    use hoot_proto::message::{
        Bool, Direction, Motor, MotorMove, MotorPosition, MotorSetEnable, StepCount, StepsPerSecond,
    };
    use hoot_proto::{Address, Query};

    let (motor, node) = (Motor::One, Address::DEFAULT);
    let question = MotorPosition { motor };
    let position = |outcome: Outcome<'_>| match outcome {
        Outcome::Done(reply) => question.decode_reply(reply).ok().map(|answer| answer.value.0),
        _ => None,
    };
    let mut session = Session::new(Options::default());
    let (mut out, mut arrived) = ([0; 42], [0; 64]);
    session.link_up();
    loop {
        let told = match session.poll(now(), &mut out) {
            Ok(Next::Transmit(packet)) => {
                let Ok(()) = line.write_all(packet).await;
                continue;
            }
            Ok(Next::Wait(until)) => {
                let len = wait(&mut line, until, &mut arrived).await;
                let _ = session.receive(now(), &arrived[..len]);
                continue;
            }
            Ok(Next::Event(event)) => event,
            Err(_) => break *step = c"hoot: a message cannot be written",
        };
        let given = match told {
            Event::Ready { .. } => {
                *step = c"hoot: ready";
                session.request(Token(1), node, question.into())
            }
            Event::Ended { token: Token(1), outcome } if position(outcome) == Some(0) => {
                *step = c"hoot: the motor stands at 0";
                session.request(Token(2), node, MotorSetEnable { motor, enable: Bool::TRUE }.into())
            }
            Event::Ended { token: Token(2), outcome: Outcome::Done(_) } => {
                *step = c"hoot: the motor is enabled";
                session.speed(Token(6), node, motor, StepsPerSecond(1000.0))
            }
            Event::Ended { token: Token(6), outcome: Outcome::Done(_) | Outcome::Applied } => {
                *step = c"hoot: the speed is set";
                let go = MotorMove { motor, direction: Direction(1), steps: StepCount(1000) };
                session.request(Token(3), node, go.into())
            }
            Event::Ended { token: Token(3), outcome: Outcome::Done(_) } => {
                *step = c"hoot: the motor moves";
                Timer::after_millis(100).await;
                session.stop_motor(Token(4), node, motor)
            }
            Event::Stopped(_) => {
                *step = c"hoot: stopped";
                session.request(Token(5), node, question.into())
            }
            Event::Ended { token: Token(5), outcome } if position(outcome).is_some_and(|at| (1..900).contains(&at)) => {
                return;
            }
            _ => Ok(()),
        };
        if given.is_err() {
            *step = c"hoot: a command was not taken";
        }
    }
    core::future::pending().await
}

/// Jogs a motor, stops it on its way, and sends it back to where it began.
async fn kos_client(mut line: End<'_>, step: &mut Failed) {
    use kos_proto::host::{Endpoint, Event, Get, Go, Next, Options, Outcome, Session, Source, StopTarget};
    use kos_proto::message::{Motor, MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared};

    let (motor, begin) = (MotorAddress(1), Rotations(0.0));
    let (speed, acceleration) = (RotationsPerSecond(10.0), RotationsPerSecondSquared(100.0));
    let mut rests_at = begin;
    let mut session: Session = Session::new(Options::default());
    let (mut out, mut arrived) = ([0; 512], [0; 64]);
    let mut given = session.connect(Token(1), Endpoint::Usb);
    loop {
        if given.is_err() {
            *step = c"kOS: a command was not taken";
        }
        let told = match session.poll(now(), &Source::default(), &mut out) {
            Ok(Next::Transmit(message)) => {
                let Ok(()) = line.write_all(message).await;
                continue;
            }
            Ok(Next::Wait(until)) => {
                let len = wait(&mut line, until, &mut arrived).await;
                let _ = session.receive(now(), &arrived[..len]);
                continue;
            }
            Ok(Next::Broadcast(_)) => continue,
            Ok(Next::Event(event)) => event,
            Err(_) => break *step = c"kOS: a message cannot be written",
        };
        given = match told {
            Event::Connect(_) => {
                session.link_up();
                Ok(())
            }
            Event::Ready { .. } => {
                *step = c"kOS: ready";
                session.jog(Token(2), motor, speed, acceleration)
            }
            Event::Ended { token: Token(2), outcome: Outcome::Sent } => {
                *step = c"kOS: the motor moves";
                Timer::after_millis(100).await;
                session.stop(Token(3))
            }
            Event::MotorRests(MotorAddress(1), position) => {
                rests_at = position;
                Ok(())
            }
            Event::Stopped(StopTarget::All) if (0.1..9.0).contains(&rests_at.0) => {
                *step = c"kOS: the motor rests on its way";
                session.get(Token(4), Get::MotorInfo)
            }
            Event::Ended { token: Token(4), outcome: Outcome::Done(_) } => {
                let knows = |known: &Motor| known.motor_address == motor && known.position == rests_at;
                if session.machine().motors().any(knows) {
                    *step = c"kOS: the motor is known to rest where it was stopped";
                    session.move_to(Token(5), Go { motor, position: begin, speed, acceleration })
                } else {
                    Ok(())
                }
            }
            Event::Ended { token: Token(5), outcome: Outcome::Done(_) } if rests_at == begin => {
                if !session.may_move() {
                    return;
                }
                Ok(())
            }
            _ => Ok(()),
        };
    }
    core::future::pending().await
}
