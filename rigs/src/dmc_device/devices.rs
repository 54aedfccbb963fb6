//! Devices and quirks of DMC by name.

use dmc_proto::device::Quirks;
use dmc_proto::message::{Capabilities, Hi, MotorFlags, Name};

use super::{Facts, Setup};
use crate::device::{Choice, Named};

/// Time after which a jog ends by itself, in milliseconds.
const JOG_LASTS: u64 = 600;

impl Named for Setup {
    const PROTOCOL: &'static str = "DMC";

    const DEVICES: &'static [Choice<Self>] = &[
        Choice { name: "mild", about: "As the document means it, with all motors enabled.", apply: mild },
        Choice {
            name: "reference",
            about: "As the document means it; no motor is enabled at first.",
            apply: reference,
        },
        Choice { name: "dmc-lite", about: "The vendor's small controller, version 1.2.", apply: dmc_lite },
        Choice { name: "servo", about: "An independent controller of servo motors.", apply: servo },
    ];

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
        Choice {
            name: "stop-locks",
            about: "After a stop of everything, all but questions is refused for two seconds, stops too.",
            apply: |setup| setup.add(Quirks::STOP_LOCKS),
        },
        Choice {
            name: "stop-of-one-ignored",
            about: "A stop of one motor in a run is acknowledged, and does nothing.",
            apply: |setup| setup.add(Quirks::STOP_OF_ONE_IGNORED),
        },
        Choice {
            name: "rests-beyond",
            about: "A run ends one frame after its last one.",
            apply: |setup| setup.add(Quirks::RESTS_BEYOND),
        },
        Choice {
            name: "clamps-frames",
            about: "A way to a frame outside the move leads to the nearest frame.",
            apply: |setup| setup.add(Quirks::CLAMPS_FRAMES),
        },
        Choice {
            name: "stays-after-shot",
            about: "After a shot the motors stay where they are.",
            apply: |setup| setup.add(Quirks::STAYS_AFTER_SHOT),
        },
        Choice {
            name: "positions-after-ack",
            about: "After some acknowledgements, positions follow under the id of the request.",
            apply: |setup| setup.add(Quirks::POSITIONS_AFTER_ACK),
        },
        Choice {
            name: "disabled",
            about: "No motor is enabled at first. Such a motor gets no pulses, although it seems to move.",
            apply: |setup| setup.facts.uses = MotorFlags::empty(),
        },
        Choice {
            name: "moves-disabled",
            about: "Moves and jogs move motors that are not enabled.",
            apply: |setup| setup.facts.moves_disabled = true,
        },
        Choice {
            name: "fills-with-zeros",
            about: "An upload gives each motor a path of zeros, so that each enabled motor is part of the move.",
            apply: |setup| setup.facts.fills_with_zeros = true,
        },
        Choice {
            name: "blurs-along-move",
            about: "In a shot without ways, a motor that blurs follows the uploaded move.",
            apply: |setup| setup.facts.blurs_along_move = true,
        },
        Choice {
            name: "jog-ends",
            about: "A jog ends by itself after 0.6 seconds.",
            apply: |setup| setup.facts.jog_lasts = Some(JOG_LASTS),
        },
        Choice {
            name: "leaves-shutter-open",
            about: "A stop in a shot leaves the shutter open.",
            apply: |setup| setup.facts.leaves_shutter_open = true,
        },
        Choice {
            name: "ignores-limits",
            about: "Moves and ways to a frame pass limits that were set.",
            apply: |setup| setup.facts.ignores_limits = true,
        },
        Choice {
            name: "truncates",
            about: "Positions are sent a step too near to 0.",
            apply: |setup| setup.facts.truncates = true,
        },
        Choice {
            name: "compares-check",
            about: "A frame with other check bytes than the device writes is damaged.",
            apply: |setup| setup.facts.compares_check = true,
        },
        Choice {
            name: "deaf-after-cut",
            about: "The device waits for the end of a frame for ever, and drops a damaged one with all that is in it.",
            apply: deaf,
        },
        Choice {
            name: "silent-at-boot",
            about: "The device greets at the first byte that arrives.",
            apply: |setup| setup.facts.is_silent_at_boot = true,
        },
    ];
}

/// Takes everything back that a device or a quirk decides.
fn mild(setup: &mut Setup) {
    let usual = Setup::with_motors(u8::try_from(setup.motors.len()).unwrap_or(u8::MAX));
    setup.options = usual.options;
    (setup.patience, setup.facts) = (usual.patience, usual.facts);
}

fn reference(setup: &mut Setup) {
    mild(setup);
    setup.facts.uses = MotorFlags::empty();
    setup.facts.blurs_along_move = true;
}

fn deaf(setup: &mut Setup) {
    setup.patience = setup.patience.with_margin(u32::MAX);
    setup.facts.drops_damaged = true;
}

fn dmc_lite(setup: &mut Setup) {
    reference(setup);
    deaf(setup);
    let capabilities = Capabilities::REAL_TIME
        | Capabilities::SHOOT_FRAME
        | Capabilities::SHOOT_FRAME2
        | Capabilities::COUPLE
        | Capabilities::LOOP
        | Capabilities::CAMERA_TRIGGER;
    let hi = Hi {
        name: Name::truncated("dmc-lite"),
        fw_minor: 2,
        dmx_count: 0,
        gio_out_count: 2,
        gio_in_count: 1,
        hw_limit_count: 0,
        capabilities,
        ..setup.options.hi()
    };
    setup.options = setup.options.with_hi(hi);
    setup.add(Quirks::VENDOR);
    setup.facts = Facts {
        moves_disabled: true,
        fills_with_zeros: true,
        jog_lasts: Some(JOG_LASTS),
        leaves_shutter_open: true,
        ignores_limits: true,
        truncates: true,
        is_silent_at_boot: true,
        ..setup.facts
    };
}

fn servo(setup: &mut Setup) {
    reference(setup);
    setup.patience = setup.patience.with_margin(u32::MAX);
    setup.add(Quirks::POSITIONS_AFTER_ACK);
    setup.facts.compares_check = true;
}

impl Setup {
    fn add(&mut self, quirks: Quirks) {
        self.options = self.options.with_quirks(self.options.quirks() | quirks);
    }
}
