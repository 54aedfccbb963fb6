//! The laws over every message of both sides, and over the stream.

use hoot_proto::{Device, DeviceMessage, Hoot, Host, HostMessage, Messages, Requests, Strict};
use laws::stream::{Drain, Feed, Owned, read};
use proptest::prelude::*;
use serde_json::Value;

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

/// Both sides of the vectors, packet by packet.
fn traffic() -> Vec<Vec<u8>> {
    let vectors: Vec<Value> = serde_json::from_str(include_str!("../../vectors/hoot.json")).unwrap();
    let hex =
        |hex: &str| (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect();
    vectors.iter().map(|vector| hex(vector["hex"].as_str().unwrap())).collect()
}

const BREAK: [u8; 6] = [0, 0, 0, 0, 0, 255];

/// Finds a packet at each break that is followed by its data.
fn rescan_for_breaks(bytes: &[u8]) -> Result<usize, usize> {
    match bytes.get(9) {
        Some(&len @ 0..=32) if bytes.starts_with(&BREAK) && bytes.len() >= 10 + usize::from(len) => {
            Ok(10 + usize::from(len))
        }
        _ => Err(1),
    }
}

/// The same, except that a header of zeros is not a packet.
fn rescan_for_requests(bytes: &[u8]) -> Result<usize, usize> {
    if bytes.get(6..10) == Some(&[0; 4]) { Err(1) } else { rescan_for_breaks(bytes) }
}

/// Reads ten bytes and the data, and checks the break only then.
fn read_like_a_node(bytes: &[u8]) -> Result<usize, usize> {
    let Some(&len) = bytes.get(9) else { return Err(bytes.len()) };
    let total = 10 + usize::from(len);
    if total <= bytes.len() && len <= 32 && bytes.starts_with(&BREAK) { Ok(total) } else { Err(total) }
}

/// Packets of the vectors, noise, parts of breaks and wrong headers, in any order, some of them cut off.
fn any_stream() -> impl Strategy<Value = Vec<u8>> {
    let packets = traffic();
    let part = prop_oneof![
        6 => any::<prop::sample::Index>().prop_map(move |at| at.get(&packets).clone()),
        1 => any::<prop::sample::Index>().prop_map(|at| BREAK[..at.index(7)].to_vec()),
        1 => (1_usize..4).prop_map(|breaks| BREAK.repeat(breaks)),
        1 => (0_usize..20).prop_map(|zeros| vec![0; zeros]),
        1 => any::<[u8; 4]>().prop_map(|rest| [&BREAK[..], &rest].concat()),
        1 => proptest::collection::vec(any::<u8>(), 0..12),
    ];
    let cut = (part, any::<prop::sample::Index>(), 0..8).prop_map(|(mut part, at, dice)| {
        if dice == 0 {
            part.truncate(at.index(part.len() + 1));
        }
        part
    });
    proptest::collection::vec(cut, 0..24).prop_map(|parts| parts.concat())
}

proptest! {
    #[test]
    fn any_body_of_any_command(number in 0_u32..=0x2_FFFF, body in proptest::collection::vec(any::<u8>(), 0..60)) {
        let _ = laws::message::any_body::<Host>(number, &body);
        let _ = laws::message::any_body::<Device>(number, &body);
    }

    #[test]
    fn prefixes_and_tails(kind in any::<prop::sample::Index>(), body in proptest::collection::vec(any::<u8>(), 0..40)) {
        laws::message::prefixes::<Host>(kind.get(HostMessage::ALL).number, &body);
        laws::message::prefixes::<Device>(kind.get(DeviceMessage::ALL).number, &body);
    }

    #[test]
    fn any_stream_in_any_pieces(
        stream in any_stream(),
        mut gaps in proptest::collection::vec(0_usize..400, 0..3),
        cuts in proptest::collection::vec(1_usize..40, 1..8),
    ) {
        gaps.sort_unstable();
        let mut at = 0;
        let mut cut = || { at += 1; cuts[at % cuts.len()] };
        laws::stream::check::<Hoot, 84>(&stream, &gaps, &mut cut, rescan_for_breaks);
        laws::stream::check::<Requests, 84>(&stream, &gaps, &mut cut, rescan_for_requests);
        laws::stream::check::<Strict, 84>(&stream, &gaps, &mut cut, read_like_a_node);
    }
}

#[test]
fn all_vectors_in_one_stream() {
    let mut packets = traffic();
    packets.retain(|packet| rescan_for_breaks(packet) == Ok(packet.len()));
    assert_eq!(packets.len(), traffic().len() - 2, "all but the malformed ones");
    let found = laws::stream::check::<Hoot, 84>(&packets.concat(), &[], || 17, rescan_for_breaks);
    assert_eq!(found, packets.into_iter().map(Owned::Frame).collect::<Vec<_>>());
}

#[test]
fn floods_cost_no_more_than_their_bytes() {
    let lying = [0, 0, 0, 0, 0, 255, 3, 0, 2, 255];
    let short = [0, 0, 0, 0, 0, 255, 3, 0, 2, 32];
    for unit in [&[0][..], &[255], &BREAK, &[0, 0, 0, 0, 255], &[0, 0, 0, 0, 0, 1], &lying, &short] {
        let flood: Vec<u8> = unit.iter().copied().cycle().take(60_000).collect();
        for cut in [1, 7, 84] {
            let tolerant = read::<Hoot, 84>(&flood, &[], Drain::AtGap, Feed::Push, || cut).work;
            let requests = read::<Requests, 84>(&flood, &[], Drain::AtGap, Feed::Push, || cut).work;
            let strict = read::<Strict, 84>(&flood, &[], Drain::AtGap, Feed::Push, || cut).work;
            assert!(
                tolerant.max(requests).max(strict) <= 4 * flood.len(),
                "{unit:?} by {cut}: {tolerant}, {requests}, {strict}"
            );
        }
    }
}
