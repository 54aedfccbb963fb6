//! Models of host and device of each protocol for a model checker, which explores every order of events within stated
//! bounds.
//!
//! A model is a world of two machines, the [lines](laws::world::Line) between them, a rig that is as simple as possible, and
//! an application that may make the requests of a short list. Each action is one event: a message arrives or is lost, a
//! timer runs out, a motor arrives, the application stops. Time advances only to the next moment at which a machine
//! asks to be woken.
//!
//! The properties that must hold are in `tests/`, with the number of states that were explored.

pub mod dmc;
pub mod hoot;
pub mod kos;
