//! Simulated rigs, and the hosts that control them, on a virtual clock.
//!
//! A [`Rig`] is a device with its motors and cameras. A [`Host`] is the program that controls it. Both take bytes and
//! give bytes, and both are told the time, so that an hour passes in a moment and the same seed gives the same hour.
//! Other code carries the bytes between them: a [`Scene`] in a test, sockets and serial lines in the programs
//! `simulate` and `drive`.
//!
//! Faults are in [`faults`]: lost, doubled, late and damaged bytes, resets, motors that get stuck.
//!
//! # Types
//!
//! | | a rig | a host |
//! |---|---|---|
//! | kOS | [`kos_device::KosDevice`] | [`kos_host::KosHost`] |
//! | DMC | [`dmc_device::DmcDevice`] | [`dmc_host::DmcHost`] |
//! | hoot | [`hoot_node::HootNode`] | [`hoot_master::HootMaster`] |

pub mod device;
pub mod dmc_device;
pub mod dmc_host;
pub mod faults;
pub mod hoot_master;
pub mod hoot_node;
pub mod kos_device;
pub mod kos_host;
pub mod line;
pub mod motor;
mod scene;
mod tap;

use std::collections::VecDeque;
use std::net::SocketAddrV4;

use motion_core::time::Millis;

pub use scene::{Scene, Side};

use motor::Motor;

/// Time between two updates of moving motors, in milliseconds.
pub const TICK: u64 = 1;

/// Line of a party: a connection or a port, from 0 on. Parties with one line use `LineId(0)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct LineId(pub u8);

/// Request of a party. Requests are carried out in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outgoing {
    /// Bytes to send on a line: one message, or several.
    Bytes(LineId, Vec<u8>),
    /// Line to open. Report success with [`Party::open`], or failure with [`Party::close`].
    Open(LineId),
    /// Line to close.
    HangUp(LineId),
    /// Datagram to broadcast.
    Announce(Vec<u8>),
    /// Datagram to an address.
    Datagram(SocketAddrV4, Vec<u8>),
}

/// Number of bytes that wait to be taken.
fn waiting(outgoing: &VecDeque<Outgoing>) -> usize {
    let len = |outgoing: &Outgoing| match outgoing {
        Outgoing::Bytes(_, bytes) | Outgoing::Announce(bytes) | Outgoing::Datagram(_, bytes) => bytes.len(),
        Outgoing::Open(_) | Outgoing::HangUp(_) => 0,
    };
    outgoing.iter().map(len).sum()
}

/// Moment or duration in seconds.
#[expect(clippy::cast_precision_loss, reason = "exact for 285,000 years")]
const fn seconds(moment: Millis) -> f64 {
    moment.0 as f64 / 1000.0
}

/// One end of a line: a rig or a host.
///
/// Each call gives the time, which never decreases, and does everything that is due until then. After each call, call
/// [`poll`](Self::poll) until it returns nothing.
pub trait Party {
    /// Reports that a line is open.
    fn open(&mut self, now: Millis, line: LineId);

    /// Reports that a line is closed, or cannot be opened.
    fn close(&mut self, now: Millis, line: LineId);

    /// Takes bytes that arrived, cut anywhere. Bytes on a line that is not open are ignored.
    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]);

    /// Does everything that is due.
    fn advance(&mut self, now: Millis);

    /// Time when something is due next, if nothing happens before.
    fn wake(&self) -> Option<Millis>;

    /// Next request of the party.
    fn poll(&mut self) -> Option<Outgoing>;
}

/// A simulated rig.
pub trait Rig: Party {
    /// Greatest number of lines that can be open at once.
    const LINES: u8;

    /// Takes a datagram that arrived from an address. Rigs without datagrams ignore it.
    fn datagram(&mut self, now: Millis, from: SocketAddrV4, bytes: &[u8]) {
        let _ = (now, from, bytes);
    }

    /// Motors of the rig, starting with motor 1, in the units of the protocol: rotations (kOS), steps (DMC), microsteps
    /// (hoot).
    fn motors(&self) -> &[Motor];

    /// Elapsed part of the move that is played now: seconds of the move (kOS), number of the frame (DMC), milliseconds
    /// or shots (hoot). `None` while no move is played.
    fn moment(&self) -> Option<f64>;

    /// Interrupts the power for a moment: all lines close, all motors stop dead, and everything that is not stored is
    /// lost.
    fn reset(&mut self, now: Millis);

    /// Makes a moving motor get stuck. The rig notices it and reacts as it does to faults.
    fn stall(&mut self, now: Millis);
}

/// Host of a rig, with one line.
pub trait Host: Party {
    /// Command to the host.
    type Command;
    /// Event of the host.
    type Event;

    /// Carries out a command.
    fn command(&mut self, now: Millis, command: Self::Command);

    /// Next event.
    fn next_event(&mut self) -> Option<Self::Event>;
}

#[doc = include_str!("../README.md")]
#[cfg(doctest)]
struct ReadmeDoctests;
