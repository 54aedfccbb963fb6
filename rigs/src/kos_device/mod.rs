//! A kOS device: motors in rotations, a camera, and up to four clients over TCP.
//!
//! What it answers and allows is the business of [`DeviceMachine`]; here are the motors that it moves, the camera, what
//! it stores, and its connections. Over USB it cannot be reached.
//!
//! The count of a motor outlives a reset, as that of an encoder does that keeps it: it stands for the place. The range
//! of a motor is forgotten then.

mod camera;
mod playing;
mod rig;
mod setup;

use std::collections::VecDeque;
use std::sync::Arc;

use kos_proto::device::{
    DeviceMachine, Event, Ignored, Input, MotorProfile, Profile, Report, SESSIONS, Scratch, Send, SessionId, To, What,
};
use kos_proto::message::{
    DeviceType, ErrorCode, FirmwareVersion, LedMode, MotorAddress, NetworkInfo, Normalized, Rotations,
};
use kos_proto::summary::MotorSet;
use kos_proto::{Frame, Frames, HostMessage};
use motion_core::machine::Machine as _;
use motion_core::profile::Limits;
use motion_core::time::Millis;
use motion_core::wire::{Bool, Password};
use tracing::{debug, info, warn};

use self::camera::Camera;
use self::playing::{Playing, Stage};
use crate::kos_host::StoredMove;
use crate::motor::{Happening, Motor};
use crate::{LineId, Outgoing, TICK};

pub use camera::Photo;
pub use setup::{MotorSetup, QuirkError, Setup};

/// Milliseconds that it needs to start.
const BOOT: u64 = 500;

/// A motor that is told to be further in a tick than it can go, loses its move; by so much more, for rounding.
const SLACK: f64 = 1e-3;

/// A simulated kOS device.
#[derive(Debug)]
pub struct KosDevice {
    setup: Setup,
    profiles: Vec<MotorProfile>,
    machine: DeviceMachine,
    lines: [Line; SESSIONS],
    motors: Vec<Motor>,
    drives: Vec<Drive>,
    playing: Option<Playing>,
    camera: Camera,
    store: Store,
    /// The last moment that it was told of.
    now: Millis,
    /// The moment of the last step of the machine, and when it wants the next.
    stepped: Millis,
    wake: Option<Millis>,
    /// When it runs, if it does not.
    starts: Option<Millis>,
    outgoing: VecDeque<Outgoing>,
}

#[derive(Debug, Default)]
struct Line {
    is_open: bool,
    frames: Option<Box<Frames>>,
}

/// What the rig knows of a motor for the machine.
#[derive(Debug, Clone, Copy, Default)]
struct Drive {
    /// Where the machine takes it to be.
    told: f32,
    /// Where it was sent by a move, and should be when it rests.
    goal: Option<f64>,
}

/// What outlives a reset; but for the move and the lamps, which do not.
#[derive(Debug, Clone)]
struct Store {
    password: Arc<[u8]>,
    platform: u8,
    trajectory: Option<StoredMove>,
    leds: (LedMode, LedMode),
}

impl KosDevice {
    /// A device that is switched on at moment 0.
    #[must_use]
    pub fn new(setup: Setup) -> Self {
        let mut setup = setup;
        setup.motors.truncate(kos_proto::summary::MOTORS);
        setup.options = setup.options.with_motors(MotorSet::of((1_u8..).map(MotorAddress).take(setup.motors.len())));
        let motors = setup.motors.iter().map(|motor| {
            let profile = motor.profile;
            let limits = Limits {
                velocity: f64::from(profile.max_max_move_speed.0.max(profile.max_max_setup_speed.0)),
                acceleration: f64::from(profile.max_max_acceleration.0),
                jerk: None,
            };
            motor.travel.map_or(Motor::new(limits), |travel| Motor::new(limits).within(travel))
        });
        Self {
            profiles: setup.motors.iter().map(|motor| motor.profile).collect(),
            machine: DeviceMachine::new(setup.options),
            lines: Default::default(),
            motors: motors.collect(),
            drives: vec![Drive::default(); setup.motors.len()],
            playing: None,
            camera: Camera::default(),
            store: Store {
                password: setup.password.clone().into(),
                platform: setup.options.platform,
                trajectory: None,
                leds: (LedMode::OFF, LedMode::OFF),
            },
            now: Millis(0),
            stepped: Millis(0),
            wake: None,
            starts: Some(Millis(0)),
            outgoing: VecDeque::new(),
            setup,
        }
    }

    /// The machine, to look at.
    #[must_use]
    pub const fn machine(&self) -> &DeviceMachine {
        &self.machine
    }

    /// How many photos it took.
    #[must_use]
    pub const fn photo_count(&self) -> u64 {
        self.camera.count()
    }

    /// The last photos that it took, 4096 at most.
    pub fn photos(&self) -> impl Iterator<Item = &Photo> {
        self.camera.photos()
    }

    /// The stored password.
    #[must_use]
    pub fn password(&self) -> &[u8] {
        &self.store.password
    }

    /// The stored platform.
    #[must_use]
    pub const fn platform(&self) -> u8 {
        self.store.platform
    }

    /// The stored move.
    #[must_use]
    pub const fn stored_move(&self) -> Option<&StoredMove> {
        self.store.trajectory.as_ref()
    }

    /// The lamps of the device and of its slave.
    #[must_use]
    pub const fn leds(&self) -> (LedMode, LedMode) {
        self.store.leds
    }

    /// Bytes that it holds: of messages that are not whole, and of messages that nobody took yet.
    #[must_use]
    pub fn held(&self) -> usize {
        let frames = self.lines.iter().filter_map(|line| line.frames.as_ref()).map(|frames| frames.held());
        let waiting = self.outgoing.iter().map(|outgoing| match outgoing {
            Outgoing::Bytes(_, bytes) | Outgoing::Announce(bytes) | Outgoing::Answer(bytes) => bytes.len(),
            Outgoing::Open(_) | Outgoing::HangUp(_) => 0,
        });
        frames.chain(waiting).sum()
    }

    /// Whether it is on.
    const fn runs(&self) -> bool {
        self.starts.is_none()
    }

    fn motor(&mut self, motor: MotorAddress) -> Option<(&mut Motor, &mut Drive)> {
        let index = usize::from(motor.number()).checked_sub(1)?;
        self.motors.get_mut(index).zip(self.drives.get_mut(index))
    }

    /// The motors by their addresses.
    fn addresses(&self) -> impl Iterator<Item = MotorAddress> + use<> {
        (1_u8..).map(MotorAddress).take(self.motors.len())
    }

    /// Does what is due at a moment, and no later.
    fn tick(&mut self, now: Millis) {
        self.now = now;
        if self.starts.is_some_and(|starts| starts <= now) {
            self.starts = None;
            info!("kOS: it runs");
            self.step(now, Input::Rig(Report::Started), None);
        }
        let lost = self.follow(now);
        let happened: Vec<_> =
            self.addresses().zip(&mut self.motors).map(|(motor, it)| (motor, it.advance(now))).collect();
        for motor in lost {
            warn!("motor {motor} cannot follow its curve");
            self.report(now, Report::Fault(motor, ErrorCode::PVT_INTEGRITY));
        }
        for (motor, happened) in happened.into_iter().filter_map(|(motor, happened)| Some((motor, happened?))) {
            match happened {
                Happening::Rests => self.rests(now, motor),
                Happening::Tripped { upper } => {
                    warn!("motor {motor} ran into the {} end of its travel", if upper { "upper" } else { "lower" });
                    self.report(now, Report::Fault(motor, ErrorCode::FAULT));
                }
            }
        }
        if self.wake.is_some_and(|wake| wake <= now) {
            self.sync();
            self.step(now, Input::Wake, None);
        }
        if self.playing.as_ref().is_some_and(|playing| playing.is_over(now)) {
            self.release(now);
        }
    }

    /// Leads the motors along the curves that are played, and names those that cannot follow.
    fn follow(&mut self, now: Millis) -> Vec<MotorAddress> {
        let Some(playing) = self.playing.as_ref().filter(|playing| playing.runs()) else { return Vec::new() };
        let mut lost = Vec::new();
        for way in playing.ways() {
            let index = usize::from(way.motor.number()).wrapping_sub(1);
            let (Some(motor), Some(mut place)) = (self.motors.get_mut(index), playing.place(way, now)) else {
                continue;
            };
            let most = motor.limits().velocity;
            #[expect(clippy::cast_precision_loss, reason = "a tick is a millisecond")]
            let reach = most * TICK as f64 / 1000.0 * (1.0 + SLACK) + SLACK;
            if (place.position - motor.at(now).position).abs() > reach {
                motor.halt(now);
                lost.push(way.motor);
            } else {
                place.velocity = place.velocity.clamp(-most, most);
                motor.lead(place);
            }
        }
        lost
    }

    /// The curves are at their end: the motors rest where these end.
    fn release(&mut self, now: Millis) {
        let Some(playing) = self.playing.as_mut().filter(|playing| playing.runs()) else { return };
        playing.stage = Stage::At(playing.elapsed(now));
        for way in playing.ways() {
            if let Some(motor) = self.motors.get_mut(usize::from(way.motor.number()).wrapping_sub(1)) {
                motor.halt(now);
            }
        }
    }

    /// A motor rests: where it was sent, or it did not get there.
    fn rests(&mut self, now: Millis, motor: MotorAddress) {
        let Some((it, drive)) = self.motor(motor) else { return };
        let position = it.at(now).position;
        let missed = drive.goal.take().is_some_and(|goal| (goal - position).abs() > SLACK);
        debug!("motor {motor} rests at {position:.4}");
        if missed {
            warn!("motor {motor} did not get to where the move wants it");
            self.report(now, Report::CannotHome(motor));
        } else {
            self.report(now, Report::Arrived(motor, rotations(position)));
        }
    }

    /// Tells the machine what happened.
    fn report(&mut self, now: Millis, report: Report) {
        if self.runs() {
            self.sync();
            self.step(now, Input::Rig(report), None);
        }
    }

    /// Tells the machine where the motors are, as of its last step, so that nothing follows from it but that.
    fn sync(&mut self) {
        for motor in self.addresses() {
            let now = self.now;
            let Some((it, drive)) = self.motor(motor) else { continue };
            let position = rotations(it.at(now).position);
            if position.0.to_bits() != drive.told.to_bits() {
                drive.told = position.0;
                let stepped = self.stepped;
                self.step(stepped, Input::Rig(Report::At(motor, position)), None);
            }
        }
    }

    /// Gives something to the machine, and does all that follows; `given` is the message in it.
    fn step(&mut self, now: Millis, input: Input<'_>, given: Option<&Frame<'_>>) {
        let (machine, output) = self.machine.clone().step(now, input);
        (self.machine, self.wake, self.stepped) = (machine, output.wake, now);
        for &event in &output.events {
            self.happens(now, event, given);
        }
        for send in &output.send {
            self.send(send, given);
        }
    }

    fn send(&mut self, send: &Send, given: Option<&Frame<'_>>) {
        let bytes = self.encoded(send, given);
        match send.to {
            To::Broadcast => self.outgoing.push_back(Outgoing::Announce(bytes)),
            To::Asker => self.outgoing.push_back(Outgoing::Answer(bytes)),
            To::Sessions(sessions) => {
                for session in sessions.iter() {
                    if self.lines.get(usize::from(session.0)).is_some_and(|line| line.is_open) {
                        self.outgoing.push_back(Outgoing::Bytes(LineId(session.0), bytes.clone()));
                    }
                }
            }
        }
    }

    fn encoded(&self, send: &Send, given: Option<&Frame<'_>>) -> Vec<u8> {
        let number = self.setup.number.to_be_bytes();
        let [.., n3, n4, n5, n6, n7] = number;
        let guid = [*b"kOSrig\x40\x00", number].concat();
        let network = NetworkInfo {
            dhcp: Bool::TRUE,
            // The second bit says that nobody but its owner gave it.
            mac_address: [2, n3, n4, n5, n6, n7].into(),
            ip_address: self.setup.address.into(),
            device_type: DeviceType::SECOND_SHOOTER_PRO,
            ..Profile::default().network
        };
        let mut profile = Profile {
            older_dialect: self.setup.older_dialect,
            device_type: DeviceType::SECOND_SHOOTER_PRO,
            firmware_version: FirmwareVersion([1, 0, 1, 16]),
            network,
            guid: &guid,
            password: Password(&self.store.password),
            motors: &self.profiles,
            received: given.map_or(&[], |frame| frame.bytes()),
            ..Profile::default()
        };
        if let (What::TrajectoryData { .. }, Some(stored)) = (&send.what, &self.store.trajectory) {
            profile.trajectory = stored.data();
        }
        let mut scratch = Scratch::default();
        let message = send.message(&profile, &mut scratch);
        debug!("says {message}");
        let mut bytes = vec![0; message.encoded_len()];
        match message.encode_into(&mut bytes) {
            Ok(len) => bytes.truncate(len),
            Err(error) => {
                warn!("cannot say {message}: {error}");
                bytes.clear();
            }
        }
        bytes
    }

    /// Does what the machine wants done.
    fn happens(&mut self, now: Millis, event: Event, given: Option<&Frame<'_>>) {
        match event {
            Event::Move { motor, to, speed, acceleration } => {
                debug!("motor {motor} goes to {to}, {speed}, {acceleration}");
                if let Some((it, drive)) = self.motor(motor) {
                    drive.goal = None;
                    it.go_to(now, to.0.into(), speed.0.into(), acceleration.0.into());
                }
            }
            Event::StopMotor { motor, acceleration } => {
                info!("motor {motor} stops");
                if let Some((it, drive)) = self.motor(motor) {
                    drive.goal = None;
                    it.stop(now, acceleration.map(|acceleration| acceleration.0.into()));
                }
            }
            Event::StopAll => {
                info!("everything stops");
                self.stop_all(now);
            }
            Event::Home { way, speed, motors } => {
                info!(
                    "its motors go to where the move {}",
                    if let Stage::At(1.0) = home(way) { "ends" } else { "begins" }
                );
                self.playing = self.store.trajectory.as_ref().and_then(|stored| {
                    let told = |motor: MotorAddress| {
                        self.drives.get(usize::from(motor.number()).wrapping_sub(1)).map(|drive| drive.told)
                    };
                    Playing::new(stored, &self.machine, told)
                });
                self.go_to_part(now, home(way), motors, Some(speed));
            }
            Event::Play { way, millis } => {
                info!("the move is played {way:?}, in {millis} ms");
                if let Some(playing) = &mut self.playing {
                    playing.stage = Stage::Runs { way, start: now, millis };
                }
            }
            Event::MoveToFrame { frame, last } => {
                debug!("its motors go to place {frame} of {last}");
                let part = f64::from(frame) / f64::from(last.max(1));
                self.go_to_part(now, Stage::At(part), MotorSet::of(self.addresses()), None);
            }
            Event::OpenShutter { millis } => {
                let moment = self.playing.as_ref().map(|playing| playing.moment(now));
                self.camera.open(Photo { opened: now, closes: now.after(millis), moment });
                info!("photo {}, for {millis} ms", self.camera.count());
            }
            Event::MoveOver => {
                info!("the move is over");
                self.release(now);
                self.playing = None;
            }
            event => self.stores(event, given),
        }
    }

    /// Sends motors to a part of the move: as fast as they can, or at a part of their setup speed.
    fn go_to_part(&mut self, now: Millis, stage: Stage, motors: MotorSet, speed: Option<Normalized>) {
        let (Some(playing), Stage::At(part)) = (&mut self.playing, stage) else { return };
        playing.stage = stage;
        for way in playing.ways().iter().filter(|way| motors.contains(way.motor)) {
            let index = usize::from(way.motor.number()).wrapping_sub(1);
            let (Some(motor), Some(drive)) = (self.motors.get_mut(index), self.drives.get_mut(index)) else { continue };
            let (Some(profile), Some(to)) = (self.profiles.get(index), way.position(part)) else { continue };
            let speed = match speed {
                Some(part) => f64::from(part.0) * f64::from(profile.max_max_setup_speed.0),
                None => profile.max_max_move_speed.0.into(),
            };
            drive.goal = Some(to);
            motor.go_to(now, to, speed, profile.max_max_acceleration.0.into());
        }
    }

    /// What is stored, connected and ignored.
    fn stores(&mut self, event: Event, given: Option<&Frame<'_>>) {
        let message = given.and_then(|frame| HostMessage::decode(frame).ok());
        match (event, message) {
            (Event::Leds { master, slave }, _) => self.store.leds = (master, slave),
            (Event::StorePassword, Some(HostMessage::SetDevicePassword(given))) => {
                info!("another password is stored");
                self.store.password = given.password.0.into();
            }
            (Event::StoreTrajectory, Some(HostMessage::SetTrajectoryData(data))) => {
                info!("a move is stored");
                self.store.trajectory = StoredMove::new(&data).ok();
            }
            (Event::BadTrajectory(error), _) => {
                info!("a move cannot be played: {error}");
                self.store.trajectory = None;
            }
            (Event::StorePlatform(platform), _) => self.store.platform = platform,
            (Event::Close(session, why), _) => {
                info!("client {} is disconnected: {why:?}", session.0);
                self.hang_up(session);
            }
            (Event::Reboot, _) => {
                info!("it starts anew");
                self.start_anew();
            }
            (Event::Ignored(Ignored::Off), _) => {}
            (Event::Ignored(why), _) => info!("ignored: {why:?}"),
            (event, _) => warn!("nothing is done about {event:?}"),
        }
    }

    fn stop_all(&mut self, now: Millis) {
        self.playing = None;
        self.camera.close(now);
        for (motor, drive) in self.motors.iter_mut().zip(&mut self.drives) {
            drive.goal = None;
            motor.stop(now, None);
        }
    }

    fn hang_up(&mut self, session: SessionId) {
        if let Some(line) = self.lines.get_mut(usize::from(session.0)).filter(|line| line.is_open) {
            *line = Line::default();
            self.outgoing.push_back(Outgoing::HangUp(LineId(session.0)));
        }
    }

    fn start_anew(&mut self) {
        for session in SessionId::ALL {
            self.hang_up(session);
        }
        self.machine = DeviceMachine::new(self.setup.options.with_platform(self.store.platform));
        self.store.trajectory = None;
        self.store.leds = (LedMode::OFF, LedMode::OFF);
        self.drives.fill(Drive::default());
        (self.starts, self.wake) = (Some(self.now.after(BOOT)), None);
    }
}

/// Where a move that is played this way begins.
const fn home(way: kos_proto::summary::Direction) -> Stage {
    match way {
        kos_proto::summary::Direction::Forward => Stage::At(0.0),
        kos_proto::summary::Direction::Reverse => Stage::At(1.0),
    }
}

#[expect(clippy::cast_possible_truncation, reason = "rounds to the nearest; the protocol has no other number")]
fn rotations(position: f64) -> Rotations {
    Rotations(position as f32)
}
