//! A device and a host on the bench: what is put in, and what comes out.

use dmc_proto::device::{self, DeviceMachine, Rig, Scratch};
use dmc_proto::host::{self, Command, HostMachine, Token};
use dmc_proto::message::{
    Ack, AckCode, Capabilities, Empty, FrameNumber, FramesPerSecond, Hi, HostMessage, JogSpeed, Milliseconds, Motor,
    MotorJog, MotorMove, MotorStatus, MotorStop, MotorStopAll, Motors, MoveTime, Name, RtJogAll, RtPositionFrame,
    RtRunMove, RtShootFrame2, RtUploadMoveAxis, RtUploadMoveBegin, RunFlags, ShortMilliseconds, StartIndex, Steps,
    VirtConfig, VirtualPosition,
};
use dmc_proto::{DeviceMessage, MessageId, MessageType};
use motion_core::fixed::Scaled;
use motion_core::time::Millis;
use zerocopy::little_endian::I32;

pub(crate) const EMPTY: Empty<'static> = Empty { tail: &[] };

/// A rig that can do everything, with eight motors.
pub(crate) fn hi() -> Hi<'static> {
    Hi {
        name: Name::new("bench").unwrap(),
        fw_major: 1,
        fw_minor: 2,
        fw_rev: 3,
        motor_count: 8,
        dmx_count: 100,
        gio_out_count: 4,
        gio_in_count: 4,
        hw_limit_count: 2,
        upload_frame_count: 1000,
        capabilities: Capabilities(0x07ff),
        protocol_version: Some(2),
        tail: &[],
    }
}

pub(crate) fn frame(frame: i32) -> FrameNumber {
    FrameNumber(frame)
}

pub(crate) fn move_to(motor: u8, position: i32) -> HostMessage<'static> {
    HostMessage::MotorMove(MotorMove { motor: Motor(motor), position: Steps(position), tail: &[] })
}

pub(crate) fn jog(motor: u8) -> HostMessage<'static> {
    HostMessage::MotorJog(MotorJog {
        motor: Motor(motor),
        speed: JogSpeed::FULL,
        destination: Steps(i32::MAX),
        tail: &[],
    })
}

pub(crate) fn stop(motor: u8) -> HostMessage<'static> {
    HostMessage::MotorStop(MotorStop { motor: Motor(motor), tail: &[] })
}

pub(crate) fn stop_all() -> HostMessage<'static> {
    HostMessage::MotorStopAll(MotorStopAll { flags: None, tail: &[] })
}

pub(crate) fn begin(first: i32, last: i32) -> HostMessage<'static> {
    HostMessage::RtUploadMoveBegin(RtUploadMoveBegin { start_frame: frame(first), end_frame: frame(last), tail: &[] })
}

pub(crate) fn axis(motor: u8) -> HostMessage<'static> {
    let (start_index, positions) = (StartIndex::new(0, true).unwrap(), &[I32::ZERO; 2]);
    HostMessage::RtUploadMoveAxis(RtUploadMoveAxis { motor: Motor(motor), start_index, positions, tail: &[] })
}

pub(crate) fn position_frame(number: i32) -> HostMessage<'static> {
    HostMessage::RtPositionFrame(RtPositionFrame { frame: frame(number), tail: &[] })
}

pub(crate) fn jog_all(destination: i32) -> HostMessage<'static> {
    let fps_x1000 = FramesPerSecond(Scaled(24_000));
    HostMessage::RtJogAll(RtJogAll { fps_x1000, destination: frame(destination), tail: &[] })
}

pub(crate) fn run(start: i32, end: i32, flags: RunFlags) -> HostMessage<'static> {
    HostMessage::RtRunMove(RtRunMove {
        fps_x1000: FramesPerSecond(Scaled(10_000)),
        start_frame: frame(start),
        end_frame: frame(end),
        pre_roll_ms: Milliseconds(200),
        post_roll_ms: Milliseconds(100),
        sync_dmx: false.into(),
        bloop_location: 0.into(),
        bloop_dmx_channel: 0.into(),
        bloop_ms: ShortMilliseconds(0),
        flags: Some(flags),
        open_angle: None,
        close_angle: None,
        tail: &[],
    })
}

pub(crate) fn shot(number: i32) -> HostMessage<'static> {
    HostMessage::RtShootFrame2(RtShootFrame2 {
        frame: frame(number),
        exposure_ms: Milliseconds(500),
        open_angle: 0.into(),
        close_angle: 180.into(),
        motors: &[],
        tail: &[],
    })
}

/// A virtual rig of a kind whose layout is a few bytes: swing and pan.
pub(crate) const SWING_PAN: [u8; 17] = [2, 1, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0];

pub(crate) fn virtuals(body: &[u8]) -> HostMessage<'_> {
    use motion_core::wire::Message;
    HostMessage::VirtConfig(VirtConfig::decode(body).unwrap())
}

pub(crate) fn virtual_position(units: i32) -> VirtualPosition {
    VirtualPosition(Scaled(units))
}

/// Motors stand at ten times their number.
pub(crate) struct Tens;

impl Rig for Tens {
    fn position(&self, motor: Motor) -> Steps {
        Steps(10 * i32::from(motor.0))
    }
}

/// What a device sent, in a form that is easy to compare.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Said {
    Ack(u32, u16, AckCode),
    /// The time in the move, in frames.
    Positions(u32, i32),
    Other(u32, device::What),
}

pub(crate) const UNASKED: u32 = 0;

/// A device that is driven by hand.
pub(crate) struct Bench {
    pub(crate) machine: DeviceMachine,
    pub(crate) now: Millis,
    pub(crate) wake: Option<Millis>,
    id: u32,
}

pub(crate) type Out = (Vec<Said>, Vec<device::Event>);

impl Bench {
    pub(crate) fn new() -> Self {
        Self::of(device::Options::of(hi()))
    }

    pub(crate) fn of(options: device::Options) -> Self {
        Self { machine: DeviceMachine::new(options), now: Millis(1000), wake: None, id: 100 }
    }

    /// Takes a step; what it sends is also made into bytes and read back, as the host would.
    pub(crate) fn step(&mut self, input: device::Input<'_>) -> Out {
        let (machine, output) = laws::machine::step(self.machine.clone(), self.now, input);
        (self.machine, self.wake) = (machine, output.wake);
        let mut said = Vec::new();
        for send in &output.send {
            let mut scratch = Scratch::default();
            let message = send.message(&Tens, &mut scratch);
            let mut bytes = [0; 256];
            let len = message.encode_into(send.id, &mut bytes).unwrap();
            let frame = dmc_proto::Frame::decode(&bytes[..len]).unwrap();
            assert_eq!(DeviceMessage::decode(&frame), Ok(message));
            said.push(match message {
                DeviceMessage::Ack(Ack { of, response_code, .. }) => Said::Ack(send.id.0, of.0, response_code.unwrap()),
                DeviceMessage::MotorGetPosition(positions) => {
                    let expected: Vec<_> = (1..=8).map(|motor| I32::new(10 * motor)).collect();
                    assert_eq!(positions.positions, expected);
                    let MoveTime(Scaled(time)) = positions.move_time;
                    assert_eq!(time % 1000, 0);
                    Said::Positions(send.id.0, time / 1000)
                }
                _ => Said::Other(send.id.0, send.what),
            });
        }
        (said, output.events.into_iter().collect())
    }

    /// A message arrives, that the rig has nothing against. Its id is 101, then 102, and so on.
    pub(crate) fn asked(&mut self, message: HostMessage<'_>) -> Out {
        self.asked_with(message, AckCode::OK)
    }

    pub(crate) fn asked_with(&mut self, message: HostMessage<'_>, rig: AckCode) -> Out {
        self.id += 1;
        self.step(device::Input::Received { id: MessageId(self.id), message, rig })
    }

    /// The answer to a request must be this code alone, and nothing be done.
    pub(crate) fn refuses(&mut self, message: HostMessage<'_>, code: AckCode) {
        let state = self.machine.state();
        let (said, events) = self.asked(message);
        let expected = (vec![Said::Ack(self.id, message.kind().0, code)], vec![]);
        assert_eq!((said, events), expected, "{message} in {state:?}");
        assert_eq!(self.machine.state(), state);
    }

    /// The answer must be OK, and this the only event.
    pub(crate) fn takes(&mut self, message: HostMessage<'_>, event: device::Event) {
        let state = self.machine.state();
        let (said, events) = self.asked(message);
        let expected = (vec![Said::Ack(self.id, message.kind().0, AckCode::OK)], vec![event]);
        assert_eq!((said, events), expected, "{message} in {state:?}");
    }

    pub(crate) fn ack(&self, message: &HostMessage<'_>, code: AckCode) -> Said {
        Said::Ack(self.id, message.kind().0, code)
    }

    pub(crate) fn id(&self) -> u32 {
        self.id
    }

    /// Time passes, and the machine is woken at every moment that it asks for.
    pub(crate) fn pass(&mut self, millis: u64) -> Out {
        let end = self.now.after(millis);
        let (mut said, mut events) = (vec![], vec![]);
        while let Some(wake) = self.wake.filter(|&wake| wake <= end) {
            self.now = wake;
            let (more, told) = self.step(device::Input::Wake);
            said.extend(more);
            events.extend(told);
        }
        self.now = end;
        (said, events)
    }

    /// Gives a message of an upload to a buffer that takes it.
    pub(crate) fn store(&mut self, message: HostMessage<'_>) -> Said {
        let (said, events) = self.asked(message);
        assert_eq!(said, []);
        let [device::Event::Store(store)] = events[..] else { panic!("{events:?}") };
        let (said, events) = self.step(device::Input::Stored(store, AckCode::OK));
        assert_eq!(events, []);
        let [said] = &said[..] else { panic!("{said:?}") };
        said.clone()
    }

    /// A device with a move of motors 1 and 2 from frame 1 to 10.
    pub(crate) fn loaded() -> Self {
        let mut bench = Self::new();
        bench.load();
        bench
    }

    pub(crate) fn load(&mut self) {
        for message in [begin(1, 10), axis(1), axis(2), HostMessage::RtUploadMoveEnd(EMPTY)] {
            assert_eq!(self.store(message), self.ack(&message, AckCode::OK));
        }
        assert!(self.machine.is_loaded());
    }

    /// The same, standing on frame 1.
    pub(crate) fn on_frame() -> Self {
        let mut bench = Self::loaded();
        bench.takes(position_frame(1), device::Event::ToFrame(frame(1)));
        bench.rests();
        assert_eq!(bench.machine.on_frame(), Some(frame(1)));
        bench
    }

    /// The rig comes to rest.
    pub(crate) fn rests(&mut self) -> Out {
        self.step(device::Input::AtRest)
    }

    pub(crate) fn state(&self) -> device::State {
        self.machine.state()
    }

    /// A device in each of its states, with what led there: for rows that hold in any state.
    pub(crate) fn everywhere() -> Vec<Self> {
        use device::Input;
        let benches = device::State::ALL.map(|state| {
            let mut bench = Self::on_frame();
            match state {
                device::State::Idle => {}
                device::State::Moving => drop(bench.asked(jog(3))),
                device::State::Stopping => {
                    bench.asked(jog(3));
                    bench.asked(stop_all());
                }
                device::State::ToFrame => drop(bench.asked(position_frame(2))),
                device::State::JogAll => drop(bench.asked(jog_all(5))),
                device::State::PreRoll => drop(bench.asked(run(1, 10, RunFlags::LOOP))),
                device::State::Ready => {
                    bench.asked(run(1, 10, RunFlags::LOOP));
                    bench.rests();
                }
                device::State::Running => {
                    bench.asked(run(1, 10, RunFlags::LOOP));
                    bench.rests();
                    bench.asked(HostMessage::RtGo(EMPTY));
                }
                device::State::PostRoll => {
                    bench.asked(run(1, 10, RunFlags(0)));
                    bench.rests();
                    bench.asked(HostMessage::RtGo(EMPTY));
                    bench.step(Input::PassEnd);
                }
                device::State::Locked => drop(bench.step(Input::Limit { motor: Motor(2), upper: true })),
                state => panic!("no way to {state:?}"),
            }
            assert_eq!(bench.state(), state);
            bench
        });
        benches.into()
    }
}

/// A host that is driven by hand.
#[derive(Clone)]
pub(crate) struct Desk {
    pub(crate) machine: HostMachine,
    pub(crate) now: Millis,
    pub(crate) wake: Option<Millis>,
}

/// What a host sent, and what its application was told.
pub(crate) type Told = (Vec<(u32, host::What)>, Vec<host::Event>);

impl Desk {
    pub(crate) fn new() -> Self {
        Self::of(host::Options::default())
    }

    pub(crate) fn of(options: host::Options) -> Self {
        Self { machine: HostMachine::new(options), now: Millis(1000), wake: None }
    }

    /// A host that is up, with a device that can do everything. The last id is 1.
    pub(crate) fn up() -> Self {
        Self::up_with(host::Options::default(), hi())
    }

    pub(crate) fn up_with(options: host::Options, hi: Hi<'_>) -> Self {
        let mut desk = Self::of(options);
        assert_eq!(desk.step(host::Input::LinkUp), (vec![(1, host::What::Greeting)], vec![]));
        assert_eq!(desk.hears(1, DeviceMessage::Hi(hi)), (vec![], vec![host::Event::Greeted]));
        assert_eq!(desk.command(Command::Configured), (vec![], vec![host::Event::Up]));
        desk
    }

    pub(crate) fn step(&mut self, input: host::Input<'_>) -> Told {
        let (machine, output) = laws::machine::step(self.machine.clone(), self.now, input);
        (self.machine, self.wake) = (machine, output.wake);
        let sent = output.send.iter().map(|send| (send.id.0, send.what)).collect();
        (sent, output.events.into_iter().collect())
    }

    pub(crate) fn hears(&mut self, id: u32, message: DeviceMessage<'_>) -> Told {
        self.step(host::Input::Received(MessageId(id), message))
    }

    /// The device acknowledges.
    pub(crate) fn acked(&mut self, id: u32, of: u16, code: AckCode) -> Told {
        self.hears(id, DeviceMessage::Ack(Ack::new(MessageType(of), code)))
    }

    /// The device says which motors move.
    pub(crate) fn status(&mut self, id: u32, motors: u32) -> Told {
        let motor_status = Motors(motors);
        self.hears(id, DeviceMessage::MotorStatus(MotorStatus { motor_status, dmx_status: false.into(), tail: &[] }))
    }

    pub(crate) fn command(&mut self, command: Command<'_>) -> Told {
        self.step(host::Input::Command(command))
    }

    pub(crate) fn request(&mut self, token: u32, message: HostMessage<'_>) -> Told {
        self.command(Command::Request(Token(token), message))
    }

    pub(crate) fn sequence(&mut self, token: u32, message: HostMessage<'_>) -> Told {
        self.command(Command::Sequence(Token(token), message))
    }

    pub(crate) fn stop(&mut self, stop: host::Stop) -> Told {
        self.command(Command::Stop(stop))
    }

    /// Time passes, and the machine is woken at every moment that it asks for.
    pub(crate) fn pass(&mut self, millis: u64) -> Told {
        let end = self.now.after(millis);
        let (mut sent, mut events) = (vec![], vec![]);
        while let Some(wake) = self.wake.filter(|&wake| wake <= end) {
            self.now = wake;
            let (more, told) = self.step(host::Input::Wake);
            sent.extend(more);
            events.extend(told);
        }
        self.now = end;
        (sent, events)
    }
}

/// The message of the application's that has this token.
pub(crate) const fn named(token: u32) -> host::What {
    host::What::Named(host::Name::Message(Token(token)))
}
