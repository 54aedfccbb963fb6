//! Differences between firmware of different ages, as data.

mod age;
mod facts;

use core::cmp::Ordering;
use core::fmt;
use core::str::FromStr;

use super::Answer;
use crate::message::{CommonLine, HostMessage, RunState, StartDelay, ValueType, Version};
use age::Age;
pub use facts::DelayUnit;

/// Age of the firmware of a node, as far as it is known, because commands and replies depend on it.
///
/// A profile is one build: a day (from 2014-09-24 to 2015-01-08, with the libraries of that day), or a version (from v0.20
/// to v0.70). Or it is several builds one after the other, if a node does not tell more. The questions to a profile, such
/// as [`is_silent`](Self::is_silent), are answered by `None` if its builds differ.
///
/// Profiles have an order: one that is smaller is older, as a whole. Profiles that overlap are not ordered. The text of a
/// profile is a day, a version, two of them with "to" between them, or a name of the constants in lower case.
///
/// ```
/// use hoot_proto::query::Profile;
///
/// let build: Profile = "2014-12-03".parse()?;
/// assert!(Profile::SHEET < build && build < "v0.45".parse()?);
/// assert_eq!((build.one_is_paused(), build.is_silent()), (Some(true), Some(false)));
/// assert_eq!((Profile::VERSION_6.one_is_paused(), Profile::VERSION_6.to_string().as_str()), (None, "version-6"));
/// # Ok::<(), hoot_proto::query::ProfileError>(())
/// ```
///
/// Source: hoot, sections 1.2, 2 and 7; what firmware with motors answered (decision H-60).
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Profile {
    first: Age,
    last: Age,
}

/// Error of a text that names no firmware.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[error(
    "no firmware has this name: give a day from 2014-09-24 to 2015-01-08, a version from v0.20 to v0.70, sheet or unknown"
)]
pub struct ProfileError;

/// Profiles that have a name.
const NAMES: [(&str, Profile); 4] = [
    ("unknown", Profile::UNKNOWN),
    ("version-6", Profile::VERSION_6),
    ("sheet", Profile::SHEET),
    ("january-2015", Profile::JANUARY_2015),
];

impl Profile {
    /// Any firmware: nothing is known. Values for it are written as by v0.33.
    pub const UNKNOWN: Self = Self { first: Age::FIRST, last: Age::LAST };
    /// Firmware that says that its version is 6: all builds from 2014-09-24 to 2015-01-04.
    pub const VERSION_6: Self = Self { first: Age::FIRST, last: Age::day(2015, 1, 4) };
    /// Firmware with the library of 2014-09-25, which the published sheet describes.
    pub const LIBRARY_2014_09_25: Self = Self::one(Age::day(2014, 9, 25));
    /// Firmware of the sheet's date, 2014-10-28, whose version is 6.
    pub const SHEET: Self = Self::one(Age::day(2014, 10, 28));
    /// Firmware of 2015-01-08 or later, before v0.33.
    pub const JANUARY_2015: Self = Self { first: Age::version(20), last: Age::version(32) };
    /// Firmware v0.33, of 2015-04-07.
    pub const V033: Self = Self::one(Age::version(33));
    /// Firmware v0.35, of 2015-04-21.
    pub const V035: Self = Self::one(Age::version(35));
    /// Firmware v0.70 of 2016-08-10, or later.
    pub const V070: Self = Self::one(Age::LAST);

    const fn one(age: Age) -> Self {
        Self { first: age, last: age }
    }

    /// Firmware of a version, 20 for v0.20 to 70 for v0.70; `None` if it is another one.
    #[must_use]
    pub const fn version(version: u8) -> Option<Self> {
        let age = Age::version(version);
        if age.exists() { Some(Self::one(age)) } else { None }
    }

    /// Firmware of a day, with the libraries of that day, from 2014-09-24 to 2015-01-08; `None` if it is another day.
    #[must_use]
    pub const fn build(year: u16, month: u8, day: u8) -> Option<Self> {
        if year < 2014 || year > 2015 || month > 12 || day > 31 {
            return None;
        }
        let age = Age::day(year, month, day);
        if age.exists() { Some(Self::one(age)) } else { None }
    }

    /// Profiles of all builds that can be named, the oldest first.
    pub fn builds() -> impl Iterator<Item = Self> {
        Age::all().map(Self::one)
    }

    /// Whether the profile is one build.
    #[must_use]
    pub const fn is_one_build(self) -> bool {
        self.last.is_at_most(self.first)
    }

    const fn contains(self, age: Age) -> bool {
        self.first.is_at_most(age) && age.is_at_most(self.last)
    }

    /// Whether all builds are within a time, of which the end does not count; `None` if only some are.
    const fn is_within(self, since: Age, until: Age) -> Option<bool> {
        if since.is_at_most(self.first) && !until.is_at_most(self.last) {
            Some(true)
        } else if until.is_at_most(self.first) || !since.is_at_most(self.last) {
            Some(false)
        } else {
            None
        }
    }

    /// One build, for what has to be decided where nothing is known.
    pub(crate) const fn usual(self) -> Self {
        if self.contains(Self::V033.first) {
            Self::V033
        } else if self.contains(Self::SHEET.first) {
            Self::SHEET
        } else {
            Self::one(self.first)
        }
    }

    /// Number of the version, as the build answers it.
    #[must_use]
    pub(crate) const fn number(self) -> Version {
        let usual = self.usual();
        Version(match (usual.first.hundredths(), usual.has_long_version()) {
            (Some(hundredths), _) => hundredths as u32,
            (None, Some(true)) => 1907,
            (None, _) => 6,
        })
    }

    /// Profile of firmware that answers this version, as far as the version tells it.
    #[must_use]
    pub fn of_version(version: &Answer<Version>) -> Self {
        let between = |first, last| Self { first: Age::version(first), last: Age::version(last) };
        match (version.value_type(), version.value.0) {
            (ValueType::BYTE, 6) => Self::VERSION_6,
            (ValueType::BYTE, _) => Self::UNKNOWN,
            (_, 1907) => Self { first: Age::day(2015, 1, 5), last: Age::day(2015, 1, 7) },
            // Numbers of trial builds: of 2015-12-10 and 2015-12-15, and from 2016-01-27 on.
            (_, 9006 | 9007) => between(44, 46),
            (_, 999) => between(47, 48),
            (_, 70..) => Self::V070,
            (_, version) => u8::try_from(version).ok().and_then(Self::version).unwrap_or(Self::UNKNOWN),
        }
    }

    /// Builds of this profile that answer a query, or that refuse it.
    ///
    /// Version 6 stands for four months of builds. The queries for joystick mode, for ping-pong and for the sleep of a motor
    /// were added meanwhile, so a node tells its age by answering or refusing them. A refusal tells nothing in joystick mode,
    /// except for the query for joystick mode.
    ///
    /// ```
    /// use hoot_proto::message::{Motor, MotorMaxProgramSpeed};
    /// use hoot_proto::query::Profile;
    ///
    /// let query = MotorMaxProgramSpeed { motor: Motor::One }.into();
    /// assert_eq!(Profile::VERSION_6.that_answers(&query, true).one_is_paused(), Some(true));
    /// assert_eq!(Profile::VERSION_6.that_answers(&query, false).one_is_paused(), Some(false));
    /// ```
    #[must_use]
    pub fn that_answers(self, query: &HostMessage<'_>, answers: bool) -> Self {
        let since = match query {
            HostMessage::JoystickMode(_) => facts::JOYSTICK_QUERY,
            HostMessage::PingPong(_) => facts::PING_PONG_QUERY,
            HostMessage::MotorMaxProgramSpeed(_) => facts::SLEEP_QUERY,
            _ => return self,
        };
        let (older, newer) = (Self { last: since.before(), ..Self::UNKNOWN }, Self { first: since, ..Self::UNKNOWN });
        self.and(if answers { newer } else { older })
    }

    /// Builds that are in both profiles; the builds of this one if there are none.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let both = Self { first: self.first.max(other.first), last: self.last.min(other.last) };
        if both.first.is_at_most(both.last) { both } else { self }
    }

    /// Greatest number of packets that answer a request.
    ///
    /// No packet answers a broadcast or command 0. Two packets answer requests that firmware refuses and then
    /// acknowledges nevertheless.
    #[must_use]
    pub fn packets(self, request: &HostMessage<'_>) -> u8 {
        match request {
            HostMessage::Noop(_)
            | HostMessage::BroadcastStart(_)
            | HostMessage::BroadcastStop(_)
            | HostMessage::BroadcastPause(_)
            | HostMessage::BroadcastAssignAddress(_) => 0,
            HostMessage::SetCommonLine(message) if message.common_line > CommonLine::SECOND => 2,
            HostMessage::MotorSetEasing(message) if message.easing.name().is_none() => 2,
            HostMessage::MotorRunning(_) if self.answers_running_twice() != Some(false) => 2,
            _ => 1,
        }
    }
}

impl Default for Profile {
    fn default() -> Self {
        Self::UNKNOWN
    }
}

impl PartialOrd for Profile {
    /// Compares two times. Times that overlap have no order.
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        if self == other {
            Some(Ordering::Equal)
        } else if self.last < other.first {
            Some(Ordering::Less)
        } else if other.last < self.first {
            Some(Ordering::Greater)
        } else {
            None
        }
    }
}

impl fmt::Display for Profile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((name, _)) = NAMES.iter().find(|(_, profile)| profile == self) {
            f.write_str(name)
        } else if self.is_one_build() {
            self.first.fmt(f)
        } else {
            write!(f, "{} to {}", self.first, self.last)
        }
    }
}

impl fmt::Debug for Profile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl FromStr for Profile {
    type Err = ProfileError;

    fn from_str(text: &str) -> Result<Self, ProfileError> {
        if let Some((_, profile)) = NAMES.iter().find(|(name, _)| *name == text) {
            return Ok(*profile);
        }
        let (first, last) = text.split_once(" to ").unwrap_or((text, text));
        let (first, last) = (Age::parse(first).ok_or(ProfileError)?, Age::parse(last).ok_or(ProfileError)?);
        if first.is_at_most(last) { Ok(Self { first, last }) } else { Err(ProfileError) }
    }
}

impl RunState {
    /// Whether the program runs, or waits for its start; `None` if it is not known.
    ///
    /// Firmware before 2014-12-03 answers 0 both for stopped and for paused.
    #[must_use]
    pub fn is_running(self, profile: Profile) -> Option<bool> {
        match self {
            Self::STOPPED => Some(false),
            Self::RUNNING_OR_PAUSED => profile.one_is_paused().map(|paused| !paused),
            Self::RUNNING | Self::DELAY | Self::STILL_SHOOTING | Self::PING_PONG => Some(true),
            _ => None,
        }
    }
}

impl StartDelay {
    /// Delay in milliseconds; `None` if the unit of the firmware is not known.
    #[must_use]
    pub fn milliseconds(self, profile: Profile) -> Option<u64> {
        let delay = u64::from(self.0);
        match profile.start_delay()? {
            DelayUnit::Seconds => Some(delay.wrapping_mul(1000)),
            DelayUnit::Milliseconds => Some(delay),
        }
    }
}
