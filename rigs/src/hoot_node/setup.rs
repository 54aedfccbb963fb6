//! Setup of a simulated node.

use hoot_proto::device::{self, Quirks};
use hoot_proto::query::Profile;
use motion_core::profile::Limits;
use motion_core::trajectory::Range;

/// Setup of a simulated node, from the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// Options of the machine: address, name, firmware and quirks.
    pub options: device::Options,
    /// Number of motors that are plugged in, from motor 1 on: at most 3. A node has three motors; one that is not plugged
    /// in fails when it has to move.
    pub motors: u8,
    /// Limits of each motor, in microsteps per second, at quarter steps, which are the setting of a new node.
    pub limits: Limits,
    /// Ends of the rig, in microsteps from the first position of the motors, at quarter steps. A motor that reaches an end
    /// stops at once, and fails.
    pub travel: Range,
}

/// Error in a text that should name quirks.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is not a quirk: give none, firmware, {list}", list = names())]
pub struct QuirkError(String);

/// Habits of firmware, with their names in texts.
const QUIRKS: [(&str, Quirks); 5] = [
    ("refuses-stop", Quirks::REFUSES_STOP),
    ("drops-top-byte", Quirks::DROPS_TOP_BYTE),
    ("short-moves", Quirks::SHORT_MOVES),
    ("answers-twice", Quirks::ANSWERS_TWICE),
    ("deaf", Quirks::IS_DEAF),
];

/// Versions of firmware, with their names in texts.
const PROFILES: [(&str, Profile); 6] = [
    ("library-2014-09-25", Profile::LIBRARY_2014_09_25),
    ("sheet", Profile::SHEET),
    ("january-2015", Profile::JANUARY_2015),
    ("v0.33", Profile::V033),
    ("v0.35", Profile::V035),
    ("v0.70", Profile::V070),
];

fn names() -> String {
    let names: Vec<_> = QUIRKS.iter().map(|(name, _)| *name).chain(PROFILES.iter().map(|(name, _)| *name)).collect();
    names.join(", ")
}

impl Default for Setup {
    /// A new node with three motors, which can move by 50,000 steps in each direction.
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
    /// A node with this number of motors, at most 3.
    #[must_use]
    pub fn with_motors(count: u8) -> Self {
        Self { motors: count.min(3), ..Self::default() }
    }

    /// Returns the setup with other options of the machine.
    #[must_use]
    pub const fn with_options(self, options: device::Options) -> Self {
        Self { options, ..self }
    }

    /// Returns the setup with other ends of the rig.
    #[must_use]
    pub const fn with_travel(self, travel: Range) -> Self {
        Self { travel, ..self }
    }

    /// Returns the setup with the quirks that a text names: `none`, `firmware` for all quirks of firmware of the sheet's
    /// date, or a list of versions and quirks, such as `v0.33,answers-twice`.
    ///
    /// # Errors
    ///
    /// [`QuirkError`] names the unknown quirk, and lists all quirks.
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
        assert_eq!(of("none"), Ok((Quirks::NONE, Profile::SHEET)));
        assert_eq!(of("firmware, v0.70"), Ok((Quirks::FIRMWARE, Profile::V070)));
        let all = QUIRKS.map(|(name, _)| name).join(",");
        assert_eq!(of(&all), Ok((Quirks::FIRMWARE, Profile::SHEET)));
        assert_ne!(of("deaf"), of("none"));
        let error = of("deaf,loud").unwrap_err().to_string();
        assert!(error.starts_with("\"loud\" is not a quirk: give none, firmware, refuses-stop, "), "{error}");
    }
}
