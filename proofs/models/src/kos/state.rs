//! State of the world, with the part of the past that the properties need.

use std::fmt;

use kos_proto::device::{self, Contents, playback};
use kos_proto::host::{self, Command, Event, Move, MoveState, Outcome, StopTarget, Token, Transmit};
use kos_proto::message::PlaybackState;
use kos_proto::{DeviceMessage, Effect, HostMessage, Millis};

use super::Conduct;
use super::rig::Rig;
use super::world::{World, frame};

/// State of the connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Link {
    /// No connection.
    Down,
    /// The client wants a connection.
    Opening,
    /// The connection is open.
    Up,
    /// The connection is cut, and at least one side sees it. Messages in flight may still come.
    Cut {
        /// Whether the client sees the cut.
        host: bool,
        /// Whether the device sees the cut.
        device: bool,
    },
}

impl Link {
    /// Whether the connection is open for the device.
    #[must_use]
    pub const fn is_open_for_device(self) -> bool {
        matches!(self, Self::Up | Self::Cut { device: false, .. })
    }
}

/// State of the world.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct State {
    /// Client, device, and the messages between them.
    pub(crate) both: World,
    /// The connection.
    pub link: Link,
    /// The rig.
    pub rig: Rig,
    /// Number of times that each request of the script may still come.
    pub(super) wishes: [u8; 8],
    /// Commands that have not ended: bit n for token n.
    pub(super) open: u32,
    pub(super) jumps: u8,
    pub(super) cuts: u8,
    pub(super) failures: u8,
    /// Memory of the past.
    pub ledger: Ledger,
    /// Reports to the application in the last step.
    pub told: Told,
}

/// Breach of a rule in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Breach {
    /// A stop was not sent first, in the step of its request.
    StopNotSent,
    /// A stop came, and was not obeyed in that step; or a client left, and its motion by hand goes on.
    StopNotObeyed,
    /// The rig got a command for a second motion.
    TwoMoves,
    /// A motion request was sent before the last motion request was answered.
    TwoRequests,
    /// A request that must not be repeated was sent again.
    Repeated,
    /// A stop was given up without a report.
    StopForgotten,
    /// A move was reported as over, but it was not.
    NotOver,
    /// A command ended that was not open.
    EndedTwice,
    /// A stop was reported as confirmed, but not everything rests.
    NotStopped,
}

/// Reports to the application in the last step, as far as the properties need them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[expect(clippy::struct_excessive_bools, reason = "the reports are independent of each other")]
pub struct Told {
    /// A move came to its end.
    pub finished: bool,
    /// A stop is confirmed.
    pub stopped: bool,
    /// A stop is not confirmed.
    pub not_confirmed: bool,
    /// A question is answered, or not.
    pub answered: bool,
    /// A question is not answered.
    pub failed: bool,
    /// A move was found again after a lost connection.
    pub found: bool,
}

/// Motion request that was sent and is not answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Request {
    /// Motion to a position. It may replace a motion by hand (decision K-S20).
    Position,
    Distance,
    /// Motion of the move.
    Move,
}

/// Memory of the past.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[expect(clippy::struct_excessive_bools, reason = "the events are independent of each other")]
pub struct Ledger {
    breach: Option<Breach>,
    /// Question of the application, and the time by which it has to end.
    pub(super) asked: Option<(Token, Millis)>,
    /// Time by which a stop has to be confirmed, or reported as not confirmed.
    pub(super) stopping: Option<Millis>,
    /// Whether the next connection has to start with a stop.
    pub(super) unstopped: bool,
    /// Whether there was another connection before.
    pub(super) reconnected: bool,
    /// Whether a stop was confirmed.
    pub(super) stopped: bool,
    /// Whether a message was lost, damaged or doubled.
    pub(super) harmed: bool,
    /// Whether a command to a motor waits to be sent.
    waits: bool,
    request: Option<Request>,
    /// Number of moves that were started by a command, less those that the device began.
    owed: i8,
}

impl Ledger {
    pub(super) fn breach(&mut self, breach: Breach) {
        self.breach.get_or_insert(breach);
    }

    /// First breach of a rule.
    #[must_use]
    pub const fn breached(&self) -> Option<Breach> {
        self.breach
    }

    /// A motion request is sent. No other motion request may be unanswered.
    fn request(&mut self, request: Request) {
        let replaces = |other| request == Request::Position && other != Request::Move;
        if self.request.is_some_and(|other| !replaces(other)) {
            self.breach(Breach::TwoRequests);
        }
        self.request = Some(request);
    }

    fn sent(&mut self, input: &host::Input<'_>, transmit: &Transmit<'_>) {
        let command = if let host::Input::Command(_, command) = input { Some(command) } else { None };
        // A request that must not be repeated is sent only in the step of its command. A command to a position may
        // wait.
        let wanted = match transmit {
            transmit if transmit.conduct().repeatable => true,
            Transmit::Trajectory => matches!(command, Some(Command::Load { .. } | Command::PlayDirect { .. })),
            Transmit::Setup { .. } => matches!(command, Some(Command::Load { .. })),
            Transmit::Start => matches!(command, Some(Command::Play | Command::PlayDirect { .. })),
            Transmit::RapidToFirstKeyFrame => matches!(command, Some(Command::RapidToFirstKeyFrame)),
            Transmit::Bump(_) => matches!(command, Some(Command::Bump(_))),
            Transmit::MoveTo(_) => {
                let direct = matches!(command, Some(Command::MoveTo(_) | Command::Jog { .. }));
                direct || (std::mem::take(&mut self.waits) && *input == host::Input::Wake)
            }
            _ => false,
        };
        if !wanted {
            self.breach(Breach::Repeated);
        }
        match transmit {
            transmit if transmit.conduct().is_stop() => self.request = None,
            Transmit::Setup { delay_return: false, .. } | Transmit::RapidToFirstKeyFrame => self.request(Request::Move),
            Transmit::Start => {
                self.owed += 1;
                self.request(Request::Move);
            }
            Transmit::Bump(_) => self.request(Request::Distance),
            Transmit::MoveTo(_) => self.request(Request::Position),
            _ => {}
        }
    }

    /// Answers of the device end the motion requests.
    fn received(&mut self, message: &DeviceMessage<'_>) {
        let by = |request| self.request == Some(request);
        let answered = match message {
            DeviceMessage::MotorPosition(_) => by(Request::Position) || by(Request::Distance),
            DeviceMessage::PlaybackStatus(status) => {
                by(Request::Move) || status.playback_status == PlaybackState::FULL_STOP
            }
            DeviceMessage::ErrorStatus(_) | DeviceMessage::UnsupportedMessage(_) => true,
            _ => false,
        };
        if answered {
            self.request = None;
        }
    }
}

impl fmt::Display for State {
    /// Writes the states of both machines, the rig, and the messages on their way.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (host, device) = (self.both.host.machine.move_state(), self.both.device.machine.playback());
        write!(f, "{host} {device} {:?} {:?}", self.link, self.rig)?;
        for message in self.both.up.iter() {
            write!(f, " > {:?}", HostMessage::decode(&frame(message)))?;
        }
        for message in self.both.down.iter() {
            write!(f, " < {:?}", DeviceMessage::decode(&frame(message)))?;
        }
        write!(f, " {:?}", self.ledger)
    }
}

impl State {
    /// Records the step of the client. Reports of the device are `clear` if none of them comes twice.
    pub(super) fn ledger_of_host(&mut self, input: &host::Input<'_>, output: &host::Output<'_>, clear: bool) {
        let connected = self.both.host.machine.state().is_connected();
        let (now, timeouts) = (self.both.now, host::Options::default());
        let ledger = &mut self.ledger;
        let first = output.effects.first();
        let stops_all = first == Some(&Effect::Transmit(Transmit::StopPlayback));
        let stops = matches!(first, Some(Effect::Transmit(transmit)) if transmit.conduct().is_stop());
        let unconfirmed = output.events().any(|event| *event == Event::StopNotConfirmed(StopTarget::All));
        if let host::Input::Command(token, _) = input {
            self.open |= 1 << token.0;
        }
        match input {
            host::Input::Command(_, Command::Stop) if connected != stops_all || connected == unconfirmed => {
                ledger.breach(Breach::StopNotSent);
            }
            host::Input::Command(_, Command::StopMotor(_)) if connected && !stops => {
                ledger.breach(Breach::StopNotSent);
            }
            host::Input::Command(_, Command::MoveTo(_) | Command::Jog { .. }) => {
                ledger.waits = output.transmits().next().is_none();
            }
            host::Input::Command(token, Command::Get(_)) => {
                ledger.asked = Some((*token, now.after(timeouts.request_timeout())));
            }
            host::Input::Command(_, Command::Disconnect) => ledger.unstopped = false,
            host::Input::LinkUp if ledger.unstopped => {
                ledger.unstopped = false;
                if !stops_all {
                    ledger.breach(Breach::StopForgotten);
                }
            }
            host::Input::Received(message) => ledger.received(message),
            _ => {}
        }
        for transmit in output.transmits() {
            ledger.sent(input, transmit);
        }
        // A locked device may ignore a stop, so it is sent again directly after the password.
        let wants_stop = self.both.host.machine.move_state() == MoveState::Stopping;
        let password = |effect: &host::Effect<'_>| matches!(effect, Effect::Transmit(Transmit::UserPassword(_)));
        if let Some(place) = output.effects.iter().position(password).filter(|_| wants_stop)
            && output.effects.get(place + 1) != Some(&Effect::Transmit(Transmit::StopPlayback))
        {
            ledger.breach(Breach::StopNotSent);
        }
        let mut told = Told::default();
        let (mut closed, mut obeyed) = (false, false);
        for event in output.events() {
            match *event {
                Event::Ended { token, outcome } => {
                    let bit = 1 << token.0;
                    if self.open & bit == 0 {
                        ledger.breach(Breach::EndedTwice);
                    }
                    self.open &= !bit;
                    if ledger.asked.is_some_and(|(asked, _)| asked == token) {
                        ledger.asked = None;
                        (told.answered, told.failed) =
                            (matches!(outcome, Outcome::Done(Some(_))), matches!(outcome, Outcome::Failed(_)));
                    }
                }
                Event::StopNotConfirmed(StopTarget::All) => told.not_confirmed = true,
                Event::Stopped(StopTarget::All) => {
                    told.stopped = true;
                    if clear && !self.rig.rests(self.both.now) {
                        ledger.breach(Breach::NotStopped);
                    }
                }
                Event::Move(Move::Finished { requested }) => {
                    (obeyed, told.finished) = (requested, !requested);
                    if self.both.device.machine.playback().runs() {
                        ledger.breach(Breach::NotOver);
                    }
                }
                Event::Move(Move::Found(_)) => told.found = true,
                Event::LinkDown(_) => closed = true,
                _ => {}
            }
        }
        if closed {
            // Everything that was not confirmed is reported, and the next connection starts with a stop.
            if ledger.stopping.is_some() && !told.not_confirmed {
                ledger.breach(Breach::StopForgotten);
            }
            (ledger.request, ledger.waits, ledger.reconnected, ledger.owed) = (None, false, true, 0);
        }
        ledger.stopped |= told.stopped;
        if obeyed || told.not_confirmed {
            ledger.stopping = None;
        }
        if told.not_confirmed && !connected {
            ledger.unstopped = !matches!(input, host::Input::Command(_, Command::Disconnect));
        }
        if output.transmits().any(|transmit| *transmit == Transmit::StopPlayback) {
            ledger.stopping = Some(now.after(timeouts.stop_timeout()));
        }
        self.told = told;
    }

    /// Records the step of the device, which the rig has followed already.
    pub(super) fn ledger_of_device(
        &mut self,
        input: &device::Input<'_>,
        output: &device::Output<'_>,
        conduct: Conduct,
    ) {
        let device::Input::Received { message, session, .. } = input else { return };
        let is_locked = self.both.device.machine.session(*session) == device::clients::State::Locked;
        if conduct == Conduct::DeafWhileLocked && is_locked && message.conduct().is_stop() {
            return;
        }
        let obeyed = match message {
            HostMessage::StopPlayback(_) => {
                let empty = self.both.device.machine.playback() == playback::State::Empty;
                let says = |contents: &Contents<'_>| matches!(contents, Contents::PlaybackStatus { state, .. } if *state == PlaybackState::FULL_STOP);
                let told = output.transmits().any(|transmit| says(&transmit.contents));
                empty && told && output.events().any(|event| *event == device::Event::StopAll)
            }
            HostMessage::SetPositionSpeedAcceleration(message) if message.is_stop() => true,
            _ => return self.begun(message),
        };
        if !obeyed || self.rig.is_driven(self.both.now) {
            self.ledger.breach(Breach::StopNotObeyed);
        }
    }

    /// The device does not begin more moves than were started.
    fn begun(&mut self, message: &HostMessage<'_>) {
        if let HostMessage::StartPlayback(_) = message {
            self.ledger.owed -= 1;
            if self.ledger.owed < 0 && !self.ledger.reconnected {
                self.ledger.breach(Breach::Repeated);
            }
        }
    }

    /// Whether all messages have arrived, over a sound connection, at a client that knows the device.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        let quiet = self.both.up.is_empty() && self.both.down.is_empty();
        let knows = matches!(self.both.host.machine.state(), host::State::Ready | host::State::Locked);
        quiet && self.link == Link::Up && knows
    }

    /// Whether both agree on the move. If a message was damaged, it is enough that a running move is known to run.
    #[must_use]
    pub fn agrees(&self) -> bool {
        use playback::State as Device;
        let (host, device) = (&self.both.host.machine, self.both.device.machine.playback());
        if self.ledger.harmed {
            return !device.runs() || host.may_move();
        }
        match host.move_state() {
            // After another connection, a move that is only ready is not a move of this client (decision K-S17), and no
            // status says that a move is on its way home.
            MoveState::NoMove if self.ledger.reconnected => {
                let homing = matches!(device, Device::HomingSetup | Device::HomingStart | Device::HomingRapid);
                !device.runs() || homing || host.may_move()
            }
            MoveState::NoMove | MoveState::Stopping => device == Device::Empty,
            MoveState::SettingUp => device == Device::HomingSetup,
            MoveState::Armed => matches!(device, Device::Ready | Device::HomingRapid),
            MoveState::Starting => device == Device::HomingStart,
            MoveState::Delay => device == Device::Delay,
            MoveState::PreShoot => device == Device::Pre,
            MoveState::Running => device.runs() && !matches!(device, Device::Pre | Device::Post | Device::Delay),
            MoveState::Ended => device == Device::Post,
        }
    }

    /// Whether every open question and stop ends in time, because the client wakes for it.
    #[must_use]
    pub fn ends_in_time(&self) -> bool {
        let in_time = |due: Millis| self.both.host.wake.is_some_and(|wake| wake <= due.max(self.both.now));
        let asked = self.ledger.asked.map(|(_, due)| due);
        asked.is_none_or(in_time) && self.ledger.stopping.is_none_or(in_time)
    }
}
