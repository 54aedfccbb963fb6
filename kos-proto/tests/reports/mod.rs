//! Model of a receiver of USB reports, and any sequence of reports for the model and the real receiver.

use kos_proto::frame::{self, Frame, FrameError, MessageId, MessageType};
use kos_proto::usb::{Dropped, Fragments, Reassembly, ReportError, decode};
use motion_core::time::Millis;

/// `StopPlayback`.
pub(crate) const STOP: [u8; 7] = [4, 0, 7, 0, 0x80, 0, 6];

/// A message in one report, with the id of the report, or without it as some libraries return it.
pub(crate) fn report(message: &[u8], numbered: bool) -> Vec<u8> {
    let mut report = [&[1], message].concat();
    assert!(report.len() <= 64, "it fits");
    report.resize(64, 0);
    if numbered { report } else { report.split_off(1) }
}

/// Message of which some pieces have come.
struct Waiting {
    bytes: Vec<u8>,
    needed: usize,
    numbered: bool,
    last: u64,
}

/// Receiver as safety decision 4 describes it.
struct Model {
    room: usize,
    waiting: Option<Waiting>,
}

/// The 63 bytes of a report, or fewer, without its id.
fn stripped(report: &[u8], numbered: bool) -> Result<Vec<u8>, ReportError> {
    if report.is_empty() || report.len() > 65 {
        return Err(ReportError::BadLength { found: report.len() });
    }
    if numbered && report[0] != 1 {
        return Err(ReportError::BadId { found: report[0] });
    }
    Ok(report.iter().skip(usize::from(numbered)).take(63).copied().collect())
}

/// Message in a report and the bytes after it, or the error.
fn single(report: &[u8]) -> Result<(Vec<u8>, Vec<u8>), ReportError> {
    let data = stripped(report, report.first() != Some(&4))?;
    let have = data.len();
    match data[..] {
        [found, ..] if found != 4 => Err(FrameError::BadVersion { found })?,
        [_, high, low, _, _, _, ..] => match usize::from(high) << 8 | usize::from(low) {
            found @ 0..6 => Err(FrameError::BadLength { found })?,
            needed if needed > have => Err(FrameError::Truncated { needed, have })?,
            needed => Ok((data[..needed].to_vec(), data[needed..].to_vec())),
        },
        _ => Err(FrameError::Truncated { needed: 6, have })?,
    }
}

impl Model {
    fn push(&mut self, now: u64, report: &[u8]) -> (Option<Dropped>, Result<Option<Vec<u8>>, ReportError>) {
        let alone = single(report).is_ok_and(|(_, behind)| behind.iter().all(|&byte| byte == 0));
        let late = |waiting: &Waiting| now >= waiting.last + 100;
        let dropped = self.waiting.take_if(|waiting| late(waiting) || alone).map(|waiting| {
            let (needed, have) = (waiting.needed, waiting.bytes.len());
            if late(&waiting) { Dropped::Late { needed, have } } else { Dropped::Interrupted { needed, have } }
        });
        (dropped, self.message(now, report))
    }

    fn message(&mut self, now: u64, report: &[u8]) -> Result<Option<Vec<u8>>, ReportError> {
        let Some(waiting) = &mut self.waiting else {
            let found = single(report);
            let Err(ReportError::Frame(FrameError::Truncated { needed, have: 63 })) = found else {
                return found.map(|(message, _)| Some(message));
            };
            let numbered = report[0] == 1;
            self.waiting = Some(Waiting { bytes: stripped(report, numbered)?, needed, numbered, last: now });
            return Ok(None);
        };
        let piece = stripped(report, waiting.numbered)?;
        waiting.last = now;
        waiting.bytes.extend(&piece);
        waiting.bytes.truncate(waiting.needed);
        if waiting.bytes.len() < waiting.needed && piece.len() == 63 {
            return Ok(None);
        }
        let Waiting { bytes, needed, .. } = self.waiting.take().expect("it is there");
        match bytes.len() {
            have if have < needed => Err(FrameError::Truncated { needed, have })?,
            total if total > self.room => Err(ReportError::TooLong { total, max: self.room }),
            _ => Ok(Some(bytes)),
        }
    }
}

/// Receiver with room for `N` bytes, and its model.
struct Both<const N: usize> {
    real: Reassembly<N>,
    model: Model,
    now: u64,
}

impl<const N: usize> Both<N> {
    fn push(&mut self, report: &[u8]) -> Result<Option<Vec<u8>>, ReportError> {
        let (dropped, wanted) = self.model.push(self.now, report);
        let received = self.real.push(Millis(self.now), report);
        assert_eq!(received.dropped, dropped, "{report:02x?}");
        let message = received.message.map(|frame| frame.map(|frame| frame.bytes().to_vec()));
        assert_eq!(message, wanted, "{report:02x?}");
        let waiting = self.model.waiting.as_ref();
        assert_eq!(self.real.held(), waiting.map_or(0, |waiting| waiting.bytes.len()));
        assert_eq!(self.real.deadline(), waiting.map(|waiting| Millis(waiting.last + 100)));
        message
    }
}

/// Sends any sequence of reports, among them long messages with lost, doubled and late pieces. The receiver does what
/// the model does. An undisturbed long message arrives, and `StopPlayback` always arrives.
///
/// The input is a list of operations: one byte for the kind, one byte for the amount, and the bytes that the operation
/// needs.
pub(crate) fn hostile<const N: usize>(input: &[u8]) {
    let model = Model { room: N, waiting: None };
    let mut both = Both::<N> { real: Reassembly::assume(), model, now: 0 };
    let mut input = input.iter().copied();
    while let (Some(what), Some(amount)) = (input.next(), input.next()) {
        both.now += u64::from(what >> 4) * 8;
        let numbered = what & 8 == 0;
        match what & 7 {
            // Any bytes.
            0 => drop(both.push(&input.by_ref().take(amount.into()).collect::<Vec<u8>>())),
            // Any bytes after an id.
            1 => drop(both.push(&[vec![1], input.by_ref().take(63).collect()].concat())),
            // A wait.
            2 => both.now += u64::from(amount),
            // A message of any length in its reports. Two bits for each report say whether it is lost, doubled or late.
            3..=5 => {
                let mishaps =
                    u64::from_le_bytes([0, 0, input.next().unwrap_or(0), input.next().unwrap_or(0), 0, 0, 0, 0]);
                let mishaps = if what & 7 == 3 { 0 } else { mishaps >> 16 };
                let payload: Vec<u8> = input.by_ref().take(amount.into()).collect();
                let mut message = vec![0; 3 * payload.len() + 6];
                let written = frame::encode(MessageId(0x12), MessageType::SET, &payload.repeat(3), &mut message);
                assert_eq!(written, Ok(message.len()));
                fragments(&mut both, &message, numbered, mishaps);
            }
            // A piece whose length field says more than comes.
            6 => drop(both.push(&report(&[&[4, 0, amount, 0, 0x12, 0, 4][..], &[amount; 56]].concat(), numbered))),
            // A stop that has to arrive, with or without the id, in buffers of any length.
            _ => {
                let mut stop = report(&STOP, numbered);
                stop.truncate(usize::from(amount).max(8));
                assert_eq!(both.push(&stop), Ok(Some(STOP.to_vec())), "StopPlayback always arrives");
            }
        }
    }
}

fn fragments<const N: usize>(both: &mut Both<N>, message: &[u8], numbered: bool, mishaps: u64) {
    let whole = Frame::decode(message).expect("a message that was just written");
    let Ok(reports) = Fragments::assume(whole) else { return };
    assert_eq!(reports.len(), message.len().div_ceil(63));
    let clear = both.model.waiting.is_none();
    let mut arrived = Vec::new();
    for (at, report) in reports.enumerate() {
        assert!(at == 0 || decode(report.as_ref()).is_err(), "a piece is not a message");
        let report = if numbered { report.as_ref() } else { &report.as_ref()[1..] };
        let times = match mishaps >> (2 * at) & 3 {
            0 => 1,
            1 => 0,
            2 => 2,
            _ => {
                both.now += 100;
                1
            }
        };
        arrived.extend((0..times).filter_map(|_| both.push(report).ok().flatten()));
    }
    if clear && mishaps == 0 {
        let wanted = if message.len() <= N.max(63) { vec![message.to_vec()] } else { vec![] };
        assert_eq!(arrived, wanted, "an undisturbed message arrives complete, if there is room");
    }
}
