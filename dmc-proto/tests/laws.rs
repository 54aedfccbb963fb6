//! Laws of every message of both sides, and of the stream.

mod recorded;

use dmc_proto::{Device, DeviceMessage, Dmc, Host, HostMessage};
use laws::stream::{Owned, check};
use motion_core::wire::Messages;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};

#[test]
fn every_message_is_drawn_at_a_fair_share() {
    laws::drawn::shares::<Host>(200);
    laws::drawn::shares::<Device>(200);
}

#[test]
fn every_message_of_both_tables() {
    laws::message::table::<Host>();
    laws::message::table::<Device>();
}

/// Lengths and types of the only message that is too long and has too many layouts for the test above.
#[test]
fn every_length_of_every_virtual_rig() {
    for kind in 0..=5 {
        let body: Vec<u8> = (0..700_u16).map(|at| if at == 0 { kind } else { at.to_le_bytes()[0] }).collect();
        let decoded =
            (0..=body.len()).filter(|&len| laws::message::any_body::<Host>(0x0200, &body[..len]).is_ok()).count();
        let shortest = match kind {
            1 => 93,
            2 => 17,
            _ => 1,
        };
        assert_eq!(decoded, body.len() + 1 - shortest);
    }
}

/// Frames of the conformance vectors, with the corrupt one.
fn frames() -> Vec<Vec<u8>> {
    recorded::vectors().into_iter().map(|(_, bytes)| bytes).collect()
}

/// Frames that a search from each byte in turn finds. It is written separately, with the checksum of the specification.
fn rescan(max: usize) -> impl Fn(&[u8]) -> Result<usize, usize> {
    move |bytes| {
        if bytes.len() < 12 || !bytes.starts_with(b"DF") {
            return Err(1);
        }
        let total = 12 + usize::from(bytes[8]) + 256 * usize::from(bytes[9]);
        if total > max || total > bytes.len() {
            return Err(1);
        }
        let sums = bytes[..total].iter().fold((0_u32, 0_u32), |(first, second), &byte| {
            let first = (first + u32::from(byte)) % 255;
            (first, (second + first) % 255)
        });
        if sums == (0, 0) { Ok(total) } else { Err(1) }
    }
}

/// Stream of frames of the vectors, whole, cut or damaged, with noise that begins like a frame between them; places of
/// gaps; lengths of pieces.
fn traffic() -> impl Strategy<Value = (Vec<u8>, Vec<usize>, Vec<usize>)> {
    let frames = frames();
    let frame = move || select(frames.clone());
    let part = prop_oneof![
        5 => frame(),
        2 => vec(select(&b"DDDFF\0\x05"[..]), 0..14),
        1 => vec(any::<u8>(), 0..40),
        2 => (frame(), any::<Index>()).prop_map(|(frame, at)| frame[..at.index(frame.len())].to_vec()),
        2 => (frame(), any::<Index>(), 1..=255_u8).prop_map(|(mut frame, at, by)| {
            let at = at.index(frame.len());
            frame[at] ^= by;
            frame
        }),
    ];
    (vec(part, 0..16), vec(any::<Index>(), 0..4), vec(1..200_usize, 1..16)).prop_map(|(parts, gaps, cuts)| {
        let stream = parts.concat();
        let mut gaps: Vec<_> = gaps.iter().map(|gap| gap.index(stream.len() + 1)).collect();
        gaps.sort_unstable();
        (stream, gaps, cuts)
    })
}

proptest! {
    #[test]
    fn any_body_of_any_type(number in 0_u32..=0xffff, body in vec(any::<u8>(), 0..200)) {
        let _ = laws::message::any_body::<Host>(number, &body);
        let _ = laws::message::any_body::<Device>(number, &body);
    }

    #[test]
    fn prefixes_and_tails(kind in any::<Index>(), body in vec(any::<u8>(), 0..60)) {
        laws::message::prefixes::<Host>(kind.get(HostMessage::ALL).number, &body);
        laws::message::prefixes::<Device>(kind.get(DeviceMessage::ALL).number, &body);
    }

    #[test]
    fn any_traffic((stream, gaps, cuts) in traffic()) {
        let mut cuts = cuts.iter().copied().cycle();
        check::<Dmc, 4096>(&stream, &gaps, || cuts.next().unwrap(), rescan(2048));
        check::<Dmc<60>, 120>(&stream, &gaps, || cuts.next().unwrap(), rescan(60));
    }
}

/// Decision D-12: the frame after the damage is not lost, and the damage is reported once.
#[test]
fn a_frame_without_its_end_loses_no_other_frame() {
    for frame in frames().iter().filter(|frame| (13..=64).contains(&frame.len())) {
        let lost = &frame[..frame.len() - 3];
        let good = &frames()[0];
        let stream = [lost, good, &[0; 64]].concat();
        let items = check::<Dmc, 4096>(&stream, &[], || 7, rescan(2048));
        assert_eq!(items.iter().filter(|item| matches!(item, Owned::Corrupt { .. })).count(), 1);
        assert!(items.iter().any(|item| matches!(item, Owned::Frame(bytes) if bytes == good)));
    }
}

/// All vectors in one stream: each frame is found, and the corrupt one is reported with its header.
#[test]
fn all_vectors_in_one_stream() {
    let frames = frames();
    let items = check::<Dmc, 4096>(&frames.concat(), &[], || 100, rescan(2048));
    let found: Vec<_> =
        items.iter().filter_map(|item| if let Owned::Frame(bytes) = item { Some(bytes) } else { None }).collect();
    assert_eq!(found.len(), frames.len() - 1);
    let corrupt: Vec<_> = items
        .iter()
        .filter_map(|item| if let Owned::Corrupt { header, .. } = item { Some(header) } else { None })
        .collect();
    let [header] = &corrupt[..] else { panic!("{corrupt:?}") };
    assert_eq!((header.id().0, header.kind().0), (85, 0x0032));
}
