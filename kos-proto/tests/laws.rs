//! Laws that hold for every message of both sides, for the blocks of moves, and for the stream.

mod recorded;

use kos_proto::trajectory::Block;
use kos_proto::{Device, DeviceMessage, Host, HostMessage, Item, Kos};
use laws::stream::{Owned, check};
use motion_core::stream::{Fatal, Frames, Framing, Noise};
use motion_core::wire::{Messages, Side};
use motion_core::zerocopy::BE;
use proptest::collection::vec;
use proptest::prelude::*;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Blocks {}

impl Side for Blocks {
    type Message<'a> = Block<'a>;
    type Order = BE;
}

/// Numbers of messages: each number of the tables, and any other number.
fn numbers() -> impl Strategy<Value = u32> {
    let all = [HostMessage::ALL, DeviceMessage::ALL, Block::ALL].concat();
    let known: Vec<u32> = all.iter().map(|kind| kind.number).chain([0x000B_8200]).collect();
    prop_oneof![3 => prop::sample::select(known), 1 => any::<u32>()]
}

#[test]
fn every_message_is_drawn_at_a_fair_share() {
    laws::drawn::shares::<Host>(200);
    laws::drawn::shares::<Device>(200);
    laws::drawn::shares::<Blocks>(200);
}

#[test]
fn every_message_of_all_tables() {
    laws::message::table::<Host>();
    laws::message::table::<Device>();
    laws::message::table::<Blocks>();
}

/// Bodies of up to `len` bytes with many small bytes, so that the counts are small and the lists complete.
fn bodies(len: usize) -> impl Strategy<Value = Vec<u8>> {
    vec(prop_oneof![2 => any::<u8>(), 2 => 0..4_u8], 0..len)
}

proptest! {
    #[test]
    fn any_body_of_any_number(number in numbers(), body in bodies(200)) {
        let _ = laws::message::any_body::<Host>(number, &body);
        let _ = laws::message::any_body::<Device>(number, &body);
        let _ = laws::message::any_body::<Blocks>(number, &body);
    }

    #[test]
    fn prefixes_and_tails(number in numbers(), body in bodies(60)) {
        laws::message::prefixes::<Host>(number, &body);
        laws::message::prefixes::<Device>(number, &body);
        laws::message::prefixes::<Blocks>(number, &body);
    }

    #[test]
    fn changed_vectors(which in any::<prop::sample::Index>(), at in any::<prop::sample::Index>(), by in any::<u8>()) {
        let vectors = whole_messages();
        let mut bytes = which.get(&vectors).clone();
        let at = at.index(bytes.len());
        bytes[at] ^= by;
        let number = u32::from_be_bytes([bytes[3], bytes[4], bytes[5], 0]);
        let (number, body) = match (number, bytes.get(6)) {
            (0x0080_0000 | 0x0081_0200, Some(&sub)) => (number | u32::from(sub), &bytes[7..]),
            _ => (number, &bytes[6..]),
        };
        let _ = laws::message::any_body::<Host>(number, body);
        let _ = laws::message::any_body::<Device>(number, body);
        laws::message::prefixes::<Host>(number, body);
        laws::message::prefixes::<Device>(number, body);
    }
}

/// Messages of the vectors that are whole messages.
fn whole_messages() -> Vec<Vec<u8>> {
    let ok = |vector: &&serde_json::Value| matches!(vector["kind"].as_str(), Some("ok" | "accept" | "accept-legacy"));
    recorded::vectors().iter().filter(ok).map(recorded::bytes).collect()
}

/// Search for frames that does not use the framing of the crate: the length of the frame at the front, or the number of
/// bytes to skip.
fn rescan(cap: usize) -> impl Fn(&[u8]) -> Result<usize, usize> {
    move |bytes| match *bytes {
        [4, l0, l1, ..] => match usize::from(l0) * 256 + usize::from(l1) {
            0..6 => Err(1),
            total if total > cap || total > bytes.len() => Err(total),
            total => Ok(total),
        },
        [4, ..] => Err(bytes.len()),
        _ => Err(1),
    }
}

/// Streams of whole, cut and damaged messages with noise between them, places of gaps, and lengths of pieces.
fn traffic() -> impl Strategy<Value = (Vec<u8>, Vec<usize>, Vec<usize>)> {
    let message = || prop::sample::select(whole_messages());
    let part = prop_oneof![
        6 => message(),
        1 => vec(prop_oneof![Just(4_u8), Just(0), Just(6), any::<u8>()], 0..20),
        1 => (message(), any::<prop::sample::Index>()).prop_map(|(mut bytes, at)| {
            bytes.truncate(at.index(bytes.len()));
            bytes
        }),
        1 => (message(), any::<prop::sample::Index>(), any::<u8>()).prop_map(|(mut bytes, at, by)| {
            let at = at.index(bytes.len());
            bytes[at] ^= by;
            bytes
        }),
    ];
    (vec(part, 0..30), vec(any::<prop::sample::Index>(), 0..4), vec(1..80_usize, 1..20)).prop_map(
        |(parts, gaps, cuts)| {
            let stream = parts.concat();
            let mut gaps: Vec<_> = gaps.iter().map(|gap| gap.index(stream.len() + 1)).collect();
            gaps.sort_unstable();
            (stream, gaps, cuts)
        },
    )
}

fn hold<const CAP: usize, const N: usize>(stream: &[u8], gaps: &[usize], cuts: &[usize]) {
    let mut cuts = cuts.iter().copied().cycle();
    check::<Kos<CAP>, N>(stream, gaps, || cuts.next().unwrap(), rescan(CAP));
}

proptest! {
    #[test]
    fn streams_of_any_traffic((stream, gaps, cuts) in traffic()) {
        hold::<32, 64>(&stream, &gaps, &cuts);
        hold::<256, 600>(&stream, &gaps, &cuts);
        hold::<16_384, 32_768>(&stream, &gaps, &cuts);
        hold::<65_535, 131_070>(&stream, &gaps, &cuts);
    }
}

#[test]
fn every_split_of_two_messages_gives_the_same() {
    let stream = [&b"\x04\x00\x0c\x00\x81\x02\x07\x03\x41\x3f\xb8\x00"[..], b"\x04\x00\x06\x00\x0b\x01"].concat();
    for split in 0..=stream.len() {
        let mut frames: Box<kos_proto::Frames> = Box::default();
        let mut found = Vec::new();
        for piece in [&stream[..split], &stream[split..]] {
            assert_eq!(frames.push(piece), piece.len());
            while let Some(item) = frames.next() {
                let Item::Frame(frame) = item else { panic!("{item:?}") };
                found.push(frame.bytes().to_vec());
            }
        }
        assert_eq!(found, [&stream[..12], &stream[12..]], "split at {split}");
        hold::<16_384, 32_768>(&stream, &[], &[split.max(1), stream.len()]);
    }
}

#[test]
fn fatal_is_said_as_soon_as_it_can_be_known() {
    assert_eq!(Kos::<100>::head(&[3]), motion_core::stream::Head::Fatal(Fatal::BadVersion { found: 3, expected: 4 }));
    assert_eq!(Kos::<100>::head(&[4, 0]), motion_core::stream::Head::More(3));
    let short = Fatal::BadLength { found: 5, least: 6 };
    assert_eq!(Kos::<100>::head(&[4, 0, 5]), motion_core::stream::Head::Fatal(short));

    let mut frames = Frames::<Kos<100>, 200>::new();
    assert_eq!(frames.push(&[4, 0, 0, 0, 0x0f, 1]), 6);
    for _ in 0..3 {
        assert!(matches!(frames.next(), Some(Item::Fatal(Fatal::BadLength { found: 0, least: 6 }))));
    }
}

#[test]
fn what_is_longer_than_the_cap_is_skipped_in_step() {
    let mut stream = vec![4, 0x01, 0x00, 0, 0x12, 0];
    stream.resize(256, 4);
    stream.extend(b"\x04\x00\x06\x00\x0f\x01");
    let items = check::<Kos<64>, 128>(&stream, &[], || 7, rescan(64));
    let why = Noise::TooLong { total: 256, max: 64 };
    assert_eq!(items, [Owned::Noise { bytes: stream[..256].to_vec(), why }, Owned::Frame(stream[256..].to_vec())]);
}
