//! Rules of a move, each written once. The builder, the reader and lint use them (decisions K-J1 to K-J10).

use core::cmp::Ordering;

use motion_core::lint::Severity::{self, Error, Warning};

use super::blocks::{Axis, Blocks, Playback, Segment, TimeLapse};
use super::error::{MoveError, Place};
use super::overshoot;
use super::values::{DelayMode, LoopCount, Point, Points};
use crate::message::{MotorAddress, PlaybackMode};

/// Greatest distance between the end of a segment and the start of the next, and between the ends of a way and of the
/// move.
const TOLERANCE: f32 = 1e-4;

/// Note for a motor's way that does not start with the move.
pub(super) const LATE: &str = "is the start of the first segment, not 0";
/// Note for a motor's way that does not end with the move.
pub(super) const EARLY: &str = "is the end of the last segment, not 1";

/// Receiver of findings. An error means that the blocks are not a move; a warning means that the move is unwise.
pub(crate) type Found<'f> = dyn FnMut(Severity, MoveError) + 'f;

/// Checks a whole move.
///
/// The cost is at most 255 × 255 blocks.
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
    // There are at most 255 blocks, so the range is long enough.
    for (axis, before) in blocks.axes().zip(0..=Blocks::MAX) {
        let again = |other: &Axis<'_>| same(other.motor_address, axis.motor_address);
        if blocks.axes().take(before).any(|other| again(&other)) {
            contradiction(found, Place::Motor(axis.motor_address), "axis", "is present twice");
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

/// Whether a motor can have this address (decision K-M1).
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

/// The only block of its kind. A strict device requires each kind once, with zeros if it is not used (decision K-J1).
fn only<T>(found: &mut Found<'_>, what: &'static str, mut blocks: impl Iterator<Item = T>) -> Option<T> {
    let first = blocks.next();
    if first.is_none() {
        contradiction(found, Place::Move, what, "is missing");
    }
    if blocks.next().is_some() {
        contradiction(found, Place::Move, what, "is present twice");
    }
    first
}

/// Checks that an amount is finite and not negative (decision K-N1).
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
            found(Error, MoveError::number(Place::Move, "duration", duration.0, "is too short for a move"));
        }
        if rapid_reverse != duration {
            found(Warning, MoveError::OtherRapidReverse { value: rapid_reverse.0.into() });
        }
        if rapid != LoopCount::NONE && back != LoopCount::NONE {
            contradiction(found, Place::Move, "loop_after_reverse", "cannot be set with loop_after_rapid_reverse");
        }
    } else if rapid != LoopCount::NONE || back != LoopCount::NONE {
        contradiction(found, Place::Move, "loop_after_reverse", "is set, but a time lapse does not loop");
    }
    let interval = playback.delay_interval_bits;
    match playback.delay_mode {
        DelayMode::INTERVAL => amount(found, "delay_interval_bits", interval.seconds().0),
        DelayMode::UNTIL if interval.is_float_time() => found(Warning, MoveError::FloatMoment),
        _ => {}
    }
    home_speed(found, playback.return_to_home_percent.0);
}

/// Checks a part of the greatest speed. The specification does not say what 0 means (decision K-J6).
fn home_speed(found: &mut Found<'_>, part: f32) {
    let what = "return_to_home_percent";
    amount(found, what, part);
    if part.is_finite() && !(0.0..=1.0).contains(&part) {
        found(Warning, MoveError::number(Place::Move, what, part, "is not in 0 to 1"));
    }
    if part == 0.0 {
        found(Warning, MoveError::number(Place::Move, what, part, "may never bring the motors to the start"));
    }
}

fn time_lapse(found: &mut Found<'_>, photos: &TimeLapse<'_>) {
    amount(found, "delay", photos.delay.0);
    amount(found, "exposure", photos.exposure.0);
}

/// Checks the segments of a motor: as many as its axis says, each following the one before (decisions K-J8 and K-J9).
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

/// Checks one curve: time increases, and the curve stays in the move and the range, also between its ends (decision
/// K-J8).
fn curve(found: &mut Found<'_>, place: Place, points: &Points) {
    let Points([begin, out, into, end]) = points;
    let numbers = points.0.map(|point| [point.time.0, point.position.0]);
    let whole = 0.0..=1.0;
    let times = [begin, out, into, end].map(|point| point.time.0);
    let mut steps = times.iter().zip(times.iter().skip(1));
    if let Some((_, &next)) = steps.find(|(one, next)| one.partial_cmp(next).is_none_or(Ordering::is_gt)) {
        found(Error, MoveError::number(place, "points", next, "is earlier than the point before"));
    } else if begin.time.0 >= end.time.0 {
        found(Error, MoveError::number(place, "points", end.time.0, "is both start and end"));
    }
    let ends = [begin.position.0, end.position.0];
    if let Some(&outside) = times.iter().chain(&ends).find(|number| !whole.contains(*number)) {
        found(Error, MoveError::number(place, "points", outside, "is not in 0 to 1"));
        return;
    }
    if let Some(&none) = numbers.as_flattened().iter().find(|number| !number.is_finite()) {
        found(Error, MoveError::NotFinite { place, what: "points", bits: none.to_bits() });
    }
    if let Some(outside) = beyond_range(place, points) {
        found(Warning, outside);
    }
}

/// First curve of the blocks that leaves the range of its motor, so that no motor can follow it (decision K-J8).
pub(crate) fn outside_range(blocks: &Blocks<'_>) -> Option<MoveError> {
    blocks.segments().find_map(|Segment { motor_address, segment_number, points, .. }| {
        beyond_range(Place::Segment(motor_address, segment_number), &points)
    })
}

/// Error about a curve that leaves the range.
fn beyond_range(place: Place, points: &Points) -> Option<MoveError> {
    let outside = overshoot::outside(points)?;
    Some(MoveError::number(place, "points", outside, "is a position of the curve outside the range"))
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
