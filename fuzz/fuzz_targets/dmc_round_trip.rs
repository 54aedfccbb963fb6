//! DMC: any data of any type, decoded, encoded as a whole frame and read again, gives the same data, for both senders.
//!
//! Input: id (`u32`) and type (`u16`) of the message, little-endian, then its data. The data also draws a message of each
//! side.

#![no_main]

use dmc_proto::frame::{self, Frame, MessageId, MessageType};
use dmc_proto::lint::Context;
use dmc_proto::message::Hi;
use dmc_proto::{DecodeError, Device, DeviceMessage, EncodeError, Host, HostMessage};
use fuzz::drawn;
use libfuzzer_sys::fuzz_target;
use motion_core::wire::Message;

macro_rules! there_and_back {
    ($side:ident, $id:ident, $kind:ident, $data:ident, $contexts:expr) => {{
        let mut wire = vec![0; $data.len() + frame::OVERHEAD];
        let written = frame::encode($id, $kind, $data, &mut wire);
        let given = Frame::decode(&wire).expect("a frame that was just encoded");
        assert_eq!(written, Ok(wire.len()));
        match $side::decode(&given) {
            Ok(message) => {
                let mut again = vec![0; message.encoded_len() + 3];
                let len = message.encode_into($id, &mut again).expect("a decoded message can be encoded");
                assert_eq!((&again[..len], &again[len..]), (&wire[..], &[0; 3][..]));
                for context in $contexts {
                    let checked = message.encode_checked($id, context, &mut again);
                    let refused = message.lint(context).first_error().map(EncodeError::Refused);
                    // The id 0 is allowed only for some senders.
                    assert!(checked == Ok(len) || checked.err() == refused || $id == MessageId::UNSOLICITED);
                }
                assert!(message.to_string().len() < 8192);
            }
            Err(DecodeError::Truncated { needed, have, .. }) => assert!(have == $data.len() && needed > have),
            Err(error) => panic!("{error}"),
        }
    }};
}

fuzz_target!(|input: &[u8]| {
    let Some((&[i0, i1, i2, i3, k0, k1], data)) = input.split_first_chunk() else { return };
    let (id, kind) = (MessageId(u32::from_le_bytes([i0, i1, i2, i3])), MessageType(u16::from_le_bytes([k0, k1])));
    if data.len() > usize::from(u16::MAX) {
        return;
    }
    holds(id, kind, data);
    let drawn = |wire: &[u8]| {
        let given = Frame::decode(wire).expect("a frame that was just encoded");
        holds(given.id(), given.kind(), given.payload());
    };
    drawn::frame::<Host>(data, |_| id, drawn);
    drawn::frame::<Device>(data, |_| id, drawn);
});

fn holds(id: MessageId, kind: MessageType, data: &[u8]) {
    // Greeting of a device: none, or the one in the data.
    let contexts = [Context::default(), Hi::decode(data).map(Context::of).unwrap_or_default()];
    there_and_back!(HostMessage, id, kind, data, &contexts);
    there_and_back!(DeviceMessage, id, kind, data, &contexts);
}
