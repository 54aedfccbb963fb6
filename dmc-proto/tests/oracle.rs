//! Law 13: a second decoder, written with nom from the specification alone, agrees with the crate.

mod decoder;
mod recorded;

use decoder::{agree, frame, frames_agree};
use dmc_proto::{DeviceMessage, HostMessage};
use motion_core::wire::Messages;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};

/// Types of both tables.
fn kinds() -> Vec<u16> {
    let all = HostMessage::ALL.iter().chain(DeviceMessage::ALL);
    all.map(|kind| u16::try_from(kind.number).unwrap()).collect()
}

fn frames() -> Vec<Vec<u8>> {
    recorded::vectors().into_iter().map(|(_, bytes)| bytes).collect()
}

#[test]
fn on_every_vector() {
    for bytes in frames() {
        frames_agree(&bytes);
        if let Some((_, kind, data)) = frame(&bytes) {
            agree(kind, data);
        }
    }
}

#[test]
fn on_every_length_of_every_type() {
    let bytes: Vec<u8> = (0..=255).map(|at: u8| at.wrapping_mul(89) ^ 0x35).collect();
    for kind in kinds() {
        (0..bytes.len()).for_each(|len| agree(kind, &bytes[..len]));
    }
}

#[test]
fn on_every_length_of_every_rig() {
    for kind in 0..=5 {
        let body: Vec<u8> = (0..700_u16).map(|at| if at == 0 { kind } else { at.to_le_bytes()[0] }).collect();
        (0..body.len()).for_each(|len| agree(0x0200, &body[..len]));
    }
}

proptest! {
    #[test]
    fn on_any_body_of_any_type(known in select(kinds()), any in any::<u16>(), body in vec(any::<u8>(), 0..120)) {
        agree(known, &body);
        agree(any, &body);
    }

    #[test]
    fn on_frames_with_a_few_wrong_bytes(
        mut frame in select(frames()),
        wrong in vec((any::<Index>(), any::<u8>()), 0..3),
        len in any::<Index>(),
        whole in any::<bool>(),
    ) {
        for (at, byte) in wrong {
            let at = at.index(frame.len());
            frame[at] = byte;
        }
        let len = if whole { frame.len() } else { len.index(frame.len()) };
        frames_agree(&frame[..len]);
    }
}
