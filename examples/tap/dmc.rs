//! DMC on a serial line.

use dmc_proto::lint::Context;
use dmc_proto::{DeviceMessage, Frame, HostMessage, MessageId, MessageType};
use motion_core::stream::Framing;
use motion_core::wire::Messages;

use super::{Read, Show, read};
use crate::cli::Stop;
use crate::record::{Body, Shown};
use crate::text::Side;

/// Twice the longest frame.
pub(super) const BUFFER: usize = 2 * <dmc_proto::Dmc as Framing>::MAX;

pub(super) struct Dmc;

impl Show for Dmc {
    const NAME: &'static str = "dmc";
    type Framing = dmc_proto::Dmc;
    type Requests = dmc_proto::Dmc;

    fn show(
        &mut self,
        from: Side,
        frame: &Frame<'_>,
        see: &mut dyn FnMut(Shown<'_>) -> Result<(), Stop>,
    ) -> Result<(), Stop> {
        let (id, context) = (frame.id(), Context::default());
        match from {
            Side::Host => {
                let message = HostMessage::decode(frame);
                let encode = |message: &HostMessage<'_>, out: &mut [u8]| message.encode_into(id, out);
                see(shown(frame, &read(frame.bytes(), message, |message| message.lint(&context), encode)))
            }
            Side::Device => {
                let message = DeviceMessage::decode(frame);
                let encode = |message: &DeviceMessage<'_>, out: &mut [u8]| message.encode_into(id, out);
                see(shown(frame, &read(frame.bytes(), message, |message| message.lint(&context), encode)))
            }
        }
    }
}

fn shown<'m, 'f: 'm, M: Messages<'f>>(frame: &Frame<'f>, read: &'m Read<M>) -> Shown<'m> {
    let known = || M::ALL.iter().find(|kind| kind.number == u32::from(frame.kind().0)).map(|kind| kind.name);
    let message = read.message.as_ref().map_or_else(|_| known(), |message| Some(message.name()));
    let subject =
        if frame.kind().is_ack() { format!(" of {}", request(frame.kind().request())) } else { String::new() };
    let unknown = if message == Some("Other") { format!(" {}", frame.kind()) } else { String::new() };
    Shown {
        frame: frame.bytes(),
        message,
        title: format!("{}{subject}{unknown}", message.unwrap_or("unknown")),
        subtitle: if frame.id() == MessageId::UNSOLICITED {
            "unsolicited".to_owned()
        } else {
            format!("id {}", frame.id())
        },
        keys: vec![("id", frame.id().0.into()), ("type", format!("0x{:04X}", frame.kind().0).into())],
        header_fields: Vec::new(),
        body: match &read.message {
            Ok(message) => Body::Fields(message),
            Err(error) => Body::Error(error.to_string(), frame.payload()),
        },
        canonical: read.canonical,
        lints: read.lints.clone(),
        checked: true,
    }
}

/// Name of a request, or its number if it has no name.
fn request(kind: MessageType) -> String {
    let known = HostMessage::ALL.iter().find(|known| known.number == u32::from(kind.0));
    known.map_or_else(|| kind.to_string(), |known| known.name.to_owned())
}
