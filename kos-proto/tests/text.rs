//! Values from text that people type.

use std::fmt::{Debug, Display};
use std::str::FromStr;

use kos_proto::ParseError;
use kos_proto::message::{FirmwareVersion, Ipv4, MacAddress, MotorAddress, Rotations, RotationsPerSecond, Seconds};
use proptest::prelude::*;

fn comes_back<T: Display + FromStr<Err = ParseError> + PartialEq + Debug>(value: T) {
    assert_eq!(value.to_string().parse::<T>().as_ref(), Ok(&value));
}

proptest! {
    #[test]
    fn what_is_printed_is_read_back(bytes: [u8; 4], mac: [u8; 6], number: f32) {
        comes_back(Ipv4(u32::from_be_bytes(bytes)));
        comes_back(MacAddress::from(mac));
        comes_back(FirmwareVersion(bytes));
        comes_back(MotorAddress(bytes[0]));
        if number.is_finite() {
            comes_back(Rotations(number));
            comes_back(RotationsPerSecond(number));
            comes_back(Seconds(number));
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
    assert_eq!(
        refused("two".parse::<MotorAddress>().unwrap_err()),
        "MotorAddress: byte 0 does not fit: write a number from 1 to 10, or 0 for all motors"
    );
}
