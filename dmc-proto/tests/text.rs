//! Values from text that people type.

use dmc_proto::message::{AckCode, Degrees, FramesPerSecond, JogSpeed, Motor, Scaled, Steps};
use proptest::prelude::*;

proptest! {
    #[test]
    fn what_is_printed_is_read_back(steps: i32, rate: u32, speed: u16) {
        prop_assert_eq!(Steps(steps).to_string().parse(), Ok(Steps(steps)));
        prop_assert_eq!(FramesPerSecond(Scaled(rate)).to_string().parse(), Ok(FramesPerSecond(Scaled(rate))));
        prop_assert_eq!(JogSpeed(Scaled(speed)).to_string().parse(), Ok(JogSpeed(Scaled(speed))));
        prop_assert_eq!(Degrees(speed).to_string().parse(), Ok(Degrees(speed)));
    }
}

#[test]
fn an_error_says_what_was_read_and_what_is_wrong() {
    let steps = |text: &str| text.parse::<Steps>().unwrap_err().to_string();
    assert_eq!(steps("1.5"), "Steps: more than 0 decimals");
    assert_eq!(steps("3000000000"), "Steps: not from -2147483648 to 2147483647");
    assert_eq!("300".parse::<Motor>().unwrap_err().to_string(), "Motor: not from 0 to 255");
    assert_eq!("700".parse::<JogSpeed>().unwrap_err().to_string(), "JogSpeed: not from 0.00 to 655.35");
}

#[test]
fn values_are_written_and_read_as_their_raw_numbers() {
    let json = serde_json::to_string(&(Steps(-5), FramesPerSecond(Scaled(23_976)), AckCode::ERR_RANGE, Motor(7)));
    assert_eq!(json.unwrap(), format!("[-5,23976,{},7]", AckCode::ERR_RANGE.0));
    assert_eq!(serde_json::from_str::<FramesPerSecond>("23976").unwrap(), FramesPerSecond(Scaled(23_976)));
    assert_eq!(serde_json::from_str::<AckCode>("200").unwrap(), AckCode(200));
    assert!(serde_json::from_str::<Motor>("256").is_err());
}
