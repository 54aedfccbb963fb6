//! Client and device on one line, with messages as bytes: what the tests, the fuzz target and the model share.

use kos_proto::device::{self, Contents, DeviceMachine, SessionId};
use kos_proto::host::{self, HostMachine};
use kos_proto::message::{MotorAddress, Password, PlaybackState};
use kos_proto::{DeviceMessage, Effect, Frame, HostMessage};

/// Client, device, and the messages between them.
pub(crate) type World = laws::world::World<HostMachine, DeviceMachine, Vec<u8>, Vec<u8>>;

/// Bytes of a message of the client. The decoder reads the same message from them.
pub(crate) fn host_bytes(transmit: &host::Transmit<'_>, source: &host::Source<'_>) -> Vec<u8> {
    let message = transmit.message(source);
    let mut bytes = vec![0; message.encoded_len()];
    assert_eq!(message.encode_into(&mut bytes), Ok(bytes.len()), "{message}");
    assert_eq!(HostMessage::decode(&frame(&bytes)), Ok(message));
    bytes
}

/// Bytes of a message of the device. The decoder reads the same message from them.
pub(crate) fn device_bytes(transmit: &device::Transmit<'_>, source: &device::Source<'_>) -> Vec<u8> {
    let mut scratch = device::Scratch::default();
    let message = transmit.message(source, &mut scratch);
    let mut bytes = vec![0; message.encoded_len()];
    assert_eq!(message.encode_into(&mut bytes), Ok(bytes.len()), "{message}");
    assert_eq!(DeviceMessage::decode(&frame(&bytes)), Ok(message));
    bytes
}

/// Message on a line without damage.
pub(crate) fn frame(bytes: &[u8]) -> Frame<'_> {
    Frame::decode(bytes).expect("a message that was encoded")
}

/// Input of the device for bytes that arrive on a connection.
pub(crate) fn to_device<'a>(session: SessionId, bytes: &'a [u8], password: Password<'a>) -> device::Input<'a> {
    match Frame::decode(bytes) {
        Ok(frame) => device::Input::received(session, &frame, password),
        Err(_) => device::Input::Fatal(session),
    }
}

/// Input of the client for bytes that arrive.
pub(crate) fn to_host(bytes: &[u8]) -> host::Input<'_> {
    match Frame::decode(bytes) {
        Ok(frame) => host::Input::received(&frame),
        Err(_) => host::Input::Fatal,
    }
}

/// Checks that a stop goes out before everything else, so also before anybody is told of it. A locked device may ignore it,
/// so that it goes out again directly after a password.
pub(crate) fn host_stops_first(output: &host::Output<'_>) {
    let is_stop =
        |effect: &host::Effect<'_>| matches!(effect, Effect::Transmit(transmit) if transmit.conduct().is_stop());
    let is_password = |effect: &host::Effect<'_>| matches!(effect, Effect::Transmit(host::Transmit::UserPassword(_)));
    let mut runs = output.effects.split(|effect| is_password(effect));
    let runs_begin_with_stops =
        |run: &[host::Effect<'_>]| run.iter().skip_while(|effect| is_stop(effect)).all(|effect| !is_stop(effect));
    assert!(runs.all(runs_begin_with_stops), "{output:?}");
}

/// Checks that the rig stops before anybody is told of it: that the move is over, because of which error, what failed, or
/// where the range ends.
pub(crate) fn device_stops_first(output: &device::Output<'_>) {
    let tells = |contents: &Contents<'_>, stopped: Option<MotorAddress>| match contents {
        Contents::PlaybackStatus { state, .. } => stopped.is_none() && *state == PlaybackState::FULL_STOP,
        Contents::ErrorStatus { motor, .. } | Contents::MotorCalibrated { motor, .. } => stopped == Some(*motor),
        _ => false,
    };
    for (index, effect) in output.effects.iter().enumerate() {
        let stopped = match effect {
            Effect::Event(device::Event::StopAll) => None,
            Effect::Event(device::Event::StopMotor { motor, .. }) => Some(*motor),
            _ => continue,
        };
        let is_early = |effect: &&device::Effect<'_>| matches!(effect, Effect::Transmit(transmit) if tells(&transmit.contents, stopped));
        assert_eq!(output.effects[..index].iter().find(is_early), None, "told before it is done: {output:?}");
    }
    // An error that ends a move is told directly before its end.
    for window in output.effects.windows(3) {
        let [_, Effect::Transmit(error), Effect::Transmit(end)] = window else { continue };
        if matches!(error.contents, Contents::ErrorStatus { .. }) && tells(&end.contents, None) {
            assert_eq!(window[0], Effect::Event(device::Event::StopAll), "{output:?}");
        }
    }
}
