//! Simulated rigs, and the hosts that control them, on a virtual clock.
//!
//! A [`Rig`] is a device with motors and cameras behind it; a [`Host`] is what talks to it. Both are bytes in, bytes out,
//! and both are told what time it is, so that an hour passes in a moment and the same seed gives the same hour. Around
//! them stands whatever carries bytes: a [`Scene`] in a test, sockets and serial lines in the programs `simulate` and
//! `drive`.
//!
//! What goes wrong on the way is in [`faults`]: lost, doubled, late and damaged bytes, resets, motors that get stuck.
//!
//! # Which is which
//!
//! | | a rig | a host |
//! |---|---|---|
//! | kOS | [`kos_device::KosDevice`] | [`kos_host::KosHost`] |
//! | DMC | [`dmc_device::DmcDevice`] | [`dmc_host::DmcHost`] |
//! | hoot | [`hoot_node::HootNode`] | [`hoot_master::HootMaster`] |

pub mod dmc_device;
pub mod dmc_host;
mod dmc_reader;
pub mod faults;
pub mod hoot_master;
pub mod hoot_node;
pub mod kos_device;
pub mod kos_host;
pub mod line;
pub mod motor;
mod scene;

use std::collections::VecDeque;

use motion_core::time::Millis;

pub use scene::{Scene, Side};

use motor::Motor;

/// Milliseconds between two looks at motors that move.
pub const TICK: u64 = 1;

/// A line of a party: a connection, or a port, from 0 on. Who has one line calls it 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct LineId(pub u8);

/// What a party wants done, in this order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outgoing {
    /// Bytes on a line: one message, or several.
    Bytes(LineId, Vec<u8>),
    /// Open this line, and say so by [`Party::open`], or by [`Party::close`] that it cannot be.
    Open(LineId),
    /// Hang up.
    HangUp(LineId),
    /// A datagram to everybody.
    Announce(Vec<u8>),
    /// A datagram to the one whose datagram was just given in.
    Answer(Vec<u8>),
}

/// Bytes that wait to be taken.
fn waiting(outgoing: &VecDeque<Outgoing>) -> usize {
    let len = |outgoing: &Outgoing| match outgoing {
        Outgoing::Bytes(_, bytes) | Outgoing::Announce(bytes) | Outgoing::Answer(bytes) => bytes.len(),
        Outgoing::Open(_) | Outgoing::HangUp(_) => 0,
    };
    outgoing.iter().map(len).sum()
}

/// A moment, or a time, in seconds.
#[expect(clippy::cast_precision_loss, reason = "exact for 285,000 years")]
const fn seconds(moment: Millis) -> f64 {
    moment.0 as f64 / 1000.0
}

/// One end of a line: a rig or a host.
///
/// Each call says what time it is, never an earlier one than before, and does all that is due until then. After each,
/// take what [`poll`](Self::poll) gives until it gives nothing.
pub trait Party {
    /// A line is open.
    fn open(&mut self, now: Millis, line: LineId);

    /// A line is gone, or cannot be opened.
    fn close(&mut self, now: Millis, line: LineId);

    /// Bytes arrived, cut anywhere. On a line that is not open they count for nothing.
    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]);

    /// Does all that is due.
    fn advance(&mut self, now: Millis);

    /// When something is due next, if nothing happens before.
    fn wake(&self) -> Option<Millis>;

    /// What to do next.
    fn poll(&mut self) -> Option<Outgoing>;
}

/// A simulated rig.
pub trait Rig: Party {
    /// How many lines can be open at once.
    const LINES: u8;

    /// A datagram arrived. Rigs without datagrams take no notice.
    fn datagram(&mut self, now: Millis, bytes: &[u8]) {
        let _ = (now, bytes);
    }

    /// Its motors, the first of them motor 1, in the units of the protocol: rotations (kOS), steps (DMC), microsteps
    /// (hoot).
    fn motors(&self) -> &[Motor];

    /// How far the move is that is played just now: seconds of the move (kOS), frames from its first frame's number on
    /// (DMC), milliseconds or shots (hoot). `None` while none is.
    fn moment(&self) -> Option<f64>;

    /// The power fails for a moment: all lines close, all motors stop dead, and what is not stored is forgotten.
    fn reset(&mut self, now: Millis);

    /// A motor that moves gets stuck: the rig notices, and does what it does at faults.
    fn stall(&mut self, now: Millis);
}

/// What talks to a rig. It has one line.
pub trait Host: Party {
    /// What it can be told to do.
    type Command;
    /// What it tells.
    type Event;

    /// Does what it is told.
    fn command(&mut self, now: Millis, command: Self::Command);

    /// What it tells next.
    fn next_event(&mut self) -> Option<Self::Event>;
}
