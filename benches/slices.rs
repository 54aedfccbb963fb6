//! D1 to D3: frames in one slice are decoded to typed messages, whose fields are all added up, compared with other crates.
//!
//! Each contender knows the four messages of the mixes and their directions. All parsers of DMC verify with our checksum,
//! so only the way from bytes to values differs. The limit is to walk from length to length and to add up all bytes.
//! Nothing in a reply of hoot says what it answers. The mix has one kind of query, so our contender reads each value
//! through that query, and knows its type as all peers do.
//!
//! This is a program of its own, because it has to decode in one place: our decoders are used by all other benches as
//! well, and the optimiser does not copy them into a loop if they are also used elsewhere. The parsers of the peers are
//! used here alone.

mod peers {
    pub(crate) mod dmc;
    pub(crate) mod hoot;
    pub(crate) mod kos;
}

use benches::decode::{Fields, rows};
use benches::report::{self, Report};
use benches::traffic;

fn main() {
    report::run("decode", env!("CARGO_TARGET_TMPDIR"), &[("dmc", dmc), ("kos", kos), ("hoot", hoot)]);
}

fn dmc(report: &mut Report) {
    let mixes = [("upload mix", traffic::dmc(true)), ("small mix", traffic::dmc(false))];
    rows(&mut report.table("DMC decode"), &mixes, &peers::dmc::readers::<Fields>());
}

fn kos(report: &mut Report) {
    let mixes = [("mix", traffic::kos(true)), ("small mix", traffic::kos(false))];
    rows(&mut report.table("kOS decode"), &mixes, &peers::kos::readers::<Fields>());
}

fn hoot(report: &mut Report) {
    rows(&mut report.table("hoot decode"), &[("mix", traffic::hoot())], &peers::hoot::readers::<Fields>());
}
