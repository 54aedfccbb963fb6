//! The three protocols, with the parts of them that no table of messages has.

use dmc_proto::message::RigKind;
use hoot_proto::message::{Reply, ResponseCode, ValueType};
use hoot_proto::query::{IntoReply, Query};
use kos_proto::{MessageId, MessageType};
use motion_core::wire::{Message as _, Messages, Row, Side};
use motion_core::zerocopy::BE;

use crate::probe::{self, Meaning, Message};
use crate::view::{View, views};

/// Protocol with all its messages.
#[derive(Debug)]
pub struct Protocol {
    /// Name of the protocol in filters and file names.
    pub key: &'static str,
    /// Name of the protocol.
    pub name: &'static str,
    /// Sentences about the tables of the messages.
    pub note: &'static str,
    /// Number of hexadecimal digits of a number.
    pub digits: usize,
    /// Lua constants of the line: byte order, port, and how a frame begins if its parts are joined from several records.
    pub line: &'static str,
    /// Names of numbers that are not in the body of a message, by field.
    pub names: Vec<(&'static str, Meaning)>,
    /// Messages of the host.
    pub host: Vec<Message>,
    /// Messages of the host that the published description does not have.
    pub later: Vec<Message>,
    /// Messages of the device.
    pub device: Vec<Message>,
    /// Groups of fields by number that a part of the dissector reads which is written by hand: a name for the list, and for
    /// each group its number and its message.
    pub groups: Option<(&'static str, Vec<Message>)>,
    /// Answers to queries, by the name of the query.
    pub answers: Vec<Answer>,
    /// Part of the dissector that is written by hand.
    pub by_hand: &'static str,
}

/// Values that answer a query.
#[derive(Debug)]
pub struct Answer {
    /// Name of the query.
    pub query: &'static str,
    /// Types that a value may have, how a person reads such a value, and its unit.
    pub types: Vec<(u8, Meaning, &'static str)>,
}

/// Data of the messages that are dissected by code that is written by hand.
pub const IRREGULAR: [(&str, &str); 4] = [
    ("TrajectoryData", "block_count u8; n × (block_id u8, length u16, block)"),
    ("SetTrajectoryData", "block_count u8; n × (block_id u8, length u16, block)"),
    (
        "VirtConfig",
        "type u8 of `rig`; rig by its type; after a boom, boom_table 121 × i32 and safe_distance_x1000 u32, if present",
    ),
    ("Reply", "value_type u8; value by its type"),
];

/// Protocols in the order of the crates.
#[must_use]
pub fn all() -> Vec<Protocol> {
    vec![kos(), dmc(), hoot()]
}

fn kos() -> Protocol {
    Protocol {
        key: "kos",
        name: "kOS",
        note: "The number of a message is its id, its type, and the number of the action or notification.\nAll numbers are big-endian. Devices of the older dialect leave out `begin_position` in MotorInfo and MotorCalibrated, and\n`photo_count` in PlaybackStatus. The length tells the dialects apart.",
        digits: 8,
        line: "local LITTLE, PORT, MARKER = false, 5520, nil",
        names: vec![
            ("message_id", names(|id| MessageId(u16::from(id)).name())),
            ("message_type", names(|kind| MessageType(kind).name())),
        ],
        host: probe::messages::<kos_proto::Host>(),
        later: Vec::new(),
        device: probe::messages::<kos_proto::Device>(),
        groups: Some(("blocks", probe::messages::<Blocks>())),
        answers: Vec::new(),
        by_hand: include_str!("../lua/kos.lua"),
    }
}

/// Names of the numbers of one byte.
fn names(name: impl Fn(u8) -> Option<&'static str>) -> Meaning {
    Meaning::Names((0..=u8::MAX).filter_map(|number| Some((number.into(), name(number)?.to_owned()))).collect())
}

/// Side that the blocks of a kOS move are listed as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Blocks {}

impl Side for Blocks {
    type Message<'a> = kos_proto::trajectory::Block<'a>;
    type Order = BE;
}

fn dmc() -> Protocol {
    use dmc_proto::message::{BoomRig, SwingPan};
    let rig = |number, name, layout: &[Row], read: &dyn Fn(&[u8]) -> Option<Vec<View>>| Message {
        number,
        last: number,
        also: None,
        name,
        conduct: None,
        sub: None,
        fields: probe::fields(layout, true, read),
        tail: false,
    };
    let boom = |body: &[u8]| BoomRig::decode(body).ok().map(|rig| views(&rig));
    let swing = |body: &[u8]| SwingPan::decode(body).ok().map(|rig| views(&rig));
    Protocol {
        key: "dmc",
        name: "DMC",
        note: "The number of a message is its type. All numbers are little-endian.",
        digits: 4,
        line: r#"local LITTLE, PORT, MARKER = true, nil, "DF""#,
        names: vec![("rig", names(|kind| RigKind(kind).name()))],
        host: probe::messages::<dmc_proto::Host>(),
        later: Vec::new(),
        device: probe::messages::<dmc_proto::Device>(),
        groups: Some((
            "rigs",
            vec![rig(1, "BoomRig", BoomRig::LAYOUT, &boom), rig(2, "SwingPan", SwingPan::LAYOUT, &swing)],
        )),
        answers: Vec::new(),
        by_hand: include_str!("../lua/dmc.lua"),
    }
}

fn hoot() -> Protocol {
    Protocol {
        key: "hoot",
        name: "hoot",
        note: "The number of a message is its table, its command and its sub-address. The table is 1 for broadcasts, 2 for\nthe core protocol, and 0 for all others. All numbers are big-endian.\nA command with data of another length is unknown.",
        digits: 6,
        line: r#"local LITTLE, PORT, MARKER = false, nil, string.rep("\0", 5) .. "\255""#,
        names: vec![
            ("response_code", names(|code| ResponseCode(code).name())),
            ("value_type", names(|value_type| ValueType(value_type).name())),
        ],
        host: probe::messages::<hoot_proto::Host>(),
        later: probe::messages::<hoot_proto::beyond::Host>(),
        device: probe::messages::<hoot_proto::Device>(),
        groups: None,
        answers: answers(),
        by_hand: include_str!("../lua/hoot.lua"),
    }
}

/// Answers to the queries, found by asking each query for its reading of made-up values.
fn answers() -> Vec<Answer> {
    let kinds = hoot_proto::HostMessage::ALL.iter();
    let queries = kinds
        .filter_map(|kind| Some((kind.name, hoot_proto::HostMessage::decode_body(kind.number, &[]).ok()?.query()?)));
    queries
        .map(|(name, query)| {
            let view = |value_type: u8, value: u32| {
                let size = [1, 2, 2, 4, 4, 4, 0].get(usize::from(value_type)).copied()?;
                let data = [&[value_type], &value.to_be_bytes()[4 - size..]].concat();
                let answer = query.decode_reply(Reply { code: ResponseCode::OK, data: &data }).ok()?;
                (answer.value().value_type().0 == value_type).then(|| views(&answer).remove(1))
            };
            let types = (0..=6).filter_map(|value_type| {
                let View { unit, .. } = view(value_type, 0)?;
                let text = |value| Some(view(value_type, u32::try_from(value).ok()?)?.text);
                Some((value_type, probe::meaning_of(if value_type == 0 { 1 } else { 2 }, &text), unit))
            });
            Answer { query: name, types: types.collect() }
        })
        .collect()
}
