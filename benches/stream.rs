//! Streams decoded to typed messages: the cost of pieces, compared with peers, and the cost of the worst floods.
//!
//! Each contender decodes each message as a message of its side and adds up all fields, so all times are for the whole
//! way from bytes to values. Before the measurement, the tally of each contender must equal that of the values in the
//! mix. For floods, the frames must be those that a search from each byte in turn finds.

mod floods;
mod machines;

use std::hint::black_box;
use std::io;
use std::marker::PhantomData;

use benches::ratios::{Contender, Table, contender};
use benches::traffic::{self, Mix, Protocol, Reader, Tally};
use bytes::{Buf, Bytes, BytesMut};
use criterion::{BenchmarkId, Criterion, Throughput};
use dmc_proto::Dmc;
use hoot_proto::Hoot;
use kos_proto::Kos;
use motion_core::stream::{Frames, Framing, Head, Item, Memo};
use tokio_util::codec::Decoder;

use machines::{DmcMachine, HootMachine, KosMachine, Machine};

/// Sizes of the pieces: the whole stream, packets of a network, reads from a fast serial line and from a slow one.
const PIECES: [(&str, usize); 4] = [("whole", usize::MAX), ("1460 B", 1460), ("64 B", 64), ("1 B", 1)];

fn main() {
    let dmc = [("DMC upload mix", traffic::dmc(true)), ("DMC small mix", traffic::dmc(false))];
    let kos = [("kOS mix", traffic::kos(true)), ("kOS small mix", traffic::kos(false))];
    let hoot = [("hoot", traffic::hoot())];

    let mut table = Table::new("I1, a stream in pieces, beside frames that lie in one slice");
    for (name, mix) in &dmc {
        table.row(name, pieces::<Dmc, 4096>(mix));
    }
    for (name, mix) in &kos {
        table.row(name, pieces::<Kos, 32_768>(mix));
    }
    for (name, mix) in &hoot {
        table.row(name, pieces::<Hoot, 84>(mix));
    }

    for (piece, cut) in PIECES {
        let mut table = Table::new(&format!("I1, a stream in pieces ({piece}), beside peers"));
        for (name, mix) in &dmc {
            table.row(name, peers::<Dmc, DmcMachine, 4096>(mix, cut));
        }
        for (name, mix) in &kos {
            table.row(name, peers::<Kos, KosMachine, 32_768>(mix, cut));
        }
        for (name, mix) in &hoot {
            table.row(name, peers::<Hoot, HootMachine, 84>(mix, cut));
        }
    }

    // The upload mix is the one that costs less for each byte.
    for ((name, mix), (piece, cut)) in
        [(&dmc[0], PIECES[0]), (&dmc[0], PIECES[2]), (&dmc[0], PIECES[3]), (&dmc[1], PIECES[0])]
    {
        flood_table(&format!("I2, floods in pieces ({piece}), beside the {name}"), mix, cut);
    }

    let mut criterion = Criterion::default().configure_from_args();
    for (name, mix) in &dmc {
        group(&mut criterion, name, mix);
    }
    criterion.final_summary();
}

/// Reads a stream in pieces of `cut` bytes. Between two pieces everything is in memory, here as for the peers, because
/// pieces arrive one by one and the optimiser cannot know the next one.
fn read<F: Protocol, const N: usize>(
    frames: &mut Frames<F, N>,
    stream: &[u8],
    cut: usize,
    mut reader: Reader<'_>,
) -> Tally {
    let mut drain = |frames: &mut Frames<F, N>| {
        while let Some(item) = frames.next() {
            if let Item::Frame(frame) = item {
                reader.frame::<F>(&frame);
            }
        }
    };
    if cut == 1 {
        for &byte in stream {
            let frames = black_box(&mut *frames);
            // There is always room for one byte.
            _ = frames.push(&[byte]);
            drain(frames);
        }
    } else {
        for mut piece in stream.chunks(cut) {
            let frames = black_box(&mut *frames);
            while !piece.is_empty() {
                let taken = frames.push(piece);
                piece = &piece[taken..];
                drain(frames);
            }
        }
    }
    reader.tally
}

/// Reads frames in one slice, without a buffer and without errors.
fn read_slice<F: Protocol>(mut stream: &[u8], mut reader: Reader<'_>) -> Tally {
    while !stream.is_empty() {
        let Head::Total(len) = F::head(stream) else { break };
        let (frame, rest) = stream.split_at(len);
        if let Some(frame) = F::frame(frame).filter(|_| F::Memo::<0>::is_sound(frame)) {
            reader.frame::<F>(&frame);
        }
        stream = rest;
    }
    reader.tally
}

/// Contender that calls [`read`] with its own buffer.
fn ours<'a, F: Protocol, const N: usize>(name: &'static str, mix: &'a Mix, cut: usize) -> Contender<'a> {
    let mut frames = Box::new(Frames::<F, N>::new());
    checked(name, mix, move |mix| read(&mut frames, &mix.bytes, cut, mix.reader()))
}

/// Contender whose tally was checked.
fn checked<'a>(name: &'static str, mix: &'a Mix, mut work: impl FnMut(&Mix) -> Tally + 'a) -> Contender<'a> {
    assert_eq!(work(mix), mix.tally, "{name}");
    contender(name, move || work(black_box(mix)))
}

fn pieces<F: Protocol, const N: usize>(mix: &Mix) -> Vec<Contender<'_>> {
    let mut contenders = vec![checked("one slice", mix, |mix| read_slice::<F>(&mix.bytes, mix.reader()))];
    contenders.extend(PIECES.map(|(name, cut)| ours::<F, N>(name, mix, cut)));
    contenders
}

/// Contenders for a mix in pieces. The byte machine is only one of them if a piece is a single byte.
fn peers<F: Protocol, M: Machine, const N: usize>(mix: &Mix, cut: usize) -> Vec<Contender<'_>> {
    let mut buffer = BytesMut::new();
    let codec = move |mix: &Mix| read_codec::<F>(&mut buffer, &mix.bytes, cut, mix.reader());
    let mut contenders = vec![ours::<F, N>("motion-core", mix, cut), checked("BytesMut codec", mix, codec)];
    if cut == 1 {
        let mut machine = Box::<M>::default();
        let machine = move |mix: &Mix| read_bytes::<F>(&mut *machine, &mix.bytes, mix.reader());
        contenders.push(checked("byte machine", mix, machine));
    }
    contenders
}

fn read_bytes<F: Protocol>(machine: &mut impl Machine, stream: &[u8], mut reader: Reader<'_>) -> Tally {
    for &byte in stream {
        let machine = black_box(&mut *machine);
        if let Some(frame) = machine.byte(byte).and_then(F::frame) {
            reader.frame::<F>(&frame);
        }
    }
    reader.tally
}

/// Reader as users of `tokio_util` write it: a codec over `BytesMut` that splits off frames.
fn read_codec<F: Protocol>(buffer: &mut BytesMut, stream: &[u8], cut: usize, mut reader: Reader<'_>) -> Tally {
    let mut codec = Codec(PhantomData::<F>);
    for piece in stream.chunks(cut) {
        let buffer = black_box(&mut *buffer);
        buffer.extend_from_slice(piece);
        while let Some(bytes) = codec.decode(buffer).expect("the codec has no errors") {
            if let Some(frame) = F::frame(&bytes) {
                reader.frame::<F>(&frame);
            }
        }
    }
    reader.tally
}

struct Codec<F>(PhantomData<F>);

impl<F: Framing> Decoder for Codec<F> {
    type Item = Bytes;
    type Error = io::Error;

    #[inline]
    fn decode(&mut self, src: &mut BytesMut) -> io::Result<Option<Bytes>> {
        while !src.is_empty() {
            match F::head(src) {
                Head::Total(len) if len <= src.len() => {
                    if F::Memo::<0>::is_sound(&src[..len]) {
                        return Ok(Some(src.split_to(len).freeze()));
                    }
                    src.advance(1);
                }
                Head::Total(len) | Head::More(len) => {
                    src.reserve(len - src.len());
                    return Ok(None);
                }
                Head::Skip(len, _) => src.advance(len.min(src.len())),
                Head::Fatal(why) => return Err(io::Error::new(io::ErrorKind::InvalidData, why)),
            }
        }
        Ok(None)
    }
}

/// Prints a row for each flood: a mix, and the flood through streams of three limits, with the same number of bytes.
fn flood_table(title: &str, mix: &Mix, cut: usize) {
    let len = mix.bytes.len();
    let mut table = Table::new(title);
    let clean = || ours::<Dmc, 4096>("clean, limit 2048", mix, cut);
    let small = floods::floods(1048, len).map(|(name, flood)| (name, flooded::<1048, 2096>("limit 1048", flood, cut)));
    let usual = floods::floods(2048, len).map(|(_, flood)| flooded::<2048, 4096>("limit 2048", flood, cut));
    let full = floods::floods(65_547, len).map(|(_, flood)| flooded::<65_547, 131_094>("limit 65547", flood, cut));
    for (((name, small), usual), full) in small.into_iter().zip(usual).zip(full) {
        table.row(name, vec![clean(), small, usual, full]);
    }
}

fn flooded<const CAP: usize, const N: usize>(name: &'static str, flood: Vec<u8>, cut: usize) -> Contender<'static> {
    let mut frames = Box::new(Frames::<Dmc<CAP>, N>::new());
    assert_eq!(floods::found(&mut frames, &flood, cut), floods::rescan(&flood, CAP), "{name}");
    contender(name, move || read(&mut frames, black_box(&flood), cut, Mix::default().reader()))
}

fn group(criterion: &mut Criterion, name: &str, mix: &Mix) {
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Bytes(mix.bytes.len() as u64));
    let mut frames = Box::new(Frames::<Dmc, 4096>::new());
    for (piece, cut) in PIECES {
        group.bench_with_input(BenchmarkId::new("motion-core", piece), mix, |bencher, mix| {
            bencher.iter(|| read(&mut frames, black_box(&mix.bytes), cut, mix.reader()));
        });
    }
    group.finish();
}
