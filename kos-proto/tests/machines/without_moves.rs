//! Device without moves: it does what a device does to which nobody sends a move.

use kos_proto::device::clients::State;
use kos_proto::device::{
    CommandSession, Contents, DeviceMachine, Effect, Event, Ignored, Input, Next, Options, Report, Source,
};
use kos_proto::message::{KeepAlive, MotorAddress, MotorSet, RapidToFirstKeyFrame};
use kos_proto::{DeviceMessage, Frame, HostMessage, MessageId, Millis, Transport};
use proptest::collection::vec;
use proptest::prelude::*;

use super::bench::{ZERO, live, live_move, set_psa, setup, start};
use super::random::{device_op, device_options, time};

/// Input after which a device with moves that has no move does the same, if a device without moves does not know the message.
fn counterpart(input: Input<'_>) -> Option<Input<'_>> {
    match input {
        Input::Received { session, message, password, .. } => {
            let is_unknown = matches!(
                message,
                HostMessage::SetTrajectoryData(_)
                    | HostMessage::SetupPlayback(_)
                    | HostMessage::StartPlayback(_)
                    | HostMessage::RapidToFirstKeyFrame(_)
            );
            let message = KeepAlive::default().into();
            is_unknown.then_some(Input::Received { session, message, bytes: &[], password })
        }
        _ => None,
    }
}

proptest! {
    #[test]
    fn a_device_without_moves_does_what_a_device_does_that_gets_no_move(
        options in device_options(),
        ops in vec((time(), device_op()), 0..80),
    ) {
        let (mut device, mut plain) = (DeviceMachine::new(options), DeviceMachine::without_moves(options));
        let (mut now, mut wake) = (Millis(0), None);
        let started = Input::Rig(Report::Started);
        prop_assert_eq!(device.advance(now, started).effects, plain.advance(now, started).effects);
        for (time, op) in &ops {
            now = time.pass(now, wake);
            let input = op.input();
            let sender = match input {
                Input::Received { session, .. } | Input::Malformed { session, .. } => Some(session),
                _ => None,
            };
            let is_open = sender.is_some_and(|session| plain.session(session) == State::Unlocked);
            let mut done = plain.advance(now, input);
            wake = done.wake;
            let same = match (counterpart(input).filter(|_| is_open), input) {
                (Some(same), _) => {
                    let echo = done.effects.remove(0);
                    let is_echo = matches!(&echo,
                        Effect::Transmit(echo) if matches!(echo.contents, Contents::UnsupportedMessage(_)));
                    prop_assert!(is_echo, "{echo:?}");
                    let why = done.effects.remove(0);
                    prop_assert_eq!(why, Effect::Event(Event::Ignored(Ignored::Unsupported(sender.unwrap()))));
                    same
                }
                // A move that ends in the middle of a block is a message that the device does not know, too.
                (None, Input::Malformed { id: MessageId::TRAJECTORY_DATA, session, kind, error, bytes }) => {
                    Input::Malformed { id: MessageId(0x7777), session, kind, error, bytes }
                }
                (None, input) => input,
            };
            let expected = device.advance(now, same);
            prop_assert_eq!((&done.effects, done.wake), (&expected.effects, expected.wake));
            let state = (device.link(), device.playback(), device.may_move());
            prop_assert_eq!((plain.link(), plain.playback(), plain.may_move()), state);
            prop_assert!((0..11).map(MotorAddress).all(|motor| plain.motor(motor) == device.motor(motor)));
        }
    }
}

#[test]
fn a_session_without_moves_sends_back_what_belongs_to_a_move_and_moves_motors_by_hand() {
    let options = Options::default().with_motors(MotorSet::of([MotorAddress(1)]));
    let mut session = CommandSession::new(DeviceMachine::without_moves(options));
    session.report(Report::Started).unwrap();
    session.link_up(ZERO, Transport::Usb).unwrap();
    let mut out = [0; 512];
    let mut done = |message: HostMessage<'_>| {
        let (mut echoes, mut events) = (0, Vec::new());
        let mut bytes = vec![0; message.encoded_len()];
        let mut sent = message.encode_into(&mut bytes).unwrap();
        loop {
            match session.poll(Millis(0), &Source::default(), &mut out).unwrap() {
                Next::Transmit(_, answer) => {
                    let answer = DeviceMessage::decode(&Frame::decode(answer).unwrap()).unwrap();
                    echoes += usize::from(
                        matches!(answer, DeviceMessage::UnsupportedMessage(echo) if echo.message.0 == bytes),
                    );
                }
                Next::Event(event) => events.push(event.to_static().unwrap()),
                Next::Wait(_) if sent > 0 => {
                    let piece = &bytes[bytes.len() - sent..][..sent.min(CommandSession::PIECE)];
                    sent -= session.receive(Millis(0), ZERO, piece);
                }
                Next::Wait(_) => return (echoes, events),
            }
        }
    };
    let ignored = vec![Event::Ignored(Ignored::Unsupported(ZERO))];
    for message in [live_move(live()).into(), setup(false), start(), RapidToFirstKeyFrame::default().into()] {
        assert_eq!(done(message), (1, ignored.clone()), "{message}");
    }
    let (echoes, events) = done(set_psa(1, 3.0, 2.0));
    assert!(echoes == 0 && matches!(events[..], [Event::Move { motor: MotorAddress(1), .. }]), "{events:?}");
}
