//! Parser with binrw: its derive macros, lists as vectors, and no list of errors, which would take longer.

use std::io::Cursor;

use benches::decode::Use;
use benches::traffic::Side;
use binrw::BinRead;

use super::message::Message;
use super::split;

#[derive(BinRead)]
#[expect(dead_code, reason = "read to reach the body")]
#[br(big, magic = 4_u8)]
struct Frame {
    len: u16,
    id: u16,
    kind: u8,
    #[br(args(id, kind))]
    body: Message,
}

#[inline]
pub(crate) fn read<U: Use>(stream: &[u8], _: Side) -> Option<(u32, &[u8])> {
    let (bytes, rest) = split(stream)?;
    let frame = Frame::read(&mut Cursor::new(bytes)).ok()?;
    Some((U::kept(frame.body).sum(), rest))
}
