//! Move files for kOS motors.

use kos_proto::lint::Context;
use kos_proto::message::Motor;
use kos_proto::trajectory::{Play, Trajectory};
use motion_core::trajectory::Range;
use motion_move::{Kos, Move, MoveAxis, kos};
use motion_rigs::kos_host::StoredMove;

use crate::drive::Trouble;

/// Greatest difference between the range of the rig and the range of the file, as a part of the range.
const SAME: f64 = 1e-3;

/// Axes of a move that have a kOS motor.
///
/// # Errors
///
/// [`Trouble::Refused`] if no axis has a kOS motor.
pub fn axes(file: &Move) -> Result<Vec<(&MoveAxis, Kos)>, Trouble> {
    let ours: Vec<_> = file.axes().iter().filter_map(|axis| Some((axis, axis.kos()?))).collect();
    if ours.is_empty() {
        return Err(Trouble::Refused(format!(
            "the move {:?} has no axis for kOS: give one a \"kos\" motor in its file",
            file.name()
        )));
    }
    Ok(ours)
}

/// Note about the axes without a kOS motor, if there are any.
pub(super) fn left_out(file: &Move) -> Option<String> {
    let others = file.axes().iter().filter(|axis| axis.kos().is_none());
    let names: Vec<String> = others.map(|axis| format!("{:?}", axis.name())).collect();
    (!names.is_empty()).then(|| format!("left out, because they have no kOS motor: {}", names.join(", ")))
}

/// Blocks of a move, as the rig stores them.
///
/// # Errors
///
/// [`Trouble::Refused`], which says why kOS cannot represent the move.
pub fn stored(file: &Move, play: Play) -> Result<StoredMove, Trouble> {
    axes(file)?;
    let refused = |why: &dyn std::fmt::Display| Trouble::Refused(format!("the move {:?}: {why}", file.name()));
    let converted = kos::convert(file, play).map_err(|why| refused(&why))?;
    StoredMove::new(&converted.data()).map_err(|why| refused(&why))
}

/// Checks whether the rig can play a move: its motors exist, are calibrated over the ranges of the file, and are fast
/// enough.
///
/// # Errors
///
/// [`Trouble::Refused`], which says what is missing, and what to do.
pub fn check(file: &Move, stored: &StoredMove, motors: &[Motor]) -> Result<(), Trouble> {
    for (axis, kos) in axes(file)? {
        let known = motors.iter().find(|known| known.motor_address.number() == kos.motor);
        let Some(known) = known else { return Err(no_motor(kos.motor, motors)) };
        let Range { from, to } = kos.range;
        let width = kos.range.width();
        let calibrate = format!("moco drive kos ADDRESS calibrate {} {from} {to}", kos.motor);
        let Some(range) = known.range() else {
            return Err(Trouble::Refused(format!("motor {} is not calibrated: {calibrate}", kos.motor)));
        };
        // No device reports where the beginning of its range is: some count from there, and some from anywhere.
        if (f64::from(range.0) - width).abs() > SAME * width.abs() {
            return Err(Trouble::Refused(format!(
                "motor {} is calibrated over {} rotations, but axis {:?} is planned over {width}: {calibrate}",
                kos.motor,
                range.0,
                axis.name()
            )));
        }
    }
    if let Some(excess) = file.excesses().next() {
        return Err(Trouble::Refused(format!("the move {:?}: {excess}: make it slower", file.name())));
    }
    let data = stored.data();
    let excess = Trajectory::new(&data).ok().and_then(|trajectory| {
        let known = Context::default().with_motors(motors);
        trajectory.excesses(&known).next()
    });
    match excess {
        Some(excess) => Err(Trouble::Refused(format!("the move {:?}: {excess}: make it slower", file.name()))),
        None => Ok(()),
    }
}

/// Trouble about a motor that the rig does not have.
pub(super) fn no_motor(motor: u8, motors: &[Motor]) -> Trouble {
    let numbers: Vec<String> = motors.iter().map(|known| known.motor_address.number().to_string()).collect();
    Trouble::Refused(match &numbers[..] {
        [] => format!("there is no motor {motor}: the rig has none"),
        [only] => format!("there is no motor {motor}: the rig has motor {only}"),
        numbers => format!("there is no motor {motor}: the rig has motors {}", numbers.join(", ")),
    })
}
