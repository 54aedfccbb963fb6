//! The rules of a move, each in one place: the builder, the reader and lint ask here (decisions K-J1 to K-J10).

use core::cmp::Ordering;

use motion_core::bezier;
use motion_core::lint::Severity::{self, Error, Warning};

use super::blocks::{Axis, Blocks, Playback, Segment, TimeLapse};
use super::error::{Amount, MoveError, Place};
use super::values::{DelayMode, LoopCount, Point, Points};
use crate::message::{MotorAddress, PlaybackMode};

/// How far the end of a segment may be from the begin of the next, and the ends of a motor's way from those of the move.
const TOLERANCE: f32 = 1e-4;

/// Where a motor's way should begin.
pub(super) const LATE: &str = "is where the first segment begins, not 0";
/// Where it should end.
pub(super) const EARLY: &str = "is where the last segment ends, not 1";

/// Who is told what is wrong, and how bad it is: an error makes it no move, a warning an unwise one.
pub(crate) type Found<'f> = dyn FnMut(Severity, MoveError) + 'f;

/// Looks at a whole move.
///
/// At most 255 blocks are looked through for each of at most 255 blocks.
pub(crate) fn check(blocks: &Blocks<'_>, found: &mut Found<'_>) {
    let played = only(found, "playback", blocks.playbacks());
    let photos = only(found, "time_lapse", blocks.time_lapses());
    if let Some(played) = &played {
        playback(found, played);
    }
    if let Some(photos) = photos.filter(|_| !played.is_some_and(is_live)) {
        time_lapse(found, &photos);
    }
    if blocks.axes().next().is_none() {
        found(Error, MoveError::NoMotors);
    }
    // There are at most 255 blocks, and the range ends there too.
    for (axis, before) in blocks.axes().zip(0..=Blocks::MAX) {
        let again = |other: &Axis<'_>| same(other.motor_address, axis.motor_address);
        if blocks.axes().take(before).any(|other| again(&other)) {
            contradiction(found, Place::Motor(axis.motor_address), "axis", "is there twice");
        } else if blocks.axes().filter(again).nth(1).is_none() {
            self::axis(found, blocks, &axis);
        }
    }
    for Segment { motor_address, segment_number, .. } in blocks.segments() {
        if !blocks.axes().any(|axis| same(axis.motor_address, motor_address)) {
            contradiction(found, Place::Segment(motor_address, segment_number), "segment", "has no axis");
        }
    }
}

/// Whether a motor can have that address (decision K-M1).
pub(super) fn is_motor(motor: MotorAddress) -> bool {
    (1..=MotorAddress::LAST.0).contains(&motor.number())
}

fn is_live(playback: Playback<'_>) -> bool {
    playback.playback_mode == PlaybackMode::LIVE_MOTION
}

fn same(one: MotorAddress, other: MotorAddress) -> bool {
    one.number() == other.number()
}

fn contradiction(found: &mut Found<'_>, place: Place, what: &'static str, note: &'static str) {
    found(Error, MoveError::Contradiction { place, what, note });
}

/// The only block of its kind; a strict device wants each once, zeros where it is not used (decision K-J1).
fn only<T>(found: &mut Found<'_>, what: &'static str, mut blocks: impl Iterator<Item = T>) -> Option<T> {
    let first = blocks.next();
    if first.is_none() {
        contradiction(found, Place::Move, what, "is missing");
    }
    if blocks.next().is_some() {
        contradiction(found, Place::Move, what, "is there twice");
    }
    first
}

/// An amount: finite, and not less than nothing (decision K-N1).
fn amount(found: &mut Found<'_>, what: &'static str, value: f32) {
    if !value.is_finite() {
        found(Error, MoveError::NotFinite { place: Place::Move, what, bits: value.to_bits() });
    } else if value < 0.0 {
        found(Error, MoveError::number(Place::Move, what, value, "is negative"));
    }
}

fn playback(found: &mut Found<'_>, playback: &Playback<'_>) {
    let (duration, rapid_reverse) = (playback.duration, playback.rapid_reverse_duration);
    amount(found, "duration", duration.0);
    amount(found, "rapid_reverse_duration", rapid_reverse.0);
    let (rapid, back) = (playback.loop_after_rapid_reverse, playback.loop_after_reverse);
    if is_live(*playback) {
        // Decisions K-J10, K-J5 and K-J4.
        if duration.0 == 0.0 {
            found(Error, MoveError::number(Place::Move, "duration", duration.0, "is no time for a move"));
        }
        if rapid_reverse != duration {
            found(Warning, MoveError::OtherRapidReverse { value: rapid_reverse.0.into() });
        }
        if rapid != LoopCount::NONE && back != LoopCount::NONE {
            contradiction(found, Place::Move, "loop_after_reverse", "excludes loop_after_rapid_reverse");
        }
    } else if rapid != LoopCount::NONE || back != LoopCount::NONE {
        contradiction(found, Place::Move, "loop_after_reverse", "is set, and a time lapse does not loop");
    }
    let interval = playback.delay_interval_bits;
    match playback.delay_mode {
        DelayMode::INTERVAL => amount(found, "delay_interval_bits", interval.seconds().0),
        DelayMode::UNTIL if interval.is_float_time() => found(Warning, MoveError::FloatMoment),
        _ => {}
    }
    home_speed(found, playback.return_to_home_percent.0);
}

/// A part of the greatest speed; what 0 means nobody knows (decision K-J6).
fn home_speed(found: &mut Found<'_>, part: f32) {
    let what = "return_to_home_percent";
    amount(found, what, part);
    if part.is_finite() && !(0.0..=1.0).contains(&part) {
        found(Warning, MoveError::number(Place::Move, what, part, "is not in 0 to 1"));
    }
    if part == 0.0 {
        found(Warning, MoveError::number(Place::Move, what, part, "may never bring the motors to the begin"));
    }
}

fn time_lapse(found: &mut Found<'_>, photos: &TimeLapse<'_>) {
    amount(found, "delay", photos.delay.0);
    amount(found, "exposure", photos.exposure.0);
}

/// The segments of a motor: as many as said, each following the one before (decisions K-J8 and K-J9).
fn axis(found: &mut Found<'_>, blocks: &Blocks<'_>, axis: &Axis<'_>) {
    let (motor, said) = (axis.motor_address, axis.segment_count);
    if !is_motor(motor) {
        found(Error, MoveError::Address { motor });
    }
    let segments = || blocks.segments_of(motor);
    let have = segments().fold(0, |count: u8, _| count.saturating_add(1));
    if have != said {
        found(Error, MoveError::SegmentCount { motor, said, have });
    }
    let mut before: Option<(Place, Point)> = None;
    for number in 0..said {
        let place = Place::Segment(motor, number);
        let Some(segment) = segments().find(|segment| segment.segment_number == number) else {
            contradiction(found, place, "segment_number", "is missing");
            break;
        };
        curve(found, place, &segment.points);
        let Points([begin, .., end]) = segment.points;
        match before {
            None => near_or(found, place, begin, 0.0, LATE),
            Some((_, end)) if !close(end, begin) => found(Error, MoveError::Apart { place, end, begin }),
            Some(_) => {}
        }
        before = Some((place, end));
    }
    if let Some((place, end)) = before {
        near_or(found, place, end, 1.0, EARLY);
    }
}

/// One curve: time goes on, its ends lie in the move and the range, and so does what is between (decision K-J8).
fn curve(found: &mut Found<'_>, place: Place, points: &Points) {
    let Points([begin, out, into, end]) = points;
    let numbers = points.0.map(|point| [point.time.0, point.position.0]);
    let whole = 0.0..=1.0;
    let times = [begin, out, into, end].map(|point| point.time.0);
    let mut steps = times.iter().zip(times.iter().skip(1));
    if let Some((_, &next)) = steps.find(|(one, next)| one.partial_cmp(next).is_none_or(Ordering::is_gt)) {
        found(Error, MoveError::number(place, "points", next, "is earlier than the point before"));
    } else if begin.time.0 >= end.time.0 {
        found(Error, MoveError::number(place, "points", end.time.0, "is both begin and end"));
    }
    let ends = [begin.position.0, end.position.0];
    if let Some(&outside) = times.iter().chain(&ends).find(|number| !whole.contains(*number)) {
        found(Error, MoveError::number(place, "points", outside, "is not in 0 to 1"));
        return;
    }
    if let Some(&none) = numbers.as_flattened().iter().find(|number| !number.is_finite()) {
        found(Error, MoveError::NotFinite { place, what: "points", bits: none.to_bits() });
    }
    // A curve stays between its points, so that it can only leave where a handle does.
    if [out, into].iter().any(|handle| !whole.contains(&handle.position.0)) {
        if let Some(outside) = points.curve().ok().and_then(|curve| outside(&curve)) {
            found(Warning, MoveError::number(place, "points", outside, "is where the curve leaves the range"));
        }
    }
}

/// The farthest position outside the range, if it is outside by more than rounding.
fn outside(curve: &bezier::Segment) -> Option<f32> {
    let (least, most) = curve.range();
    let (below, above) = (-least, most - 1.0);
    let farthest = if below > above { least } else { most };
    (below.max(above) > f64::from(f32::EPSILON)).then_some(Amount::shown(farthest).0)
}

fn near(one: f32, other: f32) -> bool {
    (-TOLERANCE..=TOLERANCE).contains(&(one - other))
}

fn close(one: Point, other: Point) -> bool {
    near(one.time.0, other.time.0) && near(one.position.0, other.position.0)
}

fn near_or(found: &mut Found<'_>, place: Place, point: Point, wanted: f32, note: &'static str) {
    if !near(point.time.0, wanted) {
        found(Warning, MoveError::number(place, "points", point.time.0, note));
    }
}
