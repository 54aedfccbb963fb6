//! Devices and quirks of kOS by name.

use kos_proto::device::{Actions, MotorSpecs, Options, Quirks};
use kos_proto::message::{ActionId, FirmwareVersion, RotationsPerSecond, RotationsPerSecondSquared};

use super::{MotorSetup, Setup};
use crate::device::{Choice, Kind, Named};

impl Named for Setup {
    const PROTOCOL: &'static str = "kOS";

    const DEVICES: &'static [Choice<Self>] = &[
        Choice::new("mild", "Device as the document means it.", mild),
        Choice::new(
            "printed",
            "Device that follows the document to the letter: it always asks for a password, and ignores stops without it.",
            |setup| {
                mild(setup);
                setup.nul_terminated = true;
                setup.motors.iter_mut().for_each(|motor| motor.specs = printed(motor.specs));
                setup.add(Quirks::LOCKED_IGNORES_STOPS | Quirks::REQUIRE_EMPTY_PASSWORD);
            },
        ),
        Choice::new(
            "cinedrive",
            "Device of the older generation: without bumps, photo counts and ranges that begin elsewhere.",
            |setup| {
                mild(setup);
                setup.older_dialect = true;
                setup.add(Quirks::NO_SOFTWARE_ID);
                setup.forget(ActionId::BUMP_POSITION_SPEED_ACCELERATION);
            },
        ),
        Choice::new("1.0.1.5", "Firmware 1.0.1.5: ranges that do not begin at 0.", |setup| {
            mild(setup);
            setup.firmware = FirmwareVersion([1, 0, 1, 5]);
            setup.add(Quirks::BEGIN_NONZERO);
        }),
    ];

    const QUIRKS: &'static [Choice<Self>] = &[
        Choice::new("older-dialect", "The device speaks the older dialect.", |setup| setup.older_dialect = true),
        Choice::new("begin-nonzero", "The count of positions stays when a range is marked.", |setup| {
            setup.add(Quirks::BEGIN_NONZERO);
        }),
        Choice::new("empty-password", "A client has to send the password, although it is empty.", |setup| {
            setup.add(Quirks::REQUIRE_EMPTY_PASSWORD);
        }),
        Choice::new("stop-when-alone", "A move is stopped when the last client is gone.", |setup| {
            setup.options = setup.options.with_stop_when_alone(true);
        }),
        Choice::new("push-address", "The address is sent over TCP every five seconds.", |setup| {
            setup.options = setup.options.with_push_every(Some(5000));
        }),
        Choice::new("no-progress", "The progress of a live move is not reported.", |setup| {
            setup.options = setup.options.with_progress_every(None);
        }),
        Choice::new(
            "locked-ignores-all",
            "A locked client is ignored, stops included, until it sends the password.",
            |setup| setup.add(Quirks::LOCKED_IGNORES_STOPS),
        ),
        Choice::new(
            "ignores-direction",
            "A move is played forward, whatever the direction of the start says.",
            |setup| setup.add(Quirks::IGNORES_DIRECTION),
        ),
        Choice::new(
            "jog-not-clamped",
            "A motor is sent where the message says, also beyond the end of its range.",
            |setup| setup.add(Quirks::NOT_CLAMPED),
        ),
        Choice::new("no-bump", "The device does not know BumpPositionSpeedAcceleration.", |setup| {
            setup.forget(ActionId::BUMP_POSITION_SPEED_ACCELERATION);
        }),
        Choice::new("no-software-id", "The device does not know SoftwareID.", |setup| {
            setup.add(Quirks::NO_SOFTWARE_ID);
        }),
    ];

    const FAMILIES: &'static [(Kind, &'static str, &'static str)] = &[(
        Kind::Quirk,
        "unsupported=ACTION",
        "The device does not know the action with this number, such as 0x0f. Can be given several times.",
    )];

    fn apply_other(&mut self, kind: Kind, name: &str) -> bool {
        let action = name.strip_prefix("unsupported=").filter(|_| kind == Kind::Quirk);
        let number = action.and_then(|action| match action.strip_prefix("0x") {
            Some(digits) => u8::from_str_radix(digits, 16).ok(),
            None => action.parse().ok(),
        });
        let known = number.map(ActionId).filter(|&action| Actions::NONE.with(action) != Actions::NONE);
        known.map(|action| self.forget(action)).is_some()
    }
}

/// Takes everything back that a device or a quirk decides.
fn mild(setup: &mut Setup) {
    setup.motors.iter_mut().for_each(|motor| motor.specs = MotorSetup::new(motor.kind).specs);
    setup.options = Options::default();
    (setup.older_dialect, setup.nul_terminated, setup.firmware) = (false, false, Setup::FIRMWARE);
}

/// Motor with the limits that the document prints as an example.
const fn printed(specs: MotorSpecs) -> MotorSpecs {
    let speed = RotationsPerSecond(166.7);
    MotorSpecs {
        max_max_setup_speed: speed,
        max_max_move_speed: speed,
        max_max_acceleration: RotationsPerSecondSquared(200.0),
        ..specs
    }
}

#[cfg(test)]
mod tests {
    use super::super::KosDevice;
    use super::*;
    use kos_proto::message::AxisKind;

    /// A device name decides the limits of the motors of a setup. Limits that are set after it count.
    #[test]
    fn motors_have_the_limits_of_their_setup() {
        let mut setup = Setup::with_motors(2).with_device("printed").unwrap();
        assert!(setup.motors.iter().all(|motor| motor.specs.max_max_move_speed == RotationsPerSecond(166.7)));
        let tilt = MotorSetup::new(AxisKind::Tilt);
        setup.motors[1] = tilt;
        let device = KosDevice::new(setup.clone());
        assert_eq!(device.specs, [setup.motors[0].specs, tilt.specs]);
        let mild = setup.with_device("mild").unwrap();
        assert_eq!(mild.motors, [MotorSetup::new(AxisKind::Slider), tilt]);
    }

    #[test]
    fn each_quirk_has_a_name() {
        let names: Vec<_> = Setup::QUIRKS.iter().map(|choice| choice.name).collect();
        let all = Setup::default().with_quirks(&names.join(",")).unwrap();
        assert!(all.older_dialect && all.options.stop_when_alone());
        let quirks = Quirks::all().iter_names().fold(Quirks::empty(), |quirks, (_, quirk)| quirks | quirk);
        assert_eq!(all.options.quirks(), quirks);
        assert_eq!(all.options.unsupported(), Actions::NONE.with(ActionId::BUMP_POSITION_SPEED_ACCELERATION));
        let none = Setup::default().with_quirks("unsupported=0x0f,unsupported=9").unwrap();
        assert_eq!(
            none.options.unsupported(),
            Actions::NONE.with(ActionId::SETUP_PLAYBACK).with(ActionId::TAKE_PICTURE)
        );
        for wrong in ["unsupported=", "unsupported=64", "unsupported=-1", "unsupported=0xzz"] {
            assert!(Setup::default().with_quirks(wrong).is_err(), "{wrong}");
        }
        assert_eq!((all.options.push_every(), all.options.progress_every()), (Some(5000), None));
        let error = Setup::default().with_quirks("loud").unwrap_err().to_string();
        assert!(error.starts_with("kOS has no quirk \"loud\": it has older-dialect, "), "{error}");
        assert_eq!(Setup::with_motors(99).motors.len(), 10);
        for device in Setup::DEVICES {
            let setup = all.clone().with_device(device.name).unwrap();
            assert_eq!(setup, Setup::default().with_device(device.name).unwrap(), "{} decides all", device.name);
            assert_eq!(setup == Setup::default(), device.name == "mild");
        }
    }
}
