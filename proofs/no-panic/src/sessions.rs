//! Sessions of both sides, which read unchecked bytes.

use core::fmt::{self, Write};

use motion_core::session::NotTaken;
use motion_core::wire::EncodeError;

use crate::exercise::first;

/// Room for a message. It is too small for some messages, and that must not panic either.
const ROOM: usize = 512;
/// Things that are done for a session before it is told anything else.
const TURNS: usize = 100;

/// Runs each session, and prints what it wants.
pub fn everything(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    kos(input, out)?;
    dmc_host(input, out)?;
    dmc_device(input, out)?;
    hoot(input, out)
}

fn told(told: Result<(), NotTaken>, out: &mut dyn Write) -> fmt::Result {
    if let Err(error) = told { writeln!(out, "{error}") } else { Ok(()) }
}

/// Prints what a session wants. Returns false if it waits, or cannot write a message.
fn turn<N: fmt::Debug>(next: Result<N, EncodeError>, waits: bool, out: &mut dyn Write) -> Result<bool, fmt::Error> {
    match next {
        Ok(next) => writeln!(out, "{next:?}")?,
        Err(error) => writeln!(out, "{error}")?,
    }
    Ok(!waits)
}

fn kos(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use kos_proto::device::{self, DeviceMachine, Report, Sender, SessionId};
    use kos_proto::host::{self, Endpoint, Get, Go, Token};
    use kos_proto::message::{Ipv4, MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared};
    use kos_proto::{Millis, Transport};

    let mut client: host::Session = host::Session::new(host::Options::default());
    let mut device: device::Session<40_000> = device::Session::new(DeviceMachine::new(device::Options::default()));
    let mut plain = device::CommandSession::new(DeviceMachine::without_moves(device::Options::default()));
    told(plain.report(Report::Started), out)?;
    told(plain.link_up(SessionId(0), Transport::Usb), out)?;
    let (mut now, mut room) = (Millis(0), [0; ROOM]);
    for bytes in input.chunks(48) {
        let [what, gap, a, b, ..] = first::<48>(bytes);
        now = now.after(u64::from(gap) * u64::from(b));
        let (token, motor, at) = (Token(a.into()), MotorAddress(b), f32::from(a));
        let (speed, acceleration) = (RotationsPerSecond(at), RotationsPerSecondSquared(at));
        let go = Go { motor, position: Rotations(at), speed, acceleration };
        told(
            match what % 16 {
                0 => client.connect(token, Endpoint::Usb),
                1 => client.stop(token),
                2 => client.stop_motor(token, motor),
                3 => client.get(token, Get::DeviceInfo),
                4 => client.move_to(token, go),
                5 => client.jog(token, motor, speed, acceleration),
                6 => client.bump(token, go),
                7 => client.play(token),
                8 => client.disconnect(token),
                9 => device.link_up(SessionId(b), Transport::Tcp),
                10 => device.link_down(SessionId(b)),
                11 => device.report(Report::Arrived(motor, Rotations(at))),
                12 => {
                    client.link_up();
                    Ok(())
                }
                13 => {
                    client.link_down();
                    Ok(())
                }
                14 => {
                    let sender = Sender { address: Ipv4(a.into()), port: b.into() };
                    writeln!(out, "{}", device.receive_datagram(now, sender, bytes))?;
                    Ok(())
                }
                _ => client.unlock(token),
            },
            out,
        )?;
        if gap == 7 {
            told(device.stop(), out)?;
        }
        writeln!(out, "{} {}", client.may_move(), device.may_move())?;
        writeln!(out, "{} {}", client.receive(now, bytes), device.receive(now, SessionId(b), bytes))?;
        for _ in 0..TURNS {
            let next = client.poll(now, &host::Source::default(), &mut room);
            let waits = matches!(next, Ok(host::Next::Wait(_)) | Err(_));
            if !turn(next, waits, out)? {
                break;
            }
        }
        for _ in 0..TURNS {
            let next = device.poll(now, &device::Source::default(), &mut room);
            let waits = matches!(next, Ok(device::Next::Wait(_)) | Err(_));
            if !turn(next, waits, out)? {
                break;
            }
        }
        writeln!(out, "{}", plain.receive(now, SessionId(0), bytes))?;
        for _ in 0..TURNS {
            let next = plain.poll(now, &device::Source::default(), &mut room);
            let waits = matches!(next, Ok(device::Next::Wait(_)) | Err(_));
            if !turn(next, waits, out)? {
                break;
            }
        }
        writeln!(out, "{client:?} {} {device:?} {plain:?}", client.may_move())?;
    }
    Ok(())
}

fn dmc_host(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use dmc_proto::Millis;
    use dmc_proto::host::{Next, Options, Session, Token};
    use dmc_proto::message::{FrameNumber, Motor, MotorMove, Motors, RtUploadMoveBegin, Steps};
    use dmc_proto::upload::MoveSource;

    struct Ramp;
    impl MoveSource for Ramp {
        fn start_frame(&self) -> FrameNumber {
            FrameNumber(1)
        }
        fn frame_count(&self) -> u32 {
            300
        }
        fn motors(&self) -> Motors {
            Motors(3)
        }
        fn position(&self, motor: Motor, index: u32) -> Steps {
            Steps(i32::from(motor.0).wrapping_mul(index.cast_signed()))
        }
    }

    let mut session = Session::<200>::new(Options::default());
    let (mut now, mut room) = (Millis(0), [0; ROOM]);
    for bytes in input.chunks(48) {
        let [what, gap, a, b, ..] = first::<48>(bytes);
        now = now.after(u64::from(gap) * u64::from(b));
        let (token, motor) = (Token(a.into()), Motor(b));
        told(
            match what % 10 {
                0 => {
                    session.link_up();
                    Ok(())
                }
                1 => {
                    session.link_down();
                    Ok(())
                }
                2 => session.stop(token),
                3 => session.stop_motor(token, motor),
                4 => session.configured(token),
                5 => session.sequence(token, RtUploadMoveBegin::default()),
                6 => session.go(token),
                7 => session.end_stops(token),
                8 => session.greet(token),
                _ => session.request(token, MotorMove { motor, position: Steps(a.into()), tail: &[] }),
            },
            out,
        )?;
        writeln!(out, "{}", session.receive(now, bytes))?;
        for _ in 0..TURNS {
            let next = session.poll(now, &Ramp, &mut room);
            let waits = matches!(next, Ok(Next::Wait(_)) | Err(_));
            if !turn(next, waits, out)? {
                break;
            }
        }
        writeln!(out, "{session:?} {}", session.may_move())?;
    }
    Ok(())
}

fn dmc_device(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use dmc_proto::device::{DeviceMachine, Next, Options, Rig, Session};
    use dmc_proto::message::{FrameNumber, Hi, Motor, Motors, Steps, Triggers};
    use dmc_proto::{Millis, Patience};

    struct Nowhere;
    impl Rig for Nowhere {
        fn verdict(&self, _: &dmc_proto::HostMessage<'_>) -> dmc_proto::message::AckCode {
            dmc_proto::message::AckCode::OK
        }

        fn position(&self, motor: Motor) -> Steps {
            Steps(motor.0.into())
        }
    }

    let [motors, capabilities] = first(input);
    let hi = Hi { motor_count: motors, capabilities: u32::from(capabilities).into(), ..Options::default().hi() };
    let mut session: Session = Session::new(DeviceMachine::new(Options::of(hi)), Patience::default());
    let (mut now, mut room) = (Millis(0), [0; ROOM]);
    for bytes in input.chunks(48) {
        let [what, gap, a, b, ..] = first::<48>(bytes);
        now = now.after(u64::from(gap) * u64::from(b));
        told(
            match what % 10 {
                0 => {
                    session.link_up();
                    Ok(())
                }
                1 => {
                    session.link_down();
                    Ok(())
                }
                2 => session.at_rest(),
                3 => session.at_frame(FrameNumber(a.into())),
                4 => session.pass_end(),
                5 => session.operator_go(),
                6 => session.limit(Motor(a), b > 9),
                7 => session.emergency_stop(a > 9),
                8 => session.inputs(Triggers(a.into())),
                _ => session.moving(Motors(a.into())),
            },
            out,
        )?;
        if gap == 7 {
            told(session.stop(), out)?;
        }
        writeln!(out, "{}", session.may_move())?;
        writeln!(out, "{}", session.receive(now, bytes))?;
        for _ in 0..TURNS {
            let next = session.poll(now, &Nowhere, &mut room);
            let waits = matches!(next, Ok(Next::Wait(_)) | Err(_));
            if !turn(next, waits, out)? {
                break;
            }
        }
        writeln!(out, "{session:?}")?;
    }
    Ok(())
}

fn hoot(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use hoot_proto::device::{self, Command, DeviceMachine, Port};
    use hoot_proto::host::{self, Token};
    use hoot_proto::message::{Motor, Start, Steps, StepsPerSecond};
    use hoot_proto::{Address, Millis};

    let mut master = host::Session::new(host::Options::default());
    let mut node = device::Session::new(DeviceMachine::new(device::Options::default()));
    let (mut now, mut room) = (Millis(0), [0; 30]);
    for bytes in input.chunks(48) {
        let [what, gap, a, b, ..] = first::<48>(bytes);
        now = now.after(u64::from(gap) * u64::from(b));
        let (token, to) = (Token(a.into()), Address(b));
        let port = if b > 99 { Port::Bus } else { Port::Usb };
        told(
            match what % 14 {
                0 => {
                    master.link_up();
                    Ok(())
                }
                1 => {
                    master.link_down();
                    Ok(())
                }
                2 => master.stop(token),
                3 => master.stop_node(token, to),
                4 => master.stop_motor(token, to, Motor::One),
                5 => master.request(token, to, Start {}.into()),
                6 => master.speed(token, to, Motor::Two, StepsPerSecond(a.into())),
                7 => master.keep_alive(token, to, a > 9),
                8 => master.end_emergency(token),
                9 => node.link_up(port),
                10 => node.link_down(port),
                11 => node.position(Motor::One, Steps(a.into())),
                12 => node.arrived(Motor::One),
                _ => node.command(Command::EmergencyStop),
            },
            out,
        )?;
        if gap == 7 {
            told(node.stop(), out)?;
        }
        writeln!(out, "{} {}", master.may_move(), node.may_move())?;
        writeln!(out, "{} {}", master.receive(now, bytes), node.receive(now, port, bytes))?;
        for _ in 0..TURNS {
            let next = master.poll(now, &mut room);
            let waits = matches!(next, Ok(host::Next::Wait(_)) | Err(_));
            if !turn(next, waits, out)? {
                break;
            }
        }
        for _ in 0..TURNS {
            let next = node.poll(now, &mut room);
            let waits = matches!(next, Ok(device::Next::Wait(_)) | Err(_));
            if !turn(next, waits, out)? {
                break;
            }
        }
        writeln!(out, "{master:?} {} {node:?}", master.may_move())?;
    }
    Ok(())
}
