//! Whole messages of hoot, compared with other crates, and replies without the query that they answer.
//!
//! A listener reads a value by the type before it. Our contender in the other tables reads it through the query, and
//! knows its type as all peers do.

use benches::decode::{self, Fields, Read, Whole, ours, read};
use benches::report::Report;
use benches::traffic;
use hoot_proto::Hoot;

use crate::peers::hoot::readers;

pub(crate) fn chapter(report: &mut Report) {
    let mixes = [("mix", traffic::hoot())];
    decode::rows(&mut report.table("hoot decode, whole messages"), &mixes, &readers::<Whole>());
    let value: (_, Read) = ("Reply::value", |mix| read(mix, ours::<Hoot, Fields>));
    let [_, peers @ ..] = readers::<Fields>();
    decode::rows(&mut report.table("hoot decode by Reply::value"), &mixes, &[&[value], &peers[..]].concat());
}
