//! Owned messages and their JSON, with a table that has every kind of part.

#![expect(missing_docs, reason = "a table for tests")]

use motion_core::owned::Owned;
use motion_core::wire::{
    Block16, Bool, Bytes, Counted, DecodeError, EncodeError, Fields, Message, Newer, Password, Reader, Rest, Row, Side,
    Text16, Visitor, Writer,
};
use motion_core::zerocopy::{self, BE};
use motion_core::{element, message, messages, unit};
use proptest::prelude::*;

unit! {
    /// A motor.
    pub struct Motor(u8) "";
    /// Steps.
    pub struct Steps(i32) "steps";
    /// Revolutions.
    pub struct Turns(f32) "rev";
}

/// Four letters; bytes after the first NUL are not shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Tag([u8; 4]);

impl core::fmt::Display for Tag {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        motion_core::wire::print::text(f, &self.0)
    }
}

impl motion_core::wire::Field for Tag {
    const SIZE: usize = 4;
    const WIRE: &'static str = "text[4]";

    fn read<O: zerocopy::ByteOrder>(reader: &mut Reader<'_, O>) -> Option<Self> {
        reader.array().map(Self)
    }
    fn write<O: zerocopy::ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        writer.array(self.0)
    }
    fn value(&self) -> motion_core::wire::Value<'_> {
        motion_core::wire::Value::Text(self.0.split(|&byte| byte == 0).next().unwrap_or_default())
    }
}

element! {
    /// Position of a motor.
    pub struct Place in BE, "place_count" {
        /// Number of the motor.
        motor: Motor,
        /// Position of the motor.
        position: Steps,
    }
}

message! {
    /// Fixed fields, and optional ones.
    pub struct Jog<'a> in BE {
        /// Number of the motor.
        motor: Motor,
        /// Distance of the jog.
        turns: Turns,
        /// Whether the motor is on.
        on: Bool,
        /// An address of six bytes.
        address: Bytes<6>,
        /// A tag of four letters.
        tag: Tag,
        ;
        /// Speed of the jog.
        speed: Option<u16>,
        /// Duration of the jog.
        time: Option<i16>,
    }

    /// A list up to the end of the body.
    pub struct Shoot<'a> in BE {
        ;
        /// Positions of the motors.
        motors: &'a [Place],
    }

    /// Numbers up to the end of the body.
    pub struct Curve<'a> in BE {
        ;
        /// The numbers of the curve.
        points: &'a [zerocopy::I32<BE>],
    }

    /// Parts of variable length in the middle.
    pub struct Info<'a> in BE {
        ;
        /// Positions of the motors.
        motors: Counted<'a, Place>,
        /// A name.
        name: Text16<'a>,
        /// A secret.
        password: Password<'a>,
        /// A block.
        block: Block16<'a>,
        /// A count that newer dialects add.
        count: Newer<u32>,
    }

    /// A message of any bytes.
    pub struct Raw<'a> in BE {
        ;
        /// All bytes of the body.
        data: Rest<'a>,
    }
}

motion_core::__logged! {
    /// A message that remembers its number.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct Ack<'a> {
        number: u32,
        body: Raw<'a>,
    }
}

impl<'a> Message<'a> for Ack<'a> {
    const LAYOUT: &'static [Row] = Raw::LAYOUT;

    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        Self::decode_as(0x80, body)
    }
    fn decode_as(number: u32, body: &'a [u8]) -> Result<Self, DecodeError> {
        Raw::decode(body).map(|body| Self { number, body })
    }
    fn number(&self, _: u32) -> u32 {
        self.number
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

motion_core::__logged! {
    /// A message whose layout does not fully describe it: its bytes are in the other order.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct Odd<'a>(Little<'a>);
}

message! {
    /// A number in the other byte order.
    pub struct Little<'a> in LE {
        /// The number.
        number: u16,
    }
}

impl<'a> Message<'a> for Odd<'a> {
    const LAYOUT: &'static [Row] = Little::LAYOUT;

    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        Little::decode(body).map(Self)
    }
    fn encoded_len(&self) -> usize {
        self.0.encoded_len()
    }
    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        self.0.encode_into(out)
    }
}

impl Fields for Odd<'_> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        self.0.fields(visitor);
    }
}

messages! {
    /// A message of each shape.
    pub enum Everything<'a> {
        1 => Jog(Jog<'a>),
        2 => Shoot(Shoot<'a>),
        3 => Curve(Curve<'a>),
        4 => Info(Info<'a>),
        5 => Raw(Raw<'a>),
        6 => Odd(Odd<'a>),
        0x80..=0xff => Ack(Ack<'a>),
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum All {}

impl Side for All {
    type Message<'a> = Everything<'a>;
    type Order = BE;
}

/// Messages whose layout does not fully describe them.
const IRREGULAR: &[&str] = &["Odd"];

const JOG: &str = r#"{"message":"Jog","number":1,"fields":{"motor":3,"turns":0.1,"on":1,"address":"000102030405","tag":"ab","speed":500,"tail":"ff"}}"#;
const JOG_BYTES: &[u8] = &[3, 0x3d, 0xcc, 0xcc, 0xcd, 1, 0, 1, 2, 3, 4, 5, b'a', b'b', 0, 0, 1, 0xf4, 0xff];

fn read(json: &str) -> Result<Owned<All>, String> {
    serde_json::from_str(json).map_err(|error| error.to_string())
}

/// The body from the JSON of a message with these fields, or the error.
fn body(message: &str, fields: &str) -> Result<Vec<u8>, String> {
    let json = format!(r#"{{"message":"{message}","fields":{fields}}}"#);
    read(&json).map(Owned::into_body)
}

#[test]
fn every_message_of_the_table_obeys_the_laws() {
    laws::owned::table::<All>(IRREGULAR);
}

proptest! {
    #[test]
    fn any_body_of_any_message_obeys_the_laws(number in 0_u32..0x90, body in proptest::collection::vec(any::<u8>(), 0..200)) {
        laws::owned::any_body::<All>(number, &body, IRREGULAR);
    }
}

#[test]
fn the_layout_turns_fields_into_bytes() {
    let jog = read(JOG).unwrap();
    assert_eq!((jog.number(), jog.body()), (1, JOG_BYTES));
    let Everything::Jog(message) = jog.message() else { panic!("{jog:?}") };
    assert_eq!((message.motor, message.speed, message.time, message.tail), (Motor(3), Some(500), None, &[0xff][..]));
    assert_eq!(body("Shoot", r#"{"motors":[{"motor":1,"position":-2}]}"#).unwrap(), [1, 255, 255, 255, 254]);
    assert_eq!(
        body("Info", r#"{"place_count":0,"motors":[],"name":"é","password":"p","block":"0a0B","count":7}"#).unwrap(),
        [0, 0, 2, 0xc3, 0xa9, 0, 1, b'p', 0, 2, 10, 11, 0, 0, 0, 7]
    );
}

#[test]
fn nan_and_texts_that_are_not_utf_8_have_another_form() {
    let jog = JOG.replace("0.1", r#""0x7fc00001""#).replace(r#""tag":"ab""#, r#""tag_bytes":"ff""#);
    let jog = read(&jog).unwrap();
    assert_eq!((&jog.body()[1..5], &jog.body()[12..16]), (&[0x7f, 0xc0, 0, 1][..], &[0xff, 0, 0, 0][..]));
    let short = JOG.replace("0.1", "1").replace(r#""on":1"#, r#""on":true,"time":null"#);
    assert_eq!(read(&short).unwrap().body()[1..6], [0x3f, 0x80, 0, 0, 1]);
}

#[test]
fn texts_lose_the_bytes_that_their_json_does_not_show() {
    let mut bytes = JOG_BYTES.to_vec();
    bytes[15] = b'x';
    let json = serde_json::to_string(&Owned::<All>::from_parts(1, bytes)).unwrap();
    assert_eq!(read(&json).unwrap().body(), JOG_BYTES);
}

#[test]
fn a_name_or_a_number_may_be_left_out() {
    assert_eq!(read(&JOG.replace(r#""number":1,"#, "")), read(JOG));
    assert_eq!(read(&JOG.replace(r#""message":"Jog","#, r#""offset":12,"canonical":true,"lint":[],"#)), read(JOG));
    let ack = read(r#"{"message":"Ack","number":131,"fields":{"data":"01"}}"#).unwrap();
    assert_eq!((ack.number(), ack.body()), (131, &[1][..]));
    let unknown = read(r#"{"number":99,"fields":{"data":"0102"}}"#).unwrap();
    assert!(matches!(unknown.message(), Everything::Other(other) if (other.id(), other.payload()) == (99, &[1, 2])));
}

#[test]
fn errors_name_the_field() {
    let jog = |from: &str, to: &str| read(&JOG.replace(from, to)).unwrap_err();
    for (error, expected) in [
        (jog(r#""motor":3,"#, ""), "Jog.motor: missing; the layout needs it for this message"),
        (jog(r#""motor":3"#, r#""motor":256"#), "Jog.motor: out of the range of u8"),
        (jog(r#""motor":3"#, r#""motor":3.0"#), "Jog.motor: should be an integer"),
        (jog(r#""motor":3"#, r#""motor":3,"rotor":3"#), "Jog.rotor: is not read back"),
        (jog(r#""motor":3"#, r#""motor":3,"motor":4"#), "motor: given twice"),
        (jog("0.1", "1e39"), "Jog.turns: out of the range of f32"),
        (jog("0.1", r#""0x3f800000""#), "Jog.turns: should be a number, or the 32 bits of one that is not finite"),
        (jog("0001020304", "000102030"), "Jog.address: should be a text of hex digits, two for each byte"),
        (jog("0001020304", "00010203"), "Jog.address: takes 5 bytes, should take 6"),
        (jog(r#""ab""#, r#""abcde""#), "Jog.tag: takes 5 bytes, should take 4"),
        (jog(r#""ab""#, r#""a\u0000b""#), "Jog.tag: is read back as something else"),
        (jog(r#""speed":500,"#, r#""time":5,"#), "Jog.time: is not read back"),
        (jog(r#""speed":500,"tail":"ff""#, r#""tail":"ffff""#), "Jog.tail: is not read back"),
        (jog("Jog", "Jig"), "Jig: there is no such message"),
        (jog(r#""number":1"#, r#""number":2"#), "Jog.number: is read back as something else"),
        (jog(r#""number":1"#, r#""number":-2"#), "number: out of the range of u32"),
        (read("[]").unwrap_err(), "should be a map"),
        (read("{}").unwrap_err(), "message: missing"),
        (read(r#"{"message":"Other","fields":{"data":""}}"#).unwrap_err(), "number: missing"),
        (body("Odd", r#"{"number":1}"#).unwrap_err(), "Odd.number: is read back as something else"),
        (body("Curve", r#"{"points":[0,2147483648]}"#).unwrap_err(), "Curve.points[1]: out of the range of i32"),
        (
            body("Shoot", r#"{"motors":[{"motor":1,"position":2},{"motor":1}]}"#).unwrap_err(),
            "Shoot.motors[1].position: missing",
        ),
    ] {
        assert!(error.contains(expected), "{error:?} does not say {expected:?}");
    }
}

#[test]
fn an_owned_message_is_its_number_and_bytes() {
    let points = [1.into(), 2.into()];
    let owned = Owned::<All>::new(&Everything::Curve(Curve { points: &points, tail: &[] })).unwrap();
    let same = Owned::from_parts(3, owned.body().to_vec());
    assert_eq!(owned, same);
    assert_ne!(owned, Owned::from_parts(5, owned.body().to_vec()), "the same bytes of another message");
    assert_eq!(owned.to_string(), "Curve { points: [1, 2] }");
    assert!(format!("{owned:?}").starts_with("Owned(Curve("), "{owned:?}");
    assert_eq!(owned.into_body(), [0, 0, 0, 1, 0, 0, 0, 2]);

    let swallowed = Everything::Shoot(Shoot { motors: &[], tail: &[0; 5] });
    assert_eq!(Owned::<All>::new(&swallowed), Err(EncodeError::Tail { what: "Shoot.motors", len: 5 }));

    let short = Owned::<All, _>::from_parts(1, [3_u8]);
    assert!(matches!(short.message(), Everything::Other(other) if (other.id(), other.payload()) == (1, &[3])));
}
