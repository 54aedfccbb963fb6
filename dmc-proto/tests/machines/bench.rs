//! Device and host alone: inputs given by hand, and outputs in a form that is easy to compare.

use dmc_proto::device::{self, DeviceMachine, Scratch};
use dmc_proto::host::{self, Command, Event, Failure, HostMachine, Outcome, Refusal};
use dmc_proto::message::{
    Ack, AckCode, Bool, FrameNumber, FramesPerSecond, Hi, HostMessage, I32, JogSpeed, Milliseconds, Motor, MotorJog,
    MotorMove, MotorStatus, MotorStop, MotorStopAll, Motors, MoveTime, RtGo, RtJogAll, RtPositionFrame, RtRunMove,
    RtShootFrame2, RtUploadMoveAxis, RtUploadMoveBegin, RtUploadMoveEnd, RunFlags, Scaled, StartIndex, Steps,
    VirtConfig, VirtualPosition,
};
use dmc_proto::{DeviceMessage, MessageId, MessageType, Millis, Token};

use super::app::{Tens, stops_go_first, the_rig_acts_first};

pub(crate) use super::app::hi;

pub(crate) fn frame(frame: i32) -> FrameNumber {
    FrameNumber(frame)
}

pub(crate) fn move_to(motor: u8, position: i32) -> HostMessage<'static> {
    MotorMove { motor: Motor(motor), position: Steps(position), tail: &[] }.into()
}

pub(crate) fn jog(motor: u8) -> HostMessage<'static> {
    MotorJog { motor: Motor(motor), speed: JogSpeed::FULL, destination: Steps(i32::MAX), tail: &[] }.into()
}

pub(crate) fn stop(motor: u8) -> HostMessage<'static> {
    MotorStop { motor: Motor(motor), tail: &[] }.into()
}

pub(crate) fn stop_all() -> HostMessage<'static> {
    MotorStopAll { flags: None, tail: &[] }.into()
}

pub(crate) fn begin(first: i32, last: i32) -> HostMessage<'static> {
    RtUploadMoveBegin { start_frame: frame(first), end_frame: frame(last), tail: &[] }.into()
}

pub(crate) fn axis(motor: u8) -> HostMessage<'static> {
    let (start_index, positions) = (StartIndex::new(0, true).unwrap(), &[I32::ZERO; 2]);
    RtUploadMoveAxis { motor: Motor(motor), start_index, positions, tail: &[] }.into()
}

pub(crate) fn position_frame(number: i32) -> HostMessage<'static> {
    RtPositionFrame { frame: frame(number), tail: &[] }.into()
}

pub(crate) fn jog_all(destination: i32) -> HostMessage<'static> {
    let fps_x1000 = FramesPerSecond(Scaled(24_000));
    RtJogAll { fps_x1000, destination: frame(destination), tail: &[] }.into()
}

pub(crate) fn run(start: i32, end: i32, flags: RunFlags) -> HostMessage<'static> {
    RtRunMove {
        fps_x1000: FramesPerSecond(Scaled(10_000)),
        start_frame: frame(start),
        end_frame: frame(end),
        pre_roll_ms: Milliseconds(200),
        post_roll_ms: Milliseconds(100),
        flags: Some(flags),
        ..RtRunMove::default()
    }
    .into()
}

pub(crate) fn shot(number: i32) -> HostMessage<'static> {
    RtShootFrame2 {
        frame: frame(number),
        exposure_ms: Milliseconds(500),
        open_angle: 0.into(),
        close_angle: 180.into(),
        motors: &[],
        tail: &[],
    }
    .into()
}

/// Configuration of a virtual rig with a short layout: swing and pan.
pub(crate) const SWING_PAN: [u8; 17] = [2, 1, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0];

pub(crate) fn virtuals(body: &[u8]) -> HostMessage<'_> {
    use motion_core::wire::Message;
    VirtConfig::decode(body).unwrap().into()
}

pub(crate) fn virtual_position(units: i32) -> VirtualPosition {
    VirtualPosition(Scaled(units))
}

/// Message of a device, in a form that is easy to compare.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Said {
    Ack(u32, u16, AckCode),
    /// Positions, with the id and the time in the move in frames.
    Positions(u32, i32),
    Other(u32, device::Contents),
}

pub(crate) const UNASKED: u32 = 0;

/// Device alone.
pub(crate) struct Bench {
    pub(crate) machine: DeviceMachine,
    pub(crate) now: Millis,
    pub(crate) wake: Option<Millis>,
    id: u32,
}

/// Messages of a device, and events for its rig.
pub(crate) type Out<'a> = (Vec<Said>, Vec<device::Event<'a>>);

fn said(transmit: &device::Transmit) -> Said {
    let mut scratch = Scratch::default();
    let message = transmit.message(&Tens, &mut scratch);
    let mut bytes = [0; 256];
    let len = message.encode_into(transmit.id, &mut bytes).unwrap();
    let frame = dmc_proto::Frame::decode(&bytes[..len]).unwrap();
    assert_eq!(DeviceMessage::decode(&frame), Ok(message));
    match message {
        DeviceMessage::Ack(Ack { of, response_code, .. }) => Said::Ack(transmit.id.0, of.0, response_code.unwrap()),
        DeviceMessage::MotorGetPosition(positions) => {
            let expected: Vec<_> = (1..=8).map(|motor| I32::new(10 * motor)).collect();
            assert_eq!(positions.positions, expected);
            let MoveTime(Scaled(time)) = positions.move_time;
            assert_eq!(time % 1000, 0);
            Said::Positions(transmit.id.0, time / 1000)
        }
        _ => Said::Other(transmit.id.0, transmit.contents),
    }
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self::of(device::Options::of(hi()))
    }

    pub(crate) fn of(options: device::Options) -> Self {
        Self { machine: DeviceMachine::new(options), now: Millis(1000), wake: None, id: 100 }
    }

    /// Takes a step. Each message is also encoded and decoded, as on a line.
    pub(crate) fn step<'a>(&mut self, input: device::Input<'a>) -> Out<'a> {
        let (machine, output) = laws::machine::step(self.machine.clone(), self.now, input);
        (self.machine, self.wake) = (machine, output.wake);
        the_rig_acts_first(&output);
        let said = output.transmits().map(said).collect();
        (said, output.events().copied().collect())
    }

    /// Receives a message that the rig allows. The ids are 101, 102, and so on.
    pub(crate) fn asked<'a>(&mut self, message: HostMessage<'a>) -> Out<'a> {
        self.asked_with(message, AckCode::OK)
    }

    pub(crate) fn asked_with<'a>(&mut self, message: HostMessage<'a>, rig: AckCode) -> Out<'a> {
        self.id += 1;
        self.step(device::Input::Received { id: MessageId(self.id), message, rig })
    }

    /// Checks that a request is answered by this code, and that nothing is done.
    pub(crate) fn refuses(&mut self, message: HostMessage<'_>, code: AckCode) {
        let state = self.machine.state();
        let (said, events) = self.asked(message);
        let expected = (vec![Said::Ack(self.id, message.kind().0, code)], vec![]);
        assert_eq!((said, events), expected, "{message} in {state:?}");
        assert_eq!(self.machine.state(), state);
    }

    /// Checks that a request is acknowledged, with this event alone.
    pub(crate) fn takes<'a>(&mut self, message: HostMessage<'a>, event: device::Event<'a>) {
        let state = self.machine.state();
        let (said, events) = self.asked(message);
        let expected = (vec![Said::Ack(self.id, message.kind().0, AckCode::OK)], vec![event]);
        assert_eq!((said, events), expected, "{message} in {state:?}");
    }

    /// Checks that a request is acknowledged, with this event of the message alone.
    pub(crate) fn takes_as<'a>(&mut self, message: HostMessage<'a>, event: fn(HostMessage<'a>) -> device::Event<'a>) {
        self.takes(message, event(message));
    }

    pub(crate) fn ack(&self, message: &HostMessage<'_>, code: AckCode) -> Said {
        Said::Ack(self.id, message.kind().0, code)
    }

    pub(crate) fn id(&self) -> u32 {
        self.id
    }

    /// Lets time pass. The machine is woken whenever it wants to be.
    pub(crate) fn pass(&mut self, millis: u64) -> Out<'static> {
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

    /// Receives a message of an upload, which the buffer accepts.
    pub(crate) fn store(&mut self, message: HostMessage<'_>) -> Said {
        let (said, events) = self.asked(message);
        assert_eq!(said, []);
        let [device::Event::Store { store, message: stored }] = events[..] else { panic!("{events:?}") };
        assert_eq!(stored, message);
        let (said, events) = self.step(device::Input::Rig(device::Report::Stored(store, AckCode::OK)));
        assert_eq!(events, []);
        let [said] = &said[..] else { panic!("{said:?}") };
        said.clone()
    }

    /// Device with a move of motors 1 and 2 from frame 1 to 10.
    pub(crate) fn loaded() -> Self {
        let mut bench = Self::new();
        bench.load();
        bench
    }

    /// Device with quirks and a move of motors 1 and 2, on frame 1.
    pub(crate) fn quirky(quirks: device::Quirks) -> Self {
        let mut bench = Self::of(device::Options::of(hi()).with_quirks(quirks));
        bench.load();
        bench.asked(position_frame(1));
        bench.rests();
        bench
    }

    pub(crate) fn load(&mut self) {
        for message in [begin(1, 10), axis(1), axis(2), RtUploadMoveEnd::default().into()] {
            assert_eq!(self.store(message), self.ack(&message, AckCode::OK));
        }
        assert!(self.machine.is_loaded());
    }

    /// Device with this move, on frame 1.
    pub(crate) fn on_frame() -> Self {
        let mut bench = Self::loaded();
        bench.takes(position_frame(1), device::Event::ToFrame(frame(1)));
        bench.rests();
        assert_eq!(bench.machine.on_frame(), Some(frame(1)));
        bench
    }

    /// Reports that all motors rest.
    pub(crate) fn rests(&mut self) -> Out<'static> {
        self.step(device::Input::Rig(device::Report::AtRest))
    }

    pub(crate) fn state(&self) -> device::State {
        self.machine.state()
    }

    /// Devices in every state.
    pub(crate) fn everywhere() -> Vec<Self> {
        use device::{Input, Report};
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
                    bench.asked(RtGo::default().into());
                }
                device::State::PostRoll => {
                    bench.asked(run(1, 10, RunFlags(0)));
                    bench.rests();
                    bench.asked(RtGo::default().into());
                    bench.step(Input::Rig(Report::PassEnd));
                }
                device::State::Locked => drop(bench.step(Input::Rig(Report::Limit { motor: Motor(2), upper: true }))),
                state => panic!("no way to {state:?}"),
            }
            assert_eq!(bench.state(), state);
            bench
        });
        benches.into()
    }
}

/// Host alone.
#[derive(Clone)]
pub(crate) struct Desk {
    pub(crate) machine: HostMachine,
    pub(crate) now: Millis,
    pub(crate) wake: Option<Millis>,
    /// Number of zero bytes that were sent. They are left out of the messages.
    pub(crate) padding: u32,
}

/// Messages of a host with their ids, and events for its application.
pub(crate) type Seen<'a> = (Vec<(u32, host::Contents)>, Vec<Event<'a>>);

/// Token of commands other than requests and sequences.
pub(crate) const COMMAND: Token = Token(1000);

pub(crate) const fn ended(token: u32, outcome: Outcome<'_>) -> Event<'_> {
    Event::Ended { token: Token(token), outcome }
}

pub(crate) const fn done(token: u32) -> Event<'static> {
    ended(token, Outcome::Done(None))
}

pub(crate) const fn answered(token: u32, message: DeviceMessage<'_>) -> Event<'_> {
    ended(token, Outcome::Done(Some(message)))
}

pub(crate) const fn failed(token: u32, failure: Failure) -> Event<'static> {
    ended(token, Outcome::Failed(failure))
}

pub(crate) const fn refused(token: u32, refusal: Refusal) -> Event<'static> {
    ended(token, Outcome::Refused(refusal))
}

pub(crate) const fn not_confirmed(token: u32) -> Event<'static> {
    ended(token, Outcome::NotConfirmed)
}

/// Status of a device.
pub(crate) const fn status(motors: u32) -> DeviceMessage<'static> {
    let motor_status = Motors(motors);
    DeviceMessage::MotorStatus(MotorStatus { motor_status, dmx_status: Bool(0), tail: &[] })
}

/// Acknowledgement of a device.
pub(crate) fn ack(of: u16, code: AckCode) -> DeviceMessage<'static> {
    Ack::new(MessageType(of), code).into()
}

impl Desk {
    pub(crate) fn new() -> Self {
        Self::of(host::Options::default())
    }

    pub(crate) fn of(options: host::Options) -> Self {
        Self { machine: HostMachine::new(options), now: Millis(1000), wake: None, padding: 0 }
    }

    /// Host that is ready, and whose device has every capability. The last id is 1.
    pub(crate) fn up() -> Self {
        Self::up_with(host::Options::default(), hi())
    }

    /// Host that is ready, and that does not want motors to be enabled: most tests are about something else.
    pub(crate) fn up_with(options: host::Options, hi: Hi<'static>) -> Self {
        let mut desk = Self::of(options.with_needs_enabled(false));
        desk.becomes_ready(1, hi);
        desk
    }

    /// Opens the link and makes the host ready. `id` is that of the greeting.
    pub(crate) fn becomes_ready(&mut self, id: u32, hi: Hi<'static>) {
        assert_eq!(self.step(host::Input::LinkUp), (vec![(id, host::Contents::Greeting)], vec![]));
        assert_eq!(self.receives(id, hi.into()), (vec![], vec![Event::Greeted(hi)]));
        let (sent, events) = self.command(Command::Configured);
        assert_eq!((sent, events), (vec![], vec![Event::Ready { reconnected: id != 1 }]));
    }

    pub(crate) fn step<'a>(&mut self, input: host::Input<'a>) -> Seen<'a> {
        let (machine, output) = laws::machine::step(self.machine.clone(), self.now, input);
        (self.machine, self.wake) = (machine, output.wake);
        stops_go_first(&output);
        let mut sent: Vec<_> = output.transmits().map(|transmit| (transmit.id.0, transmit.contents)).collect();
        sent.retain(|(_, contents)| {
            let host::Contents::Padding(len) = contents else { return true };
            self.padding += u32::from(*len);
            false
        });
        (sent, output.events().copied().collect())
    }

    pub(crate) fn receives<'a>(&mut self, id: u32, message: DeviceMessage<'a>) -> Seen<'a> {
        self.step(host::Input::Received(MessageId(id), message))
    }

    /// Receives an acknowledgement.
    pub(crate) fn acked(&mut self, id: u32, of: u16, code: AckCode) -> Seen<'static> {
        self.receives(id, ack(of, code))
    }

    /// Receives a status.
    pub(crate) fn status(&mut self, id: u32, motors: u32) -> Seen<'static> {
        self.receives(id, status(motors))
    }

    /// Gives a command. Its end is left out of the events if it is done or sent.
    pub(crate) fn command<'a>(&mut self, command: Command<'a>) -> Seen<'a> {
        let (sent, mut events) = self.step(host::Input::Command(COMMAND, command));
        let is_plain = |event: &Event<'_>| *event == done(COMMAND.0) || *event == ended(COMMAND.0, Outcome::Sent);
        events.retain(|event| !is_plain(event));
        (sent, events)
    }

    pub(crate) fn request<'a>(&mut self, token: u32, message: HostMessage<'a>) -> Seen<'a> {
        self.step(host::Input::Command(Token(token), Command::Request(message)))
    }

    pub(crate) fn sequence<'a>(&mut self, token: u32, message: HostMessage<'a>) -> Seen<'a> {
        self.step(host::Input::Command(Token(token), Command::Sequence(message)))
    }

    pub(crate) fn stop(&mut self, target: host::StopTarget) -> Seen<'static> {
        self.command(Command::Stop(target))
    }

    /// Lets time pass. The machine is woken whenever it wants to be.
    pub(crate) fn pass(&mut self, millis: u64) -> Seen<'static> {
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

/// Message of the command with this token.
pub(crate) const fn named(token: u32) -> host::Contents {
    host::Contents::Application(host::Source::Command(Token(token)))
}
