//! Age of one build of the firmware, and the text that names it.

use core::fmt;

/// Age of one build: a day until version 0.20 began, a version from then on. The order is that of time.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Age(u16);

/// Code of version 0.00. The codes of all days are smaller.
const VERSIONS: u16 = 1024;

impl Age {
    /// First day on which the firmware called itself version 6.
    pub(super) const FIRST: Self = Self::day(2014, 9, 24);
    /// Last version that can be named.
    pub(super) const LAST: Self = Self::version(70);
    const LAST_DAY: Self = Self::day(2015, 1, 8);
    const FIRST_VERSION: Self = Self::version(20);

    /// Build of the firmware and its libraries of a day.
    pub(super) const fn day(year: u16, month: u8, day: u8) -> Self {
        let months = year.saturating_sub(2014).saturating_mul(16).saturating_add(month as u16);
        Self(months.saturating_mul(32).saturating_add(day as u16))
    }

    /// Version, in hundredths.
    pub(super) const fn version(hundredths: u8) -> Self {
        Self(VERSIONS.saturating_add(hundredths as u16))
    }

    /// All builds, the oldest first.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        (Self::FIRST.0..=Self::LAST.0).map(Self).filter(|age| age.exists())
    }

    /// Age just before this one.
    pub(super) const fn before(self) -> Self {
        Self(self.0.saturating_sub(1))
    }

    /// Whether the build is as old as another one, or older.
    pub(super) const fn is_at_most(self, other: Self) -> bool {
        self.0 <= other.0
    }

    /// The version in hundredths, if the build is named by one.
    pub(super) const fn hundredths(self) -> Option<u16> {
        self.0.checked_sub(VERSIONS)
    }

    /// Whether there was such a build.
    pub(super) const fn exists(self) -> bool {
        let (month, day) = (self.0 / 32 % 16, self.0 % 32);
        let is_day = 1 <= month && month <= 12 && 1 <= day && !(day == 31 && (month == 9 || month == 11));
        Self::FIRST.0 <= self.0 && self.0 <= Self::LAST_DAY.0 && is_day
            || Self::FIRST_VERSION.0 <= self.0 && self.0 <= Self::LAST.0
    }

    /// Reads a day such as `2014-12-03`, or a version such as `v0.45`.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let number = |digits: &str, len: usize| {
            let is_plain = digits.len() == len && digits.bytes().all(|digit| digit.is_ascii_digit());
            if is_plain { digits.parse().ok() } else { None }
        };
        let age = if let Some(version) = text.strip_prefix("v0.") {
            Self::version(u8::try_from(number(version, 2)?).ok()?)
        } else {
            let mut parts = text.splitn(3, '-');
            let mut part = |len| number(parts.next()?, len);
            let (year, month, day): (u16, u16, u16) = (part(4)?, part(2)?, part(2)?);
            if !(2014..=2015).contains(&year) || month > 12 || day > 31 {
                return None;
            }
            Self::day(year, u8::try_from(month).ok()?, u8::try_from(day).ok()?)
        };
        Some(age).filter(|age| age.exists())
    }
}

impl fmt::Display for Age {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(version) = self.hundredths() {
            return write!(f, "v0.{version:02}");
        }
        let year = if self.0 < Self::day(2015, 0, 0).0 { 2014 } else { 2015 };
        write!(f, "{year}-{:02}-{:02}", self.0 / 32 % 16, self.0 % 32)
    }
}
