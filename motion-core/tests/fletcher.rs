//! Fletcher-16 compared with the conformance vectors, and with the definition byte by byte.

use std::fmt::Write as _;

use motion_core::fletcher::{Sum, check_bytes, verify};
use proptest::prelude::*;
use serde_json::Value;
use sha2::{Digest, Sha256};

/// The definition of the checksum: two sums, reduced after every byte.
fn reference(bytes: &[u8]) -> u16 {
    references(bytes).last().unwrap()
}

/// The checksums of the first 0, 1, 2 and more bytes, up to all of them.
fn references(bytes: &[u8]) -> impl Iterator<Item = u16> {
    let later = bytes.iter().scan((0, 0), |(f0, f1), &byte| {
        *f0 = (*f0 + u16::from(byte)) % 255;
        *f1 = (*f1 + *f0) % 255;
        Some(*f1 << 8 | *f0)
    });
    std::iter::once(0).chain(later)
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

/// Every length up to several blocks, with the bytes that are nearest to an overflow, at even and odd places, and with
/// random bytes.
#[test]
fn every_length_has_the_right_checksum() {
    let alternating = |even, odd| [even, odd].repeat(2_048);
    let fills = [vec![0xFF; 4_096], alternating(0xFF, 0), alternating(0, 0xFF), lcg(7, 4_096)];
    for fill in &fills {
        for (len, sum) in references(fill).enumerate() {
            let bytes = &fill[..len];
            assert_eq!(Sum::of(bytes).value(), sum, "{len} bytes of {:?}..", &fill[..2]);
            assert!(len > 500 || verify(bytes) == (sum == 0), "{len} bytes of {:?}..", &fill[..2]);
        }
    }
}

/// A frame with a changed byte has another first sum. Two changed bytes may leave the first sum as it is.
#[test]
fn a_wrong_first_or_second_sum_is_detected() {
    for len in (3..400).chain((400..=4_096).step_by(37)) {
        let frame = sealed(&lcg(13, len - 2));
        assert!(verify(&frame), "{len} bytes");
        for at in [0, len / 3, len / 2, len - 2] {
            let (one, next) = (frame[at], frame[at + 1]);
            let mut other = frame.clone();
            other[at] = one ^ 0x10;
            assert!(!verify(&other), "{len} bytes, byte {at} is changed");
            (other[at], other[at + 1]) = (next, one);
            assert_eq!(verify(&other), one % 255 == next % 255, "{len} bytes, bytes {at} and {} are swapped", at + 1);
        }
    }
}

#[test]
fn zero_bytes_in_front_change_nothing() {
    for len in 0..=300 {
        let bytes = [vec![0; 40], lcg(17, len)].concat();
        for zeros in 0..40 {
            assert_eq!(Sum::of(&bytes[zeros..]), Sum::of(&bytes[40..]), "{} zeros before {len} bytes", 40 - zeros);
        }
    }
}

#[test]
fn check_bytes_of_a_head_and_a_body_are_those_of_the_whole() {
    let known = [
        [0xFF; 8],
        [0xFF, 0, 0xFF, 0, 0xFF, 0, 0xFF, 0],
        [0; 8],
        *b"\0\0\0\0\0\0DF",
        *b"\x01\x02\x03\x04\x05\x06\x07\x08",
    ];
    for low in known {
        for high in known {
            let bytes = [&low, &high, &lcg(23, 1_100)[..]].concat();
            for fill in [bytes, [&low, &high, &[0xFF; 1_100][..]].concat()] {
                for len in (0..200).chain([367, 368, 369, 1_029, 1_100]) {
                    let check = check_bytes([low, high], &fill[16..16 + len]);
                    assert_eq!(check, Sum::of(&fill[..16 + len]).check_bytes(), "{low:?} {high:?} and {len} bytes");
                }
            }
        }
    }
    let long = lcg(29, 200_000);
    assert_eq!(
        check_bytes([known[3], known[4]], &long),
        Sum::of(&[&known[3], &known[4], &long[..]].concat()).check_bytes()
    );
}

/// All 65,025 states before the last two bytes, which are all possible check bytes of a frame.
#[test]
fn only_the_right_check_bytes_are_accepted() {
    for len in [2, 7, 8, 9, 12, 16, 17, 19, 25, 40, 41, 48, 80, 91, 127, 128, 145] {
        let mut frame = lcg(19, len);
        let state = Sum::of(&frame[..len - 2]);
        for check in 0..=u16::MAX {
            let check = check.to_le_bytes();
            frame[len - 2..].copy_from_slice(&check);
            let right = state.check_bytes().map(|byte| byte % 255) == check.map(|byte| byte % 255);
            assert_eq!(verify(&frame), right, "{len} bytes, check bytes {check:?}");
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
