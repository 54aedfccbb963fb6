//! Moves as uploads of DMC.
//!
//! ```
//! use dmc_proto::message::{Motor, Steps};
//! use dmc_proto::upload::MoveSource;
//! use motion_move::{Move, dmc};
//!
//! let pan = Move::parse("pan.json", r#"{ "move": 1, "name": "Pan", "rate": 24, "axes": [{
//!     "name": "Pan", "unit": "°", "keys": [{ "time": 0, "position": 0 }, { "time": 4, "position": 90 }],
//!     "dmc": { "motor": 1, "steps_per_unit": 100 }
//! }] }"#)?;
//! let converted = dmc::convert(&pan)?;
//! assert_eq!((converted.frame_count(), converted.position(Motor(1), 48)), (97, Steps(4500)));
//! assert!(converted.losses[0].amount < 0.02);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use dmc_proto::message::{FrameNumber, FramesPerSecond, Motor, Motors, Steps};
use dmc_proto::upload::MoveSource;
use motion_core::fixed::FixedError;
use motion_core::trajectory::{Axis, FrameRate, FrameTimes, StepScale, StepsError};

use crate::axis::MoveAxis;
use crate::bound::{Cubic, Far, NOISE};
use crate::limits::Excess;
use crate::loss::{Loss, LossKind};
use crate::moves::Move;

/// Number of the first frame.
const FIRST: FrameNumber = FrameNumber(1);

/// Why a move cannot be uploaded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No axis has a DMC motor.
    #[error("no axis has a DMC motor: give one \"dmc\": {{ \"motor\": 1, \"steps_per_unit\": ... }}")]
    NoMotor,
    /// Steps of an axis do not fit 32 bits.
    #[error("axis {axis:?}: {error}")]
    Steps {
        /// Name of the axis.
        axis: String,
        /// The frame and its steps.
        #[source]
        error: StepsError,
    },
    /// The frame rate is too great.
    #[error("\"rate\": {0}")]
    Rate(#[from] FixedError),
    /// The move has more frames than their numbers can count.
    #[error("{0} frames are too many: their numbers have 32 bits")]
    Frames(u32),
}

/// Move as it is uploaded: positions in whole steps at whole frames. The first frame of the move is frame 1.
///
/// It is a [`MoveSource`]. A position is computed when it is asked for, without allocation.
#[derive(Clone, Debug)]
pub struct Converted<'a> {
    frames: FrameTimes,
    rate: FramesPerSecond,
    axes: Vec<(Motor, Axis<'a>, StepScale)>,
    /// Differences between the move and what a device plays: one for each axis with a DMC motor, one for each axis without,
    /// and one if the frame rate is rounded.
    pub losses: Vec<Loss>,
    /// Limits that the axes with a DMC motor exceed.
    pub excesses: Vec<Excess<'a>>,
}

impl Converted<'_> {
    /// Frame rate as it is sent.
    #[must_use]
    pub const fn rate(&self) -> FramesPerSecond {
        self.rate
    }
}

impl MoveSource for Converted<'_> {
    fn start_frame(&self) -> FrameNumber {
        FIRST
    }

    fn frame_count(&self) -> u32 {
        self.frames.count
    }

    fn motors(&self) -> Motors {
        self.axes.iter().map(|(motor, ..)| *motor).collect()
    }

    /// Position of a motor at a frame. A motor that is not part of the move has position 0, and frames after the last one have
    /// its position.
    fn position(&self, motor: Motor, index: u32) -> Steps {
        let index = index.min(self.frames.count.saturating_sub(1));
        let axis = self.axes.iter().find(|(other, ..)| *other == motor);
        // All frames were computed when the move was converted, and a frame has the same steps every time.
        Steps(axis.and_then(|(_, curve, scale)| curve.steps_at(self.frames, index, *scale).ok()).unwrap_or_default())
    }
}

/// Converts a move to an upload, in which axes without a DMC motor are left out.
///
/// All frames are computed once, so that a position that does not fit is an error here, and never a wrong step later. The loss
/// of an axis includes the rounding to steps, and the straight lines from frame to frame: the greatest distance from each line
/// is found by closed formulas.
///
/// # Errors
///
/// [`Error`] says why the move cannot be uploaded.
pub fn convert(subject: &Move) -> Result<Converted<'_>, Error> {
    let frames = subject.frames();
    if i32::try_from(frames.count).is_err() {
        return Err(Error::Frames(frames.count));
    }
    let (mut axes, mut losses) = (Vec::new(), Vec::new());
    for axis in subject.axes() {
        let Some(dmc) = axis.dmc() else { continue };
        let Far { amount, time } =
            apart(axis, frames, dmc.scale).map_err(|error| Error::Steps { axis: axis.name().to_owned(), error })?;
        losses.push(Loss::of(axis, LossKind::Frames, amount / dmc.scale.per_unit().abs(), time));
        axes.push((Motor(dmc.motor), axis.curve(), dmc.scale));
    }
    if axes.is_empty() {
        return Err(Error::NoMotor);
    }
    let rate = frames.rate.to_milli()?;
    let last = frames.count.saturating_sub(1);
    // A rate of less than half a thousandth is sent as 0.
    let sent = FrameRate::try_from(rate).map_or(f64::INFINITY, |rate| rate.seconds(last));
    let late = (sent - frames.rate.seconds(last)).abs();
    losses.extend((late > 0.0).then(|| Loss::late(subject, LossKind::Rate, late)));
    losses.extend(Loss::left_out(subject, "DMC", |axis| axis.dmc().is_some()));
    let excesses = subject.excesses().filter(|excess| excess.axis.dmc().is_some()).collect();
    Ok(Converted { frames, rate: FramesPerSecond(rate), axes, losses, excesses })
}

/// The greatest distance of a curve from the straight lines between its steps at frames, in steps.
fn apart(axis: &MoveAxis, frames: FrameTimes, scale: StepScale) -> Result<Far, StepsError> {
    let curve = axis.curve();
    let place = |position: f64| position * scale.per_unit() + scale.offset();
    let mut segments = curve.segments().iter();
    let (mut far, mut before) = (Far::NONE, None);
    for frame in 0..frames.count {
        let (time, steps) = (frames.time(frame), f64::from(curve.steps_at(frames, frame, scale)?));
        far = far.or(Far { amount: (place(curve.position(time)) - steps).abs(), time });
        let Some((from, first)) = before.replace((time, steps)) else { continue };
        let line = |at: f64| first + (steps - first) * ((at - from) / (time - from));
        // Segments that end before this frame count no longer.
        while let [this, _, ..] = segments.as_slice() {
            if this.end() > from {
                break;
            }
            segments.next();
        }
        for segment in segments.as_slice().iter().take_while(|segment| segment.start() < time) {
            let apart = Cubic(segment.points().map(|point| place(point.position) - line(point.time)));
            let (begin, end) = (segment.start().max(from), segment.end().min(time));
            if begin < end {
                let (amount, u) = apart.farthest(segment.parameter(begin), segment.parameter(end));
                let clock = Cubic(segment.points().map(|point| point.time));
                far = far.or(Far { amount, time: clock.at(u) });
            }
        }
    }
    let range = curve.range();
    let largest = place(range.from).abs().max(place(range.to).abs()).max(1.0);
    Ok(Far { amount: far.amount + NOISE * largest, ..far })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::tests::{CRANE, PAN};
    use crate::write::tests::any_move;

    #[test]
    fn the_sample_is_half_a_step_and_a_sagitta_away() {
        let pan = Move::parse("", PAN).unwrap();
        let converted = convert(&pan).unwrap();
        let [loss] = &converted.losses[..] else { panic!("{:?}", converted.losses) };
        // From 0 to 9000 steps in 4 s: the acceleration is 3375 steps/s² at first, so the line of a frame is 0.73 steps off.
        let sagitta = 3375.0 / 24.0 / 24.0 / 8.0;
        assert!(loss.amount > 0.5 / 100.0 && loss.amount < (0.5 + sagitta) / 100.0 + 1e-9, "{loss}");
        let crane = Move::parse("", CRANE).unwrap();
        let rate = &convert(&crane).unwrap().losses[4];
        assert!(rate.kind == LossKind::Rate && (rate.amount - 20.0 / 1_001_000.0).abs() < 1e-5, "{rate}");
    }

    #[test]
    fn a_move_without_a_motor_is_an_error() {
        let pan = Move::parse("", &PAN.replace("\"dmc\": { \"motor\": 1, \"steps_per_unit\": 100 },", "")).unwrap();
        assert_eq!(convert(&pan).unwrap_err(), Error::NoMotor);
    }

    proptest! {
        #[test]
        fn straight_lines_between_frames_are_within_the_loss(
            subject in any_move().prop_filter("DMC", |subject| subject.axes()[0].dmc().is_some() && subject.frames().count < 5000),
            at in prop::collection::vec(0.0..1.0, 64),
        ) {
            let converted = convert(&subject).unwrap();
            let (axis, loss, frames) = (&subject.axes()[0], &converted.losses[0], subject.frames());
            let dmc = axis.dmc().unwrap();
            for part in at {
                let frame: f64 = part * f64::from(frames.count - 1);
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a frame")]
                let index = frame as u32;
                let steps = |index| f64::from(converted.position(Motor(dmc.motor), index).0);
                let (from, to) = (frames.time(index), frames.time(index + 1));
                let time = from + frame.fract() * (to - from);
                let played = steps(index) + (steps(index + 1) - steps(index)) * frame.fract();
                let off = (played - dmc.scale.offset()) / dmc.scale.per_unit() - axis.curve().position(time);
                prop_assert!(off.abs() <= loss.amount * (1.0 + 1e-9) + 1e-9, "{} at {}: {}", off, time, loss);
            }
        }
    }
}
