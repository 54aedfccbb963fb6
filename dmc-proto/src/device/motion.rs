//! What the motors do: DMC D2 and D3.

use motion_core::time::Millis;

use crate::message::{AckCode, FrameNumber, Motors};

/// What a device is doing, for those who look at it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum State {
    /// Nothing: all motors stand.
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
    /// A run or a shot.
    Running,
    /// All motors come to rest behind a run or a shot.
    PostRoll,
    /// A hard stop: no motor may move for now.
    Locked,
}

impl State {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Idle,
        Self::Moving,
        Self::Stopping,
        Self::ToFrame,
        Self::JogAll,
        Self::PreRoll,
        Self::Ready,
        Self::Running,
        Self::PostRoll,
        Self::Locked,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "Idle",
            Self::Moving => "Moving",
            Self::Stopping => "Stopping",
            Self::ToFrame => "ToFrame",
            Self::JogAll => "JogAll",
            Self::PreRoll => "PreRoll",
            Self::Ready => "Ready",
            Self::Running => "Running",
            Self::PostRoll => "PostRoll",
            Self::Locked => "Locked",
        }
    }
}

/// What a device is doing, with all that belongs to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(super) enum Motion {
    #[default]
    Idle,
    Moving,
    /// Until then, a second stop is a harder one.
    Stopping(Option<Millis>),
    ToFrame(FrameNumber),
    /// Where it is, and where it ends.
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

    /// Whether positions are to be told now and then.
    pub(super) const fn is_in_motion(&self) -> bool {
        match self {
            Self::Idle | Self::Ready(_) => false,
            Self::Locked(lock) => !lock.is_at_rest,
            _ => true,
        }
    }

    /// The run or shot.
    pub(super) const fn job(&self) -> Option<Job> {
        match self {
            Self::PreRoll(job) | Self::Ready(job) | Self::Running(job) | Self::PostRoll(job) => Some(*job),
            _ => None,
        }
    }

    /// Whether all motors of the uploaded move act as one; with those of a run or shot, if it has its own.
    pub(super) fn coordinated(&self, axes: Motors) -> Option<Motors> {
        match self {
            Self::ToFrame(_) | Self::JogAll(..) => Some(axes),
            _ => self.job().map(|job| job.axes),
        }
    }
}

/// A run or a shot, once it was accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Job {
    pub(super) kind: JobKind,
    /// Where the pass begins.
    pub(super) from: FrameNumber,
    /// Where the pass ends.
    pub(super) to: FrameNumber,
    /// The frame it has come to.
    pub(super) at: FrameNumber,
    /// The motors that take part.
    pub(super) axes: Motors,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum JobKind {
    Shot,
    Once,
    Loop,
    PingPong,
}

impl Job {
    /// The pass behind this one; `None` if this is the last.
    pub(super) fn next(self) -> Option<Self> {
        match self.kind {
            JobKind::Shot | JobKind::Once => None,
            JobKind::Loop => Some(Self { at: self.from, ..self }),
            JobKind::PingPong => Some(Self { from: self.to, to: self.from, at: self.to, ..self }),
        }
    }

    /// The same, ending with its pass.
    pub(super) fn last(self) -> Self {
        let kind = if self.kind == JobKind::Shot { JobKind::Shot } else { JobKind::Once };
        Self { kind, ..self }
    }
}

/// A hard stop, until it is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Lock {
    /// What requests are answered.
    pub(super) code: AckCode,
    /// Whether the emergency stop is pressed.
    pub(super) is_pressed: bool,
    /// Whether all motors stand.
    pub(super) is_at_rest: bool,
    /// Until then it lasts at least.
    pub(super) until: Option<Millis>,
}

impl Lock {
    /// Whether it is over: all motors have stood for a while, and the emergency stop is released. A limit switch may still
    /// be pressed: the motor has to be driven off it.
    pub(super) const fn is_over(&self) -> bool {
        self.is_at_rest && self.until.is_none() && !self.is_pressed
    }
}
