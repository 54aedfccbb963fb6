//! The machine of a device: which client may do what, and what is answered (kOS 7.1).

use motion_core::time::Millis;
use motion_core::wire::{Bool, DecodeError, Messages as _, Password};
use motion_core::{debug, machine, states};

use super::Output;
use super::clients::{self, DisconnectReason, SessionId, Sessions, Table};
use super::effects::Effects;
use super::event::{Event, Ignored};
use super::input::{Input, Report};
use super::motor::{Drive, Drives, Motion};
use super::options::{Options, Quirks};
use super::playback::{self, Playback, Rig};
use super::transmit::{Activity, Contents, Destination, MotorReport};
use crate::HostMessage;
use crate::frame::{self, MessageId, MessageType};
use crate::message::{
    ActionId, AuxInputs, Direction, ErrorCode, LedMode, MotorAddress, MotorSet, PlaybackDirection, Seconds,
};
use crate::move_summary::MoveSummary;

states! {
    /// State of the link: whether the device can be found and connected to.
    pub enum Link {
        /// The device starts, or starts anew.
        Rebooting,
        /// No client is connected over TCP, and the device tells its address every five seconds.
        Advertising,
        /// A client is connected over TCP.
        Connected,
    }
}

/// Machine of a device: see the [module](super).
///
/// A device has `MOVES`, unless its machine is made [`without_moves`](Self::without_moves). Then the program has no code to check
/// and to play moves.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct DeviceMachine<const MOVES: bool = true> {
    pub(super) options: Options,
    on: bool,
    /// Time at which the device tells its address again.
    announce: Option<Millis>,
    pub(super) sessions: Table,
    pub(super) drives: Drives,
    /// Motors of which nobody knows whether they rest: they went off line while they moved, or the device started anew.
    pub(super) gone: MotorSet,
    pub(super) playback: Playback<MOVES>,
    /// Time at which the shutter of a single photo closes.
    pub(super) shutter: Option<Millis>,
    inputs: AuxInputs,
    leds: (LedMode, LedMode),
    platform: u8,
}

debug! { [impl<const MOVES: bool>] DeviceMachine<MOVES> { options on announce sessions drives gone playback shutter inputs leds platform } }

machine! { [impl<const MOVES: bool>] DeviceMachine<MOVES> }

impl DeviceMachine {
    /// Makes a device that is switched off: [`Report::Started`] follows.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self::with(options)
    }
}

impl DeviceMachine<false> {
    /// Makes a device that stores and plays no moves, and that is switched off: [`Report::Started`] follows.
    ///
    /// It answers `TrajectoryData`, `SetupPlayback`, `StartPlayback` and `RapidToFirstKeyFrame` with `UnsupportedMessage`, and the
    /// question for its move with a message without blocks. `StopPlayback` stops everything, as on each device.
    #[must_use]
    pub fn without_moves(options: Options) -> Self {
        Self::with(options)
    }
}

impl<const MOVES: bool> DeviceMachine<MOVES> {
    fn with(options: Options) -> Self {
        Self {
            options,
            on: false,
            announce: None,
            sessions: Table::default(),
            drives: Drives::new(options.motors()),
            gone: MotorSet::NONE,
            playback: Playback::default(),
            shutter: None,
            inputs: AuxInputs::default(),
            leds: (LedMode::OFF, LedMode::OFF),
            platform: options.platform(),
        }
    }

    /// State of the link.
    #[must_use]
    pub fn link(&self) -> Link {
        match (self.on, self.sessions.has_tcp()) {
            (false, _) => Link::Rebooting,
            (true, false) => Link::Advertising,
            (true, true) => Link::Connected,
        }
    }

    /// State of a connection.
    #[must_use]
    pub fn session(&self, session: SessionId) -> clients::State {
        self.sessions.state(session)
    }

    /// State of the move.
    #[must_use]
    pub const fn playback(&self) -> playback::State {
        self.playback.state()
    }

    /// Move that is stored.
    #[must_use]
    pub const fn stored_move(&self) -> Option<&MoveSummary> {
        self.playback.plan()
    }

    /// Whether anything may move because of what this device was told.
    ///
    /// It is yes while a move runs or waits for its time, while the shutter is open for a photo, and until the rig reported
    /// of each motor that was sent or stopped by hand that it rests. It stays yes when such a motor goes off line, and when
    /// the device starts anew.
    #[must_use]
    pub fn may_move(&self) -> bool {
        self.playback.state().runs() || !self.moving().is_empty() || self.shutter.is_some()
    }

    /// Motors that are not known to rest.
    fn moving(&self) -> MotorSet {
        self.drives.moving().with(self.playback.travelling()).with(self.gone)
    }

    /// Motor, if it is there.
    #[must_use]
    pub fn motor(&self, motor: MotorAddress) -> Option<&Drive> {
        self.drives.get(motor)
    }

    fn received<'a>(
        &mut self,
        now: Millis,
        output: &mut Effects<'_, 'a>,
        session: SessionId,
        (message, bytes): (HostMessage<'a>, &'a [u8]),
        stored: Password<'_>,
    ) {
        let locked = match self.sessions.state(session) {
            clients::State::Closed => return output.ignore(Ignored::NoSession(session)),
            clients::State::Locked => true,
            clients::State::Unlocked => false,
        };
        self.sessions.message_received(now, session, &self.options);
        // Stops come first, and ask for no password (safety decision 2).
        let obeys_stops = self.knows(&message) && !(locked && self.options.has(Quirks::LOCKED_IGNORES_STOPS));
        match message {
            HostMessage::StopPlayback(_) if obeys_stops => self.stop_all(now, output),
            HostMessage::SetPositionSpeedAcceleration(message) if obeys_stops && message.is_stop() => {
                self.stop_motor(now, output, message.motor_address, message.acceleration);
            }
            HostMessage::BumpPositionSpeedAcceleration(message) if obeys_stops && message.is_stop() => {
                self.stop_motor(now, output, message.motor_address, message.acceleration);
            }
            HostMessage::KeepAlive(_) => {}
            HostMessage::GetNetworkInfo(_) => output.answer(Contents::NetworkInfo),
            HostMessage::GetDeviceInfo(_) => output.answer(Contents::DeviceInfo(self.activity(now))),
            HostMessage::SetUserPassword(given) => {
                if !self.sessions.user_password(session, given.password, stored) {
                    output.answer_error(ErrorCode::LOCKED_OUT, MotorAddress::ALL);
                    output.ignore(Ignored::WrongPassword(session));
                }
            }
            _ if locked => output.ignore(Ignored::Locked(session)),
            message if !self.knows(&message) => unknown(output, session, (message.id(), message.kind(), bytes)),
            message => self.unlocked(now, output, session, (message, bytes), stored),
        }
    }

    /// Whether the device knows a message of the table.
    fn knows(&self, message: &HostMessage<'_>) -> bool {
        match frame::parts(message.number()) {
            (MessageId::ACTION, _, Some((_, action))) => !self.options.unsupported().contains(ActionId(action)),
            (id, ..) => id != MessageId::SOFTWARE_ID || !self.options.has(Quirks::NO_SOFTWARE_ID),
        }
    }

    fn unlocked<'a>(
        &mut self,
        now: Millis,
        output: &mut Effects<'_, 'a>,
        session: SessionId,
        (message, bytes): (HostMessage<'a>, &'a [u8]),
        stored: Password<'_>,
    ) {
        let rig = Rig::of(&self.drives, &self.options);
        match message {
            HostMessage::SetDevicePassword(given) => {
                self.sessions.device_password(given.password, stored);
                output.event(Event::StorePassword(given.password));
            }
            HostMessage::GetLEDStatus(_) => {
                let (master, slave) = self.leds;
                output.answer(Contents::LedStatus { master, slave });
            }
            HostMessage::SetLEDStatus(leds) => {
                let (master, slave) = (leds.master_status, leds.slave_status);
                if master.name().is_none() || slave.name().is_none() {
                    return output.ignore(Ignored::Unsupported(session));
                }
                self.leds = (master, slave);
                output.event(Event::Leds { master, slave });
            }
            HostMessage::GetMotorInfo(_) => self.motor_info(output),
            HostMessage::GetTrajectoryData(_) => {
                output.answer(Contents::TrajectoryData { stored: self.playback.plan().is_some() });
            }
            HostMessage::SetTrajectoryData(data) if MOVES => self.playback.store(output, data),
            HostMessage::GetDeviceGUID(_) => output.answer(Contents::DeviceGuid),
            HostMessage::GetSoftwareID(_) => output.answer(Contents::SoftwareId { platform: self.platform }),
            HostMessage::SetSoftwareID(software) => {
                self.platform = software.platform;
                output.event(Event::StorePlatform(software.platform));
            }
            HostMessage::ResetDevice(_) => self.reboot(output),
            HostMessage::ResetAxis(message) => self.reset_axis(output, message.motor_address),
            HostMessage::MarkBeginPosition(message) => self.mark_begin(output, message.motor_address),
            HostMessage::MarkEndPosition(message) => self.mark_end(output, message.motor_address),
            HostMessage::SetupPlayback(message) if MOVES => {
                if let Some(way) = self.way(output, message.direction, message.start_time) {
                    self.playback.setup(now, output, rig, way, message.delay_return.get());
                }
            }
            HostMessage::StartPlayback(message) if MOVES => {
                if let Some(way) = self.way(output, message.direction, message.start_time) {
                    self.playback.start(now, output, rig, way);
                }
            }
            HostMessage::RapidToFirstKeyFrame(_) if MOVES => self.playback.rapid(now, output, rig),
            HostMessage::TakePicture(message) => self.take_picture(now, output, message.exposure),
            HostMessage::SetPositionSpeedAcceleration(message) => {
                let pace = (message.speed, message.acceleration);
                let target = |drive: &Drive, clamps| drive.target(message.position, clamps);
                self.go(output, session, message.motor_address, target, pace);
            }
            HostMessage::BumpPositionSpeedAcceleration(message) => {
                let pace = (message.speed, message.acceleration);
                let target = |drive: &Drive, clamps| drive.target_by(message.delta, clamps);
                self.go(output, session, message.motor_address, target, pace);
            }
            message => unknown(output, session, (message.id(), message.kind(), bytes)),
        }
    }

    fn malformed<'a>(
        &mut self,
        now: Millis,
        output: &mut Effects<'_, 'a>,
        session: SessionId,
        about: (MessageId, MessageType, &'a [u8]),
        error: DecodeError,
    ) {
        if self.sessions.state(session) == clients::State::Closed {
            return output.ignore(Ignored::NoSession(session));
        }
        self.sessions.message_received(now, session, &self.options);
        output.ignore(Ignored::Malformed(session, error));
        if self.sessions.state(session) == clients::State::Unlocked {
            match about {
                (MessageId::TRAJECTORY_DATA, MessageType::SET, _) if MOVES => self.playback.forget(output),
                about => unknown(output, session, about),
            }
        }
    }

    fn activity(&self, now: Millis) -> Activity {
        let playback = &self.playback;
        Activity {
            mode: playback.mode(),
            state: playback.status(),
            inputs: self.inputs,
            times: (playback.remaining(now), playback.elapsed(now)),
            photos: playback.photos,
        }
    }

    /// Direction in which a move is to be played. Numbers without a known meaning move nothing (decision K-J7).
    fn way(
        &self,
        output: &mut Effects<'_, '_>,
        direction: PlaybackDirection,
        start_time: Seconds,
    ) -> Option<Direction> {
        if start_time.0 != 0.0 {
            output.refuse(ErrorCode::INVALID_MOVE_TIME);
            return None;
        }
        if self.options.has(Quirks::IGNORES_DIRECTION) {
            return Some(Direction::Forward);
        }
        let way = Direction::of(direction);
        if way.is_none() {
            output.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        }
        way
    }

    /// Tells one motor a message, and more until the last (decision K-M3).
    fn motor_info(&self, output: &mut Effects<'_, '_>) {
        let mut motors = self.drives.iter().peekable();
        if motors.peek().is_none() {
            output.answer(Contents::MotorInfo { motor: None, more: false });
        }
        while let Some((motor, drive)) = motors.next() {
            let (position, (begin, end)) = (drive.position(), drive.range());
            let motor = Some(MotorReport { motor, position, begin, end });
            output.answer(Contents::MotorInfo { motor, more: motors.peek().is_some() });
        }
    }

    fn reboot(&mut self, output: &mut Effects<'_, '_>) {
        output.event(Event::StopAll);
        for session in self.sessions.all().iter() {
            output.event(Event::Disconnect { session, reason: DisconnectReason::Reset });
        }
        output.event(Event::Reboot);
        *self = Self { platform: self.platform, gone: self.moving(), ..Self::with(self.options) };
    }

    /// Closes a connection, after what its client moved by hand is stopped.
    fn disconnect(&mut self, now: Millis, output: &mut Effects<'_, '_>, session: SessionId, reason: DisconnectReason) {
        self.close(now, output, session);
        output.event(Event::Disconnect { session, reason });
    }

    /// A connection is gone, and what its client moved by hand stops.
    fn close(&mut self, now: Millis, output: &mut Effects<'_, '_>, session: SessionId) {
        let had_tcp = self.sessions.has_tcp();
        self.sessions.close(session);
        output.told = self.sessions.unlocked();
        for (motor, drive) in self.drives.iter_mut() {
            match drive.motion() {
                Motion::Moving(by) if by == session => {
                    output.event(Event::StopMotor { motor, acceleration: None });
                    drive.set_motion(Motion::Stopping(Sessions::NONE));
                }
                Motion::Stopping(waiting) => {
                    drive.set_motion(Motion::Stopping(waiting.without(Sessions::one(session))));
                }
                Motion::Moving(_) | Motion::Resting => {}
            }
        }
        if had_tcp && !self.sessions.has_tcp() {
            self.announce = Some(now.after(self.options.announce_every()));
        }
        if self.options.stop_when_alone() && self.sessions.all().is_empty() && self.playback.state().runs() {
            self.stop_all(now, output);
        }
    }

    fn report(&mut self, now: Millis, output: &mut Effects<'_, '_>, report: Report) {
        match report {
            Report::Started if self.on => output.ignore(Ignored::Report),
            Report::Started => {
                self.on = true;
                self.announce = Some(now);
                self.stop_again(output);
            }
            Report::At(motor, position) | Report::Arrived(motor, position) => {
                let Some(drive) = self.drives.get_mut(motor).filter(|_| position.0.is_finite()) else {
                    return output.ignore(Ignored::Report);
                };
                drive.is_at(position);
                if let Report::Arrived(..) = report {
                    self.arrived(now, output, motor);
                }
            }
            Report::CannotHome(motor) => {
                if self.playback.is_homing() && self.drives.get(motor).is_some() {
                    self.fail(now, output, ErrorCode::RETURN_TO_FIRST_KEYFRAME, MotorAddress::ALL);
                } else {
                    output.ignore(Ignored::Report);
                }
            }
            Report::Fault(motor, code) => self.fault(now, output, motor, code),
            Report::Online(motor, online) => self.online(now, output, motor, online),
            Report::Inputs(inputs) => {
                self.inputs = inputs;
                output.tell(Sessions::NONE, Contents::AuxInputStatus(inputs));
            }
        }
    }

    fn timers(&mut self, now: Millis, output: &mut Effects<'_, '_>) {
        for session in self.sessions.silent(now).iter() {
            self.disconnect(now, output, session, DisconnectReason::Silence);
        }
        self.shutter = self.shutter.filter(|closes| *closes > now);
        let pushed = self.sessions.push(now, &self.options);
        output.transmit(Destination::Sessions(pushed), Contents::NetworkInfo);
        if self.link() == Link::Advertising && self.announce.is_some_and(|announce| announce <= now) {
            output.transmit(Destination::Broadcast, Contents::NetworkInfo);
            self.announce = Some(now.after(self.options.announce_every()));
        }
        if let Err(code) = self.playback.wake(now, output, Rig::of(&self.drives, &self.options)) {
            self.fail(now, output, code, MotorAddress::ALL);
        }
    }

    fn deadline(&self) -> Option<Millis> {
        let announce = self.announce.filter(|_| self.link() == Link::Advertising);
        [announce, self.sessions.deadline(), self.playback.deadline(), self.shutter].into_iter().flatten().min()
    }

    fn run<'a>(&mut self, now: Millis, output: &mut Output<'a>, input: Input<'a>) {
        let asker = match input {
            Input::Received { session, .. } | Input::Malformed { session, .. } => Sessions::one(session),
            _ => Sessions::NONE,
        };
        let mut output = Effects { output, told: self.sessions.unlocked(), asker };
        self.take(now, &mut output, input);
        (output.told, output.asker) = (self.sessions.unlocked(), Sessions::NONE);
        self.timers(now, &mut output);
        output.output.wake = self.deadline().map(|deadline| deadline.max(now.after(1)));
    }

    fn take<'a>(&mut self, now: Millis, output: &mut Effects<'_, 'a>, input: Input<'a>) {
        match input {
            Input::Rig(Report::Started) => self.report(now, output, Report::Started),
            Input::Stop => self.stop_all(now, output),
            Input::Wake => {}
            Input::Rig(Report::Arrived(motor, position)) if self.gone.contains(motor) && position.0.is_finite() => {
                self.gone.remove(motor);
            }
            _ if !self.on => output.ignore(Ignored::Off),
            Input::LinkUp { session, transport, password } => {
                self.close(now, output, session);
                if !self.sessions.open(now, session, transport, password, &self.options) {
                    output.event(Event::Disconnect { session, reason: DisconnectReason::NoRoom });
                }
            }
            Input::LinkDown(session) => self.close(now, output, session),
            Input::Received { session, message, bytes, password } => {
                self.received(now, output, session, (message, bytes), password);
            }
            Input::Malformed { session, id, kind, error, bytes } => {
                self.malformed(now, output, session, (id, kind, bytes), error);
            }
            Input::Fatal(session) => self.disconnect(now, output, session, DisconnectReason::Framing),
            Input::Datagram { from, message: HostMessage::GetNetworkInfo(question) } => {
                let broadcast = question.limited_response.is_some_and(Bool::get);
                let destination = if broadcast { Destination::Broadcast } else { Destination::Datagram(from) };
                output.transmit(destination, Contents::NetworkInfo);
            }
            Input::Datagram { .. } => output.ignore(Ignored::Datagram),
            Input::Rig(report) => self.report(now, output, report),
        }
    }
}

/// Sends a message back that the device does not know, unless it is one that only devices send (decision K-P10).
fn unknown<'a>(
    output: &mut Effects<'_, 'a>,
    session: SessionId,
    (id, kind, bytes): (MessageId, MessageType, &'a [u8]),
) {
    if id == MessageId::NOTIFICATION || matches!(kind, MessageType::RESPONSE | MessageType::RESPONSE_MORE) {
        return output.ignore(Ignored::NotForDevices(session));
    }
    output.answer(Contents::UnsupportedMessage(bytes));
    output.ignore(Ignored::Unsupported(session));
}
