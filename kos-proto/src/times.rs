//! Conversions between whole milliseconds and the numbers on the wire.

use crate::message::{Normalized, Seconds};

/// Time in whole milliseconds, rounded. Negative times and NaN give 0. An infinite time gives `u64::MAX`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion cuts off the fraction, and ends at the greatest and the least number"
)]
pub(crate) fn millis(time: Seconds) -> u64 {
    (f64::from(time.0) * 1000.0 + 0.5) as u64
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
