//! The side that controls: what Dragonframe sends when, what a silence means, and what is never sent twice.
//!
//! [`HostMachine`] knows the protocol, and keeps no messages. It is told what arrives and what the application wants; it
//! names what to send, and tells what came of it. Between two steps it is a value: it can be copied, compared, stored.
//!
//! # When do I call what?
//!
//! | when | what |
//! |---|---|
//! | the line is open, or gone | [`Input::LinkUp`], [`Input::LinkDown`] |
//! | a frame has arrived | [`Input::frame`] |
//! | a frame with a wrong checksum has arrived | [`Input::Corrupt`] |
//! | [`Event::Greeted`] has come, and the device is configured | [`Command::Configured`] |
//! | the application asks for something | [`Command::Request`], with a token of its own |
//! | it wants an upload, a run, a shot, a way to a frame | [`Command::Sequence`], and [`Command::Go`] after [`Event::Ready`] |
//! | it wants to stop | [`Command::Stop`], at any time |
//! | [`Event::NextSection`] has come | [`Input::Section`] |
//! | the moment of `output.wake` has come | [`Input::Wake`] |
//!
//! After each step the messages are sent, in their order, and the events told. The application keeps the message of a
//! token until that is [done](Event::Done) or has [failed](Event::Failed): the machine may want it again.
//!
//! ```
//! # use dmc_proto::host::{Command, Token};
//! # use dmc_proto::message::{FrameNumber, HostMessage, Motor, Motors, Steps};
//! # use dmc_proto::upload::{MoveSource, SCRATCH};
//! use dmc_proto::host::{Event, HostMachine, Input, Name};
//! use dmc_proto::upload::{Section, SectionSize};
//! use motion_core::machine::Machine;
//! use motion_core::time::Millis;
//! # struct Ramp;
//! # impl MoveSource for Ramp {
//! #     fn start_frame(&self) -> FrameNumber { FrameNumber(1) }
//! #     fn frame_count(&self) -> u32 { 100 }
//! #     fn motors(&self) -> Motors { Motors(1) }
//! #     fn position(&self, _: Motor, index: u32) -> Steps { Steps(index as i32) }
//! # }
//! # struct App { messages: Vec<HostMessage<'static>>, ramp: Ramp, told: Vec<Event> }
//!
//! type Bytes = Vec<u8>;
//!
//! fn step(machine: &mut HostMachine, now: Millis, input: Input<'_>, app: &mut App, line: &mut Bytes) -> Option<Millis> {
//!     let (next, output) = machine.clone().step(now, input);
//!     *machine = next;
//!     for send in output.send {
//!         let (mut scratch, mut bytes) = ([0; SCRATCH], [0; 1048]);
//!         let message = send.message(|name| match name {
//!             Name::Message(token) => app.messages[token.0 as usize],
//!             Name::Section(section) => section.message(&app.ramp, &mut scratch),
//!         });
//!         let len = message.encode_into(send.id, &mut bytes).unwrap_or(0);
//!         line.extend_from_slice(&bytes[..len]);
//!     }
//!     let mut wake = output.wake;
//!     for event in output.events {
//!         if let Event::NextSection(behind) = event {
//!             let size = SectionSize::default();
//!             let section = behind.map_or_else(|| Section::first(&app.ramp, size), |it| it.next(&app.ramp, size));
//!             wake = step(machine, now, Input::Section(section), app, line);
//!         } else {
//!             app.told.push(event);
//!         }
//!     }
//!     wake
//! }
//! # use dmc_proto::host::{Options, Outcome};
//! # use dmc_proto::message::{Ack, AckCode, Hi};
//! # use dmc_proto::upload;
//! # use dmc_proto::{DeviceMessage, Frame, lint::Context};
//! # let hi = Hi { motor_count: 1, upload_frame_count: 100, capabilities: 1.into(), ..dmc_proto::device::Options::default().hi };
//! # let begin = HostMessage::RtUploadMoveBegin(upload::begin(&Ramp, &Context::default())?);
//! # let mut app = App { messages: vec![begin], ramp: Ramp, told: vec![] };
//! # let (mut machine, mut line) = (HostMachine::new(Options::default()), vec![]);
//! # step(&mut machine, Millis(0), Input::LinkUp, &mut app, &mut line);
//! # let hello = Input::Received(Frame::decode(&line)?.id(), DeviceMessage::Hi(hi));
//! # step(&mut machine, Millis(5), hello, &mut app, &mut line);
//! # step(&mut machine, Millis(5), Input::Command(Command::Configured), &mut app, &mut line);
//! # line.clear();
//! # step(&mut machine, Millis(5), Input::Command(Command::Sequence(Token(0), begin)), &mut app, &mut line);
//! # let mut kinds = vec![];
//! # while !line.is_empty() {
//! #     let sent = core::mem::take(&mut line);
//! #     let frame = Frame::decode(&sent)?;
//! #     kinds.push(frame.kind().0);
//! #     let ack = DeviceMessage::Ack(Ack::new(frame.kind(), AckCode::OK));
//! #     step(&mut machine, Millis(9), Input::Received(frame.id(), ack), &mut app, &mut line);
//! # }
//! # assert_eq!(kinds, [0x0100, 0x0101, 0x0103]);
//! # assert_eq!(app.told, [Event::Greeted, Event::Up, Event::Done(Token(0), Outcome::Finished)]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Safety of people
//!
//! A stop is sent in the step that asks for it, before and beside all else, and calls off whatever could move a motor. It
//! is repeated until it is known to be obeyed. [`Event::StopNotConfirmed`] has to reach somebody who can press the
//! emergency stop. After a sequence that failed, look at [`HostMachine::is_armed`]: as long as it says so, the device may
//! begin to move by its operator's hand.
//!
//! Source: DMC D5 and the safety decisions; each row is in `docs/machines-dmc.md` of the repository.

mod commands;
mod connection;
mod io;
mod machine;
mod options;
mod requests;
mod run;
mod sequence;
mod stops;
mod upload;

pub use connection::State;
pub use io::{Command, EVENTS, Event, Failure, Input, Name, Outcome, Output, SENDS, Send, Token, What};
pub use machine::HostMachine;
pub use options::{MAX_WINDOW, Options, Times};
pub use requests::MAX_QUEUE;
pub use sequence::Progress;
pub use stops::Stop;
