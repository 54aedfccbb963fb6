//! Devices and quirks of hoot by name.

use hoot_proto::device::Quirks;
use hoot_proto::query::Profile;

use super::Setup;
use crate::device::{Choice, Kind, Named};

/// Firmware with all its habits. Its name is the name of its age.
macro_rules! device {
    ($name:literal, $about:literal) => {
        Choice::new($name, $about, |setup| {
            let known = setup.apply_other(Kind::Device, $name);
            debug_assert!(known, "{}", $name);
        })
    };
}

impl Named for Setup {
    const PROTOCOL: &'static str = "hoot";

    const DEVICES: &'static [Choice<Self>] = &[
        Choice::new("mild", "As the published sheet means it.", |setup| {
            setup.become_device(Profile::SHEET, Quirks::NONE);
        }),
        device!("sheet", "Firmware of the published sheet, of 2014-10-28."),
        device!("2014-10-15", "First binary: without joystick mode."),
        device!("2014-10-29", "Bytes for yes and no, one answer to each query."),
        device!("2014-11-03", "Sends go at full speed, and a joystick moves."),
        device!("2014-11-05", "The lead-in is read back in 32 bits."),
        device!("2014-12-03", "Run status 1 means paused, the run time stays."),
        device!("2014-12-22", "Silent about unknown commands."),
        device!("v0.20", "A start blocks for 1.5 s, and the version is a long number."),
        device!("v0.25", "Lead-out in the place of single steps."),
        device!("v0.33", "Hundredths that are right."),
        device!("v0.35", "A lead-in in 32 bits."),
        device!("v0.41", "The delay before the start in milliseconds."),
        device!("v0.45", "Motors that are enabled from the start."),
        device!("v0.49", "Limits that hold nothing."),
        device!("v0.58", "Joystick mode that allows all queries."),
        device!("v0.70", "The last version of the vendor's branch."),
    ];

    const QUIRKS: &'static [Choice<Self>] = &[
        Choice::new("refuses-stop", "Joystick mode refuses the stop of the controller.", |setup| {
            setup.add(Quirks::REFUSES_STOP);
        }),
        Choice::new("drops-top-byte", "Unsigned numbers of 32 bits lose their top byte.", |setup| {
            setup.add(Quirks::DROPS_TOP_BYTE);
        }),
        Choice::new(
            "short-moves",
            "The missing bytes of a move count as zeros, which is a run without end.",
            |setup| setup.add(Quirks::SHORT_MOVES),
        ),
        Choice::new("answers-twice", "Some requests are answered twice.", |setup| setup.add(Quirks::ANSWERS_TWICE)),
        Choice::new(
            "blocks",
            "Start and a change of the address block for up to 2.5 s; two packets that wait then hang the node.",
            |setup| setup.add(Quirks::BLOCKS),
        ),
        Choice::new("firmware-settings", "The settings of firmware, read back as firmware does.", |setup| {
            setup.add(Quirks::FIRMWARE_SETTINGS);
        }),
        Choice::new(
            "sends-fast",
            "Commands 11, 12, 23 and 24 of a motor go at full speed, and forget the speed that was set.",
            |setup| setup.add(Quirks::SENDS_FAST),
        ),
        Choice::new(
            "firmware-limits",
            "The end limit makes a limit of the home too, and later stops nothing.",
            |setup| setup.add(Quirks::FIRMWARE_LIMITS),
        ),
        Choice::new("joystick-moves", "In joystick mode the speed of runs sets motors in motion.", |setup| {
            setup.add(Quirks::JOYSTICK_MOVES);
        }),
        Choice::new("changes-microsteps", "Sends and starts change the microsteps.", |setup| {
            setup.add(Quirks::CHANGES_MICROSTEPS);
        }),
        Choice::new(
            "firmware-directions",
            "Neither the setting of the direction nor a negative speed inverts a run.",
            |setup| setup.add(Quirks::FIRMWARE_DIRECTIONS),
        ),
        Choice::new("exposes-always", "A picture on command needs no camera, and has no focus.", |setup| {
            setup.add(Quirks::EXPOSES_ALWAYS);
        }),
        Choice::new("never-resumes", "Motors do not go on after a pause in the modes without stops.", |setup| {
            setup.add(Quirks::NEVER_RESUMES);
        }),
        Choice::new("firmware", "All quirks of firmware of the sheet's date.", |setup| setup.add(Quirks::FIRMWARE)),
    ];

    /// A node can be any build from 2014-10-15 to 2015-01-08, and any version from v0.20 to v0.70.
    fn apply_other(&mut self, kind: Kind, name: &str) -> bool {
        let age = name.parse().ok().filter(|age: &Profile| age.is_one_build());
        let Some(age) = age.filter(|_| kind == Kind::Device) else { return false };
        self.become_device(age, Quirks::FIRMWARE);
        true
    }
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
        assert_eq!(of("mild", ""), (Profile::SHEET, Quirks::NONE));
        assert_eq!(of("mild", "blocks"), (Profile::SHEET, Quirks::BLOCKS));
        assert_eq!(of("v0.70", ""), (Profile::V070, Quirks::FIRMWARE));
        let single = Setup::QUIRKS.iter().filter(|choice| choice.name != "firmware");
        let names: Vec<_> = single.map(|choice| choice.name).collect();
        assert_eq!(of("mild", &names.join(",")).1, Quirks::FIRMWARE);
        let error = Setup::default().with_quirks("blocks,loud").unwrap_err().to_string();
        assert!(error.starts_with("hoot has no quirk \"loud\": it has refuses-stop, "), "{error}");
    }
}
