//! Checks whether blocks make a move (decisions K-J1 to K-J11), by the same rules as the builder of moves.

use motion_core::lint::{Findings as _, Lints, Problem, Severity};

use super::{Context, address, yes_or_no, zero};
use crate::trajectory::{Block, Excess, MoveError, Playback, Trajectory, TrajectoryData, rules};

/// Checks a move that is to be stored.
pub(super) fn check(lints: &mut Lints, context: &Context<'_>, message: &TrajectoryData<'_>) {
    rules::check(&message.blocks, &mut |severity, error| report(lints, severity, error));
    for block in &message.blocks {
        match block {
            Block::Playback(playback) => {
                lints.named("playback_mode", playback.playback_mode.0, playback.playback_mode.name());
                lints.named("delay_mode", playback.delay_mode.0, playback.delay_mode.name());
                unsupported(lints, &playback);
            }
            Block::TimeLapse(photos) => zero(lints, "not_used", photos.not_used),
            Block::Other(other) => lints.push(Severity::Warning, "block_id", Problem::Unnamed(other.id())),
            Block::Axis(_) | Block::Segment(_) => {}
        }
    }
    if !context.motors.is_empty() {
        motors(lints, context, message);
    }
}

/// Checks whether the motors can play the move (decisions K-J9 and K-M6).
fn motors(lints: &mut Lints, context: &Context<'_>, message: &TrajectoryData<'_>) {
    let excesses = Trajectory::new(message).into_iter().flat_map(|trajectory| trajectory.excesses(context));
    for excess in excesses {
        match excess {
            Excess::Absent { .. } => {
                lints.note(Severity::Error, "motor_address", "is not the address of a motor of the device");
            }
            Excess::Uncalibrated { .. } => lints.note(Severity::Error, "motor_address", "is not calibrated"),
            Excess::Speed { .. } => lints.note(Severity::Warning, "points", "are too fast for the motor"),
            Excess::Acceleration { .. } => lints.note(Severity::Warning, "points", "accelerate too much for the motor"),
        }
    }
}

fn report(lints: &mut Lints, severity: Severity, error: MoveError) {
    let mut note = |what, note| lints.note(severity, what, note);
    match error {
        MoveError::Number { what, note: text, .. } | MoveError::Contradiction { what, note: text, .. } => {
            note(what, text);
        }
        MoveError::NoMotors => note("axis", "is missing"),
        MoveError::Address { motor } => address(lints, motor, 1),
        MoveError::SegmentCount { .. } => note("segment_count", "is not the number of segments"),
        MoveError::Apart { .. } => note("points", "do not begin where the segment before them ends"),
        MoveError::OtherRapidReverse { .. } => note("rapid_reverse_duration", "should be the same as duration"),
        MoveError::FloatMoment => {
            note("delay_interval_bits", "holds the moment as an IEEE number, which may start the move at once");
        }
        MoveError::NotFinite { what: what @ "delay_interval_bits", bits, .. } => {
            lints.push(severity, what, Problem::NonFinite(bits));
        }
        // `common` checks that all other numbers are finite. Only the builder and the reader find the other errors.
        MoveError::NotFinite { .. }
        | MoveError::Uncalibrated { .. }
        | MoveError::Outside { .. }
        | MoveError::Moment { .. }
        | MoveError::Unnamed { .. }
        | MoveError::TooManyBlocks { .. }
        | MoveError::Encode(_) => {}
    }
}

/// Checks that fields which devices do not support are 0 (decision K-J11).
fn unsupported(lints: &mut Lints, playback: &Playback<'_>) {
    let switches = [
        ("camera_roll_enabled", playback.camera_roll_enabled),
        ("flash_mark_enabled", playback.flash_mark_enabled),
        ("use_external_trigger", playback.use_external_trigger),
        ("using_lanc", playback.using_lanc),
    ];
    for (what, switch) in switches {
        yes_or_no(lints, what, switch);
    }
    let bytes = switches.map(|(what, switch)| (what, switch.0)).into_iter();
    let bytes = bytes.chain([("flash_mark_type", playback.flash_mark_type)]);
    let times = [
        ("camera_roll_pre_delay", playback.camera_roll_pre_delay),
        ("camera_roll_post_delay", playback.camera_roll_post_delay),
        ("flash_mark_post_delay", playback.flash_mark_post_delay),
    ];
    let set = bytes.map(|(what, byte)| (what, byte != 0));
    for (what, _) in set.chain(times.iter().map(|&(what, time)| (what, time.0 != 0.0))).filter(|&(_, set)| set) {
        lints.note(Severity::Warning, what, "is not supported and should be 0");
    }
}
