//! Conduct of firmware that the published sheet does not tell, in the nodes that are named after it.

use motion_core::time::Millis;
use rigs::device::Named;
use rigs::hoot_node::{HootNode, Setup};
use rigs::{LineId, Outgoing, Party, Rig};

const USB: LineId = LineId(0);
const OK: &str = "0000000000ff00000100";

/// A node, with the time and short names for packets.
struct Bench {
    node: HootNode,
    now: u64,
}

impl Bench {
    fn new(device: &str) -> Self {
        let mut node = HootNode::new(Setup::default().with_device(device).unwrap());
        node.open(Millis(0), USB);
        Self { node, now: 0 }
    }

    /// Sends packets, from the address on, in one piece.
    fn send(&mut self, packets: &[&str]) {
        let bytes: Vec<u8> = packets.iter().flat_map(|packet| bytes(&format!("0000000000ff{packet}"))).collect();
        self.node.receive(Millis(self.now), USB, &bytes);
    }

    /// Lets time pass, and returns what the node says meanwhile.
    fn pass(&mut self, millis: u64) -> String {
        self.now += millis;
        self.node.advance(Millis(self.now));
        let mut said = String::new();
        while let Some(outgoing) = self.node.poll() {
            if let Outgoing::Bytes(USB, packet) = outgoing {
                said.extend(packet.iter().map(|byte| format!("{byte:02x}")));
            }
        }
        said
    }

    fn ask(&mut self, packet: &str) -> String {
        self.send(&[packet]);
        self.pass(20)
    }

    #[track_caller]
    fn ok(&mut self, packet: &str) {
        assert_eq!(self.ask(packet), OK, "{packet}");
    }
}

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
}

const START: &str = "03000200";
const STOP: &str = "03000400";
const STATUS: &str = "03006500";

#[test]
fn a_start_blocks_and_a_stop_that_waits_alone_is_obeyed() {
    for device in ["v0.20", "v0.33", "v0.70"] {
        let mut bench = Bench::new(device);
        bench.send(&[START]);
        assert_eq!(bench.pass(1000), "", "{device}");
        bench.send(&[STOP]);
        assert_eq!(bench.pass(499), "", "{device}");
        assert_eq!(bench.pass(1), format!("{OK}{OK}"), "{device}: the start, and then the stop");
        assert!(bench.ask(STATUS).ends_with("020000"), "{device}: stopped");
        assert!(!bench.node.is_hung());
    }
    for device in ["mild", "2014-10-15", "2014-12-22"] {
        let mut bench = Bench::new(device);
        assert_eq!(bench.ask(START), OK, "{device} does not block");
    }
}

#[test]
fn two_packets_that_wait_hang_a_node_until_its_power_is_interrupted() {
    for device in ["v0.20", "v0.33", "v0.70"] {
        for gap in [0, 150, 500] {
            let mut bench = Bench::new(device);
            bench.send(&[START]);
            assert_eq!(bench.pass(100), "");
            bench.send(&[STOP]);
            assert_eq!(bench.pass(gap), "");
            bench.send(&[STOP]);
            assert_eq!(bench.pass(5000), OK, "{device}: the start only");
            assert!(bench.node.is_hung());
            assert_eq!((bench.ask(STOP), bench.ask(STATUS)), (String::new(), String::new()), "{device}");
            bench.node.reset(Millis(bench.now));
            bench.node.open(Millis(bench.now), USB);
            assert!(bench.ask(STATUS).ends_with("020000"), "{device}: at work again");
        }
    }
}

#[test]
fn a_new_address_blocks_and_two_packets_that_wait_then_hang_the_node() {
    for (device, assign, answer, blocks) in [
        ("2014-10-15", "0100040109", "", 2500),
        ("v0.70", "0100040109", "", 2500),
        ("v0.70", "0300080109", OK, 1000),
        ("v0.33", "030001020409", OK, 1000),
    ] {
        for waiting in [1, 2] {
            let mut bench = Bench::new(device);
            bench.send(&[assign]);
            assert_eq!(bench.pass(1), answer);
            for _ in 0..waiting {
                bench.send(&[STOP]);
            }
            assert_eq!(bench.pass(blocks - 2), "", "{device}");
            assert_eq!(bench.pass(1), if waiting == 1 { OK } else { "" }, "{device}");
            assert_eq!(bench.node.is_hung(), waiting == 2, "{device}");
        }
    }
}

#[test]
fn firmware_at_rest_answers_all_packets_of_one_write_and_a_mild_node_the_first() {
    for (device, answers) in [("mild", 1), ("sheet", 3), ("v0.70", 3)] {
        let mut bench = Bench::new(device);
        bench.send(&[STOP, STOP, STOP]);
        assert_eq!(bench.pass(100), OK.repeat(answers), "{device}");
    }
}

#[test]
fn more_than_32_bytes_of_data_hang_firmware() {
    let long = format!("03000721{}", "41".repeat(33));
    for (device, hangs) in [("mild", false), ("2014-10-15", true), ("v0.70", true)] {
        let mut bench = Bench::new(device);
        assert_eq!(bench.ask(&long), "");
        assert_eq!((bench.node.is_hung(), bench.ask(STOP).is_empty()), (hangs, hangs), "{device}");
    }
}
