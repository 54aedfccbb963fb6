//! Values from text that people type.

use std::fmt::{Debug, Display};
use std::str::FromStr;

use kos_proto::ParseError;
use kos_proto::message::{FirmwareVersion, Ipv4, MacAddress, MotorAddress, Rotations, RotationsPerSecond, Seconds};
use kos_proto::trajectory::bezier::{Ease, Key, Segment};
use motion_core::serde::Serialize;
use motion_core::serde::de::DeserializeOwned;
use proptest::prelude::*;

fn comes_back<T: Display + FromStr<Err = ParseError> + PartialEq + Debug>(value: &T) {
    assert_eq!(value.to_string().parse::<T>().as_ref(), Ok(value));
}

proptest! {
    #[test]
    fn what_is_printed_is_read_back(bytes: [u8; 4], mac: [u8; 6], number: f32) {
        comes_back(&Ipv4(u32::from_be_bytes(bytes)));
        comes_back(&MacAddress::from(mac));
        comes_back(&FirmwareVersion(bytes));
        comes_back(&MotorAddress(bytes[0]));
        if number.is_finite() {
            comes_back(&Rotations(number));
            comes_back(&RotationsPerSecond(number));
            comes_back(&Seconds(number));
        }
    }

    #[test]
    fn no_text_panics(text in "[0-9a-fIZ.: +-]{0,24}") {
        let _ = (text.parse::<Ipv4>(), text.parse::<MacAddress>(), text.parse::<FirmwareVersion>());
        let _ = (text.parse::<MotorAddress>(), text.parse::<Rotations>());
    }
}

#[test]
fn an_error_says_what_was_read_and_where_it_ends() {
    let refused = |error: ParseError| error.to_string();
    assert_eq!(
        refused("192.168.50.300".parse::<Ipv4>().unwrap_err()),
        "Ipv4: byte 13 does not fit: write four numbers such as 192.168.50.1"
    );
    assert_eq!(
        refused("2,5".parse::<Rotations>().unwrap_err()),
        "Rotations: no sign, digit or decimal point at byte 1"
    );
    assert_eq!(refused("NaN".parse::<Seconds>().unwrap_err()), "Seconds: no sign, digit or decimal point at byte 0");
    for (text, at) in [("two", 0), ("", 0), ("2x", 1), ("2 F", 1), ("128", 2), ("1280 FIZ", 3)] {
        let expected = format!(
            "MotorAddress: byte {at} does not fit: write a number from 0 to 127, such as 2 or 2 FIZ; motors have 1 to 10, and 0 \
             is for all motors"
        );
        assert_eq!(refused(text.parse::<MotorAddress>().unwrap_err()), expected);
    }
}

/// The value after it was written as JSON, and the JSON.
fn through_json<T: Serialize + DeserializeOwned>(value: &T) -> (T, String) {
    let json = serde_json::to_string(value).unwrap();
    (serde_json::from_str(&json).unwrap(), json)
}

#[test]
fn values_are_written_and_read_as_their_raw_values() {
    assert_eq!(through_json(&Rotations(0.1)), (Rotations(0.1), "0.10000000149011612".to_owned()));
    assert_eq!(through_json(&Rotations(f32::NAN)), (Rotations(f32::NAN), "\"0x7fc00000\"".to_owned()));
    let address = MacAddress::from([0, 27, 197, 9, 0, 255]);
    assert_eq!(through_json(&address), (address, "\"001bc50900ff\"".to_owned()));
    for wrong in ["\"001bc50900\"", "\"001bc50900fg\"", "\"001bc50900+f\"", "12"] {
        assert!(serde_json::from_str::<MacAddress>(wrong).is_err(), "{wrong}");
    }
    assert_eq!(serde_json::from_str::<Rotations>("2").unwrap(), Rotations(2.0));
    // Bits are read only of numbers that are written so.
    for wrong in ["1e39", "\"0x3f800000\"", "\"0x7fc\"", "\"0x+fc00000\""] {
        assert!(serde_json::from_str::<Rotations>(wrong).is_err(), "{wrong}");
    }
}

#[test]
#[cfg(feature = "serde")]
fn a_move_is_written_and_read_back() {
    use kos_proto::message::{MotorSet, Normalized};
    use kos_proto::trajectory::{Delay, LiveMotion, Loop, Play, Times};

    let play = Play::Live(LiveMotion {
        duration: Seconds(8.0),
        repeat: Loop::Reverse(Times::new(3).unwrap()),
        delay: Delay::For(Seconds(2.5)),
        home_speed: Normalized(0.25),
    });
    let json = r#"{"live":{"duration":8.0,"repeat":{"reverse":3},"delay":{"for":2.5},"home_speed":0.25}}"#;
    assert_eq!(through_json(&play), (play, json.to_owned()));
    assert!(serde_json::from_str::<Play>(&json.replace(":3}", ":0}")).is_err(), "no loop has 0 times");

    let motors = MotorSet::of([MotorAddress(2), MotorAddress(10)]);
    assert_eq!(through_json(&motors), (motors, "[2,10]".to_owned()));
    assert!(serde_json::from_str::<MotorSet>("[2,11]").is_err());
}

#[test]
fn a_curve_is_written_as_its_points_and_read_back() {
    let key = |time, position| Key { time, position, arrive: Ease::Flat(0.4), leave: Ease::Linear };
    let (from, to) = (key(0.0, 0.0), key(3.0, 1.5));
    let segment = Segment::between(&from, &to).unwrap();
    let (read, json) = through_json(&segment);
    assert_eq!(read, segment);
    assert!(json.starts_with(r#"[{"time":0.0,"position":0.0},{"time":1.0,"position":0.5},"#), "{json}");
    assert!(serde_json::from_str::<Segment>(&json.replace("3.0", "1e76")).is_err(), "no coordinate is above 1e75");
    let (read, json) = through_json(&from);
    assert_eq!(read, from);
    assert_eq!(json, r#"{"time":0.0,"position":0.0,"arrive":{"flat":0.4},"leave":"linear"}"#);
}
