//! Motion of a device: DMC D2 and D3.

use motion_core::states;
use motion_core::time::Millis;

use crate::message::{AckCode, FrameNumber, Motors};

states! {
    /// State of a device: what its motors do.
    #[non_exhaustive]
    pub enum State {
        /// All motors rest.
        Idle,
        /// Motors move, each for itself.
        Moving,
        /// Motors come to rest, because they were told to stop.
        Stopping,
        /// All motors of the uploaded move go to a frame.
        ToFrame,
        /// All motors run along the uploaded move.
        JogAll,
        /// All motors go to where a run or a shot begins.
        PreRoll,
        /// The device waits for the signal to start.
        Ready,
        /// The device runs or shoots.
        Running,
        /// All motors come to rest after a run or a shot.
        PostRoll,
        /// No motor may move for now, because of a hard stop.
        Locked,
    }
}

/// State of a device, with all that belongs to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(super) enum Motion {
    #[default]
    Idle,
    Moving,
    /// Until this time a second stop is a harder one.
    Stopping(Option<Millis>),
    ToFrame(FrameNumber),
    /// Frame that it has come to, and frame where it ends.
    JogAll(FrameNumber, FrameNumber),
    PreRoll(Job),
    Ready(Job),
    Running(Job),
    PostRoll(Job),
    Locked(Lock),
}

impl Motion {
    pub(super) const fn state(&self) -> State {
        match self {
            Self::Idle => State::Idle,
            Self::Moving => State::Moving,
            Self::Stopping(_) => State::Stopping,
            Self::ToFrame(_) => State::ToFrame,
            Self::JogAll(..) => State::JogAll,
            Self::PreRoll(_) => State::PreRoll,
            Self::Ready(_) => State::Ready,
            Self::Running(_) => State::Running,
            Self::PostRoll(_) => State::PostRoll,
            Self::Locked(_) => State::Locked,
        }
    }

    /// Whether positions are reported regularly.
    pub(super) const fn is_in_motion(&self) -> bool {
        match self {
            Self::Idle | Self::Ready(_) => false,
            Self::Locked(lock) => !lock.is_at_rest,
            _ => true,
        }
    }

    /// Whether motors move, or may begin to without another request.
    pub(super) const fn may_move(&self) -> bool {
        self.is_in_motion() || matches!(self, Self::Ready(_))
    }

    /// The run or shot, if there is one.
    pub(super) const fn job(&self) -> Option<Job> {
        match self {
            Self::PreRoll(job) | Self::Ready(job) | Self::Running(job) | Self::PostRoll(job) => Some(*job),
            _ => None,
        }
    }

    /// Motors that act as one: those of the uploaded move (`axes`), or those of the run or shot. `None` if motors move each
    /// for itself.
    pub(super) fn coordinated(&self, axes: Motors) -> Option<Motors> {
        match self {
            Self::ToFrame(_) | Self::JogAll(..) => Some(axes),
            _ => self.job().map(|job| job.axes),
        }
    }
}

/// A run or a shot that was accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Job {
    pub(super) kind: JobKind,
    /// Frame where the pass begins.
    pub(super) from: FrameNumber,
    /// Frame where the pass ends.
    pub(super) to: FrameNumber,
    /// Frame that it has come to.
    pub(super) at: FrameNumber,
    /// Motors that take part.
    pub(super) axes: Motors,
    /// Whether the shutter is opened.
    pub(super) opens_shutter: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum JobKind {
    Shot,
    Once,
    Loop,
    PingPong,
}

impl Job {
    /// The next pass; `None` if this is the last one.
    pub(super) fn next(self) -> Option<Self> {
        match self.kind {
            JobKind::Shot | JobKind::Once => None,
            JobKind::Loop => Some(Self { at: self.from, ..self }),
            JobKind::PingPong => Some(Self { from: self.to, to: self.from, at: self.to, ..self }),
        }
    }

    /// The same job, ending with its pass.
    pub(super) fn last(self) -> Self {
        let kind = if self.kind == JobKind::Shot { JobKind::Shot } else { JobKind::Once };
        Self { kind, ..self }
    }
}

/// Lock after a hard stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Lock {
    /// Code with which requests are answered.
    pub(super) code: AckCode,
    /// Whether the emergency stop is pressed.
    pub(super) is_pressed: bool,
    /// Whether all motors rest.
    pub(super) is_at_rest: bool,
    /// Time until which the lock lasts at least.
    pub(super) until: Option<Millis>,
    /// Whether a stop made the lock. Its time counts from the stop, and not from rest.
    pub(super) is_stop: bool,
}

impl Lock {
    /// Whether the lock is over: all motors have rested for a while, and the emergency stop is released. A limit switch may
    /// still be pressed, because the motor has to be driven off it.
    pub(super) const fn is_over(&self) -> bool {
        self.is_at_rest && self.until.is_none() && !self.is_pressed
    }
}
