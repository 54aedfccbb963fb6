//! State of the world, with the part of the past that the properties need.

use kos_proto::device::{self, DeviceMachine, What, playback};
use kos_proto::host::{self, Command, Event, HostMachine, Move, MoveState, Send};
use kos_proto::message::PlaybackState;
use kos_proto::{DeviceMessage, HostMessage};
use motion_core::time::Millis;

use super::rig::Rig;
use crate::line::Line;

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
    pub(super) now: Millis,
    /// The client.
    pub host: HostMachine,
    /// The device.
    pub device: DeviceMachine,
    pub(super) host_wake: Option<Millis>,
    pub(super) device_wake: Option<Millis>,
    /// Messages to the device.
    pub to_device: Line<Send>,
    /// Messages to the client.
    pub to_host: Line<What>,
    /// The connection.
    pub link: Link,
    /// The rig.
    pub rig: Rig,
    /// Number of times that each request of the script may still come.
    pub(super) wishes: [u8; 8],
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
    /// Time by which a question of the application has to end.
    pub(super) asked: Option<Millis>,
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

/// Whether the request stops something.
pub(super) fn is_stop(send: Send) -> bool {
    matches!(send, Send::StopPlayback) || matches!(send, Send::MoveTo(go) if go.speed.0 == 0.0)
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

    fn sent(&mut self, input: &host::Input<'_>, send: &Send) {
        let command = if let host::Input::Command(command) = input { Some(command) } else { None };
        // A request that must not be repeated is sent only in the step of its command. A command to a position may
        // wait.
        let wanted = match send {
            send if send.is_repeatable() => true,
            Send::Trajectory => matches!(command, Some(Command::Load { .. } | Command::PlayDirect { .. })),
            Send::Setup { .. } => matches!(command, Some(Command::Load { .. })),
            Send::Start(_) => matches!(command, Some(Command::Play | Command::PlayDirect { .. })),
            Send::RapidToFirstKeyFrame => matches!(command, Some(Command::RapidToFirstKeyFrame)),
            Send::Bump(_) => matches!(command, Some(Command::Bump(_))),
            Send::MoveTo(_) => {
                let direct = matches!(command, Some(Command::MoveTo(_) | Command::Jog { .. }));
                direct || (std::mem::take(&mut self.waits) && *input == host::Input::Wake)
            }
            _ => false,
        };
        if !wanted {
            self.breach(Breach::Repeated);
        }
        match send {
            send if is_stop(*send) => self.request = None,
            Send::Setup { delay_return: false, .. } | Send::RapidToFirstKeyFrame => self.request(Request::Move),
            Send::Start(_) => {
                self.owed += 1;
                self.request(Request::Move);
            }
            Send::Bump(_) => self.request(Request::Distance),
            Send::MoveTo(_) => self.request(Request::Position),
            _ => {}
        }
    }

    /// Answers of the device end the motion requests.
    fn heard(&mut self, message: &DeviceMessage<'_>) {
        let by = |request| self.request == Some(request);
        let answered = match message {
            DeviceMessage::MotorPosition(_) => by(Request::Position) || by(Request::Distance),
            DeviceMessage::PlaybackStatus(status) => {
                by(Request::Move) || status.playback_status == PlaybackState::FULL_STOP
            }
            DeviceMessage::ErrorStatus(_) => true,
            _ => false,
        };
        if answered {
            self.request = None;
        }
    }
}

impl State {
    /// Records the step of the client.
    pub(super) fn ledger_of_host(&mut self, input: &host::Input<'_>, output: &host::Output) {
        let connected = self.host.state().is_connected();
        let timeouts = host::Options::default();
        let ledger = &mut self.ledger;
        let unconfirmed = output.events.contains(&Event::StopNotConfirmed(None));
        match input {
            host::Input::Command(Command::Stop)
                if connected != output.send.starts_with(&[Send::StopPlayback]) || connected == unconfirmed =>
            {
                ledger.breach(Breach::StopNotSent);
            }
            host::Input::Command(Command::StopMotor(_))
                if connected && !output.send.first().is_some_and(|send| is_stop(*send)) =>
            {
                ledger.breach(Breach::StopNotSent);
            }
            host::Input::Command(Command::MoveTo(_) | Command::Jog { .. }) => ledger.waits = output.send.is_empty(),
            host::Input::Command(Command::Get(..)) => ledger.asked = Some(self.now.after(timeouts.request_timeout)),
            host::Input::Command(Command::Disconnect) => ledger.unstopped = false,
            host::Input::Opened if ledger.unstopped => {
                ledger.unstopped = false;
                if !output.send.starts_with(&[Send::StopPlayback]) {
                    ledger.breach(Breach::StopForgotten);
                }
            }
            host::Input::Received(message) => ledger.heard(message),
            _ => {}
        }
        for send in &output.send {
            ledger.sent(input, send);
        }
        let mut told = Told::default();
        let mut closed = false;
        for event in &output.events {
            match event {
                Event::Answered(..) => told.answered = true,
                Event::Failed(..) => told.failed = true,
                Event::StopNotConfirmed(None) => told.not_confirmed = true,
                Event::Move(Move::Finished { requested }) => {
                    (told.stopped, told.finished) = (*requested, !*requested);
                    if self.device.playback().runs() {
                        ledger.breach(Breach::NotOver);
                    }
                }
                Event::Move(Move::Found(_)) => told.found = true,
                Event::Closed(_) => closed = true,
                _ => {}
            }
        }
        if told.answered || told.failed {
            ledger.asked = None;
        }
        if closed {
            // Everything that was not confirmed is reported, and the next connection starts with a stop.
            if ledger.stopping.is_some() && !told.not_confirmed {
                ledger.breach(Breach::StopForgotten);
            }
            (ledger.request, ledger.waits, ledger.reconnected, ledger.owed) = (None, false, true, 0);
        }
        ledger.stopped |= told.stopped;
        if told.stopped || told.not_confirmed {
            ledger.stopping = None;
        }
        if told.not_confirmed && !connected {
            ledger.unstopped = true;
        }
        if output.send.contains(&Send::StopPlayback) {
            ledger.stopping = Some(self.now.after(timeouts.stop_timeout));
        }
        self.told = told;
    }

    /// Records the step of the device, which the rig has followed already.
    pub(super) fn ledger_of_device(&mut self, input: &device::Input<'_>, output: &device::Output) {
        let device::Input::Received { message, .. } = input else { return };
        let says = |wanted| {
            let mut said = output.send.iter().map(|send| &send.what);
            said.any(|what| matches!(what, What::PlaybackStatus { state, .. } if *state == wanted))
        };
        let obeyed = match message {
            HostMessage::StopPlayback(_) => {
                let empty = self.device.playback() == playback::State::Empty;
                output.events.contains(&device::Event::StopAll) && empty && says(PlaybackState::FULL_STOP)
            }
            HostMessage::SetPositionSpeedAcceleration(message) if message.is_stop() => true,
            _ => return self.begun(message),
        };
        if !obeyed || self.rig.is_driven() {
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
        let quiet = self.to_device.is_empty() && self.to_host.is_empty();
        let knows = matches!(self.host.state(), host::State::Ready | host::State::Locked);
        quiet && self.link == Link::Up && knows
    }

    /// Whether both agree on the move. If a message was damaged, it is enough that a running move is known to run.
    #[must_use]
    pub fn agrees(&self) -> bool {
        use playback::State as Device;
        let device = self.device.playback();
        if self.ledger.harmed {
            return !device.runs() || self.host.moves();
        }
        match self.host.move_state() {
            // After another connection, a move that is only ready is not a move of this client (decision K-S17), and no
            // status says that a move is on its way home.
            MoveState::NoMove if self.ledger.reconnected => {
                let homing = matches!(device, Device::HomingSetup | Device::HomingStart | Device::HomingRapid);
                !device.runs() || homing || self.host.moves()
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
        let wakes =
            |due: Option<Millis>| due.is_none_or(|due| self.host_wake.is_some_and(|wake| wake <= due.max(self.now)));
        wakes(self.ledger.asked) && wakes(self.ledger.stopping)
    }
}
