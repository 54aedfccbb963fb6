//! Playing a move, in the terms of its user. These types cannot express combinations that make no sense.

use core::fmt;
use core::num::NonZeroU8;

use motion_core::wire::Bool;

use super::blocks::{Playback, TimeLapse};
use super::error::{MoveError, Place};
use super::values::{DelayInterval, DelayMode, LoopCount};
use crate::message::{Normalized, PlaybackMode, Seconds};

/// Settings for playing a move: live or as a time lapse. Source: kOS, `TrajectoryData`, blocks 1 and 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde", rename_all = "snake_case"))]
pub enum Play {
    /// Live move: the motors move all the time.
    Live(LiveMotion),
    /// Time lapse: the motors move from photo to photo. It has no loops.
    TimeLapse(TimeLapseMotion),
}

/// Move in real time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde"))]
pub struct LiveMotion {
    /// Time that the move takes once, in seconds; more than 0.
    pub duration: Seconds,
    /// Loop after the move.
    pub repeat: Loop,
    /// Condition for the start.
    pub delay: Delay,
    /// Speed on the way to the start of the move, as a part of the greatest speed of each motor: more than 0, at most 1
    /// (decision K-J6).
    ///
    /// There is no default, because only a person at the rig can say how fast the camera may move through the room
    /// (safety decision 9).
    pub home_speed: Normalized,
}

/// Move from photo to photo.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde"))]
pub struct TimeLapseMotion {
    /// State of the motors while the shutter is open.
    pub style: Style,
    /// Time from the end of one exposure to the next, in seconds.
    pub interval: Seconds,
    /// Time that the shutter is open, in seconds.
    pub exposure: Seconds,
    /// Number of photos in the move: at least one.
    pub photos: u32,
    /// Number of photos before the move.
    pub photos_before: u32,
    /// Number of photos after the move.
    pub photos_after: u32,
    /// Condition for the start.
    pub delay: Delay,
    /// Speed on the way to the start of the move, as in [`LiveMotion::home_speed`].
    pub home_speed: Normalized,
}

/// State of the motors while the shutter is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde", rename_all = "snake_case"))]
pub enum Style {
    /// The motors move on.
    Continuous,
    /// The motors stand still: shoot, move, shoot.
    ShootMoveShoot,
}

/// Loops of a live move. Only one of the two kinds can be used (decision K-J4).
///
/// After `n` loops the move was played forward `n + 1` times, and it ends at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde", rename_all = "snake_case"))]
pub enum Loop {
    /// No loop.
    Once,
    /// The move is played backward, and then forward again.
    Reverse(Times),
    /// The motors go back directly, and then the move is played again.
    RapidReverse {
        /// Number of loops.
        times: Times,
        /// Time that the way back takes, in seconds, more than 0; `None` for the duration of the move.
        ///
        /// The specification advises the duration of the move, so lint warns of another time (decision K-J5).
        duration: Option<Seconds>,
    },
}

/// Number of loops: 1 to 254, or for ever (decision K-J4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde"))]
pub struct Times(NonZeroU8);

impl Times {
    /// Loops until the move is stopped.
    pub const FOREVER: Self = Self(NonZeroU8::MAX);

    /// Number of loops; `None` unless it is 1 to 254.
    #[must_use]
    pub const fn new(count: u8) -> Option<Self> {
        match NonZeroU8::new(count) {
            Some(count) if count.get() < NonZeroU8::MAX.get() => Some(Self(count)),
            _ => None,
        }
    }

    /// Number of loops; `None` if they go on for ever.
    #[must_use]
    pub const fn count(self) -> Option<u8> {
        if self.0.get() == NonZeroU8::MAX.get() { None } else { Some(self.0.get()) }
    }
}

impl From<Times> for LoopCount {
    fn from(Times(count): Times) -> Self {
        Self(count.get())
    }
}

/// Condition for the start of a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde", rename_all = "snake_case"))]
pub enum Delay {
    /// No delay.
    None,
    /// Time to wait, in seconds.
    For(Seconds),
    /// Moment to wait for, in seconds since 1970 (decision K-J3).
    ///
    /// A device without a clock should not start, and neither should one whose clock is past that moment. A device that
    /// reads an IEEE number never starts, which is the safe mistake (safety decision 5). Moments from 2011-09-26 to
    /// 2012-01-01 would be read as IEEE numbers and are refused.
    Until(u32),
    /// Moment from 2004 to 2038 as an IEEE number, rounded to 128 seconds.
    ///
    /// Use it only for a device that is known to read an IEEE number, because a device that reads an integer starts at
    /// once. Lint warns of it.
    UntilFloat(u32),
}

impl Play {
    /// Condition for the start.
    #[must_use]
    pub const fn delay(&self) -> Delay {
        match self {
            Self::Live(live) => live.delay,
            Self::TimeLapse(photos) => photos.delay,
        }
    }

    /// Speed on the way to the start of the move, as a part of the greatest speed of each motor.
    #[must_use]
    pub const fn home_speed(&self) -> Normalized {
        match self {
            Self::Live(live) => live.home_speed,
            Self::TimeLapse(photos) => photos.home_speed,
        }
    }

    /// Time from the start of the move to its end, once, in seconds. Key frames are measured in it.
    ///
    /// For a time lapse it is an estimate: interval plus exposure, times the number of photos. The specification does
    /// not say how a device counts (decision K-J10).
    #[must_use]
    pub fn move_time(&self) -> f64 {
        match self {
            Self::Live(live) => live.duration.0.into(),
            Self::TimeLapse(photos) => photos.time_of(photos.photos.into()),
        }
    }

    /// Time from the start of the move to its end, in seconds, with loops and with the photos before and after. `None`
    /// if the move ends only when it is stopped.
    #[must_use]
    pub fn playing_time(&self) -> Option<f64> {
        let time = match self {
            Self::Live(live) => {
                let (loops, back) = live.repeat.loops(live.duration);
                let loops = f64::from(loops?);
                (loops + 1.0) * self.move_time() + loops * back
            }
            Self::TimeLapse(photos) => {
                let all = [photos.photos_before, photos.photos, photos.photos_after].map(f64::from);
                photos.time_of(all.iter().sum())
            }
        };
        Some(time).filter(|time| time.is_finite())
    }

    /// Time from the moment when the motors stand at the start until the end, in seconds: the delay and the
    /// [`playing_time`](Self::playing_time). `None` if the move ends only when it is stopped, or waits for a moment.
    ///
    /// The time that the motors need to reach the start is not included, because only the device knows it.
    #[must_use]
    pub fn total_time(&self) -> Option<f64> {
        let delay = match self.delay() {
            Delay::None => 0.0,
            Delay::For(Seconds(delay)) => f64::from(delay),
            Delay::Until(_) | Delay::UntilFloat(_) => return None,
        };
        self.playing_time().map(|time| time + delay).filter(|time| time.is_finite())
    }

    /// Part of the move that has elapsed at a time after its start, 0 to 1, as `PlaybackStatus` reports it. On a way
    /// back it decreases.
    ///
    /// It is 0 before the start and 1 after the end. A time lapse is assumed to advance evenly over its
    /// [`move_time`](Self::move_time), after the photos before the move.
    #[must_use]
    pub fn elapsed_at(&self, seconds: f64) -> f64 {
        let forward = self.move_time();
        let seconds = up_to(seconds, f64::MAX);
        let (loops, back) = match self {
            Self::Live(live) => live.repeat.loops(live.duration),
            Self::TimeLapse(_) => (Some(0), 0.0),
        };
        let period = forward + back;
        let last = loops.map(|loops| f64::from(loops) * period);
        let elapsed = match last {
            Some(last) if seconds >= last => (seconds - last) / forward,
            _ => {
                let within = seconds - period * whole(seconds / period);
                if within <= forward { within / forward } else { 1.0 - (within - forward) / back }
            }
        };
        up_to(elapsed, 1.0)
    }

    /// The two blocks that describe this.
    pub(super) fn blocks(&self) -> Result<(Playback<'static>, TimeLapse<'static>), MoveError> {
        let (delay_mode, delay_interval_bits) = self.delay().bits()?;
        let off = Seconds(0.0);
        let playback = Playback {
            playback_mode: PlaybackMode::LIVE_MOTION,
            duration: off,
            rapid_reverse_duration: off,
            loop_after_rapid_reverse: LoopCount::NONE,
            loop_after_reverse: LoopCount::NONE,
            delay_mode,
            delay_interval_bits,
            camera_roll_enabled: Bool::FALSE,
            camera_roll_pre_delay: off,
            camera_roll_post_delay: off,
            flash_mark_enabled: Bool::FALSE,
            flash_mark_type: 0,
            flash_mark_post_delay: off,
            use_external_trigger: Bool::FALSE,
            using_lanc: Bool::FALSE,
            return_to_home_percent: self.home_speed(),
            tail: &[],
        };
        let time_lapse = TimeLapse {
            delay: off,
            exposure: off,
            move_photos: 0,
            not_used: 0,
            pre_move_photos: 0,
            post_move_photos: 0,
            tail: &[],
        };
        Ok(match self {
            Self::Live(live) => (live.playback(playback)?, time_lapse),
            Self::TimeLapse(photos) => {
                if photos.photos == 0 {
                    return Err(MoveError::number(Place::Move, "move_photos", 0.0, "is less than one photo"));
                }
                let playback_mode = match photos.style {
                    Style::Continuous => PlaybackMode::TIME_LAPSE_CONTINUOUS,
                    Style::ShootMoveShoot => PlaybackMode::TIME_LAPSE_SMS,
                };
                (Playback { playback_mode, ..playback }, photos.block(time_lapse))
            }
        })
    }

    /// Reads two blocks.
    pub(super) fn read(playback: &Playback<'_>, photos: &TimeLapse<'_>) -> Result<Self, MoveError> {
        let delay = Delay::read(playback.delay_mode, playback.delay_interval_bits)?;
        let home_speed = playback.return_to_home_percent;
        let style = match playback.playback_mode {
            PlaybackMode::LIVE_MOTION => {
                let (duration, repeat) = (playback.duration, Loop::read(playback));
                return Ok(Self::Live(LiveMotion { duration, repeat, delay, home_speed }));
            }
            PlaybackMode::TIME_LAPSE_CONTINUOUS => Style::Continuous,
            PlaybackMode::TIME_LAPSE_SMS => Style::ShootMoveShoot,
            PlaybackMode(value) => return Err(MoveError::Unnamed { what: "playback_mode", value }),
        };
        Ok(Self::TimeLapse(TimeLapseMotion {
            style,
            interval: photos.delay,
            exposure: photos.exposure,
            photos: photos.move_photos,
            photos_before: photos.pre_move_photos,
            photos_after: photos.post_move_photos,
            delay,
            home_speed,
        }))
    }
}

/// Number without its fraction. A number too great for `u64` becomes smaller.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    reason = "never negative; numbers above 2^53 have no fraction"
)]
fn whole(number: f64) -> f64 {
    number as u64 as f64
}

/// Number limited to 0 and the greatest. NaN, for example 0 / 0, becomes 0.
fn up_to(number: f64, most: f64) -> f64 {
    if number > 0.0 { number.min(most) } else { 0.0 }
}

impl LiveMotion {
    fn playback<'a>(&self, playback: Playback<'a>) -> Result<Playback<'a>, MoveError> {
        let duration = self.duration;
        let playback = Playback { duration, rapid_reverse_duration: duration, ..playback };
        Ok(match self.repeat {
            Loop::Once => playback,
            Loop::Reverse(times) => Playback { loop_after_reverse: times.into(), ..playback },
            Loop::RapidReverse { times, duration: other } => {
                let back = other.unwrap_or(duration);
                if back.0 == 0.0 {
                    let what = "rapid_reverse_duration";
                    return Err(MoveError::number(Place::Move, what, back.0, "is too short for a way back"));
                }
                Playback { loop_after_rapid_reverse: times.into(), rapid_reverse_duration: back, ..playback }
            }
        })
    }
}

// A derived `Debug` of so many fields cannot be proven free of panics.
impl fmt::Debug for TimeLapseMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TimeLapseMotion")
            .field("style", &self.style)
            .field("interval", &self.interval)
            .field("exposure", &self.exposure)
            .field("photos", &self.photos)
            .field("photos_before", &self.photos_before)
            .field("photos_after", &self.photos_after)
            .field("delay", &self.delay)
            .field("home_speed", &self.home_speed)
            .finish()
    }
}

impl TimeLapseMotion {
    fn block<'a>(&self, block: TimeLapse<'a>) -> TimeLapse<'a> {
        TimeLapse {
            delay: self.interval,
            exposure: self.exposure,
            move_photos: self.photos,
            pre_move_photos: self.photos_before,
            post_move_photos: self.photos_after,
            ..block
        }
    }

    /// Time that a number of photos takes, in seconds (decision K-J10).
    fn time_of(&self, photos: f64) -> f64 {
        (f64::from(self.interval.0) + f64::from(self.exposure.0)) * photos
    }
}

impl Loop {
    /// Number of loops, `None` for ever, and the time of each way back in seconds.
    fn loops(self, duration: Seconds) -> (Option<u8>, f64) {
        match self {
            Self::Once => (Some(0), 0.0),
            Self::Reverse(times) => (times.count(), duration.0.into()),
            Self::RapidReverse { times, duration: other } => (times.count(), other.unwrap_or(duration).0.into()),
        }
    }

    /// Loop of a live move, which has at most one.
    fn read(playback: &Playback<'_>) -> Self {
        let times = |LoopCount(count)| NonZeroU8::new(count).map(Times);
        let other = Some(playback.rapid_reverse_duration).filter(|&other| other != playback.duration);
        match (times(playback.loop_after_rapid_reverse), times(playback.loop_after_reverse)) {
            (Some(times), _) => Self::RapidReverse { times, duration: other },
            (None, Some(times)) => Self::Reverse(times),
            (None, None) => Self::Once,
        }
    }
}

impl Delay {
    fn bits(self) -> Result<(DelayMode, DelayInterval), MoveError> {
        let moment = |interval: DelayInterval, seconds: u32, float| {
            if interval.is_float_time() == float {
                return Ok((DelayMode::UNTIL, interval));
            }
            let note = if float { "is not from 2004 to 2038" } else { "would be read as an IEEE number" };
            Err(MoveError::Moment { seconds, note })
        };
        match self {
            Self::None => Ok((DelayMode::NONE, DelayInterval::default())),
            Self::For(seconds) => Ok((DelayMode::INTERVAL, DelayInterval::from_seconds(seconds))),
            Self::Until(seconds) => moment(DelayInterval::from_unix_time(seconds), seconds, false),
            Self::UntilFloat(seconds) => moment(DelayInterval::from_unix_time_as_float(seconds), seconds, true),
        }
    }

    fn read(mode: DelayMode, interval: DelayInterval) -> Result<Self, MoveError> {
        match mode {
            DelayMode::NONE => Ok(Self::None),
            DelayMode::INTERVAL => Ok(Self::For(interval.seconds())),
            DelayMode::UNTIL if interval.is_float_time() => Ok(Self::UntilFloat(interval.unix_time())),
            DelayMode::UNTIL => Ok(Self::Until(interval.unix_time())),
            DelayMode(value) => Err(MoveError::Unnamed { what: "delay_mode", value }),
        }
    }
}
