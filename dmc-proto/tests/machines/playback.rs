//! Playback of the uploaded move, with the session whose events it obeys.

use dmc_proto::device::{DeviceMachine, Event, Next, Options, Playback, Rig, Session, State};
use dmc_proto::message::{
    AckCode, Capabilities, FrameNumber, FramesPerSecond, Hi, HostMessage, Motor, MotorMove, MotorStop, MotorStopAll,
    Motors, RtGo, RtJogAll, RtPositionFrame, RtRunMove, RtUploadMoveBegin, RtUploadMoveEnd, RunFlags, Scaled, Steps,
};
use dmc_proto::{MessageId, Millis, Patience};

struct NoRig;

impl Rig for NoRig {
    fn verdict(&self, _: &HostMessage<'_>) -> AckCode {
        AckCode::OK
    }
    fn position(&self, _: Motor) -> Steps {
        Steps(0)
    }
}

/// Device that does what its playback says. Its motors are at their goal at once.
struct Device {
    session: Box<Session>,
    playback: Playback,
    /// Frames to which an event sent all motors.
    sent: Vec<i32>,
    unexpected: usize,
}

const MOVE: (FrameNumber, FrameNumber) = (FrameNumber(-5), FrameNumber(100));

fn fps(rate: u32) -> FramesPerSecond {
    FramesPerSecond(Scaled(rate * 1000))
}

impl Device {
    /// Device that rests on a frame of its move.
    fn on_frame(frame: i32) -> Self {
        let capabilities = Capabilities::REAL_TIME | Capabilities::LOOP;
        let hi = Hi { motor_count: 2, upload_frame_count: 200, capabilities, ..Options::default().hi() };
        let session = Session::new(DeviceMachine::new(Options::of(hi)), Patience::default());
        let mut device =
            Self { session: Box::new(session), playback: Playback::default(), sent: vec![], unexpected: 0 };
        device.session.link_up();
        let (start_frame, end_frame) = MOVE;
        device.receive(RtUploadMoveBegin { start_frame, end_frame, tail: &[] });
        device.receive(RtUploadMoveEnd::default());
        device.receive(RtPositionFrame { frame: FrameNumber(frame), tail: &[] });
        assert_eq!(device.sent, [frame]);
        device.rest();
        assert_eq!(device.session.machine().on_frame(), Some(FrameNumber(frame)));
        device
    }

    fn work(&mut self) {
        let mut out = [0; 256];
        loop {
            match self.session.poll(Millis(0), &NoRig, &mut out).unwrap() {
                Next::Event(Event::Store { store, .. }) => self.session.stored(store, AckCode::OK).unwrap(),
                Next::Event(event) => {
                    self.sent.extend(self.playback.obey(&event).map(|frame| frame.0));
                    self.unexpected += usize::from(event == Event::UnexpectedReport);
                }
                Next::Transmit(_) => {}
                Next::Wait(_) => return,
            }
        }
    }

    fn receive<'m>(&mut self, message: impl Into<HostMessage<'m>>) {
        let mut bytes = [0; 256];
        let len = message.into().encode_into(MessageId(1), &mut bytes).unwrap();
        assert_eq!(self.session.receive(Millis(0), &bytes[..len]), len);
        self.work();
    }

    fn run(&mut self, start: i32, end: i32, flags: RunFlags) {
        let (start_frame, end_frame) = (FrameNumber(start), FrameNumber(end));
        let flags = Some(flags);
        self.receive(RtRunMove { fps_x1000: fps(100), start_frame, end_frame, flags, ..Default::default() });
        self.rest();
        assert_eq!(self.state(), State::Ready);
        self.receive(RtGo::default());
        assert_eq!(self.state(), State::Running);
    }

    /// Lets time pass, and returns the new frame.
    fn advance(&mut self, millis: u32) -> Option<i32> {
        let frame = self.playback.advance(millis, &mut self.session);
        self.work();
        frame.map(|frame| frame.0)
    }

    /// Reports that no motor moves.
    fn rest(&mut self) {
        self.playback.report(Motors::NONE, &mut self.session);
        self.work();
    }

    fn state(&self) -> State {
        self.session.machine().state()
    }
}

#[test]
fn a_run_plays_each_frame_in_its_time_and_ends_on_its_last_frame() {
    let mut device = Device::on_frame(0);
    device.run(10, 13, RunFlags::default());
    assert_eq!(device.sent, [0, 10]);
    for frame in 11..=13 {
        assert_eq!((0..9).map(|_| device.advance(1)).collect::<Vec<_>>(), [None; 9]);
        assert_eq!(device.advance(1), Some(frame));
    }
    assert_eq!((device.state(), device.playback.is_playing()), (State::PostRoll, false));
    assert_eq!(device.advance(1000), None);
    device.rest();
    assert_eq!((device.state(), device.session.machine().on_frame()), (State::Idle, Some(FrameNumber(13))));
    assert_eq!(device.unexpected, 0);
}

#[test]
fn a_run_backwards_to_a_negative_frame_is_played_and_a_run_of_one_frame_ends_at_once() {
    let mut device = Device::on_frame(0);
    device.run(-3, -5, RunFlags::default());
    assert_eq!((device.advance(10), device.advance(100)), (Some(-4), Some(-5)));
    device.rest();
    device.run(7, 7, RunFlags::default());
    assert_eq!((device.advance(1), device.state()), (None, State::PostRoll));
    assert_eq!(device.unexpected, 0);
}

#[test]
fn passes_follow_each_other_until_the_loop_is_stopped() {
    let mut device = Device::on_frame(0);
    device.run(1, 3, RunFlags::PING_PONG);
    assert_eq!((device.advance(10), device.advance(10)), (Some(2), Some(3)));
    assert_eq!((device.playback.is_playing(), device.state()), (true, State::Running));
    assert_eq!((device.advance(10), device.advance(10)), (Some(2), Some(1)));
    assert_eq!(device.sent, [0, 1, 3, 1], "each pass begins where the pass before it ended");
    device.receive(MotorStopAll::default());
    assert_eq!((device.advance(10), device.playback.is_playing()), (None, false));

    let mut device = Device::on_frame(0);
    device.run(1, 3, RunFlags::LOOP);
    assert_eq!((device.advance(20), device.advance(10)), (Some(3), Some(2)), "a loop begins at its first frame again");
    device.receive(dmc_proto::message::RtStopLoop::default());
    assert_eq!((device.advance(10), device.state()), (Some(3), State::PostRoll));
    assert_eq!(device.unexpected, 0);
}

#[test]
fn a_stop_of_everything_ends_the_playback_before_a_frame_or_an_end_is_reported() {
    for stop in [MotorStopAll::default().into(), HostMessage::from(MotorStop { motor: Motor(1), tail: &[] })] {
        let mut device = Device::on_frame(0);
        device.receive(RtJogAll { fps_x1000: fps(100), destination: FrameNumber(50), tail: &[] });
        assert_eq!(device.advance(10), Some(1));
        device.receive(stop);
        let is_all = matches!(stop, HostMessage::MotorStopAll(_));
        assert_eq!(device.playback.is_playing(), !is_all, "motor 1 is no part of the move, and stops alone");
        assert_eq!(device.advance(10), (!is_all).then_some(2));
    }
    let mut device = Device::on_frame(0);
    device.run(1, 3, RunFlags::default());
    device.session.emergency_stop(true).unwrap();
    device.work();
    assert_eq!((device.advance(1000), device.state(), device.unexpected), (None, State::Locked, 0));
}

#[test]
fn a_way_to_a_frame_takes_the_place_of_a_jog() {
    let mut device = Device::on_frame(0);
    device.receive(RtJogAll { fps_x1000: fps(100), destination: FrameNumber(50), tail: &[] });
    device.receive(RtPositionFrame { frame: FrameNumber(20), tail: &[] });
    assert_eq!((device.advance(1000), device.playback.frame()), (None, FrameNumber(20)));
    device.rest();
    assert_eq!(device.session.machine().on_frame(), Some(FrameNumber(20)));
}

#[test]
fn motors_that_rest_between_two_frames_of_a_jog_do_not_end_it() {
    let mut device = Device::on_frame(0);
    device.receive(RtJogAll { fps_x1000: fps(1), destination: FrameNumber(1), tail: &[] });
    assert_eq!(device.advance(500), None);
    assert_eq!(device.playback.part(), 500_000);
    device.rest();
    assert_eq!(device.state(), State::JogAll);
    assert_eq!(device.advance(500), Some(1));
    device.rest();
    assert_eq!((device.state(), device.session.machine().on_frame()), (State::Idle, Some(FrameNumber(1))));
}

#[test]
fn rest_is_reported_only_when_the_rig_has_obeyed_all_events() {
    let mut device = Device::on_frame(0);
    let mut bytes = [0; 64];
    let go = HostMessage::from(MotorMove { motor: Motor(1), position: Steps(9), tail: &[] });
    let len = go.encode_into(MessageId(1), &mut bytes).unwrap();
    assert_eq!(device.session.receive(Millis(0), &bytes[..len]), len);
    let next = device.session.poll(Millis(0), &NoRig, &mut bytes);
    assert!(matches!(next, Ok(Next::Event(Event::Move(..)))), "{next:?}");
    // The answer is not sent yet.
    device.rest();
    assert_eq!(device.state(), State::Moving);
    let motor = Motors::from_iter([Motor(1)]);
    device.playback.report(motor, &mut device.session);
    device.work();
    assert_eq!((device.state(), device.session.machine().moving()), (State::Moving, motor));
    device.rest();
    assert_eq!(device.state(), State::Idle);
}

#[test]
fn an_end_for_which_the_session_has_no_room_is_reported_later() {
    let mut device = Device::on_frame(0);
    device.run(1, 2, RunFlags::default());
    while device.session.moving(Motors::NONE).is_ok() {}
    assert_eq!(device.advance(10), Some(2));
    assert_eq!(device.state(), State::Running);
    assert_eq!(device.advance(1), None);
    assert_eq!((device.state(), device.unexpected), (State::PostRoll, 0));
}

#[test]
fn the_greatest_speed_goes_to_the_last_frame_at_once() {
    let mut device = Device::on_frame(0);
    let rate = FramesPerSecond(Scaled(u32::MAX));
    device.receive(RtJogAll { fps_x1000: rate, destination: MOVE.1, tail: &[] });
    assert_eq!(device.advance(u32::MAX), Some(MOVE.1.0));
}
