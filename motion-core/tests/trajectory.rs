//! Axes of several segments: the laws of `motion_core::trajectory`.

#![expect(clippy::float_cmp, reason = "what is exact by law is compared exactly")]

use motion_core::bezier::{Motion, Point, Segment};
use motion_core::trajectory::{
    Axis, FrameRate, FrameTimes, Joint, Map, Range, StepScale, StepsError, StepsOutOfRange, Tolerance,
};
use proptest::prelude::*;

/// The segments of an axis. Each begins at the end of the previous one, or after a gap or a jump.
fn chain(segments: impl Into<prop::collection::SizeRange>, jumps: bool) -> impl Strategy<Value = Vec<Segment>> {
    let share = prop_oneof![Just(0.0), Just(1.0), 0.0..=1.0];
    let handles = ([share.clone(), share], [-100.0..100.0, -100.0..100.0]);
    let gap = if jumps { prop_oneof![Just(0.0), 0.1..2.0].boxed() } else { Just(0.0).boxed() };
    let jump = if jumps { prop_oneof![Just(0.0), 1.0..20.0].boxed() } else { Just(0.0).boxed() };
    let part = (0.1..5.0, -100.0..100.0, handles, gap, jump);
    (prop::collection::vec(part, segments), -5.0..5.0, -100.0..100.0).prop_map(|(parts, start, position)| {
        let mut at = Point::new(start, position);
        let mut segments = Vec::new();
        for (duration, to, ([leave, arrive], [p1, p2]), gap, jump) in parts {
            at = Point::new(at.time + gap, at.position + jump);
            let end = Point::new(at.time + duration, to);
            let leave = Point::new(at.time + 0.9 * leave * duration, p1);
            let arrive = Point::new(at.time + (0.1 + 0.9 * arrive) * duration, p2);
            segments.push(Segment::new([at, leave, arrive, end]).unwrap());
            at = end;
        }
        segments
    })
}

fn axis(segments: &[Segment]) -> Axis<'_> {
    Axis::new(segments, "degrees").unwrap()
}

fn rate() -> impl Strategy<Value = FrameRate> {
    let usual = prop::sample::select(vec!["24", "25", "23.976", "24000/1001", "30000/1001", "60", "1000"]);
    prop_oneof![
        usual.prop_map(|text| text.parse().unwrap()),
        (1_u32..500, 1_u32..20).prop_map(|(frames, seconds)| FrameRate::new(frames, seconds).unwrap()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// The segment that has started last counts, in a batch, with a cursor, and for a single time.
    #[test]
    fn batches_agree_with_single_times(segments in chain(1..12, true), mut parts in prop::collection::vec(-0.1..1.1, 1..90), sorted: bool) {
        let axis = axis(&segments);
        if sorted {
            parts.sort_by(f64::total_cmp);
        }
        let mut times: Vec<f64> = parts.iter().map(|part| axis.start() + part * axis.duration()).collect();
        times.extend(segments.iter().flat_map(|segment| [segment.start(), segment.end()]));
        let (mut out, mut motions) = (vec![f64::NAN; times.len()], vec![Motion::default(); times.len()]);
        axis.sample(&times, &mut out);
        axis.sample_motion(&times, &mut motions);
        let mut cursor = axis.cursor();
        for ((&time, batch), motion) in times.iter().zip(out).zip(motions) {
            let started = segments.iter().rev().find(|segment| segment.start() <= time).unwrap_or(&segments[0]);
            let expected = started.at(time);
            prop_assert_eq!(axis.at(time), expected);
            prop_assert_eq!(axis.position(time), expected.position);
            prop_assert_eq!(&segments[axis.index(time)], started);
            // Coordinates are at most 100, and a cursor is right within 1e-13 of that.
            for position in [batch, motion.position, cursor.position(time)] {
                prop_assert!((position - expected.position).abs() <= 1e-11, "{position} {expected:?} at {time}");
            }
            prop_assert_eq!(cursor.index(), axis.index(time));
            prop_assert_eq!(motion.velocity.is_some(), expected.velocity.is_some());
        }
    }

    #[test]
    fn the_shorter_slice_limits_the_results(segments in chain(1..5, true), times in 0_usize..40, room in 0_usize..40) {
        let axis = axis(&segments);
        let mut out = vec![999.0; room];
        axis.sample(&vec![axis.end(); times], &mut out);
        let written = times.min(room);
        prop_assert!(out[..written].iter().all(|&position| position == axis.position(axis.end())));
        prop_assert!(out[written..].iter().all(|&position| position == 999.0));
    }

    #[test]
    fn no_motion_is_beyond_range_and_peaks(segments in chain(1..6, true), part in 0.0..1.0) {
        let axis = axis(&segments);
        let motion = axis.at(axis.start() + part * axis.duration());
        let range = axis.range();
        prop_assert!(range.from - 1e-11 <= motion.position && motion.position <= range.to + 1e-11);
        let peak = axis.peak_velocity();
        match (peak.value, motion.velocity) {
            (Some(most), Some(velocity)) => prop_assert!(velocity.abs() <= most * (1.0 + 1e-6) + 1e-9),
            (Some(_), None) => prop_assert!(false, "velocity has no limit, but its peak has one"),
            (None, _) => {}
        }
        prop_assert_eq!(segments[peak.segment].peak_velocity(), peak.value);
        let peak = axis.peak_acceleration();
        prop_assert_eq!(segments[peak.segment].peak_acceleration(), peak.value);
    }

    /// The frames within a length have times within it, and one more frame covers its end.
    #[test]
    fn frames_are_counted_by_their_times(start in -10.0..10.0, length in 0.0..100.0, rate in rate(), number in 0_u32..100_000) {
        let frames = FrameTimes::within(start, start + length, rate).unwrap();
        prop_assert!(frames.count >= 1 && frames.time(frames.count - 1) <= start + length);
        prop_assert!(frames.time(frames.count) > start + length);
        let covering = FrameTimes::covering(start, start + length, rate).unwrap();
        prop_assert!(covering.time(covering.count - 1) >= start + length);
        prop_assert!(covering.count == 1 || covering.time(covering.count - 2) < start + length);
        // A length that ends at a frame includes that frame, in spite of rounding.
        for make in [FrameTimes::within, FrameTimes::covering] {
            prop_assert_eq!(make(start, frames.time(number), rate).unwrap().count, number + 1);
        }
    }

    /// Errors do not add up, because each time is a quotient of integers, rounded once.
    #[test]
    fn frame_times_are_exact(frame: u32, rate in rate()) {
        let (frames, seconds) = rate.fraction();
        let (frames, product) = (u128::from(frames), u128::from(frame) * u128::from(seconds));
        let time = rate.seconds(frame);
        // Multiplied by a power of two it is whole, so both sides can be compared as integers.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole, and at most 2^127")]
        let scaled = (time * 2_f64.powi(60)) as u128;
        let error = (scaled * frames).abs_diff(product << 60);
        // Half a unit in the last place, of 53 binary digits.
        prop_assert!(error <= (product << 60) >> 53, "{time}");
    }

    #[test]
    fn frames_have_the_positions_of_their_times(segments in chain(1..5, true), rate in rate(), first in 0_u32..200, room in 0_usize..300) {
        let axis = axis(&segments);
        let frames = FrameTimes::covering(axis.start(), axis.end(), rate).unwrap();
        let positions: Vec<f64> = axis.positions(frames).collect();
        let times: Vec<f64> = frames.times().collect();
        prop_assert_eq!((positions.len(), times.len()), (frames.count as usize, frames.count as usize));
        for (&position, &time) in positions.iter().zip(&times) {
            prop_assert!((position - axis.position(time)).abs() <= 1e-11);
        }
        prop_assert!((positions.last().unwrap() - axis.position(axis.end())).abs() <= 1e-11, "the end is reached");

        let mut out = vec![999.0; room];
        let written = axis.sample_frames(frames, first, &mut out);
        let expected = positions.get(first as usize..).unwrap_or_default();
        prop_assert_eq!(written, expected.len().min(room));
        for (one, other) in out.iter().zip(expected) {
            prop_assert!((one - other).abs() <= 1e-11);
        }
        prop_assert!(out[written..].iter().all(|&position| position == 999.0));
    }

    #[test]
    fn steps_are_within_half_a_step(position in -1e6_f64..1e6, per_unit in prop_oneof![0.01..2e3, -2e3..-0.01], offset in -1e6..1e6) {
        let scale = StepScale::new(per_unit, offset).unwrap();
        let exact = position * per_unit + offset;
        match scale.steps(position) {
            Ok(steps) => {
                prop_assert!((f64::from(steps) - exact).abs() <= 0.5);
                prop_assert_eq!(scale.steps(scale.position(steps)), Ok(steps));
            }
            Err(StepsOutOfRange { steps }) => prop_assert!(steps == exact && exact.abs() > f64::from(i32::MAX)),
        }
    }

    /// The steps are the same in a slice, from the iterator, and for a single frame; an error names the first frame
    /// that does not fit.
    #[test]
    fn slices_and_single_frames_have_the_same_steps(segments in chain(1..5, true), rate in rate(), first in 0_u32..200, room in 0_usize..300, large: bool) {
        let axis = axis(&segments);
        let frames = FrameTimes::within(axis.start(), axis.end(), rate).unwrap();
        let per_unit = if large { 5e7 } else { 100.0 };
        let scale = StepScale::new(per_unit, 0.5).unwrap();
        let singles: Vec<Result<i32, StepsError>> = axis.steps(frames, scale).collect();
        prop_assert_eq!(singles.len(), frames.count as usize);
        for (frame, single) in (0..).zip(&singles) {
            let exact = axis.position(frames.time(frame)) * per_unit + 0.5;
            match *single {
                Ok(steps) => prop_assert!((f64::from(steps) - exact).abs() <= 0.5),
                Err(error) => {
                    prop_assert_eq!(error, StepsError { frame, time: frames.time(frame), steps: exact });
                    prop_assert!(exact.abs() > f64::from(i32::MAX));
                }
            }
        }
        let mut out = vec![7; room];
        let written = axis.sample_steps(frames, first, scale, &mut out);
        let expected: Result<Vec<i32>, StepsError> = singles.into_iter().skip(first as usize).take(room).collect();
        prop_assert_eq!(written, expected.as_ref().map(Vec::len).map_err(|error| *error));
        if let Ok(expected) = expected {
            prop_assert_eq!(&out[..expected.len()], expected);
            prop_assert!(out[written.unwrap()..].iter().all(|&steps| steps == 7));
        }
    }

    #[test]
    fn a_map_and_its_inverse_give_the_value_back(
        from in (-1e3_f64..1e3, prop_oneof![0.1_f64..1e3, -1e3_f64..-0.1]),
        to in (-1e3_f64..1e3, prop_oneof![0.1_f64..1e3, -1e3_f64..-0.1]),
        part in -0.5_f64..1.5,
    ) {
        let range = |(from, width): (f64, f64)| Range::new(from, from + width);
        let straight: f64 = to.0 + part * to.1;
        let map = Map::new(range(from), range(to)).unwrap();
        prop_assert_eq!((map.apply(range(from).from), map.apply(range(from).to)), (range(to).from, range(to).to));
        let value = from.0 + part * from.1;
        let bound = 1e-12 * (1.0 + (from.1 / to.1).abs());
        prop_assert!((map.inverse().unwrap().apply(map.apply(value)) - value).abs() <= bound * 1e3);
        prop_assert!((map.apply(value) - straight).abs() <= 1e-12 * (1e3 + 1e3 * (to.1 / from.1).abs()));
    }

    /// A mapped curve has the mapped positions at the mapped times.
    #[test]
    fn mapped_segments_have_mapped_positions(segments in chain(1..2, false), part in 0.0..1.0, seconds in 0.1..1e3, turns in prop_oneof![0.1_f64..1e3, -1e3_f64..-0.1]) {
        let segment = segments[0];
        let time = Map::new(Range::new(segment.start(), segment.end()), Range::new(0.0, seconds)).unwrap();
        let position = Map::new(Range::new(-100.0, 100.0), Range::new(0.0, turns)).unwrap();
        let mapped = segment.mapped(&time, &position).unwrap();
        prop_assert_eq!((mapped.start(), mapped.end()), (0.0, seconds));
        let at = segment.start() + part * segment.duration();
        // At a vertical tangent, a rounded time gives another position.
        let slope = segment.at(at).velocity.map_or(f64::INFINITY, f64::abs);
        let expected = position.apply(segment.position(at));
        if slope <= 1e4 {
            prop_assert!((mapped.position(time.apply(at)) - expected).abs() <= turns.abs() * 1e-9);
        }
    }

    /// Joints are found at each jump of position and each gap, and nowhere else.
    #[test]
    fn joints_are_found(segments in chain(1..10, true)) {
        let axis = axis(&segments);
        let joints: Vec<Joint> = axis.joints(Tolerance::ignoring_velocity(1e-4)).collect();
        let made: Vec<usize> = (1..segments.len())
            .filter(|&i| {
                let (last, first) = (segments[i - 1].points()[3], segments[i].points()[0]);
                first.time - last.time > 1e-4 || (first.position - last.position).abs() > 1e-4
            })
            .collect();
        prop_assert_eq!(joints.iter().map(|joint| joint.index).collect::<Vec<_>>(), made);
        for joint in joints {
            prop_assert_eq!(joint.time, segments[joint.index].start());
            prop_assert_eq!(joint.gap, joint.time - segments[joint.index - 1].end());
        }
    }

    /// A smooth curve stays smooth when it is split where the tangent is not vertical.
    #[test]
    fn splitting_makes_no_joint(p1 in -10.0..10.0, p2 in -10.0..10.0, part in 0.1..0.9) {
        let points = [(0.0, 0.0), (1.0, p1), (2.0, p2), (3.0, 1.0)].map(|(time, position)| Point::new(time, position));
        let (left, right) = Segment::new(points).unwrap().split(3.0 * part).unwrap();
        let segments = [left, right];
        let mut joints = axis(&segments).joints(Tolerance::all(1e-9));
        prop_assert!(!joints.any(|joint| joint.index == 1));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// No sample is farther away than the bound. The value is the distance at its time, and is close to the bound.
    #[test]
    fn distance_bounds_every_sample(one in chain(1..4, true), other in chain(1..4, true), parts in prop::collection::vec(0.0..=1.0, 50)) {
        let (one, other) = (axis(&one), axis(&other));
        let tolerance = 1e-3;
        let Some(found) = one.distance(&other, tolerance) else {
            prop_assert!(one.end() < other.start() || other.end() < one.start());
            return Ok(());
        };
        let (start, end) = (one.start().max(other.start()), one.end().min(other.end()));
        let apart = |time: f64| (one.position(time) - other.position(time)).abs();
        for part in parts {
            let time = start + part * (end - start);
            prop_assert!(apart(time) <= found.bound + 1e-10, "{} at {time}, {found:?}", apart(time));
        }
        prop_assert!(start <= found.time && found.time <= end && found.value <= found.bound);
        prop_assert!(found.bound <= found.value + tolerance, "{found:?}");
        // The distance is found at the time of the value, or just before it if an axis jumps.
        let before = f64::from_bits(if found.time > 0.0 { found.time.to_bits() - 1 } else { found.time.to_bits() + 1 });
        let near = [found.time, before].map(|time| (apart(time) - found.value).abs());
        let steep = one.at(before).velocity.is_none() || other.at(before).velocity.is_none();
        prop_assert!(steep || near[0] <= 1e-6 || near[1] <= 1e-3, "{near:?} {found:?}");
    }

    #[test]
    fn a_moved_axis_has_the_distance_that_it_was_moved(segments in chain(1..4, true), shift in prop_oneof![-50.0..-1.0, 1.0..50.0]) {
        let still = axis(&segments).distance(&axis(&segments), 1e-3).unwrap();
        prop_assert!(still.value == 0.0 && still.bound <= 1e-3 + 1e-10, "{still:?}");
        let map = Map::new(Range::UNIT, Range::new(shift, 1.0 + shift)).unwrap();
        let same = Map::new(Range::UNIT, Range::UNIT).unwrap();
        let moved: Vec<Segment> = segments.iter().map(|segment| segment.mapped(&same, &map).unwrap()).collect();
        let apart = axis(&segments).distance(&axis(&moved), 1e-3).unwrap();
        prop_assert!((apart.value - shift.abs()).abs() <= 1e-10 && apart.bound <= apart.value + 1e-3 + 1e-10, "{apart:?}");
        let back = axis(&moved).distance(&axis(&segments), 1e-3).unwrap();
        prop_assert!((back.value - apart.value).abs() <= 1e-10);
    }
}
