//! The uploaded move of a device, without its values: DMC D3.
//!
//! The values lie in the caller's [`UploadBuffer`](crate::upload::UploadBuffer), which has the last word on each section.

use super::event::{Part, Store};
use crate::frame::{MessageId, MessageType};
use crate::message::{AckCode, FrameNumber, HostMessage, Motors};

/// State of the uploaded move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(super) enum Upload {
    #[default]
    None,
    Loading(Frames),
    Loaded(Frames),
}

/// Frames and motors of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Frames {
    first: FrameNumber,
    last: FrameNumber,
    axes: Motors,
}

impl Upload {
    /// Takes a message of an upload. It is to be stored, or answered at once with this code: `OK` for an end that ends
    /// nothing.
    ///
    /// A begin comes here only while all motors rest, because it makes the device forget its move.
    pub(super) fn receive(
        &mut self,
        id: MessageId,
        kind: MessageType,
        message: &HostMessage<'_>,
    ) -> Result<Store, AckCode> {
        let part = match (message, *self) {
            (HostMessage::RtUploadMoveBegin(begin), _) => {
                // Until it is stored, there is nothing that could be run.
                *self = Self::None;
                Part::Begin(begin.start_frame, begin.end_frame)
            }
            (HostMessage::RtUploadMoveEnd(_), Self::Loading(_)) => Part::End,
            (HostMessage::RtUploadMoveEnd(_), _) => return Err(AckCode::OK),
            (HostMessage::RtUploadMoveAxis(axis), Self::Loading(_)) => Part::Axis(axis.motor),
            (_, Self::Loading(_)) => Part::Other,
            (_, Self::None | Self::Loaded(_)) => return Err(AckCode::ERR_GENERAL),
        };
        Ok(Store { id, kind, part })
    }

    /// Takes what was stored into the move.
    pub(super) fn stored(&mut self, store: Store) {
        *self = match (store.part, *self) {
            (Part::Begin(first, last), _) => Self::Loading(Frames { first, last, axes: Motors::NONE }),
            (Part::Axis(motor), Self::Loading(mut frames)) => {
                frames.axes.0 |= Motors::from_iter([motor]).0;
                Self::Loading(frames)
            }
            (Part::End, Self::Loading(frames)) => Self::Loaded(frames),
            (_, same) => same,
        };
    }

    /// Frames that can be run; `None` if no upload is complete.
    pub(super) fn loaded(&self) -> Option<Frames> {
        match self {
            Self::Loaded(frames) => Some(*frames),
            Self::None | Self::Loading(_) => None,
        }
    }

    /// Motors of the move.
    pub(super) fn axes(&self) -> Motors {
        self.loaded().map_or(Motors::NONE, |frames| frames.axes)
    }

    /// Frame of the move that is nearest to a frame; the frame itself without a move.
    pub(super) fn nearest(&self, frame: FrameNumber) -> FrameNumber {
        self.loaded().map_or(frame, |frames| frame.min(frames.last).max(frames.first))
    }

    /// Checks that there is a move, and that a frame is part of it.
    pub(super) fn reach(&self, frame: FrameNumber) -> Result<(), AckCode> {
        let frames = self.loaded().ok_or(AckCode::ERR_GENERAL)?;
        if (frames.first..=frames.last).contains(&frame) { Ok(()) } else { Err(AckCode::ERR_RANGE) }
    }
}
