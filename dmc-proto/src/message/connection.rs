//! Greetings, capabilities and acknowledgements.

use core::fmt;

use motion_core::wire::{DecodeError, EncodeError, Field, Fields, Message, Reader, Row, Value, Visitor, Writer, print};
use motion_core::{__message_features, flags, message, open_enum};
use zerocopy::ByteOrder;

use crate::frame::MessageType;

message! {
    /// Greeting of a host: the question who the device is. Source: DMC, MSG_HI.
    #[derive(Default)]
    pub struct HiRequest<'a> in LE {}

    /// Greeting of a device: its name, its version and its capabilities. It answers the greeting of a host, or is sent with
    /// id 0 at boot.
    ///
    /// A greeting with id 0 during a session means that the device was reset: all requests are lost, and all settings are
    /// forgotten. Source: DMC, MSG_HI; decisions D-43 to D-46.
    #[derive(Default)]
    pub struct Hi<'a> in LE {
        /// Name of the device.
        name: Name,
        /// First part of the version of the firmware.
        fw_major: u8,
        /// Second part of the version of the firmware.
        fw_minor: u8,
        /// Third part of the version of the firmware.
        fw_rev: u8,
        /// Number of motors, 0 to 32.
        motor_count: u8,
        /// Number of DMX channels, 0 to 512.
        dmx_count: u16,
        /// Number of general purpose outputs, 0 to 32.
        gio_out_count: u8,
        /// Number of general purpose inputs, 0 to 32.
        gio_in_count: u8,
        /// Number of inputs for limit switches, 0 to 32.
        hw_limit_count: u8,
        /// Number of frames of a move that can be uploaded.
        upload_frame_count: u32 ["frames"],
        /// Capabilities of the device.
        capabilities: Capabilities,
        ;
        /// Version of the protocol, 2 today. Devices from before 2020 leave it out.
        protocol_version: Option<u16>,
    }
}

/// Name of a device: 32 bytes, mostly UTF-8, padded with NULs.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[repr(transparent)]
pub struct Name(pub [u8; Self::LEN]);

impl Name {
    const LEN: usize = 32;

    /// Makes a name of up to 32 bytes; `None` if it is longer, or contains a NUL, which would end it.
    #[must_use]
    pub fn new(name: &str) -> Option<Self> {
        if name.len() <= Self::LEN && !name.as_bytes().contains(&0) { Some(Self::truncated(name)) } else { None }
    }

    /// Makes a name from as much of a text as fits. The text is cut between two characters, and before a NUL.
    #[must_use]
    pub fn truncated(name: &str) -> Self {
        let mut bytes = [0; Self::LEN];
        let mut free = bytes.iter_mut();
        for character in name.chars().take_while(|&character| character != '\0') {
            let mut utf8 = [0; 4];
            let utf8 = character.encode_utf8(&mut utf8).as_bytes();
            if free.len() < utf8.len() {
                break;
            }
            // The bytes come first, because a zip takes one more item from its first part than from its second one.
            for (byte, place) in utf8.iter().zip(&mut free) {
                *place = *byte;
            }
        }
        Self(bytes)
    }

    /// Bytes of the name up to the first NUL.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.0.split(|&byte| byte == 0).next().unwrap_or(&self.0)
    }

    /// Text of the name; `None` if it is not UTF-8. A device may cut its name inside a character. Then
    /// [`Display`](fmt::Display) shows the bytes.
    #[must_use]
    pub fn as_str(&self) -> Option<&str> {
        core::str::from_utf8(self.as_bytes()).ok()
    }
}

impl Default for Name {
    fn default() -> Self {
        Self([0; Self::LEN])
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        print::text(f, self.as_bytes())
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Name({self})")
    }
}

impl Field for Name {
    const SIZE: usize = Self::LEN;
    const WIRE: &'static str = "text[32]";

    #[inline]
    fn read<O: ByteOrder>(reader: &mut Reader<'_, O>) -> Option<Self> {
        reader.array().map(Self)
    }

    #[inline]
    fn write<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        writer.array(self.0)
    }

    fn value(&self) -> Value<'_> {
        Value::Text(self.as_bytes())
    }
}

flags! {
    /// Capabilities of a device. Unknown bits are kept. Source: DMC, MSG_HI, CAPABILITIES.
    pub struct Capabilities(u32) {
        /// Real-time moves.
        REAL_TIME = 0x0001,
        /// Go-motion: motion while the shutter is open.
        SHOOT_FRAME = 0x0002,
        /// Virtual motors of a boom, swing and track.
        BOOM_SWING_TRACK = 0x0004,
        /// Virtual motors of a swing and pan.
        SWING_PAN = 0x0008,
        /// Virtual motors of a y axis, swing and track.
        Y_SWING_TRACK = 0x0010,
        /// Virtual motors of an x, y and z axis.
        X_Y_Z = 0x0020,
        /// Aim of the camera at a point.
        AIM = 0x0040,
        /// Go-motion, second form; the specification also calls it `MSG_GO_MOTION2` (decision D-1).
        SHOOT_FRAME2 = 0x0080,
        /// Coupled motors.
        COUPLE = 0x0100,
        /// Loops and ping-pong.
        LOOP = 0x0200,
        /// Triggers for the camera during a move.
        CAMERA_TRIGGER = 0x0400,
    }
}

impl Capabilities {
    /// Virtual motors, of any kind.
    pub const VIRTUALS: Self = Self(0x003C);
}

open_enum! {
    /// Code that tells how a request ended. Source: DMC, ACK codes; decision D-7.
    pub struct AckCode(u16) {
        /// The request was done.
        OK = 0x0010,
        /// The checksum of the request was wrong. Its id and type are doubtful.
        ERR_CHECKSUM = 0x0011,
        /// The device cannot do this while motors move.
        ERR_MOVING = 0x0012,
        /// The device cannot do this.
        ERR_UNSUPPORTED = 0x0013,
        /// A number is out of range.
        ERR_RANGE = 0x0014,
        /// Any other error.
        ERR_GENERAL = 0x0015,
        /// The motors are not at the start of the move.
        ERR_NOT_IN_POSITION = 0x0016,
        /// The pre-roll goes beyond a limit.
        ERR_PREROLL = 0x0017,
        /// The post-roll goes beyond a limit.
        ERR_POSTROLL = 0x0018,
        /// Probably a point that cannot be aimed at. The code is in the header of the vendor's firmware only, and is never
        /// sent.
        ERR_AIM_COD = 0x0019,
        /// The target is beyond the upper limit that was set.
        ERR_SOFT_UP = 0x0020,
        /// The target is beyond the lower limit that was set.
        ERR_SOFT_LOW = 0x0021,
        /// A motor is at its upper limit switch.
        ERR_HARD_UP = 0x0022,
        /// A motor is at its lower limit switch.
        ERR_HARD_LOW = 0x0023,
    }
}

message! {
    /// Data of an acknowledgement.
    struct AckBody<'a> in LE {
        ;
        /// Code of the end of the request.
        response_code: Option<AckCode>,
    }
}

motion_core::__logged! {
    /// Acknowledgement: the answer to a request that asks for no data, or to any request that failed.
    ///
    /// Some devices send a code of four bytes, whose upper two bytes are zero. Those two are in `tail` (decision D-6).
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct Ack<'a> {
        /// Type of the request that the acknowledgement answers.
        pub of: MessageType,
        /// Code of the end of the request; `None` if the data is shorter than a code.
        pub response_code: Option<AckCode>,
        /// Bytes after the code, as they arrived.
        pub tail: &'a [u8],
    }
}

impl<'a> Ack<'a> {
    /// Makes the acknowledgement of a request of type `of`.
    #[must_use]
    pub const fn new(of: MessageType, code: AckCode) -> Self {
        Self { of: of.request(), response_code: Some(code), tail: &[] }
    }

    /// Whether the request was done.
    #[must_use]
    pub fn is_ok(&self) -> bool {
        self.response_code == Some(AckCode::OK)
    }

    const fn body(&self) -> AckBody<'a> {
        AckBody { response_code: self.response_code, tail: self.tail }
    }
}

impl<'a> Message<'a> for Ack<'a> {
    const LAYOUT: &'static [Row] = AckBody::LAYOUT;

    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        Self::decode_as(0x8000, body)
    }

    #[inline]
    fn decode_as(number: u32, body: &'a [u8]) -> Result<Self, DecodeError> {
        let AckBody { response_code, tail } = AckBody::decode(body)?;
        let of = MessageType(u16::try_from(number).unwrap_or(u16::MAX)).request();
        Ok(Self { of, response_code, tail })
    }

    #[inline]
    fn number(&self, _: u32) -> u32 {
        self.of.ack().0.into()
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        self.body().encoded_len()
    }

    #[inline]
    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        self.body().encode_into(out)
    }
}

impl Fields for Ack<'_> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        self.body().fields(visitor);
    }
}

__message_features! { 'a [Ack<'a>] Ack }

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;

    /// Decision D-43.
    #[test]
    fn a_name_is_whole_or_cut_between_characters() {
        assert_eq!(Name::new("dmc-16").unwrap().as_str(), Some("dmc-16"));
        let full = "ABCDEFGHIJKLMNOPQRSTUVWXYZ012345";
        assert_eq!(Name::new(full).unwrap().as_str(), Some(full), "32 bytes need no NUL");
        assert_eq!(Name::new("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456"), None);
        assert_eq!(Name::new("a\0b"), None);
        assert_eq!(Name::truncated("a\0b").as_str(), Some("a"));
        let cut = Name::truncated("ABCDEFGHIJKLMNOPQRSTUVWXYZ01234é");
        assert_eq!(cut.as_str(), Some("ABCDEFGHIJKLMNOPQRSTUVWXYZ01234"), "not half an é");
    }

    #[test]
    fn a_name_that_is_not_text_shows_its_bytes() {
        let mut name = Name::new("rig").unwrap();
        name.0[3] = 0xc3;
        assert_eq!((name.as_str(), name.as_bytes()), (None, &b"rig\xc3"[..]));
        assert_eq!(format!("{name}"), r#""rig\xc3""#);
    }

    /// Decision D-6.
    #[test]
    fn a_code_is_read_from_two_bytes_and_the_others_are_kept() {
        let decode = |body| Ack::decode_as(0x8031, body).unwrap();
        assert_eq!(decode(&[0x10, 0]), Ack::new(MessageType(0x0031), AckCode::OK));
        assert!(decode(&[0x10, 0]).is_ok());
        let wide = decode(&[0x14, 0, 0, 0]);
        assert_eq!((wide.response_code, wide.tail), (Some(AckCode::ERR_RANGE), &[0, 0][..]));
        for body in [&[][..], &[0x10]] {
            let short = decode(body);
            assert_eq!((short.response_code, short.tail, short.is_ok()), (None, body, false));
        }
    }

    #[test]
    fn a_greeting_from_before_2020_has_no_version() {
        let hi = Hi::decode(&[0; 49]).unwrap();
        assert_eq!((hi.protocol_version, hi.tail), (None, &[][..]));
        let odd = Hi::decode(&[0; 50]).unwrap();
        assert_eq!((odd.protocol_version, odd.tail), (None, &[0][..]));
        assert_eq!(Hi::decode(&[0; 51]).unwrap().protocol_version, Some(0));
    }
}
