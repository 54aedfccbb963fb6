//! One message of each protocol, from the conformance vectors, there and back.

use core::ffi::CStr;

use dmc_proto::Item;

/// What to say when a check fails, and the check.
pub const CHECKS: [(&CStr, fn() -> Option<()>); 1] = [(c"DMC failed", dmc)];

fn dmc() -> Option<()> {
    use dmc_proto::{Frames, HostMessage};
    const JOG: [u8; 19] = *b"DF\x37\0\0\0\x36\0\x07\0\x03\x01\0\xff\xff\xff\x7f\x26\x57";

    let mut frames: Frames = Frames::new();
    let _ = frames.push(&JOG);
    let Item::Frame(frame) = frames.next()? else { return None };
    let message = HostMessage::decode(&frame).ok()?;
    let HostMessage::MotorJog(jog) = message else { return None };
    let mut room = [0; 64];
    let written = message.encode_into(frame.id(), &mut room).ok()?;
    (jog.motor.0 == 3 && room.get(..written)? == JOG).then_some(())
}
