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
use crate::stream::{read_lent, read_pushed, slice, stream};

pub(crate) fn chapter(report: &mut Report) {
    let mut table = report.table("complete parsers");
    let (kos, dmc) = (&traffic::kos(false), &traffic::dmc(false));
    let (mavlink, ublox) = (field::mavlink(), field::ublox());
    let mut parser = ublox::Parser::default_proto();
    assert_eq!(field::read_mavlink(&mavlink.bytes), mavlink.tally);
    assert_eq!(field::read_ublox(&mut parser, &ublox.bytes), ublox.tally);
    let mut row = |name: &str, ours: [Contender<'_>; 3]| {
        let peers = [
            contender("mavlink", || field::read_mavlink(black_box(&mavlink.bytes))).per(mavlink.tally.messages),
            contender("ublox", || field::read_ublox(&mut parser, black_box(&ublox.bytes))).per(ublox.tally.messages),
        ];
        table.row(name, ours.into_iter().chain(peers).collect());
    };
    let kos = [
        stream("next_from", read_lent::<Kos, 32_768>, kos, usize::MAX),
        stream("push and next", read_pushed::<Kos, 32_768>, kos, usize::MAX),
        slice::<Kos>(kos),
    ];
    row("kOS small mix", kos);
    let dmc = [
        stream("next_from", read_lent::<Dmc, 4096>, dmc, usize::MAX),
        stream("push and next", read_pushed::<Dmc, 4096>, dmc, usize::MAX),
        slice::<Dmc>(dmc),
    ];
    row("DMC small mix", dmc);
}
