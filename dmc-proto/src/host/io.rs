//! What goes into a host's machine, and what comes out.

use motion_core::machine;

use super::stops::Stop;
use crate::frame::{Frame, MessageId, MessageType};
use crate::message::{
    AckCode, DeviceMessage, Empty, FrameNumber, HostMessage, Motor, Motors, RtPositionFrame, StopReason,
};
use crate::upload::Section;

/// The application's name for a request or a sequence. The machine only hands it back: the application chooses it, and
/// keeps the message that it stands for until the token is done or has failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Token(pub u32);

/// What happened to a host.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Input<'a> {
    /// The line is open.
    LinkUp,
    /// The line is gone.
    LinkDown,
    /// A message arrived.
    Received(MessageId, DeviceMessage<'a>),
    /// A sound frame arrived whose data end before the fields of its message do.
    Malformed(MessageId, MessageType),
    /// A frame with a wrong checksum arrived. Its request is left to its timeout.
    Corrupt,
    /// The application wants something.
    Command(Command<'a>),
    /// The section that was [asked for](Event::NextSection), or none behind the last one.
    Section(Option<Section>),
    /// The moment has come that the last output asked to be woken at.
    Wake,
}

impl<'a> Input<'a> {
    /// What a frame of the device's brings.
    #[must_use]
    pub fn frame(frame: &Frame<'a>) -> Self {
        match DeviceMessage::decode(frame) {
            Ok(message) => Self::Received(frame.id(), message),
            Err(_) => Self::Malformed(frame.id(), frame.kind()),
        }
    }
}

/// What the application wants.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Command<'a> {
    /// Greet the device again, after it was silent.
    Greet,
    /// The device is configured, once all that was asked is answered.
    Configured,
    /// Send a request, and tell how it ended. A stop is taken as [`Command::Stop`].
    Request(Token, HostMessage<'a>),
    /// Send what begins a sequence, and follow it to its end: `RtUploadMoveBegin` to the end of the upload,
    /// `RtPositionFrame` and `RtJogAll` until all motors stand, `RtRunMove` from its first frame on, `RtShootFrame` and
    /// `RtShootFrame2` until they are over. One sequence runs at a time.
    Sequence(Token, HostMessage<'a>),
    /// Start the run or shot that is [ready](Event::Ready).
    Go,
    /// Stop. It is sent at once, whatever waits.
    Stop(Stop),
    /// Give up stops that are not confirmed.
    EndStops,
}

/// What the application is told. The message that it is about, where there is one, has just been passed in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Event {
    /// The device said who it is. It may be configured now; nothing that moves is sent yet.
    Greeted,
    /// The device does not answer greetings. [`Command::Greet`] tries again, and a greeting at boot is taken.
    NoAnswer,
    /// Everything can be sent.
    Up,
    /// The line is gone, and all that was asked has failed.
    Closed,
    /// The device was reset: all that was asked has failed, uploads and configuration are forgotten.
    DeviceReset,
    /// A request or a sequence is done.
    Done(Token, Outcome),
    /// A request or a sequence has failed.
    Failed(Token, Failure),
    /// The upload wants the section behind this one, or the first: [`Input::Section`].
    NextSection(Option<Section>),
    /// The run or shot waits for [`Command::Go`], or for the operator.
    Ready(Token),
    /// The run or shot has begun.
    Started(Token),
    /// A pass of a loop is over.
    PassEnded(Token),
    /// The stop is obeyed.
    Stopped(Stop),
    /// A stop was not confirmed after three tries, or cannot be sent. It is tried again until it is, or given up by
    /// [`Command::EndStops`]. Whoever stands beside the rig has to press the emergency stop.
    StopNotConfirmed(Stop),
    /// The device stopped hard, and all that moves has failed.
    HardStop(StopReason, Option<Motor>),
    /// These motors move: asked after a request that must not be repeated was not answered.
    Moving(Motors),
    /// The device told something unasked: positions, inputs, virtual positions, an aim, an operator's start, an end.
    Unasked(MessageType),
    /// What arrived answers nothing that is still asked: a late answer, mostly.
    Stray(MessageId, MessageType),
    /// What arrived cannot be read: its data are too short, or its checksum is wrong.
    Unreadable,
    /// A command or a section that does not fit now was not taken.
    Ignored,
}

/// How a request was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Outcome {
    /// It was acknowledged.
    Acknowledged,
    /// It was answered by the message that was just passed in.
    Answered,
    /// The sequence has come to its end.
    Finished,
    /// It is a stop, which has events of its own.
    TakenAsStop,
}

/// Why a request was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Failure {
    /// The device said so.
    Refused(AckCode),
    /// The device acknowledged it without saying how it ended.
    Unclear,
    /// The device would say so, going by what it says of itself: nothing was sent.
    WouldBeRefused(AckCode),
    /// No answer, after all tries that it may have.
    Timeout,
    /// A stop came, or is not confirmed yet.
    Stopped,
    /// The device stopped hard.
    HardStop,
    /// The device was reset.
    DeviceReset,
    /// The line is not open, or the device not yet up.
    NotUp,
    /// Too many requests wait, or another sequence runs.
    Busy,
    /// It is part of a sequence, and cannot be sent by itself; or it begins none.
    Sequence,
}

/// A message to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Send {
    /// Its id.
    pub id: MessageId,
    /// What it says.
    pub what: What,
}

/// What a message of the host says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum What {
    /// Who are you?
    Greeting,
    /// Which motors move?
    Status,
    /// Stop.
    Stop(Stop),
    /// To a frame.
    ToFrame(FrameNumber),
    /// Start.
    Go,
    /// The upload is complete.
    UploadEnd,
    /// What only the application has.
    Named(Name),
}

/// The name of a message that the application makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Name {
    /// The message that was given with this token.
    Message(Token),
    /// This section of the move that is uploaded.
    Section(Section),
}

impl Send {
    /// The message. `named` makes those that only the application has, the same each time it is asked.
    pub fn message<'s>(&self, named: impl FnOnce(Name) -> HostMessage<'s>) -> HostMessage<'s> {
        match self.what {
            What::Named(name) => named(name),
            what => what.own().unwrap_or(HostMessage::MotorStatus(Empty { tail: &[] })),
        }
    }
}

impl What {
    /// The message, if the machine can make it by itself.
    pub(super) fn own(self) -> Option<HostMessage<'static>> {
        let empty = Empty { tail: &[] };
        Some(match self {
            Self::Greeting => HostMessage::Hi(empty),
            Self::Status => HostMessage::MotorStatus(empty),
            Self::Stop(stop) => stop.message(),
            Self::ToFrame(frame) => HostMessage::RtPositionFrame(RtPositionFrame { frame, tail: &[] }),
            Self::Go => HostMessage::RtGo(empty),
            Self::UploadEnd => HostMessage::RtUploadMoveEnd(empty),
            Self::Named(_) => return None,
        })
    }
}

/// Messages of one step at most: each place of the window and each stop once, two questions, and a greeting, rounded up.
pub const SENDS: usize = 12;
/// Events of one step at most: all that waits or is on its way fails, with the sequence and the reason, and no stop is
/// confirmed; rounded up.
pub const EVENTS: usize = 24;

/// What follows from a step, in this order: the messages are sent in theirs, so that a stop is the first of them.
pub type Output = machine::Output<Send, Event, SENDS, EVENTS>;
