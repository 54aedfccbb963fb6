//! Progress of a sequence, and its next step.

use motion_core::states;

use super::event::{Event, Outcome};
use super::requests::Request;

states! {
    /// Progress of a sequence.
    #[non_exhaustive]
    pub enum Progress {
        /// A move is uploaded.
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
        Armed,
        /// The signal to start is on its way.
        Goes,
        /// The device runs or shoots.
        Runs,
        /// The motors come to rest.
        Ends,
    }
}

/// Next step of a sequence, which has at most one request under way.
#[derive(Clone, Copy)]
pub(super) enum Next {
    Wait,
    Ask(Request),
    Tell(Event<'static>),
    End(Outcome<'static>),
}
