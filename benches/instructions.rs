//! Work of the decoders and encoders, whose instructions `.ci/instructions` counts.
//!
//! Each row of the table is one call of [`measured`], the only function in which callgrind counts. The program prints
//! the name of each row and the number of messages in it, in the order of the calls.
//!
//! The mixes are those of the other benches. The rows `all` read every valid message of the conformance vectors once.
//! With the argument `each`, every vector has its own rows instead, so that a change can be traced to a message. With
//! the argument `times`, the bench of profiles tells the program how often to repeat each row, and it answers the time.
//!
//! - `slice`: frames in one slice are found, verified and decoded, and all fields of each message are added up.
//! - `query`: as `slice`, and each reply of hoot is read through the query that it answers.
//! - `decode`: a slice that is one frame is decoded to a typed message.
//! - `stream`: all bytes of a stream are pushed into the buffer of `Frames`, and the frames are decoded to typed messages.
//! - `lend`: a stream in pieces of 64 KiB lends its frames, which are decoded to typed messages.
//! - `pieces`: as `lend`, in pieces of 64 B.
//! - `encode`: a typed message is encoded to its frame.
//! - `wake`: an idle machine is woken once.

use std::hint::black_box;
use std::time::Instant;

use benches::decode::{Fields, frame, ours, read};
use benches::traffic::{self, Mix, Protocol, Side};
use motion_core::machine::Machine;
use motion_core::stream::Head;
use motion_core::time::Millis;
use serde_json::Value;

/// One frame, and the side that sent it.
type Sent<'a> = (Side, &'a [u8]);

/// Runs the work of one row. The script counts the instructions between entry and return.
#[inline(never)]
fn measured(work: &mut dyn FnMut()) {
    work();
    // If the call were the last instruction, it would become a jump, and this function would not return.
    black_box(());
}

fn row(name: &str, messages: usize, mut work: impl FnMut()) {
    // The first run is not counted, because it initialises what is initialised once.
    work();
    let counts = std::env::args().nth(1).is_none_or(|arg| arg != "times");
    if counts {
        measured(&mut work);
    }
    println!("{name} {messages}");
    if counts {
        return;
    }
    for times in std::io::stdin().lines().map(|line| line.expect("a line").parse::<u32>().expect("a number")) {
        if times == 0 {
            break;
        }
        let start = Instant::now();
        for _ in 0..times {
            measured(&mut work);
        }
        println!("{}", start.elapsed().as_nanos());
    }
}

/// Defines the rows of one protocol. The three differ in whether decoding can fail, and in the values that a frame
/// needs beside its message.
macro_rules! protocol {
    ($name:ident, $protocol:ident, [$($sound:tt)*], [$($host:expr)?], [$($device:expr)?]) => {
        mod $name {
            use std::hint::black_box;

            use super::{Sent, Side, row};
            use $protocol::{DeviceMessage, Frame, Frames, HostMessage, Item};

            enum Message<'a> {
                Host(HostMessage<'a>),
                Device(DeviceMessage<'a>),
            }

            /// The only caller of the decoders, so that all rows count the same code.
            #[inline(never)]
            fn decode(side: Side, frame: &Frame<'_>) {
                match side {
                    Side::Host => { black_box(&HostMessage::decode(frame)); }
                    Side::Device => { black_box(&DeviceMessage::decode(frame)); }
                }
            }

            #[inline(never)]
            fn encode(message: &Message<'_>, out: &mut [u8]) {
                let len = match message {
                    Message::Host(message) => message.encode_into($($host,)? out),
                    Message::Device(message) => message.encode_into($($device,)? out),
                };
                black_box(len.is_ok());
            }

            /// Message of a frame, if a stream finds the frame and it can be decoded.
            fn message((side, bytes): Sent<'_>) -> Option<Message<'_>> {
                let mut frames = Box::new(<Frames>::new());
                if frames.push(bytes) < bytes.len() || !matches!(frames.next(), Some(Item::Frame(_))) {
                    return None;
                }
                let frame = Frame::decode(bytes).ok()?;
                Some(match side {
                    Side::Host => Message::Host(HostMessage::decode(&frame)$($sound)*),
                    Side::Device => Message::Device(DeviceMessage::decode(&frame)$($sound)*),
                })
            }

            /// Rows of a stream. Frames that cannot be decoded are left out.
            pub(super) fn rows(name: &str, stream: &[Sent<'_>]) {
                let (stream, messages): (Vec<Sent<'_>>, Vec<Message<'_>>) =
                    stream.iter().filter_map(|&sent| Some((sent, message(sent)?))).unzip();
                if stream.is_empty() {
                    return;
                }
                row(&format!("{name}/decode"), stream.len(), || {
                    for &(side, bytes) in &stream {
                        if let Ok(frame) = Frame::decode(bytes) {
                            decode(side, &frame);
                        }
                    }
                });
                let bytes: Vec<u8> = stream.iter().flat_map(|(_, bytes)| *bytes).copied().collect();
                let (mut frames, mut left) = (Box::new(<Frames>::new()), 0);
                row(&format!("{name}/stream"), stream.len(), || {
                    let (mut rest, mut sides) = (&bytes[..], stream.iter());
                    while !rest.is_empty() {
                        rest = &rest[frames.push(rest)..];
                        while let Some(item) = frames.next() {
                            if let (Item::Frame(frame), Some((side, _))) = (item, sides.next()) {
                                decode(*side, &frame);
                            }
                        }
                    }
                    left = sides.len();
                });
                assert_eq!(left, 0, "the stream finds every frame of {name}");
                for (way, cut) in [("lend", 65_536), ("pieces", 64)] {
                    row(&format!("{name}/{way}"), stream.len(), || {
                        let mut sides = stream.iter();
                        for mut piece in bytes.chunks(cut) {
                            while let Some(item) = frames.next_from(&mut piece) {
                                if let (Item::Frame(frame), Some((side, _))) = (item, sides.next()) {
                                    decode(*side, &frame);
                                }
                            }
                        }
                        left = sides.len();
                    });
                    assert_eq!(left, 0, "the stream finds every frame of {name}");
                }
                let mut out = vec![0; 1 << 17];
                row(&format!("{name}/encode"), messages.len(), || {
                    for message in &messages {
                        encode(message, &mut out);
                    }
                });
            }
        }
    };
}

protocol!(kos, kos_proto, [.ok()?], [], []);
protocol!(dmc, dmc_proto, [.ok()?], [dmc_proto::MessageId(77)], [dmc_proto::MessageId(77)]);
protocol!(hoot, hoot_proto, [], [hoot_proto::Address::DEFAULT], []);

fn main() {
    let each = std::env::args().nth(1).is_some_and(|arg| arg == "each");
    vectors("kos", include_str!("../vectors/kos.json"), each, kos::rows);
    vectors("dmc", include_str!("../vectors/dmc.json"), each, dmc::rows);
    vectors("hoot", include_str!("../vectors/hoot.json"), each, hoot::rows);
    if each {
        return;
    }
    mix::<kos_proto::Kos>("kos/mix", &traffic::kos(true), kos::rows);
    mix::<kos_proto::Kos>("kos/small", &traffic::kos(false), kos::rows);
    mix::<dmc_proto::Dmc>("dmc/mix", &traffic::dmc(true), dmc::rows);
    mix::<dmc_proto::Dmc>("dmc/small", &traffic::dmc(false), dmc::rows);
    mix::<hoot_proto::Hoot>("hoot/mix", &traffic::hoot(), hoot::rows);
    reads("hoot/mix/query", &traffic::hoot(), |mix| {
        read(mix, |stream, side| {
            frame::<hoot_proto::Hoot>(stream, |frame| traffic::through_query::<Fields>(side, frame))
        })
    });

    macro_rules! wakes {
        ($($name:literal: $protocol:ident $side:ident $machine:ident;)*) => {
            $(wake($name, $protocol::$side::$machine::new(Default::default()), || $protocol::$side::Input::Wake);)*
        };
    }
    wakes! {
        "kos/host/wake": kos_proto host HostMachine;
        "kos/device/wake": kos_proto device DeviceMachine;
        "dmc/host/wake": dmc_proto host HostMachine;
        "dmc/device/wake": dmc_proto device DeviceMachine;
        "hoot/host/wake": hoot_proto host HostMachine;
        "hoot/device/wake": hoot_proto device DeviceMachine;
    }
}

/// Rows of one mix.
fn mix<F: Protocol>(name: &str, mix: &Mix, rows: fn(&str, &[Sent<'_>])) {
    let mut rest = &mix.bytes[..];
    let stream: Vec<Sent<'_>> = mix
        .sides
        .iter()
        .map(|&side| {
            let Head::Total(len) = F::head(rest) else { panic!("{name} consists of frames") };
            let (frame, after) = rest.split_at(len);
            rest = after;
            (side, frame)
        })
        .collect();
    rows(name, &stream);
    reads(&format!("{name}/slice"), mix, |mix| read(mix, ours::<F, Fields>));
}

/// Row that must find all values of a mix.
fn reads(name: &str, mix: &Mix, read: fn(&Mix) -> traffic::Tally) {
    let mut tally = traffic::Tally::default();
    row(name, mix.tally.messages, || tally = read(black_box(mix)));
    assert_eq!(tally, mix.tally, "{name}");
}

/// Rows of the conformance vectors: of one stream of all vectors, or of each vector.
fn vectors(name: &str, json: &str, each: bool, rows: fn(&str, &[Sent<'_>])) {
    let vectors: Vec<Value> = serde_json::from_str(json).expect("vectors are JSON");
    let text = |vector: &Value, key: &str| vector[key].as_str().unwrap_or_default().replace(' ', "-");
    let sent: Vec<(String, Side, Vec<u8>)> = vectors
        .iter()
        .map(|vector| {
            let side = match text(vector, "direction").as_str() {
                "host" | "request" => Side::Host,
                _ => Side::Device,
            };
            let hex = text(vector, "hex");
            let byte = |at| u8::from_str_radix(&hex[at..at + 2], 16).expect("hexadecimal digits");
            (text(vector, "name"), side, (0..hex.len()).step_by(2).map(byte).collect())
        })
        .collect();
    let stream: Vec<Sent<'_>> = sent.iter().map(|(_, side, bytes)| (*side, &bytes[..])).collect();
    if each {
        for ((vector, ..), one) in sent.iter().zip(&stream) {
            rows(&format!("{name}/{vector}"), std::slice::from_ref(one));
        }
    } else {
        rows(&format!("{name}/all"), &stream);
    }
}

/// Row of a machine that is woken once a second and has nothing to do.
fn wake<M: Machine>(name: &str, machine: M, input: fn() -> M::Input<'static>) {
    let mut idle = black_box(machine);
    row(name, 100, || {
        for second in 1..=100 {
            black_box(&idle.advance(Millis(second * 1000), input()));
        }
    });
}
