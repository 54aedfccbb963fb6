//! The side that controls.
mod commands;
mod io;
mod machine;
mod options;
mod requests;
mod run;
mod sequence;
mod stops;
mod upload;

pub use io::{Command, EVENTS, Event, Failure, Input, Name, Outcome, Output, SENDS, Send, Token, What};
pub use machine::{HostMachine, State};
pub use options::{MAX_WINDOW, Options, Times};
pub use requests::MAX_QUEUE;
pub use sequence::Progress;
pub use stops::Stop;
