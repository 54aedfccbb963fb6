//! Second decoder, written with nom from the tables of the specification.

use kos_proto::message::Numbered;
use kos_proto::{DeviceMessage, Frame, HostMessage};
use motion_core::serialize::Map as Fields;
use nom::bytes::complete::{tag, take};
use nom::combinator::{all_consuming, map, rest, verify};
use nom::multi::{count, length_data};
use nom::number::complete::{be_u8, be_u16, be_u32};
use nom::{IResult, Parser};
use serde_json::{Map, Value, json};

type Object = Map<String, Value>;

/// Type of the specification.
#[derive(Clone, Copy)]
pub(crate) enum Type {
    U8,
    U32,
    Float,
    /// Hardware address.
    Mac,
    /// Four bytes, one by one.
    Version,
    String,
    Block,
    /// Field that may be left out.
    MaybeU8,
    /// Field that may be left out, but not be cut off.
    MaybeU32,
    /// All remaining bytes.
    Rest,
    /// Count, followed by that many groups.
    Motors(&'static [(&'static str, Type)]),
    /// Four points of two numbers.
    Points,
    /// Count, followed by that many blocks.
    Blocks,
}
use Type::{Block, Blocks, Float, Mac, MaybeU8, MaybeU32, Motors, Points, Rest, String as Text, U8, U32, Version};

pub(crate) type Row = (&'static str, Type);

const MOTOR: &[Row] = &[
    ("motor_address", U8),
    ("position", Float),
    ("begin_position", Float),
    ("end_position", Float),
    ("max_max_setup_speed", Float),
    ("max_max_move_speed", Float),
    ("max_max_acceleration", Float),
];
const OLD_MOTOR: &[Row] = &[
    ("motor_address", U8),
    ("position", Float),
    ("end_position", Float),
    ("max_max_setup_speed", Float),
    ("max_max_move_speed", Float),
    ("max_max_acceleration", Float),
];
const ONLINE: &[Row] = &[
    ("motor_address", U8),
    ("online_status", U8),
    ("motor_type", U8),
    ("max_max_setup_speed", Float),
    ("max_max_move_speed", Float),
    ("max_max_acceleration", Float),
];
const PLACE: &[Row] = &[("motor_address", U8), ("position", Float)];

const ADDRESS: &[Row] = &[("motor_address", U8)];
const LED: &[Row] = &[("master_status", U8), ("slave_status", U8)];
const MOVE: &[Row] = &[("blocks", Blocks)];
const PASSWORD: &[Row] = &[("password", Text)];

/// Section 2: messages of the client. Columns: id, type, action, name, and the fields after the header or after the
/// action.
pub(crate) const HOST: &[(u16, u8, u8, &str, &[Row])] = &[
    (0x00, 0, 0, "KeepAlive", &[]),
    (0x02, 1, 0, "NetworkInfo", &[("limited_response", MaybeU8)]),
    (0x07, 1, 0, "LEDStatus", &[]),
    (0x07, 0, 0, "LEDStatus", LED),
    (0x0B, 1, 0, "MotorInfo", &[]),
    (0x0F, 1, 0, "DeviceInfo", &[]),
    (0x10, 0, 0, "UserPassword", PASSWORD),
    (0x11, 0, 0, "DevicePassword", PASSWORD),
    (0x12, 1, 0, "TrajectoryData", &[]),
    (0x12, 0, 0, "TrajectoryData", MOVE),
    (0x1F, 1, 0, "DeviceGUID", &[]),
    (0x26, 1, 0, "SoftwareID", &[]),
    (0x26, 0, 0, "SoftwareID", &[("platform", U8)]),
    (0x80, 0, 0x01, "ResetDevice", &[]),
    (0x80, 0, 0x02, "ResetAxis", ADDRESS),
    (0x80, 0, 0x03, "MarkBeginPosition", ADDRESS),
    (0x80, 0, 0x04, "MarkEndPosition", ADDRESS),
    (0x80, 0, 0x05, "StartPlayback", &[("direction", U8), ("start_time", Float)]),
    (0x80, 0, 0x06, "StopPlayback", &[]),
    (0x80, 0, 0x07, "RapidToFirstKeyFrame", &[]),
    (0x80, 0, 0x09, "TakePicture", &[("motor_address", U8), ("exposure", Float)]),
    (0x80, 0, 0x0F, "SetupPlayback", &[("direction", U8), ("start_time", Float), ("delay_return", U8)]),
    (
        0x80,
        0,
        0x1C,
        "SetPositionSpeedAcceleration",
        &[("motor_address", U8), ("position", Float), ("speed", Float), ("acceleration", Float)],
    ),
    (
        0x80,
        0,
        0x28,
        "BumpPositionSpeedAcceleration",
        &[("motor_address", U8), ("delta", Float), ("speed", Float), ("acceleration", Float)],
    ),
];

/// Section 2: messages of the device in the newer layouts.
pub(crate) const DEVICE: &[(u16, u8, u8, &str, &[Row])] = &[
    (
        0x02,
        2,
        0,
        "NetworkInfo",
        &[
            ("dhcp", U8),
            ("mac_address", Mac),
            ("ip_address", U32),
            ("subnet_mask", U32),
            ("gateway", U32),
            ("device_type", U8),
            ("device_addr", U8),
        ],
    ),
    (0x07, 2, 0, "LEDStatus", LED),
    (0x0B, 2, 0, "MotorInfo", &[("motors", Motors(MOTOR))]),
    (0x0B, 0x82, 0, "MotorInfo", &[("motors", Motors(MOTOR))]),
    (
        0x0F,
        2,
        0,
        "DeviceInfo",
        &[
            ("device_type", U8),
            ("device_addr", U8),
            ("playback_mode", U8),
            ("playback_status", U8),
            ("firmware_version", Version),
            ("network_id", U8),
            ("hardware_id", U8),
            ("device_password", Text),
            ("aux_input_status", U8),
            ("delay_time_remaining", Float),
            ("elapsed_time", Float),
            ("photo_count", MaybeU32),
        ],
    ),
    (0x12, 2, 0, "TrajectoryData", MOVE),
    (0x1F, 2, 0, "DeviceGUID", &[("guid", Block)]),
    (0x26, 2, 0, "SoftwareID", &[("platform", U8)]),
    (0x81, 2, 0x01, "MotorStatus", &[("motors", Motors(ONLINE))]),
    (
        0x81,
        2,
        0x02,
        "PlaybackStatus",
        &[("playback_status", U8), ("elapsed_time", Float), ("photo_count", Float), ("motors", Motors(PLACE))],
    ),
    (0x81, 2, 0x03, "ErrorStatus", &[("error_code", U8), ("motor_address", U8)]),
    (0x81, 2, 0x07, "MotorPosition", PLACE),
    (0x81, 2, 0x11, "MotorCalibrated", &[("motor_address", U8), ("begin_position", Float), ("end_position", Float)]),
    (0x81, 2, 0x15, "AuxInputStatus", &[("status", U8)]),
    (0x81, 2, 0xFF, "UnsupportedMessage", &[("message", Rest)]),
];

/// Section 2.4.
const BLOCKS: &[(u8, &[Row])] = &[
    (
        1,
        &[
            ("playback_mode", U8),
            ("duration", Float),
            ("rapid_reverse_duration", Float),
            ("loop_after_rapid_reverse", U8),
            ("loop_after_reverse", U8),
            ("delay_mode", U8),
            ("delay_interval_bits", U32),
            ("camera_roll_enabled", U8),
            ("camera_roll_pre_delay", Float),
            ("camera_roll_post_delay", Float),
            ("flash_mark_enabled", U8),
            ("flash_mark_type", U8),
            ("flash_mark_post_delay", Float),
            ("use_external_trigger", U8),
            ("using_lanc", U8),
            ("return_to_home_percent", Float),
        ],
    ),
    (
        2,
        &[
            ("delay", Float),
            ("exposure", Float),
            ("move_photos", U32),
            ("not_used", U8),
            ("pre_move_photos", U32),
            ("post_move_photos", U32),
        ],
    ),
    (5, &[("motor_address", U8), ("segment_count", U8)]),
    (6, &[("motor_address", U8), ("segment_number", U8), ("points", Points)]),
];

/// Decision 7: layout of the older dialect, if the length `len` of the whole message is exactly that of the older
/// layout.
fn older(name: &str, message: &[u8]) -> Option<&'static [Row]> {
    let len = message.len();
    match name {
        "MotorInfo" => {
            let n = usize::from(*message.get(6)?);
            (n > 0 && len == 7 + 21 * n).then_some(&[("motors", Motors(OLD_MOTOR))])
        }
        "MotorCalibrated" => (len == 12).then_some(&[("motor_address", U8), ("end_position", Float)]),
        "PlaybackStatus" => {
            let n = usize::from(*message.get(12)?);
            (len == 13 + 5 * n).then_some(&[
                ("playback_status", U8),
                ("elapsed_time", Float),
                ("motors", Motors(PLACE)),
            ])
        }
        _ => None,
    }
}

fn hex(bytes: &[u8]) -> Value {
    let digits = bytes.iter().flat_map(|byte| [byte >> 4, byte & 0xf]);
    digits.map(|digit| char::from_digit(digit.into(), 16).unwrap()).collect::<String>().into()
}

fn number(bits: u32) -> Value {
    let number = f32::from_bits(bits);
    if number.is_finite() { f64::from(number).into() } else { format!("0x{bits:08x}").into() }
}

/// Reads a field into the object.
fn field<'a>(input: &'a [u8], (name, kind): Row, object: &mut Object) -> IResult<&'a [u8], ()> {
    let (input, value) = match kind {
        MaybeU8 | MaybeU32 if input.is_empty() => return Ok((input, ())),
        U8 | MaybeU8 => map(be_u8, Value::from).parse(input)?,
        U32 | MaybeU32 => map(be_u32, Value::from).parse(input)?,
        Float => map(be_u32, number).parse(input)?,
        Mac => map(take(6_usize), hex).parse(input)?,
        Version => map(count(be_u8, 4), Value::from).parse(input)?,
        Block => map(length_data(be_u16), hex).parse(input)?,
        Rest => map(rest, hex).parse(input)?,
        Text => {
            let (input, text) = length_data(be_u16).parse(input)?;
            let end = text.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
            match std::str::from_utf8(&text[..end]) {
                Ok(text) => object.insert(name.into(), text.into()),
                Err(_) => object.insert(format!("{name}_bytes"), hex(&text[..end])),
            };
            return Ok((input, ()));
        }
        Motors(rows) => {
            let (input, n) = be_u8(input)?;
            object.insert("motor_count".into(), n.into());
            map(count(|input| group(input, rows), n.into()), Value::from).parse(input)?
        }
        Points => map(count(count(map(be_u32, number), 2), 4), Value::from).parse(input)?,
        Blocks => {
            let (input, n) = be_u8(input)?;
            object.insert("block_count".into(), n.into());
            map(count(block, n.into()), Value::from).parse(input)?
        }
    };
    object.insert(name.into(), value);
    Ok((input, ()))
}

fn fields<'a>(input: &'a [u8], rows: &[Row], object: &mut Object) -> IResult<&'a [u8], ()> {
    rows.iter().try_fold((input, ()), |(input, ()), row| field(input, *row, object))
}

fn group<'a>(input: &'a [u8], rows: &[Row]) -> IResult<&'a [u8], Value> {
    let mut object = Object::new();
    let (input, ()) = fields(input, rows, &mut object)?;
    Ok((input, object.into()))
}

/// Reads fields, and the bytes after them.
fn with_tail(input: &[u8], rows: &[Row], object: &mut Object) -> Option<()> {
    let (tail, ()) = fields(input, rows, object).ok()?;
    if !tail.is_empty() {
        object.insert("tail".into(), hex(tail));
    }
    Some(())
}

fn block(input: &[u8]) -> IResult<&[u8], Value> {
    let (input, id) = be_u8(input)?;
    let (input, data) = length_data(be_u16).parse(input)?;
    let mut object = Object::from_iter([("block_id".into(), id.into())]);
    match BLOCKS.iter().find(|(known, _)| *known == id) {
        Some((_, rows)) => with_tail(data, rows, &mut object)
            .ok_or(nom::Err::Failure(nom::error::Error::new(input, nom::error::ErrorKind::Eof)))?,
        None => drop(object.insert("data".into(), hex(data))),
    }
    Ok((input, object.into()))
}

/// Section 1: header of a message that takes all of the input.
fn header(input: &[u8]) -> IResult<&[u8], (u16, u8)> {
    let whole = input.len();
    let (input, _) = tag(&[4_u8][..]).parse(input)?;
    let (input, _) = verify(be_u16, |&len| usize::from(len) == whole).parse(input)?;
    (be_u16, be_u8).parse(input)
}

/// Content of a message: its name, id, type and fields; `None` if it has to be refused.
fn oracle(table: &[(u16, u8, u8, &str, &[Row])], message: &[u8]) -> Option<Value> {
    let (mut body, (id, kind)) = header(message).ok()?;
    let mut object = Object::new();
    let (mut sub, mut name) = (0, "Other");
    for (marked, of, key) in [((0x80, 0), "Action", "action_id"), ((0x81, 2), "Notification", "note_id")] {
        if marked == (id, kind) {
            (body, sub) = be_u8::<_, nom::error::Error<_>>(body).ok()?;
            name = of;
            object.insert(key.into(), sub.into());
        }
    }
    let known = table.iter().find(|row| (row.0, row.1, row.2) == (id, kind, sub));
    if let Some((.., known, rows)) = known {
        name = known;
        with_tail(body, older(name, message).unwrap_or(rows), &mut object)?;
    } else {
        let data = all_consuming(map(rest::<_, nom::error::Error<_>>, hex)).parse(body).ok()?.1;
        object.insert("data".into(), data);
    }
    Some(json!({"message": name, "message_id": id, "message_type": kind, "fields": object}))
}

macro_rules! decoder {
    ($decode:ident, $side:ident) => {
        fn $decode(bytes: &[u8]) -> Option<Value> {
            let message = $side::decode(&Frame::decode(bytes).ok()?).ok()?;
            let fields = Fields { fields: &Numbered(&message), secrets: true };
            let (name, id, kind) = (message.specification_name(), message.id().0, message.kind().0);
            Some(json!({"message": name, "message_id": id, "message_type": kind, "fields": fields}))
        }
    };
}
decoder! { host, HostMessage }
decoder! { device, DeviceMessage }

/// Compares both decoders on both sides, and returns the values on which they agree.
pub(crate) fn agree(bytes: &[u8]) -> [Option<Value>; 2] {
    let (by_host, by_device) = (oracle(HOST, bytes), oracle(DEVICE, bytes));
    assert_eq!(host(bytes), by_host, "{bytes:02x?}");
    assert_eq!(device(bytes), by_device, "{bytes:02x?}");
    [by_host, by_device]
}

/// Message with any payload.
pub(crate) fn message(id: u16, kind: u8, payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![4];
    bytes.extend(u16::try_from(payload.len() + 6).unwrap().to_be_bytes());
    bytes.extend(id.to_be_bytes());
    bytes.push(kind);
    bytes.extend(payload);
    bytes
}
