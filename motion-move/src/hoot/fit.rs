//! The planned move that is nearest to a curve.

use hoot_proto::Address;
use hoot_proto::message::{Easing, Motor, Span, Steps};
use hoot_proto::program::Plan;

use super::{Clock, Error, Planned};
use crate::axis::MoveAxis;
use crate::motor::Hoot;

/// Greatest number of 32 bits that arrives.
const MOST: f64 = hoot_proto::message::MAX_ARRIVING as f64;
/// Least improvement that counts, in steps, because plans are cut to whole steps.
const NOISE: f64 = 0.125;
/// Number of places at which a plan is compared with its axis while the nearest one is sought.
const LOOKS: u32 = 128;

/// Fits a planned move to an axis, from its first key frame to its last.
pub(super) fn fit(axis: &MoveAxis, hoot: &Hoot, clock: &Clock) -> Result<Planned, Error> {
    let (curve, name) = (axis.curve(), || axis.name().to_owned());
    let (first, last) = (curve.start(), curve.end());
    let (from, to) = (curve.position(first), curve.position(last));
    let steps =
        |position: f64| hoot.scale.steps(position).map(Steps).map_err(|error| Error::Steps { axis: name(), error });
    let (start, stop) = (steps(from)?, steps(to)?);
    let long = || Error::Long { axis: name() };
    let lead_in = counts(first / clock.seconds).ok_or_else(long)?;
    let end = counts(last / clock.seconds * f64::from(clock.counts_of_travel)).ok_or_else(long)?;
    let travel = end.saturating_sub(lead_in.saturating_mul(clock.counts_of_travel)).max(1);
    let motor = Motor::new(hoot.motor).ok_or_else(|| Error::Motor { axis: name() })?;
    let plan = Plan { start, stop, travel: Span(travel), easing: Easing::LINEAR, ..Plan::default() };

    // The axis in steps, at the places of the comparison between its key frames.
    let looks = LOOKS.min(travel);
    let rise = f64::from(stop.0) - f64::from(start.0);
    let whole = to - from;
    let places: Vec<(u32, f64)> = (0..=looks)
        .map(|look| {
            let at = share(travel, look, looks);
            let part = f64::from(at) / f64::from(travel);
            let position = curve.position(first + (last - first) * part);
            // Without a rise, the way is that of the axis.
            let place =
                if rise == 0.0 { (position - from) * hoot.scale.per_unit() } else { rise * (position - from) / whole };
            (at, f64::from(start.0) + place)
        })
        .collect();
    // A plan is cut to whole steps, so on average it is half a step behind the axis.
    let behind = if rise == 0.0 { 0.0 } else { rise.signum() / 2.0 };
    let at = if clock.by_shots { Plan::at_shot } else { Plan::at };
    let off = |plan: &Plan| {
        let offs = places.iter().map(|(count, place)| (f64::from(at(plan, *count).0) + behind - place).abs());
        offs.fold(0.0, f64::max)
    };
    let (plan, deviation) = nearest(plan, off);
    Ok(Planned { node: Address(hoot.address), motor, plan, lead_in, deviation: deviation + behind.abs() })
}

/// Finds the easing and the lengths of acceleration and deceleration with the least deviation.
fn nearest(plan: Plan, off: impl Fn(&Plan) -> f64) -> (Plan, f64) {
    const COARSE: u32 = 24;
    let travel = plan.travel.0;
    let mut best = (plan, off(&plan));
    let mut look = |easing, gain: u32, lose: u32| {
        if gain.saturating_add(lose) <= travel {
            let plan = Plan { acceleration: Span(gain), deceleration: Span(lose), easing, ..plan };
            let off = off(&plan);
            if off + NOISE < best.1 {
                best = (plan, off);
            }
        }
        best
    };
    let mut found = (plan, f64::INFINITY);
    for easing in [Easing::LINEAR, Easing::QUADRATIC, Easing::INVERSE_QUADRATIC] {
        for gain in 0..=COARSE {
            for lose in 0..=COARSE.saturating_sub(gain) {
                found = look(easing, share(travel, gain, COARSE), share(travel, lose, COARSE));
            }
        }
    }
    let mut step = (travel / 48).max(1);
    loop {
        let (plan, before) = found;
        let (gain, lose) = (plan.acceleration.0, plan.deceleration.0);
        let (less, more) = (|length: u32| length.saturating_sub(step), |length: u32| length.saturating_add(step));
        for (gain, lose) in [
            (more(gain), lose),
            (less(gain), lose),
            (gain, more(lose)),
            (gain, less(lose)),
            (more(gain), less(lose)),
            (less(gain), more(lose)),
        ] {
            found = look(plan.easing, gain, lose);
        }
        if found.1 >= before {
            if step == 1 {
                return found;
            }
            step /= 2;
        }
    }
}

/// `parts` of `of` parts of a whole, rounded down.
pub(super) fn share(whole: u32, parts: u32, of: u32) -> u32 {
    let part = u64::from(whole).saturating_mul(parts.into()).checked_div(of.max(1).into());
    part.and_then(|part| u32::try_from(part).ok()).unwrap_or(whole)
}

/// Whole number of counts, if it is in the range that hoot can carry.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the range is checked")]
pub(super) fn counts(number: f64) -> Option<u32> {
    (0.0..=MOST).contains(&number.round()).then(|| number.round() as u32)
}
