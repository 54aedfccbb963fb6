//! Fletcher-16 beside its peers, on frames of the lengths DMC has.
//!
//! Every contender gets the same bytes. Those that compute the same sum are checked against each
//! other first; the byte sum computes less and is there as a yardstick.

use std::hint::black_box;

use benches::ratios::{Contender, Table, contender};
use criterion::{BenchmarkId, Criterion, Throughput};
use motion_core::fletcher::{Sum, verify, verify_array};

/// Empty messages, acks, jogs, positions of 16 motors, and the longest uploads.
const LENGTHS: [usize; 6] = [12, 14, 19, 80, 1041, 1048];

fn main() {
    let frames = LENGTHS.map(sound_frame);
    for frame in &frames {
        agree(frame);
    }

    let mut table = Table::new("Fletcher-16, verify");
    for frame in &frames {
        let contenders = contenders(frame);
        table.row(&format!("{} B", frame.len()), contenders);
    }

    let mut criterion = Criterion::default().configure_from_args();
    for frame in &frames {
        criterion_group(&mut criterion, frame);
    }
    criterion.final_summary();
}

fn contenders(frame: &[u8]) -> Vec<Contender<'_>> {
    vec![
        contender("motion-core", || verify(black_box(frame))),
        contender("byte sum", || byte_sum(black_box(frame))),
        contender("fletcher 1.0.0", || fletcher::calc_fletcher16(black_box(frame)) == 0),
        contender("C listing", || listing(black_box(frame)) == 0),
    ]
}

/// Adds the bytes, as a plain loop that the compiler may vectorise.
fn byte_sum(bytes: &[u8]) -> u32 {
    bytes.iter().map(|&byte| u32::from(byte)).sum()
}

/// The specification's own listing, statement by statement.
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

/// A frame of `len` bytes that verifies: random bytes from a fixed seed, and their check bytes.
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

/// All contenders give the same sums, of the frame and of its body, whose sum is not zero.
fn agree(frame: &[u8]) {
    let body = &frame[..frame.len() - 2];
    assert!(verify(frame) && !verify(body), "a sound frame, and a piece of one");
    for bytes in [frame, body] {
        let ours = Sum::of(bytes).value();
        assert_eq!(ours, listing(bytes), "the specification's listing");
        assert_eq!(ours, fletcher::calc_fletcher16(bytes), "crate fletcher");
    }
    assert_eq!(byte_sum(frame) % 255, 0, "the byte sum sees every byte");
}

fn criterion_group(criterion: &mut Criterion, frame: &[u8]) {
    let mut group = criterion.benchmark_group("fletcher16");
    group.throughput(Throughput::Bytes(frame.len() as u64));
    group.bench_with_input(BenchmarkId::new("motion-core", frame.len()), frame, |b, frame| b.iter(|| verify(frame)));
    group.bench_with_input(BenchmarkId::new("byte sum", frame.len()), frame, |b, frame| b.iter(|| byte_sum(frame)));
    group.bench_with_input(BenchmarkId::new("fletcher 1.0.0", frame.len()), frame, |b, frame| {
        b.iter(|| fletcher::calc_fletcher16(frame) == 0);
    });
    group.bench_with_input(BenchmarkId::new("C listing", frame.len()), frame, |b, frame| b.iter(|| listing(frame) == 0));
    group.finish();
}
