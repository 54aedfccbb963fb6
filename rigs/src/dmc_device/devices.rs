//! Devices and quirks of DMC by name.

use dmc_proto::device::{Options, Quirks};

use super::Setup;
use crate::device::{Choice, Named};

impl Named for Setup {
    const PROTOCOL: &'static str = "DMC";

    const DEVICES: &'static [Choice<Self>] =
        &[Choice { name: "mild", about: "As the document means it.", apply: mild }];

    const QUIRKS: &'static [Choice<Self>] = &[
        Choice {
            name: "vendor",
            about: "All quirks of the machine that the vendor's own firmware has.",
            apply: |setup| setup.add(Quirks::VENDOR),
        },
        Choice {
            name: "wide-ack",
            about: "Acknowledgements have four bytes.",
            apply: |setup| setup.add(Quirks::WIDE_ACK),
        },
        Choice {
            name: "short-greeting",
            about: "The greeting has no version of the protocol.",
            apply: |setup| setup.add(Quirks::SHORT_GREETING),
        },
        Choice {
            name: "positions-apart",
            about: "A question for positions is acknowledged, after the positions with id 0.",
            apply: |setup| setup.add(Quirks::POSITIONS_APART),
        },
        Choice {
            name: "ack-for-move",
            about: "A move is acknowledged instead of answered by a status.",
            apply: |setup| setup.add(Quirks::ACK_FOR_MOVE),
        },
        Choice {
            name: "reset-told-first",
            about: "New positions are sent before the request that set them is acknowledged.",
            apply: |setup| setup.add(Quirks::RESET_TOLD_FIRST),
        },
        Choice {
            name: "end-per-pass",
            about: "The end is reported after each pass of a loop.",
            apply: |setup| setup.add(Quirks::END_PER_PASS),
        },
        Choice {
            name: "no-end-of-shot",
            about: "The end of a shot is not reported.",
            apply: |setup| setup.add(Quirks::NO_END_OF_SHOT),
        },
        Choice {
            name: "one-lock-code",
            about: "A locked device always answers ERR_HARD_LOW.",
            apply: |setup| setup.add(Quirks::ONE_LOCK_CODE),
        },
    ];
}

/// Takes everything back that a device or a quirk decides.
fn mild(setup: &mut Setup) {
    setup.options = Options::of(setup.options.hi());
}

impl Setup {
    fn add(&mut self, quirks: Quirks) {
        self.options = self.options.with_quirks(self.options.quirks() | quirks);
    }
}
