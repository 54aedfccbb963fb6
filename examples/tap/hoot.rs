//! hoot on a bus or through a bridge.

use hoot_proto::lint::Context;
use hoot_proto::{Address, AnyQuery, AnyReply, DeviceMessage, Frame, HostMessage, Query, ReplyError};
use motion_core::stream::Framing;
use motion_core::wire::{FieldView, Fields, Messages, Visitor};

use super::{Show, read};
use crate::cli::Stop;
use crate::record::{Body, Keys, Shown, hex};
use crate::text::Side;

/// Size of the buffer for one side, in bytes: twice the longest packet.
pub(super) const BUFFER: usize = 2 * <hoot_proto::Hoot as Framing>::MAX;

/// Packets of a bus. At most one request is outstanding.
#[derive(Default)]
pub(super) struct Hoot {
    /// Request that the next reply answers: its name, and the query if it is a query.
    asked: Option<(&'static str, Option<AnyQuery>)>,
}

impl Show for Hoot {
    const NAME: &'static str = "hoot";
    type Framing = hoot_proto::Hoot;
    type Requests = hoot_proto::Requests;

    fn show(
        &mut self,
        from: Side,
        frame: &Frame<'_>,
        see: &mut dyn FnMut(Shown<'_>) -> Result<(), Stop>,
    ) -> Result<(), Stop> {
        let header = Header::of(frame);
        match from {
            Side::Host => {
                let message = HostMessage::decode(frame);
                self.asked = (frame.address() != Address::BROADCAST).then(|| (message.name(), message.query()));
                let encode = |message: &HostMessage<'_>, out: &mut [u8]| message.encode_into(frame.address(), out);
                let read = read(frame.bytes(), Ok(message), |message| message.lint(&Context::default()), encode);
                let number =
                    if message.name() == "Other" { format!(" command {}", frame.command()) } else { String::new() };
                see(Shown {
                    frame: frame.bytes(),
                    message: Some(message.name()),
                    title: format!("{}{number}", message.name()),
                    subtitle: match frame.address() {
                        Address::BROADCAST => "to all".to_owned(),
                        Address(node) => format!("to {node}"),
                    },
                    keys: header.request(),
                    header_fields: [header.request(), header.body(frame.payload())].concat(),
                    body: Body::Fields(if matches!(message, HostMessage::Other(_)) { &Nothing } else { &message }),
                    canonical: read.canonical,
                    lints: read.lints,
                    checked: false,
                })
            }
            Side::Device => {
                let message = DeviceMessage::decode(frame);
                let asked = self.asked.take();
                let read = read(
                    frame.bytes(),
                    Ok(message),
                    |message| message.lint(&Context::default()),
                    DeviceMessage::encode_into,
                );
                let mut keys = vec![("response_code", frame.command().into())];
                let mut header_fields = header.reply();
                let mut subtitle = String::new();
                let hidden = match (message, asked) {
                    (DeviceMessage::Reply(reply), Some((name, query))) => {
                        keys.push(("answers", name.into()));
                        let answer = query.map(|query| query.decode_reply(reply));
                        subtitle = match &answer {
                            Some(Ok(answer)) => format!("to {name}: {answer}"),
                            Some(Err(error)) => format!("to {name}: {error}"),
                            None => format!("to {name}"),
                        };
                        hundredths(answer, &mut header_fields)
                    }
                    _ => "",
                };
                see(Shown {
                    frame: frame.bytes(),
                    message: Some(message.name()),
                    title: message.name().to_owned(),
                    subtitle,
                    keys,
                    header_fields,
                    body: Body::Fields(&Without { fields: &message, hidden }),
                    canonical: read.canonical,
                    lints: read.lints,
                    checked: false,
                })
            }
        }
    }
}

/// Adds fields with hundredths if an answer has that unit. Returns the name of the field that they replace.
fn hundredths(answer: Option<Result<AnyReply<'_>, ReplyError>>, fields: &mut Keys) -> &'static str {
    let number = match answer {
        Some(Ok(AnyReply::Voltage(answer))) => answer.value.0,
        Some(Ok(AnyReply::Current(answer))) => answer.value.0,
        Some(Ok(AnyReply::MotorContinuousSpeed(answer))) => answer.value.0,
        Some(Ok(AnyReply::MotorContinuousAcceleration(answer))) => answer.value.0,
        _ => return "",
    };
    fields.push(("raw_i32", number.raw().into()));
    fields.push(("value_fixed_div100", number.to_f64().into()));
    "value"
}

/// Header of a packet.
struct Header {
    address: u8,
    sub_address: u8,
    command: u8,
    length: usize,
}

impl Header {
    fn of(frame: &Frame<'_>) -> Self {
        Self {
            address: frame.address().0,
            sub_address: frame.sub_address(),
            command: frame.command(),
            length: frame.payload().len(),
        }
    }

    fn request(&self) -> Keys {
        vec![
            ("address", self.address.into()),
            ("sub_address", self.sub_address.into()),
            ("command", self.command.into()),
        ]
    }

    fn body(&self, data: &[u8]) -> Keys {
        vec![("length", self.length.into()), ("data", hex(data).into())]
    }

    fn reply(&self) -> Keys {
        vec![("address", self.address.into()), ("sub_address", self.sub_address.into()), ("length", self.length.into())]
    }
}

/// Fields of a request without a type: none, because its data is shown with its header.
struct Nothing;

impl Fields for Nothing {
    fn fields(&self, _: &mut dyn Visitor) {}
}

/// Fields except one.
struct Without<'a> {
    fields: &'a dyn Fields,
    hidden: &'static str,
}

impl Fields for Without<'_> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        self.fields.fields(&mut |field: &FieldView<'_>| {
            if field.name != self.hidden {
                visitor.visit(field);
            }
        });
    }
}
