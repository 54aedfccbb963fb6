//! Host of a rig, as Dragonframe is one: when to send which message, what to do without an answer, and what is never sent
//! twice.
//!
//! [`HostMachine`] follows the protocol and keeps no messages. Its inputs are messages that arrive and commands of the
//! application. Its [effects](Effect) are messages to send and events. The machine is a value: it can be copied, compared
//! and stored.
//!
//! # When to call what
//!
//! | when | input |
//! |---|---|
//! | the link is open, or gone | [`Input::LinkUp`], [`Input::LinkDown`] |
//! | a frame has arrived | [`Input::received`] |
//! | a frame with a wrong checksum has arrived | [`Input::Corrupt`] |
//! | [`Event::Greeted`] has come, and the device is configured | [`Command::Configured`] |
//! | the application asks for something | [`Command::Request`] |
//! | the application wants an upload, a run, a shot, a way to a frame | [`Command::Sequence`], and [`Command::Go`] after [`Event::Armed`] |
//! | the application wants to stop, at any time | [`Command::Stop`] |
//! | [`Event::NextSection`] has come | [`Input::Section`] |
//! | the time of `output.wake` has come | [`Input::Wake`] |
//!
//! Give the machine a [first id](Options::first_id) that was drawn at random, and drop the bytes that wait on the line when
//! it is opened. Otherwise an old answer may confirm a stop that the device never received.
//!
//! Enable each motor by `MotorConfigure` before it is moved, and set the motors of a shot to blur. The machine refuses moves
//! of other motors, because devices acknowledge them, tell that the motor arrives, and do not move it.
//!
//! After each call, carry out the effects in their order. The application chooses the token of a command, and keeps the
//! message of a request or a sequence until its [end](Event::Ended): the machine may ask for the message again.
//!
//! ```
//! # use dmc_proto::host::Command;
//! # use dmc_proto::message::{FrameNumber, HostMessage, Motor, Motors, Steps};
//! # use dmc_proto::upload::{MoveSource, SCRATCH};
//! # use dmc_proto::{Millis, Token};
//! use dmc_proto::host::{Effect, Event, HostMachine, Input, Source};
//! use dmc_proto::upload::{Section, SectionSize};
//! # struct Ramp;
//! # impl MoveSource for Ramp {
//! #     fn start_frame(&self) -> FrameNumber { FrameNumber(1) }
//! #     fn frame_count(&self) -> u32 { 100 }
//! #     fn motors(&self) -> Motors { Motors(1) }
//! #     fn position(&self, _: Motor, index: u32) -> Steps { Steps(index as i32) }
//! # }
//! # struct App { messages: Vec<HostMessage<'static>>, ramp: Ramp, told: Vec<String> }
//!
//! fn advance(machine: &mut HostMachine, now: Millis, input: Input<'_>, app: &mut App, line: &mut Vec<u8>) -> Option<Millis> {
//!     let output = machine.advance(now, input);
//!     let (mut wake, mut next) = (output.wake, None);
//!     for effect in output {
//!         match effect {
//!             Effect::Transmit(transmit) => {
//!                 let (mut scratch, mut bytes) = ([0; SCRATCH], [0; 1048]);
//!                 let written = transmit.encode_into(|source| match source {
//!                     Source::Command(token) => app.messages[token.0 as usize],
//!                     Source::Section(section) => section.message(&app.ramp, &mut scratch),
//!                 }, &mut bytes);
//!                 let len = written.unwrap_or(0);
//!                 line.extend_from_slice(&bytes[..len]);
//!             }
//!             Effect::Event(Event::NextSection { after, .. }) => next = Some(after),
//!             Effect::Event(event) => app.told.push(format!("{event:?}")),
//!         }
//!     }
//!     if let Some(after) = next {
//!         let size = SectionSize::default();
//!         let section = after.map_or_else(|| Section::first(&app.ramp, size), |it| it.next(&app.ramp, size));
//!         wake = advance(machine, now, Input::Section(section), app, line);
//!     }
//!     wake
//! }
//! # use dmc_proto::host::Options;
//! # use dmc_proto::message::{Ack, AckCode, Capabilities, Hi};
//! # use dmc_proto::upload;
//! # use dmc_proto::{DeviceMessage, Frame, lint::Context};
//! # let hi = Hi { motor_count: 1, upload_frame_count: 100, capabilities: Capabilities::REAL_TIME, ..Hi::default() };
//! # let begin = HostMessage::from(upload::begin(&Ramp, &Context::default())?);
//! # let mut app = App { messages: vec![begin], ramp: Ramp, told: vec![] };
//! # let (mut machine, mut line) = (HostMachine::new(Options::default()), vec![]);
//! # advance(&mut machine, Millis(0), Input::LinkUp, &mut app, &mut line);
//! # let hello = Input::Received(Frame::decode(&line)?.id(), hi.into());
//! # advance(&mut machine, Millis(5), hello, &mut app, &mut line);
//! # advance(&mut machine, Millis(5), Input::Command(Token(1), Command::Configured), &mut app, &mut line);
//! # line.clear();
//! # advance(&mut machine, Millis(5), Input::Command(Token(0), Command::Sequence(begin)), &mut app, &mut line);
//! # let mut kinds = vec![];
//! # while !line.is_empty() {
//! #     let sent = core::mem::take(&mut line);
//! #     let frame = Frame::decode(&sent)?;
//! #     kinds.push(frame.kind().0);
//! #     let ack = DeviceMessage::from(Ack::new(frame.kind(), AckCode::OK));
//! #     advance(&mut machine, Millis(9), Input::Received(frame.id(), ack), &mut app, &mut line);
//! # }
//! # assert_eq!(kinds, [0x0100, 0x0101, 0x0103]);
//! # let done = |token| format!("Ended {{ token: Token({token}), outcome: Done(None) }}");
//! # assert_eq!(app.told[1..], [done(1), "Ready { reconnected: false }".into(), done(0)]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Safety of people
//!
//! The machine sends a stop of everything by itself after a run or a shot that the device refused, or that is not confirmed,
//! because the device may keep it (decision D-97).
//!
//! A stop is the first effect of the call that asks for it, and calls off all that could move a motor. The stop is repeated
//! until it is known to be obeyed, a timeout apart, whatever the device answers. [`Event::StopNotConfirmed`] has to reach a person who can press the emergency stop. As
//! long as [`HostMachine::may_move`] says so, motors may move, or begin to move by the operator's hand.
//!
//! Source: DMC D5 and the safety decisions. Each row is in `docs/machines-dmc.md` of the repository.

mod commands;
mod connection;
mod event;
mod input;
mod machine;
mod motion;
mod options;
mod progress;
mod requests;
mod run;
mod sequence;
mod session;
mod stops;
mod store;
mod transmit;
mod upload;
mod uses;

pub use connection::State;
pub use event::{Event, Failure, Outcome, Refusal, StopTarget};
pub use input::{Command, Input};
pub use machine::HostMachine;
pub use motion_core::machine::Token;
pub use options::{MAX_WINDOW, Options};
pub use progress::Progress;
pub use requests::MAX_QUEUE;
pub use session::{Next, NotTaken, Session};
pub use transmit::{Contents, EFFECTS, Effect, Output, Source, Transmit};

/// Codec of a host for a `Framed` of `tokio_util`: it takes pairs of a message id and a message of the host, and yields those of the device
/// and all bytes that are no message. Its buffer has `N` bytes, at least twice [`MAX_DEVICE_FRAME`](crate::frame::MAX_DEVICE_FRAME).
///
/// ```
/// use dmc_proto::message::{Hi, HiRequest};
/// use dmc_proto::{DeviceMessage, HostMessage, MessageId, device, host};
/// use futures_util::{SinkExt, StreamExt};
/// use tokio_util::codec::Framed;
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> std::io::Result<()> {
/// // Any asynchronous stream does, such as a serial port or a TCP connection.
/// let (here, there) = tokio::io::duplex(64);
/// let mut host: Framed<_, host::Codec> = Framed::new(here, host::Codec::default());
/// let mut device: Framed<_, device::Codec> = Framed::new(there, device::Codec::default());
///
/// host.send((MessageId(1), HostMessage::from(HiRequest::default()))).await?;
/// let Some(device::CodecItem::Message { label, message, .. }) = device.next().await.transpose()? else {
///     panic!("no message")
/// };
/// assert_eq!(message.message(), HiRequest::default().into());
///
/// // An answer has the id of its request.
/// device.send((label, DeviceMessage::from(Hi::default()))).await?;
/// match host.next().await.transpose()? {
///     Some(host::CodecItem::Message { label, message, .. }) => println!("{label}: {message}"),
///     Some(other) => println!("no message: {other:?}"),
///     None => println!("the device is gone"),
/// }
/// # Ok(())
/// # }
/// ```
#[cfg(feature = "tokio")]
pub type Codec<const N: usize = { 2 * crate::frame::MAX_DEVICE_FRAME }> =
    motion_core::codec::Codec<crate::Host, crate::Device, crate::Dmc<{ crate::frame::MAX_DEVICE_FRAME }>, N>;
/// Item that the [`Codec`] of a host yields. Labels are message ids.
#[cfg(feature = "tokio")]
pub type CodecItem = motion_core::codec::Item<crate::Device, crate::Header>;
