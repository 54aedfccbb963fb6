//! The machine of a client: connection, questions, and keep-alive (kOS 7.2).

use motion_core::time::Millis;
use motion_core::{debug, machine, states};

use super::Output;
use super::calibration::{Calibration, CalibrationState};
use super::event::{Event, Failure, LinkDownReason, MoveState, Outcome, StopTarget};
use super::input::{Endpoint, Get, Input};
use super::motors::Motors;
use super::options::{Identity, Options};
use super::playback::Playback;
use super::requests::{Asker, Fence, Requests};
use super::stops::Stops;
use super::transmit::{PasswordOf, Transmit};
use crate::message::Motor;
use crate::transport::Transport;

states! {
    /// State of the connection.
    pub enum State {
        /// There is no connection, and none is wanted.
        Discovering,
        /// The connection is being made.
        Connecting,
        /// The device has to say what it is.
        AwaitDeviceInfo,
        /// The device has to say which motors it has; it does so if the password is right.
        AwaitMotorInfo,
        /// The device has to say which of all devices it is.
        AwaitGuid,
        /// The device has to say which platform calibrated it.
        AwaitSoftware,
        /// The device wants a password.
        Locked,
        /// The device can be used.
        Ready,
        /// The connection is lost, and may be made again soon.
        Disconnected,
    }
}

impl State {
    /// Whether there is a connection.
    #[must_use]
    pub const fn is_connected(self) -> bool {
        !matches!(self, Self::Discovering | Self::Connecting | Self::Disconnected)
    }
}

/// Deadlines of the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
struct Deadlines {
    /// Time at which a keep-alive is due because nothing was sent; over USB it is due anyway.
    quiet: Millis,
    /// Time at which a keep-alive is due because nothing was received.
    deaf: Millis,
    /// Time at which the connection is given up because nothing was received.
    silent: Option<Millis>,
}

/// Machine of a client: see the [module](super).
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct HostMachine {
    pub(super) options: Options,
    pub(super) state: State,
    pub(super) endpoint: Option<Endpoint>,
    /// Time at which to ask who is there, or to connect again.
    at: Option<Millis>,
    /// Number of questions what the device is, or of tries to connect.
    pub(super) tries: u8,
    deadlines: Deadlines,
    pub(super) requests: Requests,
    pub(super) fence: Fence,
    /// Number of questions what the device is, less the answers, also after they were not waited for any longer.
    pub(super) owed: u8,
    pub(super) motors: Motors,
    pub(super) calibration: Calibration,
    pub(super) playback: Playback,
    pub(super) stops: Stops,
    guid: Option<[u8; 16]>,
    platform: Option<u8>,
    expected: Option<Identity>,
    /// Whether the device could be used before.
    was_ready: bool,
}

debug! {
    HostMachine {
        options state endpoint at tries deadlines requests fence owed motors calibration playback stops guid platform
        expected was_ready
    }
}

machine! { HostMachine }

impl HostMachine {
    /// Number of times that the time before another try is doubled.
    const DOUBLINGS: u8 = 5;

    /// Makes a client without a connection.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self {
            options,
            state: State::Discovering,
            endpoint: None,
            at: None,
            tries: 0,
            deadlines: Deadlines::default(),
            requests: Requests::default(),
            fence: Fence::Down,
            owed: 0,
            motors: Motors::default(),
            calibration: Calibration::default(),
            playback: Playback::default(),
            stops: Stops::default(),
            guid: None,
            platform: None,
            expected: options.expected(),
            was_ready: false,
        }
    }

    /// State of the connection.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state
    }

    /// State of the move on the device.
    #[must_use]
    pub const fn move_state(&self) -> MoveState {
        self.playback.state
    }

    /// Number of times that the move was played again, back or forward; at most 255.
    #[must_use]
    pub const fn loops(&self) -> u8 {
        self.playback.loops()
    }

    /// State of the range whose end was marked last.
    #[must_use]
    pub const fn calibration(&self) -> CalibrationState {
        self.calibration.state()
    }

    /// Motors that the device has, as it reported last. A motor that went off line stays here until it is known to rest.
    pub fn motors(&self) -> impl Iterator<Item = &Motor> {
        self.motors.iter()
    }

    /// Whether anything may still move because of this client.
    ///
    /// The answer is no only if rest is known: no command that may move was sent since, or the device reported the end of
    /// what it began. It stays yes when the connection goes down and when a motor goes off line, until a stop of
    /// everything is confirmed.
    #[must_use]
    pub fn may_move(&self) -> bool {
        self.stops.may_move() || !self.playback.moving().is_empty() || self.motors.any_moves()
    }

    /// Whether anything moves as far as is known, whoever moves it.
    pub(super) fn moves(&self) -> bool {
        self.playback.moves() || self.motors.any_moves()
    }

    /// Number of the device, if it has one of 16 bytes.
    #[must_use]
    pub const fn guid(&self) -> Option<[u8; 16]> {
        self.guid
    }

    /// Platform that calibrated the motors, if the device told it.
    #[must_use]
    pub const fn platform(&self) -> Option<u8> {
        self.platform
    }

    /// The password is wrong or missing. A device that is locked will not say which motors it has.
    pub(super) fn lock(&mut self, output: &mut Output<'_>, wrong_password: bool) {
        if let Some(Asker::Application(token)) = self.requests.end(Get::MotorInfo) {
            output.event(Event::ended(token, Outcome::Failed(Failure::NoAnswer)));
        }
        self.state = State::Locked;
        output.event(Event::Locked { wrong_password });
        // A stop that is wanted goes on, and is sent again when its time has come. But a locked device may ignore it.
        if self.playback.wants_stop() || self.stops.is_blind() {
            output.event(Event::StopNotConfirmed(StopTarget::All));
        }
        self.motors.tell_unconfirmed(output);
    }

    /// Tells the device the password, and asks for its motors. Over USB there is no password (decision K-U7).
    ///
    /// A locked device may ignore stops. So those that are wanted are sent again after the password, and only reports that
    /// come after it confirm them (decision K-S23).
    pub(super) fn unlock<'a>(&mut self, now: Millis, output: &mut Output<'a>, of: PasswordOf<'a>) {
        self.state = State::AwaitMotorInfo;
        if self.is_tcp() {
            output.transmit(Transmit::UserPassword(of));
            let mut is_sent = self.playback.state == MoveState::Stopping;
            if is_sent {
                self.await_rest();
                self.stop_playback(now, output);
            }
            is_sent |= self.motors.stop_again(now, output, &self.options);
            is_sent |= self.stop_deferred(now, output, self.stops.deferred());
            if is_sent {
                self.raise_fence(now, output);
            }
        }
        self.ask(now, output, Get::MotorInfo, Asker::Machine);
    }

    /// Whether the connection is over TCP.
    pub(super) fn is_tcp(&self) -> bool {
        self.endpoint.is_some_and(|endpoint| endpoint.transport() == Transport::Tcp)
    }

    pub(super) fn has_motors(&mut self, now: Millis, output: &mut Output<'_>) {
        self.state = State::AwaitGuid;
        self.ask(now, output, Get::DeviceGuid, Asker::Machine);
    }

    pub(super) fn has_guid(&mut self, now: Millis, output: &mut Output<'_>, guid: Option<[u8; 16]>) {
        self.guid = guid;
        self.state = State::AwaitSoftware;
        self.ask(now, output, Get::SoftwareId, Asker::Machine);
    }

    pub(super) fn has_platform(&mut self, output: &mut Output<'_>, platform: Option<u8>) {
        self.platform = platform;
        let identity = self.guid.zip(platform).map(|(guid, platform)| Identity { guid, platform });
        let ranges_void = identity.is_none() || identity != self.expected;
        self.expected = identity.or(self.expected);
        (self.state, self.tries) = (State::Ready, 0);
        output.event(Event::Ready { reconnected: self.was_ready, ranges_void });
        self.was_ready = true;
    }

    pub(super) fn connect(&mut self, output: &mut Output<'_>, endpoint: Endpoint) {
        (self.endpoint, self.state, self.at) = (Some(endpoint), State::Connecting, None);
        output.event(Event::Connect(endpoint));
    }

    /// The connection is there. Stops that were not confirmed go first.
    fn link_up(&mut self, now: Millis, output: &mut Output<'_>) {
        let Some(endpoint) = self.endpoint.filter(|_| self.state == State::Connecting) else {
            return output.event(Event::Ignored);
        };
        (self.state, self.tries) = (State::AwaitDeviceInfo, 1);
        let keep_alive = match endpoint.transport() {
            Transport::Tcp => self.options.tcp_keep_alive(),
            Transport::Usb => self.options.usb_keep_alive(),
        };
        let silent = (endpoint.transport() == Transport::Tcp).then(|| now.after(self.options.silence()));
        self.deadlines = Deadlines { quiet: now.after(keep_alive), deaf: now.after(keep_alive), silent };
        let mut is_sent = self.playback.state == MoveState::Stopping;
        if is_sent {
            self.stop_playback(now, output);
        }
        is_sent |= self.stop_deferred(now, output, self.stops.deferred());
        if is_sent {
            self.raise_fence(now, output);
        } else {
            self.ask(now, output, Get::DeviceInfo, Asker::Machine);
        }
    }

    /// The connection is over.
    pub(super) fn close(&mut self, now: Millis, output: &mut Output<'_>, why: LinkDownReason) {
        for get in Get::ALL {
            if let Some(Asker::Application(token)) = self.requests.end(get) {
                output.event(Event::ended(token, Outcome::Failed(Failure::LinkDown)));
            }
        }
        self.calibration.lost(output);
        self.motors.lost(output, &mut self.stops);
        self.playback.lost(output, &mut self.stops);
        if self.stops.lost(output) {
            // The device obeyed, but nobody knows whether all rest: the next connection begins with another stop.
            self.playback.stop(output, None);
        }
        output.event(Event::LinkDown(why));
        (self.fence, self.owed, self.deadlines) = (Fence::Down, 0, Deadlines::default());
        if why == LinkDownReason::Asked {
            (self.state, self.endpoint, self.tries) = (State::Discovering, None, 0);
            self.at = self.options.ask_every().map(|every| now.after(every));
        } else {
            // The tries counted questions what the device is, unless it was never connected.
            let doublings = if self.state == State::Connecting { self.tries.min(Self::DOUBLINGS) } else { 0 };
            self.tries = doublings.saturating_add(1);
            let wait = self.options.back_off().saturating_mul(1_u64.wrapping_shl(doublings.into()));
            (self.state, self.at) = (State::Disconnected, Some(now.after(wait)));
        }
    }

    fn timers(&mut self, now: Millis, output: &mut Output<'_>) {
        if self.state == State::Disconnected && self.at.is_some_and(|at| at <= now) {
            (self.state, self.at) = (State::Discovering, None);
            if let Some(endpoint) = self.endpoint.filter(|_| self.options.reconnect()) {
                self.connect(output, endpoint);
            }
        }
        if let (State::Discovering, Some(every)) = (self.state, self.options.ask_every()) {
            if self.at.is_none_or(|at| at <= now) {
                output.transmit(Transmit::Discover);
                self.at = Some(now.after(every));
            }
        }
        if self.state.is_connected() && self.deadlines.silent.is_some_and(|silent| silent <= now) {
            self.close(now, output, LinkDownReason::Silence);
        }
        if self.stale().is_some_and(|stale| stale <= now) {
            self.close(now, output, LinkDownReason::NoAnswer);
        }
        if self.playback.wake(now, output) {
            self.stop_playback(now, output);
            self.raise_fence(now, output);
        }
        if self.motors.wake(now, output, &self.options) {
            self.raise_fence(now, output);
        }
        for _ in Get::ALL {
            if let Some(get) = self.requests.expired(now) {
                self.failed(now, output, get, Failure::NoAnswer);
            }
        }
        self.calibration.wake(now, output);
        self.stops.wake(now, output);
        self.keep_alive(now, output);
        if self.fence == Fence::Down {
            self.settle(output);
        }
        self.motors.drop_gone(self.stops.astray());
    }

    /// Ends the stops that are confirmed. All that was sent before them has been answered.
    fn settle(&mut self, output: &mut Output<'_>) {
        self.playback.settle();
        self.motors.settle(output, &mut self.stops);
        if self.playback.state != MoveState::Stopping && self.stops.settle(output) {
            self.motors.all_rest();
        }
    }

    /// Keeps the line alive. Over TCP a question does it, also if much is sent and nothing is received: the device may
    /// have nothing to say (decision K-S15).
    fn keep_alive(&mut self, now: Millis, output: &mut Output<'_>) {
        let Some(endpoint) = self.endpoint.filter(|_| self.state.is_connected()) else { return };
        let quiet = self.deadlines.quiet <= now;
        match endpoint.transport() {
            Transport::Usb if quiet => {
                output.transmit(Transmit::KeepAlive);
                self.deadlines.quiet = now.after(self.options.usb_keep_alive());
                // The report that a move is over may be lost (decision K-S21).
                if self.playback.state.runs() {
                    self.ask(now, output, Get::DeviceInfo, Asker::Machine);
                }
            }
            Transport::Usb => {}
            Transport::Tcp => {
                let (deaf, next) = (self.deadlines.deaf <= now, now.after(self.options.tcp_keep_alive()));
                let sends = output.transmits().next().is_some();
                if deaf || (quiet && !sends) {
                    self.ask(now, output, Get::NetworkInfo, Asker::Machine);
                    self.deadlines.deaf = next;
                }
                if quiet || output.transmits().next().is_some() {
                    self.deadlines.quiet = next;
                }
            }
        }
    }

    /// The device sent something, so it is there.
    pub(super) fn message_received(&mut self, now: Millis) {
        if let Some(silent) = &mut self.deadlines.silent {
            *silent = now.after(self.options.silence());
            self.deadlines.deaf = now.after(self.options.tcp_keep_alive());
        }
    }

    fn deadline(&self) -> Option<Millis> {
        let line = self.state.is_connected().then(|| match self.deadlines {
            Deadlines { quiet, deaf, silent: Some(silent) } => quiet.min(deaf).min(silent),
            Deadlines { quiet, .. } => quiet,
        });
        let own = [self.at, line, self.stale(), self.requests.deadline(), self.playback.deadline()];
        let parts = [self.motors.deadline(), self.calibration.deadline(), self.stops.deadline()];
        own.into_iter().chain(parts).flatten().min()
    }

    fn run<'a>(&mut self, now: Millis, output: &mut Output<'a>, input: Input<'a>) {
        match input {
            Input::Command(token, command) => self.command(now, output, token, command),
            Input::LinkUp => self.link_up(now, output),
            Input::LinkDown if self.state.is_connected() || self.state == State::Connecting => {
                self.close(now, output, LinkDownReason::Ended);
            }
            Input::Fatal if self.state.is_connected() => self.close(now, output, LinkDownReason::Framing),
            Input::Received(message) if self.state.is_connected() => self.received(now, output, message),
            Input::Malformed { id, kind, error } if self.state.is_connected() => {
                self.malformed(now, output, (id, kind), error);
            }
            Input::Wake => {}
            Input::LinkDown | Input::Fatal | Input::Received(_) | Input::Malformed { .. } => {
                output.event(Event::Ignored);
            }
        }
        self.timers(now, output);
        output.wake = self.deadline().map(|deadline| deadline.max(now.after(1)));
    }
}
