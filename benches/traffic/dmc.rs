//! Mixes of DMC.

use dmc_proto::message::{
    Ack, AckCode, JogSpeed, Motor, MotorJog, MotorPositions, MoveTime, RtUploadMoveAxis, StartIndex, Steps,
};
use dmc_proto::{DeviceMessage, Dmc, Frame, HostMessage, MessageId, MessageType};
use motion_core::fixed::Scaled;
use motion_core::zerocopy::little_endian::I32;
use std::array;

use crate::decode::Use;

use super::{Mix, Protocol, Rng, SEED, Side, bytes, total};

/// Mix of 60 % positions of 16 motors, 20 % acknowledgements, 15 % jogs and 5 % uploads of 256 positions. The small mix
/// has jogs instead of uploads.
#[must_use]
pub fn dmc(uploads: bool) -> Mix {
    let (mut mix, mut rng) = (Mix::default(), Rng(SEED));
    let jogs = if uploads { [300, 100] } else { [400, 0] };
    for (kind, number) in rng.shuffle([1200, 400, jogs[0], jogs[1]]).into_iter().zip(1..) {
        let id = MessageId(number);
        let host = |mix: &mut Mix, message: &HostMessage<'_>| {
            mix.put(Side::Host, message, number, |out| message.encode_into(id, out));
        };
        let device = |mix: &mut Mix, message: &DeviceMessage<'_>| {
            mix.put(Side::Device, message, number, |out| message.encode_into(id, out));
        };
        let motor = Motor(1 + rng.byte() % 16);
        let positions: [I32; 256] = array::from_fn(|_| I32::new(rng.steps()));
        match kind {
            0 => {
                let move_time = MoveTime(Scaled(rng.steps()));
                let positions = MotorPositions { move_time, positions: &positions[..16], tail: &[] };
                device(&mut mix, &DeviceMessage::MotorGetPosition(positions));
            }
            1 => device(&mut mix, &DeviceMessage::Ack(Ack::new(MessageType(0x36), AckCode::OK))),
            2 => {
                let jog = MotorJog { motor, speed: JogSpeed::FULL, destination: Steps(rng.steps()), tail: &[] };
                host(&mut mix, &HostMessage::MotorJog(jog));
            }
            _ => {
                let start_index = StartIndex(u32::from(rng.byte()) * 256);
                let upload = RtUploadMoveAxis { motor, start_index, positions: &positions, tail: &[] };
                host(&mut mix, &HostMessage::RtUploadMoveAxis(upload));
            }
        }
    }
    mix
}

impl<const CAP: usize> Protocol for Dmc<CAP> {
    #[inline]
    fn sum<U: Use>(side: Side, frame: &Frame<'_>) -> u32 {
        let steps = |list: &[I32]| total(list.iter().map(|steps| steps.get().cast_unsigned()));
        let fields = match side {
            Side::Host => match U::kept(HostMessage::decode(frame)) {
                Ok(HostMessage::MotorJog(MotorJog { motor, speed, destination, tail })) => {
                    total([motor.0.into(), speed.0.0.into(), destination.0.cast_unsigned(), bytes(tail)])
                }
                Ok(HostMessage::RtUploadMoveAxis(RtUploadMoveAxis { motor, start_index, positions, tail })) => {
                    total([motor.0.into(), start_index.0, steps(positions), bytes(tail)])
                }
                _ => 0,
            },
            Side::Device => match U::kept(DeviceMessage::decode(frame)) {
                Ok(DeviceMessage::MotorGetPosition(MotorPositions { move_time, positions, tail })) => {
                    total([move_time.0.0.cast_unsigned(), steps(positions), bytes(tail)])
                }
                Ok(DeviceMessage::Ack(Ack { response_code, tail, .. })) => {
                    total([response_code.map_or(0, |code| code.0.into()), bytes(tail)])
                }
                _ => 0,
            },
        };
        fields.wrapping_add(frame.id().0)
    }
}
