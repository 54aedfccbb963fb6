//! Whether there is a move, and of which frames: DMC D3, uploads. The values lie in the caller's
//! [`UploadBuffer`](crate::upload::UploadBuffer), which has the last word on each section.

use crate::frame::{MessageId, MessageType};
use crate::message::{AckCode, FrameNumber, HostMessage, Motor, Motors};

/// A message of an upload that is to be stored, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Store {
    pub(super) id: MessageId,
    pub(super) kind: MessageType,
    what: Part,
}

/// Which part of an upload.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Part {
    Begin(FrameNumber, FrameNumber),
    Axis(Motor),
    Other,
    End,
}

/// What a device has of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(super) enum Upload {
    #[default]
    None,
    Loading(Frames),
    Loaded(Frames),
}

/// The frames and motors of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Frames {
    first: FrameNumber,
    last: FrameNumber,
    axes: Motors,
}

impl Upload {
    /// What to do with a message of an upload: store it, or answer it at once with this code, which is `OK` for an end
    /// that ends nothing. A begin is only given here when all is at rest, since what there was is forgotten with it.
    pub(super) fn receive(&mut self, id: MessageId, message: &HostMessage<'_>) -> Result<Store, AckCode> {
        let what = match (message, *self) {
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
        Ok(Store { id, kind: message.kind(), what })
    }

    /// What was stored is part of the move.
    pub(super) fn stored(&mut self, store: Store) {
        *self = match (store.what, *self) {
            (Part::Begin(first, last), _) => Self::Loading(Frames { first, last, axes: Motors::NONE }),
            (Part::Axis(motor), Self::Loading(mut frames)) => {
                frames.axes.0 |= Motors::from_iter([motor]).0;
                Self::Loading(frames)
            }
            (Part::End, Self::Loading(frames)) => Self::Loaded(frames),
            (_, same) => same,
        };
    }

    /// The frames that can be run; `None` if no upload is complete.
    pub(super) fn loaded(&self) -> Option<Frames> {
        match self {
            Self::Loaded(frames) => Some(*frames),
            Self::None | Self::Loading(_) => None,
        }
    }

    /// The motors of the move.
    pub(super) fn axes(&self) -> Motors {
        self.loaded().map_or(Motors::NONE, |frames| frames.axes)
    }

    /// Whether a frame can be gone to: a move is there, and the frame is part of it.
    pub(super) fn reach(&self, frame: FrameNumber) -> Result<(), AckCode> {
        let frames = self.loaded().ok_or(AckCode::ERR_GENERAL)?;
        if (frames.first..=frames.last).contains(&frame) { Ok(()) } else { Err(AckCode::ERR_RANGE) }
    }
}
