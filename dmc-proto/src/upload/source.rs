//! Source of the data of a move, and the check whether a device can take it.

use super::{MAX_FRAMES, SCRATCH, Section};
use crate::EncodeError;
use crate::lint::Context;
use crate::message::{DmxChannel, FrameNumber, HostMessage, Motor, Motors, RtUploadMoveBegin, Steps, Triggers};

/// Data of a move, for example in memory, in a file, or in curves that are sampled on demand.
///
/// Frames are counted by their index: 0 is the first frame of the move, whatever its number. Only frames and tracks of
/// the move are asked for. As long as the upload runs, the same question must have the same answer.
pub trait MoveSource {
    /// Number of the first frame.
    fn start_frame(&self) -> FrameNumber;

    /// Number of frames, at least one.
    fn frame_count(&self) -> u32;

    /// Motors that are part of the move. Other motors do not move (safety decision 5).
    fn motors(&self) -> Motors;

    /// Position of a motor at a frame.
    fn position(&self, motor: Motor, index: u32) -> Steps;

    /// Whether a DMX channel is part of the move. By default, no channel is.
    fn has_channel(&self, channel: DmxChannel) -> bool {
        let _ = channel;
        false
    }

    /// Level of a DMX channel at a frame.
    fn level(&self, channel: DmxChannel, index: u32) -> u8 {
        let _ = (channel, index);
        0
    }

    /// Outputs that the move switches; by default none.
    fn mask(&self) -> Triggers {
        Triggers::NONE
    }

    /// Outputs that are on at a frame. Outputs outside [`mask`](Self::mask) are ignored.
    fn triggers(&self, index: u32) -> Triggers {
        let _ = index;
        Triggers::NONE
    }
}

/// Move without frames and motors, for hosts that upload nothing. No device can take it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct NoMove;

impl MoveSource for NoMove {
    fn start_frame(&self) -> FrameNumber {
        FrameNumber(1)
    }

    fn frame_count(&self) -> u32 {
        0
    }

    fn motors(&self) -> Motors {
        Motors::NONE
    }

    fn position(&self, _: Motor, _: u32) -> Steps {
        Steps(0)
    }
}

/// Part of a move that has a value for each frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
pub enum Track {
    /// Positions of a motor.
    Axis(Motor),
    /// Levels of a DMX channel.
    Channel(DmxChannel),
    /// Outputs.
    Triggers,
}

/// Tracks of a move in order: motors, channels, triggers.
pub(super) fn tracks<S: MoveSource + ?Sized>(source: &S) -> impl Iterator<Item = Track> {
    let axes = source.motors().iter().map(Track::Axis);
    let channels = (1..=512).map(DmxChannel).filter(|&channel| source.has_channel(channel)).map(Track::Channel);
    let triggers = (source.mask() != Triggers::NONE).then_some(Track::Triggers);
    axes.chain(channels).chain(triggers)
}

/// Message that starts the upload of a move, if the device can take the whole move.
///
/// The motors, channels, outputs and frames are checked against `context` before anything is sent, so that no upload
/// fails halfway.
///
/// # Errors
///
/// [`EncodeError::OutOfRange`] if the move has no frame, or more frames than the indices or the frame numbers reach.
/// [`EncodeError::Refused`] with the finding of lint in the first message that the device would refuse.
pub fn begin<S: MoveSource + ?Sized>(
    source: &S,
    context: &Context<'_>,
) -> Result<RtUploadMoveBegin<'static>, EncodeError> {
    let (start_frame, count) = (source.start_frame(), i64::from(source.frame_count()));
    // Count of numbers from the first frame to the greatest number.
    let max = i64::from(i32::MAX).wrapping_sub(start_frame.0.into()).wrapping_add(1).min(MAX_FRAMES.into());
    let wrong = EncodeError::OutOfRange { what: "frame_count", value: count, min: 1, max };
    if !(1..=max).contains(&count) {
        return Err(wrong);
    }
    let end = i64::from(start_frame.0).wrapping_add(count).wrapping_sub(1);
    let end_frame = FrameNumber(i32::try_from(end).map_err(|_| wrong)?);
    let begin = RtUploadMoveBegin { start_frame, end_frame, tail: &[] };

    check(&begin.into(), context)?;
    for track in tracks(source) {
        check(&Section::empty(track).message(source, &mut [0; SCRATCH]), context)?;
    }
    Ok(begin)
}

fn check(message: &HostMessage<'_>, context: &Context<'_>) -> Result<(), EncodeError> {
    message.lint(context).first_error().map_or(Ok(()), |error| Err(EncodeError::Refused(error)))
}
