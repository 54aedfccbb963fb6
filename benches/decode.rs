//! D1 to D3: frames in one slice are decoded to typed messages.
//!
//! Each chapter names its contenders. The walk through the stream, the use of the messages, the measurement of the limit
//! and the check of all values are here, once for the three protocols.

use std::hint::black_box;

use motion_core::stream::{Head, Memo};

use crate::ratios::{Table, contender};
use crate::traffic::{Mix, Protocol, Side, Tally};

/// Function that reads each frame of a stream, with its side.
pub type Read = fn(&Mix) -> Tally;

/// Name of the contender that only walks from length to length and adds up all bytes.
pub const LIMIT: &str = "walk and touch";

/// Use of a decoded message, before its fields are added up.
pub trait Use {
    /// Uses the message, and returns it.
    fn kept<T>(message: T) -> T;
}

/// Use of the fields alone. The optimiser may leave out what a decoder does for messages that are not in the mix.
pub enum Fields {}

/// Use of the whole message, whichever it is: it is in memory, so the optimiser leaves out nothing.
pub enum Whole {}

impl Use for Fields {
    #[inline]
    fn kept<T>(message: T) -> T {
        message
    }
}

impl Use for Whole {
    #[inline]
    fn kept<T>(message: T) -> T {
        black_box(&message);
        message
    }
}

/// Measures a row for each mix, after all contenders have found all values of the mix. The limit finds no values, and
/// counts the messages.
///
/// # Panics
///
/// If a contender finds other values.
pub fn rows(table: &mut Table<'_>, mixes: &[(&'static str, Mix)], readers: &[(&'static str, Read)]) {
    for (name, mix) in mixes {
        let reader = |&(name, read): &(&'static str, Read)| {
            let found = read(mix);
            let value = if name == LIMIT { found.value } else { mix.tally.value };
            assert_eq!(found, Tally { value, ..mix.tally }, "{name}");
            contender(name, move || read(black_box(mix))).per(mix.tally.messages)
        };
        table.row(name, readers.iter().map(reader).collect());
    }
}

/// Walks from frame to frame. `frame` is the contender, and returns the sum of the fields of one frame and the bytes
/// after the frame.
#[inline]
pub fn read<'a>(mix: &'a Mix, frame: impl Fn(&'a [u8], Side) -> Option<(u32, &'a [u8])>) -> Tally {
    let (mut tally, mut stream) = (Tally::default(), &mix.bytes[..]);
    for &side in &mix.sides {
        let Some((sum, rest)) = frame(stream, side) else { break };
        tally.add(sum);
        stream = rest;
    }
    tally
}

/// Our contender: the frame at the start is verified and decoded.
#[must_use]
#[inline]
pub fn ours<F: Protocol, U: Use>(stream: &[u8], side: Side) -> Option<(u32, &[u8])> {
    frame::<F>(stream, |frame| F::sum::<U>(side, frame))
}

/// Splits a verified frame from the start, and returns what `sum` makes of it and the bytes after it.
#[inline]
pub fn frame<'a, F: Protocol>(stream: &'a [u8], sum: impl Fn(&F::Frame<'a>) -> u32) -> Option<(u32, &'a [u8])> {
    let Head::Total(len) = F::head(stream) else { return None };
    let (bytes, rest) = stream.split_at_checked(len)?;
    let frame = F::frame(bytes).filter(|_| F::Memo::<0>::is_sound(bytes))?;
    Some((sum(&frame), rest))
}

/// The limit for a frame of length `len`: adds up all its bytes as numbers of 64 bits.
#[must_use]
#[inline]
pub fn touch(stream: &[u8], len: usize) -> Option<(u32, &[u8])> {
    let (bytes, rest) = stream.split_at_checked(len)?;
    let words = bytes.chunks_exact(8);
    let last = words.remainder().iter().fold(0, |sum: u64, &byte| sum << 8 | u64::from(byte));
    let sum = words.fold(last, |sum, word| {
        let word = word.first_chunk().map_or(0, |word| u64::from_le_bytes(*word));
        sum.wrapping_add(word)
    });
    Some(((sum >> 32) as u32 ^ (sum & 0xFFFF_FFFF) as u32, rest))
}

/// Defines `readers`, the contenders for frames in one slice: ours, the limit, and the parsers of the module around it.
#[macro_export]
macro_rules! readers {
    ($name:literal, $protocol:ty) => {
        /// Contenders for frames in one slice.
        pub(crate) fn readers<U: Use>() -> [(&'static str, Read); 7] {
            [
                ($name, |mix| read(mix, ours::<$protocol, U>)),
                (LIMIT, |mix| read(mix, limit)),
                ("zerocopy", |mix| read(mix, zerocopy::read::<U>)),
                ("nom", |mix| read(mix, nom::read::<U>)),
                ("winnow", |mix| read(mix, winnow::read::<U>)),
                ("deku", |mix| read(mix, deku::read::<U>)),
                ("binrw", |mix| read(mix, binrw::read::<U>)),
            ]
        }
    };
}
