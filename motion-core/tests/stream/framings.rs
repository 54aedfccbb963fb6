//! Framings like those of the three protocols, each with a rescan for comparison.
//!
//! The rescans are written separately and share no line with the framings.

use motion_core::fletcher::{PrefixSums, Sum};
use motion_core::stream::{Fatal, Framing, Head, Noise};

/// Framing like DMC: `DF`, id u32, type u16, length u16, data, two check bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Dmc<const MAX: usize> {}

/// The header: id and type.
pub(crate) type DmcHeader = (u32, u16);

impl<const MAX: usize> Framing for Dmc<MAX> {
    const MAX: usize = MAX;
    type Header = DmcHeader;
    type Frame<'a> = &'a [u8];
    type Memo<const N: usize> = PrefixSums<N>;

    fn head(bytes: &[u8]) -> Head {
        match bytes {
            [b'D', b'F', _, _, _, _, _, _, l0, l1, ..] => {
                let total = 12 + usize::from(u16::from_le_bytes([*l0, *l1]));
                if total > MAX { Head::Skip(2, Noise::TooLong { total, max: MAX }) } else { Head::Total(total) }
            }
            [b'D'] | [b'D', b'F', ..] => Head::More(10),
            [_, rest @ ..] => {
                let marker = rest.iter().position(|&byte| byte == b'D').unwrap_or(rest.len());
                Head::Skip(1 + marker, Noise::NoMarker)
            }
            [] => Head::More(1),
        }
    }
    fn header(bytes: &[u8]) -> Option<DmcHeader> {
        let [_, _, a, b, c, d, t0, t1] = *bytes.first_chunk()?;
        Some((u32::from_le_bytes([a, b, c, d]), u16::from_le_bytes([t0, t1])))
    }
    fn frame(bytes: &[u8]) -> Option<&[u8]> {
        Some(bytes)
    }
    fn give_up(_: &[u8]) -> usize {
        2
    }
}

pub(crate) fn dmc_frame(id: u32, kind: u16, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"DF".to_vec();
    bytes.extend(id.to_le_bytes());
    bytes.extend(kind.to_le_bytes());
    bytes.extend(u16::try_from(data.len()).unwrap().to_le_bytes());
    bytes.extend(data);
    bytes.extend(Sum::of(&bytes).check_bytes());
    bytes
}

pub(crate) fn dmc_rescan(max: usize) -> impl Fn(&[u8]) -> Result<usize, usize> {
    move |bytes| {
        if bytes.len() < 12 || bytes[0] != 0x44 || bytes[1] != 0x46 {
            return Err(1);
        }
        let total = 12 + usize::from(bytes[8]) + 256 * usize::from(bytes[9]);
        if total > max || total > bytes.len() {
            return Err(1);
        }
        let sums = bytes[..total].iter().fold((0_u32, 0_u32), |(a, b), &byte| {
            let a = (a + u32::from(byte)) % 255;
            (a, (b + a) % 255)
        });
        if sums == (0, 0) { Ok(total) } else { Err(1) }
    }
}

/// Framing like kOS: version 4, length of the whole frame u16 big-endian, id u16, type u8.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Kos<const MAX: usize> {}

impl<const MAX: usize> Framing for Kos<MAX> {
    const MAX: usize = MAX;
    type Header = u16;
    type Frame<'a> = &'a [u8];
    type Memo<const N: usize> = ();

    fn head(bytes: &[u8]) -> Head {
        match *bytes {
            [4, l0, l1, ..] => match usize::from(u16::from_be_bytes([l0, l1])) {
                found @ 0..6 => Head::Fatal(Fatal::BadLength { found, least: 6 }),
                total if total > MAX => Head::Skip(total, Noise::TooLong { total, max: MAX }),
                total => Head::Total(total),
            },
            [] | [4, ..] => Head::More(3),
            [found, ..] => Head::Fatal(Fatal::BadVersion { found, expected: 4 }),
        }
    }
    fn header(bytes: &[u8]) -> Option<u16> {
        let [_, _, _, i0, i1, _] = *bytes.first_chunk()?;
        Some(u16::from_be_bytes([i0, i1]))
    }
    fn frame(bytes: &[u8]) -> Option<&[u8]> {
        Some(bytes)
    }
    fn give_up(bytes: &[u8]) -> usize {
        bytes.len()
    }
}

pub(crate) fn kos_frame(id: u16, data: &[u8]) -> Vec<u8> {
    let mut bytes = vec![4];
    bytes.extend(u16::try_from(6 + data.len()).unwrap().to_be_bytes());
    bytes.extend(id.to_be_bytes());
    bytes.push(2);
    bytes.extend(data);
    bytes
}

pub(crate) fn kos_rescan(max: usize) -> impl Fn(&[u8]) -> Result<usize, usize> {
    move |bytes| {
        if bytes[0] != 4 {
            return Err(1);
        }
        if bytes.len() < 3 {
            return Err(bytes.len());
        }
        let total = 256 * usize::from(bytes[1]) + usize::from(bytes[2]);
        if total < 6 {
            Err(1)
        } else if total > max || total > bytes.len() {
            Err(total)
        } else {
            Ok(total)
        }
    }
}

/// Framing like hoot: `00 00 00 00 00 FF`, address, sub-address, command, length of the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Hoot {}

const BREAK: [u8; 6] = [0, 0, 0, 0, 0, 0xFF];

impl Framing for Hoot {
    const MAX: usize = 10 + 32;
    type Header = [u8; 3];
    type Frame<'a> = &'a [u8];
    type Memo<const N: usize> = ();

    fn head(bytes: &[u8]) -> Head {
        match *bytes {
            [0, 0, 0, 0, 0, 0xFF, _, _, _, len, ..] if len > 32 => {
                Head::Skip(6, Noise::TooLong { total: 10 + usize::from(len), max: Self::MAX })
            }
            [0, 0, 0, 0, 0, 0xFF, _, _, _, len, ..] => Head::Total(10 + usize::from(len)),
            _ if bytes.iter().zip(BREAK).all(|(&byte, wanted)| byte == wanted) => Head::More(10),
            _ => Head::Skip(1, Noise::NoMarker),
        }
    }
    fn header(bytes: &[u8]) -> Option<[u8; 3]> {
        let [_, _, _, _, _, _, address, sub, command] = *bytes.first_chunk()?;
        Some([address, sub, command])
    }
    fn frame(bytes: &[u8]) -> Option<&[u8]> {
        Some(bytes)
    }
}

pub(crate) fn hoot_frame(header: [u8; 3], data: &[u8]) -> Vec<u8> {
    let len = u8::try_from(data.len()).unwrap();
    [&BREAK[..], &header, &[len], data].concat()
}

pub(crate) fn hoot_rescan(bytes: &[u8]) -> Result<usize, usize> {
    let total = 10 + bytes.get(9).map_or(0, |&len| usize::from(len));
    if bytes.starts_with(&BREAK) && bytes.len() >= total && total <= 42 { Ok(total) } else { Err(1) }
}
