//! Framings: how a master, a listener and a node find packets among other bytes.

use motion_core::stream::{self, Framing, Head, Noise};
use zerocopy::FromBytes;

use super::{BREAK, Frame, HEADER_LEN, Header, MAX_DATA, MAX_FRAME};

/// Framing of a master or a listener, which finds the next break after any bytes.
///
/// Packets hold up to `CAP` bytes of data. A packet that claims more is noise, and the search goes on after its break.
/// If there are more than five zeros before the FF, the last five count. Source: hoot, sections 1 and 5.
///
/// A break that is sent twice begins like the reply of a node that refused: address, part, code and length are 0. A master
/// needs such a reply at once, so the packet after the second break is lost. [`Requests`] finds it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hoot<const CAP: usize = MAX_DATA> {}

impl<const CAP: usize> Framing for Hoot<CAP> {
    const MAX: usize = HEADER_LEN.saturating_add(CAP);
    type Header = Header;
    type Frame<'a> = Frame<'a>;
    type Memo<const N: usize> = ();

    #[inline]
    fn head(bytes: &[u8]) -> Head {
        match Header::ref_from_prefix(bytes) {
            Ok((header, _)) if header.has_break() => match header.frame_len() {
                total if total <= Self::MAX => Head::Total(total),
                total => Head::Skip(BREAK.len(), Noise::TooLong { total, max: Self::MAX }),
            },
            Err(_) if bytes.iter().zip(&BREAK).all(|(byte, of_break)| byte == of_break) => Head::More(HEADER_LEN),
            _ => Head::Skip(to_break(bytes), Noise::NoMarker),
        }
    }

    fn header(bytes: &[u8]) -> Option<Header> {
        Header::read_from_prefix(bytes).ok().map(|(header, _)| header)
    }

    #[inline]
    fn frame(bytes: &[u8]) -> Option<Frame<'_>> {
        Frame::decode(bytes).ok()
    }
}

/// Framing of a listener that reads what a master sends. It is [`Hoot`] with one more rule.
///
/// No request goes to the address of the master. So a header of zeros is a break that was sent twice, and the packet
/// begins at the second one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Requests<const CAP: usize = MAX_DATA> {}

impl<const CAP: usize> Framing for Requests<CAP> {
    const MAX: usize = Hoot::<CAP>::MAX;
    type Header = Header;
    type Frame<'a> = Frame<'a>;
    type Memo<const N: usize> = ();

    #[inline]
    fn head(bytes: &[u8]) -> Head {
        match Hoot::<CAP>::head(bytes) {
            Head::Total(HEADER_LEN) if bytes.get(BREAK.len()..HEADER_LEN) == Some(&[0; 4]) => {
                Head::Skip(BREAK.len(), Noise::NoMarker)
            }
            head => head,
        }
    }

    fn header(bytes: &[u8]) -> Option<Header> {
        Hoot::<CAP>::header(bytes)
    }

    #[inline]
    fn frame(bytes: &[u8]) -> Option<Frame<'_>> {
        Hoot::<CAP>::frame(bytes)
    }
}

/// Number of bytes before the next break, or before the zeros at the end that may become one.
#[cold]
fn to_break(bytes: &[u8]) -> usize {
    let zeros = BREAK.len().saturating_sub(1);
    bytes.windows(BREAK.len()).position(|window| window == BREAK).unwrap_or_else(|| {
        let trailing = bytes.iter().rev().take(zeros).take_while(|&&byte| byte == 0).count();
        bytes.len().saturating_sub(trailing)
    })
}

/// Framing of the firmware of a node, which reads ten bytes and the data, and checks the break only then.
///
/// After a wrong break, all bytes that were read are lost; firmware does not search for the next break. The caller does
/// two more things that firmware does: after more than 100 ms of silence inside a packet it drops the beginning of the
/// packet ([`Frames::gap`](stream::Frames::gap)), and after each packet, good or bad, it drops all other bytes that
/// have arrived ([`Frames::reset`](stream::Frames::reset)). So a master sends one request, and waits.
///
/// If a packet claims more than `CAP` bytes of data, as many bytes as it claims are lost. Source: hoot, sections 1.1
/// and 4.1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Strict<const CAP: usize = MAX_DATA> {}

impl<const CAP: usize> Framing for Strict<CAP> {
    const MAX: usize = HEADER_LEN.saturating_add(CAP);
    type Header = Header;
    type Frame<'a> = Frame<'a>;
    type Memo<const N: usize> = ();

    #[inline]
    fn head(bytes: &[u8]) -> Head {
        let Ok((header, _)) = Header::ref_from_prefix(bytes) else { return Head::More(HEADER_LEN) };
        let total = header.frame_len();
        if !header.has_break() {
            Head::Skip(total, Noise::NoMarker)
        } else if total > Self::MAX {
            Head::Skip(total, Noise::TooLong { total, max: Self::MAX })
        } else {
            Head::Total(total)
        }
    }

    fn header(bytes: &[u8]) -> Option<Header> {
        Header::read_from_prefix(bytes).ok().map(|(header, _)| header)
    }

    #[inline]
    fn frame(bytes: &[u8]) -> Option<Frame<'_>> {
        Frame::decode(bytes).ok()
    }

    /// After a silence, all bytes of an incomplete packet are dropped.
    fn give_up(bytes: &[u8]) -> usize {
        bytes.len()
    }
}

/// Stream of packets as a master reads them, in a buffer of `N` bytes, at least twice [`MAX_FRAME`].
///
/// For a node there are [`NodeFrames`]. For other limits, name the framing: `motion_core::stream::Frames<Hoot<255>, 530>`.
pub type Frames<const N: usize = { 2 * MAX_FRAME }> = stream::Frames<Hoot, N>;

/// Stream of packets as a node reads them, in a buffer of 84 bytes.
pub type NodeFrames = stream::Frames<Strict, { 2 * MAX_FRAME }>;

/// Time that a packet gets in a session: that of its bytes on a slow line, and the time after which firmware drops a packet
/// that is cut off.
pub(crate) const PATIENCE: stream::Patience = stream::Patience::new().with_line_speed(9600).with_margin(101);

#[cfg(test)]
mod tests {
    use super::*;
    use motion_core::stream::Item;
    use std::vec::Vec;

    const START: [u8; 10] = [0, 0, 0, 0, 0, 0xFF, 3, 0, 2, 0];

    /// Items that the framing finds in `bytes` before a silence: lengths of frames, and negative lengths of noise.
    fn items<F: Framing>(bytes: &[u8]) -> Vec<i64> {
        let mut frames = stream::Frames::<F, 600>::new();
        assert_eq!(frames.push(bytes), bytes.len());
        frames.gap();
        let mut found = Vec::new();
        while let Some(item) = frames.next() {
            let len = i64::try_from(item.bytes().len()).unwrap();
            found.push(if matches!(item, Item::Frame(_)) { len } else { -len });
        }
        found
    }

    #[test]
    fn a_master_finds_the_last_five_zeros_and_a_node_does_not() {
        for junk in [&[0][..], &[0; 9], &[7], &[0, 0, 0, 0, 0xFF], &[0xFF; 6]] {
            let stream = [junk, &START, &START].concat();
            let len = i64::try_from(junk.len()).unwrap();
            assert_eq!(items::<Hoot>(&stream), [-len, 10, 10], "{junk:?}");
        }
        // With one more zero, the length byte is the 2 of the command, so twelve bytes are lost, and the next packet
        // too.
        assert_eq!(items::<Strict>(&[&[0][..], &START, &START].concat()), [-21]);
        assert_eq!(items::<Strict>(&[START, START].concat()), [10, 10]);
    }

    #[test]
    fn a_claim_of_more_than_32_bytes_is_noise() {
        let mut stream = START.to_vec();
        stream[9] = 33;
        stream.extend(START);
        assert_eq!(items::<Hoot>(&stream), [-10, 10], "the search goes on behind the break");
        assert_eq!(items::<Strict>(&stream), [-20], "the node reads as many bytes as are claimed");
        stream.resize(43, 0);
        assert_eq!(items::<Hoot<33>>(&stream), [43]);
    }

    #[test]
    fn a_break_that_is_sent_twice_costs_a_listener_nothing_in_any_pieces() {
        for breaks in 1..4 {
            let mut stream = START.to_vec();
            stream.extend(BREAK.repeat(breaks));
            stream.extend(START);
            stream.extend(START);
            for first in 0..=stream.len() {
                for second in first..=stream.len() {
                    let mut frames = stream::Frames::<Requests, 84>::new();
                    let (mut found, mut noise) = (0, 0);
                    for piece in [&stream[..first], &stream[first..second], &stream[second..]] {
                        assert_eq!(frames.push(piece), piece.len());
                        while let Some(item) = frames.next() {
                            match item {
                                Item::Frame(frame) => {
                                    assert_eq!(frame.bytes(), START);
                                    found += 1;
                                }
                                item => noise += item.bytes().len(),
                            }
                        }
                    }
                    assert_eq!((found, noise), (3, 6 * breaks), "{breaks} breaks, cut at {first} and {second}");
                }
            }
        }
    }

    /// For a master it is the reply of a node that refused, which is told at once.
    #[test]
    fn a_reply_of_zeros_is_a_packet_for_a_master_before_any_byte_follows() {
        let refused = [&BREAK[..], &[0; 4]].concat();
        assert_eq!(items::<Hoot>(&refused), [10]);
        assert_eq!(items::<Hoot>(&[&refused[..], &refused, &START].concat()), [10, 10, 10]);
        assert_eq!(items::<Hoot>(&[&BREAK[..], &START, &START].concat()), [10, -6, 10]);
        assert_eq!(items::<Requests>(&refused), [-10]);
    }

    #[test]
    fn a_partial_break_is_kept() {
        for len in 1..10 {
            assert_eq!(Hoot::<32>::head(&START[..len]), Head::More(10));
        }
        assert_eq!(Hoot::<32>::head(&[0; 20]), Head::Skip(15, Noise::NoMarker));
        assert_eq!(Hoot::<32>::head(&[1, 0, 0]), Head::Skip(1, Noise::NoMarker));
        assert_eq!(Hoot::<32>::head(&[1, 0, 0, 2]), Head::Skip(4, Noise::NoMarker));
    }

    #[test]
    fn a_node_with_its_habits_loses_the_second_of_two_requests() {
        let mut frames = stream::Frames::<Strict, 84>::new();
        assert_eq!(frames.push(&[START, START].concat()), 20);
        assert!(matches!(frames.next(), Some(Item::Frame(_))));
        frames.reset();
        assert!(frames.next().is_none());
    }
}
