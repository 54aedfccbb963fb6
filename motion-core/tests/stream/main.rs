//! Streams of all three framings, compared with the laws and with a rescan.

mod floods;
mod framings;

use framings::{Dmc, Hoot, Kos, dmc_frame, dmc_rescan, hoot_frame, hoot_rescan, kos_frame, kos_rescan};
use laws::stream::{Owned, check};
use motion_core::stream::{Corrupt, Fatal, Frames, Framing, Item, Noise};
use proptest::collection::vec;
use proptest::prelude::*;

/// A stream, the positions of its gaps, and the lengths of its pieces.
type Case = (Vec<u8>, Vec<usize>, Vec<usize>);

/// Streams of whole, cut, damaged and nested frames, with noise between them that begins like a frame.
fn cases(marker: &'static [u8], frame: fn(&[u8]) -> Vec<u8>) -> impl Strategy<Value = Case> {
    let data = || vec(prop_oneof![any::<u8>(), prop::sample::select(marker)], 0..30);
    let damaged = move |bytes: Vec<u8>, at: prop::sample::Index, by: u8| {
        let mut bytes = frame(&bytes);
        let at = at.index(bytes.len());
        bytes[at] ^= by;
        bytes
    };
    let part = prop_oneof![
        3 => data().prop_map(move |data| frame(&data)),
        1 => data(),
        1 => vec(prop::sample::select(marker), 0..12),
        1 => (data(), any::<prop::sample::Index>()).prop_map(move |(data, at)| {
            let bytes = frame(&data);
            bytes[..at.index(bytes.len())].to_vec()
        }),
        2 => (data(), any::<prop::sample::Index>(), 1..=255_u8).prop_map(move |(data, at, by)| damaged(data, at, by)),
        1 => (data(), any::<prop::sample::Index>(), 1..=255_u8).prop_map(move |(data, at, by)| damaged(frame(&data), at, by)),
    ];
    (vec(part, 0..40), vec(any::<prop::sample::Index>(), 0..4), vec(1..60_usize, 1..20)).prop_map(
        |(parts, gaps, cuts)| {
            let stream = parts.concat();
            let mut gaps: Vec<_> = gaps.iter().map(|gap| gap.index(stream.len() + 1)).collect();
            gaps.sort_unstable();
            (stream, gaps, cuts)
        },
    )
}

fn assert_laws<F: Framing, const N: usize>(
    (stream, gaps, cuts): &Case,
    rescan: impl Fn(&[u8]) -> Result<usize, usize>,
) {
    let mut cuts = cuts.iter().copied().cycle();
    check::<F, N>(stream, gaps, || cuts.next().unwrap(), rescan);
}

proptest! {
    #[test]
    fn dmc_streams_obey_the_laws(case in cases(b"DDF\0", |data| dmc_frame(7, 0x36, data))) {
        assert_laws::<Dmc<50>, 100>(&case, dmc_rescan(50));
        assert_laws::<Dmc<1048>, 2096>(&case, dmc_rescan(1048));
    }

    #[test]
    fn kos_streams_obey_the_laws(case in cases(b"\x04\x04\x00\x06\x09", |data| kos_frame(0x81, data))) {
        assert_laws::<Kos<24>, 48>(&case, kos_rescan(24));
        assert_laws::<Kos<65_535>, 131_070>(&case, kos_rescan(65_535));
    }

    #[test]
    fn hoot_streams_obey_the_laws(case in cases(b"\0\0\0\0\0\0\xFF", |data| hoot_frame([0, 0, 1], data))) {
        assert_laws::<Hoot, 84>(&case, hoot_rescan);
        assert_laws::<Hoot, 4096>(&case, hoot_rescan);
    }

    #[test]
    fn any_bytes_obey_the_laws(case in (vec(any::<u8>(), 0..600), Just(vec![]), vec(1..60_usize, 1..9))) {
        assert_laws::<Dmc<1048>, 2096>(&case, dmc_rescan(1048));
        assert_laws::<Kos<1024>, 2048>(&case, kos_rescan(1024));
        assert_laws::<Hoot, 84>(&case, hoot_rescan);
    }
}

#[test]
fn pieces_and_gaps_at_every_place_obey_the_laws() {
    let dmc = [&b"DF"[..], &dmc_frame(1, 2, b"DDF"), b"D", &dmc_frame(3, 4, &[])].concat();
    let kos = [kos_frame(1, &[4, 0, 6]), kos_frame(2, &[0; 30]), kos_frame(3, &[])].concat();
    let hoot = [&b"\0\0\0"[..], &hoot_frame([0, 0, 1], &[0; 7]), &hoot_frame([0; 3], &[])].concat();
    for split in 1..60 {
        for gaps in (0..dmc.len().max(kos.len()).max(hoot.len())).map(|gap| [gap]) {
            let case = |stream: &[u8]| (stream.to_vec(), gaps.to_vec(), vec![split]);
            assert_laws::<Dmc<20>, 40>(&case(&dmc), dmc_rescan(20));
            assert_laws::<Kos<20>, 40>(&case(&kos), kos_rescan(20));
            assert_laws::<Hoot, 84>(&case(&hoot), hoot_rescan);
        }
    }
}

#[test]
fn a_dmc_frame_cut_by_three_bytes_costs_only_itself() {
    let good = dmc_frame(2, 0x36, b"good");
    let mut stream = dmc_frame(1, 0x30, b"a frame that lost its end");
    stream.truncate(stream.len() - 3);
    stream.extend_from_slice(&good);
    stream.extend_from_slice(&[0; 9]);
    let items = check::<Dmc<1048>, 2096>(&stream, &[], || 7, dmc_rescan(1048));
    let [corrupt, noise, Owned::Frame(frame), Owned::Noise { .. }] = &items[..] else { panic!("{items:?}") };
    let why = Corrupt::Checksum { len: 37 };
    assert_eq!(*corrupt, Owned::Corrupt { header: (1, 0x30), why, bytes: b"DF".to_vec() });
    assert_eq!(noise.bytes().len(), 32);
    assert_eq!(*frame, good);
}

#[test]
fn a_valid_frame_ends_the_episode() {
    let (mut bad, good) = (dmc_frame(1, 0x30, b"bad"), dmc_frame(2, 0x36, b"good"));
    bad[11] ^= 4;
    let stream = [&bad[..], &bad, &good, &bad].concat();
    let items = check::<Dmc<1048>, 2096>(&stream, &[], || 5, dmc_rescan(1048));
    let [Owned::Corrupt { .. }, Owned::Noise { .. }, Owned::Frame(frame), Owned::Corrupt { .. }, Owned::Noise { .. }] =
        &items[..]
    else {
        panic!("{items:?}")
    };
    assert_eq!(*frame, good);
}

#[test]
fn a_kos_frame_longer_than_the_limit_is_skipped_whole() {
    let (long, good) = (kos_frame(1, &[4; 500]), kos_frame(2, b"good"));
    let why = Noise::TooLong { total: 506, max: 20 };
    let wanted = [Owned::Noise { bytes: long.clone(), why }, Owned::Frame(good.clone())];
    assert_eq!(check::<Kos<20>, 40>(&[&long[..], &good].concat(), &[], || 13, kos_rescan(20)), wanted);

    // A gap ends the wait for the rest of it.
    let stream = [&long[..100], &good].concat();
    let wanted = [Owned::Noise { bytes: long[..100].to_vec(), why }, Owned::Frame(good)];
    assert_eq!(check::<Kos<20>, 40>(&stream, &[100], || 13, kos_rescan(20)), wanted);
}

#[test]
fn bytes_after_a_gap_do_not_complete_what_was_before() {
    let (cut_off, good) = (&kos_frame(1, &[9; 10])[..12], kos_frame(2, b"good"));
    let mut frames = Frames::<Kos<20>, 40>::new();
    assert_eq!(frames.push(cut_off), 12);
    assert!(frames.next().is_none());
    frames.gap();
    assert_eq!(frames.push(&good), 10);
    assert!(matches!(frames.next(), Some(Item::Noise { bytes, why: Noise::CutOff }) if bytes == cut_off));
    assert!(matches!(frames.next(), Some(Item::Frame(frame)) if frame == good));
    assert!(frames.next().is_none());
}

#[test]
fn a_fatal_error_is_returned_again_until_resync_or_reset() {
    let why = Fatal::BadVersion { found: 7, expected: 4 };
    let good = kos_frame(2, b"good");
    let mut frames = Frames::<Kos<20>, 40>::default();
    assert_eq!(frames.push(b"\x07\x04\0\x02"), 4);
    assert!(matches!(frames.next(), Some(Item::Fatal(again)) if again == why));
    assert_eq!(frames.push(&good), 10);
    assert!(matches!(frames.next(), Some(Item::Fatal(again)) if again == why));
    frames.resync();
    let mut left = Vec::new();
    while left.len() < 4 {
        let Some(Item::Noise { bytes, why: Noise::Resync }) = frames.next() else { panic!("not noise") };
        left.extend_from_slice(bytes);
    }
    assert_eq!(left, b"\x07\x04\0\x02");
    assert!(matches!(frames.next(), Some(Item::Frame(frame)) if frame == good));

    // After the valid frame, fatal errors are returned again.
    assert_eq!(frames.push(&[7, 7]), 2);
    assert!(matches!(frames.next(), Some(Item::Fatal(_))));
    frames.reset();
    assert_eq!((frames.held(), frames.next().is_none()), (0, true));
    assert_eq!(frames.push(&good), 10);
    assert!(matches!(frames.next(), Some(Item::Frame(frame)) if frame == good));

    // On a new connection, the rest of a skipped frame is not skipped.
    assert_eq!(frames.push(&kos_frame(1, &[0; 500])[..9]), 9);
    assert!(matches!(frames.next(), Some(Item::Noise { bytes, .. }) if bytes.len() == 9));
    frames.reset();
    assert_eq!(frames.push(&good), 10);
    assert!(matches!(frames.next(), Some(Item::Frame(frame)) if frame == good));

    // Without a fatal error, a resync does nothing.
    frames.resync();
    assert_eq!(frames.push(&[7]), 1);
    assert!(matches!(frames.next(), Some(Item::Fatal(_))));
}

#[test]
fn bytes_can_be_read_directly_into_the_buffer() {
    let stream = dmc_frame(1, 2, b"data").repeat(100);
    let (mut frames, mut rest, mut found) = (Frames::<Dmc<20>, 40>::new(), &stream[..], 0);
    while !rest.is_empty() {
        let spare = frames.spare_mut();
        assert!(!spare.is_empty());
        let n = std::io::Read::read(&mut rest, spare).unwrap();
        frames.commit(n);
        while let Some(item) = frames.next() {
            assert!(matches!(item, Item::Frame(frame) if frame.len() == 16));
            found += 1;
        }
    }
    assert_eq!(found, 100);
}
