//! How a move is played, as people mean it: what cannot be meant cannot be said.

use core::fmt;
use core::num::NonZeroU8;

use motion_core::wire::Bool;

use super::blocks::{Playback, TimeLapse};
use super::error::{MoveError, Place};
use super::values::{DelayInterval, DelayMode, LoopCount};
use crate::message::{Normalized, PlaybackMode, Seconds};

/// How a move is played. Source: kOS, `TrajectoryData`, blocks 1 and 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Play {
    /// The motors move all the time.
    Live(LiveMotion),
    /// The motors move from photo to photo; there is no loop.
    TimeLapse(TimeLapseMotion),
}

/// A move in real time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LiveMotion {
    /// How long it takes once: more than 0.
    pub duration: Seconds,
    /// What comes then.
    pub repeat: Loop,
    /// What it waits for before it begins.
    pub delay: Delay,
    /// How fast the motors go to where the move begins, as a part of their greatest speed: more than 0, at most 1
    /// (decision K-J6).
    ///
    /// There is no default: how fast a camera may sweep through a room, only who stands there can say (safety decision
    /// 9).
    pub home_speed: Normalized,
}

/// A move from photo to photo.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct TimeLapseMotion {
    /// What the motors do while the shutter is open.
    pub style: Style,
    /// Time from the end of one exposure to the next.
    pub interval: Seconds,
    /// How long the shutter is open.
    pub exposure: Seconds,
    /// Photos in the move: at least one.
    pub photos: u32,
    /// Photos before the move.
    pub photos_before: u32,
    /// Photos behind the move.
    pub photos_after: u32,
    /// What it waits for before it begins.
    pub delay: Delay,
    /// How fast the motors go to where the move begins, as in [`LiveMotion::home_speed`].
    pub home_speed: Normalized,
}

/// What the motors do while the shutter is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Style {
    /// They move on.
    Continuous,
    /// They stand still: shoot, move, shoot.
    ShootMoveShoot,
}

/// What comes after a live move; one loop excludes the other (decision K-J4).
///
/// After `n` loops the move was played forward `n + 1` times, and ends where it ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Loop {
    /// Nothing.
    Once,
    /// It is played back, and then again.
    Reverse(Times),
    /// The motors go back at once, and then it is played again.
    RapidReverse {
        /// How often.
        times: Times,
        /// How long the way back takes, more than 0; as long as the move if not said.
        ///
        /// The specification wants no other, so lint warns of one (decision K-J5).
        duration: Option<Seconds>,
    },
}

/// A number of loops: 1 to 254, or for ever (decision K-J4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Times(NonZeroU8);

impl Times {
    /// Until it is stopped.
    pub const FOREVER: Self = Self(NonZeroU8::MAX);

    /// So many times; `None` unless 1 to 254.
    #[must_use]
    pub const fn new(count: u8) -> Option<Self> {
        match NonZeroU8::new(count) {
            Some(count) if count.get() < NonZeroU8::MAX.get() => Some(Self(count)),
            _ => None,
        }
    }

    /// How many; `None` for ever.
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

/// What a move waits for before it begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Delay {
    /// Nothing.
    None,
    /// A time.
    For(Seconds),
    /// A moment, in seconds since 1970 (decision K-J3).
    ///
    /// A device without a clock, or past that moment, should not start. One that reads an IEEE number never does, which
    /// is the safe mistake (safety decision 5). The moments of 2011-09-26 to 2012-01-01 would be read as such and are
    /// refused.
    Until(u32),
    /// A moment of 2004 to 2038 as IEEE number, rounded to 128 seconds.
    ///
    /// Only for a device that is known to read it so: one that reads an integer starts at once. Lint warns of it.
    UntilFloat(u32),
}

impl Play {
    /// What it waits for before it begins.
    #[must_use]
    pub const fn delay(&self) -> Delay {
        match self {
            Self::Live(live) => live.delay,
            Self::TimeLapse(photos) => photos.delay,
        }
    }

    /// How fast the motors go to where the move begins, as a part of their greatest speed.
    #[must_use]
    pub const fn home_speed(&self) -> Normalized {
        match self {
            Self::Live(live) => live.home_speed,
            Self::TimeLapse(photos) => photos.home_speed,
        }
    }

    /// Seconds from the begin of the move to its end, once; key frames are measured by it.
    ///
    /// For a time lapse an estimate, interval and exposure times the photos: how a device counts is not said (decision
    /// K-J10).
    #[must_use]
    pub fn move_time(&self) -> f64 {
        match self {
            Self::Live(live) => live.duration.0.into(),
            Self::TimeLapse(photos) => photos.time_of(photos.photos.into()),
        }
    }

    /// Seconds from the begin of the move to its end, with loops, and with the photos before and behind; `None` if it
    /// ends only when it is stopped.
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

    /// Seconds from the moment when the motors stand at the begin, to the end: [`playing_time`](Self::playing_time) and
    /// the delay. `None` if it ends only when it is stopped, or waits for a moment.
    ///
    /// How long the motors need to get to the begin is not in it: nobody but the device knows.
    #[must_use]
    pub fn total_time(&self) -> Option<f64> {
        let delay = match self.delay() {
            Delay::None => 0.0,
            Delay::For(Seconds(delay)) => f64::from(delay),
            Delay::Until(_) | Delay::UntilFloat(_) => return None,
        };
        self.playing_time().map(|time| time + delay).filter(|time| time.is_finite())
    }

    /// How far in the move it is so many seconds after its begin, 0 to 1, as `PlaybackStatus` reports it; on a way back
    /// it goes down.
    ///
    /// It is 0 before the begin and 1 behind the end. A time lapse is taken to go on evenly for its
    /// [`move_time`](Self::move_time); the photos before the move are over.
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

    /// The two blocks that say this.
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
            flash_mark_enabled: 0,
            flash_mark_type: 0,
            flash_mark_post_delay: off,
            use_external_trigger: 0,
            using_lanc: 0,
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
                    return Err(MoveError::number(Place::Move, "move_photos", 0.0, "is no move"));
                }
                let playback_mode = match photos.style {
                    Style::Continuous => PlaybackMode::TIME_LAPSE_CONTINUOUS,
                    Style::ShootMoveShoot => PlaybackMode::TIME_LAPSE_SMS,
                };
                (Playback { playback_mode, ..playback }, photos.block(time_lapse))
            }
        })
    }

    /// What two blocks say.
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

/// The number without what is behind the point; for one too great for that, something smaller.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    reason = "never negative; beyond 2^53 there is nothing behind the point"
)]
fn whole(number: f64) -> f64 {
    number as u64 as f64
}

/// The number between 0 and the greatest; what is no number is 0, as nothing divided by nothing.
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
                    return Err(MoveError::number(Place::Move, what, back.0, "is no time for a way back"));
                }
                Playback { loop_after_rapid_reverse: times.into(), rapid_reverse_duration: back, ..playback }
            }
        })
    }
}

// A derived one of so many fields cannot be proven free of panics.
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

    /// Seconds that so many photos take (decision K-J10).
    fn time_of(&self, photos: f64) -> f64 {
        (f64::from(self.interval.0) + f64::from(self.exposure.0)) * photos
    }
}

impl Loop {
    /// How often it comes back, `None` for ever, and how many seconds each way back takes.
    fn loops(self, duration: Seconds) -> (Option<u8>, f64) {
        match self {
            Self::Once => (Some(0), 0.0),
            Self::Reverse(times) => (times.count(), duration.0.into()),
            Self::RapidReverse { times, duration: other } => (times.count(), other.unwrap_or(duration).0.into()),
        }
    }

    /// The loop of a live move, which has at most one.
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
            let note = if float { "is not in 2004 to 2038" } else { "would be read as an IEEE number" };
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
