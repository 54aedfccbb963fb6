//! Streams to typed messages: what pieces cost, beside peers, and what the worst floods cost.
//!
//! Every contender decodes each message as its side's and adds up all fields, so all times are those of the whole way
//! from bytes to values. Each is first asked for its tally, which must be that of the values that went into the mix; of
//! floods, the frames must be those that a search from each byte in turn finds.

use std::hint::black_box;
use std::io;

use benches::ratios::{Contender, Table, contender};
use benches::traffic::{self, Mix, Protocol, Reader, Tally};
use bytes::{Buf, Bytes, BytesMut};
use criterion::{BenchmarkId, Criterion, Throughput};
use dmc_proto::{Dmc, MessageId, MessageType};
use hoot_proto::Hoot;
use kos_proto::Kos;
use motion_core::fletcher;
use motion_core::stream::{Frames, Framing, Head, Item, Memo};
use tokio_util::codec::Decoder;

/// A network's packets, a fast serial line's reads, a slow one's.
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

    for (name, mix) in &dmc {
        for (piece, cut) in [PIECES[0], PIECES[2], PIECES[3]] {
            floods(&format!("I2, floods in pieces ({piece}), beside the {name}"), mix, cut);
        }
    }

    let mut criterion = Criterion::default().configure_from_args();
    for (name, mix) in &dmc {
        group(&mut criterion, name, mix);
    }
    criterion.final_summary();
}

/// Reads a stream in pieces of `cut` bytes.
fn read<F: Protocol, const N: usize>(
    frames: &mut Frames<F, N>,
    stream: &[u8],
    cut: usize,
    mut reader: Reader<'_>,
) -> Tally {
    for mut piece in stream.chunks(cut) {
        while !piece.is_empty() {
            let taken = frames.push(piece);
            piece = &piece[taken..];
            while let Some(item) = frames.next() {
                if let Item::Frame(frame) = item {
                    reader.frame::<F>(&frame);
                }
            }
        }
    }
    reader.tally
}

/// Reads frames that lie in one slice: nothing to buffer, and nothing that could go wrong.
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

/// [`read`] of a mix, with a buffer of its own.
fn ours<'a, F: Protocol, const N: usize>(name: &'static str, mix: &'a Mix, cut: usize) -> Contender<'a> {
    let mut frames = Box::new(Frames::<F, N>::new());
    checked(name, mix, move |mix| read(&mut frames, &mix.bytes, cut, mix.reader()))
}

/// A contender that finds what is in the mix.
fn checked<'a>(name: &'static str, mix: &'a Mix, mut work: impl FnMut(&Mix) -> Tally + 'a) -> Contender<'a> {
    assert_eq!(work(mix), mix.tally, "{name}");
    contender(name, move || work(black_box(mix)))
}

fn pieces<F: Protocol, const N: usize>(mix: &Mix) -> Vec<Contender<'_>> {
    let mut contenders = vec![checked("one slice", mix, |mix| read_slice::<F>(&mix.bytes, mix.reader()))];
    contenders.extend(PIECES.map(|(name, cut)| ours::<F, N>(name, mix, cut)));
    contenders
}

fn peers<F: Protocol, M: Machine, const N: usize>(mix: &Mix, cut: usize) -> Vec<Contender<'_>> {
    let mut machine = Box::<M>::default();
    let mut buffer = BytesMut::new();
    vec![
        ours::<F, N>("motion-core", mix, cut),
        checked("byte machine", mix, move |mix| read_bytes::<F>(&mut *machine, &mix.bytes, mix.reader())),
        checked("BytesMut codec", mix, move |mix| read_codec::<F>(&mut buffer, &mix.bytes, cut, mix.reader())),
    ]
}

/// A parser as it stands in many a firmware: takes a byte, and now and then has a whole frame.
trait Machine: Default + 'static {
    fn byte(&mut self, byte: u8) -> Option<&[u8]>;
}

fn read_bytes<F: Protocol>(machine: &mut impl Machine, stream: &[u8], mut reader: Reader<'_>) -> Tally {
    for &byte in stream {
        if let Some(frame) = machine.byte(byte).and_then(F::frame) {
            reader.frame::<F>(&frame);
        }
    }
    reader.tally
}

/// Sums as it goes, with the modulo left to the end of the frame. It does less than the others: after a wrong checksum it
/// does not search again.
struct DmcMachine {
    buf: [u8; 2048],
    len: usize,
    total: usize,
    sums: [u32; 2],
}

impl Default for DmcMachine {
    fn default() -> Self {
        let mut buf = [0; 2048];
        buf[..2].copy_from_slice(b"DF");
        Self { buf, len: 0, total: 12, sums: [0; 2] }
    }
}

impl Machine for DmcMachine {
    #[inline]
    fn byte(&mut self, byte: u8) -> Option<&[u8]> {
        const D: u32 = b'D' as u32;
        const F: u32 = b'F' as u32;
        match (self.len, byte) {
            (0 | 1, b'D') => self.len = 1,
            (1, b'F') => (self.len, self.sums) = (2, [D + F, 2 * D + F]),
            (0 | 1, _) => self.len = 0,
            _ => {
                self.buf[self.len] = byte;
                self.len += 1;
                self.sums[0] += u32::from(byte);
                self.sums[1] += self.sums[0];
                if self.len == 10 {
                    self.total = 12 + usize::from(u16::from_le_bytes([self.buf[8], byte]));
                    if self.total > self.buf.len() {
                        self.len = 0;
                    }
                } else if self.len == self.total {
                    self.len = 0;
                    return (self.sums.map(|sum| sum % 255) == [0, 0]).then(|| &self.buf[..self.total]);
                }
            }
        }
        None
    }
}

struct KosMachine {
    buf: [u8; 16_384],
    len: usize,
    total: usize,
}

impl Default for KosMachine {
    fn default() -> Self {
        Self { buf: [0; 16_384], len: 0, total: 6 }
    }
}

impl Machine for KosMachine {
    #[inline]
    fn byte(&mut self, byte: u8) -> Option<&[u8]> {
        self.buf[self.len] = byte;
        self.len += 1;
        match self.len {
            1 if byte != 4 => self.len = 0,
            3 => {
                self.total = usize::from(u16::from_be_bytes([self.buf[1], byte]));
                if !(6..=self.buf.len()).contains(&self.total) {
                    self.len = 0;
                }
            }
            len if len >= 6 && len == self.total => {
                self.len = 0;
                return Some(&self.buf[..len]);
            }
            _ => {}
        }
        None
    }
}

struct HootMachine {
    buf: [u8; 42],
    len: usize,
    total: usize,
}

impl Default for HootMachine {
    fn default() -> Self {
        Self { buf: [0; 42], len: 0, total: 10 }
    }
}

impl Machine for HootMachine {
    #[inline]
    fn byte(&mut self, byte: u8) -> Option<&[u8]> {
        self.buf[self.len] = byte;
        match (self.len, byte) {
            (0..5, 0) | (5, 0xFF) | (6..9 | 10.., _) => self.len += 1,
            // Of more than five zeros, the last five count.
            (5, 0) => {}
            (9, _) => (self.len, self.total) = (10, 10 + usize::from(byte)),
            _ => self.len = 0,
        }
        if self.total > self.buf.len() {
            (self.len, self.total) = (0, 10);
        }
        if self.len == self.total {
            self.len = 0;
            return Some(&self.buf[..self.total]);
        }
        None
    }
}

/// What `tokio_util` users write: a codec over `BytesMut` that splits frames off.
fn read_codec<F: Protocol>(buffer: &mut BytesMut, stream: &[u8], cut: usize, mut reader: Reader<'_>) -> Tally {
    let mut codec = Codec(std::marker::PhantomData::<F>);
    for piece in stream.chunks(cut) {
        buffer.extend_from_slice(piece);
        while let Some(bytes) = codec.decode(buffer).expect("nothing fatal") {
            if let Some(frame) = F::frame(&bytes) {
                reader.frame::<F>(&frame);
            }
        }
    }
    reader.tally
}

struct Codec<F>(std::marker::PhantomData<F>);

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

/// A row for each flood: a mix, and the flood through streams of three limits, as many bytes of each.
fn floods(title: &str, mix: &Mix, cut: usize) {
    let len = mix.bytes.len();
    let mut table = Table::new(title);
    let clean = || ours::<Dmc, 4096>("clean, limit 2048", mix, cut);
    let small = floods_of(1048, len).map(|(name, flood)| (name, flooded::<1048, 2096>("limit 1048", flood, cut)));
    let usual = floods_of(2048, len).map(|(_, flood)| flooded::<2048, 4096>("limit 2048", flood, cut));
    let full = floods_of(65_547, len).map(|(_, flood)| flooded::<65_547, 131_094>("limit 65547", flood, cut));
    for (((name, small), usual), full) in small.into_iter().zip(usual).zip(full) {
        table.row(name, vec![clean(), small, usual, full]);
    }
}

fn flooded<const CAP: usize, const N: usize>(name: &'static str, flood: Vec<u8>, cut: usize) -> Contender<'static> {
    let mut frames = Box::new(Frames::<Dmc<CAP>, N>::new());
    assert_eq!(found(&mut frames, &flood, cut), rescan(&flood, CAP), "{name}");
    contender(name, move || read(&mut frames, black_box(&flood), cut, Mix::default().reader()))
}

/// Where the frames lie, and how long they are.
fn found<const CAP: usize, const N: usize>(
    frames: &mut Frames<Dmc<CAP>, N>,
    stream: &[u8],
    cut: usize,
) -> Vec<(usize, usize)> {
    let (mut at, mut found) = (0, Vec::new());
    for mut piece in stream.chunks(cut) {
        let last = piece.as_ptr_range().end == stream.as_ptr_range().end;
        while !piece.is_empty() {
            let taken = frames.push(piece);
            piece = &piece[taken..];
            if last && piece.is_empty() {
                frames.gap();
            }
            while let Some(item) = frames.next() {
                let len = item.bytes().len();
                if matches!(item, Item::Frame(_)) {
                    found.push((at, len));
                }
                at += len;
            }
        }
    }
    assert_eq!(at, stream.len(), "every byte is part of an item");
    found
}

/// The same by a search from each byte in turn.
fn rescan(stream: &[u8], cap: usize) -> Vec<(usize, usize)> {
    let (mut at, mut found) = (0, Vec::new());
    while let Some(rest) = stream.get(at..).filter(|rest| rest.len() >= 12) {
        let len = 12 + usize::from(u16::from_le_bytes([rest[8], rest[9]]));
        let frame = rest.get(..len).filter(|_| len <= cap && rest.starts_with(b"DF"));
        let sound = frame.is_some_and(fletcher::verify);
        found.extend(sound.then_some((at, len)));
        at += if sound { len } else { 1 };
    }
    found
}

/// Streams made to be dear where frames may have `cap` bytes, `len` bytes of each.
fn floods_of(cap: usize, len: usize) -> [(&'static str, Vec<u8>); 14] {
    let longest = cap - 12;
    let good = frame(&[0; 7]);
    let lie = |data_len| [b"DF\x01\0\0\0\x36\0".to_vec(), le(data_len)].concat();
    // A marker every five bytes: each reads its length out of the next but one.
    let dense = |data_len| [b"DF\x09".to_vec(), le(data_len)].concat();
    let varied = (0..=255).flat_map(|byte| [b'D', b'F', byte]).collect();
    let mut corrupt = good.clone();
    corrupt[12] ^= 1;
    [
        ("longest", lie(longest)),
        ("half as long", lie(longest / 2 + 7)),
        ("empty", lie(0)),
        ("dense longest", dense(longest)),
        ("dense short", dense(8)),
        ("dense empty", dense(0)),
        ("dense mixed", [dense(8).repeat(cap / 10), dense(longest).repeat(cap / 10)].concat()),
        ("good in a lie", [lie(longest), good.repeat(cap / good.len())].concat()),
        ("good, corrupt", [good, corrupt, vec![0]].concat()),
        ("DF", b"DF".to_vec()),
        ("DF varied", varied),
        ("D", b"D".to_vec()),
        ("D every 2nd", b"D\0".to_vec()),
        ("zeros", vec![0]),
    ]
    .map(|(name, unit)| (name, unit.iter().copied().cycle().take(len).collect()))
}

fn le(len: usize) -> Vec<u8> {
    u16::try_from(len).expect("a length on the wire").to_le_bytes().to_vec()
}

/// A sound frame: a jog.
fn frame(data: &[u8]) -> Vec<u8> {
    let mut out = vec![0; data.len() + 12];
    let len = dmc_proto::frame::encode(MessageId(1), MessageType(0x36), data, &mut out);
    assert_eq!(len, Ok(out.len()));
    out
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
