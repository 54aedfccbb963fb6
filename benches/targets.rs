//! Targets of speed, in the order of the table.

use crate::report::Bound::{self, Cost, Shown, Speed};
use crate::report::Target;

type Bounds = &'static [(&'static str, Bound)];
type Rows = &'static [&'static str];

const fn target(id: &'static str, table: &'static str, rows: Rows, ours: &'static str, bounds: Bounds) -> Target {
    Target { id, table, rows, ours, bounds }
}

const FLETCHER: &str = "Fletcher-16, verify";
const ARRAY: &str = "Fletcher-16, verify, length known to the compiler";
const SHORT: Rows = &["12 B", "14 B", "19 B"];
const MIXES: Rows = &["DMC upload mix", "DMC small mix", "kOS mix", "kOS small mix", "hoot"];
const BATCHES: &str = "B1 and B3, an axis at 1 kHz in batches of 16, 992 times";
const CURVES: Rows = &["typical", "any"];
const WORST: Rows = &["*"];
// `clean` reads valid frames by `push` and `next`, so that the bound does not get stricter when frames are lent faster.
const FLOOD: Bounds = &[("clean", Cost(8.0))];
const WHOLE: Bounds = &[("zerocopy", Shown), ("nom", Shown), ("binrw", Shown)];

pub(crate) const TARGETS: &[Target] = &[
    target(
        "F1",
        FLETCHER,
        &["1048 B"],
        "motion-core",
        &[("byte sum (u64)", Speed(3.0)), ("fletcher", Speed(8.0)), ("C listing", Speed(9.0))],
    ),
    target("F2", FLETCHER, &["80 B"], "motion-core", &[("byte sum (u64)", Speed(1.3))]),
    target("F2", FLETCHER, SHORT, "motion-core", &[("byte sum (u32)", Speed(0.7))]),
    target("F2", ARRAY, SHORT, "motion-core, array", &[("byte sum (u32)", Speed(1.0))]),
    // All four parsers allocate their lists.
    target(
        "D1",
        "DMC decode",
        &["upload mix", "small mix"],
        "dmc-proto",
        &[
            ("zerocopy", Speed(1.0)),
            ("nom", Speed(7.0)),
            ("winnow", Speed(7.0)),
            ("deku", Speed(7.0)),
            ("binrw", Speed(7.0)),
            ("walk and touch", Shown),
        ],
    ),
    target("D1", "DMC decode, whole messages", &["upload mix", "small mix"], "dmc-proto", WHOLE),
    target("D1", "instructions", &["dmc/mix/slice"], "fat", &[("", Cost(250.0))]),
    target("D1", "instructions", &["dmc/small/slice"], "fat", &[("", Cost(195.0))]),
    target(
        "D2",
        "kOS decode",
        &["mix", "small mix"],
        "kos-proto",
        &[
            ("deku", Speed(3.0)),
            ("binrw", Speed(8.0)),
            ("zerocopy", Shown),
            ("nom", Shown),
            ("winnow", Shown),
            ("walk and touch", Shown),
        ],
    ),
    target("D2", "kOS decode, whole messages", &["mix", "small mix"], "kos-proto", WHOLE),
    target("D2", "instructions", &["kos/mix/slice"], "fat", &[("", Cost(200.0))]),
    target("D2", "instructions", &["kos/small/slice"], "fat", &[("", Cost(100.0))]),
    target(
        "D3",
        "hoot decode",
        &["mix"],
        "hoot-proto",
        &[("binrw", Speed(10.0)), ("zerocopy", Shown), ("nom", Shown), ("walk and touch", Shown)],
    ),
    target("D3", "hoot decode by Reply::value", &["mix"], "Reply::value", &[("binrw", Speed(10.0))]),
    target("D3", "hoot decode, whole messages", &["mix"], "hoot-proto", WHOLE),
    target("D3", "instructions", &["hoot/mix/query"], "fat", &[("", Cost(44.0))]),
    target("D3", "instructions", &["hoot/mix/slice"], "fat", &[("", Cost(60.0))]),
    target(
        "D4",
        "complete parsers",
        &["kOS small mix"],
        "next_from",
        &[("mavlink", Speed(12.0)), ("ublox", Speed(4.5))],
    ),
    target(
        "D4",
        "complete parsers",
        &["DMC small mix"],
        "next_from",
        &[("mavlink", Speed(7.0)), ("ublox", Speed(2.5))],
    ),
    target("I1a", "stream, pieces of 64 KiB", MIXES, "next_from", &[("one slice", Speed(0.9))]),
    target("I1b", "stream, pieces of 64 B", MIXES, "next_from", &[("one slice", Speed(0.6))]),
    target(
        "I1c",
        "stream, pieces of 1 B",
        MIXES,
        "push and next",
        &[("tokio-util, BytesMut", Speed(2.4)), ("byte machine", Shown)],
    ),
    // The last bytes of a stream are not looked at, which counts for more in a short one.
    target("I2", "floods, work for each byte", WORST, "4 n", &[("", Cost(8.0)), ("n", Cost(1.03))]),
    target("I2", "floods, longer and longer", WORST, "4 n", &[("n", Cost(1.2))]),
    target("I2", "floods, pieces of 64 KiB", WORST, "limit 1048", FLOOD),
    target("I2", "floods, pieces of 64 KiB", WORST, "limit 2048", FLOOD),
    target("I2", "floods, pieces of 64 KiB", WORST, "limit 65547", FLOOD),
    target("I2", "floods, pieces of 64 B", WORST, "limit 2048", FLOOD),
    target("I2", "floods, pieces of 1 B", WORST, "limit 2048", FLOOD),
    target("I2", "floods, pieces of 1 B", WORST, "limit 2048, push", FLOOD),
    target(
        "E1",
        "DMC encode",
        &["19 B", "80 B", "1041 B"],
        "dmc-proto",
        &[("memcpy and sum", Speed(0.95)), ("bytes, BytesMut", Shown)],
    ),
    target("B1", BATCHES, CURVES, "positions", &[("y by de Casteljau", Speed(0.6)), ("kurbo", Speed(14.0))]),
    target(
        "B2",
        "B2, random access, 992 times, with the making of tables",
        CURVES,
        "Table",
        &[("kurbo", Speed(2.0)), ("bezier_easing", Speed(1.1))],
    ),
    target("B3", BATCHES, CURVES, "with rates", &[("positions", Cost(1.5))]),
    target("P", "instructions", &["*/slice", "*/stream", "*/lend", "*/pieces"], "default", &[("fat", Cost(1.1))]),
    target("P", "profiles", &["*/slice", "*/stream", "*/lend", "*/pieces"], "default", &[("fat", Cost(1.1))]),
];
