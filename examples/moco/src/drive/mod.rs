//! Command `drive`, and the trait of the hosts that it uses.

pub mod address;
pub mod command;
pub mod dmc;
pub mod foreign;
pub mod hoot;
pub mod kos;
pub mod output;
pub mod printer;
pub mod program;

use std::fmt;

use examples::program::{Failure, Status};
use motion_core::time::Millis;
use motion_rigs::Host;

pub use command::Command;

/// Host that can stop everything, and that knows whether a stop is needed.
pub trait Driven: Host {
    /// Whether the host [asks](motion_core::session::Session::ASKS) for its line, also after the line is lost. Otherwise a lost
    /// line ends the session.
    const ASKS: bool = false;

    /// Whether a motor that this host set in motion may still move, or a shutter that it opened may still be open.
    fn may_move(&self) -> bool;

    /// Whether the rig may ignore stops, so that it is useless to wait long for a confirmation.
    fn is_deaf(&self) -> bool {
        false
    }

    /// Stops everything, with the emergency stop of the protocol.
    fn stop_all(&mut self, now: Millis);

    /// Result of that stop, if the event contains it.
    fn stopped(event: &Self::Event) -> Option<Stopped>;

    /// Question whether motors move, which is asked after a stop of everything because of motors that an earlier session set in
    /// motion. `None` if a stop is only confirmed when all motors rest, or if the rig does not know the question.
    fn question(&self) -> Option<Self::Command> {
        None
    }

    /// Whether all motors rest, if the event contains the answer to that question.
    fn rest(event: &Self::Event) -> Option<bool> {
        let _ = event;
        None
    }
}

/// End of the line about a stop that is confirmed without the report that all motors rest.
pub const OBEYED: &str = "the rig confirmed the stop, but it does not say whether its motors rest: check that they do";

/// Result of a stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stopped {
    /// The rig confirmed the stop, and nothing may move any more.
    Confirmed,
    /// The rig confirmed the stop, and did not say in time that its motors rest.
    Obeyed,
    /// The rig has not confirmed the stop.
    NotConfirmed,
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Confirmed => "the rig confirmed the stop",
            Self::Obeyed => OBEYED,
            Self::NotConfirmed => "the stop is NOT confirmed: press the emergency stop",
        })
    }
}

/// Reason why a command was not done, in one line that says what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Trouble {
    /// Ctrl-C was pressed.
    #[error("interrupted")]
    Interrupted,
    /// There is no line to the rig.
    #[error("{0}")]
    Line(String),
    /// The line to the rig was lost.
    #[error("{0}")]
    Lost(String),
    /// The rig or the protocol does not allow the command.
    #[error("{0}")]
    Refused(String),
    /// The rig did not do the command.
    #[error("{0}")]
    Failed(String),
    /// The command line is wrong.
    #[error("{0}")]
    Usage(String),
    /// A motor may still move.
    #[error("{0}")]
    MayMove(String),
    /// The command was not done, and motors were stopped.
    #[error("{0}: {1}")]
    Stopped(Box<Self>, Stopped),
}

impl Trouble {
    /// Exit status of the program.
    #[must_use]
    pub fn status(&self) -> Status {
        match self {
            Self::Interrupted => Status::Interrupted,
            Self::Usage(_) => Status::Usage,
            Self::MayMove(_) | Self::Stopped(_, Stopped::Obeyed | Stopped::NotConfirmed) => Status::MayMove,
            Self::Stopped(trouble, Stopped::Confirmed) => trouble.status(),
            Self::Line(_) | Self::Lost(_) | Self::Refused(_) | Self::Failed(_) => Status::NotDone,
        }
    }
}

impl From<Trouble> for Failure {
    fn from(trouble: Trouble) -> Self {
        Self { status: trouble.status(), line: trouble.to_string() }
    }
}
