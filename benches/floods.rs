//! I2: DMC streams that are made to be expensive, beside a stream of valid frames.
//!
//! The frames in them must be those that a search from each byte in turn finds. The work is the number of bytes looked
//! at for each byte in, counted by the stream itself. Work and time for each byte must not grow with the input.

use std::hint::black_box;

use benches::ratios::{Contender, contender};
use benches::report::Report;
use benches::traffic::{self, Mix, Tally};
use dmc_proto::{Dmc, MessageId, MessageType};
use motion_core::fletcher;
use motion_core::stream::{Frames, Framing as _, Item};

use crate::stream::{Read, read_lent, read_pushed};

const PIECES: [(&str, usize); 3] =
    [("floods, pieces of 64 KiB", 65_536), ("floods, pieces of 64 B", 64), ("floods, pieces of 1 B", 1)];

/// Bytes of a flood, and the tally of the frames in it.
struct Flood {
    name: &'static str,
    bytes: Vec<u8>,
    tally: Tally,
}

pub(crate) fn chapter(report: &mut Report) {
    // The upload mix costs less for each byte than the small one, so it is the stricter measure.
    let mix = traffic::dmc(true);
    let len = mix.bytes.len();

    let mut table = report.table("floods, work for each byte");
    for (name, unit) in units(2048) {
        for (_, cut) in PIECES {
            table.numbers(&format!("{name}, next_from, {cut} B"), &works(read_lent::<Dmc, 4096>, &unit, len, cut));
            table.numbers(&format!("{name}, push, {cut} B"), &works(read_pushed::<Dmc, 4096>, &unit, len, cut));
        }
    }
    let [once, twice, four] = [1, 2, 4].map(|times| floods(2048, len * times));
    let mut table = report.table("floods, longer and longer");
    for ((once, twice), four) in once.iter().zip(&twice).zip(&four) {
        let lengths = [("n", once), ("2 n", twice), ("4 n", four)];
        table.row(once.name, lengths.map(|(name, flood)| flooded(name, read_lent::<Dmc, 4096>, flood, 65_536)).into());
    }
    let (short, full) = (floods(1048, len), floods(65_547, len));
    for (piece, cut) in PIECES {
        let mut table = report.table(piece);
        for ((short, once), full) in short.iter().zip(&once).zip(&full) {
            let contenders = vec![
                clean(&mix, cut),
                flooded("limit 2048", read_lent::<Dmc, 4096>, once, cut),
                flooded("limit 2048, push", read_pushed::<Dmc, 4096>, once, cut),
                flooded("limit 1048", read_lent::<Dmc<1048>, 2096>, short, cut),
                flooded("limit 65547", read_lent::<Dmc<65_547>, 131_094>, full, cut),
            ];
            table.row(once.name, contenders);
        }
    }
}

/// Work for each byte of a flood of `len` bytes, and of one twice and four times as long.
fn works<const N: usize>(read: Read<Dmc, N>, unit: &[u8], len: usize, cut: usize) -> [(&'static str, f64); 3] {
    [("n", len), ("2 n", 2 * len), ("4 n", 4 * len)].map(|(name, len)| {
        let mut frames = Box::new(Frames::new());
        read(&mut frames, &cycle(unit, len), cut, Mix::default().reader());
        let [work, len] = [frames.work(), len].map(|number| f64::from(u32::try_from(number).expect("32 bits")));
        (name, work / len)
    })
}

/// Contender that reads valid frames.
fn clean(mix: &Mix, cut: usize) -> Contender<'_> {
    let mut frames = Box::new(Frames::<Dmc, 4096>::new());
    contender("clean", move || read_pushed(&mut frames, black_box(&mix.bytes), cut, mix.reader())).per(mix.bytes.len())
}

/// Contender that finds all frames of a flood.
fn flooded<'a, const CAP: usize, const N: usize>(
    name: &'static str,
    read: Read<Dmc<CAP>, N>,
    flood: &'a Flood,
    cut: usize,
) -> Contender<'a> {
    let mut frames = Box::new(Frames::new());
    let mix = Mix::default();
    let mut reader = mix.reader();
    reader.tally = read(&mut frames, &flood.bytes, cut, mix.reader());
    frames.gap();
    while let Some(item) = frames.next() {
        if let Item::Frame(frame) = item {
            reader.frame::<Dmc<CAP>>(&frame);
        }
    }
    assert_eq!(reader.tally, flood.tally, "{name}, {}", flood.name);
    let work = move || read(&mut frames, black_box(&flood.bytes), cut, Mix::default().reader());
    contender(name, work).per(flood.bytes.len())
}

/// Expensive streams of `len` bytes each, for frames of up to `cap` bytes.
fn floods(cap: usize, len: usize) -> [Flood; 16] {
    units(cap).map(|(name, unit)| {
        let bytes = cycle(&unit, len);
        let tally = rescan(&bytes, cap);
        Flood { name, bytes, tally }
    })
}

fn cycle(unit: &[u8], len: usize) -> Vec<u8> {
    unit.iter().copied().cycle().take(len).collect()
}

/// Tally of the frames, found by a search from each byte in turn.
fn rescan(stream: &[u8], cap: usize) -> Tally {
    let (mut at, mix) = (0, Mix::default());
    let mut reader = mix.reader();
    while let Some(rest) = stream.get(at..).filter(|rest| rest.len() >= 12) {
        let len = 12 + usize::from(u16::from_le_bytes([rest[8], rest[9]]));
        let bytes = rest.get(..len).filter(|_| len <= cap && rest.starts_with(b"DF"));
        if let Some(frame) = bytes.filter(|bytes| fletcher::verify(bytes)).and_then(Dmc::<65_547>::frame) {
            reader.frame::<Dmc<65_547>>(&frame);
            at += len;
        } else {
            at += 1;
        }
    }
    reader.tally
}

/// Bytes that make an expensive stream when they are repeated, for frames of up to `cap` bytes.
fn units(cap: usize) -> [(&'static str, Vec<u8>); 16] {
    let longest = cap - 12;
    let good = frame(&[0; 7]);
    let lie = |data_len| [&b"DF\x01\0\0\0\x36\0"[..], &le(data_len)].concat();
    // A marker every five bytes. The length field of each is inside the next marker but one.
    let dense = |data_len| [&b"DF\x09"[..], &le(data_len)].concat();
    // The first sums are equal at both ends of the claimed frames, so that the second sums must decide.
    let even = |data_len| {
        let [l0, l1] = le(data_len);
        let filler = [b'D', b'F', l0, l1].iter().fold(0, |sum, &byte| (sum + u32::from(byte)) % 255);
        [b'D', b'F', 255 - filler.to_le_bytes()[0], l0, l1].to_vec()
    };
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
        ("dense even", even(longest - longest % 5 - 2)),
        ("good in a lie", [lie(longest), good.repeat(cap / good.len())].concat()),
        ("good, corrupt", [good, corrupt, vec![0]].concat()),
        ("DF", b"DF".to_vec()),
        ("DF even", b"DF\x16".to_vec()),
        ("DF varied", varied),
        ("D", b"D".to_vec()),
        ("D every 2nd", b"D\0".to_vec()),
        ("zeros", vec![0]),
    ]
}

fn le(len: usize) -> [u8; 2] {
    u16::try_from(len).expect("the length fits on the wire").to_le_bytes()
}

/// Valid frame: a jog.
fn frame(data: &[u8]) -> Vec<u8> {
    let mut out = vec![0; data.len() + 12];
    let len = dmc_proto::frame::encode(MessageId(1), MessageType(0x36), data, &mut out);
    assert_eq!(len, Ok(out.len()));
    out
}
