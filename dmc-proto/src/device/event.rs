//! Events of a device's machine: what the rig has to do, and what it is told.

use motion_core::display;

use crate::frame::{MessageId, MessageType};
use crate::message::{FrameNumber, FramesPerSecond, HostMessage, JogSpeed, Motor, Steps, VirtualMotor};

/// Something that the rig has to do, or is told.
///
/// An event stands before the message that acknowledges it: the rig acts before the host is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Event<'a> {
    /// Stop. A later stop never makes this one softer.
    Stop(StopKind),
    /// Switch off all outputs of the uploaded move (safety decision 6).
    TriggersOff,
    /// Do what this message says: it sets something.
    Apply(HostMessage<'a>),
    /// Give this message to the upload buffer, and give the buffer's answer to the machine as
    /// [`Report::Stored`](super::Report::Stored).
    Store {
        /// Name of the message, for the answer.
        store: Store,
        /// The message.
        message: HostMessage<'a>,
    },
    /// Send a motor to a position.
    Move(Motor, Steps),
    /// Run a motor towards a position, and come to rest there, or at a limit that was set.
    Jog(Motor, JogSpeed, Steps),
    /// Move virtual motors as this message says, or aim with them.
    MoveVirtual(HostMessage<'a>),
    /// Send all motors of the uploaded move to a frame, instead of what they do.
    ToFrame(FrameNumber),
    /// Run all motors along the uploaded move, to a frame.
    JogAll(FramesPerSecond, FrameNumber),
    /// Get ready for the run or shot of this message, and rest where it begins.
    Prepare(HostMessage<'a>),
    /// Begin the run or shot that was prepared. For a shot, also move the shutter.
    Go,
    /// Begin the next pass of the run, from one frame to another.
    NextPass(FrameNumber, FrameNumber),
    /// The pass that runs is the last one.
    LastPass,
    /// The run or shot is over: come to rest after it, with the shutter closed.
    PostRoll,
    /// The device takes requests again, after a hard stop.
    Unlocked,
    /// An acknowledgement arrived, which only devices send. It is not answered (decision D-5).
    Acknowledgement(MessageId, MessageType),
    /// The rig reported something that does not fit what it was told. Nothing was done.
    UnexpectedReport,
}

impl Event<'_> {
    /// Returns the same event if it can be kept; `None` if it lends a message of the host.
    #[must_use]
    pub const fn to_static(&self) -> Option<Event<'static>> {
        Some(match *self {
            Self::Apply(_) | Self::Store { .. } | Self::MoveVirtual(_) | Self::Prepare(_) => return None,
            Self::Stop(kind) => Event::Stop(kind),
            Self::TriggersOff => Event::TriggersOff,
            Self::Move(motor, position) => Event::Move(motor, position),
            Self::Jog(motor, speed, position) => Event::Jog(motor, speed, position),
            Self::ToFrame(frame) => Event::ToFrame(frame),
            Self::JogAll(speed, frame) => Event::JogAll(speed, frame),
            Self::Go => Event::Go,
            Self::NextPass(from, to) => Event::NextPass(from, to),
            Self::LastPass => Event::LastPass,
            Self::PostRoll => Event::PostRoll,
            Self::Unlocked => Event::Unlocked,
            Self::Acknowledgement(id, kind) => Event::Acknowledgement(id, kind),
            Self::UnexpectedReport => Event::UnexpectedReport,
        })
    }
}

/// Kind of a stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum StopKind {
    /// One motor, with its own deceleration.
    Motor(Motor),
    /// One virtual motor.
    Virtual(VirtualMotor),
    /// Everything: all motors, and the shutter.
    All {
        /// Whether the device shows no warning (safety decision 4).
        silent: bool,
    },
    /// Everything, harder, because it is the second stop within a second.
    Harder,
    /// Everything, as fast as possible: a limit switch, a fault, the emergency stop.
    Hard,
}

display! {
    Event<'_> {
        Stop(kind) => "stop {kind}";
        TriggersOff => "switch off all outputs of the uploaded move";
        Apply(message) => "apply {message}";
        Store { message, .. } => "store {message}";
        Move(motor, position) => "move motor {motor} to {position} steps";
        Jog(motor, speed, position) => "jog motor {motor} at {speed} % towards {position} steps";
        MoveVirtual(message) => "move virtual motors: {message}";
        ToFrame(frame) => "go to frame {frame}";
        JogAll(speed, frame) => "jog all motors of the uploaded move at {speed} frames/s to frame {frame}";
        Prepare(message) => "prepare {message}";
        Go => "begin the run or shot";
        NextPass(from, to) => "begin the next pass, from frame {from} to frame {to}";
        LastPass => "the pass that runs is the last one";
        PostRoll => "the run or shot is over";
        Unlocked => "the device takes requests again";
        Acknowledgement(id, kind) => "acknowledgement {id} of type {kind} is not answered";
        UnexpectedReport => "the report does not fit what the rig was told";
    }

    StopKind {
        Motor(motor) => "motor {motor}";
        Virtual(motor) => "virtual motor {motor}";
        All { silent: false } => "everything";
        All { silent: true } => "everything, without warnings";
        Harder => "everything, harder";
        Hard => "everything, as fast as possible";
    }
}

/// Name of a message of an upload that is to be stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
pub struct Store {
    pub(super) id: MessageId,
    pub(super) kind: MessageType,
    pub(super) part: Part,
}

/// Part of an upload.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
pub(super) enum Part {
    Begin(FrameNumber, FrameNumber),
    Axis(Motor),
    Other,
    End,
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn an_event_prints_what_the_rig_has_to_do() {
        assert_eq!(Event::Stop(StopKind::All { silent: true }).to_string(), "stop everything, without warnings");
        let jog = Event::Jog(Motor(1), JogSpeed::FULL, Steps(-200));
        assert_eq!(jog.to_string(), "jog motor 1 at 100.00 % towards -200 steps");
        assert_eq!(
            Event::NextPass(FrameNumber(1), FrameNumber(24)).to_string(),
            "begin the next pass, from frame 1 to frame 24"
        );
    }
}
