//! hoot: any data of any command, decoded, encoded as a whole packet and read again, gives the same bytes, for both
//! senders, as the sheet reads it and as later firmware does.
//!
//! Input: address, sub-address and command of the packet, then its data. The input also draws a message of each side.

#![no_main]

use fuzz::drawn::{self, address};
use hoot_proto::frame::{self, MAX_DATA, MAX_FRAME};
use hoot_proto::lint::Context;
use hoot_proto::{Address, Device, DeviceMessage, EncodeError, Frame, Host, HostMessage, Messages, beyond};
use libfuzzer_sys::fuzz_target;

macro_rules! there_and_back {
    ($message:expr, $wire:expr $(, $to:expr)?) => {
        let (message, wire): (_, &[u8]) = ($message, $wire);
        let mut again = [0; MAX_FRAME + 3];
        let len = message.encode_into($($to,)? &mut again).expect("a decoded message can be encoded");
        assert_eq!((&again[..len], &again[len..]), (wire, &[0; MAX_FRAME + 3][len..]));
        assert_eq!(message.encoded_len(), len);
        let few = &mut again[..len - 1];
        assert_eq!(message.encode_into($($to,)? few), Err(EncodeError::BufferTooSmall { needed: len, have: len - 1 }));

        let checked = message.encode_checked($($to,)? &Context::default(), &mut again);
        match message.lint(&Context::default()).first_error() {
            Some(first) => assert_eq!(checked, Err(EncodeError::Refused(first))),
            None => assert!(checked == Ok(len) $(|| $to == Address::MASTER)?),
        }
        assert!(message.to_string().len() < 8192);
    };
}

fuzz_target!(|input: &[u8]| {
    drawn::frame::<Host>(input, |message| address(message.number()), holds);
    drawn::frame::<beyond::Host>(input, |message| address(message.number()), holds);
    drawn::frame::<Device>(input, |_| (), holds);
    let Some((&[address, sub_address, command], data)) = input.split_first_chunk() else { return };
    let mut out = [0; MAX_FRAME];
    let written = frame::encode(Address(address), sub_address, command, data, &mut out);
    let Ok(len) = written else { return assert!(data.len() > MAX_DATA) };
    let wire = &out[..len];
    let packet = Frame::decode(wire).expect("a packet that was just encoded");
    assert_eq!((packet.bytes(), packet.payload()), (wire, data));
    holds(wire);
});

fn holds(wire: &[u8]) {
    let packet = Frame::decode(wire).expect("a packet that was just encoded");
    let to = packet.address();
    there_and_back!(HostMessage::decode(&packet), wire, to);
    there_and_back!(beyond::HostMessage::decode(&packet), wire, to);
    there_and_back!(DeviceMessage::decode(&packet), wire);
}
