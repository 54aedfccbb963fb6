//! What a simulated node is.

use hoot_proto::device::{self, Quirks};
use hoot_proto::query::Profile;
use motion_core::profile::Limits;
use motion_core::trajectory::Range;

/// What a simulated node is, from the start on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// Its address, name, firmware and habits.
    pub options: device::Options,
    /// How many motors are plugged in, from motor 1 on: at most 3. A node knows three; one that is not there fails as
    /// soon as it is to move.
    pub motors: u8,
    /// What each motor can do, in microsteps a second, at quarter steps, which a new node has.
    pub limits: Limits,
    /// Where the rig ends, in microsteps from where the motors are at first, at quarter steps. A motor that gets there
    /// stops dead, and fails.
    pub travel: Range,
}

/// Why a text names no quirks.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is no quirk: there are none, firmware, {list}", list = names())]
pub struct QuirkError(String);

/// Habits of firmware, with their names in texts.
const QUIRKS: [(&str, Quirks); 5] = [
    ("refuses-stop", Quirks::REFUSES_STOP),
    ("drops-top-byte", Quirks::DROPS_TOP_BYTE),
    ("short-moves", Quirks::SHORT_MOVES),
    ("answers-twice", Quirks::ANSWERS_TWICE),
    ("deaf", Quirks::IS_DEAF),
];

/// Firmware as texts name it.
const PROFILES: [(&str, Profile); 6] = [
    ("library-2014-09-25", Profile::Library20140925),
    ("sheet", Profile::Sheet),
    ("january-2015", Profile::January2015),
    ("v0.33", Profile::V033),
    ("v0.35", Profile::V035),
    ("v0.70", Profile::V070),
];

fn names() -> String {
    let names: Vec<_> = QUIRKS.iter().map(|(name, _)| *name).chain(PROFILES.iter().map(|(name, _)| *name)).collect();
    names.join(", ")
}

impl Default for Setup {
    /// A new node with three motors on rigs of 50,000 steps each way.
    fn default() -> Self {
        Self {
            options: device::Options::default(),
            motors: 3,
            limits: Limits { velocity: 5000.0, acceleration: 20_000.0, jerk: None },
            travel: Range::new(-200_000.0, 200_000.0),
        }
    }
}

impl Setup {
    /// A node with so many motors, at most 3.
    #[must_use]
    pub fn with_motors(count: u8) -> Self {
        Self { motors: count.min(3), ..Self::default() }
    }

    /// The same with other options of the device machine.
    #[must_use]
    pub const fn with_options(self, options: device::Options) -> Self {
        Self { options, ..self }
    }

    /// The same with other ends.
    #[must_use]
    pub const fn with_travel(self, travel: Range) -> Self {
        Self { travel, ..self }
    }

    /// The same with the habits of firmware that a text names: `none`, `firmware` for all that firmware of the sheet's
    /// date has, or a list such as `v0.33,answers-twice` of versions and habits.
    ///
    /// # Errors
    ///
    /// [`QuirkError`] says what is not known, and what there is.
    pub fn with_quirks(self, text: &str) -> Result<Self, QuirkError> {
        let mut quirks = Quirks::NONE;
        let mut options = self.options;
        for name in text.split(',').map(str::trim) {
            if let Some((_, quirk)) = QUIRKS.iter().find(|(of, _)| *of == name) {
                quirks |= *quirk;
            } else if let Some((_, profile)) = PROFILES.iter().find(|(of, _)| *of == name) {
                options = options.with_profile(*profile);
            } else if name == "firmware" {
                quirks = Quirks::FIRMWARE;
            } else if name != "none" {
                return Err(QuirkError(name.to_owned()));
            }
        }
        Ok(Self { options: options.with_quirks(quirks), ..self })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_name_quirks() {
        let of = |text| Setup::default().with_quirks(text).map(|it| (it.options.quirks(), it.options.profile()));
        assert_eq!(of("none"), Ok((Quirks::NONE, Profile::Sheet)));
        assert_eq!(of("firmware, v0.70"), Ok((Quirks::FIRMWARE, Profile::V070)));
        let all = QUIRKS.map(|(name, _)| name).join(",");
        assert_eq!(of(&all), Ok((Quirks::FIRMWARE, Profile::Sheet)));
        assert_ne!(of("deaf"), of("none"));
        let error = of("deaf,loud").unwrap_err().to_string();
        assert!(error.starts_with("\"loud\" is no quirk: there are none, firmware, refuses-stop, "), "{error}");
    }
}
