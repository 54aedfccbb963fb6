//! Device of a rig, the controller: what it answers, and what its motors have to do.
//!
//! [`DeviceMachine`] follows the protocol, and knows neither motors nor memory. Its inputs are messages that arrive and
//! reports of the rig. Its [effects](Effect) are events for the rig and messages to send. The machine is a value: it can be
//! copied, compared and stored.
//!
//! # When to call what
//!
//! | when | input |
//! |---|---|
//! | the link is open, at boot | [`Input::LinkUp`] |
//! | a frame has arrived | [`Input::received`] |
//! | a frame with a wrong checksum has arrived | [`Input::Corrupt`], from its header |
//! | the rig has something to report | [`Input::Rig`] with its [`Report`] |
//! | the upload buffer has answered | [`Report::Stored`] |
//! | the time of `output.wake` has come | [`Input::Wake`] |
//!
//! After each call, carry out the effects in their order: the rig acts first, then the host is told. The message of an
//! [`Event::Store`] goes to the [`UploadBuffer`](crate::upload::UploadBuffer), whose answer goes back to the machine.
//!
//! ```
//! # use dmc_proto::device::Rig;
//! # use dmc_proto::message::{AckCode, HostMessage, Motor, Steps};
//! # use dmc_proto::upload::{Memory, Room, UploadBuffer};
//! # use dmc_proto::Millis;
//! use dmc_proto::device::{DeviceMachine, Effect, Event, Input, Report, Scratch};
//! # struct MyRig<'m> { told: Vec<String>, buffer: UploadBuffer<'m> }
//! # impl Rig for MyRig<'_> {
//! #     fn verdict(&self, _: &HostMessage<'_>) -> AckCode { AckCode::OK }
//! #     fn position(&self, _: Motor) -> Steps { Steps(0) }
//! # }
//! # impl MyRig<'_> {
//! #     fn obey(&mut self, event: Event<'_>) { self.told.push(format!("{event:?}")) }
//! # }
//!
//! fn advance(machine: &mut DeviceMachine, now: Millis, input: Input<'_>, rig: &mut MyRig, line: &mut Vec<u8>) -> Option<Millis> {
//!     let output = machine.advance(now, input);
//!     let (mut wake, mut stored) = (output.wake, None);
//!     for effect in output {
//!         match effect {
//!             Effect::Event(Event::Store { store, message }) => {
//!                 let code = rig.buffer.receive(&message).unwrap_or(AckCode::ERR_GENERAL);
//!                 stored = Some(Input::Rig(Report::Stored(store, code)));
//!             }
//!             Effect::Event(event) => rig.obey(event),
//!             Effect::Transmit(transmit) => {
//!                 let (mut scratch, mut bytes) = (Scratch::default(), [0; 256]);
//!                 let len = transmit.message(rig, &mut scratch).encode_into(transmit.id, &mut bytes).unwrap_or(0);
//!                 line.extend_from_slice(&bytes[..len]);
//!             }
//!         }
//!     }
//!     if let Some(stored) = stored {
//!         wake = advance(machine, now, stored, rig, line);
//!     }
//!     wake
//! }
//! # use dmc_proto::device::Options;
//! # use dmc_proto::{Frame, MessageId};
//! # use dmc_proto::message::{Capabilities, Hi, MotorStopAll, RtUploadMoveBegin, RtUploadMoveEnd, FrameNumber};
//! # let hi = Hi { motor_count: 2, upload_frame_count: 50, capabilities: Capabilities::REAL_TIME, ..Hi::default() };
//! # let room = Room { motors: 2, channels: 0, frames: 50 };
//! # let (mut positions, mut written) = (vec![0; room.positions()], vec![0; room.written()]);
//! # let memory = Memory { positions: &mut positions, levels: &mut [], triggers: &mut [], written: &mut written };
//! # let mut rig = MyRig { told: vec![], buffer: UploadBuffer::new(room, memory)? };
//! # let mut machine = DeviceMachine::new(Options::of(hi));
//! # let mut receive = |message: HostMessage<'_>| -> Result<Vec<u8>, Box<dyn std::error::Error>> {
//! #     let (mut bytes, mut line) = ([0; 64], vec![]);
//! #     let len = message.encode_into(MessageId(1), &mut bytes)?;
//! #     let input = Input::received(&Frame::decode(&bytes[..len])?, |message| rig.verdict(message));
//! #     advance(&mut machine, Millis(0), input, &mut rig, &mut line);
//! #     Ok(line)
//! # };
//! # let stop = receive(MotorStopAll::default().into())?;
//! # assert_eq!(stop[10..12], [0x10, 0]);
//! # let begin = RtUploadMoveBegin { start_frame: FrameNumber(1), end_frame: FrameNumber(50), tail: &[] };
//! # assert_eq!(receive(begin.into())?[10..12], [0x10, 0]);
//! # assert_eq!(receive(RtUploadMoveEnd::default().into())?[10..12], [0x10, 0]);
//! # assert!(machine.is_loaded() && rig.buffer.is_loaded());
//! # assert_eq!(rig.told, ["Stop(All { silent: false })"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Safety of people
//!
//! A stop is obeyed in every state. Its event is the first effect of the call that brings the stop; nothing is asked before,
//! not even the rig. The machine cannot stop a motor itself: make sure that the rig obeys [`Event::Stop`] before anything
//! else.
//!
//! Source: DMC D2, D3 and D4. Each row is in `docs/machines-dmc.md` of the repository.

mod event;
mod input;
mod machine;
mod motion;
mod motors;
mod options;
mod playback;
mod real_time;
mod session;
mod stops;
mod transmit;
mod upload;

pub use event::{Event, StopKind, Store};
pub use input::{Input, Report};
pub use machine::DeviceMachine;
pub use motion::State;
pub use options::{Options, Quirks};
pub use playback::Playback;
pub use session::{Next, NotTaken, Session, SmallSession};
pub use transmit::{Contents, EFFECTS, Effect, Output, Rig, Scratch, Transmit};

/// Codec of a device for a `Framed` of `tokio_util`: it takes pairs of a message id and a message of the device, and yields those of the host
/// and all bytes that are no message. Its buffer has `N` bytes, at least twice [`MAX_FRAME`](crate::frame::MAX_FRAME).
///
/// The [codec of a host](crate::host::Codec) has an example of both.
#[cfg(feature = "tokio")]
pub type Codec<const N: usize = { 2 * crate::frame::MAX_FRAME }> =
    motion_core::codec::Codec<crate::Device, crate::Host, crate::Dmc, N>;
/// Item that the [`Codec`] of a device yields. Labels are message ids.
#[cfg(feature = "tokio")]
pub type CodecItem = motion_core::codec::Item<crate::Host, crate::Header>;
