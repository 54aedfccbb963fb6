//! The sequence that a host follows: an upload or a run.

use motion_core::machine::Token;
use motion_core::time::Millis;

use super::options::Options;
use super::progress::{Next, Progress};
use super::requests::Reply;
use super::run::Run;
use super::upload::Upload;

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

impl Sequence {
    /// Next step after an answer.
    pub(super) fn answered(&mut self, now: Millis, options: &Options, reply: &Reply<'_>) -> Next {
        match &mut self.course {
            Course::Upload(upload) => upload.answered(self.token, reply),
            Course::Run(run) => run.answered(now, options, self.token, reply),
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

    /// The run, if motors move in the sequence.
    pub(super) const fn run(&mut self) -> Option<&mut Run> {
        match &mut self.course {
            Course::Run(run) => Some(run),
            Course::Upload(_) => None,
        }
    }
}
