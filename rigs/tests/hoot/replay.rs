//! What firmware answered, replayed against the node of the same name.

use std::collections::BTreeMap;

use motion_core::time::Millis;
use motion_rigs::device::Named;
use motion_rigs::hoot_node::{HootNode, Setup};
use motion_rigs::{LineId, Outgoing, Party};

use crate::recorded::{Known, bytes, check, hex, table};

/// Start of each packet.
const BREAK: &str = "0000000000ff";
/// Time from one request to the next. The firmware was asked at leisure too.
const PAUSE: u64 = 300;

/// Answer of the node to a request, as hex.
fn ask(node: &mut HootNode, now: u64, request: &str) -> String {
    node.receive(Millis(now), LineId(0), &bytes(&format!("{BREAK}{request}")));
    node.advance(Millis(now + PAUSE - 1));
    let mut answer = String::new();
    while let Some(outgoing) = node.poll() {
        if let Outgoing::Bytes(LineId(0), packet) = outgoing {
            answer.push_str(&hex(&packet));
        }
    }
    answer
}

/// Lines of each build whose answer the node does not give.
const DIFFERENCES: &[(&str, &[Known])] = &[
    (
        "2014-10-15",
        &[
            (SUPPLY, &[8, 9, 1313, 1314]),
            ("the vendor's compiler rounds a number below the range of normal ones in another way", &[1087]),
        ],
    ),
    (
        "2014-12-03",
        &[
            (SUPPLY, &[8, 9, 1313, 1314]),
            ("the compiler of this build rounds a number below the range of normal ones in another way", &[1087]),
            (TWO, &[262, 274, 282, 1345]),
            (NAN, &[492, 506]),
            (KEY_FRAMES, &[1369, 1370]),
            (LATER_CAMERA, &[1779, 1780]),
        ],
    ),
    (
        "v0.23",
        &[
            (SUPPLY, &[8, 9, 1313, 1314]),
            (TWO, &[262, 274, 282, 1345]),
            (NAN, &[492, 506]),
            (KEY_FRAMES, &[1369, 1370]),
            (LATER_CAMERA, &[1779, 1780]),
        ],
    ),
    ("v0.33", &[(KEY_FRAMES, &[1369, 1370]), (LATER_CAMERA, &[1779, 1780])]),
    ("v0.45", &[(MEMORY, &[1476]), (LATER_CAMERA, &[1779, 1780, 1781])]),
    (
        "v0.58",
        &[
            (MEMORY, &[1476]),
            ("a query with surplus data read an end limit from a place in memory that holds something else", &[1333]),
            (LATER_CAMERA, &[1779, 1780, 1781, 1782, 1783]),
        ],
    ),
    ("v0.70", &[(MEMORY, &[1476]), (LATER_CAMERA, &[1779, 1780, 1781, 1782, 1783])]),
];
const SUPPLY: &str = "the lower half of an IEEE number from the converter; the node knows hundredths only";
const TWO: &str = "a yes that was set as 2 is read back as 2; the node keeps yes or no";
const NAN: &str = "the compiler of this build gives NaN a sign";
const KEY_FRAMES: &str = "commands of key frames, which the sheet does not have";
const LATER_CAMERA: &str = "queries of the camera that the sheet does not have";
const MEMORY: &str = "the number of free bytes, a query that the sheet does not have";

#[test]
fn nodes_answer_as_firmware_did() {
    for (device, known) in DIFFERENCES {
        let mut node = HootNode::new(Setup::default().with_device(device).unwrap());
        node.open(Millis(0), LineId(0));
        let rows = table(&format!("nmx/{device}"));
        assert!(rows.len() > 1980, "{device}");
        let mut wrong = BTreeMap::new();
        for (number, [kind, request, answer]) in (1_usize..).zip(&rows) {
            let found = ask(&mut node, number as u64 * PAUSE, request);
            if found != *answer {
                wrong.insert(number, format!("{kind} {request}: {found} and not {answer}"));
            }
        }
        check(device, rows.len(), wrong, known);
    }
}
