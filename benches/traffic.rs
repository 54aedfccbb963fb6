//! The traffic that streams are measured with: mixes of messages in random order, always the same.
//!
//! A mix is what a tap on the line sees: both directions in one stream, each message with the side that sent it. Whoever
//! reads it decodes each message as that side's and adds up its fields, so that all of them count. What must come out is
//! known from the values that went in.

mod dmc;
mod hoot;
mod kos;

use motion_core::stream::Framing;
use motion_core::wire::{EncodeError, FieldView, Fields, Value};

pub use dmc::dmc;
pub use hoot::hoot;
pub use kos::kos;

/// Who sent a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The one that controls.
    Host,
    /// The one that moves.
    Device,
}

/// A protocol whose messages can be decoded and added up.
pub trait Protocol: Framing + 'static {
    /// The sum of all fields of a message, modulo 2^32.
    fn sum(side: Side, frame: &Self::Frame<'_>) -> u32;
}

/// What became of a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Messages found.
    pub messages: usize,
    /// Their sums, entangled so that their order counts.
    pub value: u32,
}

impl Tally {
    fn add(&mut self, sum: u32) {
        self.messages += 1;
        self.value = self.value.rotate_left(1) ^ sum;
    }
}

/// Messages in one stream.
#[derive(Clone, Debug, Default)]
pub struct Mix {
    /// Their frames, one behind the other.
    pub bytes: Vec<u8>,
    /// Who sent each.
    pub sides: Vec<Side>,
    /// What a reader must find.
    pub tally: Tally,
}

impl Mix {
    /// Who reads the messages, from the first one on.
    #[must_use]
    pub fn reader(&self) -> Reader<'_> {
        Reader { sides: self.sides.iter(), tally: Tally::default() }
    }

    /// Puts a message at the end. `extra` is what a reader adds to the fields.
    fn put(
        &mut self,
        side: Side,
        message: &impl Fields,
        extra: u32,
        encode: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
    ) {
        let mut frame = [0; 4096];
        let len = encode(&mut frame).expect("a message that can be written");
        self.bytes.extend(&frame[..len]);
        self.sides.push(side);
        self.tally.add(sum_of(message).wrapping_add(extra));
    }
}

/// Decodes the frames that a stream gives, and keeps the tally.
#[derive(Clone, Debug)]
pub struct Reader<'a> {
    sides: std::slice::Iter<'a, Side>,
    /// What was found so far.
    pub tally: Tally,
}

impl Reader<'_> {
    /// Decodes the next frame. Frames beyond those of the mix count as the host's.
    #[inline]
    pub fn frame<F: Protocol>(&mut self, frame: &F::Frame<'_>) {
        let side = self.sides.next().copied().unwrap_or(Side::Host);
        self.tally.add(F::sum(side, frame));
    }
}

/// The sum of all fields, found out the slow way, without any decoder.
fn sum_of(message: &dyn Fields) -> u32 {
    let mut sum = 0_u32;
    message.fields(&mut |field: &FieldView<'_>| sum = sum.wrapping_add(raw(field.value)));
    sum
}

fn raw(value: Value<'_>) -> u32 {
    let low = |wide: u64| u32::try_from(wide & 0xFFFF_FFFF).expect("masked");
    match value {
        Value::Unsigned(number) => low(number),
        Value::Signed(number) => low(number.cast_unsigned()),
        Value::Float(number) => number.to_bits(),
        Value::Text(bytes) | Value::Secret(bytes) | Value::Bytes(bytes) => bytes.iter().copied().map(u32::from).sum(),
        Value::List(list) => {
            let mut sum = 0_u32;
            list.each(&mut |item| sum = sum.wrapping_add(raw(item)));
            sum
        }
        Value::Group(fields) => sum_of(fields),
    }
}

/// Adds up, modulo 2^32.
fn total(numbers: impl IntoIterator<Item = u32>) -> u32 {
    numbers.into_iter().fold(0, u32::wrapping_add)
}

fn count(len: usize) -> u32 {
    u32::try_from(len).unwrap_or(u32::MAX)
}

fn bytes(bytes: &[u8]) -> u32 {
    total(bytes.iter().copied().map(u32::from))
}

/// Random numbers from a fixed seed (xorshift).
struct Rng(u32);

impl Rng {
    fn next(&mut self) -> u32 {
        for shift in [13, -17, 5] {
            self.0 ^= if shift > 0 { self.0 << shift } else { self.0 >> -shift };
        }
        self.0
    }

    fn byte(&mut self) -> u8 {
        self.next().to_be_bytes()[0]
    }

    /// A position as a rig has it: some hundred thousand steps either way.
    fn steps(&mut self) -> i32 {
        self.next().cast_signed() >> 12
    }

    /// A part of a whole.
    fn part(&mut self) -> f32 {
        f32::from_bits(0x3F80_0000 | self.next() >> 9) - 1.0
    }

    /// Numbers each kind of message as often as said, in random order.
    fn shuffle<const KINDS: usize>(&mut self, shares: [usize; KINDS]) -> Vec<usize> {
        let mut kinds: Vec<usize> =
            shares.into_iter().enumerate().flat_map(|(kind, share)| std::iter::repeat_n(kind, share)).collect();
        for left in (1..=kinds.len()).rev() {
            kinds.swap(left - 1, self.next() as usize % left);
        }
        kinds
    }
}

const SEED: u32 = 0x2545_F491;
