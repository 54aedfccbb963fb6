//! Laws 1, 3 to 7, 11 and 12: what holds for the body of every message, for any bytes.

use motion_core::wire::print::MAX_PRINTED;
use motion_core::wire::{DecodeError, EncodeError, FieldView, Fields, Messages, PartKind, Row, Side, Value};
use motion_core::zerocopy::byteorder::U16;

/// Checks every law that holds for any body under any number.
///
/// # Errors
///
/// [`DecodeError`], if it cannot be decoded, which is no broken law.
///
/// # Panics
///
/// If a law is broken.
pub fn any_body<S: Side>(number: u32, body: &[u8]) -> Result<(), DecodeError> {
    let message = S::Message::decode_body(number, body)?;
    assert_eq!(message.number(), number, "12: the number survives: {message:?}");
    assert_eq!(message.body_len(), body.len(), "6: {message:?} was decoded from all of the body");

    let mut out = vec![0xa5; body.len() + 8];
    let written = message.encode_body(&mut out);
    assert_eq!(written, Ok(body.len()), "6: encoded_len is what encode_into writes: {message:?}");
    assert_eq!(&out[..body.len()], body, "2, 12: every bit survives: {message:?}");
    assert!(out[body.len()..].iter().all(|&byte| byte == 0xa5), "7: nothing is written beyond: {message:?}");
    assert_eq!(S::Message::decode_body(number, &out[..body.len()]), Ok(message), "1: decode of encode");

    let kept = S::Message::other(number, body).encode_body(&mut vec![0; body.len()]);
    let refused = Err(EncodeError::Typed { what: message.name() });
    let expected = if message.name() == "Other" { written } else { refused };
    assert_eq!(kept, expected, "1: a message without a type never travels as {message:?}");

    if let Some(short) = body.len().checked_sub(1) {
        let mut out = vec![0xa5; short];
        let refused = message.encode_body(&mut out);
        assert_eq!(refused, Err(EncodeError::BufferTooSmall { needed: body.len(), have: short }), "7: {message:?}");
        assert!(out.iter().all(|&byte| byte == 0xa5), "7: nothing is written at all: {message:?}");
    }

    printing(&message);
    layout::<S>(&message, body);
    let _ = S::lint(&message);
    Ok(())
}

/// Laws 3 and 4: the prefixes of a body, and the body with bytes behind it.
///
/// # Panics
///
/// If a law is broken.
pub fn prefixes<S: Side>(number: u32, body: &[u8]) {
    for len in 0..body.len() {
        // Either an error, or a message whose encoding is exactly this prefix.
        let _ = any_body::<S>(number, &body[..len]);
    }
    for extra in 1..20 {
        let _ = any_body::<S>(number, &[body, &vec![0x5a; extra]].concat());
    }
}

/// Every message of the table, from bodies of every length up to 80 and a few patterns.
///
/// # Panics
///
/// If a law is broken, or a message of the table cannot be decoded from any of them.
pub fn table<S: Side>() {
    for kind in S::Message::ALL {
        let mut decoded = 0;
        for len in 0..80_u8 {
            let patterns: [Vec<u8>; 4] = [
                vec![0; len.into()],
                vec![0xff; len.into()],
                (0..len).collect(),
                (0..len).map(|at| at.wrapping_mul(37) ^ 0xd4).collect(),
            ];
            decoded += patterns.iter().filter(|body| any_body::<S>(kind.number, body).is_ok()).count();
        }
        assert!(decoded > 0, "{} is never decoded", kind.name);
        rows(kind.name, kind.layout);
    }
    let mut names: Vec<_> = S::Message::ALL.iter().map(|kind| kind.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), S::Message::ALL.len(), "each name stands once in the table");
}

/// The rows of a layout follow each other without a gap.
fn rows(name: &str, rows: &[Row]) {
    let mut next = Some(0);
    for row in rows {
        assert_eq!(row.offset, next, "{name}.{} stands where the fields before it end", row.name);
        assert!(!row.name.is_empty() && !row.wire.is_empty(), "{name}: {row:?}");
        next = match row.part {
            PartKind::Fixed | PartKind::Optional => next.map(|at| at + row.size),
            _ => None,
        };
        self::rows(row.name, row.element);
    }
}

/// Law 11.
fn printing<M: Fields + ToString + core::fmt::Debug>(message: &M) {
    let text = message.to_string();
    let limit = MAX_PRINTED + "… (18446744073709551615 bytes more)".len();
    assert!(text.len() <= limit, "11: {} bytes of text", text.len());
    assert!(!text.chars().any(char::is_control), "11: no control characters: {text:?}");
}

/// What the decoder found in the fixed fields is what stands where the layout says.
fn layout<S: Side>(message: &S::Message<'_>, body: &[u8]) {
    let Some(kind) = S::Message::ALL.iter().find(|kind| kind.name == message.name()) else { return };
    let fixed: Vec<&Row> =
        kind.layout.iter().filter(|row| row.part == PartKind::Fixed && row.offset.is_some()).collect();
    let mut seen: Vec<(&'static str, String)> = Vec::new();
    message.fields(&mut |field: &FieldView<'_>| seen.push((field.name, number(field.value))));
    for row in fixed {
        let at = row.offset.unwrap_or_default();
        let bytes = &body[at..at + row.size];
        let (_, value) =
            seen.iter().find(|(name, _)| *name == row.name).unwrap_or_else(|| panic!("{} is shown", row.name));
        assert_eq!(*value, stored::<S>(row, bytes), "{}.{} at {at}", kind.name, row.name);
    }
}

fn number(value: Value<'_>) -> String {
    match value {
        Value::Unsigned(number) => number.to_string(),
        Value::Signed(number) => number.to_string(),
        Value::Float(number) => format!("{:08x}", number.to_bits()),
        Value::Bytes(bytes) => format!("{bytes:02x?}"),
        _ => "structured".to_string(),
    }
}

fn stored<S: Side>(row: &Row, bytes: &[u8]) -> String {
    let mut ordered = bytes.to_vec();
    if U16::<S::Order>::new(1).to_bytes() == [1, 0] {
        ordered.reverse();
    }
    let unsigned = ordered.iter().fold(0_i64, |number, &byte| number << 8 | i64::from(byte));
    let sign = 1_i64 << (8 * row.size.min(4) - 1);
    match row.wire {
        "u8" | "u16" | "u32" => unsigned.to_string(),
        "i16" | "i32" => ((unsigned ^ sign) - sign).to_string(),
        "f32" => format!("{unsigned:08x}"),
        "bytes" => format!("{bytes:02x?}"),
        _ => "structured".to_string(),
    }
}
