//! Cost of the state machines beside decoding: a call of each machine, and the decoding of the frame that it takes.
//!
//! Each machine goes through an exchange that is typical of it, again and again from the beginning:
//!
//! - kOS: connect, load a move, play it, 100 notifications of its progress;
//! - DMC: greet, upload the positions of 2 motors for 1000 frames in sections, then jog;
//! - hoot: 100 questions for positions, each with its answer.
//!
//! The first column is the average call, with the decoding of the frame that it takes. The second column only decodes the
//! same frames; for inputs that are no frames it does nothing. Neither column encodes.

use std::hint::black_box;

use benches::ratios::{Table, contender};
use benches::report::Report;
use motion_core::machine::Machine;
use motion_core::time::Millis;

/// Something that happened to a machine: a frame arrived, or anything else.
enum Happened<I> {
    Frame(Vec<u8>),
    Else(I),
}

/// All that happens to a machine in an exchange, in order.
type Exchange<I> = Vec<(Millis, Happened<I>)>;

pub(crate) fn chapter(report: &mut Report) {
    let mut table = report.table("machines");
    /// A row of a machine; `input` makes its input from what happened.
    macro_rules! row {
        ($label:literal, $machine:expr, $exchange:expr, $input:path) => {
            let call = |machine: &mut _, now, happened: &_| {
                _ = black_box(Machine::advance(machine, now, $input(happened)));
            };
            row(&mut table, $label, &$machine, &$exchange, call, |happened| _ = black_box($input(happened)));
        };
    }
    let (client, device) = kos::exchange();
    row!("kOS client", kos::client(), client, kos::client_input);
    row!("kOS device", kos::device(), device, kos::device_input);
    let (host, device) = dmc::exchange();
    row!("DMC host", dmc::host(), host, dmc::host_input);
    row!("DMC device", dmc::device(), device, dmc::device_input);
    let (master, node) = hoot::exchange();
    row!("hoot master", hoot::master(), master, hoot::master_input);
    row!("hoot node", hoot::node(), node, hoot::node_input);
}

fn row<M: Clone, I>(
    table: &mut Table<'_>,
    label: &str,
    first: &M,
    exchange: &Exchange<I>,
    call: impl Fn(&mut M, Millis, &Happened<I>),
    decode: impl Fn(&Happened<I>),
) {
    let (mut machine, mut left) = (first.clone(), exchange.iter());
    let calls = move || {
        let (now, happened) = left.next().unwrap_or_else(|| {
            (machine, left) = (first.clone(), exchange.iter());
            left.next().expect("something happens")
        });
        call(&mut machine, *now, black_box(happened));
    };
    let mut all = exchange.iter().cycle();
    let frames = move || {
        if let Some((_, happened @ Happened::Frame(_))) = all.next() {
            decode(black_box(happened));
        }
    };
    table.row(label, vec![contender("call", calls), contender("decode", frames)]);
}

/// A client and a device. Each receives the messages that the specification describes.
mod kos {
    use kos_proto::device::{self, DeviceMachine, Positions, Report, SessionId};
    use kos_proto::host::{self, Command, Endpoint, HostMachine, Token};
    use kos_proto::message::{
        AuxInputs, Block16, Bool, DeviceGUID, DeviceInfo, DeviceType, FirmwareVersion, MarkBeginPosition,
        MarkEndPosition, MotorAddress, MotorEntry, MotorInfo, MotorInfos, MotorPlace, Newer, Normalized, Password,
        Photos, PlaybackDirection, PlaybackMode, PlaybackState, PlaybackStatus, Rotations, RotationsPerSecond,
        RotationsPerSecondSquared, Seconds, SetupPlayback, SoftwareID, StartPlayback,
    };
    use kos_proto::trajectory::{Delay, LiveMotion, Loop, MotorPlan, Plan, Play, TrajectoryData, Way, bezier};
    use kos_proto::{DeviceMessage, Frame, HostMessage, Millis, MoveSummary, Transport};

    use super::{Exchange, Happened};

    const SESSION: SessionId = SessionId(0);
    const PASSWORD: Password<'static> = Password(b"");

    type ClientInput = host::Input<'static>;
    type DeviceInput = device::Input<'static>;

    pub(super) fn client() -> HostMachine {
        HostMachine::new(host::Options::default())
    }

    pub(super) fn device() -> DeviceMachine {
        DeviceMachine::new(device::Options::default().with_progress_every(Some(90)))
    }

    pub(super) fn client_input(happened: &Happened<ClientInput>) -> host::Input<'_> {
        match happened {
            Happened::Frame(bytes) => host::Input::received(&Frame::decode(bytes).expect("a message")),
            Happened::Else(input) => *input,
        }
    }

    pub(super) fn device_input(happened: &Happened<DeviceInput>) -> device::Input<'_> {
        match happened {
            Happened::Frame(bytes) => {
                let frame = Frame::decode(bytes).expect("a message");
                device::Input::received(SESSION, &frame, PASSWORD)
            }
            Happened::Else(input) => *input,
        }
    }

    pub(super) fn exchange() -> (Exchange<ClientInput>, Exchange<DeviceInput>) {
        let exchanges = (of_client(), of_device());
        let (mut client, mut device) = (client(), device());
        for (now, happened) in &exchanges.0 {
            let _ = client.advance(*now, client_input(happened));
        }
        assert_eq!(client.move_state().name(), "Running");
        let mut told = 0;
        for (now, happened) in &exchanges.1 {
            told += device.advance(*now, device_input(happened)).transmits().count();
        }
        assert!(device.playback().runs() && told > 100, "{:?}, {told} messages", device.playback());
        exchanges
    }

    fn of_client() -> Exchange<ClientInput> {
        let tail = &[][..];
        let told = |message: DeviceMessage<'_>| {
            let mut bytes = vec![0; message.encoded_len()];
            message.encode_into(&mut bytes).expect("room for it");
            Happened::Frame(bytes)
        };
        let state = |playback_status| {
            let motors = [1, 2].map(|motor| MotorPlace::new(MotorAddress(motor), Rotations(0.5)));
            told(
                PlaybackStatus {
                    playback_status,
                    elapsed_time: Normalized(0.5),
                    photo_count: Some(Photos(0.0)),
                    motors: &motors.into_iter().collect::<Positions>(),
                    tail,
                }
                .into(),
            )
        };
        let (speed, acceleration) = (RotationsPerSecond(100.0), RotationsPerSecondSquared(80.0));
        let [zero, end] = [0.0, 8.0].map(Rotations);
        let motors =
            [1, 2].map(|motor| MotorEntry::new(MotorAddress(motor), zero, zero, end, speed, speed, acceleration));
        let info = DeviceInfo {
            device_type: DeviceType::SECOND_SHOOTER_PRO,
            device_addr: 0,
            playback_mode: PlaybackMode::LIVE_MOTION,
            playback_status: PlaybackState::NO_MOVE,
            firmware_version: FirmwareVersion([1, 0, 1, 5]),
            network_id: 0,
            hardware_id: 0,
            device_password: PASSWORD,
            aux_input_status: AuxInputs::default(),
            delay_time_remaining: Seconds(0.0),
            elapsed_time: Normalized(0.0),
            photo_count: Newer(Some(0)),
            tail,
        };
        let summary = MoveSummary::of(&trajectory()).expect("a move that can be played");
        let command = |command| Happened::Else(host::Input::Command(Token(1), command));
        let start = [
            command(Command::Connect(Endpoint::Usb)),
            Happened::Else(host::Input::LinkUp),
            told(info.into()),
            told(MotorInfo { more: false, motors: MotorInfos::New(&motors), tail }.into()),
            told(DeviceGUID { guid: Block16(&[7; 16]), tail }.into()),
            told(SoftwareID { platform: 4, tail }.into()),
            command(Command::Load { summary, delay_return: false }),
            state(PlaybackState::MOTORS_HOME),
            state(PlaybackState::SETUP_COMPLETED),
            command(Command::Play),
        ];
        let notifications = std::iter::repeat_with(|| state(PlaybackState::START_FORWARD)).take(100);
        (1000..).step_by(10).map(Millis).zip(start.into_iter().chain(notifications)).collect()
    }

    fn of_device() -> Exchange<DeviceInput> {
        let asked = |message: HostMessage<'_>| {
            let mut bytes = vec![0; message.encoded_len()];
            message.encode_into(&mut bytes).expect("room for it");
            Happened::Frame(bytes)
        };
        let arrived =
            |motor, place| Happened::Else(device::Input::Rig(Report::Arrived(MotorAddress(motor), Rotations(place))));
        let (direction, start_time, tail) = (PlaybackDirection::FORWARD, Seconds(0.0), &[][..]);
        let opened = device::Input::LinkUp { session: SESSION, transport: Transport::Tcp, password: PASSWORD };
        let mut all = vec![Happened::Else(device::Input::Rig(Report::Started)), Happened::Else(opened)];
        for motor in [1, 2] {
            let motor_address = MotorAddress(motor);
            all.push(arrived(motor, 0.0));
            all.push(asked(MarkBeginPosition { motor_address, tail }.into()));
            all.push(arrived(motor, 8.0));
            all.push(asked(MarkEndPosition { motor_address, tail }.into()));
        }
        all.push(asked(trajectory().into()));
        let setup = SetupPlayback { direction, start_time, delay_return: Bool::FALSE, tail };
        all.push(asked(setup.into()));
        all.extend([arrived(1, 0.0), arrived(2, 0.0)]);
        all.push(asked(StartPlayback { direction, start_time, tail }.into()));
        all.extend(std::iter::repeat_with(|| Happened::Else(device::Input::Wake)).take(100));
        (1000..).step_by(90).map(Millis).zip(all).collect()
    }

    /// A live move of ten seconds, of motors 1 and 2.
    fn trajectory() -> TrajectoryData<'static> {
        let (duration, home_speed) = (Seconds(10.0), Normalized(1.0));
        let play = Play::Live(LiveMotion { duration, repeat: Loop::Once, delay: Delay::None, home_speed });
        let line = [0.0, 0.25, 0.75, 1.0].map(|part| bezier::Point::new(part, part));
        let line = [bezier::Segment::new(line).expect("finite")];
        let motors = [1, 2].map(|motor| MotorPlan { motor: MotorAddress(motor), way: Way::Segments(&line) });
        Plan::new(play, &motors).encode(vec![0; Plan::MAX_LEN].leak()).expect("a move")
    }
}

/// A host and a device on a good line.
mod dmc {
    use dmc_proto::device::{self, DeviceMachine, Rig};
    use dmc_proto::host::{self, Command, Event, HostMachine, Outcome, Source, Token};
    use dmc_proto::message::{
        AckCode, Capabilities, FrameNumber, Hi, JogSpeed, Motor, MotorJog, Motors, RtUploadMoveBegin, Steps,
    };
    use dmc_proto::upload::{MoveSource, SCRATCH, Section, SectionSize};
    use dmc_proto::{Effect, Frame, HostMessage, Millis};

    use super::{Exchange, Happened};

    type HostInput = host::Input<'static>;
    type DeviceInput = device::Input<'static>;

    const FRAMES: u32 = 1000;
    const MESSAGES: [HostMessage<'static>; 2] = [
        HostMessage::RtUploadMoveBegin(RtUploadMoveBegin {
            start_frame: FrameNumber(1),
            end_frame: FrameNumber(FRAMES.cast_signed()),
            tail: &[],
        }),
        HostMessage::MotorJog(MotorJog {
            motor: Motor(1),
            speed: JogSpeed::FULL,
            destination: Steps(i32::MAX),
            tail: &[],
        }),
    ];

    pub(super) fn host() -> HostMachine {
        HostMachine::new(host::Options::default().with_needs_enabled(false))
    }

    pub(super) fn device() -> DeviceMachine {
        let hi = device::Options::default().hi();
        let capabilities = Capabilities::REAL_TIME;
        DeviceMachine::new(device::Options::of(Hi { motor_count: 2, upload_frame_count: FRAMES, capabilities, ..hi }))
    }

    pub(super) fn host_input(happened: &Happened<HostInput>) -> host::Input<'_> {
        match happened {
            Happened::Frame(bytes) => host::Input::received(&Frame::decode(bytes).expect("a frame")),
            Happened::Else(input) => *input,
        }
    }

    pub(super) fn device_input(happened: &Happened<DeviceInput>) -> device::Input<'_> {
        match happened {
            Happened::Frame(bytes) => device::Input::received(&Frame::decode(bytes).expect("a frame"), |_| AckCode::OK),
            Happened::Else(input) => *input,
        }
    }

    pub(super) fn exchange() -> (Exchange<HostInput>, Exchange<DeviceInput>) {
        let [begin, jog] = MESSAGES;
        let mut recorder =
            Recorder { host: host(), device: device(), now: 1000, of_host: vec![], of_device: vec![], done: vec![] };
        for input in [
            host::Input::LinkUp,
            host::Input::Command(Token(2), Command::Configured),
            host::Input::Command(Token(0), Command::Sequence(begin)),
            host::Input::Command(Token(1), Command::Request(jog)),
        ] {
            recorder.tell_host(Happened::Else(input));
        }
        assert_eq!(recorder.done, [2, 0, 1].map(Token));
        assert!(recorder.host.is_loaded() == Some(true) && recorder.device.is_loaded());
        (recorder.of_host, recorder.of_device)
    }

    /// The move, and the rig.
    struct Ramp;

    impl MoveSource for Ramp {
        fn start_frame(&self) -> FrameNumber {
            FrameNumber(1)
        }

        fn frame_count(&self) -> u32 {
            FRAMES
        }

        fn motors(&self) -> Motors {
            Motors(3)
        }

        fn position(&self, motor: Motor, index: u32) -> Steps {
            Steps(i32::from(motor.0) * index.cast_signed())
        }
    }

    impl Rig for Ramp {
        fn verdict(&self, _: &HostMessage<'_>) -> AckCode {
            AckCode::OK
        }

        fn position(&self, _: Motor) -> Steps {
            Steps(0)
        }
    }

    struct Recorder {
        host: HostMachine,
        device: DeviceMachine,
        now: u64,
        of_host: Exchange<HostInput>,
        of_device: Exchange<DeviceInput>,
        done: Vec<Token>,
    }

    impl Recorder {
        fn tell_host(&mut self, happened: Happened<HostInput>) {
            enum Follow {
                Device(Vec<u8>),
                Section(Option<Section>),
            }

            self.now += 1;
            let mut follow = vec![];
            let output = self.host.advance(Millis(self.now), host_input(&happened));
            for effect in output {
                match effect {
                    Effect::Transmit(transmit) => {
                        let mut scratch = [0; SCRATCH];
                        let mut frame = vec![0; 1048];
                        let written = transmit.encode_into(
                            |source| match source {
                                Source::Command(token) => MESSAGES[token.0 as usize],
                                Source::Section(section) => section.message(&Ramp, &mut scratch),
                            },
                            &mut frame,
                        );
                        let len = written.expect("room for it");
                        frame.truncate(len);
                        follow.push(Follow::Device(frame));
                    }
                    Effect::Event(Event::Ended { token, outcome: Outcome::Done(_) }) => self.done.push(token),
                    Effect::Event(Event::NextSection { after, .. }) => {
                        let size = SectionSize::of(200);
                        let next =
                            after.map_or_else(|| Section::first(&Ramp, size), |section| section.next(&Ramp, size));
                        follow.push(Follow::Section(next));
                    }
                    Effect::Event(_) => {}
                }
            }
            self.of_host.push((Millis(self.now), happened));
            for next in follow {
                match next {
                    Follow::Device(frame) => self.tell_device(Happened::Frame(frame)),
                    Follow::Section(section) => self.tell_host(Happened::Else(host::Input::Section(section))),
                }
            }
        }

        fn tell_device(&mut self, happened: Happened<DeviceInput>) {
            self.now += 1;
            let output = self.device.advance(Millis(self.now), device_input(&happened));
            let (mut stored, mut frames) = (None, vec![]);
            for effect in output {
                match effect {
                    Effect::Transmit(transmit) => {
                        let mut scratch = device::Scratch::default();
                        let message = transmit.message(&Ramp, &mut scratch);
                        let mut frame = vec![0; message.encoded_len()];
                        message.encode_into(transmit.id, &mut frame).expect("room for it");
                        frames.push(frame);
                    }
                    Effect::Event(device::Event::Store { store, .. }) => stored = Some(store),
                    Effect::Event(_) => {}
                }
            }
            self.of_device.push((Millis(self.now), happened));
            if let Some(store) = stored {
                self.tell_device(Happened::Else(device::Input::Rig(device::Report::Stored(store, AckCode::OK))));
            }
            for frame in frames {
                self.tell_host(Happened::Frame(frame));
            }
        }
    }
}

/// A master and a node on a good line.
mod hoot {
    use hoot_proto::device::{self, DeviceMachine, Port};
    use hoot_proto::frame::MAX_FRAME;
    use hoot_proto::host::{self, Command, Event, HostMachine, Nodes, Outcome, Request, Token};
    use hoot_proto::message::{Motor, MotorPosition};
    use hoot_proto::{Address, Frame, Millis};

    use super::{Exchange, Happened};

    type MasterInput = host::Input<'static>;
    type NodeInput = device::Input<'static>;

    pub(super) fn master() -> HostMachine {
        let nodes = Nodes::NONE.with(Address::DEFAULT).expect("room for one");
        HostMachine::new(host::Options::default().with_nodes(nodes))
    }

    pub(super) fn node() -> DeviceMachine {
        DeviceMachine::new(device::Options::default())
    }

    pub(super) fn master_input(happened: &Happened<MasterInput>) -> host::Input<'_> {
        match happened {
            Happened::Frame(bytes) => host::Input::received(&Frame::decode(bytes).expect("a packet")),
            Happened::Else(input) => *input,
        }
    }

    pub(super) fn node_input(happened: &Happened<NodeInput>) -> device::Input<'_> {
        match happened {
            Happened::Frame(bytes) => device::Input::received(Port::Bus, &Frame::decode(bytes).expect("a packet")),
            Happened::Else(input) => *input,
        }
    }

    pub(super) fn exchange() -> (Exchange<MasterInput>, Exchange<NodeInput>) {
        let (mut master, mut node) = (master(), node());
        let (mut of_master, mut of_node) = (vec![(Millis(1000), Happened::Else(host::Input::LinkUp))], vec![]);
        let _ = master.advance(Millis(1000), host::Input::LinkUp);
        for number in 0..100 {
            let now = Millis(2000).after(u64::from(number) * 500);
            let request = Request { to: Address::DEFAULT, message: MotorPosition { motor: Motor::Two }.into() };
            let asked = Happened::Else(host::Input::Command(Token(number), Command::Request(request)));
            let mut packet = [0; MAX_FRAME];
            let question = {
                let output = master.advance(now, master_input(&asked));
                let question = output.transmits().next().expect("a question");
                let len = question.encode_into(&mut packet).expect("room for it");
                Happened::Frame(packet[..len].to_vec())
            };
            let answer = {
                let output = node.advance(now, node_input(&question));
                let answer = output.transmits().next().expect("an answer");
                let len = answer.encode_into(&mut packet).expect("room for it");
                Happened::Frame(packet[..len].to_vec())
            };
            let is_end = |event: &Event<'_>| matches!(event, Event::Ended { token, outcome: Outcome::Done(_) } if *token == Token(number));
            assert!(master.advance(now.after(20), master_input(&answer)).events().any(is_end));
            of_master.extend([(now, asked), (now.after(20), answer)]);
            of_node.push((now, question));
        }
        (of_master, of_node)
    }
}
