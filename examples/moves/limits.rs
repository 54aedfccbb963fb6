//! Curves held against the limits of their axis.

use std::fmt;

use motion_core::trajectory::Tolerance;

use super::MoveAxis;

/// A jump of velocity that is none: this part of the limit of velocity.
const SMOOTH: f64 = 1e-6;

/// What a curve asks for beyond the limits of its axis. It prints as one line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excess<'a> {
    /// The axis.
    pub axis: &'a MoveAxis,
    /// The number of the segment, from 0: it runs from the key frame of that number to the next.
    pub segment: usize,
    /// What is too much.
    pub what: What,
}

/// What is too much: numbers in units of the axis; `None` is without limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum What {
    /// The greatest speed, and what it may be.
    Velocity(Option<f64>, f64),
    /// The greatest acceleration, and what it may be.
    Acceleration(Option<f64>, f64),
    /// Velocity jumps by this much where the segment begins, which no acceleration can do.
    Corner(Option<f64>),
}

/// All excesses of an axis; none without limits.
pub(super) fn excesses(axis: &MoveAxis) -> impl Iterator<Item = Excess<'_>> {
    axis.limits.into_iter().flat_map(move |limits| {
        let tolerance = Tolerance { time: f64::INFINITY, position: f64::INFINITY, velocity: SMOOTH * limits.velocity };
        let corners: Vec<_> = axis.curve().joints(tolerance).collect();
        axis.segments.iter().enumerate().flat_map(move |(segment, curve)| {
            let beyond = |peak: Option<f64>, limit: f64| peak.is_none_or(|peak| peak > limit * (1.0 + SMOOTH));
            let corner =
                corners.iter().find(|corner| corner.index == segment).map(|corner| What::Corner(corner.velocity));
            let (velocity, acceleration) = (curve.peak_velocity(), curve.peak_acceleration());
            let fast = beyond(velocity, limits.velocity).then_some(What::Velocity(velocity, limits.velocity));
            let hard = beyond(acceleration, limits.acceleration)
                .then_some(What::Acceleration(acceleration, limits.acceleration));
            [corner, fast, hard].into_iter().flatten().map(move |what| Excess { axis, segment, what })
        })
    })
}

impl fmt::Display for Excess<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, unit, segment) = (&self.axis.name, &self.axis.unit, self.segment);
        let amount = |value: Option<f64>| match value.map(|value| format!("{value:.6}")) {
            Some(digits) => digits.trim_end_matches('0').trim_end_matches('.').to_owned(),
            None => "without limit".to_owned(),
        };
        let (from, to) = (self.axis.segments[segment].start(), self.axis.segments[segment].end());
        write!(f, "axis {name:?}, segment {} from {from} s to {to} s: ", segment + 1)?;
        match self.what {
            What::Velocity(peak, limit) => write!(f, "velocity {}, the limit is {limit} {unit}/s", amount(peak)),
            What::Acceleration(peak, limit) => {
                write!(f, "acceleration {}, the limit is {limit} {unit}/s²", amount(peak))
            }
            What::Corner(None) => write!(f, "a corner at {from} s, where velocity has no limit"),
            What::Corner(jump) => write!(f, "a corner at {from} s, velocity jumps by {} {unit}/s", amount(jump)),
        }
    }
}
