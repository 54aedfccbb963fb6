//! D4: streams are decoded to typed messages, compared with complete parsers of other protocols.
//!
//! Each parser finds, verifies and decodes the frames of its own protocol, so times are compared for each message. There
//! are 2000 messages, of 23 bytes on average for kOS, 56 for DMC, 31 for mavlink and 32 for ublox.

use std::hint::black_box;

use benches::ratios::{Contender, contender};
use benches::report::Report;
use benches::traffic;
use dmc_proto::Dmc;
use kos_proto::Kos;

use crate::peers::field;
use crate::stream::{pushed, slice};

pub(crate) fn chapter(report: &mut Report) {
    let mut table = report.table("complete parsers");
    let (kos, dmc) = (&traffic::kos(false), &traffic::dmc(false));
    let (mavlink, ublox) = (field::mavlink(), field::ublox());
    let mut parser = ublox::Parser::default_proto();
    assert_eq!(field::read_mavlink(&mavlink.bytes), mavlink.tally);
    assert_eq!(field::read_ublox(&mut parser, &ublox.bytes), ublox.tally);
    let mut row = |name: &str, ours: [Contender<'_>; 2]| {
        let peers = [
            contender("mavlink", || field::read_mavlink(black_box(&mavlink.bytes))).per(mavlink.tally.messages),
            contender("ublox", || field::read_ublox(&mut parser, black_box(&ublox.bytes))).per(ublox.tally.messages),
        ];
        table.row(name, ours.into_iter().chain(peers).collect());
    };
    row("kOS small mix", [pushed::<Kos, 32_768>(kos, usize::MAX), slice::<Kos>(kos)]);
    row("DMC small mix", [pushed::<Dmc, 4096>(dmc, usize::MAX), slice::<Dmc>(dmc)]);
}
