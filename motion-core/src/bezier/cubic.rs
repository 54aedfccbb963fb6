//! A coordinate of a segment as a cubic polynomial, and the solution of the time polynomial.

use super::double::Double;

/// The polynomial `a u³ + b u² + c u`: a coordinate, measured from the end point where `u` is 0.
#[derive(Clone, Copy)]
pub(super) struct Cubic {
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) c: f64,
}

impl Cubic {
    /// The polynomial from the differences of the other three control points to the first one.
    pub(super) fn new([first, second, third]: [f64; 3]) -> Self {
        Self { a: third - 3.0 * (second - first), b: 3.0 * (second - 2.0 * first), c: 3.0 * first }
    }

    /// The polynomial measured from its point at one half, and the value there, from the same differences.
    pub(super) fn middle([first, second, third]: [f64; 3]) -> (Self, f64) {
        let between = second - first;
        let (a, b, c) = (third - 3.0 * between, 1.5 * ((third - second) - first), 0.75 * (third + between));
        (Self { a, b, c }, 0.375 * (first + second) + 0.125 * third)
    }

    #[inline]
    pub(super) fn value(&self, u: f64) -> f64 {
        ((self.a * u + self.b) * u + self.c) * u
    }

    #[inline]
    pub(super) fn slope(&self, u: f64) -> f64 {
        (3.0 * self.a * u + 2.0 * self.b) * u + self.c
    }

    /// Half the second derivative.
    #[inline]
    pub(super) fn bend(&self, u: f64) -> f64 {
        3.0 * self.a * u + self.b
    }

    /// Value, slope and half the second derivative, in fewer operations than one by one.
    #[inline]
    pub(super) fn derivatives(&self, u: f64) -> [f64; 3] {
        let first = self.a * u;
        let second = first + self.b;
        let third = second * u + self.c;
        let bend = first + second;
        [third * u, bend * u + third, first + bend]
    }

    /// The same coordinate, measured from the point at `u`.
    #[inline]
    pub(super) fn moved(&self, u: f64) -> Self {
        Self { a: self.a, b: self.bend(u), c: self.slope(u) }
    }

    /// Sum of the absolute values of the terms of [`slope`](Self::slope), to which its rounding error is proportional.
    pub(super) fn slope_size(&self, u: f64) -> f64 {
        (3.0 * self.a.abs() * u + 2.0 * self.b.abs()) * u + self.c.abs()
    }

    /// The parameters of both extrema in order, each moved into 0 to 1.
    pub(super) fn turns(&self) -> [f64; 2] {
        quadratic(3.0 * self.a, 2.0 * self.b, self.c)
    }

    /// The step of Halley's method from `u` towards a value, and the slope at `u`.
    #[inline]
    pub(super) fn halley(&self, u: f64, value: f64) -> (f64, f64) {
        let [at, slope, bend] = self.derivatives(u);
        let off = at - value;
        (off * slope / (slope * slope - off * bend), slope)
    }

    /// The step of Halley's method, which is of third order, from `u` with the residual `off`.
    #[inline]
    fn step(&self, u: f64, off: f64) -> f64 {
        let slope = self.slope(u);
        off * slope / (slope * slope - off * self.bend(u))
    }
}

/// The roots of `a u² + b u + c` in order, each moved into 0 to 1; 0 if a root does not exist.
pub(super) fn quadratic(a: f64, b: f64, c: f64) -> [f64; 2] {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant.is_nan() || discriminant < 0.0 {
        return [0.0; 2];
    }
    // Both roots without cancellation: one is `larger / a`, the other `c / larger`.
    let larger = -0.5 * (b + libm::copysign(libm::sqrt(discriminant), b));
    let inside = |root: f64| if root > 0.0 { root.min(1.0) } else { 0.0 };
    let (one, other) = (inside(larger / a), inside(c / larger));
    [one.min(other), one.max(other)]
}

/// The time coordinate, ready to be solved for the curve parameter.
#[derive(Clone, Copy)]
pub(super) struct Clock {
    pub(super) cubic: Cubic,
    /// The differences of the other three control points to the first one.
    ahead: [Double; 3],
    /// Whether the root farthest from 0 counts, or else the nearest.
    farthest: bool,
}

impl Clock {
    pub(super) fn new(ahead: [Double; 3], farthest: bool) -> Self {
        Self { cubic: Cubic::new(ahead.map(|difference| difference.high)), ahead, farthest }
    }

    /// The parameter at the time `after`, which is between 0 and the whole.
    ///
    /// Searches the stretches between the extrema in the required order, with residuals of twice the digits.
    pub(super) fn solve(&self, after: Double) -> f64 {
        let [turn1, turn2] = self.cubic.turns();
        let mut stretches = [(0.0, turn1), (turn1, turn2), (turn2, 1.0)];
        if self.farthest {
            stretches.reverse();
        }
        let residual = |u| self.residual(u, after);
        stretches
            .into_iter()
            .filter(|(low, high)| low < high)
            .find_map(|(low, high)| search(&self.cubic, residual, low, high))
            // The ends are on both sides of the time, so one stretch contains it.
            .unwrap_or(1.0)
    }

    fn residual(&self, u: f64, after: Double) -> f64 {
        let [first, second, third] = self.ahead;
        let a = third.minus(second.minus(first).times(3.0));
        let b = second.minus(first.times(2.0)).times(3.0);
        let c = first.times(3.0);
        Double::ZERO.plus(a).times(u).plus(b).times(u).plus(c).times(u).minus(after).high
    }
}

/// Slope of time, as a part of its mean, from which on `f64` alone is exact enough.
pub(super) const STEEP: f64 = 1.0 / 16.0;

/// The root of `residual` between `low` and `high`, which are not negative; `None` if it has the same sign at both.
///
/// A step that leaves the bracket, or does not halve the residual, is replaced by bisection of the bits of the bracket.
/// So the search ends after about 130 rounds at most, also at small parameters.
pub(super) fn search(cubic: &Cubic, residual: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> Option<f64> {
    const ROUNDS: usize = 160;
    let (at_low, at_high) = (residual(low), residual(high));
    if at_low == 0.0 || at_high == 0.0 {
        return Some(if at_high == 0.0 { high } else { low });
    }
    let rising = at_high > 0.0;
    if rising == (at_low > 0.0) {
        return None;
    }
    let mut u = 0.5 * (low + high);
    let mut last = f64::INFINITY;
    for _ in 0..ROUNDS {
        let off = residual(u);
        if off == 0.0 {
            break;
        }
        if rising == (off > 0.0) {
            high = u;
        } else {
            low = u;
        }
        let mut next = u - cubic.step(u, off);
        #[expect(clippy::float_cmp, reason = "a step without effect ends the search")]
        if next == u {
            break;
        }
        if !(low < next && next < high && off.abs() <= 0.5 * last) {
            let (from, to) = (low.to_bits(), high.to_bits());
            next = f64::from_bits(from.wrapping_add(to.wrapping_sub(from) >> 1));
            if next <= low {
                break;
            }
        }
        last = off.abs();
        u = next;
    }
    Some(u)
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "numbers of few digits, where nothing rounds")]
mod tests {
    use super::*;

    /// The polynomial `4 u³ - 6 u² + 3 u`, whose slope is 0 at one half.
    const STILL: Cubic = Cubic { a: 4.0, b: -6.0, c: 3.0 };

    #[test]
    fn a_polynomial_is_made_from_control_points() {
        let Cubic { a, b, c } = Cubic::new([1.0, 0.0, 1.0]);
        assert_eq!((a, b, c), (STILL.a, STILL.b, STILL.c));
        assert_eq!([0.0, 0.5, 1.0].map(|u| STILL.value(u)), [0.0, 0.5, 1.0]);
        assert_eq!([0.0, 0.5, 1.0].map(|u| STILL.slope(u)), [3.0, 0.0, 3.0]);
        assert_eq!([0.0, 0.5, 1.0].map(|u| STILL.bend(u)), [-6.0, 0.0, 6.0]);
    }

    #[test]
    fn derivatives_agree_with_single_values_and_with_a_moved_origin() {
        for u in [-0.5, 0.0, 0.25, 0.75, 1.0] {
            assert_eq!(STILL.derivatives(u), [STILL.value(u), STILL.slope(u), STILL.bend(u)]);
            let moved = STILL.moved(u);
            assert_eq!(moved.value(0.5), STILL.value(u + 0.5) - STILL.value(u));
            assert_eq!(moved.slope(0.5), STILL.slope(u + 0.5));
        }
    }

    #[test]
    fn quadratics_have_the_right_roots() {
        assert_eq!(quadratic(1.0, -0.75, 0.125), [0.25, 0.5]);
        assert_eq!(quadratic(-1.0, 0.75, -0.125), [0.25, 0.5]);
        assert_eq!(quadratic(0.0, 2.0, -1.0), [0.0, 0.5]);
        assert_eq!(quadratic(1.0, 0.0, 1.0), [0.0, 0.0]);
        assert_eq!(quadratic(1.0, -4.5, 2.0), [0.5, 1.0]);
        // A small root keeps its digits next to a large one.
        let [small, large] = quadratic(1.0, -1.0, 1e-20);
        assert_eq!((small, large), (1e-20, 1.0));
    }

    #[test]
    fn the_search_finds_a_root_or_none() {
        let line = Cubic { a: 0.0, b: 0.0, c: 2.0 };
        let find = |target: f64| search(&line, |u| line.value(u) - target, 0.0, 1.0);
        assert_eq!([0.0, 0.5, 1e-30, 2.0].map(find), [Some(0.0), Some(0.25), Some(5e-31), Some(1.0)]);
        assert_eq!([-1.0, 3.0].map(find), [None, None]);
        // Newton's method alone would not converge where the slope is 0.
        let found = search(&STILL, |u| STILL.value(u) - 0.5, 0.0, 0.9).unwrap();
        assert!((found - 0.5).abs() < 1e-5, "{found}");
    }

    #[test]
    fn the_nearest_and_the_farthest_root_of_a_fold_are_found() {
        // Time runs to 0.52 and back to 0.48: three parameters belong to one half, and the outer two are found.
        let ahead = [1.2, -0.2, 1.0].map(|time| Double::difference(time, 0.0));
        let found = [false, true].map(|farthest| Clock::new(ahead, farthest).solve(Double::difference(0.5, 0.0)));
        let [nearest, farthest] = found;
        assert!(nearest < 0.4 && farthest > 0.6 && (nearest + farthest - 1.0).abs() < 1e-15, "{found:?}");
    }
}
