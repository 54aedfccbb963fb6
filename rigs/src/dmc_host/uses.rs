//! Uses that the motors need before a command moves them, and commands that wait for them.
//!
//! Devices acknowledge moves of motors that are not enabled, tell that they arrive, and do not move them. In a shot they
//! move only the motors that are set to blur, and with a blurred motor and no ways they follow the uploaded move. Some give
//! a motor that is not in the move a path of zeros: enabled, it would run to 0.

use std::collections::BTreeMap;

use dmc_proto::Token;
use dmc_proto::message::{HostMessage, Motor, MotorFlags, MotorPair};
use dmc_proto::upload::MoveSource;

use super::Table;

/// Command that waits until its motors have their uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Waiting {
    pub(super) token: Token,
    pub(super) is_sequence: bool,
}

/// Uses of the motors on this link, as the device acknowledged them.
pub(super) type Uses = BTreeMap<Motor, MotorFlags>;

/// First of the `count` motors of the device that has not the uses that a message needs, with the uses to set. Motors that
/// move together need all other motors to be disabled. Without a move that this host uploaded, nobody knows which ones that
/// are.
pub(super) fn lacking(
    uses: &Uses,
    message: &HostMessage<'_>,
    table: Option<&Table>,
    count: u8,
) -> Option<(Motor, MotorFlags)> {
    let axes = || table.into_iter().flat_map(|table| table.motors().iter());
    let others = |own: &[MotorPair]| {
        let is_axis = |motor: Motor| table.is_some_and(|table| table.motors().contains(motor));
        let takes_part = |motor: Motor| is_axis(motor) || own.iter().any(|pair| pair.motor() == motor);
        let is_known = table.is_some() || !own.is_empty();
        disabled(uses, (1..=count).map(Motor).filter(|motor| is_known && !takes_part(*motor)))
    };
    match message {
        HostMessage::MotorMove(message) => enabled(uses, [message.motor]),
        HostMessage::MotorJog(message) => enabled(uses, [message.motor]),
        HostMessage::RtPositionFrame(_) | HostMessage::RtJogAll(_) | HostMessage::RtRunMove(_) => {
            others(&[]).or_else(|| enabled(uses, axes()))
        }
        HostMessage::RtShootFrame(shot) => others(shot.motors).or_else(|| blurred(uses, shot.motors, axes())),
        HostMessage::RtShootFrame2(shot) => others(shot.motors).or_else(|| blurred(uses, shot.motors, axes())),
        _ => None,
    }
}

/// First motor that is not known to be disabled, except those that are driven by hand. Its other uses stay.
fn disabled(uses: &Uses, motors: impl IntoIterator<Item = Motor>) -> Option<(Motor, MotorFlags)> {
    let moves = MotorFlags::ENABLED | MotorFlags::BLUR;
    let may_move = |flags: &MotorFlags| flags.intersects(moves) && !flags.contains(MotorFlags::LIVE);
    let motor = motors.into_iter().find(|motor| uses.get(motor).is_none_or(may_move))?;
    Some((motor, uses.get(&motor).copied().unwrap_or_default().difference(moves)))
}

/// First motor that is not enabled. Its other uses stay.
fn enabled(uses: &Uses, motors: impl IntoIterator<Item = Motor>) -> Option<(Motor, MotorFlags)> {
    let flags = |motor: &Motor| uses.get(motor).copied().unwrap_or_default();
    let motor = motors.into_iter().find(|motor| !flags(motor).contains(MotorFlags::ENABLED))?;
    Some((motor, flags(&motor) | MotorFlags::ENABLED))
}

/// First motor that has not its uses for a shot: with a way of its own it blurs, without one it does not.
fn blurred(uses: &Uses, pairs: &[MotorPair], axes: impl Iterator<Item = Motor>) -> Option<(Motor, MotorFlags)> {
    let own = |motor: Motor| pairs.iter().any(|pair| pair.motor() == motor);
    let others = axes.filter(|motor| !own(*motor)).map(|motor| (motor, MotorFlags::ENABLED));
    let blurred = pairs.iter().map(|pair| (pair.motor(), MotorFlags::ENABLED | MotorFlags::BLUR));
    blurred.chain(others).find(|(motor, flags)| uses.get(motor) != Some(flags))
}
