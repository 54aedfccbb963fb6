//! Conduct of every message from a client, stated a second time, from what the specification and the safety decisions say.

use kos_proto::HostMessage;
use kos_proto::message::*;
use kos_proto::{Conduct, Purpose};
use motion_core::wire::Messages;

/// Rows of the table by what their messages do. Questions change nothing and may be asked again.
const ASKS: [&str; 7] = [
    "GetNetworkInfo",
    "GetLEDStatus",
    "GetMotorInfo",
    "GetDeviceInfo",
    "GetTrajectoryData",
    "GetDeviceGUID",
    "GetSoftwareID",
];
/// Settings that mean the same when they are sent twice.
const SETS: [&str; 4] = ["KeepAlive", "SetLEDStatus", "SetUserPassword", "SetSoftwareID"];
/// Settings that do not: a password that locks the session, ranges that depend on where motors are, a second photo.
const SETS_ONCE: [&str; 5] = ["SetDevicePassword", "ResetAxis", "MarkBeginPosition", "MarkEndPosition", "TakePicture"];
/// A move is stored, and its motors are sent to where it begins.
const ARMS_ONCE: [&str; 2] = ["SetTrajectoryData", "SetupPlayback"];
/// Motors move.
const MOVES_ONCE: [&str; 2] = ["StartPlayback", "RapidToFirstKeyFrame"];
/// Everything stops (safety decision 2).
const STOPS: [&str; 1] = ["StopPlayback"];
/// The device starts anew.
const RESETS_ONCE: [&str; 1] = ["ResetDevice"];
/// Speed 0 stops, any other speed moves (safety decisions 1 and 3).
const BY_SPEED: [&str; 2] = ["SetPositionSpeedAcceleration", "BumpPositionSpeedAcceleration"];

fn stated(name: &str) -> Option<Conduct> {
    let groups: [(&[&str], Conduct); 7] = [
        (&ASKS, Conduct::new(Purpose::Asks)),
        (&SETS, Conduct::new(Purpose::Sets)),
        (&SETS_ONCE, Conduct::new(Purpose::Sets).once()),
        (&ARMS_ONCE, Conduct::new(Purpose::Arms).once()),
        (&MOVES_ONCE, Conduct::new(Purpose::Moves).once()),
        (&STOPS, Conduct::new(Purpose::Stops)),
        (&RESETS_ONCE, Conduct::new(Purpose::Resets).once()),
    ];
    groups.into_iter().find_map(|(names, conduct)| names.contains(&name).then_some(conduct))
}

#[test]
fn every_row_has_the_conduct_that_is_stated_here() {
    for kind in HostMessage::ALL {
        assert_eq!(kind.conduct.is_none(), BY_SPEED.contains(&kind.name), "{}", kind.name);
        assert_eq!(kind.conduct, stated(kind.name), "{}", kind.name);
    }
    let stated = [&ASKS[..], &SETS, &SETS_ONCE, &ARMS_ONCE, &MOVES_ONCE, &STOPS, &RESETS_ONCE, &BY_SPEED].concat();
    assert_eq!(stated.len(), HostMessage::ALL.len(), "no row is missing here");
}

#[test]
fn the_messages_of_a_row_have_its_conduct() {
    for kind in HostMessage::ALL {
        let message = (0..60).find_map(|len| HostMessage::decode_body(kind.number, &[0; 60][..len]).ok());
        let message = message.unwrap_or_else(|| panic!("{} is never decoded", kind.name));
        // All their numbers are 0, and so is the speed.
        let conduct = kind.conduct.unwrap_or(Conduct::new(Purpose::Stops));
        assert_eq!((message.name(), message.conduct()), (kind.name, conduct));
    }
    let unknown = HostMessage::other(0x0080_0063, &[]);
    assert_eq!((unknown.conduct(), unknown.conduct().may_move()), (Conduct::UNKNOWN, true));
}

#[test]
fn the_speed_decides_whether_a_motor_moves_or_stops() {
    let (motor_address, acceleration) = (MotorAddress(1), RotationsPerSecondSquared(1.0));
    for (speed, stops) in [(0.0, true), (-0.0, true), (1.0, false), (-1.0, false), (f32::NAN, false), (1e-45, false)] {
        let (speed, distance) = (RotationsPerSecond(speed), Rotations(3.0));
        let set = SetPositionSpeedAcceleration { motor_address, position: distance, speed, acceleration, tail: &[] };
        let bump = BumpPositionSpeedAcceleration { motor_address, delta: distance, speed, acceleration, tail: &[] };
        assert_eq!((set.is_stop(), bump.is_stop()), (stops, stops));
        for message in [HostMessage::from(set), bump.into()] {
            let conduct = message.conduct();
            assert_eq!(
                (conduct.is_stop(), conduct.may_move(), conduct.repeatable),
                (stops, !stops, stops),
                "{message}"
            );
        }
    }
}
