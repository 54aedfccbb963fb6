//! Envelope of a message: marker, id, type, length, data and two check bytes.
//!
//! | offset | size | field |
//! |---|---|---|
//! | 0 | 2 | `D` `F` |
//! | 2 | 4 | id |
//! | 6 | 2 | type; bit 15 marks an acknowledgement |
//! | 8 | 2 | length of the data |
//! | 10 | length | data |
//! | 10 + length | 2 | check bytes |
//!
//! All numbers are little-endian. The Fletcher-16 sum over the whole frame, with marker and check bytes, is zero.
//!
//! Source: DMC, Message Format; decisions D-9, D-10 and D-12.

use core::fmt;

use motion_core::fletcher::{self, PrefixSums};
use motion_core::lint::{Findings as _, Lints};
use motion_core::stream::{self, Framing, Head, Noise};
use motion_core::wire::{DecodeError, EncodeError, Envelope};
use zerocopy::little_endian::{U16, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Length of a header, in bytes.
pub const HEADER_LEN: usize = size_of::<Header>();
/// Length of a frame without its data, in bytes: header and check bytes.
pub const OVERHEAD: usize = HEADER_LEN + CHECK_LEN;
/// Greatest length of data that every device accepts, in bytes. The frame then fills the buffer of 1048 bytes that the
/// specification demands (decision D-10).
pub const MAX_DATA: usize = 1036;
/// Length of the longest frame that every device accepts, in bytes: 1048.
pub const SMALL_FRAME: usize = MAX_DATA + OVERHEAD;
/// Default of the greatest length of a frame that a receiver accepts, in bytes (decision D-10).
pub const MAX_FRAME: usize = 2048;

/// Greatest length of a frame that a host accepts, in bytes. Of the messages of a device, the positions of 32 motors are the
/// longest, with 144 bytes (decision D-75).
pub const MAX_DEVICE_FRAME: usize = 256;

const CHECK_LEN: usize = 2;
const MARKER: [u8; 2] = *b"DF";

/// Id of a message. An answer has the id of its request.
///
/// A host counts from 1 and never uses 0. A device sends 0 in messages that no request asked for (decision D-13).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde"))]
pub struct MessageId(pub u32);

impl MessageId {
    /// Id of messages that a device sends unasked.
    pub const UNSOLICITED: Self = Self(0);

    /// Id of the next request. The id 0 is left out.
    #[must_use]
    pub const fn next(self) -> Self {
        match self.0.wrapping_add(1) {
            0 => Self(1),
            id => Self(id),
        }
    }
}

motion_core::__defmt! { newtype MessageId(u32) }
motion_core::__defmt! { newtype MessageType(u16) }

impl fmt::Display for MessageId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// Type of a message. The type of its acknowledgement has bit 15 set as well.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde"))]
pub struct MessageType(pub u16);

impl MessageType {
    const ACK: u16 = 0x8000;

    /// Type of the message with a number of the tables, which hold none above 0xffff.
    pub(crate) fn of(number: u32) -> Self {
        Self(u16::try_from(number).unwrap_or(u16::MAX))
    }

    /// Whether this is the type of an acknowledgement. Only devices send these.
    #[must_use]
    pub const fn is_ack(self) -> bool {
        self.0 & Self::ACK != 0
    }

    /// Type of the request that an acknowledgement answers. Any other type stays as it is.
    #[must_use]
    pub const fn request(self) -> Self {
        Self(self.0 & !Self::ACK)
    }

    /// Type of the acknowledgement that answers a request.
    #[must_use]
    pub const fn ack(self) -> Self {
        Self(self.0 | Self::ACK)
    }
}

impl fmt::Display for MessageType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#06x}", self.0)
    }
}

impl fmt::Debug for MessageType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "MessageType({self})")
    }
}

/// Header of a frame: its first ten bytes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub struct Header {
    marker: [u8; 2],
    id: U32,
    kind: U16,
    len: U16,
}

impl Header {
    fn new(id: MessageId, kind: MessageType, len: u16) -> Self {
        Self { marker: MARKER, id: U32::new(id.0), kind: U16::new(kind.0), len: U16::new(len) }
    }

    /// Id of the message.
    #[must_use]
    #[inline]
    pub fn id(&self) -> MessageId {
        MessageId(self.id.get())
    }

    /// Type of the message.
    #[must_use]
    #[inline]
    pub fn kind(&self) -> MessageType {
        MessageType(self.kind.get())
    }

    /// Length of the data, 0 to 65535 bytes.
    #[must_use]
    #[inline]
    pub fn data_len(&self) -> usize {
        self.len.get().into()
    }

    /// Length of the whole frame, in bytes.
    #[must_use]
    #[inline]
    pub fn frame_len(&self) -> usize {
        self.data_len().saturating_add(OVERHEAD)
    }
}

impl fmt::Debug for Header {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Header")
            .field("id", &self.id())
            .field("kind", &self.kind())
            .field("data_len", &self.data_len())
            .finish()
    }
}

/// Layout of a frame, which has at least [`OVERHEAD`] bytes.
#[derive(PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Packet {
    header: Header,
    /// Data and check bytes.
    rest: [u8],
}

/// Complete frame with a correct checksum.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a>(&'a Packet);

impl<'a> Frame<'a> {
    /// Reads bytes that are exactly one frame.
    ///
    /// # Errors
    ///
    /// [`FrameError`] says what is wrong. Only the sum decides about the checksum. Check bytes are not compared, because 00
    /// and FF mean the same in them (decision D-9).
    #[inline]
    pub fn decode(bytes: &'a [u8]) -> Result<Self, FrameError> {
        let frame = Self::unverified(bytes)?;
        if fletcher::verify(bytes) { Ok(frame) } else { Err(FrameError::Checksum { len: bytes.len() }) }
    }

    /// Reads a frame, and does not verify its checksum.
    #[inline]
    fn unverified(bytes: &'a [u8]) -> Result<Self, FrameError> {
        match Packet::ref_from_bytes(bytes) {
            Ok(packet) if packet.header.marker == MARKER && packet.header.frame_len() == bytes.len() => {
                Ok(Self(packet))
            }
            _ => Err(not_one_frame(bytes)),
        }
    }

    /// Header of the frame.
    #[must_use]
    pub const fn header(&self) -> &'a Header {
        &self.0.header
    }

    /// Id of the message.
    #[must_use]
    #[inline]
    pub fn id(&self) -> MessageId {
        self.0.header.id()
    }

    /// Type of the message.
    #[must_use]
    #[inline]
    pub fn kind(&self) -> MessageType {
        self.0.header.kind()
    }

    /// Data of the frame.
    #[must_use]
    #[inline]
    pub const fn payload(&self) -> &'a [u8] {
        match self.0.rest.split_last_chunk::<CHECK_LEN>() {
            Some((data, _)) => data,
            None => &[],
        }
    }

    /// Bytes of the whole frame, from the marker to the check bytes.
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

/// Reason why bytes are not one frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// The bytes end before the frame does.
    #[error("frame: need {needed} bytes, have {have}")]
    Truncated {
        /// Length of the whole frame, or of the shortest frame, in bytes.
        needed: usize,
        /// Number of bytes.
        have: usize,
    },
    /// The bytes go on after the frame.
    #[error("frame: {extra} bytes too many")]
    Trailing {
        /// Number of bytes after the frame.
        extra: usize,
    },
    /// The bytes do not begin with `DF`.
    #[error("frame: begins with {found:02x?}, not with \"DF\"")]
    NoMarker {
        /// First two bytes.
        found: [u8; 2],
    },
    /// The sum of the bytes is not zero.
    #[error("frame: wrong checksum over {len} bytes")]
    Checksum {
        /// Number of bytes in the sum.
        len: usize,
    },
}

/// Error of bytes that are not one frame, apart from their checksum. Cold, so that valid frames are decoded faster.
#[cold]
fn not_one_frame(bytes: &[u8]) -> FrameError {
    let have = bytes.len();
    match Header::ref_from_prefix(bytes) {
        Err(_) => FrameError::Truncated { needed: OVERHEAD, have },
        Ok((header, _)) if header.marker != MARKER => FrameError::NoMarker { found: header.marker },
        Ok((header, _)) => match header.frame_len() {
            needed if needed > have => FrameError::Truncated { needed, have },
            needed => FrameError::Trailing { extra: have.saturating_sub(needed) },
        },
    }
}

/// Writes a frame of any type around `data`. Messages without a type of their own in this crate are sent this way.
///
/// # Errors
///
/// [`EncodeError`] if `data` is longer than 65535 bytes, or if the frame does not fit into `out`. Then nothing is written.
pub fn encode(id: MessageId, kind: MessageType, data: &[u8], out: &mut [u8]) -> Result<usize, EncodeError> {
    envelope(id, kind, data.len(), out, |place| {
        place.copy_from_slice(data);
        Ok(data.len())
    })
}

/// Envelope of messages that a host sends, or a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Enclosed<const BY_HOST: bool> {}

impl<const BY_HOST: bool> Envelope for Enclosed<BY_HOST> {
    type Frame<'a> = Frame<'a>;
    type Label = MessageId;

    #[inline]
    fn open<'a>(frame: &Self::Frame<'a>) -> Result<(u32, &'a [u8]), DecodeError> {
        Ok((frame.kind().0.into(), frame.payload()))
    }

    #[inline]
    fn label(frame: &Self::Frame<'_>) -> MessageId {
        frame.id()
    }

    #[inline]
    fn frame_len(_: u32, body_len: usize) -> usize {
        frame_len(body_len)
    }

    /// Checks the id, because only devices send 0 (decision D-13).
    fn lint(id: MessageId, found: &mut Lints) {
        if BY_HOST {
            found.range("id", id.0, 1, u32::MAX);
        }
    }

    #[allow(clippy::inline_always, reason = "a program that knows what it sends writes only that")]
    #[inline(always)]
    fn seal(
        id: MessageId,
        number: u32,
        body_len: usize,
        out: &mut [u8],
        body: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
    ) -> Result<usize, EncodeError> {
        envelope(id, MessageType::of(number), body_len, out, body)
    }
}

/// Length of a frame around `len` bytes of data.
#[inline]
pub(crate) fn frame_len(len: usize) -> usize {
    len.saturating_add(OVERHEAD)
}

/// Writes the data, the header and the check bytes, each once.
#[allow(clippy::inline_always, reason = "a program that knows what it sends writes only that")]
#[inline(always)]
fn envelope(
    id: MessageId,
    kind: MessageType,
    len: usize,
    out: &mut [u8],
    data: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
) -> Result<usize, EncodeError> {
    let max = usize::from(u16::MAX);
    let wire_len = u16::try_from(len).map_err(|_| EncodeError::TooLong { what: "data", len, max })?;
    let needed = frame_len(len);
    let small = EncodeError::BufferTooSmall { needed, have: out.len() };
    let (header, rest) =
        out.get_mut(..needed).and_then(|out| out.split_first_chunk_mut::<HEADER_LEN>()).ok_or(small)?;
    let (place, check) = rest.split_last_chunk_mut::<CHECK_LEN>().ok_or(small)?;
    data(place)?;
    // The header is summed as two numbers, and not read back.
    let numbers = u64::from(id.0) | u64::from(kind.0) << 32 | u64::from(wire_len) << 48;
    *check = fletcher::check_bytes([*b"\0\0\0\0\0\0DF", numbers.to_le_bytes()], place);
    *header = zerocopy::transmute!(Header::new(id, kind, wire_len));
    Ok(needed)
}

/// What begins with bytes that are no whole header.
#[inline]
fn no_header(bytes: &[u8]) -> Head {
    if let [b'D'] | [b'D', b'F', ..] = bytes {
        return Head::More(HEADER_LEN);
    }
    let next = bytes.iter().skip(1).position(|&byte| byte == b'D');
    Head::Skip(next.map_or(bytes.len(), |at| at.saturating_add(1)), Noise::NoMarker)
}

/// Framing of DMC, for frames of up to `CAP` bytes.
///
/// `CAP` is 12 to 65547. A header that claims a longer frame counts as noise, so that a damaged length cannot make the
/// stream wait. The search then goes on after the marker, as after a wrong checksum, and finds good frames inside the
/// damaged one (decision D-12).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dmc<const CAP: usize = MAX_FRAME> {}

impl<const CAP: usize> Framing for Dmc<CAP> {
    const MAX: usize = CAP;
    type Header = Header;
    type Frame<'a> = Frame<'a>;
    type Memo<const N: usize> = PrefixSums<N>;

    #[inline]
    fn head(bytes: &[u8]) -> Head {
        // Marker and length are read as `frame` reads them, so that a program that asks for both compares them once.
        match Header::ref_from_prefix(bytes) {
            Ok((header, _)) if header.marker == MARKER => match header.frame_len() {
                total if total <= CAP => Head::Total(total),
                total => Head::Skip(MARKER.len(), Noise::TooLong { total, max: CAP }),
            },
            _ => no_header(bytes),
        }
    }

    fn header(bytes: &[u8]) -> Option<Header> {
        Header::read_from_prefix(bytes).ok().map(|(header, _)| header)
    }

    #[inline]
    fn frame(bytes: &[u8]) -> Option<Frame<'_>> {
        Frame::unverified(bytes).ok()
    }

    /// Gives up the marker. No other marker begins inside it.
    fn give_up(bytes: &[u8]) -> usize {
        if bytes.starts_with(&MARKER) { MARKER.len() } else { 1 }
    }
}

/// Stream of DMC frames, with a buffer of `N` bytes, at least twice [`MAX_FRAME`].
///
/// For small memory there are [`SmallFrames`]. For other limits, name the framing: `motion_core::stream::Frames<Dmc<256>, 512>`.
pub type Frames<const N: usize = { 2 * MAX_FRAME }> = stream::Frames<Dmc, N>;

/// Stream of the frames that a host sends, for a device with small memory: a buffer of 2096 bytes, for frames of up to
/// [`SMALL_FRAME`] bytes. With the sums for damaged frames, it takes some 6400 bytes.
pub type SmallFrames = stream::Frames<Dmc<SMALL_FRAME>, { 2 * SMALL_FRAME }>;

/// Stream of the frames that a device sends, for a host. A frame that is not whole in time is given up, so that a damaged
/// length does not blind the host while motors move (decision D-75).
pub type HostReader = stream::TimedFrames<Dmc<MAX_DEVICE_FRAME>, { 2 * MAX_DEVICE_FRAME }>;

/// Stream of the frames that a host sends, for a device. A frame that is not whole in time is given up.
pub type DeviceReader = stream::TimedFrames<Dmc, { 2 * MAX_FRAME }>;

#[cfg(test)]
mod tests {
    use super::*;
    use motion_core::wire::Message;
    use std::{format, vec::Vec};

    /// Frame of an unknown type.
    fn frame(data: &[u8]) -> Vec<u8> {
        let mut out = std::vec![0xa5; frame_len(data.len())];
        assert_eq!(encode(MessageId(0x0403_0201), MessageType(0x0605), data, &mut out), Ok(out.len()));
        out
    }

    #[test]
    fn fields_are_at_the_offsets_of_the_table() {
        let bytes = frame(b"data");
        assert_eq!(bytes[..14], *b"DF\x01\x02\x03\x04\x05\x06\x04\0data");
        let frame = Frame::decode(&bytes).unwrap();
        assert_eq!(
            (frame.id(), frame.kind(), frame.payload()),
            (MessageId(0x0403_0201), MessageType(0x0605), &b"data"[..])
        );
        assert_eq!((frame.header().data_len(), frame.header().frame_len()), (4, 16));
        assert_eq!(frame.bytes(), bytes);
    }

    #[test]
    fn bytes_that_are_not_one_frame_are_an_error() {
        let good = frame(b"data");
        for len in 0..good.len() {
            let needed = if len < HEADER_LEN { OVERHEAD } else { good.len() };
            assert_eq!(Frame::decode(&good[..len]), Err(FrameError::Truncated { needed, have: len }));
        }
        let longer = [&good[..], b"DF"].concat();
        assert_eq!(Frame::decode(&longer), Err(FrameError::Trailing { extra: 2 }));
        let mut other = good.clone();
        other[1] = b'f';
        assert_eq!(Frame::decode(&other), Err(FrameError::NoMarker { found: *b"Df" }));
        for at in [2, 6, 10, 14, 15] {
            let mut bad = good.clone();
            bad[at] ^= 0x10;
            assert_eq!(Frame::decode(&bad), Err(FrameError::Checksum { len: 16 }), "byte {at}");
        }
    }

    /// Decision D-9: the checksum counts modulo 255.
    #[test]
    fn zero_and_255_count_the_same_in_every_byte() {
        let mut bytes = frame(&[0; 20]);
        for at in 10..30 {
            bytes[at] = 0xff;
            assert!(Frame::decode(&bytes).is_ok(), "a known weakness");
        }
        // For this frame the formula gives 255 for a check byte.
        let mut bytes = [b'D', b'F', 0x83, 0, 0, 0, 0x30, 0, 0, 0, 0xc1, 0xff];
        assert!(Frame::decode(&bytes).is_ok());
        bytes[11] = 0;
        let frame = Frame::decode(&bytes).unwrap();
        let mut again = [0; OVERHEAD];
        encode(frame.id(), frame.kind(), frame.payload(), &mut again).unwrap();
        assert_eq!(again[11], 0xff, "a check byte is never written as 0");
    }

    #[test]
    fn of_a_frame_that_does_not_fit_nothing_is_written() {
        let mut out = [0xa5; 15];
        let small = EncodeError::BufferTooSmall { needed: 16, have: 15 };
        assert_eq!(encode(MessageId(1), MessageType(2), b"data", &mut out), Err(small));
        assert_eq!(out, [0xa5; 15]);
        let long = std::vec![0; 65_536];
        let refused = encode(MessageId(1), MessageType(2), &long, &mut out);
        assert_eq!(refused, Err(EncodeError::TooLong { what: "data", len: 65_536, max: 65_535 }));
    }

    /// Decision D-12: no marker begins inside another one.
    #[test]
    fn a_damaged_frame_is_given_up_with_its_marker() {
        let mut bad = frame(b"DFDF");
        bad[2] ^= 1;
        assert_eq!(<Dmc as Framing>::give_up(&bad), 2);
        assert_eq!(<Dmc as Framing>::give_up(b"D"), 1, "cut off by a gap");
    }

    #[test]
    fn a_message_that_cannot_be_written_leaves_the_buffer_alone() {
        let motors = crate::message::RtShootFrame2 { tail: &[0; 9], ..Message::decode(&[0; 12]).unwrap() };
        let mut out = [0xa5; 64];
        let refused = crate::HostMessage::from(motors).encode_into(MessageId(1), &mut out);
        assert_eq!(refused, Err(EncodeError::Tail { what: "RtShootFrame2.motors", len: 9 }));
        assert_eq!(out, [0xa5; 64]);
    }

    /// Decision D-13.
    #[test]
    fn the_header_of_a_corrupt_frame_tells_what_to_acknowledge() {
        use crate::DeviceMessage;
        use crate::message::{Ack, AckCode};

        let mut bytes = frame(b"data");
        bytes[11] ^= 1;
        let mut frames = Frames::<4096>::new();
        assert_eq!(frames.push(&bytes), bytes.len());
        let Some(stream::Item::Corrupt { header, .. }) = frames.next() else { panic!("the frame is corrupt") };
        assert_eq!((header.id(), header.kind()), (MessageId(0x0403_0201), MessageType(0x0605)));
        let ack = DeviceMessage::from(Ack::new(header.kind(), AckCode::ERR_CHECKSUM));
        let mut out = [0; 14];
        assert_eq!(ack.encode_into(header.id(), &mut out), Ok(14));
        assert_eq!(&out[..12], b"DF\x01\x02\x03\x04\x05\x86\x02\0\x11\0", "decision D-8");
    }

    #[test]
    fn a_host_counts_from_1_and_leaves_0_out() {
        assert_eq!(MessageId::default().next(), MessageId(1));
        assert_eq!(MessageId(1).next(), MessageId(2));
        assert_eq!(MessageId(u32::MAX).next(), MessageId(1));
    }

    #[test]
    fn an_acknowledgement_has_the_type_of_its_request_and_bit_15() {
        let request = MessageType(0x0032);
        assert_eq!((request.ack(), request.ack().request()), (MessageType(0x8032), request));
        assert!(request.ack().is_ack() && !request.is_ack());
        assert_eq!(format!("{:?}", request.ack()), "MessageType(0x8032)");
    }
}
