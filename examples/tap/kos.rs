//! kOS over TCP, in datagrams, and in USB reports.

use kos_proto::lint::Context;
use kos_proto::usb::{self, Reassembly, Received, ReportError};
use kos_proto::{DeviceMessage, Frame, FrameError, HostMessage, MessageId, MessageType};
use motion_core::time::Millis;
use motion_core::wire::{Fields, Messages};

use super::{Place, Read, Show, Whole, read};
use crate::cli::Stop;
use crate::record::{Body, Keys, Kind, Shown};
use crate::text::Side;

/// Longest message, in bytes. A listener accepts messages of any length that a header can have.
const LONGEST: usize = 65_535;
/// Size of the buffer for one side, in bytes: twice the longest message.
pub(super) const BUFFER: usize = 2 * LONGEST;

type Framed = kos_proto::Kos<LONGEST>;
type See<'s> = dyn FnMut(Shown<'_>) -> Result<(), Stop> + 's;

/// Messages in a stream, or one in each datagram.
pub(super) struct Kos;

impl Show for Kos {
    const NAME: &'static str = "kos";
    type Framing = Framed;
    type Requests = Framed;

    fn show(&mut self, from: Side, frame: &Frame<'_>, see: &mut See<'_>) -> Result<(), Stop> {
        let context = Context::default();
        match from {
            Side::Host => {
                let read = read(
                    frame.bytes(),
                    HostMessage::decode(frame),
                    |message| message.lint(&context),
                    HostMessage::encode_into,
                );
                let name = read.message.as_ref().ok().map(HostMessage::specification_name);
                see(shown(frame, &read, name))
            }
            Side::Device => {
                let read = read(
                    frame.bytes(),
                    DeviceMessage::decode(frame),
                    |message| message.lint(&context),
                    DeviceMessage::encode_into,
                );
                let name = read.message.as_ref().ok().map(DeviceMessage::specification_name);
                see(shown(frame, &read, name))
            }
        }
    }
}

fn shown<'m, 'f: 'm, M: Messages<'f>>(frame: &Frame<'f>, read: &'m Read<M>, name: Option<&'m str>) -> Shown<'m> {
    let own = read.message.as_ref().map_or_else(|_| known::<M>(frame), |message| Some(message.name()));
    let subtitle = match own {
        None | Some("Other") => format!("id {}, type {}", frame.id(), frame.kind()),
        _ if frame.kind() == MessageType::RESPONSE_MORE => "more messages follow".to_owned(),
        _ => String::new(),
    };
    Shown {
        frame: frame.bytes(),
        title: own.or(name).unwrap_or("unknown").to_owned(),
        subtitle,
        message: name.or_else(|| known::<M>(frame)),
        keys: vec![("message_id", frame.id().0.into()), ("message_type", frame.kind().0.into())],
        header_fields: sub(frame),
        body: match &read.message {
            Ok(message) => Body::Fields(message as &dyn Fields),
            Err(error) => Body::Error(error.to_string(), frame.payload()),
        },
        canonical: read.canonical,
        lints: read.lints.clone(),
        checked: false,
    }
}

/// Number of an action or a notification.
fn sub(frame: &Frame<'_>) -> Keys {
    let name = match (frame.id(), frame.kind()) {
        (MessageId::ACTION, MessageType::SET) => "action_id",
        (MessageId::NOTIFICATION, MessageType::RESPONSE) => "note_id",
        _ => return Keys::new(),
    };
    frame.payload().first().map(|&number| (name, number.into())).into_iter().collect()
}

/// Name of a message that could not be decoded.
fn known<'f, M: Messages<'f>>(frame: &Frame<'_>) -> Option<&'static str> {
    let numbered = !sub(frame).is_empty();
    let sub = frame.payload().first().copied().filter(|_| numbered).unwrap_or_default();
    let [id0, id1] = frame.id().0.to_be_bytes();
    let number = u32::from_be_bytes([id0, id1, frame.kind().0, sub]);
    M::ALL.iter().find(|kind| kind.number == number).map(|kind| kind.name)
}

impl Whole for Kos {
    const RECORD: usize = LONGEST;

    fn is_whole(record: &[u8]) -> bool {
        Frame::decode(record).is_ok()
    }

    fn record(&mut self, place: &mut Place, record: &[u8], see: &mut super::See<'_>) -> Result<(), Stop> {
        match Frame::decode(record) {
            Ok(frame) => place.frame(self, &frame, see),
            Err(error) => place.other(Self::NAME, kind(error), error.to_string(), record, see),
        }
    }
}

const fn kind(error: FrameError) -> Kind {
    match error {
        FrameError::Truncated { .. } => Kind::Incomplete,
        _ => Kind::Corrupt,
    }
}

/// Messages in USB reports, one in each report.
///
/// A longer message is shown as incomplete, because it is only an assumption how such a message continues.
pub(super) struct Reports;

impl Show for Reports {
    const NAME: &'static str = Kos::NAME;
    type Framing = Framed;
    type Requests = Framed;

    fn show(&mut self, from: Side, frame: &Frame<'_>, see: &mut See<'_>) -> Result<(), Stop> {
        Kos.show(from, frame, see)
    }
}

impl Whole for Reports {
    const RECORD: usize = usb::REPORT_LEN;

    fn is_whole(record: &[u8]) -> bool {
        usb::decode(record).is_ok()
    }

    fn record(&mut self, place: &mut Place, record: &[u8], see: &mut super::See<'_>) -> Result<(), Stop> {
        match usb::decode(record) {
            Ok(frame) => place.frame(&mut Kos, &frame, see),
            Err(error) => place.other(Self::NAME, kind_of_report(error), error.to_string(), record, see),
        }
    }
}

const fn kind_of_report(error: ReportError) -> Kind {
    match error {
        ReportError::Frame(error) => kind(error),
        _ => Kind::Corrupt,
    }
}

/// Messages in USB reports, on the assumption that a longer message continues in the next report.
///
/// A device gives up a message after a pause. An input has no times, so pauses are not seen here.
#[derive(Default)]
pub(super) struct Fragments {
    host: Fragmented,
    device: Fragmented,
}

/// Message of one side that is not complete.
#[derive(Default)]
struct Fragmented {
    message: Box<Reassembly<LONGEST>>,
    /// Offset of the first report of the message, and the bytes of all its reports.
    reports: Option<(u64, Vec<u8>)>,
}

impl Fragments {
    fn of(&mut self, side: Side) -> &mut Fragmented {
        match side {
            Side::Host => &mut self.host,
            Side::Device => &mut self.device,
        }
    }
}

impl Fragmented {
    /// Reports why the reports so far are not a message, at the offset of the first.
    fn give_up(&mut self, place: &mut Place, kind: Kind, why: String, see: &mut super::See<'_>) -> Result<(), Stop> {
        let Some((offset, reports)) = self.reports.take() else { return Ok(()) };
        let here = std::mem::replace(&mut place.offset, offset);
        place.other(Kos::NAME, kind, why, &reports, see)?;
        place.offset = here;
        Ok(())
    }
}

impl Show for Fragments {
    const NAME: &'static str = Kos::NAME;
    type Framing = Framed;
    type Requests = Framed;

    fn show(&mut self, from: Side, frame: &Frame<'_>, see: &mut See<'_>) -> Result<(), Stop> {
        Kos.show(from, frame, see)
    }
}

impl Whole for Fragments {
    const RECORD: usize = usb::REPORT_LEN;

    fn is_whole(record: &[u8]) -> bool {
        usb::decode(record).is_ok()
    }

    fn record(&mut self, place: &mut Place, record: &[u8], see: &mut super::See<'_>) -> Result<(), Stop> {
        let side = self.of(place.from);
        let Received { dropped, message } = side.message.push(Millis(0), record);
        // The message is copied, because the dropped one before it must be reported first.
        let message = message.map(|message| message.map(|message| message.bytes().to_vec()));
        if let Some(dropped) = dropped {
            side.give_up(place, Kind::Incomplete, dropped.to_string(), see)?;
        }
        match message {
            Ok(None) => {
                side.reports.get_or_insert_with(|| (place.offset, Vec::new())).1.extend(record);
                Ok(())
            }
            Ok(Some(bytes)) => {
                if let Some((offset, _)) = side.reports.take() {
                    place.offset = offset;
                }
                Kos.record(place, &bytes, see)
            }
            // The record is not a report. The message may still continue after it.
            Err(error) if side.message.held() > 0 => {
                place.other(Self::NAME, kind_of_report(error), error.to_string(), record, see)
            }
            Err(error) => {
                side.reports.get_or_insert_with(|| (place.offset, Vec::new())).1.extend(record);
                side.give_up(place, kind_of_report(error), error.to_string(), see)
            }
        }
    }

    fn end(&mut self, place: &mut Place, see: &mut super::See<'_>) -> Result<(), Stop> {
        let why = "the input ends inside a message".to_owned();
        self.of(place.from).give_up(place, Kind::Incomplete, why, see)
    }
}
