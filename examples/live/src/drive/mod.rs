//! What the program `drive` does, and what a host must know for it.

pub mod address;
pub mod command;
pub mod dmc;
pub mod hoot;
pub mod kos;
pub mod printer;
pub mod program;

use motion_core::time::Millis;
use rigs::Host;

pub use command::Command;

/// A host that can be driven by hand: it knows how to stop everything, and whether it should.
pub trait Driven: Host {
    /// Whether it asks for its line by itself, and again when it is lost; otherwise a lost line is the end.
    const OPENS: bool;

    /// Whether something that was set in motion here is not known to rest.
    fn may_move(&self) -> bool;

    /// Stops everything, by the emergency rules of the protocol.
    fn stop_all(&mut self, now: Millis);

    /// What an event says of that stop.
    fn stopped(event: &Self::Event) -> Option<Stopped>;
}

/// How a stop went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stopped {
    /// The rig confirmed it.
    Confirmed,
    /// The rig did not confirm it, so far.
    NotConfirmed,
}

/// Why a command was not done, in one line that says what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Trouble {
    /// Somebody pressed Ctrl-C.
    #[error("interrupted")]
    Interrupted,
    /// There is no line to the rig, or none any more.
    #[error("{0}")]
    Line(String),
    /// The rig, or the protocol, does not allow it.
    #[error("{0}")]
    Refused(String),
    /// The rig does not do what it was told.
    #[error("{0}")]
    Failed(String),
}
