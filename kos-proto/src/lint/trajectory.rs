//! Whether blocks make a move (decisions K-J1 to K-J11).

use motion_core::lint::{Lints, Problem, Severity};

use super::{address, not_negative, part_of_one, yes_or_no, zero};
use crate::message::{MotorAddress, PlaybackMode};
use crate::trajectory::{
    Axis, Block, DelayMode, LoopCount, Playback, Point, Points, Segment, TimeLapse, TrajectoryData,
};

/// How far the end of a segment may be from the begin of the next.
const TOLERANCE: f32 = 1e-4;

/// Checks a move that is to be stored.
pub(super) fn check(lints: &mut Lints, message: &TrajectoryData<'_>) {
    let blocks = || message.blocks.iter();
    let playback = one(
        lints,
        "playback",
        blocks().filter_map(|block| match block {
            Block::Playback(playback) => Some(playback),
            _ => None,
        }),
    );
    let time_lapse = one(
        lints,
        "time_lapse",
        blocks().filter_map(|block| match block {
            Block::TimeLapse(time_lapse) => Some(time_lapse),
            _ => None,
        }),
    );
    let mode = playback.map(|playback| playback.playback_mode);
    if let Some(playback) = playback {
        self::playback(lints, &playback);
    }
    if let Some(photos) = time_lapse.filter(|_| mode != Some(PlaybackMode::LIVE_MOTION)) {
        self::time_lapse(lints, &photos);
    }
    if axes(message).next().is_none() {
        lints.note(Severity::Error, "axis", "is missing");
    }
    // There are at most 255 blocks, and the range ends there too.
    for (axis, before) in axes(message).zip(0..=usize::from(u8::MAX)) {
        let again = axes(message).take(before).any(|other| same(other.motor_address, axis.motor_address));
        if again {
            lints.note(Severity::Error, "axis", "is there twice");
        } else {
            self::axis(lints, message, &axis);
        }
    }
    for block in blocks() {
        match block {
            Block::Segment(segment) if !axes(message).any(|axis| same(axis.motor_address, segment.motor_address)) => {
                lints.note(Severity::Error, "segment", "has no axis");
            }
            Block::Other(other) => lints.push(Severity::Warning, "block_id", Problem::Unnamed(other.id())),
            _ => {}
        }
    }
}

/// The only block of its kind; a strict device wants each once, zeros where it is not used (decision K-J1).
fn one<T>(lints: &mut Lints, what: &'static str, mut blocks: impl Iterator<Item = T>) -> Option<T> {
    let first = blocks.next();
    if first.is_none() {
        lints.note(Severity::Error, what, "is missing");
    }
    if blocks.next().is_some() {
        lints.note(Severity::Error, what, "is there twice");
    }
    first
}

fn axes<'a>(message: &TrajectoryData<'a>) -> impl Iterator<Item = Axis<'a>> + use<'a> {
    message.blocks.iter().filter_map(|block| if let Block::Axis(axis) = block { Some(axis) } else { None })
}

fn same(one: MotorAddress, other: MotorAddress) -> bool {
    one.number() == other.number()
}

fn playback(lints: &mut Lints, playback: &Playback<'_>) {
    lints.named("playback_mode", playback.playback_mode.0, playback.playback_mode.name());
    not_negative(lints, "duration", playback.duration.0);
    not_negative(lints, "rapid_reverse_duration", playback.rapid_reverse_duration.0);
    let (rapid, back) = (playback.loop_after_rapid_reverse, playback.loop_after_reverse);
    if playback.playback_mode == PlaybackMode::LIVE_MOTION {
        // Decisions K-J10, K-J5 and K-J4.
        if playback.duration.0 == 0.0 {
            lints.note(Severity::Error, "duration", "is 0");
        }
        if playback.rapid_reverse_duration != playback.duration {
            lints.note(Severity::Warning, "rapid_reverse_duration", "should be the same as duration");
        }
        if rapid != LoopCount::NONE && back != LoopCount::NONE {
            lints.note(Severity::Error, "loop_after_reverse", "excludes loop_after_rapid_reverse");
        }
    } else if rapid != LoopCount::NONE || back != LoopCount::NONE {
        lints.note(Severity::Error, "loop_after_reverse", "a time lapse does not loop");
    }
    lints.named("delay_mode", playback.delay_mode.0, playback.delay_mode.name());
    let interval = playback.delay_interval_bits;
    match playback.delay_mode {
        DelayMode::INTERVAL => {
            lints.finite("delay_interval_bits", interval.seconds().0);
            not_negative(lints, "delay_interval_bits", interval.seconds().0);
        }
        // A device that reads an integer would start at once (safety decision 5).
        DelayMode::UNTIL if interval.is_float_time() => {
            lints.note(Severity::Warning, "delay_interval_bits", "a moment as IEEE number may start the move at once");
        }
        _ => {}
    }
    unsupported(lints, playback);
    not_negative(lints, "return_to_home_percent", playback.return_to_home_percent.0);
    part_of_one(lints, "return_to_home_percent", playback.return_to_home_percent.0);
    if playback.return_to_home_percent.0 == 0.0 {
        lints.note(Severity::Warning, "return_to_home_percent", "is 0: the motors may never get to the begin");
    }
}

/// What devices do not support is sent as 0 (decision K-J11).
fn unsupported(lints: &mut Lints, playback: &Playback<'_>) {
    yes_or_no(lints, "camera_roll_enabled", playback.camera_roll_enabled);
    let bytes = [
        ("camera_roll_enabled", playback.camera_roll_enabled.0),
        ("flash_mark_enabled", playback.flash_mark_enabled),
        ("flash_mark_type", playback.flash_mark_type),
        ("use_external_trigger", playback.use_external_trigger),
        ("using_lanc", playback.using_lanc),
    ];
    let times = [
        ("camera_roll_pre_delay", playback.camera_roll_pre_delay),
        ("camera_roll_post_delay", playback.camera_roll_post_delay),
        ("flash_mark_post_delay", playback.flash_mark_post_delay),
    ];
    let set = bytes.iter().map(|&(what, byte)| (what, byte != 0));
    for (what, _) in set.chain(times.iter().map(|&(what, time)| (what, time.0 != 0.0))).filter(|&(_, set)| set) {
        lints.note(Severity::Warning, what, "is not supported and should be 0");
    }
}

fn time_lapse(lints: &mut Lints, photos: &TimeLapse<'_>) {
    not_negative(lints, "delay", photos.delay.0);
    not_negative(lints, "exposure", photos.exposure.0);
    zero(lints, "not_used", photos.not_used);
}

/// The segments of a motor: as many as said, each following the one before (decisions K-J8 and K-J9).
fn axis(lints: &mut Lints, message: &TrajectoryData<'_>, axis: &Axis<'_>) {
    address(lints, axis.motor_address, 1);
    let segments = || {
        message.blocks.iter().filter_map(|block| match block {
            Block::Segment(segment) if same(segment.motor_address, axis.motor_address) => Some(segment),
            _ => None,
        })
    };
    if segments().fold(0_u8, |count, _| count.saturating_add(1)) != axis.segment_count {
        lints.note(Severity::Error, "segment_count", "is not the number of segments");
    }
    let numbered = |number: u8| segments().find(|segment| segment.segment_number == number);
    let mut before: Option<Segment<'_>> = None;
    for number in 0..axis.segment_count {
        let Some(segment) = numbered(number) else {
            lints.note(Severity::Error, "segment_number", "is missing");
            break;
        };
        curve(lints, &segment.points);
        let Points([begin, ..]) = segment.points;
        match before {
            None => near_or(lints, begin.time.0, 0.0, "the first segment should begin at 0"),
            Some(Segment { points: Points([.., end]), .. }) if !close(end, begin) => {
                lints.note(Severity::Error, "points", "do not begin where the segment before ends");
            }
            Some(_) => {}
        }
        before = Some(segment);
    }
    if let Some(Segment { points: Points([.., end]), .. }) = before {
        near_or(lints, end.time.0, 1.0, "the last segment should end at 1");
    }
}

/// One curve: time goes on, its ends lie in the move and the range (decision K-J8).
fn curve(lints: &mut Lints, Points([begin, out, into, end]): &Points) {
    let times = [begin, out, into, end].map(|point| point.time.0);
    if !times.is_sorted() || begin.time.0 >= end.time.0 {
        lints.note(Severity::Error, "points", "time does not go on");
    }
    let whole = 0.0..=1.0;
    let inside = times.iter().chain([&begin.position.0, &end.position.0]).all(|number| whole.contains(number));
    if !inside {
        lints.note(Severity::Error, "points", "are not in 0 to 1");
    } else if ![out, into].iter().all(|point| whole.contains(&point.position.0)) {
        lints.note(Severity::Warning, "points", "a handle is not in 0 to 1, and the curve may leave the range");
    }
}

fn near(one: f32, other: f32) -> bool {
    (-TOLERANCE..=TOLERANCE).contains(&(one - other))
}

fn close(one: Point, other: Point) -> bool {
    near(one.time.0, other.time.0) && near(one.position.0, other.position.0)
}

fn near_or(lints: &mut Lints, time: f32, wanted: f32, note: &'static str) {
    if !near(time, wanted) {
        lints.note(Severity::Warning, "points", note);
    }
}
