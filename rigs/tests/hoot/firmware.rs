//! Conduct of firmware that the published sheet does not tell, in the nodes that are named after it.

use hoot_proto::device::ProgramState;
use motion_core::time::Millis;
use motion_rigs::device::Named;
use motion_rigs::hoot_node::{HootNode, Setup};
use motion_rigs::motor::Motor;
use motion_rigs::{LineId, Outgoing, Party, Rig};

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
        let is_active = self.node.camera().is_open() || !self.node.motors().iter().all(Motor::rests);
        assert!(!is_active || self.node.machine().may_move(), "the node knows what may move");
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

impl Bench {
    /// Enables a motor and gives it a speed.
    fn ready(&mut self, motor: u8, speed: f32) {
        self.ok(&format!("03{motor:02x}030101"));
        self.speed(motor, speed);
    }

    #[track_caller]
    fn speed(&mut self, motor: u8, speed: f32) {
        self.ok(&format!("03{motor:02x}0d04{:08x}", speed.to_bits()));
    }

    /// Sets a number of a motor.
    #[track_caller]
    fn long(&mut self, motor: u8, command: u8, number: i32) {
        self.ok(&format!("03{motor:02x}{command:02x}04{number:08x}"));
    }

    /// Moves a motor by a number of steps and waits until it rests.
    #[track_caller]
    fn go(&mut self, motor: u8, direction: u8, steps: u32) {
        self.ok(&format!("03{motor:02x}0f05{direction:02x}{steps:08x}"));
        self.rest();
    }

    fn rest(&mut self) {
        self.pass(20_000);
        assert!(self.node.motors().iter().all(Motor::rests));
    }

    fn place(&self, motor: usize) -> f64 {
        self.node.motors()[motor - 1].at(Millis(self.now)).position
    }

    /// Greatest speed of motor 1 in the next time.
    fn fastest(&mut self, millis: u64) -> f64 {
        (0..millis).fold(0.0, |most: f64, _| {
            self.pass(1);
            most.max(self.node.motors()[0].at(Millis(self.now)).velocity.abs())
        })
    }

    /// Position of a motor and number of its microsteps, as the node answers them.
    fn told(&mut self, motor: u8) -> (i32, u8) {
        let [position, microstep] = [0x6A, 0x66].map(|query| {
            let answer = self.ask(&format!("03{motor:02x}{query:02x}00"));
            i64::from_str_radix(&answer[22..], 16).unwrap()
        });
        (u32::try_from(position).unwrap().cast_signed(), u8::try_from(microstep).unwrap())
    }
}

#[test]
fn sends_go_at_full_speed_and_overwrite_the_speed_and_moves_obey_it() {
    for (device, speed) in
        [("mild", 200.0), ("2014-10-29", 200.0), ("2014-11-03", 5000.0), ("v0.33", 5000.0), ("v0.58", 5000.0)]
    {
        let mut bench = Bench::new(device);
        bench.ready(1, 200.0);
        bench.long(1, 17, 8000);
        bench.ok("03011800");
        assert!((bench.fastest(2000) - speed).abs() < 1.0, "{device} sends");
        bench.ok(STOP);
        bench.ok("03010f050000002000");
        assert!((bench.fastest(1000) - speed).abs() < 1.0, "{device} moves at the speed that was left");
        bench.ok(STOP);
        bench.speed(1, 200.0);
        bench.ok("03010f050000002000");
        assert!((bench.fastest(500) - 200.0).abs() < 1.0, "{device}: a move obeys the speed");
    }
    // The greatest speed of a motor limits sends of the last version only.
    for (device, speed) in [("v0.58", 5000.0), ("v0.70", 300.0)] {
        let mut bench = Bench::new(device);
        bench.ok("0301030101");
        bench.ok("03010702012c");
        bench.long(1, 17, 8000);
        bench.ok("03011800");
        assert!((bench.fastest(2000) - speed).abs() < 1.0, "{device}");
    }
}

#[test]
fn end_limits_hold_until_v0_47_and_make_a_limit_of_the_home() {
    for (device, ends) in [
        ("mild", [400, -600, 400]),
        ("2014-10-15", [400, 0, 400]),
        ("v0.33", [400, 0, 400]),
        ("v0.45", [400, 0, 400]),
        ("v0.49", [600, -600, 0]),
        ("v0.70", [600, -600, 0]),
    ] {
        let near = |bench: &Bench, end: i32| (bench.place(1) - f64::from(end)).abs() <= 5.0;
        let mut bench = Bench::new(device);
        bench.ready(1, 1000.0);
        bench.go(1, 1, 400);
        bench.ok("03010a00");
        bench.go(1, 0, 400);
        assert!(near(&bench, 0));
        bench.go(1, 1, 600);
        assert!(near(&bench, ends[0]), "{device}: {}", bench.place(1));
        let back = u32::try_from(ends[0]).unwrap();
        bench.go(1, 0, back);
        bench.go(1, 0, 600);
        assert!(near(&bench, ends[1]), "{device}: {}", bench.place(1));
        if ends[1] != 0 {
            bench.go(1, 1, 600);
        }
        bench.ok("03010c00");
        bench.rest();
        assert!(near(&bench, ends[2]), "{device}: {} by command 12", bench.place(1));
    }
}

#[test]
fn in_joystick_mode_firmware_starts_motors_by_their_speed() {
    for (device, answer, starts) in [
        ("mild", OK, false),
        ("sheet", OK, false),
        ("2014-11-03", OK, true),
        ("2014-12-03", "", true),
        ("v0.33", "", true),
        ("v0.70", "", true),
    ] {
        let mut bench = Bench::new(device);
        bench.ready(1, 1000.0);
        bench.ok("0300170101");
        assert_eq!(bench.ask("03010d0443960000"), answer, "{device}");
        bench.pass(500);
        assert_eq!(bench.place(1).abs() > 50.0, starts, "{device}: {}", bench.place(1));
        assert_eq!(bench.ask("03010d0400000000"), answer, "{device}");
        bench.rest();
        if starts {
            bench.ask("03010d04c3960000");
            let place = bench.place(1);
            bench.pass(500);
            assert!(bench.place(1) < place - 50.0, "{device}: the other way");
        }
    }
    // A run that was going ends when joystick mode begins.
    for (device, goes_on) in [("mild", true), ("sheet", true), ("2014-11-03", false), ("v0.70", false)] {
        let mut bench = Bench::new(device);
        bench.ready(1, 1000.0);
        bench.ok("03010f050100000000");
        bench.pass(500);
        bench.ok("0300170101");
        bench.pass(1000);
        assert_eq!(!bench.node.motors()[0].rests(), goes_on, "{device}");
    }
}

#[test]
fn sends_of_later_firmware_switch_to_quarter_steps() {
    for (device, told) in [
        ("mild", (300, 4)),
        ("2014-10-29", (300, 4)),
        ("v0.33", (75, 4)),
        ("v0.35", (75, 4)),
        ("v0.45", (300, 16)),
        ("v0.70", (300, 16)),
    ] {
        let mut bench = Bench::new(device);
        bench.ready(2, 1000.0);
        bench.long(2, 17, 300);
        bench.ok("03021800");
        bench.rest();
        assert_eq!(bench.told(2), told, "{device}");
    }
}

#[test]
fn a_start_of_later_firmware_chooses_the_microsteps() {
    for (device, told) in [
        ("mild", (1800, 4)),
        ("sheet", (1800, 4)),
        ("2014-12-03", (7200, 16)),
        ("v0.33", (7200, 16)),
        ("v0.70", (7200, 16)),
    ] {
        let mut bench = Bench::new(device);
        bench.ready(1, 1000.0);
        bench.ok("0300160102");
        bench.long(1, 17, 1800);
        bench.long(1, 20, 4000);
        bench.send(&[START]);
        bench.rest();
        assert_eq!(bench.told(1), told, "{device}");
    }
}

#[test]
fn directions_of_firmware_are_not_inverted() {
    for (device, moved, ran) in [("mild", -400.0, -1.0), ("2014-10-15", 400.0, 1.0), ("v0.70", 400.0, 1.0)] {
        let mut bench = Bench::new(device);
        bench.ready(1, 1000.0);
        bench.ok("0301080101");
        bench.go(1, 1, 400);
        assert!((bench.place(1) - moved).abs() < 1.0, "{device}: {}", bench.place(1));
        if device == "2014-10-15" {
            continue;
        }
        bench.ok("0301080100");
        let place = bench.place(1);
        bench.speed(1, -300.0);
        bench.ok("03010f050100000000");
        bench.pass(700);
        assert!((bench.place(1) - place) * ran > 100.0, "{device}: {}", bench.place(1) - place);
    }
}

#[test]
fn firmware_takes_a_picture_on_command_also_without_a_camera_and_the_first_firmware_takes_none() {
    for (device, photos) in [("mild", 0), ("2014-10-15", 0), ("2014-10-17", 1), ("2014-10-29", 1), ("v0.70", 1)] {
        let mut bench = Bench::new(device);
        bench.ok("0304050203e8");
        bench.ok("03040300");
        assert_eq!(bench.node.camera().is_open(), photos == 1, "{device}: no focus first");
        bench.pass(500);
        assert_eq!(bench.node.camera().taken(), photos, "{device}");
    }
}

#[test]
fn later_firmware_keeps_the_last_run_time() {
    for (device, keeps) in [("mild", false), ("2014-11-17", false), ("2014-12-03", true), ("v0.70", true)] {
        let mut bench = Bench::new(device);
        bench.ready(1, 1000.0);
        bench.ok("0300160102");
        bench.long(1, 17, 400);
        bench.long(1, 20, 1000);
        bench.send(&[START]);
        bench.rest();
        assert!(bench.ask(STATUS).ends_with("020000"), "{device}: over");
        assert_eq!(bench.ask("03006600").ends_with("00000000"), !keeps, "{device}");
    }
}

#[test]
fn after_a_pause_older_firmware_does_not_go_on_in_video_mode() {
    for (device, goes_on) in
        [("mild", true), ("2014-10-15", false), ("2014-12-03", false), ("2014-12-15", true), ("v0.70", true)]
    {
        let mut bench = Bench::new(device);
        bench.ready(1, 1000.0);
        bench.ok("0300160102");
        bench.long(1, 17, 400);
        bench.long(1, 20, 4000);
        bench.send(&[START]);
        bench.pass(3000);
        bench.ok("03000300");
        let place = bench.place(1);
        bench.pass(100);
        bench.ask(START);
        bench.pass(20_000);
        assert_eq!((bench.place(1) - place).abs() > 1.0, goes_on, "{device}");
    }
}

#[test]
fn older_firmware_takes_up_a_backlash_at_each_change_of_direction() {
    for (device, backlash) in [("mild", 0), ("2014-10-15", 384), ("2014-12-03", 384), ("2014-12-16", 0), ("v0.70", 0)] {
        let mut bench = Bench::new(device);
        bench.ready(1, 1000.0);
        // The first motion downwards takes up nothing, because motors count as having gone down.
        for (direction, steps, from, to) in
            [(0, 100, 0, -100), (1, 500, -100 - backlash, 400), (0, 400, 400 + backlash, 0)]
        {
            bench.ok(&format!("03010f05{direction:02x}{steps:08x}"));
            let told = bench.told(1).0;
            assert!((told - from).abs() < 40, "{device}: {told} at the start, not {from}");
            bench.rest();
            assert_eq!(bench.told(1).0, to, "{device}");
        }
    }
    // The setting counts in every version.
    let mut bench = Bench::new("v0.70");
    bench.ready(1, 1000.0);
    bench.ok("030105020064");
    bench.ok("03010f0501000001f4");
    assert!((bench.told(1).0 + 100).abs() < 40);
    bench.rest();
    assert_eq!(bench.told(1).0, 500);
}

#[test]
fn a_plan_without_stops_takes_up_the_backlash_within_its_time() {
    for (device, microsteps) in [("2014-10-29", 4), ("2014-12-03", 16)] {
        let mut bench = Bench::new(device);
        bench.ready(1, 1000.0);
        // The home is a limit, but not while the backlash is taken up.
        bench.go(1, 1, 2000);
        bench.ok("03010a00");
        bench.go(1, 0, 2000);
        bench.ok("0300160102");
        bench.long(1, 17, 1800);
        bench.long(1, 20, 4000);
        bench.ok(START);
        let (place, found) = bench.told(1);
        assert_eq!((found, place < -350 * i32::from(microsteps) / 4), (microsteps, true), "{device}: {place}");
        bench.pass(4100);
        assert_eq!(bench.told(1).0, 1800 * i32::from(microsteps) / 4, "{device}");
    }
}

impl Bench {
    /// Runs a program with a camera, an exposure of 0.1 s and an interval of 1 s. Returns the number of photos.
    fn photos(&mut self, mode: u8, max_shots: u8, travel: i32) -> u64 {
        self.ready(1, 5000.0);
        self.ok(&format!("03001601{mode:02x}"));
        for (command, number) in [(16, 0), (17, 400), (20, travel)] {
            self.long(1, command, number);
        }
        for set in ["0304020101", "03040404 00000064", "03040a04000003e8"] {
            self.ok(&set.replace(' ', ""));
        }
        self.ok(&format!("0304060200{max_shots:02x}"));
        self.send(&[START]);
        self.pass(30_000);
        let photos = self.node.camera().taken();
        self.ok(STOP);
        photos
    }
}

#[test]
fn a_program_of_later_firmware_takes_one_photo_more() {
    for (device, photos) in
        [("mild", 5), ("2014-10-15", 5), ("2014-12-11", 5), ("2014-12-12", 6), ("v0.33", 6), ("v0.70", 6)]
    {
        assert_eq!(Bench::new(device).photos(0, 5, 4), photos, "{device}");
    }
}

#[test]
fn firmware_stops_for_photos_at_its_own_places() {
    for (device, places) in [("mild", [281, 899, 1518, 1800]), ("v0.45", [315, 900, 1485, 1800])] {
        let mut bench = Bench::new(device);
        bench.ok("0301120103");
        bench.ready(1, 5000.0);
        for (command, number) in [(17, 1800), (20, 4), (21, 2), (22, 2)] {
            bench.long(1, command, number);
        }
        for set in ["0304020101", "030404040000000a", "03040a0400001388", "030406020004"] {
            bench.ok(set);
        }
        bench.send(&[START]);
        bench.pass(3000);
        for place in places {
            bench.pass(1000);
            assert_eq!(bench.told(1).0, place, "{device}");
            bench.pass(3960);
        }
    }
}

#[test]
fn a_time_lapse_of_later_firmware_ends_with_its_motors() {
    for (device, short, long) in [
        ("mild", 5, 5),
        ("2014-12-03", 5, 5),
        ("v0.20", 6, 6),
        ("v0.25", 2, 6),
        ("v0.33", 2, 6),
        ("v0.41", 2, 9),
        ("v0.70", 2, 9),
    ] {
        assert_eq!(Bench::new(device).photos(1, 5, 500), short, "{device}");
        assert_eq!(Bench::new(device).photos(1, 5, 7500), long, "{device}");
    }
}

#[test]
fn a_video_of_later_firmware_opens_the_shutter_without_a_camera_unless_the_exposure_is_0() {
    for (device, photos) in [("mild", 0), ("2014-11-03", 0), ("2014-12-03", 1), ("v0.20", 2), ("v0.70", 2)] {
        for exposure in [120, 0] {
            let mut bench = Bench::new(device);
            bench.ready(1, 1000.0);
            bench.ok("0300160102");
            bench.ok(&format!("03040404{exposure:08x}"));
            bench.long(1, 17, 400);
            bench.long(1, 20, 1000);
            bench.send(&[START]);
            bench.rest();
            let expected = if exposure == 0 { 0 } else { photos };
            assert_eq!(bench.node.camera().taken(), expected, "{device}");
        }
    }
}

#[test]
fn a_program_without_stops_sends_motors_without_travel_or_never_ends() {
    for (device, place, ends) in [
        ("mild", 320.0, true),
        ("2014-10-29", 0.0, true),
        ("v0.33", 0.0, true),
        ("v0.45", 320.0, false),
        ("v0.70", 320.0, false),
    ] {
        let mut bench = Bench::new(device);
        bench.ready(2, 1000.0);
        bench.go(2, 1, 320);
        bench.ready(1, 1000.0);
        bench.ok("0300160102");
        bench.long(1, 17, 400);
        bench.long(1, 20, 1000);
        bench.send(&[START]);
        bench.rest();
        assert_eq!(bench.node.machine().program().state() == ProgramState::Stopped, ends, "{device}");
        assert!((bench.place(2) - place).abs() < 1.0, "{device}: {}", bench.place(2));
    }
}

#[test]
fn a_video_with_a_lead_in_never_begins_on_some_firmware() {
    for (device, begins) in
        [("mild", true), ("2014-11-06", true), ("2014-11-07", false), ("v0.24", false), ("v0.25", true)]
    {
        for lead_in in [0, 500] {
            let mut bench = Bench::new(device);
            bench.ready(1, 1000.0);
            bench.ok("0300160102");
            bench.ok(&format!("03011302{lead_in:04x}"));
            bench.long(1, 17, 400);
            bench.long(1, 20, 1000);
            bench.send(&[START]);
            bench.rest();
            assert_eq!(bench.place(1) > 1.0, begins || lead_in == 0, "{device}, {lead_in}");
        }
    }
}

impl Bench {
    /// Sets a lead-in, which has 32 bits from v0.35 on.
    fn lead_in(&mut self, motor: u8, lead_in: u16) {
        let is_long = self.ask("03006400").ends_with("050400000046");
        let data = if is_long { format!("04{lead_in:08x}") } else { format!("02{lead_in:04x}") };
        self.ok(&format!("03{motor:02x}13{data}"));
    }
}

#[test]
fn the_lead_in_of_a_time_lapse_is_in_photos_and_later_only_the_least_one() {
    // Motor 1 has a lead-in of 2, and begins after the third photo, or at once if motor 2 is enabled and has none.
    for (device, other, begins) in [
        ("mild", 0, 2100),
        ("2014-10-29", 0, 2100),
        ("v0.33", 0, 100),
        ("v0.70", 0, 100),
        ("v0.33", 2, 2100),
        ("v0.70", 2, 2100),
    ] {
        let mut bench = Bench::new(device);
        for motor in 2..=3 {
            bench.ok(&format!("03{motor:02x}030101"));
            bench.lead_in(motor, other);
        }
        bench.lead_in(1, 2);
        bench.ready(1, 5000.0);
        bench.ok("0300160101");
        bench.long(1, 17, 4000);
        bench.long(1, 20, 4000);
        for set in ["0304020101", "030404040000000a", "03040a04000003e8", "030406020009"] {
            bench.ok(set);
        }
        bench.send(&[START]);
        bench.pass(if device.starts_with('v') { 1500 } else { 0 });
        bench.pass(begins - 100);
        assert!(bench.place(1) <= 0.0, "{device}, {other}: {}", bench.place(1));
        bench.pass(1000);
        assert!(bench.place(1) > 100.0, "{device}, {other}: {}", bench.place(1));
    }
}
