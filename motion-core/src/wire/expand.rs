//! Every arm of every table macro, expanded here under the denials of this crate: lints do not see into the macros
//! where other crates use them. The tests below say what each arm makes.

use crate::fixed::Milli;
use crate::lint::Lints;
use crate::stream::{Framing, Head};
use crate::wire::{
    Bool, Bytes, Conduct, Counted, DecodeError, Empty, EncodeError, Envelope, Fields, Message, Newer, Other, Password,
    Purpose, Rest, Row, Text16, Visitor,
};
use crate::{__logged, element, flags, message, messages, open_enum, side, unit};

unit! {
    /// A motor, from 1.
    pub struct Motor(u8) "";
    /// Motor steps.
    pub struct Steps(i32) "steps";
    /// Motor revolutions.
    pub struct Turns(f32) "rev";
    /// Frames a second.
    pub struct Rate(Milli<u32>) "frames/s";
}

open_enum! {
    /// Why.
    pub struct Reason(u8) {
        /// A switch.
        SWITCH = 1,
        /// A fault.
        FAULT = 100,
    }
}

flags! {
    /// How.
    pub struct Options(u16) {
        /// Again and again.
        LOOP = 1,
        /// There and back.
        PING_PONG = 2,
    }
}

element! {
    /// Where a motor is.
    pub struct Place in LE, "place_count" {
        /// Which one.
        motor: Motor,
        /// Where.
        position: Steps,
    }
}

message! {
    /// Fixed fields only, with a tail.
    pub struct Jog<'a> in LE {
        /// Which motor.
        motor: Motor,
        /// How fast.
        speed: u16 ["1/10000"],
        /// Where to.
        destination: Steps,
    }

    /// Fixed fields only, exactly.
    pub struct Exact in LE {
        /// Where to.
        turns: Turns,
        /// Whether.
        on: Bool,
    }

    /// Optional fields of shrinking size.
    pub struct Run<'a> in LE {
        /// How fast.
        rate: Rate,
        ;
        /// How.
        options: Option<Options>,
        /// Why.
        reason: Option<Reason>,
    }

    /// A list to the end.
    pub struct Shoot<'a> in LE {
        /// The frame.
        frame: i32,
        ;
        /// The motors.
        motors: &'a [Place],
    }

    /// A counted list and a field after it.
    pub struct Count<'a> in BE {
        ;
        /// The motors.
        motors: Counted<'a, Place>,
        /// Why.
        reason: Reason,
    }

    /// Texts in the middle, and what a newer dialect adds.
    pub struct Info<'a> in BE {
        /// Six bytes.
        address: Bytes<6>,
        ;
        /// A name.
        name: Text16<'a>,
        /// A secret.
        password: Password<'a>,
        /// Where.
        turns: Turns,
        /// What came later.
        count: Newer<u32>,
    }

    /// Bytes that another message of the same number refuses.
    pub struct Inexact<'a> in BE {}

    /// Anything.
    pub struct Raw<'a> in BE {
        ;
        /// All of it.
        data: Rest<'a>,
    }
}

__logged! {
    /// By hand: several numbers, which it remembers.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct Ack<'a> {
        /// What is acknowledged.
        pub of: u32,
        /// How.
        pub body: Raw<'a>,
    }
}

impl<'a> Message<'a> for Ack<'a> {
    const LAYOUT: &'static [Row] = Raw::LAYOUT;

    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        Self::decode_as(0x80, body)
    }

    fn decode_as(number: u32, body: &'a [u8]) -> Result<Self, DecodeError> {
        Raw::decode(body).map(|body| Self { of: number & 0x7f, body })
    }

    fn number(&self, declared: u32) -> u32 {
        declared | self.of
    }

    fn encoded_len(&self) -> usize {
        self.body.encoded_len()
    }

    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        self.body.encode_into(out)
    }
}

impl Fields for Ack<'_> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        self.body.fields(visitor);
    }
}

messages! {
    /// A message of each shape, with every kind of conduct.
    pub enum Everything<'a> from host {
        1 => Go(Empty<'a>) [moves once, in sequence],
        2 => Jog(Jog<'a>) [by jog],
        3 => Exact(Exact) [sets]
            or
            /// Bytes of another length.
            Inexact(Inexact<'a>) [sets once],
        4 => Run(Run<'a>) [arms],
        5 => Shoot(Shoot<'a>) [moves],
        6 => Count(Count<'a>) [stops],
        7 | 17 => Info(Info<'a>) [asks],
        8 => Raw(Raw<'a>) [resets once],
        0x80..=0xff => Ack(Ack<'a>) [asks, in sequence],
    }
}

messages! {
    /// Messages that are told apart byte by byte.
    pub enum Bytewise<'a> {
        [0, 2, 0] => Go(Empty<'a>),
        [0, 2, 1..=3] => Exact(Exact)
            or
            /// Bytes of another length.
            Inexact(Inexact<'a>),
        [1, 2, 0..=255] => Raw(Raw<'a>),
    }
}

messages! {
    /// Commands that are told apart byte by byte.
    pub enum BytewiseCommand<'a> from host {
        [0, 2, 0] => Go(Empty<'a>) [moves],
        [0, 2, 1..=3] => Exact(Exact) [stops]
            or
            /// Bytes of another length.
            Inexact(Inexact<'a>) [asks],
    }
}

/// A jog without speed is a stop.
const fn jog(jog: &Jog<'_>) -> Conduct {
    if jog.speed == 0 { Conduct::new(Purpose::Stops) } else { Conduct::new(Purpose::Moves).once() }
}

impl Everything<'_> {
    /// Nothing is found.
    #[allow(clippy::unused_self, clippy::trivially_copy_pass_by_ref, reason = "as all messages have it")]
    fn lint(&self, (): &()) -> Lints {
        Lints::new()
    }
}

impl Bytewise<'_> {
    /// Nothing is found.
    #[allow(clippy::unused_self, clippy::trivially_copy_pass_by_ref, reason = "as all messages have it")]
    fn lint(&self, (): &()) -> Lints {
        Lints::new()
    }
}

/// A frame: the number of the message and the length of its body, a byte each, then the body.
pub enum Plain {}

impl Plain {
    fn write(
        number: u32,
        out: &mut [u8],
        body: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
    ) -> Result<usize, EncodeError> {
        let small = EncodeError::BufferTooSmall { needed: 2, have: out.len() };
        let (header, place) = out.split_first_chunk_mut().ok_or(small)?;
        let len = body(place)?;
        let [low, ..] = number.to_le_bytes();
        *header = [low, u8::try_from(len).unwrap_or(u8::MAX)];
        Ok(len.saturating_add(2))
    }
}

impl Framing for Plain {
    const MAX: usize = 257;
    type Header = ();
    type Frame<'a> = &'a [u8];
    type Memo<const N: usize> = ();

    fn head(bytes: &[u8]) -> Head {
        match bytes {
            [_, len, ..] => Head::Total(usize::from(*len).saturating_add(2)),
            _ => Head::More(2),
        }
    }

    fn header(_: &[u8]) -> Option<()> {
        Some(())
    }

    fn frame(bytes: &[u8]) -> Option<&[u8]> {
        Some(bytes)
    }
}

impl Envelope for Plain {
    type Frame<'a> = &'a [u8];
    type Label = Motor;

    fn open<'a>(frame: &Self::Frame<'a>) -> Result<(u32, &'a [u8]), DecodeError> {
        match *frame {
            [number, _, body @ ..] => Ok((u32::from(*number), body)),
            short => Err(DecodeError::Truncated { what: "frame", needed: 2, have: short.len() }),
        }
    }

    fn label(_: &Self::Frame<'_>) -> Motor {
        Motor(0)
    }

    fn frame_len(_: u32, body_len: usize) -> usize {
        body_len.saturating_add(2)
    }

    fn seal(
        _: Motor,
        number: u32,
        _: usize,
        out: &mut [u8],
        body: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
    ) -> Result<usize, EncodeError> {
        Self::write(number, out, body)
    }
}

/// The same frame, for a side whose frames say nothing else.
pub enum Unlabelled {}

impl Envelope for Unlabelled {
    type Frame<'a> = &'a [u8];
    type Label = ();

    fn open<'a>(frame: &Self::Frame<'a>) -> Result<(u32, &'a [u8]), DecodeError> {
        Plain::open(frame)
    }

    fn label(_: &Self::Frame<'_>) {}

    fn frame_len(number: u32, body_len: usize) -> usize {
        Plain::frame_len(number, body_len)
    }

    fn seal(
        (): (),
        number: u32,
        _: usize,
        out: &mut [u8],
        body: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
    ) -> Result<usize, EncodeError> {
        Plain::write(number, out, body)
    }
}

side! {
    /// A side whose frames name a motor.
    pub enum Sender in LE: Everything(to: Motor) by Plain, over Plain, lint ();
    /// A side whose decoder cannot fail.
    pub enum Commander in LE: Bytewise() by Unlabelled, or other, over Plain, lint ();
}

const _: fn(&Other<'_>) -> u32 = |other| other.id();

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::{Messages, PartKind};
    use std::format;
    use std::vec::Vec;

    fn encode(message: &Everything<'_>) -> Result<Vec<u8>, EncodeError> {
        let mut out = std::vec![0xa5; message.body_len()];
        message.encode_body(&mut out).map(|len| {
            assert_eq!(len, out.len());
            out
        })
    }

    #[test]
    fn fields_stand_where_the_list_says() {
        let jog = Jog { motor: Motor(3), speed: 0x0102, destination: Steps(-2), tail: b"!" };
        assert_eq!(encode(&Everything::Jog(jog)).unwrap(), [3, 2, 1, 0xfe, 0xff, 0xff, 0xff, b'!']);
        let offsets: Vec<_> = Jog::LAYOUT.iter().map(|row| (row.name, row.offset, row.size, row.unit)).collect();
        assert_eq!(
            offsets,
            [("motor", Some(0), 1, ""), ("speed", Some(1), 2, "1/10000"), ("destination", Some(3), 4, "steps")]
        );
        let parts: Vec<_> = Info::LAYOUT.iter().map(|row| (row.offset, row.part)).collect();
        assert_eq!(
            parts,
            [
                (Some(0), PartKind::Fixed),
                (Some(6), PartKind::Text16),
                (None, PartKind::Text16),
                (None, PartKind::Fixed),
                (None, PartKind::Optional)
            ]
        );
        assert_eq!(Shoot::LAYOUT[1].element[1].offset, Some(1));
    }

    #[test]
    fn short_bodies_say_what_they_lack() {
        assert_eq!(
            Jog::decode(&[1, 2]),
            Err(DecodeError::Truncated { what: "Jog", needed: 7, have: 2 }),
            "one check for all fixed fields"
        );
        assert_eq!(
            Info::decode(&[0, 0, 0, 0, 0, 0, 0, 3, b'a']),
            Err(DecodeError::Truncated { what: "Info.name", needed: 11, have: 9 })
        );
        assert_eq!(Exact::decode(&[0; 6]), Err(DecodeError::Trailing { what: "Exact", extra: 1 }));
        assert_eq!(Count::decode(&[2, 0]), Err(DecodeError::Truncated { what: "Count.motors", needed: 11, have: 2 }));
    }

    #[test]
    fn what_would_be_read_back_as_something_else_is_refused() {
        let run = |options, reason, tail| {
            Everything::Run(Run { rate: Rate(crate::fixed::Scaled(24_000)), options, reason, tail })
        };
        let hole = encode(&run(None, Some(Reason::FAULT), &[]));
        assert_eq!(hole, Err(EncodeError::Hole { what: "Run.reason" }));
        let swallowed = encode(&run(None, None, &[1, 2]));
        assert_eq!(swallowed, Err(EncodeError::Tail { what: "Run.options", len: 2 }));
        assert!(encode(&run(None, None, &[1])).is_ok(), "one byte is no flag word, so it stays a tail");
        let places = [Place::new(Motor(1), Steps(5)); 256];
        let count = Everything::Count(Count { motors: Counted(&places), reason: Reason::SWITCH, tail: &[] });
        assert_eq!(encode(&count), Err(EncodeError::TooLong { what: "Count.motors", len: 256, max: 255 }));
        let shoot = Everything::Shoot(Shoot { frame: 1, motors: &places[..1], tail: &[0; 5] });
        assert_eq!(encode(&shoot), Err(EncodeError::Tail { what: "Shoot.motors", len: 5 }));
    }

    #[test]
    fn an_absent_optional_closes_those_behind_it() {
        let run = Run::decode(&[0, 0, 0, 0, 7]).unwrap();
        assert_eq!((run.options, run.reason, run.tail), (None, None, &[7u8][..]), "not the reason");
    }

    #[test]
    fn values_print_as_a_person_reads_them() {
        let places = [Place::new(Motor(1), Steps(-5))];
        let shoot = Everything::Shoot(Shoot { frame: 7, motors: &places, tail: &[0xab] });
        assert_eq!(format!("{shoot}"), "Shoot { frame: 7, motors: [{ motor: 1, position: -5 steps }], tail: ab }");
        assert_eq!(format!("{}", Everything::Go(Empty { tail: &[] })), "Go");
        assert_eq!(format!("{:?} {:?}", Reason::FAULT, Reason(7)), "Reason(FAULT) Reason(7)");
        assert_eq!(format!("{} {}", Options::all(), Options(0)), "LOOP | PING_PONG | 0xfffc none");
        assert_eq!(format!("{:?}", Turns(f32::from_bits(0x7fc0_0001))), "Turns(NaN)");
        let secret = Info {
            address: Bytes([1; 6]),
            name: Text16(b"a\0"),
            password: Password(b"hush"),
            turns: Turns(1.5),
            count: Newer(None),
            tail: &[],
        };
        assert!(!format!("{secret:?} {}", Everything::Info(secret)).contains("hush"));
        assert_eq!(secret.name.as_str(), Some("a"));
    }

    #[test]
    fn one_message_may_have_several_numbers() {
        let ack = Everything::decode_body(0x83, &[1]).unwrap();
        assert!(matches!(ack, Everything::Ack(Ack { of: 3, .. })));
        assert_eq!(ack.number(), 0x83);
        assert!(matches!(Everything::decode_body(17, &[0; 14]), Ok(Everything::Info(_))));
        assert!(matches!(Everything::decode_body(99, &[1]), Ok(Everything::Other(other)) if other.id() == 99));
    }

    #[test]
    fn numbers_may_be_told_apart_byte_by_byte() {
        let name = |number| Bytewise::decode_body(number, &[0; 5]).unwrap().name();
        assert_eq!([0x02_00, 0x02_01, 0x02_03, 0x02_04].map(name), ["Go", "Exact", "Exact", "Other"]);
        assert_eq!([0x1_02_00, 0x1_02_FF, 0x1_03_00].map(name), ["Raw", "Raw", "Other"]);
        assert_eq!(name(0x0100_0200), "Other", "the highest byte counts");
        assert_eq!(Bytewise::decode_body(0x02_02, &[0; 6]).unwrap().name(), "Inexact");
        assert_eq!(
            Bytewise::ALL.iter().map(|kind| kind.number).collect::<Vec<_>>(),
            [0x02_00, 0x02_01, 0x02_01, 0x1_02_00]
        );
    }

    #[test]
    fn a_row_states_the_conduct_of_its_messages() {
        let rows: Vec<_> =
            Everything::ALL.iter().map(|kind| kind.conduct.map(|conduct| format!("{conduct}"))).collect();
        let rows: Vec<_> = rows.iter().map(|row| row.as_deref().unwrap_or("by its values")).collect();
        let expected = ["moves once, in sequence", "by its values", "sets", "sets once", "arms", "moves", "stops"];
        assert_eq!(rows[..7], expected);
        assert_eq!(rows[7..], ["asks", "resets once", "asks, in sequence"]);

        let jog = |speed| Everything::from(Jog { motor: Motor(3), speed, destination: Steps(0), tail: &[] }).conduct();
        assert!(jog(0).is_stop() && jog(0).repeatable && !jog(0).may_move());
        assert!(jog(1).may_move() && !jog(1).repeatable);
        assert_eq!(Everything::other(99, &[]).conduct(), Conduct::UNKNOWN);
        assert_eq!(BytewiseCommand::from(Empty { tail: &[] }).conduct(), Conduct::new(Purpose::Moves));
        assert_eq!(Messages::conduct(&Bytewise::other(99, &[])), None, "no host sends it");
        assert_eq!(format!("{:?}", Conduct::UNKNOWN), "Conduct(moves once)");
    }

    #[test]
    fn two_messages_may_share_a_number() {
        assert!(matches!(Everything::decode_body(3, &[0; 5]), Ok(Everything::Exact(_))));
        assert!(matches!(Everything::decode_body(3, &[0; 6]), Ok(Everything::Inexact(_))));
    }

    #[test]
    #[cfg(all(feature = "alloc", feature = "bytes"))]
    fn a_whole_frame_goes_into_a_vector_or_a_buffer() {
        for len in [3, 200] {
            let body = &[7; 200][..len];
            let message = Everything::decode_body(8, body).unwrap();
            let frame = [&[8, u8::try_from(len).unwrap()], body].concat();
            assert_eq!(message.to_vec(Motor(1)), Ok(frame.clone()));
            let mut buf = Vec::new();
            assert_eq!(message.encode(Motor(1), &mut buf), Ok(frame.len()));
            assert_eq!(buf, frame);
            assert_eq!(Everything::decode(&&frame[..]), Ok(message));
        }
    }

    #[test]
    fn a_decoder_that_cannot_fail_gives_other() {
        assert_eq!(Bytewise::decode(&&[7, 1, 9][..]), Bytewise::other(7, &[9]));
        assert_eq!(Bytewise::decode(&&[7][..]), Bytewise::other(0, &[]));
        let mut out = [0; 3];
        assert_eq!(Bytewise::other(7, &[9]).encode_checked(&(), &mut out), Ok(3));
        assert_eq!(out, [7, 1, 9]);
    }
}
