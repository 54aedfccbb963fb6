//! Devices and quirks of hoot by name.

use hoot_proto::device::Quirks;
use hoot_proto::query::Profile;

use super::Setup;
use crate::device::{Choice, Named};

impl Named for Setup {
    const PROTOCOL: &'static str = "hoot";

    const DEVICES: &'static [Choice<Self>] = &[
        Choice {
            name: "mild",
            about: "As the published sheet means it.",
            apply: |setup| setup.become_device(Profile::Sheet, Quirks::NONE),
        },
        Choice {
            name: "library-2014-09-25",
            about: "Library of that day.",
            apply: |setup| setup.become_device(Profile::Library20140925, Quirks::FIRMWARE),
        },
        Choice {
            name: "sheet",
            about: "Firmware of the published sheet.",
            apply: |setup| setup.become_device(Profile::Sheet, Quirks::FIRMWARE),
        },
        Choice {
            name: "january-2015",
            about: "First firmware of January 2015.",
            apply: |setup| setup.become_device(Profile::January2015, Quirks::FIRMWARE),
        },
        Choice {
            name: "v0.33",
            about: "Version 0.33.",
            apply: |setup| setup.become_device(Profile::V033, Quirks::FIRMWARE),
        },
        Choice {
            name: "v0.35",
            about: "Version 0.35.",
            apply: |setup| setup.become_device(Profile::V035, Quirks::FIRMWARE),
        },
        Choice {
            name: "v0.70",
            about: "Version 0.70, the last one.",
            apply: |setup| setup.become_device(Profile::V070, Quirks::FIRMWARE),
        },
    ];

    const QUIRKS: &'static [Choice<Self>] = &[
        Choice {
            name: "refuses-stop",
            about: "Joystick mode refuses the stop of the controller.",
            apply: |setup| setup.add(Quirks::REFUSES_STOP),
        },
        Choice {
            name: "drops-top-byte",
            about: "Unsigned numbers of 32 bits lose their top byte.",
            apply: |setup| setup.add(Quirks::DROPS_TOP_BYTE),
        },
        Choice {
            name: "short-moves",
            about: "The missing bytes of a move count as zeros, which is a run without end.",
            apply: |setup| setup.add(Quirks::SHORT_MOVES),
        },
        Choice {
            name: "answers-twice",
            about: "Some requests are answered twice.",
            apply: |setup| setup.add(Quirks::ANSWERS_TWICE),
        },
        Choice {
            name: "deaf",
            about: "Nothing is received for 2.5 s after a change of the address.",
            apply: |setup| setup.add(Quirks::IS_DEAF),
        },
        Choice {
            name: "firmware",
            about: "All quirks of firmware of the sheet's date.",
            apply: |setup| setup.add(Quirks::FIRMWARE),
        },
    ];
}

impl Setup {
    fn become_device(&mut self, profile: Profile, quirks: Quirks) {
        self.options = self.options.with_profile(profile).with_quirks(quirks);
    }

    fn add(&mut self, quirks: Quirks) {
        self.options = self.options.with_quirks(self.options.quirks() | quirks);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_choose_firmware_and_quirks() {
        let of = |device, quirks| {
            let setup = Setup::default().with_device(device).unwrap().with_quirks(quirks).unwrap();
            (setup.options.profile(), setup.options.quirks())
        };
        assert_eq!(of("mild", ""), (Profile::Sheet, Quirks::NONE));
        assert_eq!(of("mild", "deaf"), (Profile::Sheet, Quirks::IS_DEAF));
        assert_eq!(of("v0.70", ""), (Profile::V070, Quirks::FIRMWARE));
        let names: Vec<_> = Setup::QUIRKS.iter().map(|choice| choice.name).collect();
        assert_eq!(of("mild", &names.join(",")).1, Quirks::FIRMWARE);
        let error = Setup::default().with_quirks("deaf,loud").unwrap_err().to_string();
        assert!(error.starts_with("hoot has no quirk \"loud\": it has refuses-stop, "), "{error}");
    }
}
