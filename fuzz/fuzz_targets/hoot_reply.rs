//! hoot: any data as the answer to any query. A decoded answer can be encoded again and decodes to the same value. For
//! the firmware of every profile, the encoded answer is the one that this firmware would send.
//!
//! Input: the query, which is a command and a sub-address, the response code, and the data of the reply.

#![no_main]

use hoot_proto::message::{Reply, ResponseCode, ValueType};
use hoot_proto::query::{IntoReply, Profile, Query};
use hoot_proto::{Frame, HostMessage, ReplyError};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    let Some((&[command, sub_address, code], data)) = input.split_first_chunk() else { return };
    // Queries of the core protocol are data of command 1.
    let core = [0, 0, 0, 0, 0, 0xFF, 3, sub_address, 1, 1, command];
    let plain = [0, 0, 0, 0, 0, 0xFF, 3, sub_address, command, 0];
    let request = if command < 100 { &core[..] } else { &plain };
    let request = HostMessage::decode(&Frame::decode(request).expect("a packet"));
    let Some(query) = request.query() else { return };

    let code = ResponseCode(code);
    let reply = Reply { code, data };
    let answer = match query.decode_reply(reply) {
        Ok(answer) => answer,
        Err(ReplyError::Node { code: found }) => return assert!(found == code && code != ResponseCode::OK),
        Err(ReplyError::Short { need, have }) => return assert!(need > have && have == data.len()),
        Err(ReplyError::Trailing { extra }) => return assert!(extra > 0 && extra < data.len()),
        Err(error) => return assert!(error.to_string().contains("of type"), "{error}"),
    };
    assert_eq!((code, reply.value_type()), (ResponseCode::OK, Some(answer.value_type())));
    assert!(answer.to_string().len() < 8192);

    let mut room = [0; 256];
    let Ok(made) = query.reply(answer, &mut room) else { return assert!(data.len() > room.len()) };
    assert_eq!((made.value(), made.data.len()), (Some(answer.value()), data.len()));
    assert_eq!(query.decode_reply(made), Ok(answer), "the encoded answer decodes to the same value");

    for profile in Profile::builds().chain([Profile::UNKNOWN]) {
        let is_float = answer.value_type() == ValueType::FLOAT;
        assert_eq!(answer.is_reliable(profile), !is_float || profile.float_is_true() == Some(true));
        assert!(query.value_type(profile).size().is_some() || query.value_type(profile) == ValueType::STRING);
        let _ = profile.packets(&request);
    }
});
