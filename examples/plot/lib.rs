//! Drawings as SVG and PNG: position, velocity and acceleration of each axis of a move over time, and the positions of
//! each motor that a capture has.

//!
//! The feature `draw`, on by default, has the drawing library. Without it, the curves remain, for a program that draws them
//! itself.

#[cfg(feature = "draw")]
mod draw;
#[cfg(feature = "draw")]
mod figure;
#[cfg(feature = "draw")]
mod label;
#[cfg(feature = "draw")]
mod played;
pub mod trace;

#[cfg(feature = "draw")]
pub use draw::{Recording, Subject, Track, png, svg};
#[cfg(feature = "draw")]
pub use played::{Played, played};
