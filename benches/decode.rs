//! D1 to D3: frames that lie in one slice, to typed messages whose fields are all added up.
//!
//! A bench names its contenders; how a stream is walked, how the limit is measured, and that all find the same values is
//! said here, once for the three protocols.

use std::hint::black_box;

use crate::ratios::{Contender, Table, contender};
use crate::traffic::{Mix, Side, Tally};

/// Reads a stream: each frame, and who sent it, to the sum of its fields.
pub type Read = fn(&Mix) -> Tally;

/// The contender that only walks from length to length, and adds all bytes.
pub const LIMIT: &str = "walk and touch";

/// With the arguments `count CONTENDER MIX TIMES`, reads the mix so many times with one contender, and does nothing else.
/// The difference of two runs under `valgrind --tool=callgrind` is the number of instructions. Whether it was asked for.
///
/// # Panics
///
/// If there is no such contender, mix, or number.
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

/// All contenders beside each other, after each has found what is in the mix; that of the limit only walks it.
///
/// # Panics
///
/// If one has not.
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

/// Goes from frame to frame, as each contender reads one: the sum of its fields, and the bytes behind it.
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

/// The limit, for a frame of that length: all its bytes, as numbers of 64 bits.
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
