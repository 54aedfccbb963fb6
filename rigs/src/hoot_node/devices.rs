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
            assert!(known, "{}", $name);
        })
    };
}

impl Named for Setup {
    const PROTOCOL: &'static str = "hoot";

    const DEVICES: &'static [Choice<Self>] = &[
        Choice::new(
            "mild",
            "Node as the published sheet describes it, without the habits of real firmware.",
            |setup| {
                setup.become_device(Profile::SHEET, Quirks::NONE);
            },
        ),
        device!("sheet", "Firmware of 2014-10-28, the day of the published sheet, with all its habits."),
        device!("2014-10-15", "Firmware without joystick mode, the first binary."),
        device!("2014-10-29", "Firmware that answers yes and no in bytes, and each query once."),
        device!("2014-11-03", "Firmware that sends motors at full speed, and moves them by joystick."),
        device!("2014-11-05", "Firmware that answers the lead-in in 32 bits."),
        device!("2014-12-03", "Firmware whose run status 1 means paused, and that keeps the run time."),
        device!("2014-12-22", "Firmware that does not answer unknown commands."),
        device!("v0.20", "Firmware that a start blocks for 1.5 s, and whose version is a long number."),
        device!("v0.25", "Firmware with the lead-out in the place of single steps."),
        device!("v0.33", "Firmware that sends hundredths as whole numbers."),
        device!("v0.35", "Firmware that takes the lead-in in 32 bits."),
        device!("v0.41", "Firmware that takes the delay before the start in milliseconds."),
        device!("v0.45", "Firmware that enables its motors when it is switched on."),
        device!("v0.49", "Firmware whose end limits stop nothing."),
        device!("v0.58", "Firmware that answers all queries in joystick mode."),
        device!("v0.70", "Firmware of the last version of the vendor."),
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
        Choice::new(
            "exposes-always",
            "A picture on command needs no camera, and has no focus; older firmware takes none.",
            |setup| {
                setup.add(Quirks::EXPOSES_ALWAYS);
            },
        ),
        Choice::new("never-resumes", "Motors do not go on after a pause in the modes without stops.", |setup| {
            setup.add(Quirks::NEVER_RESUMES);
        }),
        Choice::new("takes-up-backlash", "A motor takes up its backlash at each change of direction.", |setup| {
            setup.add(Quirks::TAKES_UP_BACKLASH);
        }),
        Choice::new(
            "firmware-photos",
            "Programs take photos that nobody asked for, and a time lapse ends with its motors.",
            |setup| setup.add(Quirks::FIRMWARE_PHOTOS),
        ),
        Choice::new(
            "moves-all",
            "A program without stops sends also the motors whose planned move has no travel, or never ends.",
            |setup| setup.add(Quirks::MOVES_ALL),
        ),
        Choice::new("firmware", "All quirks of firmware of the sheet's date.", |setup| setup.add(Quirks::FIRMWARE)),
    ];

    const FAMILIES: &'static [(Kind, &'static str, &'static str)] = &[
        (Kind::Device, "YYYY-MM-DD", "Firmware with the libraries of a day, from 2014-09-24 to 2015-01-08."),
        (Kind::Device, "v0.NN", "Firmware of a version, from v0.20 to v0.70."),
    ];

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
