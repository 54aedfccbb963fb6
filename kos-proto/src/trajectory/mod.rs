//! Moves: planned in seconds and rotations, written as blocks, read back, and checked before they are played.
//!
//! On the wire a move is a list of [`Blocks`]: one [`Playback`], one [`TimeLapse`] (zeros in a live move), and for each
//! motor an [`Axis`] with its [`Segment`]s. A segment is a Bézier curve of time and position, both from 0 to 1. Blocks
//! are read in any order, and unknown blocks are kept.
//!
//! A [`Plan`] describes a move in the units of its user. It makes the blocks, or an error that names the fault, its
//! place and its size. A [`Trajectory`] is the meaning of blocks: how they are [played](Play), and the [`Track`] of
//! each motor. A track gives its key frames, the position at any time, and the speeds and accelerations to compare with
//! the [limits](Limits) of the motor. The rules of a move are written once; the builder, the reader and
//! [`lint`](crate::HostMessage::lint) all use them.
//!
//! ```
//! use kos_proto::message::{MotorAddress, Normalized, Rotations, Seconds};
//! use kos_proto::trajectory::bezier::{Ease, Key};
//! use kos_proto::trajectory::{Delay, LiveMotion, Loop, MotorPlan, Plan, Play, Times, Trajectory, Way};
//!
//! // Ten seconds from rest to rest, and back, three times; then home at a fifth of the greatest speed.
//! let (duration, home_speed) = (Seconds(10.0), Normalized(0.2));
//! let repeat = Loop::Reverse(Times::new(3).expect("1 to 254"));
//! let play = Play::Live(LiveMotion { duration, repeat, delay: Delay::For(Seconds(5.0)), home_speed });
//! let key = |time, position| Key { time, position, arrive: Ease::Flat(0.4), leave: Ease::Flat(0.4) };
//! let keys = [key(0.0, 4.0), key(10.0, 40.0)];
//! let slider = MotorPlan { motor: MotorAddress(1), way: Way::Keys { range: Rotations(50.0), keys: &keys } };
//!
//! let mut out = [0; Plan::MAX_LEN];
//! let data = Plan::new(play, &[slider]).encode(&mut out)?;
//!
//! // The device reads the move from the same bytes.
//! let trajectory = Trajectory::new(&data)?;
//! assert_eq!(trajectory.play().total_time(), Some(75.0));
//! let track = trajectory.track(MotorAddress(1)).expect("planned").in_rotations(Rotations(50.0))?;
//! let middle = track.at(5.0).expect("it has segments");
//! assert!((middle.position - 22.0).abs() < 1e-5);
//! let peaks = track.peaks().next().expect("one segment");
//! assert!(peaks.speed.is_some_and(|speed| speed < 8.0));
//! # Ok::<(), kos_proto::trajectory::MoveError>(())
//! ```
//!
//! # Open questions
//!
//! No public program sends moves, so all of this follows from the specification alone. It is not known what a device
//! does with handles outside the range, how it counts photos, and how long it needs to reach the start. Test moves
//! small and slow at first, with a hand on the emergency stop.
//!
//! Source: kOS, `TrajectoryData`; decisions K-B2 and K-J1 to K-J11.

mod blocks;
mod error;
mod limits;
mod overshoot;
mod plan;
mod play;
mod reverse;
pub(crate) mod rules;
mod values;
mod view;

pub use blocks::{Axis, Block, BlockIter, Blocks, Playback, Segment, TimeLapse, TrajectoryData};
pub use error::{Amount, MoveError, Place};
pub use limits::{Excess, Limits, Peaks};
pub use motion_core::bezier;
pub use plan::{MotorPlan, Plan, Way};
pub use play::{Delay, LiveMotion, Loop, Play, Style, TimeLapseMotion, Times};
pub use values::{DelayInterval, DelayMode, LoopCount, Point, Points};
pub use view::{Track, Trajectory};
