//! Envelope of a packet: break, address, sub-address, command, length, data.
//!
//! | offset | size | field |
//! |---|---|---|
//! | 0 | 6 | break: `00 00 00 00 00 FF` |
//! | 6 | 1 | address of the receiver; 0, the master, in replies |
//! | 7 | 1 | sub-address: part of the node; 0 in replies |
//! | 8 | 1 | command; in replies the response code |
//! | 9 | 1 | length of the data |
//! | 10 | length | data |
//!
//! All numbers are big-endian. There is no checksum and no escaping: data may contain a break, and only the lengths
//! tell a reader where the next packet begins.
//!
//! Source: hoot, section 1.

mod framing;

use core::cmp::Ordering;
use core::fmt;

pub(crate) use framing::PATIENCE;
pub use framing::{Frames, Hoot, NodeFrames, Requests, Strict};
use motion_core::lint::{Findings as _, Lints};
use motion_core::unit;
use motion_core::wire::{DecodeError, EncodeError, Envelope};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Break, with which every packet begins.
pub const BREAK: [u8; 6] = [0, 0, 0, 0, 0, 0xFF];
/// Length of a header in bytes.
pub const HEADER_LEN: usize = size_of::<Header>();
/// Greatest number of bytes of data. With more, the firmware of a node writes outside its buffer (hoot, section 1).
pub const MAX_DATA: usize = 32;
/// Command whose data begins with a command of the core protocol.
const CORE_COMMAND: u8 = 1;
/// Greatest length of a packet in bytes.
pub const MAX_FRAME: usize = HEADER_LEN + MAX_DATA;

unit! {
    /// Address of the receiver of a packet.
    pub struct Address(u8) "";
}

impl Address {
    /// Address of the master, to which replies go.
    pub const MASTER: Self = Self(0);
    /// Address of all nodes. Broadcasts have commands of their own, and no node answers them.
    pub const BROADCAST: Self = Self(1);
    /// Address of a new node. It can get another address, 2 to 255.
    pub const DEFAULT: Self = Self(3);

    /// Whether a node can have this address: 2 to 255.
    #[must_use]
    pub const fn is_node(self) -> bool {
        self.0 > Self::BROADCAST.0
    }
}

/// Table of commands. The same number means different commands in different tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Table {
    /// Commands to a part of a node.
    #[default]
    Node,
    /// Commands to all nodes. Command 4 stops a node, but as a broadcast it gives all nodes an address.
    Broadcast,
    /// Core protocol, which is command 1 of every part of a node. The first byte of its data is the number of its
    /// command.
    Core,
}

/// Selector of a command: its table, its number, and the part of the node that it is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Selector {
    /// Table of the command.
    pub table: Table,
    /// Number of the command in its table.
    pub command: u8,
    /// Part of the node: 0 the controller, 1 to 3 the motors, 4 the camera. Nodes ignore it in broadcasts and in the
    /// core protocol.
    pub sub_address: u8,
}

impl Selector {
    /// The selector as one number: `table << 16 | command << 8 | sub_address`.
    ///
    /// The sub-address is last, so that the numbers of a command for several motors follow each other.
    #[must_use]
    pub const fn number(self) -> u32 {
        u32::from_le_bytes([self.sub_address, self.command, self.table as u8, 0])
    }

    /// Greatest number of a selector.
    const MAX: u32 = 0x2_FFFF;

    /// Selector of a number that [`number`](Self::number) returned.
    #[must_use]
    pub const fn from_number(number: u32) -> Self {
        let [sub_address, command, table, _] = number.to_le_bytes();
        let table = match table {
            1 => Table::Broadcast,
            2 => Table::Core,
            _ => Table::Node,
        };
        Self { table, command, sub_address }
    }

    /// Selector and parameters of a command. The selector of the core protocol includes the first byte of the data.
    #[inline]
    pub(crate) fn split(self, data: &[u8]) -> (Self, &[u8]) {
        if self.table != Table::Node || self.command != CORE_COMMAND {
            return (self, data);
        }
        match data {
            [command, parameters @ ..] => (Self { table: Table::Core, command: *command, ..self }, parameters),
            [] => (self, &[]),
        }
    }
}

/// First ten bytes of a packet.
#[derive(Clone, Copy, PartialEq, Eq, Hash, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub struct Header {
    break_: [u8; 6],
    address: u8,
    sub_address: u8,
    command: u8,
    len: u8,
}

impl Header {
    /// Whether the packet begins with a break.
    // Two numbers, because six bytes that are compared as an array are first joined to one number: three instructions more.
    #[inline]
    const fn has_break(&self) -> bool {
        let [b0, b1, b2, b3, b4, b5] = self.break_;
        u32::from_be_bytes([b0, b1, b2, b3]) == 0 && u32::from_be_bytes([b2, b3, b4, b5]) == 0xFF
    }

    /// Address of the receiver.
    #[must_use]
    pub const fn address(&self) -> Address {
        Address(self.address)
    }

    /// Part of the node that the packet is for; 0 in replies.
    #[must_use]
    pub const fn sub_address(&self) -> u8 {
        self.sub_address
    }

    /// Number of the command; in replies the response code.
    #[must_use]
    pub const fn command(&self) -> u8 {
        self.command
    }

    /// Length of the data in bytes, 0 to 255.
    #[must_use]
    #[inline]
    pub fn data_len(&self) -> usize {
        self.len.into()
    }

    /// Length of the whole packet in bytes.
    #[must_use]
    #[inline]
    pub fn frame_len(&self) -> usize {
        frame_len(self.data_len())
    }
}

impl fmt::Debug for Header {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Header")
            .field("address", &self.address)
            .field("sub_address", &self.sub_address)
            .field("command", &self.command)
            .field("data_len", &self.len)
            .finish_non_exhaustive()
    }
}

/// Layout of a packet.
#[derive(PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Packet {
    header: Header,
    data: [u8],
}

/// Whole packet: a request or a reply. Both have the same layout, and only the sender tells them apart.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a>(&'a Packet);

impl<'a> Frame<'a> {
    /// Reads bytes that are exactly one packet, with data of any length up to 255 bytes.
    ///
    /// # Errors
    ///
    /// [`FrameError`], which tells what is wrong with the bytes.
    #[inline]
    pub fn decode(bytes: &'a [u8]) -> Result<Self, FrameError> {
        let have = bytes.len();
        let packet = Packet::ref_from_bytes(bytes).map_err(|_| FrameError::Truncated { needed: HEADER_LEN, have })?;
        if !packet.header.has_break() {
            return Err(FrameError::NoBreak { found: packet.header.break_ });
        }
        let needed = packet.header.frame_len();
        match have.cmp(&needed) {
            Ordering::Less => Err(FrameError::Truncated { needed, have }),
            Ordering::Equal => Ok(Self(packet)),
            Ordering::Greater => Err(FrameError::Trailing { extra: have.saturating_sub(needed) }),
        }
    }

    /// Header of the packet.
    #[must_use]
    pub const fn header(&self) -> &'a Header {
        &self.0.header
    }

    /// Address of the receiver.
    #[must_use]
    pub const fn address(&self) -> Address {
        self.0.header.address()
    }

    /// Part of the node that the packet is for; 0 in replies.
    #[must_use]
    pub const fn sub_address(&self) -> u8 {
        self.0.header.sub_address()
    }

    /// Number of the command; in replies the response code.
    #[must_use]
    pub const fn command(&self) -> u8 {
        self.0.header.command()
    }

    /// Data of the packet.
    #[must_use]
    pub const fn payload(&self) -> &'a [u8] {
        &self.0.data
    }

    /// The packet as a request: selector of the command, and its parameters.
    ///
    /// The parameters are the data, without the first byte in the core protocol. Command 1 without that byte belongs to
    /// the table of the nodes.
    #[must_use]
    #[inline]
    pub fn request(&self) -> (Selector, &'a [u8]) {
        let (command, sub_address) = (self.command(), self.sub_address());
        if self.address() == Address::BROADCAST {
            return (Selector { table: Table::Broadcast, command, sub_address }, self.payload());
        }
        Selector { table: Table::Node, command, sub_address }.split(self.payload())
    }

    /// All bytes of the packet, with the break.
    #[must_use]
    #[inline]
    pub fn bytes(&self) -> &'a [u8] {
        self.0.as_bytes()
    }
}

impl AsRef<[u8]> for Frame<'_> {
    #[inline]
    fn as_ref(&self) -> &[u8] {
        self.bytes()
    }
}

impl fmt::Debug for Frame<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Frame").field("header", self.header()).field("payload", &self.payload()).finish()
    }
}

/// Error of bytes that are not one packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// The bytes end before the packet does.
    #[error("packet: need {needed} bytes, have {have}")]
    Truncated {
        /// Length of the whole packet, or of the shortest packet.
        needed: usize,
        /// Number of bytes there are.
        have: usize,
    },
    /// Bytes follow after the packet.
    #[error("packet: {extra} bytes too many")]
    Trailing {
        /// Number of bytes after the packet.
        extra: usize,
    },
    /// The bytes do not begin with a break.
    #[error("packet: begins with {found:02x?}, not with a break")]
    NoBreak {
        /// First six bytes.
        found: [u8; 6],
    },
}

/// Writes a packet around `data`, with any command, for messages without a type.
///
/// Only the length of the data is checked.
///
/// # Errors
///
/// [`EncodeError`], if there are more than [`MAX_DATA`] bytes of data or the packet does not fit into `out`. Then
/// nothing is written.
pub fn encode(
    address: Address,
    sub_address: u8,
    command: u8,
    data: &[u8],
    out: &mut [u8],
) -> Result<usize, EncodeError> {
    envelope([address.0, sub_address, command], data.len(), out, |place| {
        place.copy_from_slice(data);
        Ok(data.len())
    })
}

/// Length of a packet with this number of bytes of data.
#[inline]
pub(crate) fn frame_len(len: usize) -> usize {
    len.saturating_add(HEADER_LEN)
}

/// Envelope of messages of a master, with the address of the receiver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RequestEnvelope {}

impl Envelope for RequestEnvelope {
    type Frame<'a> = Frame<'a>;
    type Label = Address;

    #[inline]
    fn open<'a>(frame: &Self::Frame<'a>) -> Result<(u32, &'a [u8]), DecodeError> {
        let (selector, parameters) = frame.request();
        Ok((selector.number(), parameters))
    }

    #[inline]
    fn label(frame: &Self::Frame<'_>) -> Address {
        frame.address()
    }

    #[inline]
    fn frame_len(number: u32, body_len: usize) -> usize {
        let Selector { table, .. } = Selector::from_number(number);
        frame_len(body_len.saturating_add((table == Table::Core).into()))
    }

    #[inline]
    fn seal(
        to: Address,
        number: u32,
        body_len: usize,
        out: &mut [u8],
        body: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
    ) -> Result<usize, EncodeError> {
        at_most(number, Selector::MAX)?;
        request(Selector::from_number(number), to, body_len, out, body)
    }

    /// Finds an error in the address of the master, which sends no requests to itself.
    fn lint(to: Address, found: &mut Lints) {
        found.range("address", to.0, 1, u8::MAX);
    }
}

/// Envelope of messages of a node. The numbers are `address << 16 | sub_address << 8 | response code`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ReplyEnvelope {}

impl Envelope for ReplyEnvelope {
    type Frame<'a> = Frame<'a>;
    type Label = ();

    #[inline]
    fn open<'a>(frame: &Self::Frame<'a>) -> Result<(u32, &'a [u8]), DecodeError> {
        let number = u32::from_le_bytes([frame.command(), frame.sub_address(), frame.address().0, 0]);
        Ok((number, frame.payload()))
    }

    #[inline]
    fn label(_: &Self::Frame<'_>) {}

    #[inline]
    fn frame_len(_: u32, body_len: usize) -> usize {
        frame_len(body_len)
    }

    #[inline]
    fn seal(
        (): (),
        number: u32,
        body_len: usize,
        out: &mut [u8],
        body: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
    ) -> Result<usize, EncodeError> {
        let [_, to @ ..] = number.to_be_bytes();
        at_most(number, 0xFF_FFFF)?;
        envelope(to, body_len, out, body)
    }
}

/// Refuses a number that is not written as a whole, because the receiver would read another message.
fn at_most(number: u32, max: u32) -> Result<(), EncodeError> {
    let value = number.into();
    if number <= max { Ok(()) } else { Err(EncodeError::OutOfRange { what: "number", value, min: 0, max: max.into() }) }
}

/// Writes a request around the bytes that `parameters` writes.
///
/// Only broadcasts go to [`Address::BROADCAST`], because their numbers mean other commands.
fn request(
    Selector { table, command, sub_address }: Selector,
    to: Address,
    len: usize,
    out: &mut [u8],
    parameters: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
) -> Result<usize, EncodeError> {
    let broadcast = table == Table::Broadcast;
    if broadcast != (to == Address::BROADCAST) {
        let (min, max) = if broadcast { (1, 1) } else { (2, 255) };
        return Err(EncodeError::OutOfRange { what: "address", value: to.0.into(), min, max });
    }
    if table == Table::Node && command == CORE_COMMAND && len > 0 {
        return Err(EncodeError::Typed { what: "core command" });
    }
    if table != Table::Core {
        return envelope([to.0, sub_address, command], len, out, parameters);
    }
    envelope([to.0, sub_address, CORE_COMMAND], len.saturating_add(1), out, |place| {
        let small = EncodeError::BufferTooSmall { needed: 1, have: 0 };
        let (first, place) = place.split_first_mut().ok_or(small)?;
        let written = parameters(place)?;
        *first = command;
        Ok(written)
    })
}

/// Writes a packet around the bytes that `data` writes; `to` is address, sub-address and command.
fn envelope(
    to: [u8; 3],
    len: usize,
    out: &mut [u8],
    data: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
) -> Result<usize, EncodeError> {
    let too_long = EncodeError::TooLong { what: "data", len, max: MAX_DATA };
    let wire_len = u8::try_from(len).map_err(|_| too_long)?;
    if len > MAX_DATA {
        return Err(too_long);
    }
    let needed = frame_len(len);
    let small = EncodeError::BufferTooSmall { needed, have: out.len() };
    let (header, place) = out.get_mut(..needed).and_then(|out| out.split_first_chunk_mut()).ok_or(small)?;
    data(place)?;
    let [address, sub_address, command] = to;
    let written: [u8; HEADER_LEN] =
        zerocopy::transmute!(Header { break_: BREAK, address, sub_address, command, len: wire_len });
    *header = written;
    Ok(needed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    const START: [u8; 10] = [0, 0, 0, 0, 0, 0xFF, 3, 0, 2, 0];

    /// A stop without a type would be queued like other messages, and would not be recognised as a stop.
    #[test]
    fn a_message_without_a_type_is_never_written_as_a_typed_one() {
        use crate::HostMessage;
        use motion_core::wire::Messages;

        let encoded = |number, body| HostMessage::other(number, body).encode_into(Address(3), &mut [0; 42]);
        assert_eq!(encoded(0x0400, &[]), Err(EncodeError::Typed { what: "Stop" }));
        assert_eq!(encoded(0x0100, &[0, 63]), Err(EncodeError::Typed { what: "core command" }));
        // Firmware accepts the command with any data, but this crate has a type only for one length.
        assert_eq!(encoded(0x0400, &[1]), Ok(11));
        let unwritten = EncodeError::OutOfRange { what: "number", value: 0x0300_0400, min: 0, max: 0x2_FFFF };
        assert_eq!(encoded(0x0300_0400, &[]), Err(unwritten));
        let reply = crate::DeviceMessage::other(0x0103_0001, &[]).encode_into(&mut [0; 42]);
        assert!(matches!(reply, Err(EncodeError::OutOfRange { what: "number", .. })), "{reply:?}");
    }

    #[test]
    fn selectors_and_numbers_are_the_same() {
        for number in [0, 0x0200, 0x0F03, 0x1_01FF, 0x1_FFFF, 0x2_0000, 0x2_0304] {
            assert_eq!(Selector::from_number(number).number(), number);
        }
    }

    #[test]
    fn each_table_counts_its_own_commands() {
        let of = |address, command, data: &[u8]| {
            let mut out = [0; 42];
            let len = encode(Address(address), 9, command, data, &mut out).unwrap();
            let (selector, parameters) = Frame::decode(&out[..len]).unwrap().request();
            assert_eq!(selector.sub_address, 9);
            (selector.table, selector.command, parameters.to_vec())
        };
        assert_eq!(of(3, 4, &[7]), (Table::Node, 4, vec![7]));
        assert_eq!(of(3, 1, &[4, 7]), (Table::Core, 4, vec![7]));
        assert_eq!(of(3, 1, &[]), (Table::Node, 1, vec![]));
        assert_eq!(of(1, 1, &[4, 7]), (Table::Broadcast, 1, vec![4, 7]));
    }

    #[test]
    fn bytes_that_are_not_a_packet_give_an_error() {
        assert_eq!(Frame::decode(&START).map(|frame| frame.bytes()), Ok(&START[..]));
        assert_eq!(Frame::decode(&START[..9]), Err(FrameError::Truncated { needed: 10, have: 9 }));
        let mut long = START.to_vec();
        long.push(7);
        assert_eq!(Frame::decode(&long), Err(FrameError::Trailing { extra: 1 }));
        long[9] = 2;
        assert_eq!(Frame::decode(&long), Err(FrameError::Truncated { needed: 12, have: 11 }));
        let found = [0, 0, 0, 0, 0xFF, 3];
        assert_eq!(
            Frame::decode(&START[1..].iter().copied().chain([0]).collect::<Vec<_>>()),
            Err(FrameError::NoBreak { found })
        );
    }

    #[test]
    fn a_packet_that_cannot_be_read_is_not_written() {
        let mut out = [0xA5; 64];
        assert_eq!(
            encode(Address(3), 0, 7, &[1; 33], &mut out),
            Err(EncodeError::TooLong { what: "data", len: 33, max: 32 })
        );
        assert_eq!(
            encode(Address(3), 0, 2, &[], &mut out[..9]),
            Err(EncodeError::BufferTooSmall { needed: 10, have: 9 })
        );
        assert_eq!(out, [0xA5; 64]);
        assert_eq!(encode(Address(3), 0, 2, &[], &mut out), Ok(10));
        assert_eq!(out[..10], START);
    }
}
