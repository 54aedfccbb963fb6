//! kOS over TCP, in datagrams, and in USB reports.

use kos_proto::lint::Context;
use kos_proto::usb::{self, ReportError};
use kos_proto::{DeviceMessage, Frame, FrameError, HostMessage, MessageId, MessageType};
use motion_core::wire::{Fields, Messages};

use super::{Read, Show, Whole, read};
use crate::cli::Stop;
use crate::record::{Body, Keys, Kind, Shown};
use crate::text::Side;

/// Whoever only listens takes messages of any length that a header can say.
const LONGEST: usize = 65_535;
/// Twice the longest message.
pub(super) const BUFFER: usize = 2 * LONGEST;

type Framed = kos_proto::Kos<LONGEST>;
type See<'s> = dyn FnMut(Shown<'_>) -> Result<(), Stop> + 's;

/// Messages, in a stream or one a datagram.
pub(super) struct Kos;

impl Show for Kos {
    const NAME: &'static str = "kos";
    type Framing = Framed;

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
        _ if frame.kind() == MessageType::RESPONSE_MORE => "more follow".to_owned(),
        _ => String::new(),
    };
    Shown {
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

/// The number of an action or a notification.
fn sub(frame: &Frame<'_>) -> Keys {
    let name = match (frame.id(), frame.kind()) {
        (MessageId::ACTION, MessageType::SET) => "action_id",
        (MessageId::NOTIFICATION, MessageType::RESPONSE) => "note_id",
        _ => return Keys::new(),
    };
    frame.payload().first().map(|&number| (name, number.into())).into_iter().collect()
}

/// The name of a message that could not be decoded.
fn known<'f, M: Messages<'f>>(frame: &Frame<'_>) -> Option<&'static str> {
    let numbered = !sub(frame).is_empty();
    let sub = frame.payload().first().copied().filter(|_| numbered).unwrap_or_default();
    let [id0, id1] = frame.id().0.to_be_bytes();
    let number = u32::from_be_bytes([id0, id1, frame.kind().0, sub]);
    M::ALL.iter().find(|kind| kind.number == number).map(|kind| kind.name)
}

impl Whole for Kos {
    const RECORD: usize = LONGEST;

    fn whole<'a>(&self, record: &'a [u8]) -> Result<Frame<'a>, (Kind, String)> {
        Frame::decode(record).map_err(|error| (kind(error), error.to_string()))
    }
}

const fn kind(error: FrameError) -> Kind {
    match error {
        FrameError::Truncated { .. } => Kind::Incomplete,
        _ => Kind::Corrupt,
    }
}

/// Messages in USB reports, one each: a longer message is shown as incomplete, for how it goes on is an assumption.
pub(super) struct Reports;

impl Show for Reports {
    const NAME: &'static str = Kos::NAME;
    type Framing = Framed;

    fn show(&mut self, from: Side, frame: &Frame<'_>, see: &mut See<'_>) -> Result<(), Stop> {
        Kos.show(from, frame, see)
    }
}

impl Whole for Reports {
    const RECORD: usize = usb::REPORT_LEN;

    fn whole<'a>(&self, record: &'a [u8]) -> Result<Frame<'a>, (Kind, String)> {
        usb::decode(record).map_err(|error| match error {
            ReportError::Frame(error) => (kind(error), error.to_string()),
            error => (Kind::Corrupt, error.to_string()),
        })
    }
}
