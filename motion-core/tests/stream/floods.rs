//! Streams that are designed to be expensive. Their work is counted, so the tests do not depend on a clock.

use laws::stream::{Drain, Feed, read};
use motion_core::stream::Framing;

use crate::framings::{Dmc, Hoot, Kos, dmc_frame, dmc_rescan, hoot_frame, kos_frame};

/// Greatest work for each byte of any flood: bytes read, summed, skipped and moved, and headers read.
const WORST: usize = 8;

fn dmc_head(len: usize) -> Vec<u8> {
    let [l0, l1] = u16::try_from(len).unwrap().to_le_bytes();
    vec![b'D', b'F', 1, 0, 0, 0, 0x36, 0, l0, l1]
}

/// A marker every five bytes. The length field of each header is at the end of the next five bytes.
fn dense(len: usize) -> Vec<u8> {
    let [l0, l1] = u16::try_from(len).unwrap().to_le_bytes();
    vec![b'D', b'F', 9, l0, l1]
}

fn dmc_floods(max: usize) -> Vec<(&'static str, Vec<u8>)> {
    let longest = max - 12;
    let after_wrong_length = [dmc_head(longest), dmc_frame(1, 0x34, &[0; 7]).repeat(max / 19)].concat();
    let in_turn = [dmc_frame(1, 0x34, &[]), dmc_head(longest)].concat();
    let mixed = [dense(8).repeat(max / 10), dense(longest).repeat(max / 10)].concat();
    [
        ("wrong lengths", dmc_head(longest)),
        ("half the longest", dmc_head(longest / 2 + 7)),
        ("length 0", dmc_head(0)),
        ("dense markers, longest", dense(longest)),
        ("dense markers, short", dense(8)),
        ("dense markers, length 0", dense(0)),
        ("dense markers, mixed", mixed),
        ("valid frames after a wrong length", after_wrong_length),
        ("valid frames and wrong lengths in turn", in_turn),
        ("markers", b"DF".to_vec()),
        ("markers, every third byte", b"DF\x09".to_vec()),
        ("half markers", b"D".to_vec()),
        ("clean", dmc_frame(1, 0x34, &[7; 68])),
    ]
    .map(|(name, unit)| (name, unit.iter().copied().cycle().take(max * 12).collect()))
    .into()
}

fn kos_floods(max: usize) -> Vec<(&'static str, Vec<u8>)> {
    [
        ("all fatal", vec![0]),
        ("versions", vec![4]),
        ("too short", vec![4, 0, 5]),
        ("smallest", kos_frame(1, &[])),
        ("too long", kos_frame(1, &vec![4; 60_000])),
        ("fatal in between", [kos_frame(1, &[]), vec![9]].concat()),
    ]
    .map(|(name, unit)| (name, unit.iter().copied().cycle().take(max * 12).collect()))
    .into()
}

fn hoot_floods() -> Vec<(&'static str, Vec<u8>)> {
    [
        ("zeros", vec![0]),
        ("ones", vec![0xFF]),
        ("breaks", vec![0, 0, 0, 0, 0, 0xFF]),
        ("nearly breaks", vec![0, 0, 0, 0, 0xFF]),
        ("too long", [&hoot_frame([1, 2, 3], &[])[..9], &[33]].concat()),
        ("longest", hoot_frame([3, 0, 2], &[0; 32])),
    ]
    .map(|(name, unit)| (name, unit.iter().copied().cycle().take(20_000).collect()))
    .into()
}

/// Checks each flood whole, in pieces of 64 bytes, and byte by byte.
fn bounded<F: Framing, const N: usize>(floods: Vec<(&'static str, Vec<u8>)>) {
    for (name, flood) in floods {
        for (feed, cut) in
            [(Feed::Push, usize::MAX), (Feed::Lend, usize::MAX), (Feed::Lend, 300), (Feed::Push, 64), (Feed::Push, 1)]
        {
            let work = read::<F, N>(&flood, &[], Drain::AtGap, feed, || cut).work;
            let tenths = work * 10 / flood.len();
            println!("longest frame {}, {name}, {feed:?}, pieces of {cut}: {tenths} tenths for each byte", F::MAX);
            assert!(work <= WORST * flood.len(), "{name}, {feed:?} of {cut}: {work} for {} bytes", flood.len());
        }
    }
}

#[test]
fn work_for_each_byte_is_bounded_for_any_longest_frame() {
    fn dmc<const MAX: usize, const N: usize>() {
        bounded::<Dmc<MAX>, N>(dmc_floods(MAX));
    }
    // The largest buffers do not fit the stack of a test.
    let all = || {
        dmc::<1048, 2096>();
        dmc::<2048, 4096>();
        dmc::<16_384, 32_768>();
        dmc::<65_547, 131_094>();
        bounded::<Kos<1024>, 2048>(kos_floods(1024));
        bounded::<Kos<65_535>, 131_070>(kos_floods(65_535));
        bounded::<Hoot, 84>(hoot_floods());
    };
    std::thread::Builder::new().stack_size(16 << 20).spawn(all).unwrap().join().unwrap();
}

#[test]
fn floods_hide_no_frame() {
    for (name, flood) in dmc_floods(1048) {
        println!("{name}");
        laws::stream::check::<Dmc<1048>, 2096>(&flood, &[], || 300, dmc_rescan(1048));
    }
}
