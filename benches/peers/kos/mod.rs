//! Parsers of kOS with other libraries: the four messages of the mixes, each parser as its documentation recommends.
//!
//! All parsers check the version and the type of a message, the counts of its lists, and the number and length of each
//! block of a move. Parsers that make values make those of [`message`]. zerocopy lends its own from the stream.

pub(crate) mod binrw;
pub(crate) mod deku;
mod message;
pub(crate) mod nom;
pub(crate) mod winnow;
pub(crate) mod zerocopy;

use benches::decode::{LIMIT, Read, Use, ours, read, touch};
use benches::traffic::Side;
use kos_proto::Kos;

const VERSION: u8 = 4;
const RESPONSE: u8 = 2;
const MOTOR_INFO: u16 = 0x000B;
const TRAJECTORY_DATA: u16 = 0x0012;
const NOTIFICATION: u16 = 0x0081;
const PLAYBACK_STATUS: u8 = 0x02;
const MOTOR_POSITION: u8 = 0x07;

benches::readers!("kos-proto", Kos);

#[inline]
fn limit(stream: &[u8], _: Side) -> Option<(u32, &[u8])> {
    touch(stream, usize::from(u16::from_be_bytes([*stream.get(1)?, *stream.get(2)?])))
}

/// Splits a frame from the start, for parsers that read a message from its own bytes. Returns it and the rest.
fn split(stream: &[u8]) -> Option<(&[u8], &[u8])> {
    let [_, high, low, ..] = stream else { return None };
    stream.split_at_checked(u16::from_be_bytes([*high, *low]).into())
}
