//! Joints of an axis, and jumps at them: between its segments, and at its ends.

use core::iter;

use super::Axis;
use crate::bezier::Segment;
use crate::bezier::print::debug_numbers;

/// Tolerances for jumps of time, position and velocity at the joints of an axis.
///
/// With the tolerance `f64::INFINITY`, a jump is not checked.
#[derive(Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Greatest gap or overlap, in seconds. In a gap that is longer, the axis rests.
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

    /// Whether an axis rests in a gap.
    fn rests(&self, gap: f64) -> bool {
        gap > self.time
    }
}

/// A joint with a jump: between two segments, or at an end of the axis. Each amount is the value after the joint, minus
/// the value before it.
#[derive(Clone, Copy, PartialEq)]
pub struct Joint {
    /// Number of the segment after the joint, from 0. At the end of the axis, it is the number of all segments.
    pub index: usize,
    /// Start of the segment after the joint, or the end of the axis, in seconds.
    pub time: f64,
    /// Time from the end of the earlier segment to this start, in seconds; negative if the segments overlap. It is 0 at
    /// the ends of the axis.
    pub gap: f64,
    /// Jump of position, in units. It is 0 at the ends of the axis.
    pub position: f64,
    /// Jump of velocity, in units per second; `None` if one of the velocities has no limit. Before its start and after
    /// its end the axis rests, and so it does in a gap; there, this is the greater one of the jumps to and from rest.
    pub velocity: Option<f64>,
}

debug_numbers! { Joint { index, time, gap, position, velocity } }

impl<'a> Axis<'a> {
    /// The joints at which time, position or velocity jumps by more than a tolerance, in the order of time.
    ///
    /// The ends of the axis are joints too, because it rests outside of them. So a move that begins or ends in motion has
    /// a jump of velocity there, as if the rest was a segment.
    pub fn joints(&self, tolerance: Tolerance) -> impl Iterator<Item = Joint> + use<'a> {
        let pairs = self.segments.iter().zip(self.segments.iter().skip(1)).zip(1..);
        let inner = pairs.map(move |((before, after), index)| between(before, after, index, tolerance));
        let end = |index, time, velocity| iter::once(Joint { index, time, gap: 0.0, position: 0.0, velocity });
        let starts = self.first.at(self.start()).velocity;
        let ends = self.last.at(self.end()).velocity;
        let start = end(0, self.start(), starts);
        let last = end(self.segments.len(), self.end(), ends.map(|velocity| -velocity));
        start.chain(inner).chain(last).filter(move |joint| {
            // With these comparisons, a tolerance that is NaN tolerates nothing.
            let smooth = joint.gap.abs() <= tolerance.time
                && joint.position.abs() <= tolerance.position
                && joint.velocity.map_or(f64::INFINITY, f64::abs) <= tolerance.velocity;
            !smooth
        })
    }
}

/// The joint between two segments.
fn between(before: &Segment, after: &Segment, index: usize, tolerance: Tolerance) -> Joint {
    let (end, time) = (before.end(), after.start());
    let (ended, begins) = (before.at(end), after.at(time));
    let gap = time - end;
    let velocity = ended.velocity.zip(begins.velocity).map(|(ended, begins)| match tolerance.rests(gap) {
        false => begins - ended,
        true if ended.abs() > begins.abs() => -ended,
        true => begins,
    });
    Joint { index, time, gap, position: begins.position - ended.position, velocity }
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
        assert_eq!(joints(Tolerance::all(1e-4)), [Some(0), Some(2), Some(3), Some(4), None]);
        assert_eq!(joints(Tolerance::ignoring_velocity(1e-4)), [Some(3), None, None, None, None]);
        assert_eq!(joints(Tolerance { time: 1.0, ..Tolerance::ignoring_velocity(2.0) }), [None; 5]);
        assert_eq!(axis.joints(Tolerance::all(f64::NAN)).count(), 6);

        let corner = axis.joints(Tolerance::all(1e-4)).nth(1).unwrap();
        assert!((corner.velocity.unwrap() + 3.0).abs() < 1e-12);
        assert_eq!((corner.time, corner.gap, corner.position), (2.0, 0.0, 0.0));
        let gap = axis.joints(Tolerance::all(1e-4)).nth(2).unwrap();
        assert_eq!((gap.time, gap.gap, gap.position), (3.5, 0.5, 1.0));
        let steep = axis.joints(Tolerance::all(1e-4)).nth(3).unwrap();
        assert_eq!((steep.gap, steep.position, steep.velocity), (0.0, 0.0, None));
    }

    /// Jumps of velocity of an axis, with the times at which they are.
    fn jumps(segments: &[Segment], time: f64) -> std::vec::Vec<(f64, f64)> {
        let tolerance = Tolerance { time, ..Tolerance::all(1e-9) };
        let axis = Axis::new(segments, "").unwrap();
        axis.joints(tolerance).map(|joint| (joint.time, joint.velocity.unwrap())).collect()
    }

    #[test]
    fn a_move_in_motion_at_its_ends_has_the_same_joints_with_and_without_its_rests() {
        let (there, back) =
            (segment((1.0, 0.0), (3.0, 8.0), Ease::Linear), segment((5.0, 8.0), (9.0, 4.0), Ease::Linear));
        let rest = |from, to, position| segment((from, position), (to, position), Ease::Linear);
        let written = [rest(0.0, 1.0, 0.0), there, rest(3.0, 5.0, 8.0), back, rest(9.0, 10.0, 4.0)];
        let near = |one: &[(f64, f64)], other: &[(f64, f64)]| {
            one.len() == other.len()
                && one.iter().zip(other).all(|(a, b)| (a.0 - b.0).abs() < 1e-9 && (a.1 - b.1).abs() < 1e-9)
        };
        let all = [(1.0, 4.0), (3.0, -4.0), (5.0, -1.0), (9.0, 1.0)];
        assert!(near(&jumps(&written, 0.0), &all), "{:?}", jumps(&written, 0.0));
        // A gap is one joint, which has the greater one of its jumps.
        for time in [0.0, 1.9] {
            let found = jumps(&[there, back], time);
            assert!(near(&found, &[(1.0, 4.0), (5.0, -4.0), (9.0, 1.0)]), "{time}: {found:?}");
        }
        // A gap within the tolerance is no rest.
        for time in [2.0, f64::INFINITY] {
            let found = jumps(&[there, back], time);
            assert!(near(&found, &[(1.0, 4.0), (5.0, -5.0), (9.0, 1.0)]), "{time}: {found:?}");
        }
        let smooth = Segment::between(
            &Key { time: 0.0, position: 0.0, arrive: Ease::Linear, leave: Ease::Flat(0.3) },
            &Key { time: 2.0, position: 5.0, arrive: Ease::Flat(0.3), leave: Ease::Linear },
        );
        assert_eq!(jumps(&[smooth.unwrap()], 0.0), []);
    }
}
