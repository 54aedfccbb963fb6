//! What the sequences have in common.

use motion_core::time::Millis;

use super::io::{Event, Failure, Token};
use super::options::Options;
use super::requests::Request;
use super::run::Run;
use super::upload::Upload;
use crate::message::Motors;

/// The sequence that runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Sequence {
    pub(super) token: Token,
    pub(super) course: Course,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Course {
    Upload(Upload),
    Run(Run),
}

/// How far a sequence is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Progress {
    /// A move is being uploaded.
    Uploads,
    /// The device is asked to go to the first frame.
    ToStart,
    /// The motors are on their way to the first frame.
    Travels,
    /// The device is asked to begin.
    Begins,
    /// The motors are on their way to where the run or shot begins.
    PreRoll,
    /// The device waits for the signal to start.
    Ready,
    /// The signal to start is on its way.
    Goes,
    /// The run or shot.
    Runs,
    /// The motors come to rest.
    Ends,
}

impl Progress {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Uploads,
        Self::ToStart,
        Self::Travels,
        Self::Begins,
        Self::PreRoll,
        Self::Ready,
        Self::Goes,
        Self::Runs,
        Self::Ends,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Uploads => "Uploads",
            Self::ToStart => "ToStart",
            Self::Travels => "Travels",
            Self::Begins => "Begins",
            Self::PreRoll => "PreRoll",
            Self::Ready => "Ready",
            Self::Goes => "Goes",
            Self::Runs => "Runs",
            Self::Ends => "Ends",
        }
    }
}

/// How a request of a sequence ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reply {
    Acknowledged,
    Answered,
    Moving(Motors),
    Failed(Failure),
}

/// What a sequence does next. It has at most one request on its way.
#[derive(Clone, Copy)]
pub(super) enum Next {
    Wait,
    Ask(Request),
    Tell(Event),
    Done,
    Failed(Failure),
}

impl Sequence {
    pub(super) fn answered(&mut self, now: Millis, reply: Reply, options: &Options) -> Next {
        match &mut self.course {
            Course::Upload(upload) => upload.answered(reply),
            Course::Run(run) => run.answered(now, self.token, reply, options),
        }
    }

    pub(super) const fn progress(&self) -> Progress {
        match &self.course {
            Course::Upload(_) => Progress::Uploads,
            Course::Run(run) => run.progress(),
        }
    }

    pub(super) fn wake(&self) -> Option<Millis> {
        match &self.course {
            Course::Upload(_) => None,
            Course::Run(run) => run.wake(),
        }
    }

    /// What moves motors, if it does.
    pub(super) fn run(&mut self) -> Option<&mut Run> {
        match &mut self.course {
            Course::Run(run) => Some(run),
            Course::Upload(_) => None,
        }
    }
}
