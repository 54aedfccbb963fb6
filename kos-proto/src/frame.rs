//! Envelope of a message: a header of six bytes, and the payload.
//!
//! | offset | size | field |
//! |---|---|---|
//! | 0 | 1 | protocol version, 4 |
//! | 1 | 2 | length of the whole message, header included |
//! | 3 | 2 | message id |
//! | 5 | 1 | message type: set, get, response |
//! | 6 | length - 6 | payload |
//!
//! All numbers are big-endian. The envelope has no marker and no checksum, so the length alone says where the next
//! message begins. A wrong length cannot be repaired: the reader then looks for the next message at a wrong place.
//!
//! Source: kOS, Message Header; decisions K-F1 to K-F9.

use core::fmt;

use motion_core::open_enum;
use motion_core::session;
use motion_core::stream::{self, Fatal, Framing, Head, Noise};
use motion_core::wire::{DecodeError, EncodeError, Envelope};
use zerocopy::big_endian::U16;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Protocol version of this crate: the first byte of every message.
pub const VERSION: u8 = 4;
/// Length of a header, in bytes.
pub const HEADER_LEN: usize = size_of::<Header>();
/// Length of the longest message that a receiver takes by default, in bytes (decision K-F7).
///
/// The longest message of the specification is a trajectory of 9400 bytes. The rest is room for blocks that the
/// specification does not name. A device that only holds short moves can use a lower limit: a longer message is skipped
/// and reported, and the messages after it are read as usual.
pub const MAX_FRAME: usize = 16_384;
/// Length of the longest message that a device without moves has to take, in bytes. Only moves and passwords of some 500 bytes
/// are longer.
pub const COMMAND_FRAME: usize = 512;

open_enum! {
    /// Id of a message, which says its subject.
    pub struct MessageId(u16) {
        /// No subject; the message shows that the line is in use. Source: kOS, USB; decision K-U6.
        KEEP_ALIVE = 0x0000,
        /// Addresses of the device in the network.
        NETWORK_INFO = 0x0002,
        /// Lamps of the device and of its slave.
        LED_STATUS = 0x0007,
        /// Positions, ranges and limits of the motors.
        MOTOR_INFO = 0x000B,
        /// Type and present state of the device.
        DEVICE_INFO = 0x000F,
        /// Password of this session.
        USER_PASSWORD = 0x0010,
        /// Password that the device stores.
        DEVICE_PASSWORD = 0x0011,
        /// Stored move.
        TRAJECTORY_DATA = 0x0012,
        /// Number of the device, which no other device has.
        DEVICE_GUID = 0x001F,
        /// Platform of the client that calibrated the motors.
        SOFTWARE_ID = 0x0026,
        /// Action of the device. The first byte of the payload says which.
        ACTION = 0x0080,
        /// Notification of the client. The first byte of the payload says which.
        NOTIFICATION = 0x0081,
    }

    /// Type of a message, which says whether it sets, asks or answers. Source: kOS, Message Type; decision K-F9.
    pub struct MessageType(u8) {
        /// Message that sets something, from client to device.
        SET = 0x00,
        /// Question, from client to device.
        GET = 0x01,
        /// Answer or unasked report, from device to client.
        RESPONSE = 0x02,
        /// Part of an answer that is followed by another part, from device to client.
        RESPONSE_MORE = 0x82,
    }
}

/// Header of a message: its first six bytes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub struct Header {
    version: u8,
    len: U16,
    id: U16,
    kind: u8,
}

impl Header {
    fn new(id: MessageId, kind: MessageType, len: u16) -> Self {
        Self { version: VERSION, len: U16::new(len), id: U16::new(id.0), kind: kind.0 }
    }

    /// Id and type of the message as the tables write them, with 0 for the number of an action or notification.
    #[inline]
    const fn number(self) -> u32 {
        let [.., id0, id1, kind]: [u8; HEADER_LEN] = zerocopy::transmute!(self);
        u32::from_be_bytes([id0, id1, kind, 0])
    }

    /// Id of the message, which says its subject.
    #[must_use]
    #[inline]
    pub fn id(&self) -> MessageId {
        MessageId(self.id.get())
    }

    /// Type of the message, which says whether it sets, asks or answers.
    #[must_use]
    pub const fn kind(&self) -> MessageType {
        MessageType(self.kind)
    }

    /// Length of the whole message in bytes, with this header.
    #[must_use]
    #[inline]
    pub fn message_len(&self) -> usize {
        self.len.get().into()
    }
}

impl fmt::Debug for Header {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Header")
            .field("id", &self.id())
            .field("kind", &self.kind())
            .field("message_len", &self.message_len())
            .finish()
    }
}

/// Layout of a message.
#[derive(PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Packet {
    header: Header,
    payload: [u8],
}

/// Frame of a whole message, as it came.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a>(&'a Packet);

impl<'a> Frame<'a> {
    /// Reads bytes that are exactly one message, as a datagram should be.
    ///
    /// # Errors
    ///
    /// [`FrameError`], if the bytes are not exactly one message.
    #[inline]
    pub fn decode(bytes: &'a [u8]) -> Result<Self, FrameError> {
        match Packet::ref_from_bytes(bytes) {
            Ok(packet) if packet.header.version == VERSION && packet.header.message_len() == bytes.len() => {
                Ok(Self(packet))
            }
            _ => Err(not_one_message(bytes)),
        }
    }

    /// Header of the message.
    #[must_use]
    pub const fn header(&self) -> &'a Header {
        &self.0.header
    }

    /// Id of the message, which says its subject.
    #[must_use]
    #[inline]
    pub fn id(&self) -> MessageId {
        self.0.header.id()
    }

    /// Type of the message, which says whether it sets, asks or answers.
    #[must_use]
    pub const fn kind(&self) -> MessageType {
        self.0.header.kind()
    }

    /// Bytes after the header. In an action or a notification, its number is the first of them.
    #[must_use]
    pub const fn payload(&self) -> &'a [u8] {
        &self.0.payload
    }

    /// Bytes of the whole message, with the header.
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

/// Reason why bytes are not exactly one message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// The bytes end before the message does.
    #[error("frame: need {needed} bytes, have {have}")]
    Truncated {
        /// Length of the whole message, or of a header, in bytes.
        needed: usize,
        /// Number of bytes that were given.
        have: usize,
    },
    /// The bytes go on after the message.
    #[error("frame: {extra} bytes too many")]
    Trailing {
        /// Number of bytes after the message.
        extra: usize,
    },
    /// The first byte is not the protocol version of this crate (decision K-F3).
    #[error("frame: protocol version is {found}, should be {VERSION}")]
    BadVersion {
        /// First byte of the message.
        found: u8,
    },
    /// The length is less than that of a header (decision K-F2).
    #[error("frame: length is {found}, should be at least {HEADER_LEN}")]
    BadLength {
        /// Length that the header says, in bytes.
        found: usize,
    },
}

/// Error of bytes that are not exactly one message. Cold, so that valid messages are decoded faster.
#[cold]
fn not_one_message(bytes: &[u8]) -> FrameError {
    let have = bytes.len();
    match (bytes, Header::ref_from_prefix(bytes)) {
        (&[found, ..], _) if found != VERSION => FrameError::BadVersion { found },
        (_, Err(_)) => FrameError::Truncated { needed: HEADER_LEN, have },
        (_, Ok((header, _))) => match header.message_len() {
            found if found < HEADER_LEN => FrameError::BadLength { found },
            needed if needed > have => FrameError::Truncated { needed, have },
            needed => FrameError::Trailing { extra: have.saturating_sub(needed) },
        },
    }
}

/// Number of a message in the tables: id, type, and the number of the action or notification.
const fn number(id: MessageId, kind: MessageType, sub: u8) -> u32 {
    let [i0, i1] = id.0.to_be_bytes();
    u32::from_be_bytes([i0, i1, kind.0, sub])
}

/// Name of what the first byte of the payload numbers; `None` in other messages.
#[inline]
const fn sub_of(number: u32) -> Option<&'static str> {
    const ACTION: u32 = self::number(MessageId::ACTION, MessageType::SET, 0);
    const NOTIFICATION: u32 = self::number(MessageId::NOTIFICATION, MessageType::RESPONSE, 0);
    match number & !0xFF {
        ACTION => Some("Action"),
        NOTIFICATION => Some("Notification"),
        _ => None,
    }
}

/// Id, type, and number of the action or notification in a number of the tables. The last part is `None` for all other
/// messages.
#[inline]
pub(crate) fn parts(number: u32) -> (MessageId, MessageType, Option<(&'static str, u8)>) {
    let [i0, i1, kind, sub] = number.to_be_bytes();
    let (id, kind) = (MessageId(u16::from_be_bytes([i0, i1])), MessageType(kind));
    (id, kind, sub_of(number).map(|what| (what, sub)))
}

/// Writes a message of any id, type and payload, for messages that have no type in this crate.
///
/// The payload of an action or a notification begins with its number.
///
/// # Errors
///
/// [`EncodeError`], if the message would be longer than 65535 bytes or does not fit into `out`. Then nothing is
/// written.
pub fn encode(id: MessageId, kind: MessageType, payload: &[u8], out: &mut [u8]) -> Result<usize, EncodeError> {
    frame(id, kind, payload.len(), out, |place| {
        place.copy_from_slice(payload);
        Ok(())
    })
}

/// Length of the payload of a message whose body has `body_len` bytes.
#[inline]
fn payload_len(number: u32, body_len: usize) -> usize {
    body_len.saturating_add(usize::from(sub_of(number).is_some()))
}

/// Writes a header and a payload. The header is written last, so that nothing is written if the payload is refused.
#[inline]
fn frame(
    id: MessageId,
    kind: MessageType,
    len: usize,
    out: &mut [u8],
    payload: impl FnOnce(&mut [u8]) -> Result<(), EncodeError>,
) -> Result<usize, EncodeError> {
    let needed = len.saturating_add(HEADER_LEN);
    let wire_len = u16::try_from(needed).map_err(|_| EncodeError::TooLong {
        what: "message",
        len: needed,
        max: u16::MAX.into(),
    })?;
    let small = EncodeError::BufferTooSmall { needed, have: out.len() };
    let (header, place) = out.get_mut(..needed).and_then(<[u8]>::split_first_chunk_mut::<HEADER_LEN>).ok_or(small)?;
    payload(place)?;
    *header = zerocopy::transmute!(Header::new(id, kind, wire_len));
    Ok(needed)
}

/// Framing of kOS, for messages of up to `CAP` bytes.
///
/// `CAP` is 6 to 65535. A longer message is skipped by its length and reported as noise, and the messages after it are
/// read as usual. A wrong version or a length below 6 is fatal, because nothing on the wire says where the next message
/// begins. A TCP client then closes the connection. [`resync`](stream::Frames::resync) is not reliable, because a byte
/// 4 in a payload looks like the begin of a header (safety decision 6, decisions K-F2, K-F3).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kos<const CAP: usize = MAX_FRAME> {}

impl<const CAP: usize> Envelope for Kos<CAP> {
    type Frame<'a> = Frame<'a>;
    type Label = ();

    /// The first byte of the payload is read with id and type, as one number of four bytes: 3 to 4 instructions less than
    /// two reads.
    #[inline]
    fn open<'a>(frame: &<Self as Envelope>::Frame<'a>) -> Result<(u32, &'a [u8]), DecodeError> {
        let Some(([_, _, _, number @ ..], body)) = frame.bytes().split_first_chunk::<{ HEADER_LEN + 1 }>() else {
            let number = frame.header().number();
            return sub_of(number)
                .map_or(Ok((number, &[])), |what| Err(DecodeError::Truncated { what, needed: 1, have: 0 }));
        };
        let number = u32::from_be_bytes(*number);
        Ok(if sub_of(number).is_some() { (number, body) } else { (number & !0xFF, frame.payload()) })
    }

    #[inline]
    fn label(_: &<Self as Envelope>::Frame<'_>) {}

    #[inline]
    fn frame_len(number: u32, body_len: usize) -> usize {
        payload_len(number, body_len).saturating_add(HEADER_LEN)
    }

    #[inline]
    fn seal(
        (): (),
        number: u32,
        body_len: usize,
        out: &mut [u8],
        body: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
    ) -> Result<usize, EncodeError> {
        let (id, kind, sub) = parts(number);
        if let (None, [.., unsaid @ 1..=u8::MAX]) = (sub, number.to_be_bytes()) {
            return Err(EncodeError::OutOfRange { what: "action or note", value: unsaid.into(), min: 0, max: 0 });
        }
        frame(id, kind, payload_len(number, body_len), out, |place| {
            let place = match (place, sub) {
                ([first, rest @ ..], Some((_, sub))) => {
                    body(rest)?;
                    *first = sub;
                    return Ok(());
                }
                (place, _) => place,
            };
            body(place).map(drop)
        })
    }
}

impl<const CAP: usize> Framing for Kos<CAP> {
    const MAX: usize = CAP;
    type Header = Header;
    type Frame<'a> = Frame<'a>;
    type Memo<const N: usize> = ();

    #[inline]
    fn head(bytes: &[u8]) -> Head {
        match bytes {
            [VERSION, l0, l1, ..] => match usize::from(u16::from_be_bytes([*l0, *l1])) {
                found if found < HEADER_LEN => Head::Fatal(Fatal::BadLength { found, least: HEADER_LEN }),
                total if total > CAP => Head::Skip(total, Noise::TooLong { total, max: CAP }),
                total => Head::Total(total),
            },
            [] | [VERSION, ..] => Head::More(3),
            [found, ..] => Head::Fatal(Fatal::BadVersion { found: *found, expected: VERSION }),
        }
    }

    fn header(bytes: &[u8]) -> Option<Header> {
        Header::read_from_prefix(bytes).ok().map(|(header, _)| header)
    }

    #[inline]
    fn frame(bytes: &[u8]) -> Option<Frame<'_>> {
        Frame::decode(bytes).ok()
    }

    /// Drops all bytes: kOS has no marker, so any payload could look like a message.
    fn give_up(bytes: &[u8]) -> usize {
        bytes.len()
    }
}

/// Stream of kOS messages, in a buffer of `N` bytes, at least twice [`MAX_FRAME`].
///
/// For small memory there are [`CommandFrames`]. For other limits, name the framing:
/// `motion_core::stream::Frames<Kos<4096>, 8192>`.
pub type Frames<const N: usize = { 2 * MAX_FRAME }> = stream::Frames<Kos, N>;

/// Stream of kOS messages without moves, in a buffer of 1024 bytes, for messages of up to [`COMMAND_FRAME`] bytes.
pub type CommandFrames = stream::Frames<Kos<COMMAND_FRAME>, { 2 * COMMAND_FRAME }>;

/// Stream of the messages of a session.
pub(crate) type Link<const N: usize, const CAP: usize = MAX_FRAME> = session::Link<Kos<CAP>, N>;

/// TCP and USB lose no part of a message, so a session gives none up.
pub(crate) const PATIENCE: stream::Patience = stream::Patience::new().with_margin(u32::MAX);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::HostMessage;
    use motion_core::wire::Messages;
    use std::vec;

    #[test]
    fn a_datagram_is_exactly_one_message() {
        let keep_alive = [4, 0, 6, 0, 0, 0];
        let frame = Frame::decode(&keep_alive).unwrap();
        assert_eq!((frame.id(), frame.kind(), frame.payload()), (MessageId::KEEP_ALIVE, MessageType::SET, &[][..]));
        assert_eq!(frame.header().message_len(), 6);
        assert_eq!(Frame::decode(&[]), Err(FrameError::Truncated { needed: 6, have: 0 }));
        assert_eq!(Frame::decode(&keep_alive[..5]), Err(FrameError::Truncated { needed: 6, have: 5 }));
        assert_eq!(Frame::decode(&[4, 0, 8, 0, 0, 0, 1]), Err(FrameError::Truncated { needed: 8, have: 7 }));
        assert_eq!(Frame::decode(&[4, 0, 6, 0, 0, 0, 1, 2]), Err(FrameError::Trailing { extra: 2 }));
        assert_eq!(Frame::decode(&[3]), Err(FrameError::BadVersion { found: 3 }));
        assert_eq!(Frame::decode(&[4, 0, 5, 0, 0, 0]), Err(FrameError::BadLength { found: 5 }));
    }

    #[test]
    fn any_message_can_be_sent_raw_up_to_the_longest() {
        let mut out = vec![0; 65_540];
        let (id, kind) = (MessageId(0x1234), MessageType::GET);
        assert_eq!(encode(id, kind, b"ab", &mut out), Ok(8));
        assert_eq!(out[..8], *b"\x04\0\x08\x12\x34\x01ab");
        assert_eq!(encode(id, kind, &vec![0; 65_529], &mut out), Ok(65_535));
        let long = EncodeError::TooLong { what: "message", len: 65_536, max: 65_535 };
        assert_eq!(encode(id, kind, &vec![0; 65_530], &mut out), Err(long));
        let small = EncodeError::BufferTooSmall { needed: 8, have: 7 };
        assert_eq!(encode(id, kind, b"ab", &mut out[..7]), Err(small));
    }

    #[test]
    fn an_action_has_its_number_first() {
        let frame = Frame::decode(&[4, 0, 6, 0, 0x80, 0]).unwrap();
        let none = DecodeError::Truncated { what: "Action", needed: 1, have: 0 };
        assert_eq!(HostMessage::decode(&frame), Err(none));

        let unknown = [4, 0, 8, 0, 0x80, 0, 0x63, 7];
        let message = HostMessage::decode(&Frame::decode(&unknown).unwrap()).unwrap();
        assert_eq!((message.specification_name(), message.number()), ("Action", 0x0080_0063));
        let mut out = [0; 8];
        assert_eq!(message.encode_into(&mut out), Ok(8));
        assert_eq!(out, unknown);
        assert_eq!(message.encode_into(&mut out[..7]), Err(EncodeError::BufferTooSmall { needed: 8, have: 7 }));
    }

    #[test]
    fn a_number_that_no_message_carries_is_not_lost_in_silence() {
        let message = HostMessage::other(0x0012_3401, &[]);
        let refused = message.encode_into(&mut [0; 16]);
        assert_eq!(refused, Err(EncodeError::OutOfRange { what: "action or note", value: 1, min: 0, max: 0 }));
    }
}
