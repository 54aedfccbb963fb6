//! Absolute throughput of our crates, by criterion.
//!
//! The times hold for one machine and one moment. The bench `ratios` compares with peers.

use std::hint::black_box;

use benches::traffic::{self, Mix, Protocol};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput};
use dmc_proto::Dmc;
use hoot_proto::Hoot;
use kos_proto::Kos;
use motion_core::bezier::{Cursor, Point, Segment};
use motion_core::fletcher::verify;
use motion_core::stream::{Frames, Item};

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    stream::<Dmc, 4096>(&mut criterion, "DMC upload mix", &traffic::dmc(true));
    stream::<Dmc, 4096>(&mut criterion, "DMC small mix", &traffic::dmc(false));
    stream::<Kos, 32_768>(&mut criterion, "kOS mix", &traffic::kos(true));
    stream::<Kos, 32_768>(&mut criterion, "kOS small mix", &traffic::kos(false));
    stream::<Hoot, 84>(&mut criterion, "hoot", &traffic::hoot());
    fletcher(&mut criterion.benchmark_group("fletcher16"));
    curves(&mut criterion.benchmark_group("curves"));
    criterion.final_summary();
}

/// Streams in pieces, decoded to typed messages, whose fields are all added up.
fn stream<F: Protocol, const N: usize>(criterion: &mut Criterion, name: &str, mix: &Mix) {
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Bytes(mix.bytes.len() as u64));
    let mut frames = Box::new(Frames::<F, N>::new());
    for (piece, cut) in [("64 KiB", 65_536), ("1460 B", 1460), ("64 B", 64), ("1 B", 1)] {
        group.bench_function(piece, |bencher| {
            bencher.iter(|| {
                let mut reader = mix.reader();
                for mut piece in black_box(&mix.bytes).chunks(cut) {
                    let frames = black_box(&mut *frames);
                    while let Some(item) = frames.next_from(&mut piece) {
                        if let Item::Frame(frame) = item {
                            reader.frame::<F>(&frame);
                        }
                    }
                }
                reader.tally
            });
        });
    }
}

/// Verification of DMC frames of the usual lengths.
fn fletcher(group: &mut BenchmarkGroup<'_, WallTime>) {
    for len in [12, 19, 80, 1048] {
        group.throughput(Throughput::Bytes(len as u64));
        let frame = vec![0; len];
        group.bench_function(format!("{len} B"), |bencher| bencher.iter(|| verify(black_box(&frame))));
    }
}

/// Positions of an axis at 1 kHz for a second.
fn curves(group: &mut BenchmarkGroup<'_, WallTime>) {
    let points = [Point::ZERO, Point::new(0.3, 0.2), Point::new(0.6, 0.9), Point::new(1.0, 1.0)];
    let segment = Segment::new(points).expect("finite");
    let times: Vec<f64> = (1..=992_u32).map(|i| f64::from(i) / 993.0).collect();
    group.throughput(Throughput::Elements(992));
    group.bench_function("batches", |bencher| {
        let mut out = [0.0; 16];
        bencher.iter(|| {
            let mut cursor = Cursor::new(segment);
            for batch in black_box(&times).chunks(16) {
                cursor.sample(batch, &mut out);
                black_box(&out);
            }
        });
    });
    group.bench_function("single positions", |bencher| {
        bencher.iter(|| black_box(&times).iter().map(|&time| segment.position(time)).sum::<f64>());
    });
}
