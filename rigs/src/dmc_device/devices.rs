//! Devices and quirks of DMC by name.

use dmc_proto::device::Quirks;
use dmc_proto::message::{Acceleration, Capabilities, Hi, MotorFlags, Name, Speed};

use super::{Facts, Setup};
use crate::device::{Choice, Named};

/// Time after which a jog slows down by itself, in milliseconds.
const JOG_LASTS: u64 = 500;
/// Types of requests that dmc-lite does not know: inputs, and everything about virtual motors.
const UNKNOWN: &[u16] = &[0x0022, 0x0200, 0x0201, 0x0202, 0x0203, 0x0205, 0x0206, 0x0207];

impl Named for Setup {
    const PROTOCOL: &'static str = "DMC";

    const DEVICES: &'static [Choice<Self>] = &[
        Choice::new("mild", "Device as the document means it, with all motors enabled.", mild),
        Choice::new("reference", "Device as the document means it; no motor is enabled at first.", reference),
        Choice::new("dmc-lite", "The vendor's small controller, version 1.2.", dmc_lite),
        Choice::new("servo", "An independent controller of servo motors.", servo),
    ];

    const QUIRKS: &'static [Choice<Self>] = &[
        Choice::new("vendor", "All quirks of the machine that the vendor's own firmware has.", |setup| {
            setup.add(Quirks::VENDOR);
        }),
        Choice::new("wide-ack", "Acknowledgements have four bytes.", |setup| setup.add(Quirks::WIDE_ACK)),
        Choice::new("short-greeting", "The greeting has no version of the protocol.", |setup| {
            setup.add(Quirks::SHORT_GREETING);
        }),
        Choice::new(
            "positions-apart",
            "A question for positions is acknowledged, after the positions with id 0.",
            |setup| setup.add(Quirks::POSITIONS_APART),
        ),
        Choice::new("ack-for-move", "A move is acknowledged instead of answered by a status.", |setup| {
            setup.add(Quirks::ACK_FOR_MOVE);
        }),
        Choice::new(
            "reset-told-first",
            "New positions are sent before the request that set them is acknowledged.",
            |setup| setup.add(Quirks::RESET_TOLD_FIRST),
        ),
        Choice::new("end-per-pass", "The end is reported after each pass of a loop.", |setup| {
            setup.add(Quirks::END_PER_PASS);
        }),
        Choice::new("no-end-of-shot", "The end of a shot is not reported.", |setup| setup.add(Quirks::NO_END_OF_SHOT)),
        Choice::new("one-lock-code", "A locked device always answers ERR_HARD_LOW.", |setup| {
            setup.add(Quirks::ONE_LOCK_CODE);
        }),
        Choice::new(
            "stop-locks",
            "After a stop of everything, all but questions is refused for two seconds, stops too.",
            |setup| setup.add(Quirks::STOP_LOCKS),
        ),
        Choice::new(
            "stop-of-one-ignored",
            "A stop of one motor in a run is acknowledged, and does nothing.",
            |setup| setup.add(Quirks::STOP_OF_ONE_IGNORED),
        ),
        Choice::new("rests-beyond", "A run ends one frame after its last one.", |setup| {
            setup.add(Quirks::RESTS_BEYOND);
        }),
        Choice::new("clamps-frames", "A way to a frame outside the move leads to the nearest frame.", |setup| {
            setup.add(Quirks::CLAMPS_FRAMES);
        }),
        Choice::new("stays-after-shot", "After a shot the motors stay where they are.", |setup| {
            setup.add(Quirks::STAYS_AFTER_SHOT);
        }),
        Choice::new(
            "positions-after-ack",
            "After some acknowledgements, positions follow under the id of the request.",
            |setup| setup.add(Quirks::POSITIONS_AFTER_ACK),
        ),
        Choice::new(
            "disabled",
            "No motor is enabled at first. Such a motor gets no pulses, although it seems to move.",
            |setup| setup.facts.uses = MotorFlags::empty(),
        ),
        Choice::new("moves-disabled", "Moves and jogs move motors that are not enabled.", |setup| {
            setup.facts.moves_disabled = true;
        }),
        Choice::new(
            "fills-with-zeros",
            "An upload gives each motor a path of zeros, so that each enabled motor is part of the move.",
            |setup| setup.facts.fills_with_zeros = true,
        ),
        Choice::new(
            "blurs-along-move",
            "In a shot without ways, a motor that blurs follows the uploaded move.",
            |setup| setup.facts.blurs_along_move = true,
        ),
        Choice::new(
            "cuts-in",
            "A move or a jog of one motor is accepted on the way to a frame and before a start.",
            |setup| {
                setup.add(Quirks::CUTS_IN);
            },
        ),
        Choice::new(
            "few-checks",
            "Of the numbers in a request only motors and frames of shots are checked.",
            |setup| {
                setup.add(Quirks::FEW_CHECKS);
            },
        ),
        Choice::new(
            "busy-after-run",
            "A way to a frame is refused until the motors rest after a run or a shot.",
            |setup| {
                setup.add(Quirks::BUSY_AFTER_RUN);
            },
        ),
        Choice::new(
            "move-ends-run",
            "A move of a motor that is driven by hand ends a run, and the end is not reported.",
            |setup| {
                setup.add(Quirks::MOVE_ENDS_RUN);
            },
        ),
        Choice::new("tells-each-motor", "The status tells which motors move at this moment.", |setup| {
            setup.facts.tells_each_motor = true;
        }),
        Choice::new(
            "keeps-time",
            "The time with positions is that of the last run, shot or jog of all motors.",
            |setup| {
                setup.facts.keeps_time = true;
            },
        ),
        Choice::new(
            "vendor-shots",
            "In a shot only motors with blur move, and need a second to reach their speed.",
            |setup| {
                setup.facts.vendor_shots = true;
            },
        ),
        Choice::new(
            "vendor-jog-all",
            "A jog of all motors changes its speed slowly, and a stop of it ends on a frame.",
            |setup| {
                setup.facts.vendor_jog_all = true;
            },
        ),
        Choice::new(
            "jogs-to-run",
            "A run begins with a jog of all motors, and a stop of this jog lets the motors go on to the start of the run.",
            |setup| setup.facts.jogs_to_run = true,
        ),
        Choice::new(
            "vendor-parser",
            "Missing data counts as zeros, and no request of a type above 0x3ff is answered.",
            |setup| {
                setup.facts.vendor_parser = true;
            },
        ),
        Choice::new("no-inputs", "Requests for inputs, and all about virtual motors, are unknown.", |setup| {
            setup.facts.unknown = UNKNOWN;
        }),
        Choice::new("jog-ends", "A jog ends by itself after half a second.", |setup| {
            setup.facts.jog_lasts = Some(JOG_LASTS);
        }),
        Choice::new("leaves-shutter-open", "A stop in a shot leaves the shutter open.", |setup| {
            setup.facts.leaves_shutter_open = true;
        }),
        Choice::new("ignores-limits", "Everything except a run passes limits that were set.", |setup| {
            setup.facts.ignores_limits = true;
        }),
        Choice::new("truncates", "Positions are sent a step too near to 0.", |setup| setup.facts.truncates = true),
        Choice::new("compares-check", "A frame with other check bytes than the device writes is damaged.", |setup| {
            setup.facts.compares_check = true;
        }),
        Choice::new(
            "deaf-after-cut",
            "The device waits for the end of a frame for ever, and drops a damaged one with all that is in it.",
            deaf,
        ),
        Choice::new("silent-at-boot", "The device greets at the first byte that arrives.", |setup| {
            setup.facts.is_silent_at_boot = true;
        }),
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
        tuned: Some((Speed(5_000), Acceleration(20_000))),
        tells_each_motor: true,
        keeps_time: true,
        vendor_shots: true,
        vendor_jog_all: true,
        jogs_to_run: true,
        vendor_parser: true,
        unknown: UNKNOWN,
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
