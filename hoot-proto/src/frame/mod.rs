//! The envelope: break, address, sub-address, command, length, data.
//!
//! | offset | size | field |
//! |---|---|---|
//! | 0 | 6 | break: `00 00 00 00 00 FF` |
//! | 6 | 1 | address of the receiver; 0, the master, in replies |
//! | 7 | 1 | sub-address: what in the node is meant; 0 in replies |
//! | 8 | 1 | command; in replies the response code |
//! | 9 | 1 | length of the data |
//! | 10 | length | data |
//!
//! All numbers are big-endian. There is no checksum and nothing is escaped: data may hold a break, and only the lengths
//! keep a reader in step.
//!
//! Source: hoot, section 1.

mod framing;

use core::cmp::Ordering;
use core::fmt;

pub use framing::{Frames, Hoot, Strict};
use motion_core::unit;
use motion_core::wire::EncodeError;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// What every packet begins with.
pub const BREAK: [u8; 6] = [0, 0, 0, 0, 0, 0xFF];
/// Bytes of a header.
pub const HEADER_LEN: usize = size_of::<Header>();
/// Bytes of data that a node has room for. With more, its firmware writes beyond its memory (hoot, section 1).
pub const MAX_DATA: usize = 32;
/// Bytes of the longest packet that a node has room for.
pub const MAX_FRAME: usize = HEADER_LEN + MAX_DATA;

unit! {
    /// Who a packet is for.
    pub struct Address(u8) "";
}

impl Address {
    /// The master: where replies go.
    pub const MASTER: Self = Self(0);
    /// All nodes at once, which have commands of their own for that and never answer them.
    pub const BROADCAST: Self = Self(1);
    /// A node's address until it is given another one, 2 to 255.
    pub const DEFAULT: Self = Self(3);
}

/// What selects a command: its number, and the part of the node that it is for.
///
/// Broadcasts have a table of their own: command 4 stops a node, but gives all nodes an address when it is broadcast.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Selector {
    /// Whether it goes to all nodes at once.
    pub broadcast: bool,
    /// The command.
    pub command: u8,
    /// The part of the node: 0 the controller, 1 to 3 the motors, 4 the camera. Nodes ignore it in broadcasts.
    pub sub_address: u8,
}

impl Selector {
    /// All of it in one number: `broadcast << 16 | command << 8 | sub_address`.
    ///
    /// The sub-address stands last, so that the numbers of one command for several motors lie side by side.
    #[must_use]
    pub const fn number(self) -> u32 {
        u32::from_be_bytes([0, self.broadcast as u8, self.command, self.sub_address])
    }

    /// What a number means that [`number`](Self::number) gave.
    #[must_use]
    pub const fn from_number(number: u32) -> Self {
        let [_, broadcast, command, sub_address] = number.to_be_bytes();
        Self { broadcast: broadcast != 0, command, sub_address }
    }
}

/// The first ten bytes of a packet.
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
    /// Who it is for.
    #[must_use]
    pub const fn address(&self) -> Address {
        Address(self.address)
    }

    /// The part of the node that it is for; 0 in replies.
    #[must_use]
    pub const fn sub_address(&self) -> u8 {
        self.sub_address
    }

    /// The command; in replies the response code.
    #[must_use]
    pub const fn command(&self) -> u8 {
        self.command
    }

    /// What selects the command, in a request.
    #[must_use]
    pub const fn selector(&self) -> Selector {
        Selector {
            broadcast: self.address == Address::BROADCAST.0,
            command: self.command,
            sub_address: self.sub_address,
        }
    }

    /// Bytes of data, 0 to 255.
    #[must_use]
    pub fn data_len(&self) -> usize {
        self.len.into()
    }

    /// Bytes of the whole packet.
    #[must_use]
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

/// A whole packet: a request, or a reply. They look the same; only who sent it tells them apart.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a> {
    header: &'a Header,
    payload: &'a [u8],
    bytes: &'a [u8],
}

impl<'a> Frame<'a> {
    /// Reads bytes that are exactly one packet, with data of any length up to 255 bytes.
    ///
    /// # Errors
    ///
    /// [`FrameError`] says what is wrong with them.
    pub fn decode(bytes: &'a [u8]) -> Result<Self, FrameError> {
        let have = bytes.len();
        let (header, payload) =
            Header::ref_from_prefix(bytes).map_err(|_| FrameError::Truncated { needed: HEADER_LEN, have })?;
        if header.break_ != BREAK {
            return Err(FrameError::NoBreak { found: header.break_ });
        }
        let needed = header.frame_len();
        match have.cmp(&needed) {
            Ordering::Less => Err(FrameError::Truncated { needed, have }),
            Ordering::Equal => Ok(Self { header, payload, bytes }),
            Ordering::Greater => Err(FrameError::Trailing { extra: have.saturating_sub(needed) }),
        }
    }

    /// Its header.
    #[must_use]
    pub const fn header(&self) -> &'a Header {
        self.header
    }

    /// Who it is for.
    #[must_use]
    pub const fn address(&self) -> Address {
        self.header.address()
    }

    /// The part of the node that it is for; 0 in replies.
    #[must_use]
    pub const fn sub_address(&self) -> u8 {
        self.header.sub_address()
    }

    /// The command; in replies the response code.
    #[must_use]
    pub const fn command(&self) -> u8 {
        self.header.command()
    }

    /// Its data.
    #[must_use]
    pub const fn payload(&self) -> &'a [u8] {
        self.payload
    }

    /// All of it, from the break on.
    #[must_use]
    pub const fn bytes(&self) -> &'a [u8] {
        self.bytes
    }
}

impl AsRef<[u8]> for Frame<'_> {
    fn as_ref(&self) -> &[u8] {
        self.bytes
    }
}

impl fmt::Debug for Frame<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Frame").field("header", self.header).field("payload", &self.payload).finish()
    }
}

/// Why bytes are not one packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// They end before the packet does.
    #[error("packet: need {needed} bytes, have {have}")]
    Truncated {
        /// Bytes of the whole packet, or of the shortest one.
        needed: usize,
        /// Bytes there are.
        have: usize,
    },
    /// They go on behind the packet.
    #[error("packet: {extra} bytes too many")]
    Trailing {
        /// Bytes behind it.
        extra: usize,
    },
    /// They do not begin with a break.
    #[error("packet: begins with {found:02x?}, not with a break")]
    NoBreak {
        /// The first six bytes.
        found: [u8; 6],
    },
}

/// Writes a packet around `data`, whatever its command: the way to send what has no type of its own.
///
/// What is in the data is the caller's affair; only its length is checked.
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

/// Bytes of a packet around `len` bytes of data.
pub(crate) fn frame_len(len: usize) -> usize {
    len.saturating_add(HEADER_LEN)
}

/// The header of `to`, which is address, sub-address and command, and behind it what `data` writes.
pub(crate) fn envelope(
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
    use std::vec::Vec;

    const START: [u8; 10] = [0, 0, 0, 0, 0, 0xFF, 3, 0, 2, 0];

    #[test]
    fn selectors_and_numbers_are_the_same() {
        for number in [0, 0x0200, 0x0F03, 0x1_01FF, 0x1_FFFF] {
            assert_eq!(Selector::from_number(number).number(), number);
        }
        let stop = Frame::decode(&[0, 0, 0, 0, 0, 0xFF, 1, 9, 2, 0]).unwrap().header().selector();
        assert_eq!(stop, Selector { broadcast: true, command: 2, sub_address: 9 });
    }

    #[test]
    fn bytes_that_are_no_packet_say_why() {
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
