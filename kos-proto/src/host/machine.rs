//! The machine of a client: connection, commands, and what the device says (kOS 7.2).

use motion_core::machine::Machine;
use motion_core::time::Millis;

use super::calibration::{self, Calibration};
use super::io::{CloseReason, Endpoint, Event, Input};
use super::motors::Motors;
use super::requests::{Asker, Failure, Get, Requests};
use super::send::{PasswordOf, Send};
use super::tracker::{self, Tracker};
use super::{Identity, Options, Output};
use crate::message::Motor;
use crate::summary::{Transport, debug_fields};

/// How far the connection is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum State {
    /// There is none, and none is wanted.
    Discovering,
    /// It is being made.
    Connecting,
    /// The device has to say what it is.
    AwaitDeviceInfo,
    /// It has to say which motors it has; it does, if the password is right.
    AwaitMotorInfo,
    /// It has to say which of all devices it is.
    AwaitGuid,
    /// It has to say which platform calibrated it.
    AwaitSoftware,
    /// It wants a password.
    Locked,
    /// It can be used.
    Ready,
    /// It is lost, and may be tried again soon.
    Disconnected,
}

impl State {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Discovering,
        Self::Connecting,
        Self::AwaitDeviceInfo,
        Self::AwaitMotorInfo,
        Self::AwaitGuid,
        Self::AwaitSoftware,
        Self::Locked,
        Self::Ready,
        Self::Disconnected,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Discovering => "Discovering",
            Self::Connecting => "Connecting",
            Self::AwaitDeviceInfo => "AwaitDeviceInfo",
            Self::AwaitMotorInfo => "AwaitMotorInfo",
            Self::AwaitGuid => "AwaitGuid",
            Self::AwaitSoftware => "AwaitSoftware",
            Self::Locked => "Locked",
            Self::Ready => "Ready",
            Self::Disconnected => "Disconnected",
        }
    }

    /// Whether there is a connection.
    #[must_use]
    pub const fn is_connected(self) -> bool {
        !matches!(self, Self::Discovering | Self::Connecting | Self::Disconnected)
    }
}

/// When the line was used for too little.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
struct Line {
    /// Nothing was sent for so long that a keep-alive is due; over USB one is due anyway.
    quiet: Millis,
    /// Nothing was heard for so long that one is due.
    deaf: Millis,
    /// Nothing was heard for so long that the connection is given up.
    silent: Option<Millis>,
}

/// A question that is asked behind a stop: when it is answered, so is all that was sent before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Fence {
    Down,
    /// It is on its way, for the so manyth time.
    Up(u8),
    /// One is on its way that was asked before the last stop; it will be asked again.
    Late,
    /// It was not answered, over TCP, where no answer is lost: only another connection has nothing late on its way. It
    /// is made in the next step, for this one has much to tell already.
    Stale(Millis),
}

/// A client: see the [module](super).
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct HostMachine {
    pub(super) options: Options,
    pub(super) state: State,
    pub(super) endpoint: Option<Endpoint>,
    /// When to ask who is there, or to connect again.
    at: Option<Millis>,
    /// How often it was asked what it is, or tried to connect.
    pub(super) tries: u8,
    line: Line,
    requests: Requests,
    fence: Fence,
    /// How often it was asked what the device is, less the answers, also where they were not waited for any longer.
    owed: u8,
    pub(super) motors: Motors,
    pub(super) calibration: Calibration,
    pub(super) tracker: Tracker,
    pub(super) guid: Option<[u8; 16]>,
    pub(super) platform: Option<u8>,
    expected: Option<Identity>,
}

debug_fields! {
    HostMachine {
        options, state, endpoint, at, tries, line, requests, fence, owed, motors, calibration, tracker, guid,
        platform, expected,
    }
}

impl HostMachine {
    /// How often a device is asked what it is, before it is given up.
    const QUESTIONS: u8 = 3;
    /// How often the time before another try is doubled.
    const DOUBLINGS: u8 = 5;

    /// A client without a connection.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self {
            options,
            state: State::Discovering,
            endpoint: None,
            at: None,
            tries: 0,
            line: Line::default(),
            requests: Requests::default(),
            fence: Fence::Down,
            owed: 0,
            motors: Motors::default(),
            calibration: Calibration::default(),
            tracker: Tracker::default(),
            guid: None,
            platform: None,
            expected: options.expected,
        }
    }

    /// How far the connection is.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state
    }

    /// How far the move on the device is.
    #[must_use]
    pub const fn move_state(&self) -> tracker::State {
        self.tracker.state
    }

    /// How often the move was played again, back or forward; up to 255.
    #[must_use]
    pub const fn loops(&self) -> u8 {
        self.tracker.loops()
    }

    /// How far the range is whose end was marked last.
    #[must_use]
    pub const fn calibration(&self) -> calibration::State {
        self.calibration.state()
    }

    /// The motors that the device has, as it said last.
    pub fn motors(&self) -> impl Iterator<Item = &Motor> {
        self.motors.iter()
    }

    /// Whether anything moves, as far as the device said.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.tracker.moves() || self.motors.any_moves()
    }

    /// The number of the device, if it has one of 16 bytes.
    #[must_use]
    pub const fn guid(&self) -> Option<[u8; 16]> {
        self.guid
    }

    /// The platform that calibrated the motors, if the device says so.
    #[must_use]
    pub const fn platform(&self) -> Option<u8> {
        self.platform
    }

    /// Asks the device something; `false` if that is asked already.
    pub(super) fn ask(&mut self, now: Millis, output: &mut Output, get: Get, asker: Asker) -> bool {
        let asks = self.requests.ask(get, asker, now.after(self.options.request_timeout));
        if asks {
            output.send(Send::Get(get));
            if get == Get::DeviceInfo {
                self.owed = self.owed.saturating_add(1);
            }
            if get == Get::MotorInfo {
                self.motors.begin_series();
            }
        }
        asks
    }

    /// A part of an answer is there; the next has the full time.
    pub(super) fn more(&mut self, now: Millis, get: Get) {
        self.requests.go_on(get, now.after(self.options.request_timeout));
    }

    /// An answer is there: who asked is told. Whether it was asked at all.
    pub(super) fn answered(&mut self, now: Millis, output: &mut Output, get: Get) -> bool {
        self.pay(get);
        // One that is late answers an earlier question, not the one behind the stop.
        let late = get == Get::DeviceInfo && matches!(self.fence, Fence::Up(_)) && self.is_owed();
        match if late { None } else { self.requests.end(get) } {
            None => {
                output.event(Event::Told(get.id()));
                if let (Fence::Stale(_), false) = (self.fence, self.is_owed()) {
                    self.fence = Fence::Down;
                }
                return false;
            }
            Some(Asker::Application(token)) => output.event(Event::Answered(get, token)),
            Some(Asker::Machine) => {}
        }
        self.passed(now, output, get);
        true
    }

    /// An answer will not come: who asked is told, or what waits for it goes on without.
    pub(super) fn failed(&mut self, now: Millis, output: &mut Output, get: Get, why: Failure) {
        if matches!(why, Failure::Unsupported | Failure::Malformed) {
            self.pay(get);
        }
        match self.requests.end(get) {
            None => return,
            Some(Asker::Application(token)) => output.event(Event::Failed(get, token, why)),
            Some(Asker::Machine) => {}
        }
        match (self.state, get) {
            (State::AwaitDeviceInfo, Get::DeviceInfo) if self.tries < Self::QUESTIONS => {
                self.tries = self.tries.saturating_add(1);
                self.ask(now, output, get, Asker::Machine);
            }
            (State::AwaitDeviceInfo, Get::DeviceInfo) => return self.close(now, output, CloseReason::NoAnswer),
            (State::AwaitMotorInfo, Get::MotorInfo) => self.lock(output),
            (State::AwaitGuid, Get::DeviceGuid) => self.has_guid(now, output, None),
            (State::AwaitSoftware, Get::SoftwareId) => self.has_platform(output, None),
            _ => {}
        }
        self.passed(now, output, get);
    }

    /// An answer is there, whatever it says.
    fn pay(&mut self, get: Get) {
        if get == Get::DeviceInfo {
            self.owed = self.owed.saturating_sub(1);
        }
    }

    /// Whether an answer is still on its way, as far as that can be known: over USB it may be lost.
    fn is_owed(&self) -> bool {
        let tcp = self.endpoint.is_some_and(|endpoint| endpoint.transport() == Transport::Tcp);
        tcp && self.owed > 0
    }

    /// A question behind a stop is over; if the last stop was sent behind it, or it is not answered, another one is
    /// asked.
    fn passed(&mut self, now: Millis, output: &mut Output, get: Get) {
        if get != Get::DeviceInfo {
            return;
        }
        self.fence = match self.fence {
            Fence::Late => self.fence_again(now, output, 0),
            Fence::Up(tries) if self.is_owed() && tries < Self::QUESTIONS => self.fence_again(now, output, tries),
            Fence::Up(_) if self.is_owed() => Fence::Stale(now.after(1)),
            Fence::Stale(at) if self.is_owed() => Fence::Stale(at),
            Fence::Down | Fence::Up(_) | Fence::Stale(_) => Fence::Down,
        };
    }

    fn fence_again(&mut self, now: Millis, output: &mut Output, tries: u8) -> Fence {
        self.ask(now, output, Get::DeviceInfo, Asker::Machine);
        Fence::Up(tries.saturating_add(1))
    }

    /// The password is wrong, or missing. A device that is locked will not say which motors it has.
    pub(super) fn lock(&mut self, output: &mut Output) {
        if let Some(Asker::Application(token)) = self.requests.end(Get::MotorInfo) {
            output.event(Event::Failed(Get::MotorInfo, token, Failure::NoAnswer));
        }
        self.state = State::Locked;
        output.event(Event::Locked);
    }

    /// The device said what it is: it gets the password, and is asked for its motors.
    pub(super) fn unlock(&mut self, now: Millis, output: &mut Output, of: PasswordOf) {
        self.state = State::AwaitMotorInfo;
        output.send(Send::UserPassword(of));
        self.ask(now, output, Get::MotorInfo, Asker::Machine);
    }

    pub(super) fn has_motors(&mut self, now: Millis, output: &mut Output) {
        self.state = State::AwaitGuid;
        self.ask(now, output, Get::DeviceGuid, Asker::Machine);
    }

    pub(super) fn has_guid(&mut self, now: Millis, output: &mut Output, guid: Option<[u8; 16]>) {
        self.guid = guid;
        self.state = State::AwaitSoftware;
        self.ask(now, output, Get::SoftwareId, Asker::Machine);
    }

    pub(super) fn has_platform(&mut self, output: &mut Output, platform: Option<u8>) {
        self.platform = platform;
        let identity = self.guid.zip(platform).map(|(guid, platform)| Identity { guid, platform });
        let ranges_void = identity.is_none() || identity != self.expected;
        self.expected = identity.or(self.expected);
        (self.state, self.tries) = (State::Ready, 0);
        output.event(Event::Ready { ranges_void });
    }

    /// Stops the move: whatever it is, and whoever began it.
    pub(super) fn stop_move(&mut self, now: Millis, output: &mut Output) {
        output.send(Send::StopPlayback);
        self.tracker.stop(Some(now.after(self.options.stop_timeout)));
    }

    /// Asks behind a stop, so that its confirmation is told from one that comes late.
    pub(super) fn raise_fence(&mut self, now: Millis, output: &mut Output) {
        self.fence = if self.ask(now, output, Get::DeviceInfo, Asker::Machine) { Fence::Up(1) } else { Fence::Late };
    }

    pub(super) fn open(&mut self, output: &mut Output, endpoint: Endpoint) {
        (self.endpoint, self.state, self.at) = (Some(endpoint), State::Connecting, None);
        output.event(Event::Open(endpoint));
    }

    /// The connection is there. A stop that was not confirmed goes first.
    fn opened(&mut self, now: Millis, output: &mut Output) {
        let Some(endpoint) = self.endpoint.filter(|_| self.state == State::Connecting) else {
            return output.event(Event::Ignored);
        };
        (self.state, self.tries) = (State::AwaitDeviceInfo, 1);
        let keep_alive = match endpoint.transport() {
            Transport::Tcp => self.options.tcp_keep_alive,
            Transport::Usb => self.options.usb_keep_alive,
        };
        let silent = (endpoint.transport() == Transport::Tcp).then(|| now.after(self.options.silence));
        self.line = Line { quiet: now.after(keep_alive), deaf: now.after(keep_alive), silent };
        if self.tracker.state == tracker::State::Stopping {
            self.stop_move(now, output);
            self.raise_fence(now, output);
        } else {
            self.ask(now, output, Get::DeviceInfo, Asker::Machine);
        }
    }

    /// The connection is over.
    pub(super) fn close(&mut self, now: Millis, output: &mut Output, why: CloseReason) {
        for get in Get::ALL {
            if let Some(Asker::Application(token)) = self.requests.end(get) {
                output.event(Event::Failed(get, token, Failure::Closed));
            }
        }
        self.calibration.lost(output);
        self.motors.lost(output);
        self.tracker.lost(output);
        output.event(Event::Closed(why));
        (self.fence, self.owed, self.line) = (Fence::Down, 0, Line::default());
        if why == CloseReason::Asked {
            (self.state, self.endpoint, self.tries) = (State::Discovering, None, 0);
            self.at = self.options.ask_every.map(|every| now.after(every));
        } else {
            // It was asked what it is, not tried to be connected, unless it was never connected.
            let doublings = if self.state == State::Connecting { self.tries.min(Self::DOUBLINGS) } else { 0 };
            self.tries = doublings.saturating_add(1);
            let wait = self.options.back_off.saturating_mul(1_u64.wrapping_shl(doublings.into()));
            (self.state, self.at) = (State::Disconnected, Some(now.after(wait)));
        }
    }

    fn timers(&mut self, now: Millis, output: &mut Output) {
        if self.state == State::Disconnected && self.at.is_some_and(|at| at <= now) {
            (self.state, self.at) = (State::Discovering, None);
            if let Some(endpoint) = self.endpoint.filter(|_| self.options.reconnect) {
                self.open(output, endpoint);
            }
        }
        if let (State::Discovering, Some(every)) = (self.state, self.options.ask_every) {
            if self.at.is_none_or(|at| at <= now) {
                output.send(Send::Question);
                self.at = Some(now.after(every));
            }
        }
        if self.state.is_connected() && self.line.silent.is_some_and(|silent| silent <= now) {
            self.close(now, output, CloseReason::Silence);
        }
        if self.stale().is_some_and(|stale| stale <= now) {
            self.close(now, output, CloseReason::NoAnswer);
        }
        // Stops first.
        if self.tracker.wake(now, output) {
            self.stop_move(now, output);
            self.raise_fence(now, output);
        }
        self.motors.wake(now, output, &self.options);
        for _ in Get::ALL {
            if let Some(get) = self.requests.expired(now) {
                self.failed(now, output, get, Failure::NoAnswer);
            }
        }
        self.calibration.wake(now, output);
        self.keep_alive(now, output);
        if self.fence == Fence::Down {
            self.tracker.settle();
        }
    }

    /// When the connection is given up, because of what may come late.
    const fn stale(&self) -> Option<Millis> {
        if let Fence::Stale(at) = self.fence { Some(at) } else { None }
    }

    /// Keeps the line alive. Over TCP a question does it, also where much is sent and nothing is heard: the device may
    /// have nothing to say (decision K-S15).
    fn keep_alive(&mut self, now: Millis, output: &mut Output) {
        let Some(endpoint) = self.endpoint.filter(|_| self.state.is_connected()) else { return };
        let quiet = self.line.quiet <= now;
        match endpoint.transport() {
            Transport::Usb if quiet => {
                output.send(Send::KeepAlive);
                self.line.quiet = now.after(self.options.usb_keep_alive);
                // The word that a move is over may be lost (decision K-S21).
                if self.tracker.state.runs() {
                    self.ask(now, output, Get::DeviceInfo, Asker::Machine);
                }
            }
            Transport::Usb => {}
            Transport::Tcp => {
                let (deaf, next) = (self.line.deaf <= now, now.after(self.options.tcp_keep_alive));
                if deaf || (quiet && output.send.is_empty()) {
                    self.ask(now, output, Get::NetworkInfo, Asker::Machine);
                    self.line.deaf = next;
                }
                if quiet || !output.send.is_empty() {
                    self.line.quiet = next;
                }
            }
        }
    }

    /// Something came: the device is there.
    pub(super) fn heard(&mut self, now: Millis) {
        if let Some(silent) = &mut self.line.silent {
            *silent = now.after(self.options.silence);
            self.line.deaf = now.after(self.options.tcp_keep_alive);
        }
    }

    fn deadline(&self) -> Option<Millis> {
        let line = self.state.is_connected().then(|| match self.line {
            Line { quiet, deaf, silent: Some(silent) } => quiet.min(deaf).min(silent),
            Line { quiet, .. } => quiet,
        });
        let own = [self.at, line, self.stale(), self.requests.deadline(), self.tracker.deadline()];
        let parts = [self.motors.deadline(), self.calibration.deadline()];
        own.into_iter().chain(parts).flatten().min()
    }
}

impl Machine for HostMachine {
    type Input<'a> = Input<'a>;
    type Output = Output;

    fn step(mut self, now: Millis, input: Input<'_>) -> (Self, Output) {
        let mut output = Output::default();
        match input {
            Input::Command(command) => self.command(now, &mut output, command),
            Input::Opened => self.opened(now, &mut output),
            Input::Closed if self.state.is_connected() || self.state == State::Connecting => {
                self.close(now, &mut output, CloseReason::Ended);
            }
            Input::Fatal if self.state.is_connected() => self.close(now, &mut output, CloseReason::Framing),
            Input::Received(message) if self.state.is_connected() => self.received(now, &mut output, &message),
            Input::Malformed { id, kind, error } if self.state.is_connected() => {
                self.malformed(now, &mut output, (id, kind), error);
            }
            Input::Wake => {}
            Input::Closed | Input::Fatal | Input::Received(_) | Input::Malformed { .. } => {
                output.event(Event::Ignored);
            }
        }
        self.timers(now, &mut output);
        output.wake = self.deadline().map(|deadline| deadline.max(now.after(1))).filter(|&wake| wake > now);
        (self, output)
    }
}
