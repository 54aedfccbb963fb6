//! Device on the bench: a machine, a clock, and the effects of its steps in words.

use kos_proto::Transport;
use kos_proto::device::{
    Contents, Destination, DeviceMachine, Effect, Event, Input, MotorSpecs, Options, Report, SessionId, Source,
    Transmit,
};
use kos_proto::message::*;
use kos_proto::trajectory::*;
use kos_proto::{Frame, HostMessage, Millis};
use laws::machine::step;

use super::world::{device_bytes, device_stops_first};

pub(super) const ZERO: SessionId = SessionId(0);
pub(super) const ONE: SessionId = SessionId(1);

/// Position of a motor after [`Bench::calibrate`].
pub(super) const RANGE: f32 = 8.0;

#[derive(Clone)]
pub(super) struct Bench {
    pub(super) machine: DeviceMachine,
    pub(super) now: u64,
    pub(super) password: &'static [u8],
    /// Messages that no test has looked at.
    pub(super) messages: Vec<String>,
    /// Events that no test has looked at.
    pub(super) events: Vec<Event<'static>>,
    pub(super) wake: Option<u64>,
}

impl Bench {
    /// Device that runs, with an unlocked client over TCP.
    pub(super) fn new(options: Options) -> Self {
        let mut bench = Self::off(options);
        bench.rig(Report::Started);
        bench.open(ZERO, Transport::Tcp);
        bench.clear();
        bench
    }

    pub(super) fn off(options: Options) -> Self {
        let machine = DeviceMachine::new(options);
        Self { machine, now: 1000, password: b"", messages: Vec::new(), events: Vec::new(), wake: None }
    }

    pub(super) fn step(&mut self, input: Input<'static>) {
        let (machine, output) = step(self.machine.clone(), Millis(self.now), input);
        self.machine = machine;
        self.wake = output.wake.map(|wake| wake.0);
        device_stops_first(&output);
        let motors = [MotorSpecs { motor_type: MotorType::FIZ, ..MotorSpecs::default() }; 3];
        for effect in output {
            match effect {
                Effect::Transmit(transmit) => {
                    for older_dialect in [false, true] {
                        device_bytes(&transmit, &Source { older_dialect, motors: &motors, ..Source::default() });
                    }
                    self.messages.push(text(&transmit));
                }
                Effect::Event(event) => self.events.push(event),
            }
        }
    }

    pub(super) fn open(&mut self, session: SessionId, transport: Transport) {
        self.step(Input::LinkUp { session, transport, password: Password(self.password) });
    }

    /// Receives a message of a client.
    pub(super) fn from<'a>(&mut self, session: SessionId, message: impl Into<HostMessage<'a>>) {
        let message = message.into();
        let mut bytes = vec![0; message.encoded_len()];
        message.encode_into(&mut bytes).unwrap();
        self.step(Input::received(session, &Frame::decode(bytes.leak()).unwrap(), Password(self.password)));
    }

    /// Receives a message of the first client.
    pub(super) fn receive<'a>(&mut self, message: impl Into<HostMessage<'a>>) {
        self.from(ZERO, message);
    }

    pub(super) fn rig(&mut self, report: Report) {
        self.step(Input::Rig(report));
    }

    pub(super) fn arrive(&mut self, motor: u8, position: f32) {
        self.rig(Report::Arrived(MotorAddress(motor), Rotations(position)));
    }

    /// Lets time pass, and wakes the machine whenever it wants to be woken, and at the end.
    pub(super) fn pass(&mut self, millis: u64) {
        let end = self.now + millis;
        while let Some(wake) = self.wake.filter(|&wake| wake <= end) {
            self.now = wake;
            self.step(Input::Wake);
        }
        self.now = end;
        self.step(Input::Wake);
    }

    /// Lets time pass while the first client keeps its connection.
    pub(super) fn pass_with_client(&mut self, millis: u64) {
        let mut left = millis;
        while left > 0 {
            let part = left.min(10_000);
            self.pass(part);
            self.receive(KeepAlive::default());
            left -= part;
        }
    }

    /// Messages that were sent since the last call.
    pub(super) fn messages(&mut self) -> Vec<String> {
        std::mem::take(&mut self.messages)
    }

    /// Events since the last call.
    pub(super) fn events(&mut self) -> Vec<Event<'static>> {
        std::mem::take(&mut self.events)
    }

    pub(super) fn clear(&mut self) {
        self.messages.clear();
        self.events.clear();
    }

    /// Gives a motor a range of 8 rotations from where the rig counts 0.
    pub(super) fn calibrate(&mut self, motor: u8) {
        self.arrive(motor, 0.0);
        self.receive(mark_begin(motor));
        self.arrive(motor, RANGE);
        self.receive(mark_end(motor));
        assert!(self.machine.motor(MotorAddress(motor)).is_some_and(|drive| drive.range().1.0 == RANGE));
    }

    /// Device with a stored move for motors 1 and 2, which have ranges.
    pub(super) fn loaded(options: Options, data: TrajectoryData<'_>) -> Self {
        let mut bench = Self::new(options);
        bench.calibrate(1);
        bench.calibrate(2);
        bench.receive(HostMessage::from(data));
        assert_eq!(bench.machine.playback().name(), "Loaded", "{:?}", bench.events());
        bench.clear();
        bench
    }

    /// Lets motors 1 and 2 arrive where the move begins.
    pub(super) fn home(&mut self) {
        self.arrive(1, 0.0);
        self.arrive(2, 0.0);
    }

    pub(super) fn state(&self) -> &'static str {
        self.machine.playback().name()
    }
}

/// Receivers and contents of a message in few words.
fn text(transmit: &Transmit<'_>) -> String {
    let to: String = match transmit.destination {
        Destination::Sessions(sessions) => sessions.iter().map(|session| session.0.to_string()).collect(),
        Destination::Broadcast => "all".into(),
        Destination::Datagram(address) => address.to_string(),
    };
    let what = match &transmit.contents {
        Contents::PlaybackStatus { state, .. } => state.to_string(),
        Contents::ErrorStatus { code, motor } => format!("error {} {motor}", code.0),
        Contents::MotorPosition { motor, position } => format!("{motor} rests at {position}"),
        Contents::MotorCalibrated { motor, begin, end } => format!("{motor} goes {begin} to {end}"),
        Contents::MotorInfo { motor: Some(report), more } => {
            let more = if *more { ", more" } else { "" };
            format!("{} at {} of {} to {}{more}", report.motor, report.position, report.begin, report.end)
        }
        Contents::MotorStatus { motor, online } => format!("{motor} online {online}"),
        Contents::DeviceInfo(activity) => format!("DeviceInfo {}", activity.state),
        what => format!("{what:?}"),
    };
    format!("{to}: {what}")
}

pub(super) const STOP: HostMessage<'static> = HostMessage::StopPlayback(StopPlayback { tail: &[] });

pub(super) fn set_psa(motor: u8, position: f32, speed: f32) -> HostMessage<'static> {
    HostMessage::from(SetPositionSpeedAcceleration::move_to(
        MotorAddress(motor),
        Rotations(position),
        RotationsPerSecond(speed),
        RotationsPerSecondSquared(50.0),
    ))
}

pub(super) fn bump(motor: u8, delta: f32, speed: f32) -> HostMessage<'static> {
    HostMessage::from(BumpPositionSpeedAcceleration {
        motor_address: MotorAddress(motor),
        delta: Rotations(delta),
        speed: RotationsPerSecond(speed),
        acceleration: RotationsPerSecondSquared(50.0),
        tail: &[],
    })
}

pub(super) fn mark_begin(motor: u8) -> HostMessage<'static> {
    HostMessage::from(MarkBeginPosition { motor_address: MotorAddress(motor), tail: &[] })
}

pub(super) fn mark_end(motor: u8) -> HostMessage<'static> {
    HostMessage::from(MarkEndPosition { motor_address: MotorAddress(motor), tail: &[] })
}

pub(super) fn reset_axis(motor: u8) -> HostMessage<'static> {
    HostMessage::from(ResetAxis { motor_address: MotorAddress(motor), tail: &[] })
}

pub(super) fn start() -> HostMessage<'static> {
    start_to(PlaybackDirection::FORWARD)
}

pub(super) fn start_to(direction: PlaybackDirection) -> HostMessage<'static> {
    HostMessage::from(StartPlayback { direction, start_time: Seconds(0.0), tail: &[] })
}

pub(super) fn setup(delay_return: bool) -> HostMessage<'static> {
    HostMessage::from(SetupPlayback {
        direction: PlaybackDirection::FORWARD,
        start_time: Seconds(0.0),
        delay_return: delay_return.into(),
        tail: &[],
    })
}

pub(super) fn user_password(password: &[u8]) -> HostMessage<'_> {
    UserPassword { password: Password(password), tail: &[] }.into()
}

pub(super) fn device_password(password: &[u8]) -> HostMessage<'_> {
    DevicePassword { password: Password(password), tail: &[] }.into()
}

/// Live move of ten seconds.
pub(super) fn live() -> Playback<'static> {
    Playback {
        playback_mode: PlaybackMode::LIVE_MOTION,
        duration: Seconds(10.0),
        rapid_reverse_duration: Seconds(10.0),
        loop_after_rapid_reverse: LoopCount::NONE,
        loop_after_reverse: LoopCount::NONE,
        delay_mode: DelayMode::NONE,
        delay_interval_bits: DelayInterval(0),
        camera_roll_enabled: Bool::FALSE,
        camera_roll_pre_delay: Seconds(0.0),
        camera_roll_post_delay: Seconds(0.0),
        flash_mark_enabled: Bool::FALSE,
        flash_mark_type: 0,
        flash_mark_post_delay: Seconds(0.0),
        use_external_trigger: Bool::FALSE,
        using_lanc: Bool::FALSE,
        return_to_home_percent: Normalized(1.0),
        tail: &[],
    }
}

pub(super) fn photos(delay: f32, exposure: f32, before: u32, moving: u32, after: u32) -> TimeLapse<'static> {
    TimeLapse {
        delay: Seconds(delay),
        exposure: Seconds(exposure),
        move_photos: moving,
        not_used: 0,
        pre_move_photos: before,
        post_move_photos: after,
        tail: &[],
    }
}

/// Move of these motors from one end of their ranges to the other.
pub(super) fn trajectory_of(playback: Playback<'_>, photos: TimeLapse<'_>, motors: &[u8]) -> TrajectoryData<'static> {
    let mut blocks = vec![Block::Playback(playback), Block::TimeLapse(photos)];
    for &motor in motors {
        let motor_address = MotorAddress(motor);
        let third = 1.0 / 3.0;
        let points = Points([
            Point::new(0.0, 0.0),
            Point::new(third, third),
            Point::new(2.0 * third, 2.0 * third),
            Point::new(1.0, 1.0),
        ]);
        blocks.push(Block::Axis(Axis { motor_address, segment_count: 1, tail: &[] }));
        blocks.push(Block::Segment(Segment { motor_address, segment_number: 0, points, tail: &[] }));
    }
    TrajectoryData { blocks: Blocks::encode(&blocks, vec![0; 1024].leak()).unwrap(), tail: &[] }
}

pub(super) fn trajectory(playback: Playback<'_>, photos: TimeLapse<'_>) -> TrajectoryData<'static> {
    trajectory_of(playback, photos, &[1, 2])
}

pub(super) fn live_move(playback: Playback<'_>) -> TrajectoryData<'static> {
    trajectory(playback, photos(0.0, 0.0, 0, 0, 0))
}
