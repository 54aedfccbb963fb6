//! Stages of the move of a device: stored, made ready, played.

use motion_core::states;
use motion_core::time::Millis;

use super::effects::Effects;
use super::event::Event;
use crate::message::{Direction, MotorSet};
use crate::move_summary::Shots;

states! {
    /// State of the move of a device.
    pub enum State {
        /// There is no move.
        Empty,
        /// A move is stored.
        Loaded,
        /// The move can be played. Its motors may be where it begins, or not.
        Ready,
        /// The motors go to where the move begins, to be ready.
        HomingSetup,
        /// The motors go to where the move begins, to play it at once.
        HomingStart,
        /// The motors go to where the move begins, and nothing follows.
        HomingRapid,
        /// The move waits for its time.
        Delay,
        /// The move is played from begin to end.
        Forward,
        /// The move is played from end to begin.
        Reverse,
        /// A time lapse takes the photos before the move.
        Pre,
        /// A time lapse takes photos while the motors move.
        ForwardC,
        /// Shoot, move, shoot: the motors rest, and the photo waits.
        FrameDelay,
        /// Shoot, move, shoot: the shutter is open.
        Exposing,
        /// Shoot, move, shoot: the motors go to the next place.
        Moving,
        /// A time lapse takes the photos after the move.
        Post,
    }
}

impl State {
    /// Whether a move runs, so that only a stop is followed (safety decision 1).
    #[must_use]
    pub const fn runs(self) -> bool {
        !matches!(self, Self::Empty | Self::Loaded | Self::Ready)
    }
}

/// Step that follows when all motors are home.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Next {
    /// The move is ready, and may be played at once.
    Setup { start: bool },
    /// The move is played.
    Start,
    /// Nothing: the move is loaded, or ready, as before.
    Rapid { ready: bool },
}

/// Stage of a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Stage {
    Empty,
    Loaded,
    /// `home`: the direction for which the motors are where the move begins.
    Ready {
        home: Option<Direction>,
    },
    Homing {
        next: Next,
        way: Direction,
        waiting: MotorSet,
        limit: Option<Millis>,
    },
    Delay {
        until: Millis,
        way: Direction,
    },
    Leg(Leg),
    Lapse(Lapse),
}

/// One pass through a live move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Leg {
    pub(super) way: Direction,
    /// Whether the pass goes back to where the move began.
    pub(super) back: bool,
    pub(super) from: Millis,
    pub(super) until: Millis,
    pub(super) progress: Option<Millis>,
}

/// Stage of a time lapse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Lapse {
    /// Photos before the move, and the number of those that are taken.
    Before { shot: Shot, taken: u32 },
    /// Photos while the motors move.
    Continuous(Shot),
    /// A photo while the motors rest.
    Frame(Shot),
    /// The motors go to the next place.
    Moving { waiting: MotorSet, limit: Option<Millis> },
    /// Photos after the move, and the number of those that are taken.
    After { shot: Shot, taken: u32 },
}

/// Photo: first it waits, then the shutter is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Shot {
    exposing: bool,
    until: Millis,
    /// Time at which the photo should be over. A wake that is late shortens no photo, and does not change the rhythm.
    pub(super) planned: Millis,
}

impl Shot {
    pub(super) fn wait(now: Millis, from: Millis, shots: Shots) -> Self {
        let planned = from.after(shots.delay);
        Self { exposing: false, until: planned.max(now.after(1)), planned }
    }

    /// Opens the shutter; `None` if it was open long enough.
    pub(super) fn open(self, now: Millis, output: &mut Effects<'_, '_>, shots: Shots) -> Option<Self> {
        if self.exposing {
            return None;
        }
        output.event(Event::OpenShutter { millis: shots.exposure });
        let until = now.after(shots.exposure.max(1));
        Some(Self { exposing: true, until, planned: self.planned.after(shots.exposure) })
    }
}

impl Stage {
    // The code of the machine is made in the program, because the machine has a parameter.
    #[inline]
    pub(super) const fn state(&self) -> State {
        match self {
            Self::Empty => State::Empty,
            Self::Loaded => State::Loaded,
            Self::Ready { .. } => State::Ready,
            Self::Homing { next: Next::Setup { .. }, .. } => State::HomingSetup,
            Self::Homing { next: Next::Start, .. } => State::HomingStart,
            Self::Homing { next: Next::Rapid { .. }, .. } => State::HomingRapid,
            Self::Delay { .. } => State::Delay,
            Self::Leg(Leg { way: Direction::Forward, .. }) => State::Forward,
            Self::Leg(Leg { way: Direction::Reverse, .. }) => State::Reverse,
            Self::Lapse(lapse) => lapse.state(),
        }
    }

    /// Next time at which something follows.
    #[inline]
    pub(super) fn deadline(&self) -> Option<Millis> {
        match *self {
            Self::Empty | Self::Loaded | Self::Ready { .. } => None,
            Self::Homing { limit, .. } => limit,
            Self::Delay { until, .. } => Some(until),
            Self::Leg(Leg { until, progress, .. }) => Some(progress.map_or(until, |progress| progress.min(until))),
            Self::Lapse(lapse) => lapse.deadline(),
        }
    }
}

impl Lapse {
    const fn state(self) -> State {
        match self {
            Self::Before { .. } => State::Pre,
            Self::Continuous(_) => State::ForwardC,
            Self::Frame(Shot { exposing: false, .. }) => State::FrameDelay,
            Self::Frame(Shot { exposing: true, .. }) => State::Exposing,
            Self::Moving { .. } => State::Moving,
            Self::After { .. } => State::Post,
        }
    }

    /// Photo that is being taken; `None` while the motors move to the next place.
    pub(super) fn shot_mut(&mut self) -> Option<&mut Shot> {
        match self {
            Self::Before { shot, .. } | Self::Continuous(shot) | Self::Frame(shot) | Self::After { shot, .. } => {
                Some(shot)
            }
            Self::Moving { .. } => None,
        }
    }

    const fn deadline(self) -> Option<Millis> {
        match self {
            Self::Before { shot, .. } | Self::Continuous(shot) | Self::Frame(shot) | Self::After { shot, .. } => {
                Some(shot.until)
            }
            Self::Moving { limit, .. } => limit,
        }
    }
}
