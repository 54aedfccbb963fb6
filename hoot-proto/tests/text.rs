//! Values from text that people type.

use hoot_proto::Address;
use hoot_proto::message::{Motor, Scaled, Steps, StepsPerSecond, Volts};
#[cfg(feature = "serde")]
use hoot_proto::message::{MotorPosition, Reply, ResponseCode};
#[cfg(feature = "serde")]
use hoot_proto::{HostMessage, Query};
use proptest::prelude::*;

proptest! {
    #[test]
    fn what_is_printed_is_read_back(number: i32, address: u8) {
        prop_assert_eq!(Steps(number).to_string().parse(), Ok(Steps(number)));
        prop_assert_eq!(Volts(Scaled(number)).to_string().parse(), Ok(Volts(Scaled(number))));
        prop_assert_eq!(Address(address).to_string().parse(), Ok(Address(address)));
    }
}

#[test]
fn every_motor_is_read_back_and_no_other_number_is_a_motor() {
    for motor in Motor::ALL {
        assert_eq!(motor.to_string().parse(), Ok(motor));
    }
    for (text, at) in [("4", 0), ("", 0), ("x", 0), ("12", 1), ("3 ", 1)] {
        let expected = format!("Motor: byte {at} does not fit: write 1, 2 or 3");
        assert_eq!(text.parse::<Motor>().unwrap_err().to_string(), expected);
    }
    assert!("1 000".parse::<StepsPerSecond>().is_err());
}

#[test]
#[cfg(feature = "serde")]
fn a_reply_is_written_with_the_name_of_its_query_and_its_raw_value() {
    let query = HostMessage::from(MotorPosition { motor: Motor::Two }).query().unwrap();
    let reply = query.decode_reply(Reply { code: ResponseCode::OK, data: &[3, 0xFF, 0xFF, 0xCF, 0xC7] }).unwrap();
    assert_eq!(serde_json::to_string(&reply).unwrap(), r#"{"query":"MotorPosition","value_type":3,"value":-12345}"#);
}
