//! Comparison of curves with the limits of their axis.

use std::fmt;

use motion_core::trajectory::Tolerance;

use crate::axis::MoveAxis;

/// Tolerance of a jump or an excess, as a part of the limit.
const TOLERANCE: f64 = 1e-6;

/// A place where a curve exceeds the limits of its axis. It prints as one line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excess<'a> {
    /// The axis that has the curve.
    pub axis: &'a MoveAxis,
    /// Number of the segment, from 0. The segment is from the key frame of that number to the next.
    pub segment: usize,
    /// The rate that is too great.
    pub kind: ExcessKind,
}

/// Kind of an excess, with numbers in units of the axis; `None` means without limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExcessKind {
    /// The greatest speed, and its limit.
    Velocity(Option<f64>, f64),
    /// The greatest acceleration, and its limit.
    Acceleration(Option<f64>, f64),
    /// The jump of velocity at the start of the segment, which needs infinite acceleration.
    Corner(Option<f64>),
    /// The jump of velocity at the first key frame, before which the axis rests.
    Start(Option<f64>),
    /// The jump of velocity at the last key frame, after which the axis rests.
    End(Option<f64>),
}

/// All excesses of an axis; empty if the axis has no limits.
pub(crate) fn excesses(axis: &MoveAxis) -> impl Iterator<Item = Excess<'_>> {
    axis.limits().into_iter().flat_map(move |limits| {
        let tolerance = Tolerance { time: 0.0, position: f64::INFINITY, velocity: TOLERANCE * limits.velocity };
        let corners: Vec<_> = axis.curve().joints(tolerance).collect();
        let jump = move |index| corners.iter().find(|corner| corner.index == index).map(|corner| corner.velocity);
        let segments = axis.curve().segments();
        segments.iter().enumerate().flat_map(move |(segment, curve)| {
            let beyond = |peak: Option<f64>, limit: f64| peak.is_none_or(|peak| peak > limit * (1.0 + TOLERANCE));
            let corner = jump(segment).map(if segment == 0 { ExcessKind::Start } else { ExcessKind::Corner });
            let end = if segment.saturating_add(1) == segments.len() {
                jump(segments.len()).map(ExcessKind::End)
            } else {
                None
            };
            let (velocity, acceleration) = (curve.peak_velocity(), curve.peak_acceleration());
            let fast = beyond(velocity, limits.velocity).then_some(ExcessKind::Velocity(velocity, limits.velocity));
            let hard = beyond(acceleration, limits.acceleration)
                .then_some(ExcessKind::Acceleration(acceleration, limits.acceleration));
            [corner, fast, hard, end].into_iter().flatten().map(move |kind| Excess { axis, segment, kind })
        })
    })
}

impl fmt::Display for Excess<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, unit, segment) = (self.axis.name(), self.axis.unit(), self.segment);
        let amount = |value: Option<f64>| match value.map(|value| format!("{value:.6}")) {
            Some(digits) => digits.trim_end_matches('0').trim_end_matches('.').to_owned(),
            None => "without limit".to_owned(),
        };
        let curve = self.axis.curve();
        let (from, to) = curve.segments().get(segment).map_or((0.0, 0.0), |curve| (curve.start(), curve.end()));
        write!(f, "axis {name:?}, segment {} from {from} s to {to} s: ", segment.saturating_add(1))?;
        let corner = |f: &mut fmt::Formatter<'_>, at: f64, jump: Option<f64>| match jump {
            None => write!(f, "a corner at {at} s, where velocity has no limit"),
            jump => write!(f, "a corner at {at} s, velocity jumps by {} {unit}/s", amount(jump)),
        };
        match self.kind {
            ExcessKind::Velocity(peak, limit) => write!(f, "velocity {}, the limit is {limit} {unit}/s", amount(peak)),
            ExcessKind::Acceleration(peak, limit) => {
                write!(f, "acceleration {}, the limit is {limit} {unit}/s²", amount(peak))
            }
            ExcessKind::Corner(jump) => corner(f, from, jump),
            ExcessKind::Start(jump) => corner(f, from, jump).and_then(|()| f.write_str(", from the rest before it")),
            ExcessKind::End(jump) => corner(f, to, jump).and_then(|()| f.write_str(", to the rest after it")),
        }
    }
}
