//! D1 to D3: frames in one slice are decoded to typed messages, whose fields are all added up.
//!
//! Each bench names its contenders. The walk through the stream, the measurement of the limit and the check of all
//! values are here, once for the three protocols.

use std::hint::black_box;

use crate::ratios::{Contender, Table, contender};
use crate::traffic::{Mix, Side, Tally};

/// Function that reads each frame of a stream, with its side, and adds up the fields.
pub type Read = fn(&Mix) -> Tally;

/// Name of the contender that only walks from length to length and adds up all bytes.
pub const LIMIT: &str = "walk and touch";

/// Handles the arguments `count CONTENDER MIX TIMES`: reads the mix that many times with one contender, and does
/// nothing else. The difference of two runs under `valgrind --tool=callgrind` is the number of instructions. Returns
/// whether the arguments were given.
///
/// # Panics
///
/// If the contender or the mix does not exist, or if the number of times is not a number.
#[must_use]
pub fn counts(readers: &[(&'static str, Read)], mixes: &[(&str, Mix)]) -> bool {
    let args: Vec<_> = std::env::args().skip_while(|arg| arg != "count").collect();
    let [_, reader, mix, times] = &args[..] else { return false };
    let (_, read) = readers.iter().find(|(name, _)| name == reader).expect("a contender");
    let (_, mix) = mixes.iter().find(|(name, _)| name == mix).expect("a mix");
    for _ in 0..times.parse().expect("a number of times") {
        black_box(read(black_box(mix)));
    }
    true
}

/// Prints the table of all contenders. Each must first find all values of the mix; the limit only counts its messages.
///
/// # Panics
///
/// If a contender finds other values.
pub fn table(title: &'static str, readers: &[(&'static str, Read)], mixes: &[(&'static str, Mix)]) {
    let mut table = Table::new(title);
    for (name, mix) in mixes {
        table.row(name, readers.iter().map(|&(name, read)| reader(name, read, mix)).collect());
    }
}

fn reader<'a>(name: &'static str, read: Read, mix: &'a Mix) -> Contender<'a> {
    if name == LIMIT {
        assert_eq!(read(mix).messages, mix.tally.messages);
    } else {
        assert_eq!(read(mix), mix.tally, "{name}");
    }
    contender(name, move || read(black_box(mix)))
}

/// Walks from frame to frame. `frame` is the contender, and returns the sum of the fields of one frame and the bytes
/// after the frame.
#[inline]
pub fn read<'a>(mix: &'a Mix, frame: impl Fn(&'a [u8], Side) -> Option<(u32, &'a [u8])>) -> Tally {
    let (mut tally, mut stream) = (Tally::default(), &mix.bytes[..]);
    for &side in &mix.sides {
        let Some((sum, rest)) = frame(stream, side) else { break };
        tally.messages += 1;
        tally.value = tally.value.rotate_left(1) ^ sum;
        stream = rest;
    }
    tally
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
