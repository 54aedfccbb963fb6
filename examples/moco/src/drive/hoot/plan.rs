//! Axes of move files as planned moves, which have two positions, a time, and lengths of acceleration and deceleration.
//!
//! A planned move has one of three easings, and a length of acceleration and one of deceleration. The combination that
//! is nearest to the axis is chosen. Two smooth key frames, which are the default of a move file, are exact except for
//! whole steps: their speed is a parabola. An inverse quadratic easing that accelerates for half of the time and
//! decelerates for the other half has the same speed. `examples/moves/pan.json` moves over 9000 steps in 4 s, and its
//! planned move is off by at most 1.02 steps. Straight axes are exact too, but such a
//! move begins and ends in motion, so that an axis with limits cannot have one. Flat handles of another length are not.

use hoot_proto::Address;
use hoot_proto::message::{Easing, Motor, Span, Steps};
use hoot_proto::program::Plan;
use motion_move::{Hoot, Move, MoveAxis};

use crate::drive::Trouble;

/// Greatest number of 32 bits that arrives.
const MOST: f64 = hoot_proto::message::MAX_ARRIVING as f64;
/// Greatest deviation of a planned move, as a part of its distance.
const CLOSE: f64 = 0.01;
/// Least improvement that counts, in steps, because plans are cut to whole steps.
const NOISE: f64 = 0.125;
/// Number of places at which a plan is compared with its axis.
const LOOKS: u32 = 128;

/// Unit of the time of a planned move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Count {
    /// Milliseconds.
    Video,
    /// Photos: this number, spread over the whole move. Motors rest while photos are taken.
    Shots(u32),
    /// Photos at an interval in milliseconds: this number, spread over the whole move. Motors move meanwhile, so the travel is
    /// in milliseconds, and only the lead-in is in photos (decision H-43).
    Lapse {
        /// Number of photos.
        shots: u32,
        /// Interval.
        interval: u32,
    },
}

/// Planned move of a motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Planned {
    /// The motor.
    pub motor: Motor,
    /// The planned move.
    pub plan: Plan,
    /// Time to wait before the move, in milliseconds in video mode, otherwise in photos.
    pub lead_in: u32,
    /// Greatest distance from the axis, in steps.
    pub deviation: f64,
}

impl Planned {
    /// Greatest distance from one count to the next, in steps. If counts are milliseconds, it is a thousandth of the speed.
    ///
    /// The distance is an average over several counts, because positions are whole steps.
    #[must_use]
    pub fn peak(&self) -> f64 {
        let span = (self.plan.travel.0 / 50).max(1);
        let places = (0..=self.plan.travel.0 / span).map(|at| f64::from(self.plan.at(at * span).0));
        let places: Vec<f64> = places.collect();
        let ways = places.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        ways.fold(0.0, f64::max) / f64::from(span)
    }

    /// Longest way from one photo to the next, in steps.
    #[must_use]
    pub fn longest(&self) -> u32 {
        let places = (0..=self.plan.travel.0).map(|at| self.plan.at_shot(at).0);
        let ways = places.clone().zip(places.skip(1)).map(|(one, next)| one.abs_diff(next));
        ways.max().unwrap_or(0)
    }

    /// Makes the travel longer, with its ramps in proportion.
    pub fn stretch(&mut self, more: u32) {
        let before = self.plan.travel.0.max(1);
        let after = before.saturating_add(more);
        for span in [&mut self.plan.travel, &mut self.plan.acceleration, &mut self.plan.deceleration] {
            span.0 = share(after, span.0, before);
        }
    }

    /// The same move from its end to its start. `all` is the length of the whole move, in counts.
    fn reversed(self, all: u32) -> Self {
        let Plan { start, stop, travel, acceleration, deceleration, easing, .. } = self.plan;
        let plan =
            Plan { start: stop, stop: start, travel, acceleration: deceleration, deceleration: acceleration, easing };
        Self { plan, lead_in: all.saturating_sub(self.lead_in).saturating_sub(travel.0), ..self }
    }
}

/// Makes the planned moves of a node from a move file.
///
/// # Errors
///
/// [`Trouble::Refused`] if the move has no axis for the node, or if a planned move or the rig cannot do it.
pub fn plans(file: &Move, node: Address, count: Count, reverse: bool) -> Result<Vec<Planned>, Trouble> {
    let photo = |shots: u32| file.duration() / f64::from(shots.saturating_sub(1).max(1));
    // Time of a count of the lead-in, and number of counts of the travel in that time.
    let (seconds, counts_of_travel) = match count {
        Count::Video => (0.001, 1),
        Count::Shots(shots) => (photo(shots), 1),
        Count::Lapse { shots, interval } => (photo(shots), interval.max(1)),
    };
    let all = counts(file.duration() / seconds).unwrap_or(0);
    let mut planned: Vec<Planned> = Vec::new();
    for axis in file.axes() {
        let Some(hoot) = axis.hoot().filter(|hoot| hoot.address == node.0) else { continue };
        let at = if matches!(count, Count::Shots(_)) { Plan::at_shot } else { Plan::at };
        let this = fit(axis, &hoot, seconds, counts_of_travel, at)
            .map_err(|why| Trouble::Refused(format!("axis {:?}: {why}", axis.name())))?;
        let this = if reverse { this.reversed(all) } else { this };
        if planned.iter().any(|other| other.motor == this.motor) {
            return Err(Trouble::Refused(format!(
                "axis {:?}: motor {} already has an axis: remove one of them",
                axis.name(),
                this.motor
            )));
        }
        planned.push(this);
    }
    if planned.is_empty() {
        let address = node.0;
        return Err(Trouble::Refused(format!(
            "the move has no axis for node {address}: give one a \"hoot\" with \"address\": {address} and a \"motor\""
        )));
    }
    if let Some(excess) = file.excesses().next() {
        return Err(Trouble::Refused(format!("the move exceeds a limit: {excess}")));
    }
    Ok(planned)
}

/// Fits a planned move, whose places `at` tells, to an axis.
fn fit(
    axis: &MoveAxis,
    hoot: &Hoot,
    seconds: f64,
    counts_of_travel: u32,
    at: fn(&Plan, u32) -> Steps,
) -> Result<Planned, String> {
    let [first, last] = axis.keys() else {
        return Err(format!(
            "it has {} key frames, but a planned move has two: remove those between the first and the last",
            axis.keys().len()
        ));
    };
    let steps = |position: f64| {
        hoot.scale.steps(position).map(Steps).map_err(|error| format!("{error}: use fewer steps per unit"))
    };
    let (start, stop) = (steps(first.position)?, steps(last.position)?);
    let long = || "it is too long: the limit is 16,777,215 ms or photos".to_owned();
    let lead_in = counts(first.time / seconds).ok_or_else(long)?;
    let end = counts(last.time / seconds * f64::from(counts_of_travel)).ok_or_else(long)?;
    let travel = end.saturating_sub(lead_in.saturating_mul(counts_of_travel)).max(1);
    let motor = Motor::new(hoot.motor).ok_or("hoot has motors 1 to 3")?;
    let plan = Plan { start, stop, travel: Span(travel), easing: Easing::LINEAR, ..Plan::default() };

    // The axis in steps, at the places of the comparison between its key frames.
    let looks = LOOKS.min(travel);
    let axis_at = axis.curve();
    let rise = f64::from(stop.0) - f64::from(start.0);
    let whole = last.position - first.position;
    let places: Vec<(u32, f64)> = (0..=looks)
        .map(|look| {
            let at = share(travel, look, looks);
            let part = f64::from(at) / f64::from(travel);
            let position = axis_at.position(first.time + (last.time - first.time) * part);
            let gone = if whole == 0.0 { 0.0 } else { (position - first.position) / whole };
            (at, f64::from(start.0) + rise * gone)
        })
        .collect();
    // A plan is cut to whole steps, so on average it is half a step behind the axis.
    let behind = if rise == 0.0 { 0.0 } else { rise.signum() / 2.0 };
    let off = |plan: &Plan| {
        let offs = places.iter().map(|(count, place)| (f64::from(at(plan, *count).0) + behind - place).abs());
        offs.fold(0.0, f64::max)
    };
    let (plan, deviation) = nearest(plan, off);
    let planned = Planned { motor, plan, lead_in, deviation: deviation + behind.abs() };
    // Photos are whole numbers, so half the distance from one to the next is the best precision.
    let close = if travel > 1000 { CLOSE * rise.abs() } else { (CLOSE * rise.abs()).max(planned.peak() / 2.0) };
    if planned.deviation > close.max(2.0) {
        return Err(format!(
            "its curve is {:.0} steps away from any planned move: use smooth key frames, or straight ones",
            planned.deviation
        ));
    }
    Ok(planned)
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
            for lose in 0..=COARSE - gain {
                found = look(easing, share(travel, gain, COARSE), share(travel, lose, COARSE));
            }
        }
    }
    let mut step = (travel / (2 * COARSE)).max(1);
    loop {
        let (plan, before) = found;
        let (gain, lose) = (plan.acceleration.0, plan.deceleration.0);
        let less = |length: u32| length.saturating_sub(step);
        for (gain, lose) in [
            (gain + step, lose),
            (less(gain), lose),
            (gain, lose + step),
            (gain, less(lose)),
            (gain + step, less(lose)),
            (less(gain), lose + step),
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
fn share(whole: u32, parts: u32, of: u32) -> u32 {
    u32::try_from(u64::from(whole) * u64::from(parts) / u64::from(of.max(1))).unwrap_or(whole)
}

/// Whole number of counts, if it is in the range that hoot can carry.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the range is checked")]
fn counts(number: f64) -> Option<u32> {
    (0.0..=MOST).contains(&number.round()).then(|| number.round() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAN: &str = include_str!("../../../../moves/pan.json");
    const NODE: Address = Address::DEFAULT;

    fn pan(part: &str, other: &str) -> Move {
        assert!(PAN.contains(part));
        Move::parse("pan.json", &PAN.replacen(part, other, 1)).unwrap()
    }

    fn refused(part: &str, other: &str) -> String {
        match plans(&pan(part, other), NODE, Count::Video, false) {
            Err(Trouble::Refused(why)) => why,
            other => panic!("{other:?}"),
        }
    }

    /// Compares the move file and the planned move at each millisecond. The documentation states the difference.
    #[test]
    fn the_planned_move_of_the_sample_is_off_by_about_a_step() {
        let file = pan("Pan", "Pan");
        let planned = plans(&file, NODE, Count::Video, false).unwrap()[0];
        assert_eq!((planned.plan.start, planned.plan.stop, planned.lead_in), (Steps(0), Steps(9000), 500));
        assert_eq!((planned.plan.travel, planned.plan.easing), (Span(4000), Easing::INVERSE_QUADRATIC));
        let curve = file.axes()[0].curve();
        let off = |at: u32| {
            let place = f64::from(planned.plan.at(at.saturating_sub(planned.lead_in)).0);
            (place - 100.0 * curve.position(f64::from(at) / 1000.0)).abs()
        };
        let worst = (0..=5000).map(off).fold(0.0, f64::max);
        assert!((0.5..1.02).contains(&worst), "{worst}");
        assert!((planned.peak() - 3.375).abs() < 0.05, "{}", planned.peak());
    }

    #[test]
    fn a_reversed_move_follows_the_same_path_back() {
        let file = pan("\"duration\": 5", "\"duration\": 6");
        let there = plans(&file, NODE, Count::Video, false).unwrap()[0];
        let back = plans(&file, NODE, Count::Video, true).unwrap()[0];
        assert_eq!((back.plan.start, back.plan.stop, back.lead_in), (Steps(9000), Steps(0), 1500));
        for at in 0..=4000 {
            let off = back.plan.at(at).0 - there.plan.at(4000 - at).0;
            // Both are cut to whole steps, each towards its own start.
            assert!(off.abs() <= 2, "{off} at {at}: {there:?}");
        }
    }

    #[test]
    fn photos_are_near_the_curve() {
        let file = pan("Pan", "Pan");
        for shots in [2, 3, 10, 37, 500] {
            let planned = plans(&file, NODE, Count::Shots(shots), false).unwrap()[0];
            assert!(planned.deviation <= (planned.peak() / 2.0).max(90.0), "{planned:?}");
            assert!(planned.lead_in + planned.plan.travel.0 < shots.max(3), "{shots}: {planned:?}");
        }
    }

    #[test]
    fn the_travel_of_a_time_lapse_is_in_milliseconds_and_its_lead_in_in_photos() {
        let file = pan("Pan", "Pan");
        let (shots, interval) = (11, 2000);
        let lapse = plans(&file, NODE, Count::Lapse { shots, interval }, false).unwrap()[0];
        // Ten intervals of 2 s for a move of 5 s, of which the axis uses the time from 0.5 to 4.5 s.
        assert_eq!((lapse.lead_in, lapse.plan.travel), (1, Span(16_000)));
        let video = plans(&file, NODE, Count::Video, false).unwrap()[0];
        assert!((lapse.peak() * 4.0 - video.peak()).abs() < 0.05, "a quarter of the speed: {}", lapse.peak());
    }

    #[test]
    fn a_move_that_cannot_be_planned_is_refused() {
        let key = "{ \"time\": 4.5";
        let three = refused(key, &format!("{{ \"time\": 2, \"position\": 50 }}, {key}"));
        assert!(three.contains("axis \"Pan\": it has 3 key frames"), "{three}");
        let fast = refused("\"velocity\": 40", "\"velocity\": 20");
        assert!(fast.contains("exceeds a limit: axis \"Pan\"") && fast.contains("limit is 20"), "{fast}");
        let straight = refused("\"position\": 90 }", "\"position\": 90, \"ease\": \"linear\" }");
        assert!(straight.contains("a corner at 4.5 s"), "{straight}");
        let wild = refused("\"position\": 90 }", "\"position\": 90, \"arrive\": [-4, 20] }");
        assert!(wild.contains("steps away"), "{wild}");
        let none = refused("\"hoot\": { ", "\"hoot\": { \"address\": 4, ");
        assert!(none.contains("no axis for node 3"), "{none}");
        let long = pan("\"duration\": 5,", "");
        let [first, last] = long.axes()[0].keys() else { panic!("two key frames") };
        let keys = [*first, motion_move::KeyFrame { time: 20_000.0, ..*last }];
        let long = long.axes()[0].to_builder().keys(keys).build().unwrap();
        let hoot = long.hoot().unwrap();
        assert!(fit(&long, &hoot, 0.001, 1, Plan::at).unwrap_err().contains("too long"));
    }
}
