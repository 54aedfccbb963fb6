//! Ten thousand messages a second, with faults on: what the device acknowledges is done, and memory stays flat.

use std::collections::VecDeque;

use kos_proto::message::{
    LEDStatus, LedMode, MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds,
    SetPositionSpeedAcceleration, SoftwareID, TakePicture,
};
use kos_proto::{DeviceMessage, Frames, HostMessage, Item};
use motion_core::time::Millis;
use motion_core::wire::Empty;
use rigs::faults::{Carrier, Faults};
use rigs::kos_device::{KosDevice, Setup};
use rigs::{Host, LineId, Outgoing, Party, Rig as _, Scene};

/// Bytes that may be on their way, or held by the device: what is sent and answered in the longest silence, a second and
/// a half of 100 bytes a millisecond each way.
const HELD: usize = 300_000;

/// What a question that is not answered yet will tell, if all that was sent before it was done.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Expected {
    Platform(u8),
    Lamps(LedMode, LedMode),
    Device,
}

/// A client that sends ten messages a millisecond, without waiting for anything.
struct Flood {
    is_open: bool,
    frames: Frames,
    next: Option<Millis>,
    outgoing: VecDeque<Outgoing>,
    /// What this connection owes, and photos that were sent before each.
    owed: VecDeque<(Expected, u64)>,
    sent: u64,
    answered: u64,
    /// Photos that were asked for, and those of them that are known to be taken; on this connection, on all of them.
    photos: [u64; 2],
    taken: [u64; 2],
    lines: u64,
}

impl Flood {
    fn new() -> Self {
        Self {
            is_open: false,
            frames: Frames::new(),
            next: Some(Millis(1000)),
            outgoing: VecDeque::new(),
            owed: VecDeque::new(),
            sent: 0,
            answered: 0,
            photos: [0; 2],
            taken: [0; 2],
            lines: 0,
        }
    }

    fn batch(&mut self, now: Millis) -> Vec<u8> {
        let (tail, empty) = (&[][..], Empty { tail: &[] });
        let [platform, .., lamp] = now.0.to_le_bytes();
        let lamps = [LedMode::OFF, LedMode::ON][usize::from((platform ^ lamp) & 1)];
        let mut bytes = Vec::new();
        for number in 0..10_u8 {
            let motor = MotorAddress(1 + number % 3);
            let expected = match number {
                2 | 7 => Some(Expected::Platform(platform.wrapping_add(number))),
                4 => Some(Expected::Lamps(lamps, LedMode::OFF)),
                9 => Some(Expected::Device),
                _ => None,
            };
            let message = match number {
                0 => HostMessage::SetSoftwareID(SoftwareID { platform: platform.wrapping_add(2), tail }),
                6 => HostMessage::SetSoftwareID(SoftwareID { platform: platform.wrapping_add(7), tail }),
                2 | 7 => HostMessage::GetSoftwareID(empty),
                1 => HostMessage::SetLEDStatus(LEDStatus { master_status: lamps, slave_status: LedMode::OFF, tail }),
                4 => HostMessage::GetLEDStatus(empty),
                9 => HostMessage::GetDeviceInfo(empty),
                3 if now.0.is_multiple_of(50) => HostMessage::TakePicture(TakePicture {
                    motor_address: MotorAddress::ALL,
                    exposure: Seconds(0.01),
                    tail,
                }),
                5 | 8 => HostMessage::SetPositionSpeedAcceleration(SetPositionSpeedAcceleration::move_to(
                    motor,
                    Rotations(f32::from(platform) / 10.0),
                    RotationsPerSecond(20.0),
                    RotationsPerSecondSquared(50.0),
                )),
                _ => HostMessage::KeepAlive(empty),
            };
            if let HostMessage::TakePicture(_) = message {
                self.photos[0] += 1;
                self.photos[1] += 1;
            }
            self.owed.extend(expected.map(|expected| (expected, self.photos[0])));
            let at = bytes.len();
            bytes.resize(at + message.encoded_len(), 0);
            message.encode_into(&mut bytes[at..]).unwrap();
            self.sent += 1;
        }
        bytes
    }
}

impl Party for Flood {
    fn open(&mut self, _: Millis, _: LineId) {
        self.is_open = true;
        self.lines += 1;
        self.frames.reset();
        (self.photos[0], self.taken[0]) = (0, 0);
        self.owed.clear();
    }

    fn close(&mut self, now: Millis, _: LineId) {
        self.is_open = false;
        self.taken[1] += std::mem::take(&mut self.taken[0]);
        self.next = Some(now.after(20));
    }

    fn receive(&mut self, _: Millis, _: LineId, bytes: &[u8]) {
        let mut rest = bytes;
        while !rest.is_empty() {
            let taken = self.frames.push(rest);
            rest = &rest[taken..];
            while let Some(item) = self.frames.next() {
                let Item::Frame(frame) = item else { panic!("{item:?}") };
                let told = match DeviceMessage::decode(&frame).unwrap() {
                    DeviceMessage::SoftwareID(software) => Expected::Platform(software.platform),
                    DeviceMessage::LEDStatus(leds) => Expected::Lamps(leds.master_status, leds.slave_status),
                    DeviceMessage::DeviceInfo(_) => Expected::Device,
                    DeviceMessage::MotorPosition(_) | DeviceMessage::ErrorStatus(_) => continue,
                    message => panic!("{message}"),
                };
                let (expected, photos) = self.owed.pop_front().expect("an answer to a question");
                assert_eq!(told, expected, "what was sent before the question was not done");
                self.taken[0] = photos;
                self.answered += 1;
            }
        }
    }

    fn advance(&mut self, now: Millis) {
        if self.next.is_some_and(|next| next <= now) {
            if self.is_open {
                let batch = self.batch(now);
                self.outgoing.push_back(Outgoing::Bytes(LineId(0), batch));
                self.next = Some(now.after(1));
            } else {
                self.outgoing.push_back(Outgoing::Open(LineId(0)));
                self.next = Some(now.after(10));
            }
        }
    }

    fn wake(&self) -> Option<Millis> {
        self.next
    }

    fn poll(&mut self) -> Option<Outgoing> {
        self.outgoing.pop_front()
    }
}

impl Host for Flood {
    type Command = ();
    type Event = ();

    fn command(&mut self, _: Millis, (): ()) {}

    fn next_event(&mut self) -> Option<()> {
        None
    }
}

/// So many seconds of it.
fn load(seconds: u64) {
    // One piece in a hundred would leave no line for longer than a few milliseconds.
    let faults = Faults { break_off: 2e-4, reset: 20.0, stall: 5.0, ..Faults::all(Carrier::Stream) };
    let mut scene = Scene::new(Flood::new(), KosDevice::new(Setup::default()), Carrier::Stream, faults, 1);
    let began = std::time::Instant::now();
    let (mut most, mut own, mut owed) = (0, 0, 0);
    for now in 0..seconds * 1000 {
        scene.run(Millis(1000 + now), |_, ()| None::<()>);
        most = most.max(scene.held());
        own = own.max(scene.rig.held());
        owed = owed.max(scene.host.owed.len());
    }
    let (flood, took) = (&scene.host, began.elapsed());
    let taken = flood.taken[0] + flood.taken[1];
    println!(
        "{seconds} s in {took:?}: {} messages sent, {} answers, {} connections, {taken} of {} photos known to be \
         taken, {} taken; at most {most} bytes on their way, {own} in the rig, {owed} questions open",
        flood.sent,
        flood.answered,
        flood.lines,
        flood.photos[1],
        scene.rig.photo_count(),
    );
    assert!((taken..=flood.photos[1]).contains(&scene.rig.photo_count()));
    assert!(flood.sent >= 7000 * seconds && flood.answered >= 2500 * seconds, "the line was down most of the time");
    assert!(most + own < HELD);
    assert_eq!(scene.rig.motors().len(), 3);
}

#[test]
fn a_minute_of_ten_thousand_messages_a_second() {
    load(60);
}
