//! Upload of moves: a host cuts a move into sections, and a device assembles it from them.
//!
//! A host describes its move by a [`MoveSource`], which gives the value of a track at a frame. [`sections`] lists the
//! sections of the move, and [`Section::message`] makes the message of one section. A section is a few bytes that
//! borrow nothing. To send a section again, make its message again.
//!
//! A device has an [`UploadBuffer`] over its own memory. The buffer takes the messages in any order and any number of
//! times, gives the answer to each, and gives the values of each frame once the upload is complete.
//!
//! ```
//! use dmc_proto::lint::Context;
//! use dmc_proto::message::{AckCode, FrameNumber, Motor, Motors, RtUploadMoveEnd, Steps};
//! use dmc_proto::upload::{self, Memory, MoveSource, Room, SCRATCH, SectionSize, Track, UploadBuffer};
//! use dmc_proto::HostMessage;
//!
//! /// Motor 3 moves from 0 to 4000 steps in frames 1 to 5, and stays there.
//! struct Ramp;
//!
//! impl MoveSource for Ramp {
//!     fn start_frame(&self) -> FrameNumber {
//!         FrameNumber(1)
//!     }
//!     fn frame_count(&self) -> u32 {
//!         100
//!     }
//!     fn motors(&self) -> Motors {
//!         Motors::from_iter([Motor(3)])
//!     }
//!     fn position(&self, _: Motor, index: u32) -> Steps {
//!         Steps(1000 * index.min(4) as i32)
//!     }
//! }
//!
//! // The device: room for 4 motors, no lights, 1000 frames.
//! const ROOM: Room = Room { motors: 4, channels: 0, frames: 1000 };
//! let mut positions = vec![0; ROOM.positions()];
//! let mut written = vec![0; ROOM.written()];
//! let memory = Memory { positions: &mut positions, levels: &mut [], triggers: &mut [], written: &mut written };
//! let mut buffer = UploadBuffer::new(ROOM, memory)?;
//!
//! // The host: each message that it would send goes directly to the device.
//! let mut send = |message: &HostMessage<'_>| assert_eq!(buffer.receive(message), Some(AckCode::OK));
//! let mut scratch = [0; SCRATCH];
//! send(&upload::begin(&Ramp, &Context::default())?.into());
//! for section in upload::sections(&Ramp, SectionSize::default()) {
//!     send(&section.message(&Ramp, &mut scratch));
//! }
//! send(&RtUploadMoveEnd::default().into());
//!
//! assert_eq!(buffer.position(Motor(3), 2), Some(Steps(2000)));
//! assert_eq!(buffer.position(Motor(3), 99), Some(Steps(4000)), "held to the end, although it was not sent");
//! assert_eq!(buffer.position(Motor(1), 2), None, "not part of the move, so it must not move");
//! assert_eq!(buffer.gaps(Track::Axis(Motor(3))).next(), None);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Source: DMC, Uploading a Move; safety decisions 5 and 6, decisions D-10, D-31, D-32 and D-33.

mod buffer;
mod rows;
mod section;
mod source;

pub use buffer::{Memory, Room, RoomError, UploadBuffer};
pub use rows::Gaps;
pub use section::{SCRATCH, Section, SectionSize, sections};
pub use source::{MoveSource, NoMove, Track, begin};

/// Greatest number of frames in a move. Their indices, from 0, leave bit 31 free (decision D-32).
pub const MAX_FRAMES: u32 = 0x8000_0000;
