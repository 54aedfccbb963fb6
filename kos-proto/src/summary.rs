//! What the machines of both sides know of a move and of its motors: a summary of fixed size.
//!
//! The blocks of a move stay with the caller, however long they are. [`MoveSummary::of`] takes from the
//! [`Trajectory`] in them what decides when something happens, in whole milliseconds: times, loops, photos, and which
//! motors take part; and it refuses what no device can play.

use crate::message::{ErrorCode, MotorAddress, Normalized, PlaybackDirection, PlaybackMode, Seconds};
use crate::trajectory::{
    Delay, LiveMotion, Loop, LoopCount, MoveError, Play, Style, TimeLapseMotion, Trajectory, TrajectoryData,
};

/// The greatest number of motors that a device has (decision K-M1).
pub const MOTORS: usize = MotorAddress::LAST.0 as usize;

/// A set of motors, by their numbers 1 to 10.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct MotorSet(u16);

impl MotorSet {
    /// No motor.
    pub const NONE: Self = Self(0);

    const FIRST: u8 = 1;
    const LAST: u8 = MotorAddress::LAST.0;

    /// These motors. Addresses that no motor can have are left out.
    #[must_use]
    pub fn of(motors: impl IntoIterator<Item = MotorAddress>) -> Self {
        let mut set = Self::NONE;
        motors.into_iter().for_each(|motor| set.insert(motor));
        set
    }

    const fn bit(motor: MotorAddress) -> u16 {
        match motor.number() {
            number @ Self::FIRST..=Self::LAST => 1_u16.wrapping_shl(number as u32),
            _ => 0,
        }
    }

    /// Whether a motor is one of them.
    #[must_use]
    pub const fn contains(self, motor: MotorAddress) -> bool {
        self.0 & Self::bit(motor) != 0
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Adds a motor, unless no motor can have the address.
    pub const fn insert(&mut self, motor: MotorAddress) {
        self.0 |= Self::bit(motor);
    }

    /// Takes a motor out.
    pub const fn remove(&mut self, motor: MotorAddress) {
        self.0 &= !Self::bit(motor);
    }

    /// They, by their numbers.
    pub fn iter(self) -> impl Iterator<Item = MotorAddress> {
        (Self::FIRST..=Self::LAST).map(MotorAddress).filter(move |&motor| self.contains(motor))
    }
}

/// How a client is connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Transport {
    /// A stream in a network: behind the lock of the password.
    Tcp,
    /// Reports over USB: never locked (decision K-U7).
    Usb,
}

/// Which way a move is played.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Direction {
    /// From its begin.
    Forward,
    /// From its end.
    Reverse,
}

impl Direction {
    /// The way of a message; `None` where the number means nothing.
    #[must_use]
    pub const fn of(direction: PlaybackDirection) -> Option<Self> {
        match direction {
            PlaybackDirection::FORWARD => Some(Self::Forward),
            PlaybackDirection::REVERSE => Some(Self::Reverse),
            _ => None,
        }
    }

    /// As it stands in a message.
    #[must_use]
    pub const fn as_sent(self) -> PlaybackDirection {
        match self {
            Self::Forward => PlaybackDirection::FORWARD,
            Self::Reverse => PlaybackDirection::REVERSE,
        }
    }

    /// The other way.
    #[must_use]
    pub const fn back(self) -> Self {
        match self {
            Self::Forward => Self::Reverse,
            Self::Reverse => Self::Forward,
        }
    }
}

/// A move that a device can play, without its curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct MoveSummary {
    /// How it is played.
    pub kind: Kind,
    /// What it waits for.
    pub wait: Wait,
    /// How fast the motors go to where it begins, as a part of their greatest speed.
    pub return_to_home_percent: Normalized,
    /// The motors that take part.
    pub motors: MotorSet,
}

/// How a move is played.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// In one go, for video.
    Live {
        /// How long it takes, in milliseconds, at least 1.
        duration: u64,
        /// What follows its end.
        loops: Option<Loops>,
    },
    /// Photos while the motors move.
    Continuous(Shots),
    /// Shoot, move, shoot.
    ShootMoveShoot(Shots),
}

/// How a live move goes back and starts again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Loops {
    /// How long the way back takes, in milliseconds, at least 1.
    pub duration: u64,
    /// How often, at least once.
    pub count: LoopCount,
}

/// The photos of a time lapse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Shots {
    /// Time before a photo, in milliseconds.
    pub delay: u64,
    /// Time of a photo, in milliseconds; with `delay`, at least 1.
    pub exposure: u64,
    /// Photos in the move, at least 1.
    pub moving: u32,
    /// Photos before it.
    pub before: u32,
    /// Photos behind it.
    pub after: u32,
}

impl Shots {
    /// Time from one photo to the next, in milliseconds, without the way between them.
    #[must_use]
    pub const fn interval(&self) -> u64 {
        self.delay.saturating_add(self.exposure)
    }
}

/// What a move waits for before it begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Wait {
    /// Nothing.
    None,
    /// A time in milliseconds.
    For(u64),
    /// A moment, in seconds since 1970 (safety decision 5).
    Until(u32),
}

/// Why no device can play a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum SummaryError {
    /// Its blocks do not make a move, or one without motors.
    #[error("{0}")]
    Malformed(MoveError),
    /// It takes no time.
    #[error("the move takes no time")]
    Time,
}

impl SummaryError {
    /// What a device says of it (decisions K-J10 and K-J14).
    #[must_use]
    pub const fn code(&self) -> ErrorCode {
        match self {
            Self::Time => ErrorCode::INVALID_MOVE_TIME,
            Self::Malformed(_) => ErrorCode::TRAJECTORY,
        }
    }
}

/// A duration that no move can have is an error of its own (decision K-J10).
impl From<MoveError> for SummaryError {
    fn from(error: MoveError) -> Self {
        match error {
            MoveError::Number { what: "duration", .. } | MoveError::NotFinite { what: "duration", .. } => Self::Time,
            error => Self::Malformed(error),
        }
    }
}

impl MoveSummary {
    /// Reads a move.
    ///
    /// # Errors
    ///
    /// [`SummaryError`]: what takes no time (decision K-J10), what [`Trajectory::new`] refuses, and a move without motors.
    pub fn of(data: &TrajectoryData<'_>) -> Result<Self, SummaryError> {
        let trajectory = Trajectory::new(data)?;
        let motors = MotorSet::of(trajectory.tracks().map(|track| track.motor()));
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

    /// How many photos the move has, `None` if it is none of photos.
    #[must_use]
    pub const fn shots(&self) -> Option<Shots> {
        match self.kind {
            Kind::Live { .. } => None,
            Kind::Continuous(shots) | Kind::ShootMoveShoot(shots) => Some(shots),
        }
    }

    /// The mode, as it stands in a message.
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

/// A time of at least a millisecond.
fn some_time(time: Seconds) -> Result<u64, SummaryError> {
    Some(millis(time)).filter(|&millis| millis > 0).ok_or(SummaryError::Time)
}

/// Milliseconds, rounded; 0 for what is negative or no number, and all the time there is for what is infinite.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion cuts off what is behind the point, and stays at the greatest and the least number"
)]
pub(crate) fn millis(time: Seconds) -> u64 {
    (f64::from(time.0) * 1000.0 + 0.5) as u64
}

/// Seconds, as near as an IEEE number comes.
#[expect(clippy::cast_precision_loss, reason = "what is left of a wait is shown to people")]
pub(crate) fn seconds(millis: u64) -> Seconds {
    Seconds(millis as f32 / 1000.0)
}

/// A part of a whole, 0 to 1.
#[expect(clippy::cast_precision_loss, reason = "how much of a move is over is shown to people")]
pub(crate) fn part(done: u64, whole: u64) -> Normalized {
    Normalized(if done < whole { done as f32 / whole as f32 } else { 1.0 })
}

/// `Debug` of a struct with many fields: a derived one cannot be proven free of panics.
macro_rules! debug_fields {
    ($($name:ident { $($field:ident),* $(,)? })*) => {$(
        impl core::fmt::Debug for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.debug_struct(stringify!($name))$(.field(stringify!($field), &self.$field))*.finish()
            }
        }
    )*};
}
pub(crate) use debug_fields;

/// The builders of options: each takes the options, and gives them with one of them set.
macro_rules! with {
    ($($(#[$meta:meta])* $with:ident $field:ident: $type:ty;)*) => {$(
        $(#[$meta])*
        #[must_use]
        pub const fn $with(self, $field: $type) -> Self {
            Self { $field, ..self }
        }
    )*};
}
pub(crate) use with;
