//! Device under load, with all faults: it has done what it acknowledges, and it does not hold more and more bytes.

use std::collections::{BTreeMap, VecDeque};

use dmc_proto::device::Quirks;
use dmc_proto::host::{Options, State};
use dmc_proto::message::{
    Acceleration, AckCode, Bool, HardwareLimitSet, Motor, MotorSetLimits, MotorSetSpeed, Speed, Steps,
};
use dmc_proto::{DeviceMessage, Frames, HostMessage, Item, MessageId, Token};
use motion_core::time::Millis;
use motion_rigs::dmc_device::{DmcDevice, Setup};
use motion_rigs::dmc_host::{Command, DmcHost, Event};
use motion_rigs::faults::{Carrier, Faults};
use motion_rigs::{Host, LineId, Outgoing, Party, Scene};

/// Number of messages in a millisecond: ten thousand in a second.
const RATE: u32 = 10;
/// Number of motors of the rig.
const MOTORS: u32 = 32;

/// Host that waits for no answer. It sets the limits of the motors in turn, each time to the number of the message.
#[derive(Default)]
struct Flood {
    now: Millis,
    is_open: bool,
    frames: Frames,
    out: VecDeque<Outgoing>,
    /// Number of the last message, which is also its id.
    last: u32,
    /// Numbers of the messages that were acknowledged, and not yet checked.
    acknowledged: VecDeque<u32>,
    damaged: u64,
    greetings: u64,
}

/// Motor of the message with a number.
fn motor(number: u32) -> Motor {
    Motor(u8::try_from(number % MOTORS + 1).unwrap())
}

impl Flood {
    fn send(&mut self) {
        self.last += 1;
        let number = i32::try_from(self.last).unwrap();
        let limits = MotorSetLimits {
            motor: motor(self.last),
            lower_enable: Bool::TRUE,
            lower: Steps(-number),
            upper_enable: Bool::TRUE,
            upper: Steps(number),
            hw_set: HardwareLimitSet(0),
            tail: &[],
        };
        let mut bytes = [0; 64];
        let len = HostMessage::from(limits).encode_into(MessageId(self.last), &mut bytes).unwrap();
        self.out.push_back(Outgoing::Bytes(LineId(0), bytes[..len].to_vec()));
    }

    fn receive(&mut self, id: MessageId, message: &DeviceMessage<'_>) {
        match message {
            DeviceMessage::Ack(ack) if ack.is_ok() => self.acknowledged.push_back(id.0),
            DeviceMessage::Ack(ack) if ack.response_code == Some(AckCode::ERR_CHECKSUM) => self.damaged += 1,
            DeviceMessage::Hi(_) => self.greetings += 1,
            other => panic!("{other}"),
        }
    }
}

impl Party for Flood {
    fn open(&mut self, now: Millis, _: LineId) {
        (self.now, self.is_open) = (now, true);
        self.frames.reset();
    }

    fn close(&mut self, _: Millis, _: LineId) {
        self.is_open = false;
        self.out.clear();
    }

    fn receive(&mut self, _: Millis, _: LineId, bytes: &[u8]) {
        if !self.is_open {
            return;
        }
        let mut frames = std::mem::take(&mut self.frames);
        let mut rest = bytes;
        while !rest.is_empty() {
            rest = &rest[frames.push(rest)..];
            while let Some(item) = frames.next() {
                let Item::Frame(frame) = item else { continue };
                if let Ok(message) = DeviceMessage::decode(&frame) {
                    self.receive(frame.id(), &message);
                }
            }
        }
        self.frames = frames;
    }

    fn advance(&mut self, now: Millis) {
        if self.is_open && now > self.now {
            self.now = now;
            (0..RATE).for_each(|_| self.send());
        }
    }

    fn wake(&self) -> Option<Millis> {
        self.is_open.then(|| self.now.after(1))
    }

    fn poll(&mut self) -> Option<Outgoing> {
        self.out.pop_front()
    }
}

impl Host for Flood {
    type Command = ();
    type Event = u32;

    fn command(&mut self, _: Millis, (): ()) {}

    fn next_event(&mut self) -> Option<u32> {
        self.acknowledged.pop_front()
    }
}

fn flood(seconds: u64) {
    let rig = DmcDevice::new(Setup::with_motors(32).with_machine_quirks(Quirks::WIDE_ACK));
    let mut scene = Scene::new(Flood::default(), rig, Carrier::Serial, Faults::all(Carrier::Serial), 1);
    let (mut on_line, mut in_rig, mut acknowledged) = (0, 0, 0);
    for millis in 1..=seconds * 1000 {
        scene.run(Millis(millis), |scene, number| {
            acknowledged += 1;
            // The limits are those of this message, or of a later one to the same motor.
            let tuning = scene.rig.tuning(motor(number)).unwrap();
            let (Some(Steps(lower)), Some(Steps(upper))) = (tuning.lower, tuning.upper) else {
                panic!("{number} was acknowledged, and was not done");
            };
            let upper = u32::try_from(upper).unwrap();
            assert!(upper >= number && motor(upper) == motor(number), "{number} is {upper}");
            assert_eq!(i64::from(lower), -i64::from(upper));
            None::<()>
        });
        (on_line, in_rig) = (on_line.max(scene.held()), in_rig.max(scene.rig.held()));
    }
    let Flood { last, damaged, greetings, .. } = scene.host;
    let received = scene.rig.received();
    println!(
        "{seconds} s: sent {last}, received {received}, acknowledged {acknowledged}, damaged {damaged}, greetings \
         {greetings}; held at most {on_line} bytes on the line, {in_rig} in the rig"
    );
    assert!(u64::from(last) >= seconds * 9900, "ten thousand in a second");
    assert!(received * 10 > u64::from(last) * 8 && acknowledged * 10 > received * 8, "most requests are done");
    // In a silence of one and a half seconds, messages of 24 bytes and answers of 16 bytes collect on the line.
    assert!(on_line < 1_000_000, "{on_line} bytes on the line");
    // The rig holds one incomplete frame. The line takes all answers at once.
    assert!(in_rig < 4096, "{in_rig} bytes in the rig");
}

#[test]
fn a_device_takes_ten_thousand_messages_in_a_second() {
    flood(5);
}

#[test]
#[ignore = "takes a minute; run it with --release"]
fn a_device_takes_ten_thousand_messages_in_a_second_for_a_minute() {
    flood(60);
}

/// Sends as fast as the protocol allows: four requests are under way at once.
fn window(seconds: u64) {
    let host = DmcHost::new(Options::default().with_window(4));
    let rig = DmcDevice::new(Setup::with_motors(32));
    let mut scene = Scene::new(host, rig, Carrier::Serial, Faults::all(Carrier::Serial), 2);
    // No two requests under way are for the same motor, because a repeated request may arrive after a later one.
    let (mut last, mut asked) = (0_u32, BTreeMap::new());
    let (mut done, mut failed, mut held) = (0_u64, 0_u64, 0);
    let until = Millis(seconds * 1000);
    while scene.now() < until {
        scene.run(scene.now().after(1), |scene, event| {
            match event {
                Event::Ended(Token(number), Ok(_)) => {
                    done += 1;
                    let motor: Motor = asked.remove(&number).expect("each request ends once");
                    let speed = scene.rig.tuning(motor).unwrap().speed.0;
                    assert_eq!(speed, number + 10, "the speed is not set");
                }
                Event::Ended(Token(number), Err(_)) => {
                    failed += 1;
                    asked.remove(&number).expect("each request ends once");
                }
                _ => {}
            }
            None::<()>
        });
        held = held.max(scene.held() + scene.rig.held() + scene.host.held());
        match scene.host.machine().state() {
            State::Ready => {
                while asked.len() < 12 {
                    last += 1;
                    let free = (1..=32).map(Motor).find(|motor| asked.values().all(|other| other != motor));
                    let motor = free.expect("more motors than requests");
                    let (max_velocity, max_accel) = (Speed(last + 10), Acceleration(1000));
                    let message = MotorSetSpeed { motor, max_velocity, max_accel, tail: &[] };
                    asked.insert(last, motor);
                    scene.command(Command::Ask(Token(last), message.into()));
                }
            }
            State::Silent => scene.command(Command::Greet),
            _ => {}
        }
    }
    println!("{seconds} s: done {done}, not done {failed}; held at most {held} bytes");
    assert!(done > seconds * 20, "{done}");
    assert_eq!(u64::from(last), done + failed + u64::try_from(asked.len()).unwrap());
    // Four requests and their answers, doubled, and noise are held.
    assert!(held < 4096, "{held} bytes");
}

#[test]
fn a_host_sends_as_fast_as_the_protocol_allows() {
    window(5);
}

#[test]
#[ignore = "takes a minute; run it with --release"]
fn a_host_sends_as_fast_as_the_protocol_allows_for_a_minute() {
    window(60);
}
