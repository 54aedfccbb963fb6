//! Application of a host, a simple rig, and laws that hold for every output.
//!
//! The fuzz target of the machines includes this file too.

use std::collections::HashMap;

use dmc_proto::device::{self, Rig};
use dmc_proto::host::{self, Command, Contents, HostMachine, Outcome, Refusal, Source};
use dmc_proto::message::{
    AckCode, Capabilities, FrameNumber, Hi, Motor, MotorFlags, MotorJog, MotorMove, Motors, Name, RtShootFrame,
    RtShootFrame2, Steps,
};
use dmc_proto::upload::{MoveSource, SCRATCH, Section, SectionSize};
use dmc_proto::{DeviceMessage, Effect, Frame, HostMessage, Token};
use laws::world::Tokens;

/// Greeting of a rig with every capability and eight motors.
pub(crate) fn hi() -> Hi<'static> {
    Hi {
        name: Name::truncated("bench"),
        fw_major: 1,
        fw_minor: 2,
        fw_rev: 3,
        motor_count: 8,
        dmx_count: 100,
        gio_out_count: 4,
        gio_in_count: 4,
        hw_limit_count: 2,
        upload_frame_count: 1000,
        capabilities: Capabilities(0x07FF),
        protocol_version: Some(2),
        tail: &[],
    }
}

/// Rig whose motors stand at ten times their number. In its move, motors 1 and 2 move as many steps per frame as their
/// number.
pub(crate) struct Tens;

impl Rig for Tens {
    fn verdict(&self, _: &HostMessage<'_>) -> AckCode {
        AckCode::OK
    }

    fn position(&self, motor: Motor) -> Steps {
        Steps(10 * i32::from(motor.0))
    }
}

impl MoveSource for Tens {
    fn start_frame(&self) -> FrameNumber {
        FrameNumber(1)
    }

    fn frame_count(&self) -> u32 {
        10
    }

    fn motors(&self) -> Motors {
        Motors(3)
    }

    fn position(&self, motor: Motor, index: u32) -> Steps {
        Steps(i32::from(motor.0) * i32::try_from(index).unwrap())
    }
}

/// Application that keeps what it asked its host for.
#[derive(Default)]
pub(crate) struct App<'a> {
    /// Tokens of the commands that have not ended.
    pub(crate) tokens: Tokens,
    /// Messages of the commands, with the number of times that each was sent.
    messages: HashMap<Token, (HostMessage<'a>, u32)>,
    /// Number of times that the last signal to start was sent.
    signals: u32,
    /// Uses that the device may have for a motor. Without an entry, it may have any.
    uses: HashMap<Motor, Vec<MotorFlags>>,
    /// Motors of the move whose upload began last, and whether the upload is complete. `None` if nobody knows the move.
    upload: Option<(Motors, bool)>,
}

impl<'a> App<'a> {
    /// Gives a command, with a new token.
    pub(crate) fn command(&mut self, command: Command<'a>) -> host::Input<'a> {
        let token = self.tokens.begin();
        match command {
            Command::Request(message) | Command::Sequence(message) => {
                self.messages.insert(token, (message, 0));
            }
            Command::Go => self.signals = 0,
            _ => {}
        }
        host::Input::Command(token, command)
    }

    /// Takes an output of the host, which keeps the laws of hosts: stops go out before everything else, and so before
    /// anybody is told of them; each command ends once; no message is sent more often than it may be; no motor is moved that
    /// has not the uses for it.
    pub(crate) fn takes(&mut self, output: &host::Output<'_>, host: &HostMachine) {
        stops_go_first(output);
        for effect in &output.effects {
            match effect {
                Effect::Event(host::Event::Ended { token, outcome }) => {
                    self.tokens.end(*token);
                    self.ended(*token, outcome);
                }
                Effect::Event(host::Event::DeviceReset) => self.upload = None,
                Effect::Event(host::Event::Greeted(_)) if host.is_loaded() == Some(false) => self.upload = None,
                Effect::Event(_) => {}
                Effect::Transmit(transmit) => {
                    let times = self.count(transmit.contents);
                    let mut scratch = [0; SCRATCH];
                    let message = transmit.message(|source| self.find(source, &mut scratch));
                    let Some(message) = message else { continue };
                    if host.options().needs_enabled() {
                        self.check_uses(&message, times, host.device().map_or(0, |device| device.motor_count));
                    }
                    if transmit.contents == Contents::Greeting {
                        self.uses.clear();
                    }
                    self.keep(&message);
                }
            }
        }
    }

    /// Number of times that a message was sent for one command of the application.
    fn count(&mut self, contents: Contents) -> u32 {
        match contents {
            Contents::Go => {
                self.signals += 1;
                assert!(self.signals <= 4, "a signal, and three more after refusals");
                self.signals
            }
            Contents::Application(Source::Command(token)) => {
                let (message, times) = self.messages.get_mut(&token).expect("a command with a message");
                *times += 1;
                let most = if message.conduct().repeatable { 3 } else { 1 };
                assert!(*times <= most, "{message} is sent {times} times");
                *times
            }
            _ => 1,
        }
    }

    /// Keeps what a message that is sent may change at the device.
    fn keep(&mut self, message: &HostMessage<'_>) {
        match message {
            HostMessage::MotorConfigure(set) => {
                if let Some(uses) = self.uses.get_mut(&set.motor) {
                    uses.push(set.flags);
                }
            }
            HostMessage::RtUploadMoveBegin(_) => self.upload = Some((Motors::NONE, false)),
            HostMessage::RtUploadMoveAxis(section) => {
                let (axes, _) = self.upload.as_mut().expect("an upload has begun");
                axes.0 |= Motors::from_iter([section.motor]).0;
            }
            _ => {}
        }
    }

    fn ended(&mut self, token: Token, outcome: &Outcome<'_>) {
        let Some((message, _)) = self.messages.get(&token) else { return };
        match (message, outcome) {
            (HostMessage::RtUploadMoveBegin(_), Outcome::Done(_)) => {
                self.upload.as_mut().expect("an upload has begun").1 = true;
            }
            (HostMessage::MotorConfigure(set), Outcome::Done(None)) => self.uses_are(set.motor, set.flags),
            // A device without uses moves all its motors, and nobody can tell it otherwise.
            (HostMessage::MotorConfigure(set), Outcome::Refused(Refusal::Device(AckCode::ERR_UNSUPPORTED))) => {
                self.uses_are(set.motor, MotorFlags::all());
            }
            _ => {}
        }
    }

    /// The device has these uses for a motor, or those of a later request that is under way.
    fn uses_are(&mut self, motor: Motor, flags: MotorFlags) {
        let open = self.tokens.open().filter_map(|token| match self.messages.get(&token) {
            Some((HostMessage::MotorConfigure(set), 1..)) if set.motor == motor => Some(set.flags),
            _ => None,
        });
        let uses = [flags].into_iter().chain(open).collect();
        self.uses.insert(motor, uses);
    }

    /// Law of hosts: a motor is moved only if the device is known to use it so (decision D-76). Nothing follows a move
    /// while it is not known, or while a motor may be enabled that is not in it (decisions D-84 and D-90). A message that
    /// was sent before may be sent again for a single motor that was disabled since: nothing moves then.
    fn check_uses(&self, message: &HostMessage<'_>, times: u32, count: u8) {
        let all = |motor: Motor, holds: fn(MotorFlags) -> bool| {
            self.uses.get(&motor).is_some_and(|uses| uses.iter().all(|flags| holds(*flags)))
        };
        let is_enabled = |motor| all(motor, |flags| flags.contains(MotorFlags::ENABLED));
        let pairs = match message {
            HostMessage::MotorMove(MotorMove { motor, .. }) | HostMessage::MotorJog(MotorJog { motor, .. }) => {
                assert!(times > 1 || is_enabled(*motor), "{message}: {:?}", self.uses);
                return;
            }
            HostMessage::RtShootFrame(RtShootFrame { motors, .. })
            | HostMessage::RtShootFrame2(RtShootFrame2 { motors, .. }) => *motors,
            HostMessage::RtPositionFrame(_)
            | HostMessage::RtJogAll(_)
            | HostMessage::RtRunMove(_)
            | HostMessage::RtGo(_) => &[],
            _ => return,
        };
        for pair in pairs.iter().filter(|pair| pair.pos_a() != pair.pos_b()) {
            let blurs = all(pair.motor(), |flags| flags.contains(MotorFlags::ENABLED | MotorFlags::BLUR));
            assert!(blurs, "{message}: {:?}", self.uses);
        }
        let Some((axes, is_complete)) = self.upload else { return };
        assert!(is_complete, "{message} during an upload, or after one that failed");
        for motor in (1..=count).map(Motor) {
            let is_outside =
                |flags: MotorFlags| !flags.contains(MotorFlags::ENABLED) || flags.contains(MotorFlags::LIVE);
            let is_right = if axes.contains(motor) { is_enabled(motor) } else { all(motor, is_outside) };
            assert!(is_right, "{message}, move of motors {axes:?}: motor {motor} of {:?}", self.uses);
        }
    }

    fn find<'s>(&self, source: Source, scratch: &'s mut [u8; SCRATCH]) -> HostMessage<'s>
    where
        'a: 's,
    {
        match source {
            Source::Command(token) => self.messages[&token].0,
            Source::Section(section) => section.message(&Tens, scratch),
        }
    }

    /// Section that an upload asks for. A move of a single frame has no motors.
    pub(crate) fn section(&self, output: &host::Output<'_>) -> Option<host::Input<'static>> {
        let size = SectionSize::of(29);
        output.events().find_map(|event| {
            let host::Event::NextSection { token, after } = event else { return None };
            let has_motors = match self.messages[token].0 {
                HostMessage::RtUploadMoveBegin(begin) => begin.start_frame != begin.end_frame,
                message => panic!("{message} is no upload"),
            };
            let first = || Section::first(&Tens, size).filter(|_| has_motors);
            Some(host::Input::Section(after.map_or_else(first, |section| section.next(&Tens, size))))
        })
    }

    /// Bytes that the host sends: the frame of a message, or padding.
    pub(crate) fn frame(&self, transmit: &host::Transmit) -> Vec<u8> {
        let (mut scratch, mut bytes) = ([0; SCRATCH], vec![0; 1048]);
        let len =
            transmit.encode_into(|source| self.find(source, &mut scratch), &mut bytes).expect("a frame that fits");
        bytes.truncate(len);
        let Some(message) = transmit.message(|source| self.find(source, &mut scratch)) else {
            assert!(len > 0 && bytes.iter().all(|byte| *byte == 0), "padding");
            return bytes;
        };
        assert_eq!(message.encoded_len(), len, "{message}");
        let decoded = Frame::decode(&bytes).expect("a frame that was just encoded");
        assert_eq!((decoded.id(), HostMessage::decode(&decoded)), (transmit.id, Ok(message)));
        bytes
    }
}

/// Frame of a message of the device.
pub(crate) fn answer(transmit: &device::Transmit) -> Vec<u8> {
    let mut scratch = device::Scratch::default();
    let message = transmit.message(&Tens, &mut scratch);
    let mut bytes = vec![0; message.encoded_len()];
    assert_eq!(message.encode_into(transmit.id, &mut bytes), Ok(bytes.len()), "{message}");
    let decoded = Frame::decode(&bytes).expect("a frame that was just encoded");
    assert_eq!((decoded.id(), DeviceMessage::decode(&decoded)), (transmit.id, Ok(message)));
    bytes
}

/// Law of each output of a host: stops go out before everything else.
pub(crate) fn stops_go_first(output: &host::Output<'_>) {
    let is_stop = |effect: &host::Effect<'_>| {
        matches!(effect, Effect::Transmit(host::Transmit { contents: Contents::Stop(_), .. }))
    };
    let mut others = output.effects.iter().skip_while(|effect| is_stop(effect));
    assert!(!others.any(is_stop), "a stop after something else: {output:?}");
}

/// Whether a device with quirks refuses a stop in its state, or ignores it: decisions D-78 and D-79.
pub(crate) fn may_not_stop(device: &device::DeviceMachine, message: &HostMessage<'_>) -> bool {
    use device::{Quirks, State};
    let quirks = device.options().quirks();
    let is_run =
        matches!(device.state(), State::JogAll | State::PreRoll | State::Ready | State::Running | State::PostRoll);
    let is_ignored = matches!(message, HostMessage::MotorStop(_)) && is_run;
    (quirks.contains(Quirks::STOP_LOCKS) && device.state() == State::Locked)
        || (quirks.contains(Quirks::STOP_OF_ONE_IGNORED) && is_ignored)
}

/// Law of each output of a device: the rig acts before the host is told, and stops before everything else.
pub(crate) fn the_rig_acts_first(output: &device::Output<'_>) {
    use device::Event;
    let mut is_told = false;
    for (at, effect) in output.effects.iter().enumerate() {
        match effect {
            Effect::Transmit(_) => is_told = true,
            Effect::Event(Event::Stop(_)) => assert_eq!(at, 0, "a stop is the first effect: {output:?}"),
            Effect::Event(Event::Unlocked | Event::Acknowledgement(..) | Event::UnexpectedReport) => {}
            Effect::Event(event) => assert!(!is_told, "{event:?} comes after the message that tells of it: {output:?}"),
        }
    }
}
