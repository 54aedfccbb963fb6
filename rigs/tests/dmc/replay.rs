//! What firmware answered, replayed against the device of the same name.

use std::collections::BTreeMap;

use motion_core::time::Millis;
use motion_rigs::device::Named;
use motion_rigs::dmc_device::{DmcDevice, Setup};
use motion_rigs::{LineId, Outgoing, Party};

use crate::recorded::{Known, bytes, check, hex, table};

/// Number of motors of the firmware.
const MOTORS: u8 = 8;
/// Type of a message with positions.
const POSITIONS: u16 = 0x0034;

/// Frames one after the other, each on its own.
fn frames(mut bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut frames = Vec::new();
    while let [_, _, _, _, _, _, _, _, low, high, ..] = *bytes {
        let (frame, rest) = bytes.split_at(12 + usize::from(u16::from_le_bytes([low, high])));
        frames.push(frame.to_vec());
        bytes = rest;
    }
    assert!(bytes.is_empty());
    frames
}

fn kind(frame: &[u8]) -> u16 {
    u16::from_le_bytes([frame[6], frame[7]])
}

/// Whether two frames are equal. A position may be a step away, because the firmware adds up fractions of a step, and then
/// cuts them off.
fn are_equal(one: &[u8], other: &[u8]) -> bool {
    if kind(one) != POSITIONS || one.len() != other.len() || one[..14] != other[..14] {
        return one == other;
    }
    let numbers = |frame: &[u8]| -> Vec<i32> {
        let data = frame[14..frame.len() - 2].chunks_exact(4);
        data.map(|number| i32::from_le_bytes(number.try_into().unwrap())).collect()
    };
    numbers(one).iter().zip(numbers(other)).all(|(one, other)| one.abs_diff(other) <= 1)
}

/// Data and type of each frame.
fn shown(frames: &[Vec<u8>]) -> String {
    let show = |frame: &Vec<u8>| format!("{:04x}:{}", kind(frame), hex(&frame[10..frame.len() - 2]));
    frames.iter().map(show).collect::<Vec<_>>().join(" ")
}

/// Lines whose answer the device does not give.
const DIFFERENCES: &[Known] = &[
    ("motors in motion are a reason for a refusal before a motor or a length that is wrong", &[546, 547]),
    ("outputs outside an upload, or outside the move, are acknowledged and ignored", &[830, 844]),
    ("after a stop on the way to a run, the device is ready for this run once its motors are at its start", &[1115]),
    (
        "a way to a frame that replaces the way to a run divides by zero for a motor that stands there: this motor counts as \
         moving until a stop",
        &[1089],
    ),
    ("the end of a shot is rounded up to the next step", &[1353, 1360]),
    ("a move of a motor to the place where it stands does not end a run", &[1467, 1480]),
    ("a header that is too long is dropped with the start of the frame after it", &[1615]),
];

#[test]
fn a_device_answers_as_firmware_did() {
    let device = "dmc-lite";
    let mut rig = DmcDevice::new(Setup::with_motors(MOTORS).with_device(device).unwrap());
    rig.open(Millis(0), LineId(0));
    let rows = table::<4>("dmc/dmc-lite-1.2");
    assert!(rows.len() > 1400);
    let waits = rows.iter().skip(1).map(|[_, wait, ..]| wait.parse().unwrap());
    let (mut now, mut wrong) = (0, BTreeMap::new());
    now += rows[0][1].parse::<u64>().unwrap();
    for ((number, [topic, _, request, answer]), wait) in (1_usize..).zip(&rows).zip(waits.chain([400])) {
        rig.advance(Millis(now));
        if !request.is_empty() {
            rig.receive(Millis(now), LineId(0), &bytes(request));
        }
        now += wait;
        rig.advance(Millis(now));
        let mut found = Vec::new();
        while let Some(outgoing) = rig.poll() {
            if let Outgoing::Bytes(LineId(0), frame) = outgoing {
                found.push(frame);
            }
        }
        let wanted = frames(&bytes(answer));
        if topic == "moving" {
            found.retain(|frame| kind(frame) != POSITIONS);
        }
        let is_right =
            found.len() == wanted.len() && found.iter().zip(&wanted).all(|(one, other)| are_equal(one, other));
        if !is_right {
            wrong.insert(number, format!("{topic} {request}: {} and not {}", shown(&found), shown(&wanted)));
        }
    }
    check(device, rows.len(), wrong, DIFFERENCES);
}
