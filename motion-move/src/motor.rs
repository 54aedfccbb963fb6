//! Motors that move an axis.

use motion_core::trajectory::{Map, Range, StepScale};
use serde::Deserialize;

use crate::error::MotorProblem;
use crate::file::{FileDmc, FileHoot, FileKos};
use crate::object::Object;

/// Address of an NMX as it is sold, which an axis has if its file names no other.
pub(crate) const USUAL_ADDRESS: u8 = 3;

/// Motor of a kOS device, which receives positions as parts of its range.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(try_from = "Object<FileKos>")]
#[non_exhaustive]
pub struct Kos {
    /// Address of the motor, from 1 to 10.
    pub motor: u8,
    /// Conversion from positions of the axis to rotations.
    pub rotations: Rotations,
    /// Calibrated range of the motor, in rotations.
    pub range: Range,
    /// Map from positions of the axis to parts of the range, from 0 at its start to 1 at its end.
    pub normalized: Map,
}

impl Kos {
    /// A motor from its address, its conversion and its calibrated range in rotations.
    ///
    /// # Errors
    ///
    /// [`MotorProblem`] if the address is not from 1 to 10, the rotations per unit are 0, the range has no width, or a
    /// number is not finite.
    pub fn new(motor: u8, rotations: Rotations, range: Range) -> Result<Self, MotorProblem> {
        numbered("kos", "motor", motor, 1, 10)?;
        let position = |at: f64| (at - rotations.offset) / rotations.per_unit;
        // With a scale of 0, positions are not finite.
        let normalized = Map::new(Range::new(position(range.from), position(range.to)), Range::UNIT)
            .map_err(|_| MotorProblem::Range)?;
        Ok(Self { motor, rotations, range, normalized })
    }

    pub(crate) fn checked(self) -> Result<Self, MotorProblem> {
        Self::new(self.motor, self.rotations, self.range)
    }
}

/// Conversion from positions of an axis to rotations of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotations {
    /// Rotations per unit; negative if the motor runs against the axis.
    pub per_unit: f64,
    /// Rotations at position 0.
    pub offset: f64,
}

impl Rotations {
    /// The rotations at a position.
    #[must_use]
    pub fn at(&self, position: f64) -> f64 {
        position * self.per_unit + self.offset
    }
}

/// Motor of a DMC device.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(try_from = "Object<FileDmc>")]
#[non_exhaustive]
pub struct Dmc {
    /// Number of the motor, from 1 to 32.
    pub motor: u8,
    /// Scale from positions of the axis to steps.
    pub scale: StepScale,
}

impl Dmc {
    /// A motor from its number, its steps per unit, and its steps at position 0.
    ///
    /// # Errors
    ///
    /// [`MotorProblem`] if the number is not from 1 to 32, the steps per unit are 0, or a number is not finite.
    pub fn new(motor: u8, steps_per_unit: f64, offset: f64) -> Result<Self, MotorProblem> {
        Self { motor, scale: scale("dmc", steps_per_unit, offset)? }.checked()
    }

    pub(crate) fn checked(self) -> Result<Self, MotorProblem> {
        numbered("dmc", "motor", self.motor, 1, 32).map(|()| self)
    }
}

/// Motor of an NMX.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(try_from = "Object<FileHoot>")]
#[non_exhaustive]
pub struct Hoot {
    /// Address of the node, from 2 to 255.
    pub address: u8,
    /// Number of the motor in the node, from 1 to 3.
    pub motor: u8,
    /// Scale from positions of the axis to steps.
    pub scale: StepScale,
}

impl Hoot {
    /// A motor from the address of its node, its number, its steps per unit, and its steps at position 0.
    ///
    /// # Errors
    ///
    /// [`MotorProblem`] if the address is not from 2 to 255, the number is not from 1 to 3, the steps per unit are 0, or
    /// a number is not finite.
    pub fn new(address: u8, motor: u8, steps_per_unit: f64, offset: f64) -> Result<Self, MotorProblem> {
        Self { address, motor, scale: scale("hoot", steps_per_unit, offset)? }.checked()
    }

    pub(crate) fn checked(self) -> Result<Self, MotorProblem> {
        numbered("hoot", "address", self.address, 2, 255)?;
        numbered("hoot", "motor", self.motor, 1, 3).map(|()| self)
    }
}

fn numbered(protocol: &'static str, what: &'static str, number: u8, least: u8, most: u8) -> Result<(), MotorProblem> {
    if (least..=most).contains(&number) {
        return Ok(());
    }
    Err(MotorProblem::Number { protocol, what, number, least, most })
}

fn scale(protocol: &'static str, per_unit: f64, offset: f64) -> Result<StepScale, MotorProblem> {
    StepScale::new(per_unit, offset).map_err(|_| MotorProblem::Scale { protocol })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(feature = "hoot")]
    fn the_usual_address_is_the_one_of_the_protocol() {
        assert_eq!(USUAL_ADDRESS, hoot_proto::Address::DEFAULT.0);
    }

    #[test]
    fn motors_that_cannot_exist_are_refused() {
        let rotations = Rotations { per_unit: 0.05, offset: 0.0 };
        assert!(Kos::new(11, rotations, Range::UNIT).is_err() && Kos::new(1, rotations, Range::UNIT).is_ok());
        let still = Rotations { per_unit: 0.0, ..rotations };
        assert_eq!(Kos::new(1, still, Range::UNIT), Err(MotorProblem::Range));
        assert_eq!(Dmc::new(1, f64::NAN, 0.0), Err(MotorProblem::Scale { protocol: "dmc" }));
        assert!(
            Dmc::new(33, 1.0, 0.0).is_err() && Hoot::new(1, 1, 1.0, 0.0).is_err() && Hoot::new(3, 4, 1.0, 0.0).is_err()
        );
    }
}
