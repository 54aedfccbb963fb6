//! The machine of a device: who may say what, and what is answered (kOS 7.1).

use motion_core::machine::Machine;
use motion_core::time::Millis;
use motion_core::wire::{Bool, DecodeError, Password};

use super::motor::{Drive, Drives, Motion};
use super::playback::{self, Playback};
use super::session::{self, CloseReason, SessionId, Sessions, Table};
use super::{Doing, Event, Ignored, Input, MotorReport, Options, Output, Report, Send, To, What};
use crate::HostMessage;
use crate::frame::{MessageId, MessageType};
use crate::message::{
    AuxInputs, ErrorCode, LedMode, MotorAddress, Normalized, PlaybackDirection, PlaybackState, Seconds,
};
use crate::summary::{Direction, MoveSummary, debug_fields};

/// Whether a device can be found and connected to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Link {
    /// It starts, or starts anew.
    Rebooting,
    /// Nobody is connected over TCP, and it says every five seconds where it is.
    Advertising,
    /// Somebody is.
    Connected,
}

impl Link {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Rebooting, Self::Advertising, Self::Connected];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rebooting => "Rebooting",
            Self::Advertising => "Advertising",
            Self::Connected => "Connected",
        }
    }
}

/// A device: see the [module](super).
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct DeviceMachine {
    pub(super) options: Options,
    on: bool,
    /// When it says again where it is.
    announce: Option<Millis>,
    pub(super) sessions: Table,
    pub(super) drives: Drives,
    pub(super) playback: Playback,
    inputs: AuxInputs,
    leds: (LedMode, LedMode),
    platform: u8,
}

debug_fields! { DeviceMachine { options, on, announce, sessions, drives, playback, inputs, leds, platform } }

/// One step: its moment, what follows from it, who is told, and who asked.
pub(super) struct Turn<'o> {
    pub(super) now: Millis,
    pub(super) options: Options,
    pub(super) output: &'o mut Output,
    /// Those that are told what happens: the unlocked ones.
    pub(super) told: Sessions,
    /// The one that sent the message.
    pub(super) asker: Sessions,
}

impl Turn<'_> {
    fn send(&mut self, to: Sessions, what: What) {
        if !to.is_empty() {
            self.output.send(Send { to: To::Sessions(to), what });
        }
    }

    /// Answers the one that asked.
    pub(super) fn answer(&mut self, what: What) {
        self.send(self.asker, what);
    }

    /// Tells all that are unlocked, and these.
    pub(super) fn tell(&mut self, others: Sessions, what: What) {
        self.send(self.told.with(others), what);
    }

    pub(super) fn answer_error(&mut self, code: ErrorCode, motor: MotorAddress) {
        self.answer(What::ErrorStatus { code, motor });
    }

    pub(super) fn tell_error(&mut self, code: ErrorCode, motor: MotorAddress) {
        self.tell(Sessions::NONE, What::ErrorStatus { code, motor });
    }

    /// Refuses what was asked: only the asker hears of it, for it is nothing that happened (decision K-S3).
    pub(super) fn refuse(&mut self, code: ErrorCode) {
        self.answer_error(code, MotorAddress::ALL);
    }

    pub(super) fn status(&mut self, state: PlaybackState, elapsed: Normalized, photos: u32, drives: &Drives) {
        let positions = drives.positions();
        // A stop is confirmed to the one that asked for it, locked or not.
        let also = if state == PlaybackState::FULL_STOP { self.asker } else { Sessions::NONE };
        self.tell(also, What::PlaybackStatus { state, elapsed, photos, positions });
    }

    pub(super) fn travel_limit(&self) -> Option<Millis> {
        self.options.travel_limit.map(|limit| self.now.after(limit))
    }

    pub(super) fn ignore(&mut self, why: Ignored) {
        self.output.event(Event::Ignored(why));
    }
}

impl DeviceMachine {
    /// A device that is switched off: [`Report::Started`] follows.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self {
            options,
            on: false,
            announce: None,
            sessions: Table::default(),
            drives: Drives::new(options.motors),
            playback: Playback::default(),
            inputs: AuxInputs::default(),
            leds: (LedMode::OFF, LedMode::OFF),
            platform: options.platform,
        }
    }

    /// Whether it can be found and connected to.
    #[must_use]
    pub fn link(&self) -> Link {
        match (self.on, self.sessions.has_tcp()) {
            (false, _) => Link::Rebooting,
            (true, false) => Link::Advertising,
            (true, true) => Link::Connected,
        }
    }

    /// How far a connection is.
    #[must_use]
    pub fn session(&self, session: SessionId) -> session::State {
        self.sessions.state(session)
    }

    /// How far it is with its move.
    #[must_use]
    pub const fn playback(&self) -> playback::State {
        self.playback.state()
    }

    /// The move that is stored.
    #[must_use]
    pub const fn stored_move(&self) -> Option<&MoveSummary> {
        self.playback.plan()
    }

    /// A motor, if it is there.
    #[must_use]
    pub fn motor(&self, motor: MotorAddress) -> Option<&Drive> {
        self.drives.get(motor)
    }

    fn received(&mut self, turn: &mut Turn<'_>, session: SessionId, message: HostMessage<'_>, stored: Password<'_>) {
        let locked = match self.sessions.state(session) {
            session::State::Closed => return turn.ignore(Ignored::NoSession(session)),
            session::State::Locked => true,
            session::State::Unlocked => false,
        };
        self.sessions.heard(turn.now, session, &self.options);
        // Stops come first, and ask for no password (safety decision 2).
        match message {
            HostMessage::StopPlayback(_) => return self.stop_all(turn),
            HostMessage::SetPositionSpeedAcceleration(message) if message.is_stop() => {
                return self.stop_motor(turn, message.motor_address, message.acceleration);
            }
            HostMessage::BumpPositionSpeedAcceleration(message) if message.is_stop() => {
                return self.stop_motor(turn, message.motor_address, message.acceleration);
            }
            _ => {}
        }
        match message {
            HostMessage::KeepAlive(_) => {}
            HostMessage::GetNetworkInfo(_) => turn.answer(What::NetworkInfo),
            HostMessage::GetDeviceInfo(_) => turn.answer(What::DeviceInfo(self.doing(turn.now))),
            HostMessage::SetUserPassword(given) => {
                if !self.sessions.user_password(session, given.password, stored) {
                    turn.answer_error(ErrorCode::LOCKED_OUT, MotorAddress::ALL);
                    turn.ignore(Ignored::WrongPassword(session));
                }
            }
            _ if locked => turn.ignore(Ignored::Locked(session)),
            message => self.unlocked(turn, session, message, stored),
        }
    }

    fn unlocked(&mut self, turn: &mut Turn<'_>, session: SessionId, message: HostMessage<'_>, stored: Password<'_>) {
        match message {
            HostMessage::SetDevicePassword(given) => {
                self.sessions.device_password(given.password, stored);
                turn.output.event(Event::StorePassword);
            }
            HostMessage::GetLEDStatus(_) => {
                let (master, slave) = self.leds;
                turn.answer(What::LedStatus { master, slave });
            }
            HostMessage::SetLEDStatus(leds) => {
                let (master, slave) = (leds.master_status, leds.slave_status);
                if master.name().is_none() || slave.name().is_none() {
                    return turn.ignore(Ignored::Unsupported(session));
                }
                self.leds = (master, slave);
                turn.output.event(Event::Leds { master, slave });
            }
            HostMessage::GetMotorInfo(_) => self.motor_info(turn),
            HostMessage::GetTrajectoryData(_) => {
                turn.answer(What::TrajectoryData { stored: self.playback.plan().is_some() });
            }
            HostMessage::SetTrajectoryData(data) => self.playback.store(turn, MoveSummary::of(&data)),
            HostMessage::GetDeviceGUID(_) => turn.answer(What::DeviceGuid),
            HostMessage::GetSoftwareID(_) => turn.answer(What::SoftwareId { platform: self.platform }),
            HostMessage::SetSoftwareID(software) => {
                self.platform = software.platform;
                turn.output.event(Event::StorePlatform(software.platform));
            }
            HostMessage::ResetDevice(_) => self.reboot(turn),
            HostMessage::ResetAxis(message) => self.reset_axis(turn, message.motor_address),
            HostMessage::MarkBeginPosition(message) => self.mark_begin(turn, message.motor_address),
            HostMessage::MarkEndPosition(message) => self.mark_end(turn, message.motor_address),
            HostMessage::SetupPlayback(message) => {
                if let Some(way) = way(turn, message.direction, message.start_time) {
                    self.playback.setup(turn, &self.drives, way, message.delay_return.get());
                }
            }
            HostMessage::StartPlayback(message) => {
                if let Some(way) = way(turn, message.direction, message.start_time) {
                    self.playback.start(turn, &self.drives, way);
                }
            }
            HostMessage::RapidToFirstKeyFrame(_) => self.playback.rapid(turn, &self.drives),
            HostMessage::TakePicture(message) => self.take_picture(turn, message.exposure),
            HostMessage::SetPositionSpeedAcceleration(message) => {
                let pace = (message.speed, message.acceleration);
                let target = |drive: &Drive| drive.target(message.position);
                self.go(turn, session, message.motor_address, target, pace);
            }
            HostMessage::BumpPositionSpeedAcceleration(message) => {
                let pace = (message.speed, message.acceleration);
                let target = |drive: &Drive| drive.target_by(message.delta);
                self.go(turn, session, message.motor_address, target, pace);
            }
            message => unknown(turn, session, message.id(), message.kind()),
        }
    }

    fn malformed(
        &mut self,
        turn: &mut Turn<'_>,
        session: SessionId,
        about: (MessageId, MessageType),
        error: DecodeError,
    ) {
        if self.sessions.state(session) == session::State::Closed {
            return turn.ignore(Ignored::NoSession(session));
        }
        self.sessions.heard(turn.now, session, &self.options);
        turn.ignore(Ignored::Malformed(session, error));
        if self.sessions.state(session) == session::State::Unlocked {
            match about {
                (MessageId::TRAJECTORY_DATA, MessageType::SET) => self.playback.forget(turn),
                (id, kind) => unknown(turn, session, id, kind),
            }
        }
    }

    fn doing(&self, now: Millis) -> Doing {
        let playback = &self.playback;
        Doing {
            mode: playback.mode(),
            state: playback.status(),
            inputs: self.inputs,
            times: (playback.remaining(now), playback.elapsed(now)),
            photos: playback.photos,
        }
    }

    /// One motor a message, and more until the last (decision K-M3).
    fn motor_info(&self, turn: &mut Turn<'_>) {
        let mut motors = self.drives.iter().peekable();
        if motors.peek().is_none() {
            turn.answer(What::MotorInfo { motor: None, more: false });
        }
        while let Some((motor, drive)) = motors.next() {
            let (position, (begin, end)) = (drive.position(), drive.range());
            let motor = Some(MotorReport { motor, position, begin, end });
            turn.answer(What::MotorInfo { motor, more: motors.peek().is_some() });
        }
    }

    fn reboot(&mut self, turn: &mut Turn<'_>) {
        turn.output.event(Event::StopAll);
        for session in self.sessions.all().iter() {
            turn.output.event(Event::Close(session, CloseReason::Reset));
        }
        turn.output.event(Event::Reboot);
        *self = Self { platform: self.platform, ..Self::new(self.options) };
    }

    /// A connection is gone, and what its client moved by hand stops.
    fn close(&mut self, turn: &mut Turn<'_>, session: SessionId) {
        let had_tcp = self.sessions.has_tcp();
        self.sessions.close(session);
        turn.told = self.sessions.unlocked();
        for (motor, drive) in self.drives.iter_mut() {
            match drive.motion() {
                Motion::Moving(by) if by == session => {
                    turn.output.event(Event::StopMotor { motor, acceleration: None });
                    drive.set_motion(Motion::Stopping(Sessions::NONE));
                }
                Motion::Stopping(waiting) => {
                    drive.set_motion(Motion::Stopping(waiting.without(Sessions::one(session))));
                }
                Motion::Moving(_) | Motion::Resting => {}
            }
        }
        if had_tcp && !self.sessions.has_tcp() {
            self.announce = Some(turn.now.after(self.options.announce_every));
        }
        if self.options.stop_when_alone && self.sessions.all().is_empty() && self.playback.state().runs() {
            self.stop_all(turn);
        }
    }

    fn report(&mut self, turn: &mut Turn<'_>, report: Report) {
        match report {
            Report::Started if self.on => turn.ignore(Ignored::Report),
            Report::Started => {
                self.on = true;
                self.announce = Some(turn.now);
            }
            Report::At(motor, position) | Report::Arrived(motor, position) => {
                let Some(drive) = self.drives.get_mut(motor).filter(|_| position.0.is_finite()) else {
                    return turn.ignore(Ignored::Report);
                };
                drive.is_at(position);
                if let Report::Arrived(..) = report {
                    self.arrived(turn, motor);
                }
            }
            Report::CannotHome(motor) => {
                if self.playback.is_homing() && self.drives.get(motor).is_some() {
                    self.fail(turn, ErrorCode::RETURN_TO_FIRST_KEYFRAME, MotorAddress::ALL);
                } else {
                    turn.ignore(Ignored::Report);
                }
            }
            Report::Fault(motor, code) => self.fault(turn, motor, code),
            Report::Online(motor, online) => self.online(turn, motor, online),
            Report::Inputs(inputs) => {
                self.inputs = inputs;
                turn.tell(Sessions::NONE, What::AuxInputStatus(inputs));
            }
        }
    }

    fn timers(&mut self, turn: &mut Turn<'_>) {
        for session in self.sessions.silent(turn.now).iter() {
            turn.output.event(Event::Close(session, CloseReason::Silence));
            self.close(turn, session);
        }
        let pushed = self.sessions.push(turn.now, &self.options);
        turn.send(pushed, What::NetworkInfo);
        if self.link() == Link::Advertising && self.announce.is_some_and(|announce| announce <= turn.now) {
            turn.output.send(Send { to: To::Broadcast, what: What::NetworkInfo });
            self.announce = Some(turn.now.after(self.options.announce_every));
        }
        if let Err(code) = self.playback.wake(turn, &self.drives) {
            self.fail(turn, code, MotorAddress::ALL);
        }
    }

    fn deadline(&self) -> Option<Millis> {
        let announce = self.announce.filter(|_| self.link() == Link::Advertising);
        [announce, self.sessions.deadline(), self.playback.deadline()].into_iter().flatten().min()
    }
}

impl Machine for DeviceMachine {
    type Input<'a> = Input<'a>;
    type Output = Output;

    fn step(mut self, now: Millis, input: Input<'_>) -> (Self, Output) {
        let mut output = Output::default();
        let asker = match input {
            Input::Received { session, .. } | Input::Malformed { session, .. } => Sessions::one(session),
            _ => Sessions::NONE,
        };
        let told = self.sessions.unlocked();
        let mut turn = Turn { now, options: self.options, output: &mut output, told, asker };
        match input {
            Input::Rig(Report::Started) => self.report(&mut turn, Report::Started),
            Input::Wake => {}
            _ if !self.on => turn.ignore(Ignored::Off),
            Input::Opened { session, transport, password } => {
                self.close(&mut turn, session);
                if !self.sessions.open(now, session, transport, password, &self.options) {
                    turn.output.event(Event::Close(session, CloseReason::NoRoom));
                }
            }
            Input::Closed(session) => self.close(&mut turn, session),
            Input::Received { session, message, password } => self.received(&mut turn, session, message, password),
            Input::Malformed { session, id, kind, error } => self.malformed(&mut turn, session, (id, kind), error),
            Input::Fatal(session) => {
                turn.output.event(Event::Close(session, CloseReason::Framing));
                self.close(&mut turn, session);
            }
            Input::Datagram(HostMessage::GetNetworkInfo(question)) => {
                let broadcast = question.limited_response.is_some_and(Bool::get);
                let to = if broadcast { To::Broadcast } else { To::Asker };
                turn.output.send(Send { to, what: What::NetworkInfo });
            }
            Input::Datagram(_) => turn.ignore(Ignored::Datagram),
            Input::Rig(report) => self.report(&mut turn, report),
        }
        turn.told = self.sessions.unlocked();
        turn.asker = Sessions::NONE;
        self.timers(&mut turn);
        output.wake = self.deadline().map(|deadline| deadline.max(now.after(1))).filter(|&wake| wake > now);
        (self, output)
    }
}

/// Which way a move is to be played. What has no meaning that is known moves nothing (decision K-J7).
fn way(turn: &mut Turn<'_>, direction: PlaybackDirection, start_time: Seconds) -> Option<Direction> {
    if start_time.0 != 0.0 {
        turn.refuse(ErrorCode::INVALID_MOVE_TIME);
        return None;
    }
    let way = Direction::of(direction);
    if way.is_none() {
        turn.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
    }
    way
}

/// A message that the device does not know is sent back, unless it is one that only devices send (decision K-P10).
fn unknown(turn: &mut Turn<'_>, session: SessionId, id: MessageId, kind: MessageType) {
    if id == MessageId::NOTIFICATION || !matches!(kind, MessageType::SET | MessageType::GET) {
        return turn.ignore(Ignored::NotForDevices(session));
    }
    turn.answer(What::UnsupportedMessage);
    turn.ignore(Ignored::Unsupported(session));
}
