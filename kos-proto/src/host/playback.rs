//! The move on the device, as far as the device told it (kOS 7.6).

use motion_core::debug;
use motion_core::time::Millis;

use super::event::{Event, Failure, Move, MoveState, Outcome, Refusal, StopTarget};
use super::stops::Stops;
use super::{Options, Output, Token};
use crate::frame::MessageId;
use crate::message::{ActionId, Direction, ErrorCode, MotorSet, PlaybackState, PlaybackStatus};
use crate::move_summary::{Kind, MoveSummary};

/// Move on the device.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Playback {
    pub(super) state: MoveState,
    ways: Ways,
    /// Time at which a stop is sent again, or the move is told to be slow.
    deadline: Option<Millis>,
    /// Whether the device confirmed the stop.
    confirmed: bool,
    /// Whether the motors of the move that is ready are on their way home.
    homing: bool,
    /// Whether the device was last heard to play a move, whoever began it.
    plays: bool,
    /// Number of passes that followed the first one; it stays at the greatest number.
    loops: u8,
    /// Command that ends with the move, or when the move is ready.
    token: Option<Token>,
    /// Motors of the last move that was begun from here, until its end is known.
    motors: MotorSet,
}

/// Ways that a move goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Ways {
    /// The move goes forward only.
    Forward,
    /// The move has loops, or nobody knows.
    Both,
}

debug! { Playback { state ways deadline confirmed homing plays loops token motors } }

impl Default for Playback {
    fn default() -> Self {
        Self {
            state: MoveState::NoMove,
            ways: Ways::Both,
            deadline: None,
            confirmed: false,
            homing: false,
            plays: false,
            loops: 0,
            token: None,
            motors: MotorSet::NONE,
        }
    }
}

/// Whether the device plays a move in this state.
const fn plays(status: PlaybackState) -> bool {
    !matches!(
        status,
        PlaybackState::NO_MOVE | PlaybackState::MOTORS_HOME | PlaybackState::SETUP_COMPLETED | PlaybackState::FULL_STOP
    )
}

fn tell(output: &mut Output<'_>, happened: Move) {
    output.event(Event::Move(happened));
}

impl Playback {
    /// Whether anything may move because of a move, of this client or another.
    pub(super) const fn moves(&self) -> bool {
        self.state.moves() || self.plays
    }

    /// Motors that may move because of a move of this client.
    pub(super) const fn moving(&self) -> MotorSet {
        if self.state.moves() || self.homing { self.motors } else { MotorSet::NONE }
    }

    /// Whether motors are on their way to where the move begins, so that it cannot be played yet.
    pub(super) const fn is_homing(&self) -> bool {
        self.homing
    }

    pub(super) const fn loops(&self) -> u8 {
        self.loops
    }

    pub(super) const fn motors(&self) -> MotorSet {
        self.motors
    }

    pub(super) const fn deadline(&self) -> Option<Millis> {
        self.deadline
    }

    fn go(&mut self, state: MoveState, deadline: Option<Millis>) {
        *self = Self { state, deadline, confirmed: false, homing: false, ..*self };
    }

    /// Ends the command that waits for the move, if there is one.
    fn end(&mut self, output: &mut Output<'_>, outcome: Outcome<'static>) {
        if let Some(token) = self.token.take() {
            output.event(Event::ended(token, outcome));
        }
    }

    /// Ends the move. Unless it came to its end, its motors are still slowing down.
    fn over(&mut self, output: &mut Output<'_>, stops: &mut Stops, outcome: Outcome<'static>) {
        if self.state == MoveState::Ended {
            stops.at_rest(self.motors);
            self.end(output, Outcome::Done(None));
        } else {
            stops.lose(self.moving());
            self.end(output, outcome);
        }
        self.motors = MotorSet::NONE;
        self.go(MoveState::NoMove, None);
    }

    /// Notes a move that the device shall store.
    pub(super) const fn store(&mut self, summary: &MoveSummary) {
        self.motors = summary.motors;
        let loops = matches!(summary.kind, Kind::Live { loops: Some(_), .. });
        self.ways = if loops { Ways::Both } else { Ways::Forward };
    }

    /// Notes that a move is being made ready, or played.
    pub(super) fn begin(&mut self, now: Millis, options: &Options, state: MoveState, token: Token) {
        (self.loops, self.token) = (0, Some(token));
        self.go(state, Some(now.after(options.setup_timeout())));
    }

    /// Notes that the motors of the move that is ready go to where it begins.
    pub(super) const fn rapid(&mut self) {
        self.homing = true;
    }

    /// Notes that a stop is sent, or waits for a connection.
    pub(super) fn stop(&mut self, output: &mut Output<'_>, resend: Option<Millis>) {
        self.end(output, Outcome::Failed(Failure::Stopped));
        self.go(MoveState::Stopping, resend);
    }

    /// Ends a stop that is confirmed, when all that was sent before it has been answered: no late confirmation will be
    /// taken for the end of another move.
    pub(super) fn settle(&mut self) {
        if self.state == MoveState::Stopping && self.confirmed {
            self.motors = MotorSet::NONE;
            self.go(MoveState::NoMove, None);
        }
    }

    /// Notes that the connection went down.
    pub(super) fn lost(&mut self, output: &mut Output<'_>, stops: &mut Stops) {
        match self.state {
            MoveState::Stopping if !self.confirmed => {
                output.event(Event::StopNotConfirmed(StopTarget::All));
                self.deadline = None;
                return;
            }
            MoveState::NoMove | MoveState::Stopping => {}
            _ => tell(output, Move::Lost),
        }
        stops.lose(self.moving());
        self.end(output, Outcome::Failed(Failure::LinkDown));
        // A move that is found again may be this one.
        *self = Self { motors: self.motors, ..Self::default() };
    }

    /// Takes the state of the device at the begin of a connection.
    pub(super) fn found(&mut self, output: &mut Output<'_>, status: PlaybackState) {
        self.plays = plays(status);
        if self.state != MoveState::NoMove {
            return;
        }
        let state = match status {
            PlaybackState::DELAY_TIMER_STARTED => MoveState::Delay,
            PlaybackState::PRE_MOVE_PHOTOS_STARTED => MoveState::PreShoot,
            PlaybackState::END_OF_MOVE => MoveState::Ended,
            PlaybackState::START_FORWARD
            | PlaybackState::START_REVERSE
            | PlaybackState::START_FRAME
            | PlaybackState::SMS_MOTORS_STOPPED => MoveState::Running,
            _ => return,
        };
        self.go(state, None);
        tell(output, Move::Found(state));
    }

    /// Notes whether the device plays the move the other way. It has to be stopped then.
    pub(super) fn goes_other_way(&mut self, output: &mut Output<'_>, status: PlaybackState) -> bool {
        let is_wrong = match self.state {
            MoveState::Starting | MoveState::Delay | MoveState::PreShoot => true,
            MoveState::Running | MoveState::Ended => self.ways == Ways::Forward,
            MoveState::NoMove | MoveState::SettingUp | MoveState::Armed | MoveState::Stopping => false,
        };
        let goes = is_wrong && status == PlaybackState::START_REVERSE;
        if goes {
            self.plays = true;
            tell(output, Move::OtherWay);
            self.end(output, Outcome::Failed(Failure::OtherWay));
        }
        goes
    }

    /// Takes the state of the device from an answer to a question: the report of the end may have been lost.
    pub(super) fn said(&mut self, output: &mut Output<'_>, stops: &mut Stops, status: PlaybackState) {
        self.plays = plays(status);
        if self.state.runs() && matches!(status, PlaybackState::FULL_STOP | PlaybackState::NO_MOVE) {
            tell(output, Move::Finished { requested: false });
            self.over(output, stops, Outcome::NotConfirmed);
        }
    }

    /// Takes a report of the device on its move.
    pub(super) fn status(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        options: &Options,
        stops: &mut Stops,
        status: &PlaybackStatus<'_>,
    ) {
        use MoveState as State;
        use PlaybackState as Said;
        let said = status.playback_status;
        self.plays = plays(said);
        let photos = status.photo_count;
        let progress = Move::Progress { state: said, elapsed: status.elapsed_time, photos };
        let (next, told) = match (self.state, said) {
            (State::Stopping, Said::FULL_STOP) if !self.confirmed => {
                tell(output, Move::Finished { requested: true });
                (self.confirmed, self.deadline) = (true, None);
                return stops.obeyed(now, options);
            }
            // The move was under way when it was told to stop, or the stop is confirmed again.
            (State::Stopping, _) => return tell(output, progress),
            (_, Said::FULL_STOP) => {
                tell(output, Move::Finished { requested: false });
                return self.over(output, stops, Outcome::Failed(Failure::Stopped));
            }
            (State::SettingUp | State::Starting, Said::MOTORS_HOME) => {
                stops.at_rest(self.motors);
                return tell(output, Move::Home);
            }
            (State::Armed, Said::MOTORS_HOME) => {
                stops.at_rest(self.motors);
                (State::Armed, Move::Home)
            }
            (State::SettingUp, Said::SETUP_COMPLETED) => (State::Armed, Move::Ready),
            (State::Starting, Said::SETUP_COMPLETED) => return tell(output, Move::Ready),
            (State::Starting, Said::DELAY_TIMER_STARTED) => (State::Delay, Move::Countdown),
            (State::Starting | State::Delay, Said::PRE_MOVE_PHOTOS_STARTED) => (State::PreShoot, Move::PreShoot),
            (State::Starting | State::Delay | State::PreShoot | State::Ended, Said::START_FORWARD) => {
                (State::Running, Move::Running(Direction::Forward))
            }
            (State::Ended, Said::START_REVERSE) => (State::Running, Move::Running(Direction::Reverse)),
            (
                State::Running,
                Said::START_FORWARD | Said::START_REVERSE | Said::START_FRAME | Said::SMS_MOTORS_STOPPED,
            ) => (State::Running, progress),
            (State::Running, Said::END_OF_MOVE) => (State::Ended, Move::EndReached),
            (State::Ended, Said::POST_MOVE_PHOTOS_COMPLETED) => (State::Ended, Move::PostShot),
            _ => return tell(output, Move::Unexpected(said)),
        };
        if (self.state, next) == (State::Ended, State::Running) {
            self.loops = self.loops.saturating_add(1);
        }
        self.go(next, None);
        tell(output, told);
        if next == State::Armed {
            self.end(output, Outcome::Done(None));
        }
    }

    /// Takes an error that the device reported; whether the move has to be stopped because of it.
    pub(super) fn error(&mut self, output: &mut Output<'_>, code: ErrorCode) -> bool {
        let fails = matches!(code.0, 0 | 2 | 3 | 6 | 17 | 19 | 20);
        match self.state {
            MoveState::NoMove | MoveState::Stopping => false,
            MoveState::Delay | MoveState::PreShoot | MoveState::Running | MoveState::Ended
                if code == ErrorCode::CANNOT_EXECUTE_MOVE =>
            {
                tell(output, Move::Refused);
                false
            }
            // Nothing else is under way that a missing motor could be about (decision K-S14).
            MoveState::SettingUp | MoveState::Starting if fails || code == ErrorCode::BAD_MOTOR_ADDRESS => {
                tell(output, Move::Failed(code));
                self.end(output, Outcome::Refused(Refusal::Device(code)));
                true
            }
            _ if fails => {
                tell(output, Move::Failed(code));
                self.end(output, Outcome::Failed(Failure::Device(code)));
                true
            }
            _ => false,
        }
    }

    /// Takes the report that the device does not know a message. Returns whether the move has to be stopped.
    pub(super) fn unsupported(&mut self, output: &mut Output<'_>, id: MessageId, action: Option<ActionId>) -> bool {
        let is_needed = match (self.state, action) {
            (MoveState::SettingUp | MoveState::Starting, None) => id == MessageId::TRAJECTORY_DATA,
            (MoveState::SettingUp, Some(action)) => action == ActionId::SETUP_PLAYBACK,
            (MoveState::Starting, Some(action)) => action == ActionId::START_PLAYBACK,
            (MoveState::Armed, Some(ActionId::RAPID_TO_FIRST_KEY_FRAME)) => {
                self.homing = false;
                false
            }
            (MoveState::Stopping, Some(ActionId::STOP_PLAYBACK)) if !self.confirmed => {
                output.event(Event::StopNotConfirmed(StopTarget::All));
                false
            }
            _ => false,
        };
        if is_needed {
            self.end(output, Outcome::Refused(Refusal::Unsupported { id, action }));
        }
        is_needed
    }

    /// Whether a stop is wanted that is not confirmed yet.
    pub(super) const fn wants_stop(&self) -> bool {
        matches!(self.state, MoveState::Stopping) && !self.confirmed
    }

    /// Deals with a deadline that has come; whether a stop has to be sent again.
    pub(super) fn wake(&mut self, now: Millis, output: &mut Output<'_>) -> bool {
        if self.deadline.is_none_or(|deadline| deadline > now) {
            return false;
        }
        self.deadline = None;
        if self.state == MoveState::Stopping {
            output.event(Event::StopNotConfirmed(StopTarget::All));
            return true;
        }
        tell(output, Move::Slow);
        false
    }
}
