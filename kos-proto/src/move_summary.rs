//! Summaries of moves, which the machines of both sides keep instead of the moves.
//!
//! The blocks of a move stay with the caller, because they can be long. [`MoveSummary::of`] reads the parts of the
//! [`Trajectory`] that decide when something happens: times in whole milliseconds, loops, photos, and the motors that
//! take part. It refuses moves that no device can play.

use crate::message::{ErrorCode, MotorSet, Normalized, PlaybackMode, Seconds};
use crate::times::millis;
use crate::trajectory::{
    Delay, LiveMotion, Loop, LoopCount, MoveError, Play, Style, TimeLapseMotion, Trajectory, TrajectoryData,
};

/// Summary of a move that a device can play: everything that decides when something happens, without the curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde"))]
pub struct MoveSummary {
    /// Kind of the move.
    pub kind: Kind,
    /// Wait before the move begins.
    pub wait: Wait,
    /// Speed of the motors on the way to where the move begins, as a part of their greatest speed.
    pub return_to_home_percent: Normalized,
    /// Motors that take part.
    pub motors: MotorSet,
}

/// Kind of a move, with its times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde", rename_all = "snake_case"))]
pub enum Kind {
    /// Live motion, for video.
    Live {
        /// Duration of the move in milliseconds, at least 1.
        duration: u64,
        /// Loops after the first pass.
        loops: Option<Loops>,
    },
    /// Photos while the motors move.
    Continuous(Shots),
    /// Photos while the motors rest: shoot, move, shoot.
    ShootMoveShoot(Shots),
}

/// Loops of a live move. In each loop the motors go back, and the move is played again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde"))]
pub struct Loops {
    /// Duration of the way back in milliseconds, at least 1.
    pub duration: u64,
    /// Number of loops, at least 1.
    pub count: LoopCount,
}

/// Photos of a time lapse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde"))]
pub struct Shots {
    /// Time before each photo in milliseconds.
    pub delay: u64,
    /// Exposure of each photo in milliseconds. The sum of `delay` and `exposure` is at least 1.
    pub exposure: u64,
    /// Number of photos in the move, at least 1.
    pub moving: u32,
    /// Number of photos before the move.
    pub before: u32,
    /// Number of photos after the move.
    pub after: u32,
}

impl Shots {
    /// Time from one photo to the next in milliseconds, without the move between them.
    #[must_use]
    pub const fn interval(&self) -> u64 {
        self.delay.saturating_add(self.exposure)
    }
}

/// Wait before a move begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde", rename_all = "snake_case"))]
pub enum Wait {
    /// No wait.
    None,
    /// Wait for a time in milliseconds.
    For(u64),
    /// Wait until a moment, in seconds since 1970 (safety decision 5).
    Until(u32),
}

/// Reason why no device can play a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum SummaryError {
    /// The blocks do not make a move, or they make a move without motors.
    #[error("{0}")]
    Malformed(MoveError),
    /// The move takes no time.
    #[error("the move takes no time")]
    Time,
}

motion_core::__defmt! { as this: SummaryError => SummaryError { code: ErrorCode = this.code(), } }

impl SummaryError {
    /// Error code with which a device answers (decisions K-J10 and K-J14).
    #[must_use]
    pub const fn code(&self) -> ErrorCode {
        match self {
            Self::Time => ErrorCode::INVALID_MOVE_TIME,
            Self::Malformed(_) => ErrorCode::TRAJECTORY,
        }
    }
}

/// Conversion in which a duration that no move can have becomes an error of its own (decision K-J10).
impl From<MoveError> for SummaryError {
    fn from(error: MoveError) -> Self {
        match error {
            MoveError::Number { what: "duration", .. } | MoveError::NotFinite { what: "duration", .. } => Self::Time,
            error => Self::Malformed(error),
        }
    }
}

impl MoveSummary {
    /// Reads the summary of a move.
    ///
    /// # Errors
    ///
    /// [`SummaryError`], if the move takes no time (decision K-J10), has no motors, or [`Trajectory::new`] refuses it.
    pub fn of(data: &TrajectoryData<'_>) -> Result<Self, SummaryError> {
        let trajectory = Trajectory::new(data)?;
        let motors = trajectory.motors();
        if motors.is_empty() {
            return Err(MoveError::NoMotors.into());
        }
        let play = trajectory.play();
        let kind = match play {
            Play::Live(live) => {
                Kind::Live { duration: some_time(live.duration)?, loops: Loops::of(&live).transpose()? }
            }
            Play::TimeLapse(photos) => match photos.style {
                Style::Continuous => Kind::Continuous(Shots::of(&photos)?),
                Style::ShootMoveShoot => Kind::ShootMoveShoot(Shots::of(&photos)?),
            },
        };
        Ok(Self { kind, wait: play.delay().into(), return_to_home_percent: play.home_speed(), motors })
    }

    /// Photos of the move; `None` if it takes no photos.
    #[must_use]
    pub const fn shots(&self) -> Option<Shots> {
        match self.kind {
            Kind::Live { .. } => None,
            Kind::Continuous(shots) | Kind::ShootMoveShoot(shots) => Some(shots),
        }
    }

    /// Mode of the move, as messages name it.
    #[must_use]
    pub const fn mode(&self) -> PlaybackMode {
        match self.kind {
            Kind::Live { .. } => PlaybackMode::LIVE_MOTION,
            Kind::Continuous(_) => PlaybackMode::TIME_LAPSE_CONTINUOUS,
            Kind::ShootMoveShoot(_) => PlaybackMode::TIME_LAPSE_SMS,
        }
    }
}

impl Loops {
    fn of(live: &LiveMotion) -> Option<Result<Self, SummaryError>> {
        let (times, back) = match live.repeat {
            Loop::Once => return None,
            Loop::Reverse(times) => (times, live.duration),
            Loop::RapidReverse { times, duration } => (times, duration.unwrap_or(live.duration)),
        };
        Some(some_time(back).map(|duration| Self { duration, count: times.into() }))
    }
}

impl Shots {
    fn of(photos: &TimeLapseMotion) -> Result<Self, SummaryError> {
        let shots = Self {
            delay: millis(photos.interval),
            exposure: millis(photos.exposure),
            moving: photos.photos,
            before: photos.photos_before,
            after: photos.photos_after,
        };
        if shots.interval() == 0 || shots.moving == 0 { Err(SummaryError::Time) } else { Ok(shots) }
    }
}

impl From<Delay> for Wait {
    fn from(delay: Delay) -> Self {
        match delay {
            Delay::None => Self::None,
            Delay::For(time) => Self::For(millis(time)),
            Delay::Until(moment) | Delay::UntilFloat(moment) => Self::Until(moment),
        }
    }
}

/// Time in milliseconds, or [`SummaryError::Time`] if it is less than 1 ms.
fn some_time(time: Seconds) -> Result<u64, SummaryError> {
    Some(millis(time)).filter(|&millis| millis > 0).ok_or(SummaryError::Time)
}
