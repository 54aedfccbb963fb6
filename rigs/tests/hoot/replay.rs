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

#[test]
fn nodes_answer_as_firmware_did() {
    let mut said = String::new();
    for device in ["2014-10-15", "2014-12-03", "v0.23", "v0.33", "v0.45", "v0.58", "v0.70"] {
        let mut node = HootNode::new(Setup::default().with_device(device).unwrap());
        node.open(Millis(0), LineId(0));
        let rows = rows(device);
        let mut wrong = BTreeMap::<String, Vec<String>>::new();
        for (number, row) in rows.iter().enumerate() {
            let found = ask(&mut node, (number as u64 + 1) * PAUSE, &row.request);
            if found != row.answer {
                let line =
                    format!("{}: {} and not {}", number + 1, found.replace(BREAK, "."), row.answer.replace(BREAK, "."));
                wrong
                    .entry(format!("{} {}", row.kind, &row.request[2..6]))
                    .or_default()
                    .push(format!("{} {line}", row.request));
            }
        }
        let count: usize = wrong.values().map(Vec::len).sum();
        said += &format!("{device}: {count} of {} differ\n", rows.len());
        if std::env::var("SHOW").is_ok_and(|show| show == device) {
            for (what, all) in &wrong {
                said += &format!(
                    "  {what}: {}: {}\n",
                    all.len(),
                    all.iter().take(3).cloned().collect::<Vec<_>>().join("; ")
                );
            }
        }
    }
    println!("{said}");
}
