//! Why something is not done, in words.

use dmc_proto::host::Failure;
use dmc_proto::message::{AckCode, Motor, StopReason};

use crate::drive::Trouble;

/// What a failure means for what was wanted.
pub(super) fn failed(what: &str, failure: Failure) -> Trouble {
    let refused = |code| Trouble::Refused(format!("the rig refuses {what}: {}", reason(code)));
    let failed = |why| Trouble::Failed(format!("{what} failed: {why}"));
    match failure {
        Failure::Refused(AckCode::ERR_CHECKSUM) => failed("the rig gets it damaged each time: look at the cable"),
        Failure::Refused(code) => refused(code),
        Failure::WouldBeRefused(code) => Trouble::Refused(format!("the rig would refuse {what}: {}", reason(code))),
        Failure::Unclear => failed("the rig answers, but not how it ended: ask it with `info`"),
        Failure::Timeout => failed("the rig does not answer any more: look at its cable and its power"),
        Failure::Stopped => failed("it was stopped"),
        Failure::HardStop => failed("the rig stopped hard: look at its limit switches and its emergency stop"),
        Failure::DeviceReset => failed("the rig was reset, and has forgotten all: begin again"),
        Failure::NotUp => failed("there is no line to the rig any more: look at its cable and its power"),
        _ => failed("the rig is busy with something else: wait, or stop it"),
    }
}

fn reason(code: AckCode) -> String {
    let known = match code {
        AckCode::ERR_MOVING => "motors move: wait until they rest, or stop them",
        AckCode::ERR_UNSUPPORTED => "it is not made for that: `info` tells what it can do",
        AckCode::ERR_RANGE => "a number is out of its range: `info` tells what it has",
        AckCode::ERR_GENERAL => "it cannot do it now: release its emergency stop, or upload the move again",
        AckCode::ERR_NOT_IN_POSITION => "its motors are not where the move begins: upload the move again",
        AckCode::ERR_PREROLL => {
            "getting up to speed would pass a limit: make the begin of the move slower, or calibrate wider"
        }
        AckCode::ERR_POSTROLL => {
            "coming to rest would pass a limit: make the end of the move slower, or calibrate wider"
        }
        AckCode::ERR_SOFT_UP => "that is beyond the upper limit of a motor: stay below it, or calibrate wider",
        AckCode::ERR_SOFT_LOW => "that is beyond the lower limit of a motor: stay above it, or calibrate wider",
        AckCode::ERR_HARD_UP => "a motor is at its upper limit switch: wait two seconds, and jog it back",
        AckCode::ERR_HARD_LOW => "a motor is at its lower limit switch: wait two seconds, and jog it back",
        _ => return format!("{code:?}"),
    };
    known.to_owned()
}

/// What a hard stop means.
pub(super) fn hard_stop(reason: StopReason, motor: Option<Motor>) -> Trouble {
    let which = motor.map_or_else(|| "a motor".to_owned(), |motor| format!("motor {motor}"));
    Trouble::Failed(match reason {
        StopReason::EMERGENCY_STOP => "somebody pressed the emergency stop: release it when all is safe".to_owned(),
        StopReason::UPPER_LIMIT => {
            format!("{which} ran into its upper limit switch: jog it back, and stay below it")
        }
        StopReason::LOWER_LIMIT => {
            format!("{which} ran into its lower limit switch: jog it back, and stay above it")
        }
        _ => format!("the rig gave up because of {which}: see what is in its way, and begin again"),
    })
}
