//! Axes of a move, and the motors that move them.

use motion_core::bezier::{Key, Segment};
use motion_core::profile::Limits;
use motion_core::trajectory::{Axis, Map, Range, StepScale};
use serde::Deserialize;

use super::object::Object;
use super::schema::{FileDmc, FileHoot, FileKos};

/// One axis of a move: its curve, its limits, and the motors that move it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MoveAxis {
    /// Name of the axis.
    pub name: String,
    /// Unit of its positions.
    pub unit: String,
    /// Key frames, at least two.
    pub keys: Vec<Key>,
    /// Limits of the axis, in its units, if the file has them.
    pub limits: Option<Limits>,
    /// The kOS motor that moves the axis.
    pub kos: Option<Kos>,
    /// The DMC motor that moves the axis.
    pub dmc: Option<Dmc>,
    /// The NMX motor that moves the axis.
    pub hoot: Option<Hoot>,
    pub(super) segments: Vec<Segment>,
}

impl MoveAxis {
    /// Positions of the axis over time.
    #[must_use]
    #[expect(clippy::missing_panics_doc, reason = "the segments were checked when the file was read")]
    pub fn curve(&self) -> Axis<'_> {
        Axis::new(&self.segments, &self.unit).expect("segments in the order of time")
    }
}

/// A motor of a kOS device, which receives positions as parts of its range.
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

/// A motor of a DMC device.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(try_from = "Object<FileDmc>")]
pub struct Dmc {
    /// Number of the motor, from 1 to 32.
    pub motor: u8,
    /// Scale from positions of the axis to steps.
    pub scale: StepScale,
}

/// A motor of an NMX.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(try_from = "Object<FileHoot>")]
pub struct Hoot {
    /// Address of the node, from 2 to 255.
    pub address: u8,
    /// Number of the motor in the node, from 1 to 3.
    pub motor: u8,
    /// Scale from positions of the axis to steps.
    pub scale: StepScale,
}
