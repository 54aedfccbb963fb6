//! D3: decoding of hoot, compared with other crates.
//!
//! Packets of 10 to 15 bytes in one slice, of both directions, are decoded to typed messages. Each contender knows the
//! four messages of the mix and their directions. The limit is to walk from length to length and to add up all bytes.
//!
//! Nothing in a reply says what it answers. The mix has one kind of query, so our first contender reads each value
//! through that query, and knows its type as all peers do. The second one reads a value by the type before it, as a
//! listener does.

use benches::decode::{self, Fields, LIMIT, Read, Use, Whole, frame, ours, read, touch};
use benches::report::Report;
use benches::traffic::{self, Side, through_query};
use hoot_proto::Hoot;

use crate::peers::hoot as peers;

fn readers<U: Use>() -> [(&'static str, Read); 5] {
    [
        ("Reply::value", |mix| read(mix, ours::<Hoot, U>)),
        (LIMIT, |mix| read(mix, limit)),
        ("zerocopy", |mix| read(mix, peers::zerocopy::read::<U>)),
        ("nom", |mix| read(mix, peers::nom::read::<U>)),
        ("binrw", |mix| read(mix, peers::binrw::read::<U>)),
    ]
}

pub(crate) fn chapter(report: &mut Report) {
    let query: (_, Read) =
        ("query", |mix| read(mix, |stream, side| frame::<Hoot>(stream, |frame| through_query(side, frame))));
    let fields = [&[query], &readers::<Fields>()[..]].concat();
    decode::rows(&mut report.table("hoot decode"), &[("mix", traffic::hoot())], &fields, &readers::<Whole>());
}

#[inline]
fn limit(stream: &[u8], _: Side) -> Option<(u32, &[u8])> {
    touch(stream, usize::from(*stream.get(9)?) + 10)
}
