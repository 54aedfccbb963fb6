//! Streams decoded to typed messages: the cost of pieces, compared with frames that lie in one slice and with peers.
//!
//! Each contender decodes each message as a message of its side and adds up all fields, so all times are for the whole
//! way from bytes to values. Before the measurement, the tally of each contender must equal that of the values in the
//! mix.

use std::hint::black_box;
use std::io;
use std::marker::PhantomData;

use benches::decode::{self, Fields};
use benches::ratios::{Contender, contender};
use benches::report::Report;
use benches::traffic::{self, Mix, Protocol, Reader, Tally};
use bytes::{Buf, Bytes, BytesMut};
use dmc_proto::Dmc;
use hoot_proto::Hoot;
use kos_proto::Kos;
use motion_core::stream::{Frames, Framing, Head, Item, Memo};
use tokio_util::codec::Decoder;

use crate::peers::bytes::{DmcMachine, HootMachine, KosMachine, Machine};

/// Sizes of the pieces: reads from a file or a fast socket, packets of a network, and reads from a fast serial line and
/// from a slow one.
const PIECES: [(&str, usize); 4] = [
    ("stream, pieces of 64 KiB", 65_536),
    ("stream, pieces of 1460 B", 1460),
    ("stream, pieces of 64 B", 64),
    ("stream, pieces of 1 B", 1),
];

pub(crate) fn chapter(report: &mut Report) {
    let dmc = [("DMC upload mix", traffic::dmc(true)), ("DMC small mix", traffic::dmc(false))];
    let kos = [("kOS mix", traffic::kos(true)), ("kOS small mix", traffic::kos(false))];
    let hoot = traffic::hoot();
    for (piece, cut) in PIECES {
        let mut table = report.table(piece);
        for (name, mix) in &dmc {
            table.row(name, contenders::<Dmc, DmcMachine, 4096>(mix, cut));
        }
        for (name, mix) in &kos {
            table.row(name, contenders::<Kos, KosMachine, 32_768>(mix, cut));
        }
        table.row("hoot", contenders::<Hoot, HootMachine, 84>(&hoot, cut));
    }
}

/// Contenders for a mix in pieces. The byte machine is only one of them if a piece is a single byte.
fn contenders<F: Protocol, M: Machine, const N: usize>(mix: &Mix, cut: usize) -> Vec<Contender<'_>> {
    let mut buffer = BytesMut::new();
    let codec = move |mix: &Mix| read_codec::<F>(&mut buffer, &mix.bytes, cut, mix.reader());
    let mut contenders = vec![
        slice::<F>(mix),
        stream("next_from", read_lent::<F, N>, mix, cut),
        stream("push and next", read_pushed::<F, N>, mix, cut),
        checked("tokio-util, BytesMut", mix, codec),
    ];
    if cut == 1 {
        let mut machine = Box::<M>::default();
        let machine = move |mix: &Mix| read_bytes::<F>(&mut *machine, &mix.bytes, mix.reader());
        contenders.push(checked("byte machine", mix, machine));
    }
    contenders
}

/// Contender that reads frames in one slice, without a buffer.
pub(crate) fn slice<F: Protocol>(mix: &Mix) -> Contender<'_> {
    checked("one slice", mix, |mix| decode::read(mix, decode::ours::<F, Fields>))
}

/// Contender that reads a stream.
pub(crate) fn stream<'a, F: Protocol, const N: usize>(
    name: &'static str,
    read: Read<F, N>,
    mix: &'a Mix,
    cut: usize,
) -> Contender<'a> {
    let mut frames = Box::new(Frames::new());
    checked(name, mix, move |mix| read(&mut frames, &mix.bytes, cut, mix.reader()))
}

/// Contender whose tally was checked.
fn checked<'a>(name: &'static str, mix: &'a Mix, mut work: impl FnMut(&Mix) -> Tally + 'a) -> Contender<'a> {
    assert_eq!(work(mix), mix.tally, "{name}");
    contender(name, move || work(black_box(mix))).per(mix.tally.messages)
}

/// Function that reads a stream in pieces of some bytes. Between two pieces everything is in memory, here as for the
/// peers, because pieces arrive one by one and the optimiser cannot know the next one.
pub(crate) type Read<F, const N: usize> = fn(&mut Frames<F, N>, &[u8], usize, Reader<'_>) -> Tally;

/// Reads frames that lie whole in a piece from there.
pub(crate) fn read_lent<F: Protocol, const N: usize>(
    frames: &mut Frames<F, N>,
    stream: &[u8],
    cut: usize,
    mut reader: Reader<'_>,
) -> Tally {
    for mut piece in stream.chunks(cut) {
        let frames = black_box(&mut *frames);
        while let Some(item) = frames.next_from(&mut piece) {
            if let Item::Frame(frame) = item {
                reader.frame::<F>(&frame);
            }
        }
    }
    reader.tally
}

/// Copies all bytes into the buffer of the stream.
pub(crate) fn read_pushed<F: Protocol, const N: usize>(
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
