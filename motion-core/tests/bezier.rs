//! Bezier segments: their accuracy compared with a reference of twice the digits, and the laws of the module.

#![expect(clippy::float_cmp, reason = "what is exact by law is compared exactly")]
#![expect(clippy::many_single_char_names, reason = "control points and parameters, as the formulas have them")]

use motion_core::bezier::{Cursor, Ease, Key, Motion, OutOfRange, Point, Segment, Table};
use proptest::prelude::*;

/// Double-double numbers with fused multiplication, independent of the library.
#[derive(Clone, Copy)]
struct Wide(f64, f64);

impl Wide {
    fn two(a: f64, b: f64) -> Self {
        let sum = a + b;
        let part = sum - a;
        Self(sum, (a - (sum - part)) + (b - part))
    }

    fn add(self, other: Self) -> Self {
        let (high, low) = (Self::two(self.0, other.0), Self::two(self.1, other.1));
        let once = Self::two(high.0, high.1 + low.0);
        Self::two(once.0, once.1 + low.1)
    }

    fn mul(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let rest = self.0.mul_add(other.0, -product) + (self.0 * other.1 + self.1 * other.0);
        Self::two(product, rest)
    }

    fn of(value: f64) -> Self {
        Self(value, 0.0)
    }

    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

/// Value, first and second derivative of one coordinate at a parameter, by Bernstein polynomials.
fn bernstein(p: [f64; 4], u: Wide) -> [Wide; 3] {
    let w = Wide::of(1.0).add(u.neg());
    let mix = |a: Wide, b: Wide| a.mul(w).add(b.mul(u));
    let [a, b, c, d] = p.map(Wide::of);
    let value = mix(mix(mix(a, b), mix(b, c)), mix(mix(b, c), mix(c, d)));
    let step = |a: Wide, b: Wide| b.add(a.neg());
    let (ab, bc, cd) = (step(a, b), step(b, c), step(c, d));
    let first = mix(mix(ab, bc), mix(bc, cd)).mul(Wide::of(3.0));
    let second = mix(step(ab, bc), step(bc, cd)).mul(Wide::of(6.0));
    [value, first, second]
}

fn times(segment: &Segment) -> [f64; 4] {
    segment.points().map(|point| point.time)
}

fn positions(segment: &Segment) -> [f64; 4] {
    segment.points().map(|point| point.position)
}

/// The parameter at a time by bisection, for a segment whose time does not fold.
fn reference(segment: &Segment, time: f64) -> Wide {
    let (mut low, mut step) = (Wide::of(0.0), 1.0);
    for _ in 0..106 {
        step *= 0.5;
        let middle = low.add(Wide::of(step));
        let off = bernstein(times(segment), middle)[0].add(Wide::of(-time));
        if off.0 < 0.0 {
            low = middle;
        }
    }
    low
}

/// Greatest errors over many segments and times.
#[derive(Debug, Default)]
struct Errors {
    backward: f64,
    position: f64,
    velocity: f64,
    acceleration: f64,
}

/// Random numbers from 0 to 1, from a fixed seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        // 52 random digits after the 1, minus the 1.
        f64::from_bits(1.0_f64.to_bits() | (self.0 >> 12)) - 1.0
    }

    /// A time that is mostly anywhere in 0 to 1, and otherwise very close to an end or to the middle.
    fn time(&mut self) -> f64 {
        let (kind, value) = (self.next(), self.next());
        let tiny = 0.1_f64.powf(20.0 * value);
        match kind {
            k if k < 0.7 => value,
            k if k < 0.8 => tiny,
            k if k < 0.9 => 1.0 - tiny,
            k if k < 0.95 => 0.5 + 0.5 * tiny,
            _ => 0.5 - 0.5 * tiny,
        }
    }
}

fn unit(x1: f64, y1: f64, x2: f64, y2: f64) -> Segment {
    Segment::new([Point::ZERO, Point::new(x1, y1), Point::new(x2, y2), Point::new(1.0, 1.0)]).unwrap()
}

/// The greatest errors of single times and of tables, for segments of duration 1.
fn measure(count: usize, mut make: impl FnMut(&mut Random) -> Segment) -> Errors {
    let mut random = Random(7);
    let mut errors = Errors::default();
    for _ in 0..count {
        let segment = make(&mut random);
        let table = Table::new(segment);
        let largest = segment.end();
        for _ in 0..20 {
            let time = segment.start() + random.time();
            let u = reference(&segment, time);
            let [_, slope, bend] = bernstein(times(&segment), u).map(|wide| wide.0);
            let [position, rise, curl] = bernstein(positions(&segment), u);
            // Errors of rates are scaled by the digits that rates lose where time runs slower than on average.
            let velocity = rise.0 / slope;
            let acceleration = (curl.0 - velocity * bend) / slope / slope;
            let slow = (1.0 / slope).max(1.0);
            assert_eq!(segment.at(time).position, segment.position(time));
            assert_eq!(table.at(time).position, table.position(time));
            for (parameter, motion) in
                [(segment.parameter(time), segment.at(time)), (table.parameter(time), table.at(time))]
            {
                let found = bernstein(times(&segment), Wide::of(parameter))[0];
                errors.backward = errors.backward.max(found.add(Wide::of(-time)).0.abs() / largest);
                errors.position = errors.position.max((motion.position - position.0).abs() / largest);
                if slope > 1e-6 {
                    let (v, a) = (motion.velocity.unwrap(), motion.acceleration.unwrap());
                    errors.velocity = errors.velocity.max((v - velocity).abs() / largest / slow.powi(3));
                    errors.acceleration = errors.acceleration.max((a - acceleration).abs() / largest / slow.powi(5));
                }
            }
        }
    }
    println!("{errors:?}");
    errors
}

fn check(errors: &Errors, position: f64) {
    assert!(errors.backward <= 1e-15, "{errors:?}");
    assert!(errors.position <= position, "{errors:?}");
    assert!(errors.velocity <= 1e-14, "{errors:?}");
    assert!(errors.acceleration <= 1e-13, "{errors:?}");
}

#[test]
fn accuracy_of_typical_handles() {
    check(
        &measure(600, |r| {
            let [x1, y1, x2, y2] = [(); 4].map(|()| 0.15 + 0.7 * r.next());
            unit(x1, y1, x2, y2)
        }),
        1e-14,
    );
}

#[test]
fn accuracy_of_any_handles() {
    check(
        &measure(600, |r| {
            let [x1, y1, x2, y2] = [(); 4].map(|()| r.next());
            unit(x1, y1, x2, y2)
        }),
        1e-13,
    );
}

#[test]
fn accuracy_far_from_time_0() {
    check(
        &measure(600, |r| {
            let [start, x1, y1, x2, y2] = [(); 5].map(|()| r.next());
            let (start, at) = (100.0 * start, Point::new);
            let times = [start, start + x1, start + x2, start + 1.0];
            let [p0, p1, p2, p3] = times.map(|time| at(time, 0.0));
            Segment::new([p0, at(p1.time, y1), at(p2.time, y2), at(p3.time, 1.0)]).unwrap()
        }),
        1e-13,
    );
}

#[test]
fn accuracy_at_vertical_tangents() {
    check(
        &measure(600, |r| {
            let (y1, y2, kind) = (r.next(), r.next(), r.next());
            let near = if r.next() < 0.5 { 0.0 } else { 0.1_f64.powf(3.0 + 14.0 * r.next()) };
            match kind {
                k if k < 0.25 => unit(near, y1, near, y2),
                k if k < 0.5 => unit(1.0 - near, y1, 1.0, y2),
                k if k < 0.75 => unit(1.0 - near, y1, near, y2),
                _ => unit(near, y1, 1.0 - near, y2),
            }
        }),
        1e-13,
    );
}

#[test]
fn accuracy_with_flat_and_drawn_back_handles() {
    check(
        &measure(600, |r| match r.next() {
            k if k < 0.4 => unit(r.next(), 0.0, r.next(), 1.0),
            k if k < 0.6 => unit(0.0, 0.0, r.next(), r.next()),
            k if k < 0.8 => unit(r.next(), r.next(), 1.0, 1.0),
            _ => unit(0.0, 0.0, 1.0, 1.0),
        }),
        1e-13,
    );
}

/// A batch is as exact as single times, for handles of all kinds and times in any order.
#[test]
fn batches_are_as_exact_as_single_times() {
    let mut random = Random(13);
    let steady: Vec<f64> = (0..=1000).map(|i| f64::from(i) / 1000.0).collect();
    let film: Vec<f64> = (0..=48).map(|i| f64::from(i) / 48.0).collect();
    let mut worst = [0.0_f64; 3];
    for round in 0..400 {
        let [x1, y1, x2, y2] = [(); 4].map(|()| random.next());
        let segment = match round % 5 {
            0 => unit(0.15 + 0.7 * x1, y1, 0.15 + 0.7 * x2, y2),
            1 => unit(x1, y1, x2, y2),
            2 => unit(0.001 * x1, y1, 1.0 - 0.001 * x2, y2),
            3 => unit(1.0 - 0.001 * x1, y1, 0.001 * x2, y2),
            _ => unit(x1, 0.0, x2, 1.0),
        };
        let wild: Vec<f64> = (0..100).map(|_| 1.2 * random.time() - 0.1 * random.next()).collect();
        for times in [&steady, &film, &wild] {
            let (mut out, mut motions) = (vec![f64::NAN; times.len()], vec![Motion::default(); times.len()]);
            Cursor::new(segment).sample(times, &mut out);
            Cursor::new(segment).sample_motion(times, &mut motions);
            let mut cursor = Cursor::new(segment);
            for (i, ((&time, position), motion)) in times.iter().zip(out).zip(motions).enumerate() {
                let (single, moved) = (segment.at(time), cursor.at(time));
                for found in [position, motion.position, moved.position] {
                    worst[0] = worst[0].max((found - single.position).abs());
                }
                for found in [motion, moved] {
                    assert_eq!(found.velocity.is_some(), single.velocity.is_some(), "{segment:?} at {time}");
                    assert_eq!(found.acceleration.is_some(), single.acceleration.is_some());
                    let off = |one: Option<f64>, other: Option<f64>| (one.unwrap_or(0.0) - other.unwrap_or(0.0)).abs();
                    worst[1] = worst[1].max(off(found.velocity, single.velocity));
                    worst[2] = worst[2].max(off(found.acceleration, single.acceleration));
                }
                if i % 50 == round % 50 && (0.0..=1.0).contains(&time) {
                    let right = bernstein(positions(&segment), reference(&segment, time))[0].0;
                    assert!((position - right).abs() <= 1e-13, "{segment:?} at {time}");
                }
            }
        }
    }
    println!("{worst:?}");
    // Batches are solved together where time runs at a sixteenth of its mean or faster. So the errors of single rates
    // are at most 1e-14 times 16³ and 1e-13 times 16⁵.
    assert!(worst[0] <= 1e-13 && worst[1] <= 4e-11 && worst[2] <= 1e-7, "{worst:?}");
}

/// Where time folds, the parameter belongs to the time, and no larger parameter does.
#[test]
fn the_largest_parameter_counts_where_time_folds() {
    let mut random = Random(3);
    let (mut folded, mut worst) = (0, 0.0_f64);
    for _ in 0..600 {
        let [x1, y1, x2, y2] = [(); 4].map(|()| 4.0 * random.next() - 1.5);
        let segment = unit(x1, y1, x2, y2);
        let grid = |u: f64| bernstein(times(&segment), Wide::of(u))[0].0;
        let falls = (0..200).any(|i| grid(f64::from(i) / 200.0) > grid(f64::from(i + 1) / 200.0));
        assert!(!falls || segment.folds(), "{segment:?}");
        folded += usize::from(falls);
        for _ in 0..10 {
            let time = random.time();
            let u = segment.parameter(time);
            worst = worst.max((grid(u) - time).abs());
            let larger = (0..=100).map(|i| u + (1.0 - u) * f64::from(i) / 100.0);
            assert!(larger.into_iter().all(|u| grid(u) >= time - 2e-15), "{segment:?} at {time}");
        }
    }
    println!("{worst:.1e} in {folded} folded segments");
    assert!(folded > 200 && worst <= 1e-15, "{worst:e}");
}

#[test]
fn rates_have_limits_or_are_none_where_time_stands_still() {
    // Vertical tangents at the start, the end and in the middle.
    for (segment, time) in
        [(unit(0.0, 0.5, 0.5, 0.5), 0.0), (unit(0.5, 0.5, 1.0, 0.5), 1.0), (unit(1.0, 0.5, 0.0, 0.5), 0.5)]
    {
        let motion = segment.at(time);
        assert_eq!((motion.velocity, motion.acceleration), (None, None), "{segment:?}");
        assert_eq!(segment.peak_velocity(), None);
    }
    // With both handles at their ends, the motion is that of a straight line.
    let line = unit(0.0, 0.0, 1.0, 1.0);
    for time in [0.0, 1e-9, 0.3, 1.0] {
        let motion = line.at(time);
        assert!((motion.velocity.unwrap() - 1.0).abs() < 1e-12, "{motion:?}");
        assert!(motion.acceleration.unwrap().abs() < 1e-6 || time == 1e-9, "{motion:?}");
    }
    let start = unit(0.0, 0.0, 0.5, 1.0).at(0.0);
    assert_eq!((start.velocity, start.acceleration), (Some(2.0), None));
    // With both handles at the start, velocity is the ratio of the third terms.
    let start = unit(0.0, 0.0, 0.0, 0.0).at(0.0);
    assert_eq!((start.velocity, start.acceleration), (Some(1.0), Some(0.0)));
}

#[test]
fn a_segment_of_duration_0_rests_at_its_last_point() {
    let at = |time, position| Point::new(time, position);
    for end in [1.0, 0.5] {
        let none = Segment::new([at(1.0, 2.0), at(1.0, 3.0), at(4.0, 4.0), at(end, 5.0)]).unwrap();
        for time in [0.0, 0.7, 1.0, 2.0, f64::NAN] {
            assert_eq!(none.at(time), Motion { position: 5.0, velocity: Some(0.0), acceleration: Some(0.0) });
            assert_eq!(Cursor::new(none).position(time), 5.0);
        }
        assert_eq!((none.duration(), none.range(), none.peak_velocity()), (0.0, (5.0, 5.0), Some(0.0)));
        assert_eq!(none.split(1.0), None);
    }
}

#[test]
fn coordinates_out_of_range_are_refused_and_f32_comes_back() {
    for bad in [f64::NAN, f64::INFINITY, -1e76] {
        assert_eq!(Segment::new([Point::ZERO, Point::ZERO, Point::new(0.0, bad), Point::ZERO]), Err(OutOfRange));
        assert_eq!(Segment::new([Point::new(bad, 0.0), Point::ZERO, Point::ZERO, Point::ZERO]), Err(OutOfRange));
    }
    assert_eq!(Segment::from_f32([[0.0, f32::NAN]; 4]), Err(OutOfRange));
    assert_eq!(Segment::new([Point::new(0.0, 1e60); 4]).unwrap().to_f32(), Err(OutOfRange));
    let wire = [[0.0, 0.1], [0.3, f32::MAX], [0.7, -0.2], [1.0, 1e-45]];
    assert_eq!(Segment::from_f32(wire).unwrap().to_f32(), Ok(wire));
}

#[test]
fn a_segment_is_made_between_key_frames() {
    let from = Key { time: 2.0, position: 10.0, arrive: Ease::Linear, leave: Ease::Flat(0.5) };
    let to = Key { time: 4.0, position: 40.0, arrive: Ease::Linear, leave: Ease::Linear };
    let segment = Segment::between(&from, &to).unwrap();
    let expected = [(2.0, 10.0), (3.0, 10.0), (10.0 / 3.0, 30.0), (4.0, 40.0)];
    for (point, (time, position)) in segment.points().into_iter().zip(expected) {
        assert!((point.time - time).abs() < 1e-14 && (point.position - position).abs() < 1e-14, "{point:?}");
    }
    assert_eq!(segment.at(2.0).velocity, Some(0.0));
    assert!((segment.at(4.0).velocity.unwrap() - 15.0).abs() < 1e-12);
    let line = Segment::between(&Key { leave: Ease::Linear, ..from }, &to).unwrap();
    assert!((line.position(2.5) - 17.5).abs() < 1e-13);
    assert!(line.peak_acceleration().unwrap() < 1e-10);
}

#[test]
fn known_curves_have_known_peaks() {
    // x = u, y = 3u² - 2u³: velocity 6u - 6u², acceleration 6 - 12u.
    let smooth = unit(1.0 / 3.0, 0.0, 2.0 / 3.0, 1.0);
    assert!((smooth.peak_velocity().unwrap() - 1.5).abs() < 1e-14);
    assert!((smooth.peak_acceleration().unwrap() - 6.0).abs() < 1e-13);
    assert_eq!(smooth.range(), (0.0, 1.0));
    // With handles beyond the ends, the curve goes beyond the ends by the same distance on both sides.
    let swinging = unit(1.0 / 3.0, 4.0, 2.0 / 3.0, -3.0);
    let (least, most) = swinging.range();
    assert!((least + most - 1.0).abs() < 1e-14 && most > 1.0, "symmetric about the middle: {least} {most}");
    let highest = (0..=10_000).map(|i| swinging.position(f64::from(i) / 1e4));
    assert!((highest.fold(0.0, f64::max) - most).abs() < 1e-7);
}

fn share() -> impl Strategy<Value = f64> {
    prop_oneof![8 => 0.0..=1.0, 1 => Just(0.0), 1 => Just(1.0)]
}

/// Segments of any place and duration whose time does not fold.
fn forwards() -> impl Strategy<Value = Segment> {
    (-100.0..100.0, 0.01..100.0, share(), share(), prop::array::uniform4(-10.0..10.0)).prop_map(
        |(start, length, x1, x2, y)| {
            let [a, b, c, d] = y;
            let at = |part: f64, position| Point::new(start + part * length, position);
            Segment::new([at(0.0, a), at(x1, b), at(x2, c), at(1.0, d)]).unwrap()
        },
    )
}

/// Segments whose time does not run slowly anywhere.
fn steep() -> impl Strategy<Value = Segment> {
    forwards().prop_filter("time runs well", |segment| {
        let [t0, t1, t2, t3] = times(segment).map(|time| (time - segment.start()) / segment.duration());
        t1 - t0 > 0.15 && t3 - t2 > 0.15 && t1 < 0.85 && t2 > 0.15
    })
}

fn anything() -> impl Strategy<Value = Segment> {
    prop::array::uniform8(prop_oneof![any::<f32>().prop_filter("finite", |value| value.is_finite()), -1.0_f32..1.0])
        .prop_map(|[a, b, c, d, e, f, g, h]| Segment::from_f32([[a, b], [c, d], [e, f], [g, h]]).unwrap())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn ends_are_exact(segment in prop_oneof![forwards(), anything()]) {
        let [first, _, _, last] = segment.points();
        let table = Table::new(segment);
        prop_assert_eq!(segment.position(segment.end()), last.position);
        prop_assert_eq!(table.position(segment.end()), last.position);
        if segment.duration() > 0.0 {
            prop_assert_eq!(segment.position(segment.start()), first.position);
            prop_assert_eq!(table.position(segment.start()), first.position);
            let mut out = [0.0; 20];
            Cursor::new(segment).sample(&[segment.end(); 20], &mut out);
            prop_assert_eq!(out, [last.position; 20]);
        }
    }

    #[test]
    fn results_are_never_nan(segment in anything(), time in prop_oneof![any::<f64>(), -1.0..1.0], part in 0.0..1.0) {
        for time in [time, segment.start() + part * segment.duration(), segment.start(), segment.end()] {
            let table = Table::new(segment);
            let motions = [segment.at(time), Cursor::new(segment).at(time), table.at(time)];
            for Motion { position, velocity, acceleration } in motions {
                prop_assert!(position.is_finite());
                prop_assert!(velocity.is_none_or(f64::is_finite) && acceleration.is_none_or(f64::is_finite));
            }
            prop_assert!((0.0..=1.0).contains(&segment.parameter(time)));
            prop_assert!((0.0..=1.0).contains(&table.parameter(time)));
        }
        let (least, most) = segment.range();
        prop_assert!(least <= most);
        for peak in [segment.peak_velocity(), segment.peak_acceleration()] {
            prop_assert!(peak.is_none_or(|peak| peak >= 0.0 && peak.is_finite()));
        }
    }

    /// If position equals time at all control points, position equals time everywhere.
    #[test]
    fn a_curve_with_equal_coordinates_is_its_own_inverse(x1 in share(), x2 in share(), time in 0.0..=1.0) {
        prop_assert!((unit(x1, x1, x2, x2).position(time) - time).abs() <= 1e-15);
    }

    /// For times in any order, a cursor gives the same motion as the segment.
    #[test]
    fn a_cursor_agrees_with_single_times(segment in forwards(), mut parts in prop::collection::vec(-0.1..1.1, 1..70), dense: bool, sorted: bool) {
        if dense {
            for part in &mut parts {
                *part = 0.3 + *part * 0.01;
            }
        }
        if sorted {
            parts.sort_by(f64::total_cmp);
        }
        let times: Vec<f64> = parts.iter().map(|part| segment.start() + part * segment.duration()).collect();
        let (mut out, mut motions) = (vec![f64::NAN; times.len()], vec![Motion::default(); times.len()]);
        let mut cursor = Cursor::new(segment);
        cursor.sample(&times, &mut out);
        cursor.sample_motion(&times, &mut motions);
        for ((time, position), motion) in times.iter().zip(out).zip(motions) {
            let single = segment.at(*time);
            // Coordinates are at most 10 and 200; the slope of position over time is below 16 * 60.
            prop_assert!((position - single.position).abs() <= 1e-11, "{position} {single:?}");
            prop_assert!((motion.position - single.position).abs() <= 1e-11);
            prop_assert_eq!(motion.velocity.is_some(), single.velocity.is_some());
            let moved = Cursor::new(segment).at(*time);
            prop_assert!((moved.position - single.position).abs() <= 1e-11);
        }
    }

    /// A table gives the same motion as the segment, also beside the curve and where time folds.
    #[test]
    fn a_table_agrees_with_single_times(segment in prop_oneof![forwards(), anything()], parts in prop::collection::vec(-0.1..1.1, 1..20)) {
        let table = Table::new(segment);
        let largest = positions(&segment).into_iter().fold(1.0, |most: f64, p| most.max(p.abs()));
        for time in parts.iter().map(|part| segment.start() + part * segment.duration()).chain([f64::NAN, f64::INFINITY]) {
            let (one, other) = (table.at(time), segment.at(time));
            if segment.folds() || !(segment.start() < time && time < segment.end()) {
                prop_assert_eq!(one, other);
            } else {
                prop_assert!((one.position - other.position).abs() <= 1e-13 * largest, "{one:?} {other:?}");
                prop_assert_eq!(one.velocity.is_some(), other.velocity.is_some());
                prop_assert!((table.parameter(time) - segment.parameter(time)).abs() <= 1e-12);
            }
        }
    }

    #[test]
    fn the_shorter_slice_limits_the_results(segment in forwards(), times in 0_usize..40, room in 0_usize..40) {
        let mut out = vec![99.0; room];
        Cursor::new(segment).sample(&vec![segment.end(); times], &mut out);
        let written = times.min(room);
        prop_assert!(out[..written].iter().all(|&position| position == segment.points()[3].position));
        prop_assert!(out[written..].iter().all(|&position| position == 99.0));
    }

    #[test]
    fn splitting_changes_nothing(segment in steep(), at in 0.05..0.95, part in 0.0_f64..=1.0) {
        let time = |part: f64| segment.start() + part * segment.duration();
        let (left, right) = segment.split(time(at)).unwrap();
        prop_assert_eq!(left.position(left.end()), segment.position(time(at)));
        prop_assert_eq!(left.end(), right.start());
        let (time, piece) = (time(part), if part < at { left } else { right });
        prop_assert!((piece.position(time) - segment.position(time)).abs() <= 1e-10);
        let whole = left.join(&right, 1e-9).unwrap();
        prop_assert!((whole.position(time) - segment.position(time)).abs() <= 1e-9);
    }

    #[test]
    fn a_reversed_segment_is_the_reverse_move(segment in prop_oneof![forwards(), anything()], part in 0.0_f64..=1.0) {
        let back = segment.reversed();
        prop_assert_eq!(back.reversed(), segment);
        let time = segment.start() + part * segment.duration();
        if segment.duration() > 0.0 && !segment.folds() {
            let largest = positions(&segment).into_iter().fold(0.0, |most: f64, p| most.max(p.abs()));
            prop_assert!((back.position(-time) - segment.position(time)).abs() <= 1e-13 * largest);
        }
    }

    #[test]
    fn a_segment_comes_back_from_its_keys(segment in forwards()) {
        let (from, to) = segment.keys();
        let again = Segment::between(&from, &to).unwrap();
        for (one, other) in again.points().into_iter().zip(segment.points()) {
            prop_assert!((one.time - other.time).abs() <= 1e-13 && (one.position - other.position).abs() <= 1e-13);
        }
    }

    /// No sample is beyond the peaks, and the greatest sample is close to them.
    #[test]
    fn no_sample_is_beyond_the_peaks(segment in steep()) {
        let samples: Vec<Motion> =
            (0..=2_000).map(|i| segment.at(segment.start() + f64::from(i) / 2e3 * segment.duration())).collect();
        let most = |rate: fn(&Motion) -> f64| samples.iter().map(rate).fold(0.0, f64::max);
        let (least, greatest) = segment.range();
        prop_assert!(samples.iter().all(|m| least - 1e-13 <= m.position && m.position <= greatest + 1e-13));
        let scale = 20.0 / segment.duration();
        let (speed, peak) = (most(|m| m.velocity.unwrap().abs()), segment.peak_velocity().unwrap());
        prop_assert!(speed <= peak + 1e-9 * scale && peak <= speed + 0.01 * scale, "{speed} {peak}");
        let scale = scale / segment.duration();
        let (push, peak) = (most(|m| m.acceleration.unwrap().abs()), segment.peak_acceleration().unwrap());
        prop_assert!(push <= peak + 1e-7 * scale && peak <= push * 1.02 + 0.1 * scale, "{push} {peak}");
    }
}
