//! Readers with a deadline: what a damaged length costs, and that no good frame is lost for it. Decision D-75.

use dmc_proto::frame::encode;
use dmc_proto::{DeviceReader, HostReader, Item, MessageId, MessageType, Millis, Patience};
use motion_core::stream::{Framing, TimedFrames};

/// Positions of four motors, as a device sends them while motors move.
fn positions(number: u8) -> Vec<u8> {
    let mut bytes = vec![0; 32];
    let len = encode(MessageId(0), MessageType(0x0034), &[number; 20], &mut bytes).unwrap();
    assert_eq!(len, bytes.len());
    bytes
}

/// Header of a frame with a damaged length. The frame would take so many bytes.
fn torn(len: u16) -> Vec<u8> {
    let mut bytes = b"DF\0\0\0\0\x34\0".to_vec();
    bytes.extend((len - 12).to_le_bytes());
    bytes
}

/// Gives pieces to a reader at their times. Returns the first byte of the data of each frame, with the time at which it
/// came out.
fn read<F, const N: usize>(mut reader: TimedFrames<F, N>, pieces: &[(u64, Vec<u8>)]) -> Vec<(u8, u64)>
where
    F: Framing,
{
    fn drain<F: Framing, const N: usize>(reader: &mut TimedFrames<F, N>, now: u64, found: &mut Vec<(u8, u64)>) {
        while let Some(item) = reader.next() {
            if let Item::Frame(frame) = item {
                found.push((frame.as_ref()[10], now));
            }
        }
    }

    let mut found = vec![];
    let last = pieces.last().map_or(0, |(now, _)| now + 1000);
    let mut pieces = pieces.iter().peekable();
    for now in 0..=last {
        while reader.deadline().is_some_and(|deadline| deadline <= Millis(now)) {
            reader.give_up(Millis(now));
            drain(&mut reader, now, &mut found);
        }
        while let Some((_, piece)) = pieces.next_if(|(due, _)| *due == now) {
            let mut rest = &piece[..];
            while !rest.is_empty() {
                let taken = reader.push(Millis(now), rest);
                rest = &rest[taken..];
                drain(&mut reader, now, &mut found);
            }
        }
    }
    assert_eq!((reader.held(), reader.deadline()), (0, None));
    found
}

/// D-75
#[test]
fn a_damaged_length_costs_no_more_than_the_time_of_its_frame() {
    for (len, blind) in [(2048, 0), (257, 0), (256, 23 + 100), (60, 6 + 100)] {
        let mut pieces = vec![(50, torn(len))];
        pieces.extend((0..10).map(|number| (100 * u64::from(number) + 51, positions(number))));
        let found = read(HostReader::new(Patience::default()), &pieces);
        assert_eq!(found.len(), 10, "no frame is lost");
        for (number, now) in found {
            let sent = 100 * u64::from(number) + 51;
            assert!(now == sent || now <= 50 + blind, "{len} bytes: {number} came at {now}, not at {sent}");
        }
    }
    // A device has to take longer frames.
    let mut pieces = vec![(0, torn(2048))];
    pieces.extend((0..10).map(|number| (100 * u64::from(number) + 1, positions(number))));
    let found = read(DeviceReader::new(Patience::default()), &pieces);
    assert_eq!(found.iter().map(|(_, now)| *now).max(), Some(901));
    assert!(found.iter().all(|(number, now)| *now <= (100 * u64::from(*number) + 1).max(178 + 100)), "{found:?}");
}

/// D-75
#[test]
fn a_frame_that_has_begun_when_another_is_given_up_is_completed() {
    for cut in 1..32 {
        let (head, rest) = (positions(7)[..cut].to_vec(), positions(7)[cut..].to_vec());
        // The damaged frame is due at 123, in the middle of the good one.
        let pieces = [(0, torn(256)), (122, head), (125, rest)];
        let found = read(HostReader::new(Patience::default()), &pieces);
        assert_eq!(found, [(7, 125)], "cut after {cut}");
    }
}

/// D-75
#[test]
fn a_frame_may_have_pauses_up_to_the_margin() {
    let frame = positions(7);
    for cut in 1..32 {
        for (pause, found) in [(100, vec![(7, 100)]), (104, vec![])] {
            let pieces = [(0, frame[..cut].to_vec()), (pause, frame[cut..].to_vec())];
            // Before its tenth byte, a frame announces only a header.
            let is_found = read(HostReader::new(Patience::default()), &pieces);
            assert_eq!(is_found, found, "cut after {cut}, a pause of {pause} ms");
        }
    }
    let slow = Patience::default().with_line_speed(300);
    let bytes: Vec<_> = (0..32).map(|at| (34 * u64::try_from(at).unwrap(), vec![frame[at]])).collect();
    assert_eq!(read(HostReader::new(slow), &bytes), [(7, 34 * 31)], "a byte takes 34 ms");
}
