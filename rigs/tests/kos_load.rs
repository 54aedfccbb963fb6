//! Ten thousand messages a second, with faults: the device has done what it acknowledges, and needs no more memory.

use std::collections::VecDeque;

use kos_proto::message::{
    GetDeviceInfo, GetLEDStatus, GetSoftwareID, KeepAlive, LEDStatus, LedMode, MotorAddress, Rotations,
    RotationsPerSecond, RotationsPerSecondSquared, Seconds, SetPositionSpeedAcceleration, SoftwareID, TakePicture,
};
use kos_proto::{DeviceMessage, Frames, HostMessage, Item};
use motion_core::time::Millis;
use motion_rigs::faults::{Carrier, Faults};
use motion_rigs::kos_device::{KosDevice, Setup};
use motion_rigs::{Host, LineId, Outgoing, Party, Rig as _, Scene};

/// Greatest number of bytes on their way or in the device: those of the longest silence, which is 1.5 s, with 100 bytes a
/// millisecond each way.
const HELD: usize = 300_000;

/// Answer to a question, if the device did all that was sent before it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Expected {
    Platform(u8),
    Leds(LedMode, LedMode),
    Device,
}

/// Client that sends ten messages a millisecond, and waits for no answer.
struct Flood {
    is_open: bool,
    frames: Frames,
    next: Option<Millis>,
    outgoing: VecDeque<Outgoing>,
    /// Answers that have to come on this connection, and the number of photos that were sent before each.
    owed: VecDeque<(Expected, u64)>,
    sent: u64,
    answered: u64,
    /// Number of photos that were sent: on this connection, and on all connections.
    photos: [u64; 2],
    /// Number of photos that are known to be taken: on this connection, and on all connections before.
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
        let tail = &[][..];
        let [platform, .., high] = now.0.to_le_bytes();
        let leds = [LedMode::OFF, LedMode::ON][usize::from((platform ^ high) & 1)];
        let mut bytes = Vec::new();
        for number in 0..10_u8 {
            let motor = MotorAddress(1 + number % 3);
            let expected = match number {
                2 | 7 => Some(Expected::Platform(platform.wrapping_add(number))),
                4 => Some(Expected::Leds(leds, LedMode::OFF)),
                9 => Some(Expected::Device),
                _ => None,
            };
            let message: HostMessage<'_> = match number {
                0 => SoftwareID { platform: platform.wrapping_add(2), tail }.into(),
                6 => SoftwareID { platform: platform.wrapping_add(7), tail }.into(),
                2 | 7 => GetSoftwareID::default().into(),
                1 => LEDStatus { master_status: leds, slave_status: LedMode::OFF, tail }.into(),
                4 => GetLEDStatus::default().into(),
                9 => GetDeviceInfo::default().into(),
                3 if now.0.is_multiple_of(50) => {
                    TakePicture { motor_address: MotorAddress::ALL, exposure: Seconds(0.01), tail }.into()
                }
                5 | 8 => {
                    let position = Rotations(f32::from(platform) / 10.0);
                    let (speed, acceleration) = (RotationsPerSecond(20.0), RotationsPerSecondSquared(50.0));
                    SetPositionSpeedAcceleration::move_to(motor, position, speed, acceleration).into()
                }
                _ => KeepAlive::default().into(),
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
                    DeviceMessage::LEDStatus(leds) => Expected::Leds(leds.master_status, leds.slave_status),
                    DeviceMessage::DeviceInfo(_) => Expected::Device,
                    DeviceMessage::MotorPosition(_) | DeviceMessage::ErrorStatus(_) => continue,
                    message => panic!("{message}"),
                };
                let (expected, photos) = self.owed.pop_front().expect("an answer to a question");
                assert_eq!(told, expected, "the device did not do all that was sent before the question");
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

/// Floods a device for some seconds.
fn load(seconds: u64) {
    // With one break in a hundred pieces, no connection would last longer than some milliseconds.
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
    assert!(
        flood.sent >= 7000 * seconds && flood.answered >= 2500 * seconds,
        "the connection was down most of the time"
    );
    assert!(most + own < HELD);
    assert_eq!(scene.rig.motors().len(), 3);
}

#[test]
fn a_device_bears_ten_thousand_messages_a_second_for_a_minute() {
    load(60);
}
