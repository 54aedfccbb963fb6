//! One message of each protocol from the conformance vectors: found in a stream, decoded, checked, encoded again.

use core::ffi::CStr;

use motion_core::stream::{Frames, Framing, Item};

/// Checks, each with the text for its failure.
pub const CHECKS: [(&CStr, fn() -> Option<()>); 3] =
    [(c"kOS failed", kos), (c"DMC failed", dmc), (c"hoot failed", hoot)];

/// Jogs motor 3 with 100 rotations per second and an acceleration of 100 rotations per second².
fn kos() -> Option<()> {
    use kos_proto::{HostMessage, Kos};
    const STREAM: &[u8] = b"\x04\x00\x14\x00\x80\x00\x1c\x03\x46\xc3\x50\x00\x42\xc8\x00\x00\x42\xc8\x00\x00";

    there_and_back::<Kos<64>, 128>(STREAM, |frame, room| {
        let message = HostMessage::decode(&frame).ok()?;
        let HostMessage::SetPositionSpeedAcceleration(go) = message else { return None };
        (go.motor_address.number() == 3).then_some(message.encode_into(room).ok()?)
    })
}

/// Jogs motor 3 with the lowest speed towards the greatest position.
fn dmc() -> Option<()> {
    use dmc_proto::{Dmc, HostMessage};
    const STREAM: &[u8] = b"DF\x37\x00\x00\x00\x36\x00\x07\x00\x03\x01\x00\xff\xff\xff\x7f\x26\x57";

    there_and_back::<Dmc<64>, 128>(STREAM, |frame, room| {
        let message = HostMessage::decode(&frame).ok()?;
        let HostMessage::MotorJog(jog) = message else { return None };
        (jog.motor.0 == 3).then_some(message.encode_into(frame.id(), room).ok()?)
    })
}

/// Moves motor 1 by 1000 steps in direction 1.
fn hoot() -> Option<()> {
    use hoot_proto::{Hoot, HostMessage};
    const STREAM: &[u8] = b"\x00\x00\x00\x00\x00\xff\x03\x01\x0f\x05\x01\x00\x00\x03\xe8";

    there_and_back::<Hoot, 84>(STREAM, |frame, room| {
        let message = HostMessage::decode(&frame);
        let HostMessage::MotorMove(_) = message else { return None };
        message.encode_into(frame.address(), room).ok()
    })
}

/// Checks that the stream is one frame, and that the decoded message encodes to the same bytes.
fn there_and_back<F: Framing, const N: usize>(
    stream: &[u8],
    encode: impl Fn(F::Frame<'_>, &mut [u8]) -> Option<usize>,
) -> Option<()> {
    let mut frames = Frames::<F, N>::new();
    let pushed = frames.push(stream);
    let Item::Frame(frame) = frames.next()? else { return None };
    let mut room = [0; 64];
    let written = encode(frame, &mut room)?;
    (pushed == stream.len() && room.get(..written)? == stream).then_some(())
}
