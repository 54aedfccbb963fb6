//! Second decoder of every message, written with nom from the specification alone, for the tests and for a fuzzer.
//!
//! It shares no line with the crate: frames, sums, fields and names are all written again here.

use dmc_proto::{DeviceMessage, Frame, HostMessage};
use motion_core::wire::Messages;
use nom::branch::alt;
use nom::bytes::complete::{tag, take};
use nom::combinator::{all_consuming, consumed, map, opt, success};
use nom::error::Error;
use nom::multi::{length_data, many_m_n, many0};
use nom::number::complete::{le_i16, le_i32, le_u8, le_u16, le_u32};
use nom::{IResult, Parser};
use serde_json::{Value, json};

/// Id, type and data of one whole frame.
pub(crate) fn frame(bytes: &[u8]) -> Option<(u32, u16, &[u8])> {
    let frame = (tag(&b"DF"[..]), le_u32, le_u16, length_data(le_u16), take(2_usize));
    let parsed: IResult<_, _> = all_consuming(consumed(frame)).parse(bytes);
    let (_, (all, (_, id, kind, data, _))) = parsed.ok()?;
    (sum(all) == 0).then_some((id, kind, data))
}

/// Checksum after the listing at the end of the specification.
fn sum(data: &[u8]) -> u16 {
    let (mut sum1, mut sum2) = (0_u16, 0_u16);
    for block in data.chunks(20) {
        for byte in block {
            sum1 += u16::from(*byte);
            sum2 += sum1;
        }
        sum1 %= 0xff;
        sum2 %= 0xff;
    }
    sum2 << 8 | sum1
}

fn hex(bytes: &[u8]) -> String {
    let digits = bytes.iter().flat_map(|byte| [byte >> 4, byte & 0xf]);
    digits.map(|digit| char::from_digit(digit.into(), 16).unwrap()).collect()
}

/// Numbers, each with a name.
fn named<T: Into<Value>, const N: usize>(names: [&str; N], numbers: Vec<T>) -> Value {
    names
        .into_iter()
        .map(String::from)
        .zip(numbers.into_iter().map(Into::into))
        .collect::<serde_json::Map<_, _>>()
        .into()
}

/// Fields of a body without absent ones, and the bytes after them.
fn fields<'a>(
    body: &'a [u8],
    mut parser: impl Parser<&'a [u8], Output = Value, Error = Error<&'a [u8]>>,
) -> Option<Value> {
    let (tail, mut fields) = parser.parse(body).ok()?;
    let object = fields.as_object_mut()?;
    object.retain(|_, value| !value.is_null());
    if !tail.is_empty() {
        object.insert("tail".into(), hex(tail).into());
    }
    Some(fields)
}

/// Messages of Dragonframe.
fn host(kind: u16, body: &[u8]) -> Option<Value> {
    match kind {
        0x0001 | 0x0022 | 0x0030 | 0x0034 => fields(body, success(json!({}))),
        0x0020 => fields(
            body,
            map(
                (le_u8, le_u16, many0(le_u8)),
                |(ramp, channel, values)| json!({ "ramp": ramp, "start_channel": channel, "values": values }),
            ),
        ),
        0x0021 => fields(body, map(le_u32, |triggers| json!({ "triggers": triggers }))),
        0x0023 => fields(body, map(le_u32, |flags| json!({ "flags": flags }))),
        0x0031 | 0x0035 => {
            fields(body, map((le_u8, le_i32), |(motor, position)| json!({ "motor": motor, "position": position })))
        }
        0x0032 => fields(body, map(le_u8, |motor| json!({ "motor": motor }))),
        0x0033 => fields(body, map(opt(le_u32), |flags| json!({ "flags": flags }))),
        0x0036 => fields(
            body,
            map(
                (le_u8, le_u16, le_i32),
                |(motor, speed, destination)| json!({ "motor": motor, "speed": speed, "destination": destination }),
            ),
        ),
        0x0037 => fields(body, map((le_u8, le_u8), |(motor, flags)| json!({ "motor": motor, "flags": flags }))),
        0x0038 => fields(
            body,
            map(
                (le_u8, le_u32, le_u32),
                |(motor, velocity, accel)| json!({ "motor": motor, "max_velocity": velocity, "max_accel": accel }),
            ),
        ),
        0x0039 => fields(
            body,
            map((le_u8, le_u8, le_i32, le_u8, le_i32, le_u8), |(motor, low_on, low, up_on, up, hw)| {
                json!({
                    "motor": motor, "lower_enable": low_on, "lower": low, "upper_enable": up_on, "upper": up,
                    "hw_set": hw
                })
            }),
        ),
        0x0100..0x0200 => real_time(kind, body),
        0x0200..0x0300 => virtuals(kind, body),
        _ => Some(json!({ "data": hex(body) })),
    }
}

/// Messages of the chapter on real-time moves.
fn real_time(kind: u16, body: &[u8]) -> Option<Value> {
    let motor_pair = map((le_u8, le_i32, le_i32), |(motor, a, b)| json!({ "motor": motor, "pos_a": a, "pos_b": b }));
    match kind {
        0x0103 | 0x0113 | 0x0116 => fields(body, success(json!({}))),
        0x0100 => fields(body, map((le_i32, le_i32), |(start, end)| json!({ "start_frame": start, "end_frame": end }))),
        0x0101 => fields(
            body,
            map(
                (le_u8, le_u32, many0(le_i32)),
                |(motor, index, positions)| json!({ "motor": motor, "start_index": index, "positions": positions }),
            ),
        ),
        0x0102 => fields(
            body,
            map(
                (le_u16, le_u32, many0(le_u8)),
                |(channel, index, levels)| json!({ "channel": channel, "start_index": index, "levels": levels }),
            ),
        ),
        0x0104 => {
            let pair = map((le_u32, le_u32), |(frame, values)| json!({ "frame": frame, "values": values }));
            fields(body, map((le_u32, many0(pair)), |(mask, pairs)| json!({ "mask": mask, "pairs": pairs })))
        }
        0x0110 => fields(body, map(le_i32, |frame| json!({ "frame": frame }))),
        0x0111 => fields(
            body,
            map(
                (
                    (le_u32, le_i32, le_i32, le_u32, le_u32, le_u8, le_u32, le_u16, le_u16),
                    (opt(le_u16), opt(le_u16), opt(le_u16)),
                ),
                |((fps, start, end, pre, post, dmx, bloop, channel, ms), (flags, open, close))| {
                    json!({
                        "fps_x1000": fps, "start_frame": start, "end_frame": end,
                        "pre_roll_ms": pre, "post_roll_ms": post, "sync_dmx": dmx,
                        "bloop_location": bloop, "bloop_dmx_channel": channel, "bloop_ms": ms,
                        "flags": flags, "open_angle": open, "close_angle": close
                    })
                },
            ),
        ),
        0x0112 => fields(
            body,
            map((le_i32, le_u8, le_u32, le_u16, many0(motor_pair)), |(frame, direction, exposure, blur, motors)| {
                json!({
                    "frame": frame, "direction": direction, "exposure_ms": exposure, "blur_x10": blur, "motors": motors
                })
            }),
        ),
        0x0115 => fields(
            body,
            map((le_i32, le_u32, le_u16, le_u16, many0(motor_pair)), |(frame, exposure, open, close, motors)| {
                json!({
                    "frame": frame, "exposure_ms": exposure, "open_angle": open, "close_angle": close, "motors": motors
                })
            }),
        ),
        0x0120 => fields(body, map((le_u32, le_i32), |(fps, frame)| json!({ "fps_x1000": fps, "destination": frame }))),
        _ => Some(json!({ "data": hex(body) })),
    }
}

/// Messages of the chapter on virtual motors.
fn virtuals(kind: u16, body: &[u8]) -> Option<Value> {
    match kind {
        0x0200 => virtual_rig(body),
        0x0201 => fields(
            body,
            map((le_u8, le_i32), |(motor, position)| json!({ "virtual_motor": motor, "position_x1e5": position })),
        ),
        0x0202 => fields(body, map(le_u8, |motor| json!({ "virtual_motor": motor }))),
        0x0203 => fields(
            body,
            map(
                (le_u8, le_u16, le_i32),
                |(motor, speed, to)| json!({ "virtual_motor": motor, "speed": speed, "destination": to }),
            ),
        ),
        0x0205 => fields(body, success(json!({}))),
        0x0206 => fields(body, map((le_u8, le_i16), |(axis, speed)| json!({ "axis": axis, "speed": speed }))),
        0x0207 => fields(body, aim_point),
        _ => Some(json!({ "data": hex(body) })),
    }
}

fn aim_point(body: &[u8]) -> IResult<&[u8], Value> {
    map(
        (le_u8, le_i32, le_i32, le_i32),
        |(enable, x, y, z)| json!({ "enable": enable, "aim_x": x, "aim_y": y, "aim_z": z }),
    )
    .parse(body)
}

/// Layout of a rig, which depends on the type before it.
fn virtual_rig(body: &[u8]) -> Option<Value> {
    let (&kind, rest) = body.split_first()?;
    let mut rig = match kind {
        0 => fields(rest, success(json!({}))),
        1 => fields(rest, boom_swing_track),
        2 => fields(
            rest,
            map(many_m_n(4, 4, le_u32), |numbers| named(["swing_motor", "swing_spu", "pan_motor", "pan_spu"], numbers)),
        ),
        _ => Some(json!({ "opaque": hex(rest) })),
    }?;
    rig["type"] = kind.into();
    Some(rig)
}

fn boom_swing_track(body: &[u8]) -> IResult<&[u8], Value> {
    let axes = many_m_n(6, 6, (le_u32, le_u32, le_i32));
    let lengths = (le_u32, le_u32, le_i32, le_i32, le_i32);
    let (rest, (axes, lengths)) = (axes, lengths).parse(body)?;
    let (tail, (table, safe)) = (opt(many_m_n(121, 121, le_i32)), opt(le_u32)).parse(rest)?;
    let mut rig = json!({
        "boom_length_x1000": lengths.0, "boom_ext_x1000": lengths.1,
        "nodal_x_x1000": lengths.2, "nodal_y_x1000": lengths.3, "nodal_z_x1000": lengths.4,
        "boom_table": table, "safe_distance_x1000": safe
    });
    for (name, (motor, spu, position)) in ["boom", "swing", "track", "pan", "tilt", "roll"].into_iter().zip(axes) {
        rig[format!("{name}_motor")] = motor.into();
        rig[format!("{name}_spu")] = spu.into();
        rig[format!("{name}_pos_x1e5")] = position.into();
    }
    Ok((tail, rig))
}

/// Messages of a controller.
fn device(kind: u16, body: &[u8]) -> Option<Value> {
    match kind {
        0x0001 => fields(body, greeting),
        0x0022 => fields(body, map(le_u32, |triggers| json!({ "triggers": triggers }))),
        0x0113 | 0x0114 => fields(body, success(json!({}))),
        0x0030 => {
            fields(body, map((le_u32, le_u8), |(motors, dmx)| json!({ "motor_status": motors, "dmx_status": dmx })))
        }
        0x0031 => fields(body, map(le_u8, |moving| json!({ "moving": moving }))),
        0x0034 => fields(
            body,
            map((le_i32, many0(le_i32)), |(time, positions)| json!({ "move_time": time, "positions": positions })),
        ),
        0x003a => fields(body, map((le_u8, opt(le_u8)), |(reason, motor)| json!({ "reason": reason, "motor": motor }))),
        0x0205 => {
            let names = ["track", "ew", "ns", "pan", "tilt", "roll"];
            let pose = map(many_m_n(6, 6, le_i32), |numbers| named(names, numbers));
            // The aim counts as a whole. Otherwise only its first byte counts.
            let aim = opt(alt((aim_point, map(le_u8, |enable| json!({ "enable": enable })))));
            fields(
                body,
                map((pose, aim), |(mut pose, aim)| {
                    for (name, value) in aim.iter().flat_map(|aim| aim.as_object().unwrap()) {
                        pose[if name == "enable" { "aim_enabled" } else { name }] = value.clone();
                    }
                    pose
                }),
            )
        }
        0x0207 => fields(body, aim_point),
        0x8000.. => fields(body, map(opt(le_u16), |code| json!({ "response_code": code }))),
        _ => Some(json!({ "data": hex(body) })),
    }
}

fn greeting(body: &[u8]) -> IResult<&[u8], Value> {
    let name = map(take(32_usize), |bytes: &[u8]| bytes.split(|byte| *byte == 0).next().unwrap_or_default().to_vec());
    let counts = (le_u8, le_u16, le_u8, le_u8, le_u8, le_u32);
    let mut whole = (name, (le_u8, le_u8, le_u8), counts, le_u32, opt(le_u16));
    let (tail, (name, version, counts, capabilities, protocol)) = whole.parse(body)?;
    let mut fields = json!({
        "fw_major": version.0, "fw_minor": version.1, "fw_rev": version.2,
        "motor_count": counts.0, "dmx_count": counts.1, "gio_out_count": counts.2, "gio_in_count": counts.3,
        "hw_limit_count": counts.4, "upload_frame_count": counts.5,
        "capabilities": capabilities, "protocol_version": protocol
    });
    match String::from_utf8(name) {
        Ok(name) => fields["name"] = name.into(),
        Err(error) => fields["name_bytes"] = hex(error.as_bytes()).into(),
    }
    Ok((tail, fields))
}

/// Checks that both decoders give the same values, or that both refuse.
pub(crate) fn agree(kind: u16, body: &[u8]) {
    let message = HostMessage::decode_body(kind.into(), body);
    assert_eq!(
        message.ok().map(|message| serde_json::to_value(message).unwrap()),
        host(kind, body),
        "host, {kind:#06x}"
    );
    let message = DeviceMessage::decode_body(kind.into(), body);
    assert_eq!(
        message.ok().map(|message| serde_json::to_value(message).unwrap()),
        device(kind, body),
        "device, {kind:#06x}"
    );
}

/// Checks that both give the same id, type and data, or that both refuse.
pub(crate) fn frames_agree(bytes: &[u8]) {
    let ours = Frame::decode(bytes).ok().map(|frame| (frame.id().0, frame.kind().0, frame.payload()));
    assert_eq!(ours, frame(bytes));
}
