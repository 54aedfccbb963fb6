//! The tokio codec finds the same items as `Frames`, and a `Framed` sends and receives messages.

#[allow(dead_code, reason = "the framings of the stream tests, without their rescans")]
#[path = "stream/framings.rs"]
mod framings;

use std::fmt::Debug;

use bytes::BytesMut;
use framings::{Dmc, Hoot, Kos, dmc_frame, hoot_frame, kos_frame};
use futures_util::{SinkExt, StreamExt};
use laws::stream::{Drain, Feed, Owned, read};
use motion_core::codec::{self, Item, Outgoing};
use motion_core::stream::{Fatal, Framing, Noise};
use motion_core::wire::{DecodeError, EncodeError, Messages, Rest, Side};
use motion_core::zerocopy::LE;
use motion_core::{message, messages, wire};
use proptest::collection::vec;
use proptest::prelude::*;
use tokio_util::codec::{Decoder, Encoder, Framed};

message! {
    /// A whole frame.
    pub struct Whole<'a> in LE {
        ;
        /// All bytes of the frame.
        bytes: Rest<'a>,
    }
}

messages! {
    /// The message whose body is its whole frame.
    pub enum Any<'a> {
        /// A whole frame.
        1 => Whole(Whole<'a>),
    }
}

impl<'a> Any<'a> {
    fn of(bytes: &'a [u8]) -> Self {
        Self::Whole(Whole { bytes: Rest(bytes), tail: &[] })
    }
}

/// Makes sides of framings. A frame without data cannot be decoded, and its message cannot be encoded.
macro_rules! sides {
    ($($side:ty, $empty:literal;)*) => {$(
        impl Side for $side {
            type Message<'a> = Any<'a>;
            type Order = LE;
        }

        impl wire::Framed for $side {
            type Framing = Self;
            type Label = usize;

            fn decode<'a>(frame: &<$side as Framing>::Frame<'a>) -> Result<Any<'a>, DecodeError> {
                Self::open(frame).and_then(|(number, body)| Any::decode_body(number, body))
            }
            fn label(frame: &&[u8]) -> usize {
                frame.len()
            }
            fn open<'a>(frame: &<$side as Framing>::Frame<'a>) -> Result<(u32, &'a [u8]), DecodeError> {
                let short = DecodeError::Truncated { what: "frame", needed: $empty + 1, have: frame.len() };
                if frame.len() > $empty { Ok((1, frame)) } else { Err(short) }
            }
            fn encoded_len(message: &Any<'_>) -> usize {
                message.body_len()
            }
            fn encode_into(message: &Any<'_>, _: usize, out: &mut [u8]) -> Result<usize, EncodeError> {
                message.encode_body(out)
            }
        }

        impl Outgoing<$side> for Any<'_> {
            fn put(&self, dst: &mut BytesMut) -> Result<usize, EncodeError> {
                if self.body_len() <= $empty {
                    return Err(EncodeError::Hole { what: "data" });
                }
                motion_core::buf::put(dst, self.body_len(), |out| self.encode_body(out))
            }
        }
    )*};
}

sides! {
    Dmc<40>, 12;
    Kos<40>, 6;
    Hoot, 10;
}

/// Side and its framing.
trait OneSide: wire::Framed<Framing = Self, Label = usize> + Framing {}
impl<F: wire::Framed<Framing = Self, Label = usize> + Framing> OneSide for F {}

/// Codec whose two sides are the same.
type Codec<F, const N: usize> = codec::Codec<F, F, F, N>;

/// Reads a stream in pieces through the codec; neighbouring noise is one item.
fn decode<F: OneSide, const N: usize>(stream: &[u8], cuts: &[usize]) -> Vec<Owned<F::Header>> {
    let mut codec = Codec::<F, N>::new();
    let mut items = Vec::new();
    let mut src = BytesMut::new();
    let mut keep = |codec: &mut Codec<F, N>, item| match (item, items.last_mut()) {
        (Item::Message { label, message, frame }, _) => {
            assert_eq!((label, message.number(), message.body()), (frame.len(), 1, &frame[..]));
            items.push(Owned::Frame(frame.to_vec()));
        }
        (Item::Undecodable { label, why, frame }, _) => {
            assert!(matches!(why, DecodeError::Truncated { have, .. } if have == label));
            items.push(Owned::Frame(frame.to_vec()));
        }
        (Item::Corrupt { header, why, bytes }, _) => {
            items.push(Owned::Corrupt { header, why, bytes: bytes.to_vec() });
        }
        (Item::Noise { bytes, .. }, Some(Owned::Noise { bytes: before, .. })) => before.extend(bytes),
        (Item::Noise { bytes, why }, _) => items.push(Owned::Noise { bytes: bytes.to_vec(), why }),
        (Item::Fatal(why), _) => {
            items.push(Owned::Fatal(why));
            codec.resync();
        }
    };
    let mut rest = stream;
    for cut in cuts.iter().cycle() {
        let (piece, later) = rest.split_at(rest.len().min(*cut));
        rest = later;
        src.extend_from_slice(piece);
        while let Some(item) = codec.decode(&mut src).unwrap() {
            keep(&mut codec, item);
        }
        if rest.is_empty() {
            break;
        }
    }
    while let Some(item) = codec.decode_eof(&mut src).unwrap() {
        keep(&mut codec, item);
    }
    assert!(src.is_empty(), "every byte is part of an item");
    items
}

/// Whole and damaged frames, and noise that looks like a frame.
fn streams(marker: &'static [u8], frame: fn(&[u8]) -> Vec<u8>) -> impl Strategy<Value = Vec<u8>> {
    let data = || vec(prop_oneof![any::<u8>(), prop::sample::select(marker)], 0..20);
    let part = prop_oneof![
        3 => data().prop_map(move |data| frame(&data)),
        1 => data(),
        2 => (data(), any::<prop::sample::Index>(), 1..=255_u8).prop_map(move |(data, at, by)| {
            let mut bytes = frame(&data);
            let at = at.index(bytes.len());
            bytes[at] ^= by;
            bytes
        }),
    ];
    vec(part, 0..20).prop_map(|parts| parts.concat())
}

fn assert_same<F: OneSide, const N: usize>(stream: &[u8], cuts: &[usize]) {
    let expected = read::<F, N>(stream, &[], Drain::AtGap, Feed::Push, || usize::MAX).items;
    assert_eq!(decode::<F, N>(stream, cuts), expected);
}

proptest! {
    #[test]
    fn the_codec_finds_the_same_items_as_frames(
        dmc in streams(b"DF", |data| dmc_frame(7, 1, data)),
        kos in streams(&[4, 0, 6], |data| kos_frame(2, data)),
        hoot in streams(&[0, 0xff], |data| hoot_frame([1, 2, 3], data)),
        cuts in vec(1..60_usize, 1..9),
    ) {
        assert_same::<Dmc<40>, 80>(&dmc, &cuts);
        assert_same::<Kos<40>, 80>(&kos, &cuts);
        assert_same::<Hoot, 84>(&hoot, &cuts);
    }
}

#[test]
fn frames_are_split_off_the_buffer_and_not_copied() {
    let mut codec = Codec::<Kos<40>, 80>::new();
    let mut src = BytesMut::from(&kos_frame(1, b"abc")[..]);
    let place = src.as_ptr();
    let Some(Item::Message { message, frame, .. }) = codec.decode(&mut src).unwrap() else { panic!("a frame") };
    assert_eq!((frame.as_ptr(), message.body().as_ptr()), (place, place));
}

#[test]
fn a_fatal_error_that_the_caller_ignores_ends_the_stream() {
    let fatal = Fatal::BadVersion { found: 9, expected: 4 };
    let mut codec = Codec::<Kos<40>, 80>::new();
    let mut src = BytesMut::from(&[9, 9, 9][..]);
    assert_eq!(codec.decode(&mut src).unwrap(), Some(Item::Fatal(fatal)));
    for _ in 0..2 {
        let error = codec.decode(&mut src).unwrap_err();
        assert_eq!((error.kind(), error.to_string()), (std::io::ErrorKind::InvalidData, fatal.to_string()));
    }
    codec.resync();
    src.extend_from_slice(&kos_frame(1, b"a"));
    assert!(matches!(codec.decode(&mut src).unwrap(), Some(Item::Noise { why: Noise::Resync, .. })));
    assert!(matches!(codec.decode(&mut src).unwrap(), Some(Item::Message { .. })));

    // A new connection has a new buffer, and the same codec after a reset.
    let mut src = BytesMut::from(&[9][..]);
    assert_eq!(codec.decode(&mut src).unwrap(), Some(Item::Fatal(fatal)));
    codec.reset();
    let mut src = BytesMut::from(&kos_frame(1, b"a")[..]);
    assert!(matches!(codec.decode(&mut src).unwrap(), Some(Item::Message { .. })));
}

#[test]
fn bytes_after_a_gap_do_not_complete_a_frame_before_it() {
    let frame = dmc_frame(1, 2, b"data");
    let mut codec = Codec::<Dmc<40>, 80>::new();
    let mut src = BytesMut::from(&frame[..9]);
    assert_eq!(codec.decode(&mut src).unwrap(), None);
    codec.gap();
    src.extend_from_slice(&frame[9..]);
    let Some(Item::Noise { bytes, why: Noise::CutOff }) = codec.decode(&mut src).unwrap() else { panic!("cut off") };
    assert_eq!(bytes, frame[..9]);
}

#[test]
fn nothing_is_sent_of_a_message_that_cannot_be_encoded() {
    let frame = dmc_frame(1, 2, b"data");
    let mut codec = Codec::<Dmc<40>, 80>::new();
    let mut dst = BytesMut::new();
    codec.encode(Any::of(&frame), &mut dst).unwrap();
    let error = codec.encode(Any::of(b""), &mut dst).unwrap_err();
    assert_eq!(error.kind(), std::io::ErrorKind::InvalidInput);
    assert_eq!(error.to_string(), EncodeError::Hole { what: "data" }.to_string());
    assert_eq!(dst, frame);
}

fn run<T: Debug>(future: impl Future<Output = T>) -> T {
    tokio::runtime::Builder::new_current_thread().build().unwrap().block_on(future)
}

#[test]
fn a_framed_sends_and_receives_messages() {
    let frames = [dmc_frame(1, 2, b"one"), dmc_frame(2, 3, b"2"), dmc_frame(3, 4, &[b'D'; 20])];
    let (here, there) = tokio::io::duplex(5);
    run(async {
        let mut sender = Framed::new(here, Codec::<Dmc<40>, 80>::new());
        let mut receiver = Framed::new(there, Codec::<Dmc<40>, 80>::new());
        let send = async {
            for frame in &frames {
                sender.send(Any::of(frame)).await.unwrap();
            }
            // A frame that is cut off when the connection ends.
            let last = frames[0][..8].to_vec();
            tokio::io::AsyncWriteExt::write_all(sender.get_mut(), &last).await.unwrap();
            drop(sender);
        };
        let receive = async {
            let mut items = Vec::new();
            while let Some(item) = receiver.next().await {
                items.push(item.unwrap());
            }
            items
        };
        let ((), items) = futures_util::future::join(send, receive).await;
        assert!(items[..3].iter().all(|item| matches!(item, Item::Message { .. })));
        assert_eq!(items.iter().take(3).map(Item::bytes).collect::<Vec<_>>(), frames);
        assert!(matches!(&items[3..], [Item::Noise { bytes, why: Noise::CutOff }] if *bytes == frames[0][..8]));
    });
}
