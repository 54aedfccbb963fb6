//! Joints between the segments of an axis, and jumps at them.

use super::Axis;
use crate::bezier::print::debug_numbers;

/// Tolerances for jumps of time, position and velocity from one segment to the next.
///
/// With the tolerance `f64::INFINITY`, a jump is not checked.
#[derive(Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Greatest gap or overlap, in seconds.
    pub time: f64,
    /// Greatest jump of position, in units.
    pub position: f64,
    /// Greatest jump of velocity, in units per second.
    pub velocity: f64,
}

debug_numbers! { Tolerance { time, position, velocity } }

impl Tolerance {
    /// The same tolerance for all three; for kOS devices it is 1e-4 (kOS, `TrajectoryData`; decision K-J8).
    #[must_use]
    pub const fn all(tolerance: f64) -> Self {
        Self { time: tolerance, position: tolerance, velocity: tolerance }
    }

    /// A tolerance for time and position only, for moves that have corners on purpose.
    #[must_use]
    pub const fn ignoring_velocity(tolerance: f64) -> Self {
        Self { velocity: f64::INFINITY, ..Self::all(tolerance) }
    }
}

/// A joint with a jump from one segment to the next. Each amount is the value at the start of the later segment, minus
/// the value at the end of the earlier one.
#[derive(Clone, Copy, PartialEq)]
pub struct Joint {
    /// Number of the later segment, from 0.
    pub index: usize,
    /// Start of the later segment, in seconds.
    pub time: f64,
    /// Time from the end of the earlier segment to this start, in seconds; negative if the segments overlap.
    pub gap: f64,
    /// Jump of position, in units.
    pub position: f64,
    /// Jump of velocity, in units per second; `None` if one of the velocities has no limit. The rest in a gap does not
    /// count.
    pub velocity: Option<f64>,
}

debug_numbers! { Joint { index, time, gap, position, velocity } }

impl<'a> Axis<'a> {
    /// The joints at which time, position or velocity jumps by more than a tolerance.
    pub fn joints(&self, tolerance: Tolerance) -> impl Iterator<Item = Joint> + use<'a> {
        let pairs = self.segments.iter().zip(self.segments.iter().skip(1));
        pairs.zip(1..).filter_map(move |((before, after), index)| {
            let (end, time) = (before.end(), after.start());
            let (ended, begins) = (before.at(end), after.at(time));
            let velocity = ended.velocity.zip(begins.velocity).map(|(ended, begins)| begins - ended);
            let joint = Joint { index, time, gap: time - end, position: begins.position - ended.position, velocity };
            // With these comparisons, a tolerance that is NaN tolerates nothing.
            let smooth = joint.gap.abs() <= tolerance.time
                && joint.position.abs() <= tolerance.position
                && velocity.map_or(f64::INFINITY, f64::abs) <= tolerance.velocity;
            (!smooth).then_some(joint)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::{Ease, Key, Segment};

    fn segment(from: (f64, f64), to: (f64, f64), arrive: Ease) -> Segment {
        let key = |(time, position)| Key { time, position, arrive, leave: Ease::Linear };
        Segment::between(&key(from), &key(to)).unwrap()
    }

    #[test]
    fn each_kind_of_jump_is_found() {
        let steep = Ease::Handle(crate::bezier::Point::new(0.0, -1.0));
        let segments = [
            segment((0.0, 0.0), (1.0, 1.0), Ease::Linear),
            // No jump.
            segment((1.0, 1.0), (2.0, 2.0), Ease::Linear),
            // A corner.
            segment((2.0, 2.0), (3.0, 0.0), Ease::Linear),
            // A gap and a jump of position.
            segment((3.5, 1.0), (4.0, 0.0), steep),
            // The velocity before this segment has no limit.
            segment((4.0, 0.0), (5.0, 0.0), Ease::Linear),
        ];
        let axis = Axis::new(&segments, "").unwrap();
        let joints = |tolerance| {
            let mut found = [None; 5];
            axis.joints(tolerance).zip(&mut found).for_each(|(joint, slot)| *slot = Some(joint.index));
            found
        };
        assert_eq!(joints(Tolerance::all(1e-4)), [Some(2), Some(3), Some(4), None, None]);
        assert_eq!(joints(Tolerance::ignoring_velocity(1e-4)), [Some(3), None, None, None, None]);
        assert_eq!(joints(Tolerance { time: 1.0, ..Tolerance::ignoring_velocity(2.0) }), [None; 5]);
        assert_eq!(joints(Tolerance::all(f64::NAN)).iter().flatten().count(), 4);

        let corner = axis.joints(Tolerance::all(1e-4)).next().unwrap();
        assert!((corner.velocity.unwrap() + 3.0).abs() < 1e-12);
        assert_eq!((corner.time, corner.gap, corner.position), (2.0, 0.0, 0.0));
        let gap = axis.joints(Tolerance::all(1e-4)).nth(1).unwrap();
        assert_eq!((gap.time, gap.gap, gap.position), (3.5, 0.5, 1.0));
        let steep = axis.joints(Tolerance::all(1e-4)).nth(2).unwrap();
        assert_eq!((steep.gap, steep.position, steep.velocity), (0.0, 0.0, None));
    }
}
