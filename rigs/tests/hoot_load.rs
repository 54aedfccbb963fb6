//! Load on a node: a master that asks as fast as the protocol allows, and ten thousand messages a second on another port,
//! on bad lines.
//!
//! A master has one request under way, and leaves at least 40 ms between two, so it sends some 25 a second on a good line.
//! The messages on the Bluetooth port come without such gaps.
//!
//! hoot has no checksum: a wrong bit in a number makes another number, and the node answers OK to it. So the lines lose,
//! double, delay, cut and add bytes, fall silent and reset, but bits stay right. The last test counts the effects of wrong
//! bits.

use std::time::Instant;

use hoot_proto::host::{self, Command, Options, Request, Token};
use hoot_proto::message::{self, Motor, Steps};
use hoot_proto::{Address, HostMessage};
use motion_core::time::Millis;
use motion_rigs::faults::{Carrier, Faults};
use motion_rigs::hoot_master::{Event, HootMaster};
use motion_rigs::hoot_node::{HootNode, Setup};
use motion_rigs::line::Line;
use motion_rigs::{LineId, Outgoing, Party, Scene};

const BLUETOOTH: LineId = LineId(1);
/// Token of a query.
const QUERY: Token = Token(0);
/// Messages by Bluetooth in a millisecond.
const MESSAGES: u64 = 10;
/// Number of bytes that may wait: two packets in each of the readers, and the bytes in flight.
const HELD: usize = 1024;

/// Counts of a test.
#[derive(Debug, Default)]
struct Count {
    asked: u32,
    ended: u32,
    done: u32,
    /// Number of requests that are done, although the node has another number.
    wrong: u32,
    sent: u64,
    answered: u64,
    /// Number of answers for which it is known which number the node must have.
    proved: u64,
    /// Whether the last piece was answered. Then the node reads from the beginning of the next one.
    reads_anew: bool,
    most_held: usize,
}

fn set_start(motor: Motor, position: i32) -> HostMessage<'static> {
    message::MotorSetProgramStart { motor, position: Steps(position) }.into()
}

fn start_of(rig: &HootNode, motor: Motor) -> i32 {
    rig.machine().motor(motor).settings().plan.start.0
}

fn load(seconds: u64, faults: Faults, seed: u64) -> Count {
    // Lines are silent for up to a second and a half, so answers are later than the master takes to be possible by default.
    let options = Options::default().with_gap(40).with_settle(1).with_timeout(700);
    let (master, node) = (HootMaster::new(options), HootNode::new(Setup::default()));
    let mut scene = Scene::new(master, node, Carrier::Serial, faults, seed);
    let mut other = Line::new(faults, seed + 1000);
    let mut count = Count::default();
    let (mut waits, mut is_new) = (0, false);
    for now in 0..seconds * 1000 {
        if now % 100 == 0 {
            // A power failure may have closed the port.
            scene.rig.open(Millis(now), BLUETOOTH);
        }
        if std::mem::take(&mut is_new) {
            // After the line came up, settings wait until the node has answered a query (decision H-40).
            let message = message::FirmwareVersion {}.into();
            scene.command((QUERY, Command::Request(Request { to: Address::DEFAULT, message })));
        }
        while waits < 8 && now > 10 {
            count.asked += 1;
            waits += 1;
            let message = set_start(Motor::One, i32::try_from(count.asked).unwrap());
            scene.command((Token(count.asked), Command::Request(Request { to: Address::DEFAULT, message })));
        }
        scene.run(Millis(now), |scene, event| {
            let ended = match event {
                Event::Ended(ended) if ended.token != QUERY => ended,
                Event::Machine(host::Event::Ready { .. }) => {
                    is_new = true;
                    return None;
                }
                _ => return None::<()>,
            };
            waits -= 1;
            count.ended += 1;
            if ended.is_done() {
                count.done += 1;
                count.wrong += u32::from(start_of(&scene.rig, Motor::One) != i32::try_from(ended.token.0).unwrap());
            }
            None
        });
        flood(&mut scene, &mut other, now, &mut count);
        count.most_held = count.most_held.max(scene.held() + scene.rig.held() + scene.host.held());
    }
    count.ended += u32::try_from(scene.host.machine().pending()).unwrap();
    count
}

/// Sends ten messages to the other port. An OK answers the number that came last.
fn flood(scene: &mut Scene<HootMaster, HootNode>, line: &mut Line, now: u64, count: &mut Count) {
    let now = Millis(now);
    for _ in 0..MESSAGES {
        count.sent += 1;
        let mut packet = [0; 42];
        let number = i32::try_from(count.sent).unwrap();
        let len = set_start(Motor::Two, number).encode_into(Address::DEFAULT, &mut packet).unwrap();
        line.push(now, &packet[..len]);
    }
    let mut before = start_of(&scene.rig, Motor::Two);
    while let Some(piece) = line.pop(now) {
        let reads_anew = std::mem::take(&mut count.reads_anew);
        let whole = number_of(&piece).filter(|_| reads_anew);
        scene.rig.receive(now, BLUETOOTH, &piece);
        while let Some(out) = scene.rig.poll() {
            let Outgoing::Bytes(BLUETOOTH, bytes) = out else { continue };
            assert_eq!(bytes, [0, 0, 0, 0, 0, 0xFF, 0, 0, 1, 0], "nothing is refused");
            count.answered += 1;
            count.reads_anew = true;
            // An earlier number is never written over a later one, also if a message is doubled.
            let after = start_of(&scene.rig, Motor::Two);
            assert!(after >= before && u64::try_from(after).unwrap() <= count.sent, "{before} then {after}");
            before = after;
            if let Some(number) = whole {
                assert_eq!(after, number, "the node answers OK, and has another number");
                count.proved += 1;
            }
        }
    }
}

/// Number that a piece sets, if it begins with a packet.
fn number_of(piece: &[u8]) -> Option<i32> {
    let packet = piece.get(..14).filter(|packet| packet.starts_with(&[0, 0, 0, 0, 0, 0xFF]))?;
    packet.last_chunk().map(|number| i32::from_be_bytes(*number))
}

fn bad() -> Faults {
    Faults { corruption: 0.0, ..Faults::all(Carrier::Serial) }
}

fn holds(seconds: u64) {
    let began = Instant::now();
    let count = load(seconds, bad(), 7);
    println!("{seconds} s of load took {:?}: {count:?}", began.elapsed());
    assert_eq!(
        (count.asked, count.wrong),
        (count.ended, 0),
        "each request ends, and the node has the number of each request that is done"
    );
    assert!(u64::from(count.done) > 5 * seconds, "{count:?}");
    // A packet that is cut costs some of the packets after it, because nodes do not look for the next packet.
    assert!(count.sent == seconds * 1000 * MESSAGES && count.answered > count.sent / 50, "{count:?}");
    assert!(count.proved > count.answered / 4, "{count:?}");
    assert!(count.most_held < HELD, "{count:?}");
}

#[test]
fn on_a_good_line_each_message_is_answered_and_the_master_too() {
    let count = load(3, Faults::NONE, 1);
    assert_eq!((count.asked, count.wrong, count.answered, count.proved), (count.ended, 0, count.sent, count.sent - 1));
    assert!(count.done >= 45 && count.most_held < HELD, "{count:?}");
}

#[test]
fn a_node_holds_five_seconds_of_load() {
    holds(5);
}

#[test]
#[ignore = "takes some seconds with --release"]
fn a_node_holds_a_minute_of_load() {
    holds(60);
}

/// hoot has no checksum, so the node answers OK to some numbers that are wrong.
#[test]
fn wrong_bits_are_not_noticed() {
    let faults = Faults { corruption: 0.2, reset: 0.0, ..Faults::NONE };
    let options = Options::default().with_gap(40).with_settle(1);
    let node = HootNode::new(Setup::default());
    let mut scene = Scene::new(HootMaster::new(options), node, Carrier::Serial, faults, 3);
    scene.run(Millis(10), |_, _| None::<()>);
    let (mut done, mut wrong) = (0, 0);
    for asked in 1..400 {
        let message = set_start(Motor::One, asked);
        let token = Token(asked.unsigned_abs());
        scene.command((token, Command::Request(Request { to: Address::DEFAULT, message })));
        let until = scene.now().after(3000);
        let is_done = scene.run(until, |_, event| match event {
            Event::Ended(ended) if ended.token == token => Some(ended.is_done()),
            _ => None,
        });
        if is_done == Some(true) {
            done += 1;
            wrong += i32::from(start_of(&scene.rig, Motor::One) != asked);
        }
    }
    // A fifth of the packets has a wrong bit, and 32 of the 112 bits of a packet are in the number.
    assert!(done > 250 && (8..60).contains(&wrong), "{wrong} of {done}");
}
