//! Texts that say why something was not done.

use std::fmt::Display;

use dmc_proto::host::{Failure, Outcome, Refusal};
use dmc_proto::message::{AckCode, Motor, StopReason};

use crate::drive::Trouble;

const CABLE: &str = "check its cable and its power";

/// Trouble that it means when `what` is not done. `has_switches` says whether the rig has limit switches.
pub(super) fn not_done(what: &str, outcome: Outcome<'_>, has_switches: bool) -> Trouble {
    let failed = |why: &dyn Display, advice: &str| Trouble::Failed(format!("{what} failed: {why}: {advice}"));
    match outcome {
        Outcome::Refused(Refusal::Device(AckCode::ERR_CHECKSUM)) => {
            failed(&"each time it arrived damaged", "check the cable")
        }
        Outcome::Refused(Refusal::Device(code)) => {
            Trouble::Refused(format!("the rig refuses {what}: {}", reason(code, has_switches)))
        }
        Outcome::Refused(Refusal::WouldBeRefused(code)) => {
            Trouble::Refused(format!("the rig would refuse {what}: {}", reason(code, has_switches)))
        }
        Outcome::Refused(refusal) => {
            let advice = match refusal {
                Refusal::NotConfigured(..) => "`info` shows whether the rig has this motor",
                Refusal::NotInMove(_) => "the rig could send it to 0",
                Refusal::MoveUnknown => "upload the move again",
                Refusal::NotConnected => CABLE,
                Refusal::NotReady => "wait, and start again",
                Refusal::Stopping => "check the rig, and stop it",
                _ => "wait, or stop the rig",
            };
            failed(&refusal, advice)
        }
        Outcome::Failed(failure) => {
            let advice = match failure {
                Failure::NoAnswer | Failure::LinkDown => CABLE,
                Failure::HardStop if has_switches => "check its limit switches and its emergency stop",
                Failure::HardStop => "check its emergency stop",
                _ => "start again",
            };
            failed(&failure, advice)
        }
        _ => failed(&"the rig did not say how it ended", "check its cable and its power, and the motors with `info`"),
    }
}

fn reason(code: AckCode, has_switches: bool) -> String {
    let known = match code {
        AckCode::ERR_MOVING => "motors move: wait until they rest, or stop them",
        AckCode::ERR_UNSUPPORTED => "it does not support that: `info` shows its capabilities",
        AckCode::ERR_RANGE => "a number is out of range: `info` shows what the rig has",
        AckCode::ERR_GENERAL => "it cannot do that now: release its emergency stop, or upload the move again",
        AckCode::ERR_NOT_IN_POSITION => "its motors are not where the move begins: upload the move again",
        AckCode::ERR_PREROLL => {
            "the acceleration before the move would pass a limit: make the start of the move slower, or its range wider"
        }
        AckCode::ERR_POSTROLL => {
            "the deceleration after the move would pass a limit: make the end of the move slower, or its range wider"
        }
        AckCode::ERR_SOFT_UP => "that is beyond the upper limit of a motor: stay below it, or calibrate a wider range",
        AckCode::ERR_SOFT_LOW => "that is beyond the lower limit of a motor: stay above it, or calibrate a wider range",
        // Some devices answer so for two seconds after each stop.
        AckCode::ERR_HARD_UP | AckCode::ERR_HARD_LOW if !has_switches => {
            "it is locked after a stop: wait until the motors rest, and two seconds more"
        }
        AckCode::ERR_HARD_UP | AckCode::ERR_HARD_LOW => {
            "it is locked after a stop: wait two seconds; if a motor is at a limit switch, jog it back"
        }
        _ => return code.to_string(),
    };
    known.to_owned()
}

/// Trouble that a hard stop means.
pub(super) fn hard_stop(reason: StopReason, motor: Option<Motor>, has_switches: bool) -> Trouble {
    let which = motor.map_or_else(|| "a motor".to_owned(), |motor| format!("motor {motor}"));
    Trouble::Failed(match reason {
        StopReason::EMERGENCY_STOP => "the emergency stop was pressed: release it when all is safe".to_owned(),
        StopReason::UPPER_LIMIT | StopReason::LOWER_LIMIT if !has_switches => {
            format!(
                "the rig stopped hard because of {which}, and has no limit switches: check its range and its emergency stop"
            )
        }
        StopReason::UPPER_LIMIT => {
            format!("{which} ran into its upper limit switch: jog it back, and stay below it")
        }
        StopReason::LOWER_LIMIT => {
            format!("{which} ran into its lower limit switch: jog it back, and stay above it")
        }
        _ => format!("the rig stopped because of {which}: check what blocks it, and start again"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_switch_is_named_only_if_the_rig_has_one() {
        let refused = |code| Outcome::Refused(Refusal::Device(code));
        for has_switches in [false, true] {
            let lines = [
                not_done("the move", refused(AckCode::ERR_HARD_LOW), has_switches),
                not_done("the move", Outcome::Failed(Failure::HardStop), has_switches),
                hard_stop(StopReason::LOWER_LIMIT, Some(Motor(1)), has_switches),
                hard_stop(StopReason::UPPER_LIMIT, None, has_switches),
            ];
            for line in lines.map(|trouble| trouble.to_string()) {
                let names = line.contains("limit switch") && !line.contains("no limit switches");
                assert_eq!(names, has_switches, "{line}");
            }
        }
    }
}
