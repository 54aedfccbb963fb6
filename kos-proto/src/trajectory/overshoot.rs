//! Positions of a curve outside the range of its motor (decision K-J8).
//!
//! The search counts with integers. A device without a unit for f64 would need 5 kB of code for the roots of the curve.

use super::values::Points;

/// Bits after the point of a position.
const BITS: u32 = 40;
/// Number of times that a curve is halved at most. Then it differs from its hull by less than rounding.
const HALVES: u8 = 16;

/// Position of a curve farthest outside the range, if it is outside by more than rounding.
///
/// A curve that is outside by more than `f32::EPSILON` is always found. One that is outside by slightly less may be found. No curve
/// is found of which a number is NaN or infinite.
pub(super) fn outside(points: &Points) -> Option<f32> {
    if !points.0.iter().all(|point| point.time.0.is_finite() && point.position.0.is_finite()) {
        return None;
    }
    let positions = points.0.map(|point| point.position.0);
    // The curve stays within the hull of its points.
    if positions.iter().all(|position| (0.0..=1.0).contains(position)) {
        return None;
    }
    // The greatest number of the curve is less than 2^(BITS + 1) units, so that the sum of two fits.
    let top = positions.iter().fold(1.0_f32, |top, position| top.max(position.abs()));
    let exponent = top.to_bits() >> (f32::MANTISSA_DIGITS - 1);
    let unit = f32::from_bits((254 + BITS).saturating_sub(exponent) << (f32::MANTISSA_DIGITS - 1));
    #[expect(clippy::cast_possible_truncation, reason = "the parts that are cut off are less than rounding")]
    let count = |number: f32| (number * unit) as i64;
    let (positions, one, rounding) = (positions.map(count), count(1.0), count(f32::EPSILON));
    // Halves are rounded down, some 50 units in total.
    let tolerance = rounding / 64;
    let above = highest(positions, tolerance, i64::MIN, HALVES).saturating_sub(one);
    let below = highest(positions.map(i64::wrapping_neg), tolerance, i64::MIN, HALVES);
    let (farthest, by) = if below > above { (below.wrapping_neg(), below) } else { (above.saturating_add(one), above) };
    #[expect(clippy::cast_precision_loss, reason = "only shown")]
    let shown = farthest as f32 / unit;
    (by > rounding.saturating_sub(tolerance)).then_some(shown)
}

/// Greatest number of a curve and `most`. It may be too great by `tolerance`, but never too small.
fn highest(curve: [i64; 4], tolerance: i64, most: i64, halves: u8) -> i64 {
    let [begin, out, into, end] = curve;
    let (most, hull) = (most.max(begin).max(end), out.max(into));
    if hull <= most.saturating_add(tolerance) || halves == 0 {
        return most.max(hull);
    }
    let half = |one: i64, other: i64| one.wrapping_add(other) >> 1;
    let (left, middle, right) = (half(begin, out), half(out, into), half(into, end));
    let (before, after) = (half(left, middle), half(middle, right));
    let at = half(before, after);
    let halves = halves.saturating_sub(1);
    let most = highest([begin, left, before, at], tolerance, most, halves);
    highest([at, after, right, end], tolerance, most, halves)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::trajectory::Point;
    use crate::trajectory::error::Amount;

    fn points(positions: [f32; 4]) -> Points {
        let times = [0.0, 0.25, 0.75, 1.0];
        let mut at = times.into_iter().zip(positions).map(|(time, position)| Point::new(time, position));
        Points(core::array::from_fn(|_| at.next().unwrap()))
    }

    /// Range of the curve, from the roots of its slope.
    fn exact(positions: [f32; 4]) -> (f64, f64) {
        points(positions).curve().unwrap().range()
    }

    /// Position inside the range, or handle that may be far outside.
    fn position(far: f32) -> impl Strategy<Value = f32> {
        let near =
            prop::sample::select(std::vec![0.0, 1.0, 1.0 + f32::EPSILON, -f32::EPSILON, 0.5, 4.0 / 3.0, -1.0 / 3.0]);
        prop_oneof![2 => -far..far, 2 => -1.0..2.0_f32, 1 => 0.0..=1.0_f32, 1 => near]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4_000))]

        #[test]
        fn each_curve_outside_the_range_is_found_and_no_curve_that_is_clearly_inside(
            begin in 0.0..=1.0_f32, end in 0.0..=1.0_f32, out in position(9.0), into in position(9.0),
        ) {
            let positions = [begin, out, into, end];
            let (least, most) = exact(positions);
            let by = (-least).max(most - 1.0);
            let found = outside(&points(positions));
            prop_assert!(found.is_some() || by <= f64::from(f32::EPSILON), "{positions:?} is outside by {by:e}");
            prop_assert!(found.is_none() || by > f64::from(f32::EPSILON) * 0.95, "{positions:?} is outside by {by:e}");
            if let Some(found) = found {
                let near = [least, most].map(|end| (f64::from(found) - end).abs() < 2e-6);
                prop_assert!(near.contains(&true), "{found} is not {least} or {most}");
            }
        }

        /// The handles are moved until the curve touches the end of the range.
        #[test]
        fn curves_that_touch_the_end_of_the_range_have_the_right_verdict(
            begin in 0.0..=1.0_f32, end in 0.0..=1.0_f32, out in 1.0..3.0_f32, into in position(3.0), ulps in -3..=3_i32,
        ) {
            let (_, most) = exact([begin, out, into, end]);
            // A curve is stretched about its begin, so that its greatest position is near 1.
            let stretch = (1.0 - f64::from(begin)) / (most - f64::from(begin)).max(1e-9);
            let stretched = |position: f32| Amount::shown(f64::from(begin) + (f64::from(position) - f64::from(begin)) * stretch).0;
            let out = f32::from_bits(stretched(out).to_bits().wrapping_add_signed(ulps));
            let positions = [begin, out, stretched(into), stretched(end)];
            let (least, most) = exact(positions);
            let by = (-least).max(most - 1.0);
            let found = outside(&points(positions));
            prop_assert!(found.is_some() || by <= f64::from(f32::EPSILON), "{positions:?} is outside by {by:e}");
            prop_assert!(found.is_none() || by > f64::from(f32::EPSILON) * 0.95, "{positions:?} is outside by {by:e}");
        }

        #[test]
        fn handles_of_any_size_are_outside_as_far_as_they_are(begin in 0.0..=1.0_f32, end in 0.0..=1.0_f32, bits in any::<[u32; 2]>()) {
            let [out, into] = bits.map(f32::from_bits);
            let positions = [begin, out, into, end];
            let found = outside(&points(positions));
            if !(out.is_finite() && into.is_finite()) {
                prop_assert_eq!(found, None);
                return Ok(());
            }
            let (least, most) = exact(positions);
            let by = (-least).max(most - 1.0);
            prop_assert!(found.is_some() || by <= f64::from(f32::EPSILON), "{positions:?} is outside by {by:e}");
            let far = found.map_or(0.0, |found| f64::from(found.abs()));
            prop_assert!(by < 2.0 || (far / by.max(most) - 1.0).abs() < 1e-3, "{far} is not {by}");
        }
    }

    #[test]
    fn a_curve_that_overshoots_says_how_far() {
        // Its slope is 0 at a half: 0.75 * 1.4.
        let found = outside(&points([0.0, 1.4, 1.4, 0.0])).unwrap();
        assert!((found - 1.05).abs() < 1e-6, "{found}");
        let found = outside(&points([1.0, -0.4, -0.4, 1.0])).unwrap();
        assert!((found + 0.05).abs() < 1e-6, "{found}");
        assert_eq!(outside(&points([0.0, 4.0 / 3.0, 4.0 / 3.0, 0.0])), None);
        assert_eq!(outside(&points([0.0, 0.0, 1.0, 1.0])), None);
    }
}
