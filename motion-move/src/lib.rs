#![doc = include_str!("../README.md")]
//!
//! # The file
//!
//! A JSON Schema of the file is in `schema/move-1.json`.
//!
//! The file is an object; a member that is not named here is an error. Names have 1 to 80 characters, units 1 to 12.
//!
//! | member | meaning |
//! |---|---|
//! | `move` | 1, the version of this schema |
//! | `name` | the name of the move |
//! | `rate` | frames per second: `24`, `23.976`, or an exact fraction as text, `"24000/1001"` |
//! | `duration` | duration of the move, in seconds; by default, it ends at its last key frame |
//! | `axes` | 1 to 64 axes with different names |
//!
//! An axis has these members:
//!
//! | member | meaning |
//! |---|---|
//! | `name`, `unit` | labels; `unit` is the unit of all positions of the axis |
//! | `keys` | at least two key frames, in the order of time. Before the first and after the last, the axis rests, so a curve that begins or ends in motion has a corner there |
//! | `limits` | limits of the axis: `velocity` (units per second), `acceleration` (units per second²), and optionally `jerk` (units per second³). Curves are compared with the first two; moves that the rig makes on its own, such as the move to the start, respect all three |
//! | `kos` | if a kOS motor moves the axis: `motor`, its address from 1 to 10; `rotations_per_unit`; `offset`, its rotations at position 0 (default 0); `range`, its calibrated range as two numbers of rotations |
//! | `dmc` | if a DMC motor moves the axis: `motor`, its number from 1 to 32; `steps_per_unit`; `offset`, its steps at position 0 (default 0) |
//! | `hoot` | the same for a motor of an NMX: `address` of its node from 2 to 255 (default 3); `motor` from 1 to 3; `steps_per_unit`; `offset` |
//!
//! A motor that runs against its axis has a negative `rotations_per_unit` or `steps_per_unit`.
//!
//! A key frame has these members:
//!
//! | member | meaning |
//! |---|---|
//! | `time`, `position` | position of the axis in units, and its time in seconds from the start of the move, 0 or more |
//! | `arrive`, `leave` | the ease on either side of it |
//! | `ease` | the ease on each side that has no ease of its own |
//!
//! An ease has one of these values:
//!
//! | value | meaning |
//! |---|---|
//! | `"smooth"` | the default: through the key frame without a corner, and never beyond the positions of its neighbours; at rest at the first and the last key frame, and where the axis changes its direction |
//! | `"linear"` | straight towards the other key frame |
//! | a number from 0 to 1 | to rest or from rest, with a flat handle whose length is this part of the time between the key frames |
//! | `[seconds, units]` | a Bezier handle, as its distance from the key frame: positive seconds to leave, negative seconds to arrive, and not beyond the other key frame |

#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(
    not(test),
    deny(
        clippy::arithmetic_side_effects,
        clippy::cast_possible_truncation,
        clippy::expect_used,
        clippy::indexing_slicing,
        clippy::panic,
        clippy::unwrap_used
    )
)]

mod axis;
#[cfg(any(feature = "kos", feature = "dmc", feature = "hoot"))]
mod bound;
#[cfg(feature = "dmc")]
pub mod dmc;
mod ease;
mod error;
mod file;
#[cfg(feature = "hoot")]
pub mod hoot;
mod key;
#[cfg(feature = "kos")]
pub mod kos;
mod limits;
mod loss;
mod motor;
mod moves;
mod object;
#[cfg(feature = "schema")]
mod schema;
mod text;
mod write;

pub use axis::{AxisBuilder, MoveAxis};
pub use error::{AxisProblem, LabelError, MotorProblem, MoveError, MoveProblem};
pub use key::{Ease, KeyFrame};
pub use limits::{Excess, ExcessKind};
pub use loss::{Loss, LossKind};
pub use motor::{Dmc, Hoot, Kos, Rotations};
pub use moves::Move;
#[cfg(feature = "schema")]
pub use schema::schema;

#[cfg(test)]
mod tests;
