//! What firmware answered, replayed against the node of the same name.

use std::collections::BTreeMap;
use std::path::Path;

use motion_core::time::Millis;
use rigs::device::Named;
use rigs::hoot_node::{HootNode, Setup};
use rigs::{LineId, Outgoing, Party};

/// Start of each packet.
const BREAK: &str = "0000000000ff";
/// Time from one request to the next. The firmware was asked at leisure too.
const PAUSE: u64 = 300;

/// A request, from the address on, and the packets of the answer, one after the other.
struct Row {
    kind: String,
    request: String,
    answer: String,
}

fn rows(device: &str) -> Vec<Row> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../vectors/nmx/{device}.tsv"));
    let text = std::fs::read_to_string(path).unwrap();
    let row = |line: &str| {
        let [kind, request, answer] = line.split('\t').collect::<Vec<_>>()[..] else { panic!("{line:?}") };
        Row { kind: kind.to_owned(), request: request.to_owned(), answer: answer.to_owned() }
    };
    text.lines().map(row).collect()
}

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
}

/// Answer of the node to a request, as hex.
fn ask(node: &mut HootNode, now: u64, request: &str) -> String {
    node.receive(Millis(now), LineId(0), &bytes(&format!("{BREAK}{request}")));
    node.advance(Millis(now + PAUSE - 1));
    let mut answer = String::new();
    while let Some(outgoing) = node.poll() {
        if let Outgoing::Bytes(LineId(0), packet) = outgoing {
            answer.extend(packet.iter().map(|byte| format!("{byte:02x}")));
        }
    }
    answer
}

/// Reason, and the lines to which it applies.
type Known = (&'static str, &'static [usize]);

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
        let rows = rows(device);
        assert!(rows.len() > 1980, "{device}");
        let mut wrong = BTreeMap::new();
        for (number, row) in (1_usize..).zip(&rows) {
            let found = ask(&mut node, number as u64 * PAUSE, &row.request);
            if found != row.answer {
                wrong.insert(number, format!("{} {}: {found} and not {}", row.kind, row.request, row.answer));
            }
        }
        println!("{device}: {} of {} answers are equal", rows.len() - wrong.len(), rows.len());
        assert!(wrong.len() * 100 <= rows.len(), "{device}: {wrong:#?}");
        for (reason, lines) in *known {
            for line in *lines {
                assert!(wrong.remove(line).is_some(), "{device}, line {line} is right now, not: {reason}");
            }
        }
        assert!(wrong.is_empty(), "{device}: {wrong:#?}");
    }
}
