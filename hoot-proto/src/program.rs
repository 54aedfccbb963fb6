//! Position of a motor in a planned move, at any time.
//!
//! The sheet names the parts of a planned move, not its curve. The motor stands still for the lead-in, then it goes
//! from start to stop in the travel. At the start of the travel it gains speed for the acceleration, and at the end it
//! loses speed for the deceleration. All these times are in shots, or in milliseconds in the modes without stops; a
//! lead-in is in milliseconds in video mode only. The easing says
//! how speed is gained and lost. The formulas are those of this crate (decision H-14).
//!
//! ```
//! use hoot_proto::message::{Easing, Span, Steps};
//! use hoot_proto::program::Plan;
//!
//! let plan = Plan { start: Steps(0), stop: Steps(900), travel: Span(100), ..Plan::default() };
//! assert_eq!([0, 50, 100, 101].map(|shot| plan.at(shot)), [0, 450, 900, 900].map(Steps));
//!
//! let eased = Plan { acceleration: Span(10), deceleration: Span(10), easing: Easing::LINEAR, ..plan };
//! assert_eq!([0, 10, 50, 90, 100].map(|shot| eased.at(shot)), [0, 50, 450, 850, 900].map(Steps));
//! ```

use crate::message::{Easing, Span, Steps};

/// Planned move of one motor, without its lead-in. Source: hoot, sections 2.3 and 4.2.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
pub struct Plan {
    /// Position at the start, in steps.
    pub start: Steps,
    /// Position at the end, in steps.
    pub stop: Steps,
    /// Duration of the move, in shots or milliseconds.
    pub travel: Span,
    /// Part of the travel in which the motor gains speed, in shots or milliseconds. If acceleration and deceleration
    /// together exceed the travel, both are cut in proportion.
    pub acceleration: Span,
    /// Part of the travel in which the motor loses speed, in shots or milliseconds.
    pub deceleration: Span,
    /// Curve of gaining and losing speed. An unknown easing counts as linear.
    pub easing: Easing,
}

motion_core::debug! { Plan { start stop travel acceleration deceleration easing } }

impl Plan {
    /// Whether the motor does not move.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.travel.0 == 0 || self.start == self.stop
    }

    /// Position at a number of shots or milliseconds after the lead-in. From the end of the travel on, it is the stop.
    #[must_use]
    pub fn at(&self, elapsed: u32) -> Steps {
        self.place(elapsed, Self::ramp, false)
    }

    /// Position after a number of moves of firmware that stops for each photo. Both ramps are as long as those of
    /// [`at`](Self::at), but each move of a ramp has the speed of its end, or of its start where speed is lost (decision H-91).
    ///
    /// ```
    /// use hoot_proto::message::{Easing, Span, Steps};
    /// use hoot_proto::program::Plan;
    ///
    /// let (half, easing) = (Span(2), Easing::INVERSE_QUADRATIC);
    /// let plan = Plan { stop: Steps(1800), travel: Span(4), acceleration: half, deceleration: half, easing, ..Plan::default() };
    /// assert_eq!([0, 1, 2, 3, 4].map(|shot| plan.at_shot(shot)), [0, 315, 900, 1485, 1800].map(Steps));
    /// ```
    #[must_use]
    pub fn at_shot(&self, shot: u32) -> Steps {
        self.place(shot, Self::ramp_by_shots, true)
    }

    fn place(&self, elapsed: u32, ramp: fn(&Self, u32, u32) -> u64, to_nearest: bool) -> Steps {
        let travel = self.travel.0;
        if elapsed >= travel {
            return self.stop;
        }
        let (gain, lose) = self.ramps();
        let cruise_end = travel.saturating_sub(lose);
        let whole = |length| ramp(self, length, length);
        let total = whole(gain).saturating_add(unit(cruise_end.saturating_sub(gain))).saturating_add(whole(lose));
        let gone = if elapsed <= gain {
            ramp(self, elapsed, gain)
        } else if elapsed <= cruise_end {
            whole(gain).saturating_add(unit(elapsed.saturating_sub(gain)))
        } else {
            total.saturating_sub(ramp(self, travel.saturating_sub(elapsed), lose))
        };
        // Number of bits to drop, so that the distance of 32 bits times the covered part fits into 64 bits.
        let surplus = u64::BITS.saturating_sub(total.leading_zeros()).saturating_sub(31);
        let part = |of: u64| of.checked_shr(surplus).unwrap_or(0);
        let way = u64::from(self.start.0.abs_diff(self.stop.0));
        let half = if to_nearest { part(total) / 2 } else { 0 };
        let covered = way.wrapping_mul(part(gone)).saturating_add(half).checked_div(part(total)).unwrap_or(way);
        let covered = u32::try_from(covered).unwrap_or(u32::MAX);
        Steps(if self.start < self.stop {
            self.start.0.saturating_add_unsigned(covered)
        } else {
            self.start.0.saturating_sub_unsigned(covered)
        })
    }

    /// Times of gaining and losing speed, together no longer than the travel.
    fn ramps(&self) -> (u32, u32) {
        let (gain, lose, travel) = (self.acceleration.0, self.deceleration.0, self.travel.0);
        let both = u64::from(gain).saturating_add(lose.into());
        if both <= u64::from(travel) {
            return (gain, lose);
        }
        let gain = u64::from(gain).wrapping_mul(travel.into()).checked_div(both).unwrap_or(0);
        let gain = u32::try_from(gain).unwrap_or(travel);
        (gain, travel.saturating_sub(gain))
    }

    /// Distance covered in the first `elapsed` of a ramp, if full speed covers [`unit`] of 1 in 1. It is the integral
    /// of the speed, which is u, u², or 1 - (1 - u)² at the part u of the ramp.
    fn ramp(&self, elapsed: u32, ramp: u32) -> u64 {
        // u is 1 at most and has 20 fractional bits, its third power 60. Nothing is too great for 64 bits.
        let u = (u64::from(elapsed) << 20).checked_div(ramp.into()).unwrap_or(0);
        let square = u.wrapping_mul(u);
        let cube = square.wrapping_mul(u);
        let covered = match self.easing {
            Easing::QUADRATIC => cube / 3,
            Easing::INVERSE_QUADRATIC => (square << 20).wrapping_mul(3).saturating_sub(cube) / 3,
            _ => square << 19,
        };
        u64::from(ramp).wrapping_mul(covered >> 29)
    }

    /// Distance covered in the first `moves` of a ramp: the distance of the whole ramp, shared among its moves in the proportion
    /// of 1, 2, 3, or of their squares. An inverse quadratic ramp lacks the squares that are to come.
    fn ramp_by_shots(&self, moves: u32, ramp: u32) -> u64 {
        let whole = self.ramp(ramp, ramp);
        if moves >= ramp {
            return whole;
        }
        match self.easing {
            Easing::QUADRATIC => part_of(whole, squares(moves), squares(ramp)),
            Easing::INVERSE_QUADRATIC => {
                let to_come = squares(ramp).saturating_sub(squares(ramp.saturating_sub(moves)));
                unit(moves).saturating_sub(part_of(unit(ramp) / 3, to_come, squares(ramp)))
            }
            _ => part_of(whole, numbers(moves).into(), numbers(ramp).into()),
        }
    }
}

/// Twice the sum of the numbers up to `last`, which fits into 64 bits.
const fn numbers(last: u32) -> u64 {
    (last as u64).wrapping_mul((last as u64).saturating_add(1))
}

/// Part of a distance: it times `some / all`, of which `all` is not smaller. The quotient has 30 fractional bits, and is found
/// bit by bit, because a division of 128 bits takes a small processor two kilobytes of code.
fn part_of(distance: u64, some: u128, all: u128) -> u64 {
    let (mut rest, mut part) = (some.min(all), 0_u64);
    for _ in 0..=30 {
        let bit = rest >= all && all > 0;
        rest = if bit { rest.wrapping_sub(all) } else { rest } << 1;
        part = part << 1 | u64::from(bit);
    }
    let [high, low] = [distance >> 32, distance & 0xFFFF_FFFF].map(|half| half.wrapping_mul(part));
    (high << 2).wrapping_add(low >> 30)
}

/// Six times the sum of the squares of the numbers up to `last`.
#[cfg_attr(target_os = "none", inline(never))]
fn squares(last: u32) -> u128 {
    u128::from(numbers(last)).wrapping_mul((u64::from(last) << 1 | 1).into())
}

/// Fixed point with 31 fractional bits, so that the longest distance fits into 64 bits.
fn unit(whole: u32) -> u64 {
    u64::from(whole) << 31
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_plan() -> impl Strategy<Value = Plan> {
        (any::<[i32; 2]>(), any::<[u32; 3]>(), 0_u8..5, 0_u32..32).prop_map(|(ends, spans, easing, shift)| Plan {
            start: Steps(ends[0]),
            stop: Steps(ends[1]),
            travel: Span(spans[0] >> shift),
            acceleration: Span(spans[1] >> shift),
            deceleration: Span(spans[2] >> shift),
            easing: Easing(easing),
        })
    }

    proptest! {
        #[test]
        fn a_plan_goes_one_way_from_start_to_stop(
            plan in any_plan(),
            mut times in any::<[u32; 6]>(),
            by_shots in any::<bool>(),
        ) {
            let at = |time| if by_shots { plan.at_shot(time) } else { plan.at(time) };
            for time in &mut times {
                *time %= plan.travel.0.max(1);
            }
            times.sort_unstable();
            let mut before = if plan.travel.0 == 0 { plan.stop } else { at(0) };
            prop_assert_eq!(before, if plan.travel.0 == 0 { plan.stop } else { plan.start });
            for at in times.map(at).into_iter().chain([at(plan.travel.0)]) {
                let (least, most) = (before.min(plan.stop), before.max(plan.stop));
                prop_assert!((least..=most).contains(&at), "{plan:?}: {before} then {at}");
                before = at;
            }
            prop_assert_eq!(before, plan.stop);
        }
    }

    #[test]
    fn each_easing_has_its_curve() {
        let at = |easing| {
            let plan = Plan { stop: Steps(600_000), travel: Span(1000), ..Plan::default() };
            Plan { acceleration: Span(1000), easing, ..plan }.at(500).0
        };
        assert_eq!(at(Easing::LINEAR), 150_000, "a quarter");
        assert!(at(Easing::QUADRATIC).abs_diff(75_000) < 100, "an eighth: {}", at(Easing::QUADRATIC));
        let inverse = at(Easing::INVERSE_QUADRATIC);
        assert!(inverse.abs_diff(187_500) < 100, "five sixteenths: {inverse}");
        assert_eq!(at(Easing(9)), at(Easing::LINEAR));
    }

    #[test]
    fn ramps_that_are_too_long_are_cut_in_proportion() {
        let plan = Plan { stop: Steps(100), travel: Span(30), ..Plan::default() };
        assert_eq!(Plan { acceleration: Span(20), deceleration: Span(40), ..plan }.ramps(), (10, 20));
        assert!(plan.is_empty() == (plan.start == plan.stop) && Plan { travel: Span(0), ..plan }.is_empty());
    }
}
