//! Fletcher-16 compared with the conformance vectors, and with the definition byte by byte.

use std::fmt::Write as _;

use motion_core::fletcher::{Sum, verify};
use proptest::prelude::*;
use serde_json::Value;
use sha2::{Digest, Sha256};

/// The definition of the checksum: two sums, reduced after every byte.
fn reference(bytes: &[u8]) -> u16 {
    let (f0, f1) = bytes.iter().fold((0, 0), |(f0, f1), &byte| {
        let f0 = (f0 + u16::from(byte)) % 255;
        (f0, (f1 + f0) % 255)
    });
    f1 << 8 | f0
}

/// Random bytes by the `lcg` rule of the vectors.
fn lcg(seed: u32, len: usize) -> Vec<u8> {
    let step = |state: &u32| Some(state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    std::iter::successors(step(&seed), step).map(|state| state.to_be_bytes()[0]).take(len).collect()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

/// The bytes, followed by their check bytes.
fn sealed(bytes: &[u8]) -> Vec<u8> {
    [bytes, &Sum::of(bytes).check_bytes()].concat()
}

#[test]
fn the_vectors_have_the_right_checksums() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../vectors/fletcher16.json");
    let file: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let vectors = file["vectors"].as_array().unwrap();
    assert_eq!(vectors.len(), 51, "17 lengths, filled in 3 ways");
    for vector in vectors {
        let len = usize::try_from(vector["len"].as_u64().unwrap()).unwrap();
        let input = match vector["fill"].as_str().unwrap() {
            "00" => vec![0; len],
            "ff" => vec![0xFF; len],
            "lcg" => lcg(u32::try_from(vector["seed"].as_u64().unwrap()).unwrap(), len),
            other => panic!("no rule for fill {other}"),
        };
        assert_eq!(vector["sha256"], hex(&Sha256::digest(&input)), "input of {vector}");
        if let Some(shown) = vector["hex"].as_str() {
            assert_eq!(shown, hex(&input), "input of {vector}");
        }

        let sum = Sum::of(&input);
        assert_eq!(vector["checksum"], format!("0x{:04X}", sum.value()), "{vector}");
        assert_eq!(vector["check_bytes"], hex(&sum.check_bytes()), "{vector}");
        assert_eq!(sum.value(), reference(&input), "{vector}");
        assert!(verify(&sealed(&input)), "{vector}");
    }
}

/// Every length up to several blocks, with the bytes that are nearest to an overflow, and with random bytes.
#[test]
fn every_length_has_the_right_checksum() {
    let fills = [vec![0xFF; 5_000], vec![0xFE; 5_000], lcg(7, 5_000)];
    for fill in &fills {
        for len in 0..=fill.len() {
            assert_eq!(Sum::of(&fill[..len]).value(), reference(&fill[..len]), "{len} bytes of {}..", fill[0]);
        }
    }
}

#[test]
fn long_inputs_have_the_right_checksum() {
    for len in [65_535, 65_547, 1_000_003, 16_777_216] {
        for bytes in [vec![0xFE; len], lcg(3, len)] {
            assert_eq!(Sum::of(&bytes).value(), reference(&bytes), "{len} bytes");
        }
    }
}

/// Two bytes are enough to reach each of the 255 * 255 sums.
#[test]
fn check_bytes_make_every_sum_zero() {
    let mut seen = std::collections::HashSet::new();
    for first in 0..255 {
        for second in 0..255 {
            let sum = Sum::of(&[first, second]);
            let [c0, c1] = sum.check_bytes();
            assert!(c0 > 0 && c1 > 0, "{sum:?} gives {c0}, {c1}");
            assert_eq!(sum.update(&[c0, c1]), Sum::ZERO, "{sum:?}");
            // The formula of the specification.
            let (f0, f1) = (sum.value() & 0xFF, sum.value() >> 8);
            let published = 255 - (f0 + f1) % 255;
            assert_eq!([u16::from(c0), u16::from(c1)], [published, 255 - (f0 + published) % 255], "{sum:?}");
            seen.insert(sum);
        }
    }
    assert_eq!(seen.len(), 255 * 255);
}

/// A 0 in place of a 255 is accepted, in check bytes and elsewhere; any other change of one byte is detected.
#[test]
fn only_0_and_255_are_accepted_for_each_other() {
    assert!(verify(&[]) && verify(&[0, 0]) && verify(&[0xFF, 0xFF]) && verify(&[0, 0xFF]));
    let frame = sealed(&lcg(11, 40));
    for at in 0..frame.len() {
        for byte in 0..=255 {
            let mut other = frame.clone();
            other[at] = byte;
            let equal = byte % 255 == frame[at] % 255;
            assert_eq!(verify(&other), equal, "byte {at}: {} changed to {byte}", frame[at]);
        }
    }
}

#[test]
fn arrays_are_verified_like_slices() {
    fn check<const N: usize>() {
        let mut frame: [u8; N] = sealed(&lcg(5, N - 2)).try_into().unwrap();
        assert!(verify(&frame), "{N} bytes");
        frame[N / 2] ^= 0x10;
        assert!(!verify(&frame), "{N} bytes, one bit flipped");
    }
    check::<2>();
    check::<12>();
    check::<14>();
    check::<16>();
    check::<19>();
    check::<80>();
    check::<127>();
    check::<128>();
    check::<1041>();
}

proptest! {
    #[test]
    fn any_bytes_have_the_right_checksum(bytes in proptest::collection::vec(any::<u8>(), 0..5_000)) {
        prop_assert_eq!(Sum::of(&bytes).value(), reference(&bytes));
        prop_assert!(verify(&sealed(&bytes)));
    }

    /// Pieces are summed one by one, joined and separated again.
    #[test]
    fn the_sum_does_not_depend_on_the_pieces(
        bytes in proptest::collection::vec(any::<u8>(), 0..5_000),
        cuts in proptest::collection::vec(any::<proptest::sample::Index>(), 0..8),
    ) {
        let whole = Sum::of(&bytes);
        let mut cuts: Vec<_> = cuts.iter().map(|cut| cut.index(bytes.len() + 1)).collect();
        cuts.extend([0, bytes.len()]);
        cuts.sort_unstable();
        let running = cuts.windows(2).fold(Sum::ZERO, |sum, cut| sum.update(&bytes[cut[0]..cut[1]]));
        prop_assert_eq!(running, whole);

        for cut in cuts {
            let (left, right) = bytes.split_at(cut);
            prop_assert_eq!(Sum::of(left).then(Sum::of(right), right.len()), whole);
            prop_assert_eq!(whole.after(Sum::of(left), right.len()), Sum::of(right));
        }
    }
}
