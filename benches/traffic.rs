//! Traffic for the benches of streams: mixes of messages in random order, which are the same in each run.
//!
//! A mix is the traffic that a tap on the line sees: both directions in one stream, each message with its sender. A
//! reader decodes each message as a message of that side and adds up its fields, so that all fields count. The correct
//! result is known from the values that were encoded.

mod dmc;
mod hoot;
mod kos;

use motion_core::stream::Framing;
use motion_core::wire::{self, EncodeError, FieldView, Value};

use crate::decode::{Fields, Use};

pub use dmc::dmc;
pub use hoot::{hoot, through_query};
pub use kos::kos;

/// Side that sent a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Side that controls.
    Host,
    /// Side that moves.
    Device,
}

/// Protocol whose messages can be decoded and added up.
pub trait Protocol: Framing + 'static {
    /// Sum of all fields of a message, modulo 2^32.
    fn sum<U: Use>(side: Side, frame: &Self::Frame<'_>) -> u32;
}

/// Result of reading a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Number of messages.
    pub messages: usize,
    /// Sums of the messages, combined so that their order counts.
    pub value: u32,
}

impl Tally {
    /// Adds a message by the sum of its fields.
    #[inline]
    pub fn add(&mut self, sum: u32) {
        self.messages += 1;
        self.value = self.value.rotate_left(1) ^ sum;
    }
}

/// Mix of messages in one stream.
#[derive(Clone, Debug, Default)]
pub struct Mix {
    /// Frames of the messages, one after the other.
    pub bytes: Vec<u8>,
    /// Side that sent each message.
    pub sides: Vec<Side>,
    /// Result that a reader must find.
    pub tally: Tally,
}

impl Mix {
    /// Reader of the messages, from the first one on.
    #[must_use]
    pub fn reader(&self) -> Reader<'_> {
        Reader { sides: self.sides.iter(), tally: Tally::default() }
    }

    /// Adds a message at the end. `extra` is a number that a reader adds to the fields.
    fn put(
        &mut self,
        side: Side,
        message: &impl wire::Fields,
        extra: u32,
        encode: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
    ) {
        let mut frame = [0; 4096];
        let len = encode(&mut frame).expect("the message can be encoded");
        self.bytes.extend(&frame[..len]);
        self.sides.push(side);
        self.tally.add(sum_of(message).wrapping_add(extra));
    }
}

/// Decoder of the frames of a stream, with the tally.
#[derive(Clone, Debug)]
pub struct Reader<'a> {
    sides: std::slice::Iter<'a, Side>,
    /// Tally of the messages so far.
    pub tally: Tally,
}

impl Reader<'_> {
    /// Decodes the next frame. If there are more frames than in the mix, they count as frames of the host.
    #[inline]
    pub fn frame<F: Protocol>(&mut self, frame: &F::Frame<'_>) {
        let side = self.sides.next().copied().unwrap_or(Side::Host);
        self.tally.add(F::sum::<Fields>(side, frame));
    }
}

/// Sum of all fields, calculated slowly and without a decoder.
fn sum_of(message: &dyn wire::Fields) -> u32 {
    let mut sum = 0_u32;
    message.fields(&mut |field: &FieldView<'_>| sum = sum.wrapping_add(raw(field.value)));
    sum
}

fn raw(value: Value<'_>) -> u32 {
    let low = |wide: u64| u32::try_from(wide & 0xFFFF_FFFF).expect("the value is masked to 32 bits");
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

/// Sum of numbers, modulo 2^32.
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

    /// Position as on a rig, in steps: some hundred thousand in either direction.
    fn steps(&mut self) -> i32 {
        self.next().cast_signed() >> 12
    }

    /// Number from 0 to 1.
    fn part(&mut self) -> f32 {
        f32::from_bits(0x3F80_0000 | self.next() >> 9) - 1.0
    }

    /// Numbers of the kinds of messages, each as often as its share, in random order.
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
