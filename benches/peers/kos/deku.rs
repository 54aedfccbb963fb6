//! Parser with deku: its derive macros, and lists as vectors.

use benches::decode::Use;
use benches::traffic::Side;
use deku::prelude::*;

use super::message::Message;
use super::{NOTIFICATION, split};

#[derive(DekuRead)]
#[expect(dead_code, reason = "read to reach the body")]
#[deku(endian = "big", magic = b"\x04")]
struct Frame {
    len: u16,
    id: u16,
    kind: u8,
    #[deku(cond = "*id == NOTIFICATION")]
    note: Option<u8>,
    #[deku(ctx = "*id, *kind, *note")]
    body: Message,
}

#[inline]
pub(crate) fn read<U: Use>(stream: &[u8], _: Side) -> Option<(u32, &[u8])> {
    let (bytes, rest) = split(stream)?;
    let (_, frame) = Frame::from_bytes((bytes, 0)).ok()?;
    Some((U::kept(frame.body).sum(), rest))
}
