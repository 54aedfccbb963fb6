//! Conversions between whole milliseconds and the numbers on the wire.

use crate::message::{Normalized, Seconds};

/// Time in whole milliseconds, rounded: a half goes up. Negative times and NaN give 0. A time that is too long gives `u64::MAX`.
///
/// The integers are exact. With f64, a device without a unit for it would have 2 kB of code for this function alone.
pub(crate) const fn millis(time: Seconds) -> u64 {
    if time.0.is_nan() || time.0 <= 0.0 {
        return 0;
    }
    let (exponent, fraction) = (time.0.to_bits() >> 23, time.0.to_bits() & 0x7F_FFFF);
    // The time is so many parts of a millisecond, each 2^(exponent - 150). Times without the leading bit are far less than 1 ms.
    let parts = (fraction as u64 | 0x80_0000).saturating_mul(1000);
    match exponent {
        // More parts than a u64 can count.
        150.. if exponent.saturating_sub(150) > parts.leading_zeros() => u64::MAX,
        150.. => parts.wrapping_shl(exponent.saturating_sub(150)),
        87..150 => {
            let shift = 150_u32.saturating_sub(exponent);
            parts.saturating_add(1_u64.wrapping_shl(shift.saturating_sub(1))).wrapping_shr(shift)
        }
        _ => 0,
    }
}

/// Time in seconds, as the nearest IEEE number.
#[expect(clippy::cast_precision_loss, reason = "the time is shown to people, who need no more precision")]
pub(crate) fn seconds(millis: u64) -> Seconds {
    Seconds(millis as f32 / 1000.0)
}

/// Part of a whole that is done, 0 to 1.
#[expect(clippy::cast_precision_loss, reason = "the part is shown to people, who need no more precision")]
pub(crate) fn part(done: u64, whole: u64) -> Normalized {
    Normalized(if done < whole { done as f32 / whole as f32 } else { 1.0 })
}

/// Time between repetitions in milliseconds, at least 1; `None` if nothing is repeated.
pub(crate) const fn some_time(millis: Option<u64>) -> Option<u64> {
    match millis {
        Some(0) => Some(1),
        millis => millis,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "ends at the greatest and the least number"
    )]
    fn with_f64(time: f32) -> u64 {
        (f64::from(time) * 1000.0 + 0.5) as u64
    }

    proptest! {
        #[test]
        fn milliseconds_are_those_of_f64_for_any_bits(bits in any::<u32>(), exponent in 80..220_u32) {
            let near = f32::from_bits(exponent << 23 | bits & 0x807F_FFFF);
            for time in [f32::from_bits(bits), near] {
                prop_assert_eq!(millis(Seconds(time)), with_f64(time), "{:e}", time);
            }
        }
    }

    #[test]
    fn milliseconds_are_rounded_and_end_at_the_greatest_number() {
        let times = [
            0.0,
            -0.0,
            -1.0,
            f32::NAN,
            0.0005,
            0.000_499_99,
            0.0015,
            1.0,
            3.25,
            f32::MAX,
            f32::INFINITY,
            f32::MIN_POSITIVE,
        ];
        for time in times {
            assert_eq!(millis(Seconds(time)), with_f64(time), "{time}");
        }
        assert_eq!((millis(Seconds(1.5)), millis(Seconds(1e30))), (1500, u64::MAX));
        // A half of a millisecond: 1/16 s is 62.5 ms.
        assert_eq!(millis(Seconds(0.0625)), 63);
    }
}
