//! The side that moves: what a controller answers, and what its motors shall do.
//!
mod io;
mod machine;
mod motion;
mod motors;
mod options;
mod real_time;
mod stops;
mod upload;

pub use io::{EVENTS, Event, Input, Output, Rig, SENDS, Scratch, Send, Stop, What};
pub use machine::DeviceMachine;
pub use motion::State;
pub use options::{Options, Quirks};
pub use upload::Store;
