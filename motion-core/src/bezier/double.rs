//! Sums and products with twice the digits of `f64`, for residuals where time hardly changes along the curve.

/// The unevaluated sum of a number and its rounding error.
#[derive(Clone, Copy)]
pub(super) struct Double {
    pub(super) high: f64,
    low: f64,
}

impl Double {
    pub(super) const ZERO: Self = Self { high: 0.0, low: 0.0 };

    /// The exact difference `a - b`.
    pub(super) fn difference(a: f64, b: f64) -> Self {
        Self::sum(a, -b)
    }

    /// The exact sum `a + b`, in any order of size.
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let of_b = high - a;
        Self { high, low: (a - (high - of_b)) + (b - of_b) }
    }

    /// The exact product `a * b`, computed from halves of 26 bits.
    fn product(a: f64, b: f64) -> Self {
        let (high, (a1, a2), (b1, b2)) = (a * b, halves(a), halves(b));
        Self { high, low: ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2 }
    }

    pub(super) fn plus(self, other: Self) -> Self {
        let (high, low) = (Self::sum(self.high, other.high), Self::sum(self.low, other.low));
        let once = Self::sum(high.high, high.low + low.high);
        Self::sum(once.high, once.low + low.low)
    }

    pub(super) fn minus(self, other: Self) -> Self {
        self.plus(Self { high: -other.high, low: -other.low })
    }

    pub(super) fn times(self, factor: f64) -> Self {
        let product = Self::product(self.high, factor);
        Self::sum(product.high, product.low + self.low * factor)
    }
}

fn halves(a: f64) -> (f64, f64) {
    /// The factor 2^27 + 1, which makes rounding cut off the lower half of the digits.
    const SPLITTER: f64 = 134_217_729.0;
    let scaled = SPLITTER * a;
    let upper = scaled - (scaled - a);
    (upper, a - upper)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TINY: f64 = f64::EPSILON * f64::EPSILON;

    fn parts(double: Double) -> (f64, f64) {
        (double.high, double.low)
    }

    #[test]
    fn sums_keep_the_rounding_error() {
        assert_eq!(parts(Double::sum(1.0, TINY)), (1.0, TINY));
        assert_eq!(parts(Double::sum(TINY, 1.0)), (1.0, TINY));
        let third = Double::difference(1.0, TINY);
        assert_eq!(parts(third.plus(Double::sum(1.0, 3.0 * TINY))), (2.0, 2.0 * TINY));
        assert_eq!(parts(third.minus(Double::difference(1.0, 0.0))), (-TINY, 0.0));
    }

    #[test]
    fn products_are_exact() {
        // (1 + e)² = 1 + 2e + e²
        let near_one = 1.0 + f64::EPSILON;
        assert_eq!(parts(Double::product(near_one, near_one)), (1.0 + 2.0 * f64::EPSILON, TINY));
        assert_eq!(parts(Double::sum(1.0, TINY).times(3.0)), (3.0, 3.0 * TINY));
        assert_eq!(parts(Double::product(0.1, 10.0)), (1.0, 2.0_f64.powi(-54)));
    }
}
