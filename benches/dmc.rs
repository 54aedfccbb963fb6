//! Whole messages of DMC and their encoding, compared with other crates.
//!
//! E1: one message is encoded to its frame. The limit is to copy a finished frame and to calculate its checksum.

use std::hint::black_box;

use benches::decode::{self, Whole};
use benches::ratios::{Contender, contender};
use benches::report::Report;
use benches::traffic;
use bytes::{BufMut, BytesMut};
use dmc_proto::message::{JogSpeed, Motor, MotorJog, MotorPositions, MoveTime, RtUploadMoveAxis, StartIndex, Steps};
use dmc_proto::{DeviceMessage, HostMessage, MessageId};
use motion_core::fixed::Scaled;
use motion_core::fletcher::{Sum, verify};
use motion_core::zerocopy::little_endian::I32;

use crate::peers::dmc::readers;

pub(crate) fn chapter(report: &mut Report) {
    let mixes = [("upload mix", traffic::dmc(true)), ("small mix", traffic::dmc(false))];
    decode::rows(&mut report.table("DMC decode, whole messages"), &mixes, &readers::<Whole>());

    let mut table = report.table("DMC encode");
    let mut steps = (-128..128).map(|at| I32::new(at * 7_654_321));
    let positions: [I32; 256] = std::array::from_fn(|_| steps.next().unwrap_or_default());
    let at = MotorPositions { move_time: MoveTime(Scaled(12_345)), positions: &positions[..16], tail: &[] };
    let jog = MotorJog { motor: Motor(3), speed: JogSpeed::FULL, destination: Steps(-70_000), tail: &[] };
    let upload = RtUploadMoveAxis { motor: Motor(3), start_index: StartIndex(512), positions: &positions, tail: &[] };
    table.row("19 B", encoders(move |out| HostMessage::MotorJog(black_box(jog)).encode_into(MessageId(77), out)));
    table.row(
        "80 B",
        encoders(move |out| DeviceMessage::MotorGetPosition(black_box(at)).encode_into(MessageId(77), out)),
    );
    table.row(
        "1041 B",
        encoders(move |out| HostMessage::RtUploadMoveAxis(black_box(upload)).encode_into(MessageId(77), out)),
    );
}

/// Three contenders that write the same frame.
fn encoders<'a, E: std::fmt::Debug>(encode: impl Fn(&mut [u8]) -> Result<usize, E> + Copy + 'a) -> Vec<Contender<'a>> {
    let mut frame = [0; 2048];
    let len = encode(&mut frame).expect("the message can be encoded");
    let frame: Vec<u8> = frame[..len].into();
    assert!(verify(&frame));

    let copy = |frame: &[u8], out: &mut [u8; 2048]| {
        let (body, check) = out[..frame.len()].split_last_chunk_mut::<2>().expect("check bytes");
        body.copy_from_slice(&frame[..frame.len() - 2]);
        *check = Sum::of(body).check_bytes();
    };
    let (wanted, mut out) = (frame.clone(), [0; 2048]);
    copy(&wanted, &mut out);
    assert_eq!(out[..len], wanted);

    let message = frame[10..len - 2].to_vec();
    let head: [u8; 10] = frame[..10].try_into().expect("a header");
    let mut buf = BytesMut::with_capacity(4096);
    put(&mut buf, &head, &message);
    assert_eq!(buf, frame);

    let mut ours = [0; 2048];
    vec![
        contender("dmc-proto", move || encode(black_box(&mut ours)).is_ok()),
        contender("memcpy and sum", move || copy(black_box(&frame), black_box(&mut out))),
        contender("bytes, BytesMut", move || {
            buf.clear();
            put(black_box(&mut buf), black_box(&head), black_box(&message));
        }),
    ]
}

/// Encoder as users of `bytes` write it: number by number, then the checksum of the written bytes.
fn put(buf: &mut BytesMut, head: &[u8; 10], data: &[u8]) {
    let start = buf.len();
    let number = |at: usize| u16::from_le_bytes([head[at], head[at + 1]]);
    buf.put_slice(b"DF");
    buf.put_u32_le(u32::from(number(2)) | u32::from(number(4)) << 16);
    buf.put_u16_le(number(6));
    buf.put_u16_le(number(8));
    let (numbers, rest) = data.split_at(data.len() & !3);
    for number in numbers.chunks_exact(4) {
        buf.put_i32_le(i32::from_le_bytes(*number.first_chunk().expect("four bytes")));
    }
    for &byte in rest {
        buf.put_u8(byte);
    }
    let check = Sum::of(&buf[start..]).check_bytes();
    buf.put_slice(&check);
}
