//! What a client knows of the move on the device, from what the device says (kOS 7.6).

use motion_core::time::Millis;

use super::io::{Event, Move};
use super::{Options, Output};
use crate::message::{ErrorCode, PlaybackState, PlaybackStatus};
use crate::summary::{Direction, debug_fields};

/// How far the move is, as far as the device said.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum State {
    /// The device has no move of this client.
    #[default]
    NoMove,
    /// It is being made ready.
    SettingUp,
    /// It can be played.
    Armed,
    /// It was told to begin.
    Starting,
    /// It waits for its time.
    Delay,
    /// Photos before it are taken.
    PreShoot,
    /// It runs.
    Running,
    /// It is at its end; a loop or photos may follow.
    Ended,
    /// It was told to stop, and not all of that is confirmed.
    Stopping,
}

impl State {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::NoMove,
        Self::SettingUp,
        Self::Armed,
        Self::Starting,
        Self::Delay,
        Self::PreShoot,
        Self::Running,
        Self::Ended,
        Self::Stopping,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NoMove => "NoMove",
            Self::SettingUp => "SettingUp",
            Self::Armed => "Armed",
            Self::Starting => "Starting",
            Self::Delay => "Delay",
            Self::PreShoot => "PreShoot",
            Self::Running => "Running",
            Self::Ended => "Ended",
            Self::Stopping => "Stopping",
        }
    }

    /// Whether the device may move something because of it.
    #[must_use]
    pub const fn moves(self) -> bool {
        !matches!(self, Self::NoMove | Self::Armed)
    }

    /// Whether the device said that it plays it, and not yet that all is over.
    #[must_use]
    pub const fn runs(self) -> bool {
        matches!(self, Self::Delay | Self::PreShoot | Self::Running | Self::Ended)
    }
}

/// The move on the device.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Tracker {
    pub(super) state: State,
    way: Direction,
    /// When a stop is sent again, or it takes long.
    deadline: Option<Millis>,
    /// Whether the device confirmed the stop.
    confirmed: bool,
    /// Whether the motors of the move that is ready are on their way home.
    homing: bool,
    /// Whether the device was last heard to play a move, whoever began it.
    plays: bool,
    /// Ways that followed the first one; at the greatest number it stays.
    loops: u8,
}

debug_fields! { Tracker { state, way, deadline, confirmed, homing, plays, loops } }

impl Default for Tracker {
    fn default() -> Self {
        Self {
            state: State::NoMove,
            way: Direction::Forward,
            deadline: None,
            confirmed: false,
            homing: false,
            plays: false,
            loops: 0,
        }
    }
}

/// What the device says while it plays a move.
const fn plays(status: PlaybackState) -> bool {
    !matches!(
        status,
        PlaybackState::NO_MOVE | PlaybackState::MOTORS_HOME | PlaybackState::SETUP_COMPLETED | PlaybackState::FULL_STOP
    )
}

fn tell(output: &mut Output, happened: Move) {
    output.event(Event::Move(happened));
}

impl Tracker {
    /// Whether anything may move because of a move, of this client or another.
    pub(super) const fn moves(&self) -> bool {
        self.state.moves() || self.plays
    }

    /// Whether motors are on their way to where the move begins, so that it cannot be played yet.
    pub(super) const fn is_homing(&self) -> bool {
        self.homing
    }

    pub(super) const fn way(&self) -> Direction {
        self.way
    }

    pub(super) const fn loops(&self) -> u8 {
        self.loops
    }

    pub(super) const fn deadline(&self) -> Option<Millis> {
        self.deadline
    }

    fn go(&mut self, state: State, deadline: Option<Millis>) {
        *self = Self { state, deadline, confirmed: false, homing: false, ..*self };
    }

    /// A move is being made ready, or played.
    pub(super) fn begin(&mut self, now: Millis, options: &Options, state: State, way: Direction) {
        (self.way, self.loops) = (way, 0);
        self.go(state, Some(now.after(options.setup_timeout)));
    }

    /// The motors of the move that is ready go to where it begins.
    pub(super) fn rapid(&mut self) {
        self.homing = true;
    }

    /// A stop is sent, or cannot be: then it waits for a connection.
    pub(super) fn stop(&mut self, resend: Option<Millis>) {
        self.go(State::Stopping, resend);
    }

    /// The stop is confirmed, and what was sent before it has been answered: no late confirmation will be taken for the
    /// end of another move.
    pub(super) fn settle(&mut self) {
        if self.state == State::Stopping && self.confirmed {
            self.go(State::NoMove, None);
        }
    }

    /// The connection is lost.
    pub(super) fn lost(&mut self, output: &mut Output) {
        match self.state {
            State::Stopping if !self.confirmed => {
                output.event(Event::StopNotConfirmed(None));
                self.deadline = None;
                return;
            }
            State::NoMove | State::Stopping => {}
            _ => tell(output, Move::Lost),
        }
        *self = Self::default();
    }

    /// What the device does behind a connection that was lost, or is new.
    pub(super) fn found(&mut self, output: &mut Output, status: PlaybackState) {
        self.plays = plays(status);
        if self.state != State::NoMove {
            return;
        }
        let state = match status {
            PlaybackState::DELAY_TIMER_STARTED => State::Delay,
            PlaybackState::PRE_MOVE_PHOTOS_STARTED => State::PreShoot,
            PlaybackState::END_OF_MOVE => State::Ended,
            PlaybackState::START_FORWARD
            | PlaybackState::START_REVERSE
            | PlaybackState::START_FRAME
            | PlaybackState::SMS_MOTORS_STOPPED => State::Running,
            _ => return,
        };
        self.go(state, None);
        tell(output, Move::Found(state));
    }

    /// What the device says of itself when it is asked: that a move which should run does not is worth knowing, where
    /// the word of its end was lost.
    pub(super) fn said(&mut self, output: &mut Output, status: PlaybackState) {
        self.plays = plays(status);
        if self.state.runs() && matches!(status, PlaybackState::FULL_STOP | PlaybackState::NO_MOVE) {
            tell(output, Move::Finished { requested: false });
            self.go(State::NoMove, None);
        }
    }

    /// The device says how far it is.
    pub(super) fn status(&mut self, output: &mut Output, status: &PlaybackStatus<'_>) {
        use PlaybackState as Said;
        let said = status.playback_status;
        self.plays = plays(said);
        let photos = status.photo_count;
        let progress = Move::Progress { state: said, elapsed: status.elapsed_time, photos };
        let (next, told) = match (self.state, said) {
            (State::Stopping, Said::FULL_STOP) if !self.confirmed => {
                tell(output, Move::Finished { requested: true });
                (self.confirmed, self.deadline) = (true, None);
                return;
            }
            // What was under way when it was told to stop, and what confirms it again.
            (State::Stopping, _) => return tell(output, progress),
            (_, Said::FULL_STOP) => (State::NoMove, Move::Finished { requested: false }),
            (State::SettingUp | State::Starting, Said::MOTORS_HOME) => return tell(output, Move::Home),
            (State::Armed, Said::MOTORS_HOME) => (State::Armed, Move::Home),
            (State::SettingUp, Said::SETUP_COMPLETED) => (State::Armed, Move::Ready),
            (State::Starting, Said::SETUP_COMPLETED) => return tell(output, Move::Ready),
            (State::Starting, Said::DELAY_TIMER_STARTED) => (State::Delay, Move::Countdown),
            (State::Starting | State::Delay, Said::PRE_MOVE_PHOTOS_STARTED) => (State::PreShoot, Move::PreShoot),
            (State::Starting | State::Delay | State::PreShoot | State::Ended, Said::START_FORWARD) => {
                (State::Running, Move::Running(Direction::Forward))
            }
            (State::Starting | State::Delay | State::PreShoot | State::Ended, Said::START_REVERSE) => {
                (State::Running, Move::Running(Direction::Reverse))
            }
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
    }

    /// The device says that something failed; whether the move has to be stopped for it.
    pub(super) fn error(&mut self, output: &mut Output, code: ErrorCode) -> bool {
        let fails = matches!(code.0, 0 | 2 | 3 | 6 | 17 | 19 | 20);
        match self.state {
            State::NoMove | State::Stopping => false,
            State::Delay | State::PreShoot | State::Running | State::Ended
                if code == ErrorCode::CANNOT_EXECUTE_MOVE =>
            {
                tell(output, Move::Refused);
                false
            }
            // There is no such motor: said of the move, where nothing else is under way (decision K-S14).
            State::SettingUp | State::Starting if fails || code == ErrorCode::BAD_MOTOR_ADDRESS => {
                tell(output, Move::Failed(code));
                true
            }
            _ if fails => {
                tell(output, Move::Failed(code));
                true
            }
            _ => false,
        }
    }

    /// Deals with a deadline that has come; whether a stop has to be sent again.
    pub(super) fn wake(&mut self, now: Millis, output: &mut Output) -> bool {
        if self.deadline.is_none_or(|deadline| deadline > now) {
            return false;
        }
        self.deadline = None;
        if self.state == State::Stopping {
            output.event(Event::StopNotConfirmed(None));
            return true;
        }
        tell(output, Move::Slow);
        false
    }
}
