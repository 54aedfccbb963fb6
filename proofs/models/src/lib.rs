//! Host and device of each protocol, explored together by a model checker: every order of what may happen, within
//! stated bounds.
//!
//! A model is a world of two machines, the [lines](line::Line) between them, a rig that is as simple as can be, and an
//! application that may ask for anything of a short list. Each of its actions is one thing that happens: a message
//! arrives or is lost, a timer runs out, a motor arrives, somebody says "stop". Time is what the machines wait for: it
//! jumps to the next moment that one of them asked to be woken at.
//!
//! What has to hold is said as properties, with a count of the states that were explored, in `tests/`.

pub mod dmc;
pub mod hoot;
pub mod kos;
pub mod line;
