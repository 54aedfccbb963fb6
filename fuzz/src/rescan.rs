//! Searches for frames without buffers, one for each protocol, for the laws of streams.
//!
//! Each function gets the rest of a stream, which is never empty. It returns the length of a sound frame at its start
//! (`Ok`), or the number of bytes to skip (`Err`).

/// Search for kOS messages of up to `max` bytes. Bytes that would be fatal are skipped. Source: kOS, Message Header.
pub fn kos(bytes: &[u8], max: usize) -> Result<usize, usize> {
    if bytes[0] != 4 {
        return Err(1);
    }
    let [_, high, low, ..] = *bytes else { return Err(bytes.len()) };
    match usize::from(high) * 256 + usize::from(low) {
        0..6 => Err(1),
        total if total <= max && total <= bytes.len() => Ok(total),
        total => Err(total),
    }
}

/// Search for DMC frames of up to `max` bytes. Source: DMC, Message Format.
pub fn dmc(bytes: &[u8], max: usize) -> Result<usize, usize> {
    let [b'D', b'F', _, _, _, _, _, _, low, high, ..] = *bytes else { return Err(1) };
    let total = 10 + (usize::from(high) * 256 + usize::from(low)) + 2;
    let Some(frame) = bytes.get(..total).filter(|_| total <= max) else { return Err(1) };
    if fletcher16(frame) == 0 { Ok(total) } else { Err(1) }
}

/// Search for hoot packets with up to `max` bytes of data, as a master searches. Source: hoot, section 1.
pub fn hoot(bytes: &[u8], max: usize) -> Result<usize, usize> {
    let [0, 0, 0, 0, 0, 0xFF, _, _, _, len, data @ ..] = bytes else { return Err(1) };
    let len = usize::from(*len);
    if len <= max && len <= data.len() { Ok(10 + len) } else { Err(1) }
}

/// Search for hoot packets as a node reads: ten bytes, then the data. They are a packet only if they start with a
/// break. Source: hoot, section 1.1.
pub fn hoot_strict(bytes: &[u8], max: usize) -> Result<usize, usize> {
    let Some(&len) = bytes.get(9) else { return Err(bytes.len()) };
    let total = 10 + usize::from(len);
    let is_packet = bytes.starts_with(&[0, 0, 0, 0, 0, 0xFF]) && usize::from(len) <= max && total <= bytes.len();
    if is_packet { Ok(total) } else { Err(total) }
}

/// Fletcher-16 by its definition: both sums, modulo 255 after every byte.
pub fn fletcher16(bytes: &[u8]) -> u16 {
    let (f0, f1) = bytes.iter().fold((0, 0), |(f0, f1), &byte| {
        let f0 = (f0 + u16::from(byte)) % 255;
        (f0, (f1 + f0) % 255)
    });
    f1 << 8 | f0
}
