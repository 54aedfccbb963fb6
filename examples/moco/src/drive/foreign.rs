//! Devices of another protocol.

use kos_proto::DeviceMessage;
use motion_core::stream::Item;

use crate::simulate::Protocol;

/// Number of bytes that are enough to tell a protocol.
pub const ENOUGH: usize = 4096;

/// Protocol of the device that sent these bytes, the first ones on its line, if they show it.
///
/// A frame of DMC has a checksum, so one is enough, wherever it is. kOS has frames from the first byte on. hoot has only the
/// break before each frame, so at least half of the bytes must be in frames.
#[must_use]
pub fn spoken(bytes: &[u8]) -> Option<Protocol> {
    if dmc(bytes) {
        Some(Protocol::Dmc)
    } else if kos(bytes) {
        Some(Protocol::Kos)
    } else {
        hoot(bytes).then_some(Protocol::Hoot)
    }
}

/// Line about a device that speaks another protocol than the one that it was addressed in.
#[must_use]
pub fn line(spoken: Protocol, addressed: Protocol) -> String {
    let (spoken, name) = (spoken.name(), spoken.command());
    format!("what answers there speaks {spoken}, not {}: use `moco drive {name}`", addressed.name())
}

fn dmc(bytes: &[u8]) -> bool {
    let mut frames: Box<dmc_proto::Frames> = Box::default();
    // The buffer has room for far more than ENOUGH bytes.
    let _ = frames.push(bytes);
    std::iter::from_fn(|| frames.next().map(|item| matches!(item, Item::Frame(_)))).any(|is_frame| is_frame)
}

fn kos(bytes: &[u8]) -> bool {
    let mut frames: Box<kos_proto::Frames> = Box::default();
    // The first frame is enough.
    let _ = frames.push(bytes);
    let Some(Item::Frame(frame)) = frames.next() else { return false };
    DeviceMessage::decode(&frame).is_ok_and(|message| !matches!(message, DeviceMessage::Other(_)))
}

fn hoot(bytes: &[u8]) -> bool {
    let mut frames: Box<hoot_proto::Frames> = Box::default();
    let (mut rest, mut whole) = (bytes, 0);
    while !rest.is_empty() {
        let taken = frames.push(rest);
        rest = &rest[taken..];
        while let Some(item) = frames.next() {
            if let Item::Frame(frame) = item {
                whole += frame.bytes().len();
            }
        }
    }
    whole > 0 && 2 * whole >= bytes.len()
}

#[cfg(test)]
mod tests {
    use dmc_proto::message::Hi;

    use super::*;

    const HOOT: &[u8] = b"\0\0\0\0\0\xFF\0\0\x01\x04\0\0\x03\xE8";

    fn dmc() -> Vec<u8> {
        let mut bytes = [0; 256];
        let len =
            dmc_proto::DeviceMessage::from(Hi::default()).encode_into(dmc_proto::MessageId(0), &mut bytes).unwrap();
        bytes[..len].to_vec()
    }

    #[test]
    fn whole_frames_show_their_protocol() {
        let dmc = dmc();
        let noise = b"\x80\xF8";
        assert_eq!(spoken(&dmc), Some(Protocol::Dmc));
        assert_eq!(spoken(&[noise, &dmc[..]].concat()), Some(Protocol::Dmc));
        assert_eq!(spoken(HOOT), Some(Protocol::Hoot));
        assert_eq!(spoken(&[noise, HOOT, HOOT, &HOOT[..4]].concat()), Some(Protocol::Hoot));
        let at = b"\x04\0\x0C\0\x81\x02\x07\x03\x41\x3F\xB8\0";
        assert_eq!(spoken(&[&at[..], b"\x04\0"].concat()), Some(Protocol::Kos));
    }

    #[test]
    fn other_bytes_show_nothing() {
        let dmc = dmc();
        let damaged = [&dmc[..9], &[dmc[9] ^ 1], &dmc[10..]].concat();
        for bytes in [&[], &b"login: "[..], &dmc[..dmc.len() - 1], &damaged, &HOOT[..9], &[4, 0, 6, 0xEE, 0xEE, 1]] {
            assert_eq!(spoken(bytes), None, "{bytes:?}");
        }
    }
}
