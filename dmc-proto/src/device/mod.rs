//! The side that moves: what a controller answers, and what its motors shall do.
//!
//! [`DeviceMachine`] knows the protocol, and neither motors nor memory. It is told what arrives and what the rig reports;
//! it says what to send and what the rig shall do. Between two steps it is a value: it can be copied, compared, stored.
//!
//! # When do I call what?
//!
//! | when | what |
//! |---|---|
//! | the line is open, at boot | [`Input::LinkUp`] |
//! | a frame has arrived | [`Input::frame`] |
//! | a frame with a wrong checksum has arrived | [`Input::Corrupt`], from its header |
//! | the rig has something to report | [`Input::AtRest`], [`Input::Frame`], [`Input::PassEnd`], [`Input::Limit`] and so on |
//! | the moment of `output.wake` has come | [`Input::Wake`] |
//!
//! After each step the rig does what the events say, then the messages are sent. An [`Event::Store`] wants an answer: the
//! message goes to the [`UploadBuffer`](crate::upload::UploadBuffer), and what that says goes back as [`Input::Stored`].
//!
//! ```
//! # use dmc_proto::device::{Event, Rig, Scratch};
//! # use dmc_proto::message::{AckCode, HostMessage, Motor, Steps};
//! # use dmc_proto::upload::{Memory, Room, UploadBuffer};
//! use dmc_proto::device::{DeviceMachine, Input};
//! use motion_core::machine::Machine;
//! use motion_core::time::Millis;
//! # struct MyRig<'m> { told: Vec<Event>, buffer: UploadBuffer<'m> }
//! # impl Rig for MyRig<'_> { fn position(&self, _: Motor) -> Steps { Steps(0) } }
//! # impl MyRig<'_> {
//! #     fn obey(&mut self, event: Event, _: Input<'_>) { self.told.push(event) }
//! #     fn store(&mut self, input: Input<'_>) -> AckCode {
//! #         let Input::Received { message, .. } = input else { return AckCode::ERR_GENERAL };
//! #         self.buffer.receive(&message).unwrap_or(AckCode::ERR_GENERAL)
//! #     }
//! #     fn allows(&self, _: &HostMessage<'_>) -> AckCode { AckCode::OK }
//! # }
//!
//! type Bytes = Vec<u8>;
//!
//! fn step(machine: &mut DeviceMachine, now: Millis, input: Input<'_>, rig: &mut MyRig, line: &mut Bytes) -> Option<Millis> {
//!     let (next, output) = machine.clone().step(now, input);
//!     *machine = next;
//!     let mut wake = output.wake;
//!     for event in output.events {
//!         match event {
//!             Event::Store(store) => {
//!                 let stored = Input::Stored(store, rig.store(input));
//!                 wake = step(machine, now, stored, rig, line);
//!             }
//!             event => rig.obey(event, input),
//!         }
//!     }
//!     for send in output.send {
//!         let (mut scratch, mut bytes) = (Scratch::default(), [0; 256]);
//!         let len = send.message(rig, &mut scratch).encode_into(send.id, &mut bytes).unwrap_or(0);
//!         line.extend_from_slice(&bytes[..len]);
//!     }
//!     wake
//! }
//! # use dmc_proto::device::{Options, Stop};
//! # use dmc_proto::{Frame, MessageId};
//! # use dmc_proto::message::{Capabilities, Hi, MotorStopAll, RtUploadMoveBegin, FrameNumber, Empty};
//! # let options = Options::default();
//! # let hi = Hi { motor_count: 2, upload_frame_count: 50, capabilities: Capabilities::REAL_TIME, ..options.hi };
//! # let room = Room { motors: 2, channels: 0, frames: 50 };
//! # let (mut positions, mut written) = (vec![0; room.positions()], vec![0; room.written()]);
//! # let memory = Memory { positions: &mut positions, levels: &mut [], triggers: &mut [], written: &mut written };
//! # let mut rig = MyRig { told: vec![], buffer: UploadBuffer::new(room, memory)? };
//! # let mut machine = DeviceMachine::new(Options::of(hi));
//! # let mut receive = |message: HostMessage<'_>| -> Result<Bytes, Box<dyn std::error::Error>> {
//! #     let (mut bytes, mut line) = ([0; 64], vec![]);
//! #     let len = message.encode_into(MessageId(1), &mut bytes)?;
//! #     let input = Input::frame(&Frame::decode(&bytes[..len])?, |message| rig.allows(message));
//! #     step(&mut machine, Millis(0), input, &mut rig, &mut line);
//! #     Ok(line)
//! # };
//! # let stop = receive(HostMessage::MotorStopAll(MotorStopAll { flags: None, tail: &[] }))?;
//! # assert_eq!(stop[10..12], [0x10, 0]);
//! # let begin = RtUploadMoveBegin { start_frame: FrameNumber(1), end_frame: FrameNumber(50), tail: &[] };
//! # assert_eq!(receive(HostMessage::RtUploadMoveBegin(begin))?[10..12], [0x10, 0]);
//! # assert_eq!(receive(HostMessage::RtUploadMoveEnd(Empty { tail: &[] }))?[10..12], [0x10, 0]);
//! # assert!(machine.is_loaded() && rig.buffer.is_loaded());
//! # assert_eq!(rig.told, [Event::Stop(Stop::All { silent: false })]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Safety of people
//!
//! A stop is obeyed in every state, and its event comes in the step that brings it. Nothing is asked before, not even the
//! rig. What the machine cannot do is to stop a motor: see to it that the rig obeys [`Event::Stop`] before anything else.
//!
//! Source: DMC D2, D3 and D4; each row is in `docs/machines-dmc.md` of the repository.

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
