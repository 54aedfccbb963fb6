//! Machines of both sides, driven by unchecked bytes.

use core::fmt::{self, Write};

use crate::exercise::first;

/// Steps each machine, and prints it with its output.
pub fn everything(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    kos(input, out)?;
    dmc_host(input, out)?;
    dmc_device(input, out)?;
    hoot(input, out)
}

/// Reads bytes as events of a device of kOS and its client.
fn kos(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use kos_proto::device::{self, DeviceMachine, Report, Scratch, Sender, SessionId};
    use kos_proto::host::{self, Command, Get, Go, HostMachine, Source, Token};
    use kos_proto::message::{
        AuxInputs, ErrorCode, Ipv4, MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds,
    };
    use kos_proto::message::{MotorSet, Password};
    use kos_proto::{DeviceMessage, Effect, HostMessage, Millis, MoveSummary, Transport};
    use motion_core::wire::Messages;

    let mut device = DeviceMachine::new(device::Options::default().with_motors(MotorSet::of([MotorAddress(1)])));
    let mut host = HostMachine::new(host::Options::default());
    let mut now = 0_u64;
    let mut plan = None;
    for chunk in input.chunks(64) {
        let Some((&[a, b, c, d, e, f, g, h], body)) = chunk.split_first_chunk::<8>() else { continue };
        now = now.wrapping_add(u64::from(u32::from_be_bytes([e, f, g, h])));
        let number = u32::from_be_bytes([a, b, c, d]);
        let float = f32::from_bits(u32::from_be_bytes([b, c, d, e]));
        let session = SessionId(e);
        let password = Password(body);
        let motor = MotorAddress(f);
        let input = match h & 15 {
            0 => device::Input::LinkUp {
                session,
                transport: if g > 9 { Transport::Tcp } else { Transport::Usb },
                password,
            },
            1 => device::Input::LinkDown(session),
            2 => device::Input::Fatal(session),
            3 => device::Input::Wake,
            4 => device::Input::Rig(Report::Started),
            5 => device::Input::Rig(Report::Arrived(motor, Rotations(float))),
            6 => device::Input::Rig(Report::At(motor, Rotations(float))),
            7 => device::Input::Rig(Report::CannotHome(motor)),
            8 => device::Input::Rig(Report::Fault(motor, ErrorCode(g))),
            9 => device::Input::Rig(Report::Online(motor, g > 9)),
            10 => device::Input::Rig(Report::Inputs(AuxInputs(g))),
            x => match HostMessage::decode_body(number, body) {
                Ok(HostMessage::SetTrajectoryData(data)) if x == 11 => {
                    plan = MoveSummary::of(&data).ok();
                    continue;
                }
                Ok(message) if x == 12 => {
                    let from = Sender { address: Ipv4(number), port: g.into() };
                    device::Input::Datagram { from, message }
                }
                Ok(message) => device::Input::Received { session, message, bytes: body, password },
                Err(error) => device::Input::Malformed {
                    session,
                    id: kos_proto::MessageId(g.into()),
                    kind: kos_proto::MessageType(f),
                    error,
                    bytes: body,
                },
            },
        };
        let output = device.advance(Millis(now), input);
        write!(out, "{device:?} {:?}", output.wake)?;
        for effect in output {
            write!(out, "{effect:?}")?;
            match effect {
                Effect::Event(event) => write!(out, "{event}")?,
                Effect::Transmit(transmit) => {
                    let mut scratch = Scratch::default();
                    let source = device::Source { older_dialect: g > 9, ..device::Source::default() };
                    write!(out, "{}", transmit.message(&source, &mut scratch))?;
                }
            }
        }
        let go = Go {
            motor,
            position: Rotations(float),
            speed: RotationsPerSecond(float),
            acceleration: RotationsPerSecondSquared(float),
        };
        let command = match (g & 31, plan) {
            (0, _) => Command::Stop,
            (1, _) => Command::StopMotor(motor),
            (2, _) => Command::Connect(host::Endpoint::Usb),
            (3, _) => Command::Connect(host::Endpoint::Tcp(Ipv4(number))),
            (4, _) => Command::Disconnect,
            (5, _) => Command::Unlock,
            (6, _) => Command::ChangePassword,
            (7, _) => Command::Get(Get::MotorInfo),
            (8, _) => Command::ResetAxis(motor),
            (9, _) => Command::MarkBegin(motor),
            (10, _) => Command::MarkEnd(motor),
            (11, _) => Command::MoveTo(go),
            (12, _) => Command::Bump(go),
            (13, _) => Command::Jog { motor, speed: go.speed, acceleration: go.acceleration },
            (14, _) => Command::Play,
            (15, Some(plan)) => Command::Load { summary: plan, delay_return: f > 3 },
            (16, Some(plan)) => Command::PlayDirect { summary: plan },
            (17, _) => Command::RapidToFirstKeyFrame,
            (18, _) => Command::TakePicture(Seconds(float)),
            (19, _) => Command::ResetDevice,
            _ => Command::Alive,
        };
        let input = match h & 7 {
            0 => host::Input::LinkUp,
            1 => host::Input::LinkDown,
            2 => host::Input::Fatal,
            3 => host::Input::Wake,
            4 | 5 => host::Input::Command(Token(number), command),
            _ => match DeviceMessage::decode_body(number, body) {
                Ok(message) => host::Input::Received(message),
                Err(error) => host::Input::Malformed {
                    id: kos_proto::MessageId(g.into()),
                    kind: kos_proto::MessageType(f),
                    error,
                },
            },
        };
        let output = host.advance(Millis(now), input);
        write!(out, "{host:?} {:?} {}", output.wake, host.may_move())?;
        for effect in output {
            write!(out, "{effect:?}")?;
            match effect {
                Effect::Event(event) => write!(out, "{event}")?,
                Effect::Transmit(transmit) => write!(out, "{}", transmit.message(&Source::default()))?,
            }
        }
    }
    Ok(())
}

/// Reads bytes as events of a host of DMC.
fn dmc_host(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use dmc_proto::host::{Command, HostMachine, Input, Options, StopTarget, Token};
    use dmc_proto::message::{Motor, RtGo};
    use dmc_proto::{DeviceMessage, HostMessage, MessageId, Millis};
    use motion_core::wire::Messages;

    let mut machine = HostMachine::new(Options::default().with_window(first::<1>(input)[0]));
    let mut now = Millis(0);
    for bytes in input.chunks(48) {
        let [what, gap, id, kind, high, ..] = first::<48>(bytes);
        let body = bytes.get(5..).unwrap_or_default();
        now = now.after(u64::from(gap) * u64::from(high));
        let number = u32::from(u16::from_le_bytes([kind, high]));
        let token = Token(id.into());
        let host = HostMessage::decode_body(number, body);
        let input = match (what % 11, host) {
            (0, _) => Input::LinkUp,
            (1, _) => Input::LinkDown,
            (2, Ok(message)) => Input::Command(token, Command::Request(message)),
            (3, Ok(message)) => Input::Command(token, Command::Sequence(message)),
            (4, _) => Input::Command(token, Command::Stop(StopTarget::Motor(Motor(kind)))),
            (5, _) => Input::Command(token, Command::Go),
            (6, _) => Input::Command(token, Command::Configured),
            (7, _) => Input::Section(None),
            (8, _) => Input::Wake,
            _ => match DeviceMessage::decode_body(number, body) {
                Ok(message) => Input::Received(MessageId(id.into()), message),
                Err(_) => Input::Corrupt,
            },
        };
        writeln!(out, "{input:?}")?;
        let output = machine.advance(now, input);
        for transmit in output.transmits() {
            let len = transmit.encode_into(|_| RtGo::default().into(), &mut [0; 1048]);
            writeln!(out, "{len:?}")?;
            if let Some(message) = transmit.message(|_| RtGo::default().into()) {
                writeln!(out, "{message}")?;
            }
        }
        writeln!(out, "{machine:?} {} {output:?}", machine.may_move())?;
        for event in output.events() {
            writeln!(out, "{event}")?;
        }
    }
    Ok(())
}

/// Reads bytes as events of a device of DMC.
fn dmc_device(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use dmc_proto::Effect;
    use dmc_proto::device::{DeviceMachine, Event, Input, Options, Quirks, Report, Rig, Scratch};
    use dmc_proto::message::{AckCode, FrameNumber, Hi, Motor, Motors, Steps, Triggers};
    use dmc_proto::{HostMessage, MessageId, MessageType, Millis};
    use motion_core::wire::Messages;

    struct Nowhere;
    impl Rig for Nowhere {
        fn verdict(&self, _: &dmc_proto::HostMessage<'_>) -> dmc_proto::message::AckCode {
            dmc_proto::message::AckCode::OK
        }

        fn position(&self, motor: Motor) -> Steps {
            Steps(motor.0.into())
        }
    }

    let [motors, capabilities, quirks] = first(input);
    let hi = Hi { motor_count: motors, capabilities: u32::from(capabilities).into(), ..Options::default().hi() };
    let mut machine = DeviceMachine::new(Options::of(hi).with_quirks(Quirks(quirks.into())));
    let mut now = Millis(0);
    for bytes in input.chunks(48) {
        let [what, gap, id, kind, high, ..] = first::<48>(bytes);
        let body = bytes.get(5..).unwrap_or_default();
        now = now.after(u64::from(gap) * u64::from(high));
        let (id, number) = (MessageId(id.into()), u16::from_le_bytes([kind, high]));
        let input = match what % 16 {
            0 => Input::LinkUp,
            1 => Input::LinkDown,
            2 => Input::Rig(Report::AtRest),
            3 => Input::Rig(Report::AtFrame(FrameNumber(i32::from(number)))),
            4 => Input::Rig(Report::PassEnd),
            5 => Input::Rig(Report::OperatorGo),
            6 => Input::Rig(Report::Limit { motor: Motor(kind), upper: high > 9 }),
            7 => Input::Rig(Report::EmergencyStop(kind > 9)),
            8 => Input::Rig(Report::Inputs(Triggers(kind.into()))),
            9 => Input::Rig(Report::Moving(Motors(kind.into()))),
            10 => Input::Corrupt(id, MessageType(number)),
            11 => Input::Wake,
            _ => match HostMessage::decode_body(number.into(), body) {
                Ok(message) => Input::Received { id, message, rig: AckCode::OK },
                Err(_) => Input::Malformed(id, MessageType(number)),
            },
        };
        writeln!(out, "{input:?}")?;
        let output = machine.advance(now, input);
        writeln!(out, "{machine:?} {output:?}")?;
        for effect in output {
            match effect {
                Effect::Event(Event::Store { store, .. }) => {
                    writeln!(out, "{:?}", machine.advance(now, Input::Rig(Report::Stored(store, AckCode::OK))))?;
                }
                Effect::Event(event) => writeln!(out, "{event}")?,
                Effect::Transmit(transmit) => {
                    writeln!(out, "{}", transmit.message(&Nowhere, &mut Scratch::default()))?;
                }
            }
        }
    }
    Ok(())
}

/// Reads bytes as events of a node of hoot and the master on its bus.
fn hoot(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use hoot_proto::device::{self, DeviceMachine, Port};
    use hoot_proto::host::{self, Command, HostMachine, Nodes, Request, Token};
    use hoot_proto::message::{Motor, Steps, StepsPerSecond};
    use hoot_proto::{Address, DeviceMessage, HostMessage, Millis};
    use motion_core::wire::Messages;

    let mut node = DeviceMachine::new(device::Options::default());
    let mut master = HostMachine::new(host::Options::default());
    let mut now = Millis(0);
    for bytes in input.chunks(40) {
        let [what, gap, to, table, command, sub_address, ..] = first::<40>(bytes);
        let body = bytes.get(6..).unwrap_or_default();
        now = now.after(u64::from(gap) * u64::from(sub_address));
        let (to, number) = (Address(to), u32::from_be_bytes([0, table % 3, command, sub_address]));
        let motor = if gap > 9 { Motor::One } else { Motor::Three };
        let message = HostMessage::decode_or_other(number, body);
        let report = match what % 12 {
            0 => device::Input::Noise,
            1 => device::Input::LinkDown(Port::Usb),
            2 => device::Input::Position { motor, position: Steps(i32::from_be_bytes(first(body))) },
            3 => device::Input::Arrived(motor),
            4 => device::Input::Fault(motor),
            5 => device::Input::Command(device::Command::Start),
            6 => device::Input::Command(device::Command::EmergencyStop),
            7 => device::Input::Wake,
            _ => device::Input::Received { port: Port::Bus, to, message },
        };
        let output = node.advance(now, report);
        writeln!(out, "{node:?} {output:?}")?;
        for event in output.events() {
            writeln!(out, "{event}")?;
        }
        for transmit in output.transmits() {
            writeln!(out, "{:?}", transmit.encode_into(&mut [0; 42]).is_ok())?;
        }
        let token = Token(number);
        let happened = match what % 13 {
            0 => host::Input::LinkUp,
            1 => host::Input::LinkDown,
            2 => host::Input::Noise,
            3 => host::Input::Wake,
            4 => host::Input::Command(token, Command::EmergencyStop),
            5 => host::Input::Command(token, Command::EndEmergency),
            6 => host::Input::Command(token, Command::KeepAlive { to, on: gap > 9 }),
            7 => host::Input::Command(
                token,
                Command::Speed { to, motor, speed: StepsPerSecond(f32::from_be_bytes(first(body))) },
            ),
            8 => host::Input::Command(token, Command::Nodes(Nodes::NONE.with(to).unwrap_or_default())),
            // A request of the application lives as long as the program. The bytes that it needs are in no packet.
            9 | 10 => match HostMessage::decode_body(number, &[]) {
                Ok(message) => host::Input::Command(token, Command::Request(Request { to, message })),
                Err(_) => host::Input::Wake,
            },
            _ => match DeviceMessage::decode_body(u32::from(command), body) {
                Ok(message) => host::Input::Received(message),
                Err(_) => host::Input::Noise,
            },
        };
        let output = master.advance(now, happened);
        writeln!(out, "{master:?} {} {output:?}", master.may_move())?;
        for event in output.events() {
            writeln!(out, "{event}")?;
        }
        for transmit in output.transmits() {
            writeln!(out, "{:?}", transmit.encode_into(&mut [0; 42]).is_ok())?;
        }
    }
    Ok(())
}
