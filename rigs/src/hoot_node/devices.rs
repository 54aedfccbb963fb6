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

/// Habit of firmware.
macro_rules! quirk {
    ($name:literal, $quirk:ident, $about:literal) => {
        Choice::new($name, $about, |setup| setup.add(Quirks::$quirk))
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
        quirk!("refuses-stop", REFUSES_STOP, "Joystick mode refuses the stop of the controller."),
        quirk!("drops-top-byte", DROPS_TOP_BYTE, "Unsigned numbers of 32 bits lose their top byte."),
        quirk!("short-moves", SHORT_MOVES, "The missing bytes of a move count as zeros, which is a run without end."),
        quirk!("answers-twice", ANSWERS_TWICE, "Some requests are answered twice."),
        quirk!(
            "blocks",
            BLOCKS,
            "Start and a change of the address block for up to 2.5 s; two packets that wait then hang the node."
        ),
        quirk!("firmware-settings", FIRMWARE_SETTINGS, "The settings of firmware, read back as firmware does."),
        quirk!(
            "sends-fast",
            SENDS_FAST,
            "Commands 11, 12, 23 and 24 of a motor go at full speed, and forget the speed that was set."
        ),
        quirk!(
            "firmware-limits",
            FIRMWARE_LIMITS,
            "The end limit makes a limit of the home too, and later stops nothing."
        ),
        quirk!("joystick-moves", JOYSTICK_MOVES, "In joystick mode the speed of runs sets motors in motion."),
        quirk!("changes-microsteps", CHANGES_MICROSTEPS, "Sends and starts change the microsteps."),
        quirk!(
            "firmware-directions",
            FIRMWARE_DIRECTIONS,
            "Neither the setting of the direction nor a negative speed inverts a run."
        ),
        quirk!(
            "exposes-always",
            EXPOSES_ALWAYS,
            "A picture on command needs no camera, and has no focus; older firmware takes none."
        ),
        quirk!("never-resumes", NEVER_RESUMES, "Motors do not go on after a pause in the modes without stops."),
        quirk!("takes-up-backlash", TAKES_UP_BACKLASH, "A motor takes up its backlash at each change of direction."),
        quirk!(
            "firmware-photos",
            FIRMWARE_PHOTOS,
            "Programs take photos that nobody asked for, and a time lapse ends with its motors."
        ),
        quirk!(
            "moves-all",
            MOVES_ALL,
            "A program without stops sends also the motors whose planned move has no travel, or never ends."
        ),
        quirk!("firmware", FIRMWARE, "All quirks of firmware of the sheet's date."),
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
