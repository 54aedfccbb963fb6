//! One coordinate of a segment as a polynomial, and the curve parameter that belongs to a time.

use super::double::Double;

/// `a u³ + b u² + c u`: a coordinate, measured from the end point where `u` is 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cubic {
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) c: f64,
}

impl Cubic {
    /// From the differences of the other three control points to the first.
    pub(super) fn new([first, second, third]: [f64; 3]) -> Self {
        Self { a: third - 3.0 * (second - first), b: 3.0 * (second - 2.0 * first), c: 3.0 * first }
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

    /// The sizes of the terms of [`slope`](Self::slope) together: what its rounding is measured by.
    pub(super) fn slope_size(&self, u: f64) -> f64 {
        (3.0 * self.a.abs() * u + 2.0 * self.b.abs()) * u + self.c.abs()
    }

    /// Where it turns, in order, moved to the nearest of 0 and 1 if it lies outside.
    pub(super) fn turns(&self) -> [f64; 2] {
        quadratic(3.0 * self.a, 2.0 * self.b, self.c)
    }

    /// The step of Halley's method, of third order, from `u` with the residual `off`.
    #[inline]
    fn step(&self, u: f64, off: f64) -> f64 {
        let slope = self.slope(u);
        off * slope / (slope * slope - off * self.bend(u))
    }
}

/// The roots of `a u² + b u + c` in order, each moved into 0 to 1; 0 where there is none.
pub(super) fn quadratic(a: f64, b: f64, c: f64) -> [f64; 2] {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant.is_nan() || discriminant < 0.0 {
        return [0.0; 2];
    }
    // Both roots without cancellation: the larger over a, and c over the larger.
    let larger = -0.5 * (b + libm::copysign(libm::sqrt(discriminant), b));
    let inside = |root: f64| if root > 0.0 { root.min(1.0) } else { 0.0 };
    let (one, other) = (inside(larger / a), inside(c / larger));
    [one.min(other), one.max(other)]
}

/// The time coordinate, ready to be solved for the curve parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    pub(super) cubic: Cubic,
    /// The differences of the other three control points to the first.
    ahead: [Double; 3],
    /// Whether the parameter is sought that is farthest from 0, or the nearest.
    farthest: bool,
}

impl Clock {
    pub(super) fn new(ahead: [Double; 3], farthest: bool) -> Self {
        Self { cubic: Cubic::new(ahead.map(|difference| difference.high)), ahead, farthest }
    }

    /// The whole time from the first control point to the last.
    pub(super) fn whole(&self) -> f64 {
        let [_, _, whole] = self.ahead;
        whole.high
    }

    /// Whether both handles lie within the segment's time, so that time cannot fold.
    pub(super) fn ordered(&self) -> bool {
        let [first, second, whole] = self.ahead.map(|difference| difference.high);
        first >= 0.0 && first <= whole && second >= 0.0 && second <= whole
    }

    /// The parameter at which the time is `after`, which lies between 0 and the whole.
    pub(super) fn solve(&self, after: Double) -> f64 {
        self.quick(after.high).unwrap_or_else(|| self.exact(after))
    }

    /// A few steps without brackets: taken only where the last was short and time runs well.
    ///
    /// The error behind a step is its cube times the square of `bend / slope`, at most 1e4 here.
    #[inline]
    fn quick(&self, after: f64) -> Option<f64> {
        const STEPS: usize = 6;
        const SHORT: f64 = 1e-7;
        if !self.ordered() {
            return None;
        }
        let whole = self.whole();
        let mut u = after / whole;
        for _ in 0..STEPS {
            let step = self.cubic.step(u, self.cubic.value(u) - after);
            u -= step;
            if step.abs() <= SHORT {
                let good = (0.0..=1.0).contains(&u) && self.cubic.slope(u) >= STEEP * whole;
                return good.then_some(u);
            }
        }
        None
    }

    /// Each stretch between turns in the wanted order, searched with residuals of twice the digits.
    #[cold]
    fn exact(&self, after: Double) -> f64 {
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
            // The ends lie on both sides of the time, so some stretch holds it.
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

/// A slope of time, as part of its mean, from which on `f64` alone is good enough.
pub(super) const STEEP: f64 = 1.0 / 16.0;

/// The root of `residual` between `low` and `high`, not negative; `None` if both have the same sign.
///
/// Steps that leave the bracket, or do not halve the residual, give way to halving the bracket
/// among the floats that exist: so it ends, at small parameters too, after some 130 rounds at most.
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
        #[expect(clippy::float_cmp, reason = "a step that changes nothing ends the search")]
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
