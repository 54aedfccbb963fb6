//! Inputs of a device's machine: what happened on its link and in its rig.

use motion_core::wire::DecodeError;

use super::event::Store;
use crate::frame::{Frame, MessageId, MessageType};
use crate::message::{AckCode, FrameNumber, HostMessage, Motor, Motors, Triggers};

/// Something that happened to a device.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Input<'a> {
    /// The link to the host is open, at boot: the device greets.
    LinkUp,
    /// The link is gone. No stop could come any more, so everything stops (decision D-53).
    LinkDown,
    /// A message arrived.
    Received {
        /// Id of the message.
        id: MessageId,
        /// The message.
        message: HostMessage<'a>,
        /// Answer of the rig to the message if it were done now: `OK`; `ERR_SOFT_UP` or `ERR_SOFT_LOW` for a target or
        /// path beyond a limit that was set; `ERR_PREROLL` or `ERR_POSTROLL`; `ERR_RANGE` for what is out of reach.
        ///
        /// The machine knows neither positions nor limits. It does not look at this answer where it refuses anyway, nor
        /// ever for a stop.
        rig: AckCode,
    },
    /// A sound frame arrived whose data ends before the fields of its message do.
    Malformed(MessageId, MessageType),
    /// A frame with a wrong checksum arrived. Id and type are those of its header.
    Corrupt(MessageId, MessageType),
    /// The rig or its operator reports something.
    Rig(Report),
    /// The time of the last wake has come.
    Wake,
}

/// Message of a frame. It is decoded in one place, because the code for all messages is long.
#[inline(never)]
pub(super) fn message<'a>(frame: &Frame<'a>) -> Result<HostMessage<'a>, DecodeError> {
    HostMessage::decode(frame)
}

impl<'a> Input<'a> {
    /// Makes the input for a frame that arrived from the host. `rig` judges its message, as [`Input::Received`] says.
    pub fn received(frame: &Frame<'a>, rig: impl FnOnce(&HostMessage<'a>) -> AckCode) -> Self {
        match message(frame) {
            Ok(message) => Self::Received { id: frame.id(), rig: rig(&message), message },
            Err(_) => Self::Malformed(frame.id(), frame.kind()),
        }
    }
}

/// Report of the rig or its operator.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Report {
    /// The upload buffer answered with this code to what it was told to [store](super::Event::Store).
    Stored(Store, AckCode),
    /// These motors move now. The status tells it; nothing else follows.
    Moving(Motors),
    /// All motors rest: the last target is reached, or the stop is complete. The rig answers so to each
    /// [`Event`](super::Event) that moves or stops motors, once, even if nothing had to move.
    AtRest,
    /// A run or a jog of all motors has come to this frame of the film.
    AtFrame(FrameNumber),
    /// A run has come to the end of a pass; or a shot is done, and the shutter is closed.
    PassEnd,
    /// The operator's own switch says "go".
    OperatorGo,
    /// A motor ran into its limit switch.
    Limit {
        /// The motor.
        motor: Motor,
        /// Whether it is the upper limit.
        upper: bool,
    },
    /// The emergency stop was pressed (`true`) or released.
    EmergencyStop(bool),
    /// The motion engine gave up, because of this motor or of itself.
    Fault(Option<Motor>),
    /// The general purpose inputs changed: these are on now. The rig has to debounce them.
    Inputs(Triggers),
    /// The rig aims at another point by itself.
    Aimed,
}

impl From<Report> for Input<'_> {
    fn from(report: Report) -> Self {
        Self::Rig(report)
    }
}
