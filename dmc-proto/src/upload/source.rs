//! What a move is made of, and whether a device can take it.

use super::{MAX_FRAMES, SCRATCH, Section};
use crate::EncodeError;
use crate::lint::Context;
use crate::message::{DmxChannel, FrameNumber, HostMessage, Motor, Motors, RtUploadMoveBegin, Steps, Triggers};

/// The data of a move, wherever it lies: in memory, in a file, or in curves that are sampled when they are asked.
///
/// Frames are counted by their index: 0 is the first frame of the move, whatever its number is. Nothing is asked beyond
/// the last frame, nor of tracks that are not in the move. As long as the upload runs, the same question must have the
/// same answer.
pub trait MoveSource {
    /// The number of the first frame.
    fn start_frame(&self) -> FrameNumber;

    /// How many frames there are, at least one.
    fn frame_count(&self) -> u32;

    /// The motors that are part of the move. Others will not be moved (safety decision 5).
    fn motors(&self) -> Motors;

    /// Where a motor is at a frame.
    fn position(&self, motor: Motor, index: u32) -> Steps;

    /// Whether a DMX channel is part of the move; none is, unless said otherwise.
    fn has_channel(&self, channel: DmxChannel) -> bool {
        let _ = channel;
        false
    }

    /// The level of a DMX channel at a frame.
    fn level(&self, channel: DmxChannel, index: u32) -> u8 {
        let _ = (channel, index);
        0
    }

    /// The outputs that the move switches; none, unless said otherwise.
    fn mask(&self) -> Triggers {
        Triggers::NONE
    }

    /// The outputs that are on at a frame. Those outside [`mask`](Self::mask) do not count.
    fn triggers(&self, index: u32) -> Triggers {
        let _ = index;
        Triggers::NONE
    }
}

/// What has a value for each frame of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Track {
    /// The positions of a motor.
    Axis(Motor),
    /// The levels of a DMX channel.
    Channel(DmxChannel),
    /// The outputs.
    Triggers,
}

/// The tracks of a move in their order: motors, channels, triggers.
pub(super) fn tracks<S: MoveSource + ?Sized>(source: &S) -> impl Iterator<Item = Track> {
    let axes = source.motors().iter().map(Track::Axis);
    let channels = (1..=512).map(DmxChannel).filter(|&channel| source.has_channel(channel)).map(Track::Channel);
    let triggers = (source.mask() != Triggers::NONE).then_some(Track::Triggers);
    axes.chain(channels).chain(triggers)
}

/// The message that begins the upload of a move, if the device can take all of it.
///
/// The motors, channels, outputs and frames that `context` knows of are looked at before anything is sent, so that no
/// upload fails halfway.
///
/// # Errors
///
/// [`EncodeError::OutOfRange`], if the move has no frame, or more than the indices or the frame numbers reach.
/// [`EncodeError::Refused`] with what lint finds in the first message that the device would refuse.
pub fn begin<S: MoveSource + ?Sized>(
    source: &S,
    context: &Context<'_>,
) -> Result<RtUploadMoveBegin<'static>, EncodeError> {
    let (start_frame, count) = (source.start_frame(), i64::from(source.frame_count()));
    // As many as there are numbers from the first frame to the greatest one.
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
