//! Law 13: the crate agrees with a second decoder, which was written with nom from the specification alone.

mod decoder;
mod recorded;

use decoder::{DEVICE, HOST, agree, message};
use proptest::collection::vec;
use proptest::prelude::*;

#[test]
fn on_the_vectors_and_all_that_is_shorter_or_longer() {
    let mut agreed = 0;
    for vector in recorded::vectors() {
        let bytes = recorded::bytes(&vector);
        agreed += agree(&bytes).iter().flatten().count();
        let Some((head, payload)) = bytes.split_at_checked(6).filter(|(head, _)| head[0] == 4) else { continue };
        let (id, kind) = (u16::from_be_bytes([head[3], head[4]]), head[5]);
        for len in 0..payload.len() {
            agree(&message(id, kind, &payload[..len]));
        }
        let mut longer = payload.to_vec();
        for byte in 0..30 {
            longer.push(byte);
            agree(&message(id, kind, &longer));
        }
    }
    assert!(agreed > 300, "only {agreed} messages of the vectors were read by both decoders");
}

proptest! {
    #[test]
    fn on_any_body_of_any_message(
        which in any::<prop::sample::Index>(),
        body in vec(prop_oneof![3 => 0..4_u8, 1 => any::<u8>(), 1 => Just(0x7f)], 0..120),
    ) {
        let all = [HOST, DEVICE].concat();
        let (id, kind, sub, ..) = *which.get(&all);
        let payload = if id & 0x80 == 0 { body } else { [&[sub], &body[..]].concat() };
        agree(&message(id, kind, &payload));
    }

    #[test]
    fn on_lists_of_any_length(n in 0..8_u8, len in 0..220_usize, seed in any::<u8>()) {
        let filler: Vec<u8> = (0..len).map(|at| u8::try_from(at).unwrap().wrapping_mul(37) ^ seed).collect();
        agree(&message(0x0B, 2, &[&[n], &filler[..]].concat()));
        agree(&message(0x0B, 0x82, &[&[n], &filler[..]].concat()));
        agree(&message(0x81, 2, &[&[1, n], &filler[..]].concat()));
        agree(&message(0x81, 2, &[&[2, 0, 0, 0, 0, 0, n], &filler[..]].concat()));
        agree(&message(0x81, 2, &[&[2, 0, 0, 0, 0, 0, seed, 0, 0, 0, n], &filler[..]].concat()));
    }

    #[test]
    fn on_blocks(blocks in vec((0..8_u8, 0..60_usize), 0..6), claimed in 0..7_u8, tail in vec(any::<u8>(), 0..4)) {
        let mut payload = vec![claimed];
        for (id, len) in blocks {
            payload.extend([id, 0, u8::try_from(len).unwrap()]);
            payload.extend((0..u8::try_from(len).unwrap()).map(|at| at.wrapping_mul(11)));
        }
        payload.extend(tail);
        agree(&message(0x12, 0, &payload));
        agree(&message(0x12, 2, &payload));
    }

    #[test]
    fn on_anything(id in 0..0x90_u16, kind in prop_oneof![0..4_u8, any::<u8>()], body in vec(any::<u8>(), 0..60), raw in vec(0..7_u8, 0..20)) {
        agree(&message(id, kind, &body));
        agree(&raw);
    }
}
