//! Fletcher-16 compared with other implementations, on frames with the lengths of DMC.
//!
//! All contenders get the same bytes. Those that compute the same sum are compared with each other
//! first. The byte sum computes less and is only there for comparison.

use std::hint::black_box;

use benches::ratios::{Contender, Table, contender};
use benches::report::Report;
use motion_core::fletcher::{Sum, verify};

/// Lengths of frames, in bytes: empty messages, acks, jogs, positions of 16 motors, and the longest uploads.
const LENGTHS: [usize; 6] = [12, 14, 19, 80, 1041, 1048];

pub(crate) fn chapter(report: &mut Report) {
    let frames = LENGTHS.map(sound_frame);
    for frame in &frames {
        agree(frame);
    }

    let mut table = report.table("Fletcher-16, verify");
    for frame in &frames {
        table.row(&format!("{} B", frame.len()), contenders(frame));
    }
    let mut table = report.table("Fletcher-16, verify, length known to the compiler");
    array_row::<12>(&mut table);
    array_row::<14>(&mut table);
    array_row::<19>(&mut table);
    array_row::<80>(&mut table);
}

fn contenders(frame: &[u8]) -> Vec<Contender<'_>> {
    let mut contenders = vec![contender("motion-core", || verify(black_box(frame)))];
    contenders.extend(peers(frame));
    contenders
}

/// Measures a frame as an array. The peers take the same bytes as a slice, as always.
fn array_row<const N: usize>(table: &mut Table<'_>) {
    let frame: [u8; N] = sound_frame(N).try_into().expect("the frame has N bytes");
    let mut contenders = vec![contender("motion-core, array", || verify(black_box::<&[u8; N]>(&frame)))];
    contenders.extend(peers(&frame));
    table.row(&format!("{N} B"), contenders);
}

fn peers(frame: &[u8]) -> [Contender<'_>; 4] {
    [
        contender("byte sum (u32)", || byte_sum(black_box(frame))),
        contender("byte sum (u64)", || wide_byte_sum(black_box(frame))),
        contender("fletcher", || fletcher::calc_fletcher16(black_box(frame)) == 0),
        contender("C listing", || listing(black_box(frame)) == 0),
    ]
}

/// Sum of the bytes, in a plain loop that the compiler may vectorise.
fn byte_sum(bytes: &[u8]) -> u32 {
    bytes.iter().map(|&byte| u32::from(byte)).sum()
}

/// Sum of the bytes in 64 bits, which takes twice as many vector steps.
fn wide_byte_sum(bytes: &[u8]) -> u64 {
    bytes.iter().map(|&byte| u64::from(byte)).sum()
}

/// The listing of the specification, statement by statement.
fn listing(mut data: &[u8]) -> u16 {
    let (mut sum1, mut sum2) = (0_u16, 0_u16);
    while !data.is_empty() {
        let (block, rest) = data.split_at(data.len().min(20));
        for &byte in block {
            sum1 = sum1.wrapping_add(u16::from(byte));
            sum2 = sum2.wrapping_add(sum1);
        }
        sum1 %= 0xFF;
        sum2 %= 0xFF;
        data = rest;
    }
    (sum2 << 8) | sum1
}

/// Valid frame of `len` bytes: random bytes from a fixed seed, and their check bytes.
fn sound_frame(len: usize) -> Vec<u8> {
    let mut state = 1_u32;
    let mut frame: Vec<u8> = (2..len)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state.to_be_bytes()[0]
        })
        .collect();
    frame.extend(Sum::of(&frame).check_bytes());
    frame
}

/// Checks that all contenders give the same sums of the frame and of its body, whose sum is not zero.
fn agree(frame: &[u8]) {
    let body = &frame[..frame.len() - 2];
    assert!(verify(frame) && !verify(body), "the frame verifies, and its body alone does not");
    for bytes in [frame, body] {
        let ours = Sum::of(bytes).value();
        assert_eq!(ours, listing(bytes), "the sum equals that of the listing in the specification");
        assert_eq!(ours, fletcher::calc_fletcher16(bytes), "the sum equals that of the crate fletcher");
    }
    assert_eq!(byte_sum(frame) % 255, 0, "the first of the two sums is zero");
    assert_eq!(u64::from(byte_sum(body)), wide_byte_sum(body), "both byte sums are equal");
}
