//! Link of a node: hoot, section 4.1.

use super::world::*;
use hoot_proto::device::{Answer, Contents, Event, Ignored, Input, Options, Part, Port, Quirks, Transmit};
use hoot_proto::frame;
use hoot_proto::message::{self, HostMessage, Motor, StepCount};
use hoot_proto::query::Profile;
use hoot_proto::{Address, Frame, Item, Strict};
use motion_core::stream::Frames;
use motion_core::wire::Messages;

/// Gives bytes to a node: packets as messages, and everything else as noise.
fn feed(node: &mut Node, frames: &mut Frames<Strict, 84>, bytes: &[u8]) -> Vec<Vec<u8>> {
    assert_eq!(frames.push(bytes), bytes.len());
    drain(node, frames)
}

fn drain(node: &mut Node, frames: &mut Frames<Strict, 84>) -> Vec<Vec<u8>> {
    let mut replies = Vec::new();
    while let Some(item) = frames.next() {
        let output = match item {
            Item::Frame(frame) => node.step(Input::received(Port::Bus, &frame)),
            _ => node.step(Input::Noise),
        };
        for packet in output.transmits() {
            let mut out = [0; 42];
            let len = packet.encode_into(&mut out).unwrap();
            replies.push(out[..len].to_vec());
        }
    }
    replies
}

fn packet(sub_address: u8, command: u8, data: &[u8]) -> Vec<u8> {
    let mut out = [0; 42];
    let len = frame::encode(NODE, sub_address, command, data, &mut out).unwrap();
    out[..len].to_vec()
}

const OK: [u8; 10] = [0, 0, 0, 0, 0, 255, 0, 0, 1, 0];

// 4.1-1 4.1-2 4.1-3
#[test]
fn ten_bytes_are_a_request_without_data() {
    let (mut node, mut frames) = (Node::ready(), Frames::<Strict, 84>::new());
    let bytes = packet(0, 4, &[]);
    for byte in &bytes[..9] {
        assert!(feed(&mut node, &mut frames, &[*byte]).is_empty());
    }
    assert_eq!(feed(&mut node, &mut frames, &bytes[9..]), [OK]);
}

// 4.1-4 4.1-5
#[test]
fn data_is_read_by_its_length_up_to_32_bytes() {
    let (mut node, mut frames) = (Node::ready(), Frames::<Strict, 84>::new());
    let bytes = packet(2, 16, &[0xFF, 0xFF, 0xF8, 0x30]);
    for byte in &bytes[..13] {
        assert!(feed(&mut node, &mut frames, &[*byte]).is_empty());
    }
    assert_eq!(feed(&mut node, &mut frames, &bytes[13..]), [OK]);
    assert_eq!(node.machine.motor(Motor::Two).settings().plan.start.0, -2000);

    let mut long = packet(0, 4, &[]);
    long[9] = 33;
    long.extend([0; 33]);
    assert!(feed(&mut node, &mut frames, &long).is_empty());
    assert_eq!(feed(&mut node, &mut frames, &packet(0, 4, &[])), [OK], "as many bytes were dropped as were claimed");
}

// 4.1-6
#[test]
fn a_silence_inside_a_packet_drops_it() {
    let (mut node, mut frames) = (Node::ready(), Frames::<Strict, 84>::new());
    let bytes = packet(1, 15, &[1, 0, 0, 0, 9]);
    assert!(feed(&mut node, &mut frames, &bytes[..12]).is_empty());
    frames.gap();
    assert!(drain(&mut node, &mut frames).is_empty());
    assert!(!node.running(Motor::One), "the bytes that follow do not complete it");
    assert!(feed(&mut node, &mut frames, &bytes[12..]).is_empty());
    frames.gap();
    assert!(drain(&mut node, &mut frames).is_empty() && !node.running(Motor::One));
}

// 4.1-7
#[test]
fn a_wrong_break_costs_the_packet_and_is_not_answered() {
    let (mut node, mut frames) = (Node::ready(), Frames::<Strict, 84>::new());
    let mut bytes = packet(0, 4, &[]);
    bytes[5] = 0xFE;
    assert!(feed(&mut node, &mut frames, &bytes).is_empty());
    assert_eq!(node.tell(Input::Noise), [Event::Noise]);
    assert_eq!(feed(&mut node, &mut frames, &packet(0, 4, &[])), [OK]);
}

// 4.1-8
#[test]
fn command_0_is_not_answered() {
    let mut node = Node::ready();
    for to in [NODE, Address(9), Address::BROADCAST, Address::MASTER] {
        let noop = HostMessage::from(message::Noop::default());
        let output = node.send(to, noop);
        assert_eq!((output.packets().len(), output.event_list()), (0, vec![ignored(to, noop, Ignored::Noop)]), "{to}");
    }
    // The same with data, and as a broadcast, whose table does not have this command.
    for number in [0x00_03, 0x1_00_00] {
        let noop = HostMessage::other(number, &[1]);
        let output = node.send(NODE, noop);
        assert_eq!((output.packets().len(), output.event_list()), (0, vec![ignored(NODE, noop, Ignored::Noop)]));
    }
}

// 4.1-9
#[test]
fn broadcasts_are_done_and_never_answered() {
    let sub_address = message::AnySubAddress(9);
    let start = HostMessage::from(message::BroadcastStart { sub_address });
    let stop = HostMessage::from(message::BroadcastStop { sub_address });
    let pause = HostMessage::from(message::BroadcastPause { sub_address });
    let mut node = Node::ready();
    node.ok(run(Motor::One));
    let output = node.send(Address::BROADCAST, pause);
    assert_eq!(output.event_list()[..], [motion(Motor::One, hoot_proto::device::Motion::Stop)]);
    assert!(output.packets().is_empty());
    for message in [start, stop] {
        assert!(node.send(Address::BROADCAST, message).packets().is_empty());
    }
    // An unknown broadcast, an address that no node can have, and the number of a command to a node.
    let new_address = Address(1);
    let assign = HostMessage::from(message::BroadcastAssignAddress { sub_address, new_address });
    for message in [HostMessage::other(0x1_09_00, &[]), assign, STOP] {
        let output = node.send(Address::BROADCAST, message);
        let wanted = [ignored(Address::BROADCAST, message, Ignored::Broadcast)];
        assert_eq!(output.event_list(), wanted, "{message:?}");
        assert!(output.packets().is_empty());
    }
}

// 4.1-10
#[test]
fn packets_for_others_are_forwarded() {
    let mut node = Node::ready();
    for (from, to, beyond) in [
        (Port::Bus, Address::MASTER, &[Port::Usb, Port::Bluetooth][..]),
        (Port::Usb, Address(7), &[Port::Bus]),
        (Port::Bluetooth, Address(7), &[Port::Bus]),
    ] {
        let output = node.step(Input::Received { port: from, to, message: START });
        let contents = Contents::Forward { to, message: START };
        let wanted: Vec<_> = beyond.iter().map(|port| Transmit { port: *port, contents }).collect();
        assert_eq!((output.packets(), output.event_list()), (wanted, vec![]));
    }
    assert_eq!(node.machine.program().run_time(motion_core::time::Millis(9999)), 0, "nothing was started");
    // Requests and replies are forwarded byte for byte, with any contents.
    for (address, data) in [(9, &[1, 2, 3][..]), (0, &[5, 0, 0, 4, 0xCD]), (0, &[]), (255, &[0; 32])] {
        for command in 1..=255 {
            let mut bytes = [0; 42];
            let len = frame::encode(Address(address), 7, command, data, &mut bytes).unwrap();
            let output = node.step(Input::received(Port::Usb, &Frame::decode(&bytes[..len]).unwrap()));
            let mut again = [0; 42];
            let [packet] = output.packets()[..] else { panic!("{output:?}") };
            assert_eq!((packet.port, packet.encode_into(&mut again)), (Port::Bus, Ok(len)));
            assert_eq!(again, bytes);
        }
    }
}

// 4.1-11
#[test]
fn the_core_protocol_answers_for_any_part() {
    for part in [0, 2, 9] {
        let mut node = Node::ready();
        let sub_address = message::AnySubAddress(part);
        let version = message::CoreProtocolVersion { sub_address };
        assert_eq!(node.ask(HostMessage::from(version)), [1, 0, 1]);
        assert_eq!(node.ask(HostMessage::from(message::CoreDeviceId { sub_address })), b"\x06OMAXISVX");
        let version = message::CoreDeviceVersion { sub_address };
        assert_eq!(node.ask(HostMessage::from(version)), [1, 0, 6]);
        node.refused(HostMessage::other(u32::from(part) | 0x01_00, &[]));
        node.refused(HostMessage::other(u32::from(part) | 0x2_09_00, &[]));
        let assign = |to| HostMessage::from(message::CoreAssignAddress { sub_address, new_address: Address(to) });
        node.refused(assign(1));
        assert_eq!(node.ok(assign(9)), [Event::Address(Address(9))]);
        assert_eq!(node.machine.address(Port::Bus), Address(9));
    }
    // Joystick mode does not concern the core protocol.
    let mut node = Node::ready();
    node.ok(joystick(YES));
    let sub_address = message::AnySubAddress(0);
    assert_eq!(node.ask(HostMessage::from(message::CoreProtocolVersion { sub_address })), [1, 0, 1]);
}

/// Whether a request of each number is refused, without the numbers that begin something else.
fn refused_numbers(node: &Node, sub_address: u32) -> Vec<u32> {
    let is_refused = |number: &u32| {
        let id = number << 8 | sub_address;
        let (answers, _) = node.clone().request(HostMessage::other(id, &[0; 8]));
        answers.first().copied() == Some(Answer::Error)
    };
    (2..=121).filter(is_refused).collect()
}

// 4.1-12
#[test]
fn in_joystick_mode_the_controller_accepts_stops_and_little_else() {
    let mut node = Node::ready();
    node.ok(run(Motor::One));
    node.ok(joystick(YES));
    let left: Vec<u32> = (2..=121).filter(|number| !refused_numbers(&node, 0).contains(number)).collect();
    assert_eq!(left, [4, 23, 120]);
    assert_eq!(node.ok(STOP), [motion(Motor::One, hoot_proto::device::Motion::Stop)]);

    let firmware = Options::default().with_quirks(Quirks::FIRMWARE);
    let mut node = Node::ready_with(firmware);
    node.ok(joystick(YES));
    node.refused(STOP);
}

// 4.1-13
#[test]
fn in_joystick_mode_motors_accept_what_a_joystick_needs() {
    let mut node = Node::ready();
    node.ok(joystick(YES));
    let left: Vec<u32> = (2..=121).filter(|number| !refused_numbers(&node, 2).contains(number)).collect();
    assert_eq!(left, [3, 4, 6, 13, 15]);

    let mut node = Node::ready_with(Options::default().with_profile(Profile::V070));
    node.ok(joystick(YES));
    node.refused(move_by(Motor::Two, 9));
    assert!(!node.running(Motor::Two));
    // Later firmware does not answer speeds of a joystick.
    let (answers, events) = node.request(speed(Motor::Two, 9.0));
    assert_eq!((answers, events), (vec![], vec![ignored(NODE, speed(Motor::Two, 9.0), Ignored::Silent)]));
    assert!((node.machine.motor(Motor::Two).settings().speed.0 - 9.0).abs() < 0.1);
}

// 4.1-14
#[test]
fn joystick_mode_does_not_concern_the_camera() {
    let mut node = Node::ready();
    node.ok(HostMessage::from(message::CameraSetEnable { enable: YES }));
    node.ok(joystick(YES));
    assert_eq!(node.ok(HostMessage::from(message::CameraExpose {})), [camera(false, true)]);
}

// 4.1-15
#[test]
fn sub_addresses_above_4_are_refused() {
    for sub_address in [5, 9, 255] {
        Node::ready().refused(HostMessage::other(0x04_00 | sub_address, &[]));
    }
}

// 4.1-16 4.1-19
#[test]
fn other_commands_are_done_refused_or_not_answered() {
    let mut node = Node::ready();
    assert_eq!(node.request(PAUSE), (vec![Answer::Ok], vec![]));
    assert_eq!(node.ask(HostMessage::from(message::FirmwareVersion {})), [0, 6]);
    let unknown = [0x19_00, 0x7A_00, 0x1C_01, 0x0B_04];
    for number in unknown {
        node.refused(HostMessage::other(number, &[]));
    }
    let mut later = Node::new(Options::default().with_profile(Profile::V033));
    for number in unknown {
        let message = HostMessage::other(number, &[]);
        let silent = (vec![], vec![ignored(NODE, message, Ignored::Unknown)]);
        assert_eq!(later.request(message), silent, "{number:x}");
    }
    later.refused(HostMessage::other(0x04_05, &[]));
}

// 4.1-17
#[test]
fn commands_refresh_the_dead_man_even_when_refused() {
    let mut node = Node::ready();
    node.ok(HostMessage::from(message::SetManualMove { manual_move: YES }));
    node.ok(run(Motor::One));
    node.ok(joystick(YES));
    let noop = HostMessage::from(message::Noop::default());
    let core = HostMessage::from(message::CoreDeviceId::default());
    let broadcast = HostMessage::other(0x1_09_00, &[]);
    for (message, to, refreshes) in [
        (PAUSE, NODE, true),
        (HostMessage::other(0x77_04, &[]), NODE, true),
        (noop, NODE, false),
        (core, NODE, false),
        (broadcast, Address::BROADCAST, false),
        (START, Address(9), false),
    ] {
        let mut node = node.clone();
        node.pass(900);
        let _ = node.send(to, message);
        let stops = node.pass(200);
        assert_eq!(stops.is_empty(), refreshes, "{message:?}: {stops:?}");
    }
}

// 4.1-18
#[test]
fn missing_bytes_are_zero_and_surplus_bytes_are_ignored() {
    let mut node = Node::ready();
    // The greatest run time of two bytes; a firmware version with data.
    assert_eq!(node.ok(HostMessage::other(0x14_00, &[0, 2])), []);
    assert_eq!(node.machine.controller().max_run_time.0, 0x0002_0000);
    assert_eq!(node.ask(HostMessage::other(0x64_00, &[7, 7])), [0, 6]);
    assert_eq!(node.ok(HostMessage::other(0x07_00, b"eleven bytes")), []);
    assert_eq!(node.machine.name().0, *b"eleven byt");
    assert_eq!(node.ok(HostMessage::other(0x07_00, b"")), []);
    assert_eq!(node.machine.name().0, [0; 10]);
    // A move with missing bytes is not a run (decision H-1).
    node.refused(HostMessage::other(0x0F_01, &[1, 0]));
    let firmware = Options::default().with_quirks(Quirks::FIRMWARE);
    let mut node = Node::ready_with(firmware);
    // The backlash is taken up, and then the motor runs.
    assert_eq!(node.ok(HostMessage::other(0x0F_01, &[1, 0])).len(), 2);
    assert_eq!(node.machine.motor(Motor::One).state().name(), "Continuous");
}

// 4.1-20
#[test]
fn a_new_address_is_used_at_once_but_on_usb_after_power_up() {
    let set = |to| HostMessage::from(message::SetAddress { new_address: Address(to) });
    let mut node = Node::ready();
    node.refused(set(1));
    assert_eq!(node.ok(set(9)), [Event::Address(Address(9))]);
    let addresses = |node: &Node| [Port::Bus, Port::Bluetooth, Port::Usb].map(|port| node.machine.address(port).0);
    assert_eq!(addresses(&node), [9, 9, 3]);
    assert_eq!(node.tell(Input::Command(hoot_proto::device::Command::PowerUp)), []);
    assert_eq!(addresses(&node), [9, 9, 9]);

    // Firmware does nothing else for a while (decision H-2).
    let broadcast = message::BroadcastAssignAddress { new_address: Address(9), ..Default::default() };
    let times = |node: &Node, to, message| {
        let blocking = node.machine.blocking(Port::Usb, to, &message);
        (blocking.before, blocking.after)
    };
    let firmware = Node::ready_with(Options::default().with_quirks(Quirks::FIRMWARE));
    for (node, after) in [(&node, [0, 0]), (&firmware, [1000, 2500])] {
        let own = node.machine.address(Port::Usb);
        assert_eq!(times(node, own, set(7)), (0, after[0]));
        assert_eq!(times(node, Address::BROADCAST, broadcast.into()), (0, after[1]));
        assert_eq!(times(node, Address(77), set(7)), (0, 0), "for another node");
        assert_eq!(times(node, own, set(1)), (0, 0), "refused");
    }
}

// 4.1-24
#[test]
fn a_start_of_later_firmware_blocks_it_first() {
    let node = |profile: &str, quirks| {
        Node::ready_with(Options::default().with_profile(profile.parse().unwrap()).with_quirks(quirks))
    };
    let before = |node: &Node| node.machine.blocking(Port::Usb, NODE, &START).before;
    assert_eq!(before(&node("v0.70", Quirks::NONE)), 0);
    let firmware = ["2014-10-15", "v0.20", "v0.33", "v0.70"].map(|profile| node(profile, Quirks::FIRMWARE));
    assert_eq!(firmware.map(|node| before(&node)), [0, 1500, 1500, 1500]);
    let mut node = node("v0.70", Quirks::FIRMWARE);
    let broadcast = HostMessage::from(message::BroadcastStart::default());
    assert_eq!(node.machine.blocking(Port::Usb, Address::BROADCAST, &broadcast).before, 0);
    node.ok(HostMessage::from(message::CameraSetEnable { enable: YES }));
    node.ok(START);
    assert_eq!(before(&node), 0, "it runs already, or goes on");
}

// 4.1-21
#[test]
fn numbers_whose_top_byte_would_be_lost_are_refused() {
    let max_run_time = message::Milliseconds(0x0100_0000);
    let limit = HostMessage::from(message::SetMaxRunTime { max_run_time });
    let mut node = Node::ready();
    node.refused(limit);
    node.refused(move_by(Motor::One, StepCount::MAX.0 + 1));
    let (answers, events) = node.request(move_by(Motor::One, StepCount::MAX.0));
    assert_eq!((answers, events.len()), (vec![Answer::Ok], 1));

    let mut firmware = Node::ready_with(Options::default().with_quirks(Quirks::FIRMWARE));
    assert_eq!(firmware.request(limit), (vec![Answer::Ok], vec![Event::Set(Part::Controller)]));
    assert_eq!(firmware.machine.controller().max_run_time.0, 0);
    firmware.ok(move_by(Motor::One, StepCount::MAX.0 + 1));
    assert_eq!(firmware.machine.motor(Motor::One).state().name(), "Continuous");
}

// 4.1-22
#[test]
fn some_requests_are_answered_twice_by_firmware() {
    let line = HostMessage::from(message::SetCommonLine { common_line: message::CommonLine(3) });
    let easing = message::MotorSetEasing { motor: Motor::One, easing: message::Easing(4) };
    let running = HostMessage::from(message::MotorRunning { motor: Motor::One });
    let (mut node, mut firmware) = (Node::ready(), Node::ready_with(Options::default().with_quirks(Quirks::FIRMWARE)));
    for message in [line, HostMessage::from(easing)] {
        node.refused(message);
        assert_eq!(firmware.request(message).0, [Answer::Error, Answer::Ok]);
    }
    assert_eq!(node.request(running).0.len(), 1);
    let (answers, _) = firmware.request(running);
    assert_eq!(value(&answers[0]), message::Value::Int(0));
    assert_eq!(value(&answers[1]), message::Value::Float(motion_core::fixed::Scaled(0)));
    firmware.ok(joystick(YES));
    assert_eq!(firmware.request(running).0, [Answer::Error], "but refused once");
}

// 4.1-23
#[test]
fn a_link_that_goes_down_stops_nothing() {
    let mut node = Node::ready();
    node.ok(run(Motor::One));
    for input in [Input::LinkDown(Port::Usb), Input::LinkUp(Port::Usb)] {
        assert_eq!(node.tell(input), []);
    }
    assert!(node.running(Motor::One));
}

#[test]
fn the_input_of_a_frame_is_the_input_of_its_message() {
    let bytes = packet(1, 15, &[1, 0, 0, 0, 0]);
    assert_eq!(HostMessage::decode(&Frame::decode(&bytes).unwrap()).name(), "MotorRun");
}
