//! DMC streams that are made to be expensive, and the frames in them.

use dmc_proto::{Dmc, MessageId, MessageType};
use motion_core::fletcher;
use motion_core::stream::{Frames, Item};

/// Offsets and lengths of the frames that a stream finds.
pub(crate) fn found<const CAP: usize, const N: usize>(
    frames: &mut Frames<Dmc<CAP>, N>,
    stream: &[u8],
    cut: usize,
) -> Vec<(usize, usize)> {
    let (mut at, mut found) = (0, Vec::new());
    for mut piece in stream.chunks(cut) {
        let last = piece.as_ptr_range().end == stream.as_ptr_range().end;
        while !piece.is_empty() {
            let taken = frames.push(piece);
            piece = &piece[taken..];
            if last && piece.is_empty() {
                frames.gap();
            }
            while let Some(item) = frames.next() {
                let len = item.bytes().len();
                if matches!(item, Item::Frame(_)) {
                    found.push((at, len));
                }
                at += len;
            }
        }
    }
    assert_eq!(at, stream.len(), "every byte is part of an item");
    found
}

/// Offsets and lengths of the frames, found by a search from each byte in turn.
pub(crate) fn rescan(stream: &[u8], cap: usize) -> Vec<(usize, usize)> {
    let (mut at, mut found) = (0, Vec::new());
    while let Some(rest) = stream.get(at..).filter(|rest| rest.len() >= 12) {
        let len = 12 + usize::from(u16::from_le_bytes([rest[8], rest[9]]));
        let frame = rest.get(..len).filter(|_| len <= cap && rest.starts_with(b"DF"));
        let sound = frame.is_some_and(fletcher::verify);
        found.extend(sound.then_some((at, len)));
        at += if sound { len } else { 1 };
    }
    found
}

/// Expensive streams of `len` bytes each, for frames of up to `cap` bytes.
pub(crate) fn floods(cap: usize, len: usize) -> [(&'static str, Vec<u8>); 16] {
    let longest = cap - 12;
    let good = frame(&[0; 7]);
    let lie = |data_len| [&b"DF\x01\0\0\0\x36\0"[..], &le(data_len)].concat();
    // A marker every five bytes. The length field of each is inside the next marker but one.
    let dense = |data_len| [&b"DF\x09"[..], &le(data_len)].concat();
    // The first sums are equal at both ends of the claimed frames, so that the second sums must decide.
    let even = |data_len| {
        let [l0, l1] = le(data_len);
        let filler = [b'D', b'F', l0, l1].iter().fold(0, |sum, &byte| (sum + u32::from(byte)) % 255);
        [b'D', b'F', 255 - filler.to_le_bytes()[0], l0, l1].to_vec()
    };
    let varied = (0..=255).flat_map(|byte| [b'D', b'F', byte]).collect();
    let mut corrupt = good.clone();
    corrupt[12] ^= 1;
    [
        ("longest", lie(longest)),
        ("half as long", lie(longest / 2 + 7)),
        ("empty", lie(0)),
        ("dense longest", dense(longest)),
        ("dense short", dense(8)),
        ("dense empty", dense(0)),
        ("dense mixed", [dense(8).repeat(cap / 10), dense(longest).repeat(cap / 10)].concat()),
        ("dense even", even(longest - longest % 5 - 2)),
        ("good in a lie", [lie(longest), good.repeat(cap / good.len())].concat()),
        ("good, corrupt", [good, corrupt, vec![0]].concat()),
        ("DF", b"DF".to_vec()),
        ("DF even", b"DF\x16".to_vec()),
        ("DF varied", varied),
        ("D", b"D".to_vec()),
        ("D every 2nd", b"D\0".to_vec()),
        ("zeros", vec![0]),
    ]
    .map(|(name, unit)| (name, unit.iter().copied().cycle().take(len).collect()))
}

fn le(len: usize) -> [u8; 2] {
    u16::try_from(len).expect("the length fits on the wire").to_le_bytes()
}

/// Valid frame: a jog.
fn frame(data: &[u8]) -> Vec<u8> {
    let mut out = vec![0; data.len() + 12];
    let len = dmc_proto::frame::encode(MessageId(1), MessageType(0x36), data, &mut out);
    assert_eq!(len, Ok(out.len()));
    out
}
