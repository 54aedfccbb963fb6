//! kOS: any payload of any id and type, decoded, encoded as a whole message and read again, gives the same bytes, for
//! both senders, also over USB and as a datagram.
//!
//! Input: id (`u16`, big-endian) and type of the message, then its payload. The input also draws a message of each side.

#![no_main]

use fuzz::drawn;
use kos_proto::discovery::Datagram;
use kos_proto::frame::{self, Frame, HEADER_LEN, MessageId, MessageType};
use kos_proto::lint::Context;
use kos_proto::usb::{self, CAPACITY, Report};
use kos_proto::{DecodeError, Device, DeviceMessage, EncodeError, Host, HostMessage};
use libfuzzer_sys::fuzz_target;

macro_rules! there_and_back {
    ($side:ident, $given:ident) => {
        match $side::decode(&$given) {
            Ok(message) => {
                let wire = $given.bytes();
                let mut again = vec![0; message.encoded_len() + 3];
                let len = message.encode_into(&mut again).expect("a decoded message can be encoded");
                assert_eq!((&again[..len], &again[len..]), (wire, &[0; 3][..]));

                let checked = message.encode_checked(&Context::default(), &mut again);
                let refused = message.lint(&Context::default()).first_error().map(EncodeError::Refused);
                assert_eq!(checked, refused.map_or(Ok(len), Err));
                assert!(message.to_string().len() < 8192);

                let too_long = Err(EncodeError::TooLong { what: "USB report", len, max: CAPACITY });
                let report = Report::encode(&message);
                assert_eq!(report, Report::new($given));
                assert_eq!(report, if len > CAPACITY { too_long } else { report });
                if let Ok(report) = report {
                    assert_eq!(usb::decode(report.as_ref()), Ok($given));
                }
            }
            // In trajectories these lengths count from the start of their block.
            Err(DecodeError::Truncated { needed, have, .. }) => assert!(needed > have),
            Err(error) => panic!("{error}"),
        }
    };
}

fuzz_target!(|input: &[u8]| {
    drawn::frame::<Host>(input, |_| (), holds);
    drawn::frame::<Device>(input, |_| (), holds);
    let Some((&[i0, i1, kind], payload)) = input.split_first_chunk() else { return };
    let mut wire = vec![0; payload.len() + HEADER_LEN];
    let written = frame::encode(MessageId(u16::from_be_bytes([i0, i1])), MessageType(kind), payload, &mut wire);
    if wire.len() > usize::from(u16::MAX) {
        return assert!(written.is_err());
    }
    assert_eq!(written, Ok(wire.len()));
    holds(&wire);
});

fn holds(wire: &[u8]) {
    let given = Frame::decode(wire).expect("a message that was just encoded");
    there_and_back!(HostMessage, given);
    there_and_back!(DeviceMessage, given);

    if let Ok(said) = Datagram::decode(wire) {
        let mut again = vec![0; said.encoded_len()];
        assert_eq!((said.encode_into(&mut again), &again[..]), (Ok(wire.len()), wire));
    }
}
