//! An axis of a move.

use motion_core::bezier::{Key, Segment};
use motion_core::profile::Limits;
use motion_core::trajectory::{Axis, Map, Range, StepScale};
use serde::Deserialize;

use super::schema::{FileDmc, FileHoot, FileKos};

/// What one axis does in a move, and which motors do it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MoveAxis {
    /// What it is called.
    pub name: String,
    /// The unit of its positions.
    pub unit: String,
    /// Its key frames, at least two.
    pub keys: Vec<Key>,
    /// How fast it may be, in its units.
    pub limits: Option<Limits>,
    /// The kOS motor that moves it.
    pub kos: Option<Kos>,
    /// The DMC motor that moves it.
    pub dmc: Option<Dmc>,
    /// The NMX motor that moves it.
    pub hoot: Option<Hoot>,
    pub(super) segments: Vec<Segment>,
}

impl MoveAxis {
    /// Its positions over time.
    #[must_use]
    #[expect(clippy::missing_panics_doc, reason = "the segments were tried when the file was read")]
    pub fn curve(&self) -> Axis<'_> {
        Axis::new(&self.segments, &self.unit).expect("segments in the order of time")
    }
}

/// A motor of a kOS device, which is told positions as parts of its range.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(try_from = "FileKos")]
#[non_exhaustive]
pub struct Kos {
    /// Its address, from 1 to 10.
    pub motor: u8,
    /// Its rotations at a position of the axis.
    pub rotations: Rotations,
    /// Its calibrated range, in rotations.
    pub range: Range,
    /// Positions of the axis as parts of that range, 0 where it begins and 1 where it ends.
    pub normalized: Map,
}

/// How positions of an axis become rotations of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotations {
    /// Rotations a unit; negative if the motor runs against the axis.
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
#[serde(try_from = "FileDmc")]
pub struct Dmc {
    /// Its number, from 1 to 32.
    pub motor: u8,
    /// Its steps at a position of the axis.
    pub scale: StepScale,
}

/// A motor of an NMX.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(try_from = "FileHoot")]
pub struct Hoot {
    /// The address of its node, from 2 to 255.
    pub address: u8,
    /// Its number in the node, from 1 to 3.
    pub motor: u8,
    /// Its steps at a position of the axis.
    pub scale: StepScale,
}
