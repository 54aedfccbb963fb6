//! Mix of hoot.

use hoot_proto::message::{
    Direction, Motor, MotorMove, MotorPosition, Reply, ResponseCode, StepCount, Value, ValueType,
};
use hoot_proto::{Address, DeviceMessage, Frame, Hoot, HostMessage, Query as _};

use crate::decode::Use;

use super::{Mix, Protocol, Rng, SEED, Side, bytes, total};

/// Mix of equal numbers of moves, queries, answers and acknowledgements, of 10 to 15 bytes.
#[must_use]
pub fn hoot() -> Mix {
    let (mut mix, mut rng) = (Mix::default(), Rng(SEED));
    for kind in rng.shuffle([500; 4]) {
        let host = |mix: &mut Mix, message: &HostMessage<'_>| {
            mix.put(Side::Host, message, 0, |out| message.encode_into(Address::DEFAULT, out));
        };
        let device = |mix: &mut Mix, data: &[u8]| {
            let message = DeviceMessage::Reply(Reply { code: ResponseCode::OK, data });
            mix.put(Side::Device, &message, 0, |out| message.encode_into(out));
        };
        let motor = Motor::ALL[usize::from(rng.byte() % 3)];
        match kind {
            0 => {
                let (direction, steps) = (Direction(rng.byte() & 1), StepCount(1 + u32::from(rng.byte())));
                host(&mut mix, &HostMessage::MotorMove(MotorMove { motor, direction, steps }));
            }
            1 => host(&mut mix, &HostMessage::MotorPosition(MotorPosition { motor })),
            2 => {
                let [b0, b1, b2, b3] = rng.steps().to_be_bytes();
                device(&mut mix, &[ValueType::LONG.0, b0, b1, b2, b3]);
            }
            _ => device(&mut mix, &[]),
        }
    }
    mix
}

impl<const CAP: usize> Protocol for Hoot<CAP> {
    // The parsers of the peers have one caller each, and are inlined. This function has several.
    #[allow(clippy::inline_always, reason = "a call of the bench is not part of the work")]
    #[inline(always)]
    fn sum<U: Use>(side: Side, frame: &Frame<'_>) -> u32 {
        match side {
            Side::Host => match U::kept(HostMessage::decode(frame)) {
                HostMessage::MotorMove(MotorMove { motor, direction, steps }) => {
                    total([motor.get().into(), direction.0.into(), steps.0])
                }
                HostMessage::MotorPosition(query) => query.motor.get().into(),
                _ => 0,
            },
            Side::Device => match U::kept(DeviceMessage::decode(frame)) {
                DeviceMessage::Reply(reply) => total([reply.code.0.into(), sum_of_answer::<U>(&reply)]),
                _ => 0,
            },
        }
    }
}

/// Sum of a packet, in which a reply with a value is read through the query that it answers. The mix has one kind of
/// query, and its motor changes nothing.
#[inline]
#[must_use]
pub fn through_query<U: Use>(side: Side, frame: &Frame<'_>) -> u32 {
    if side == Side::Host {
        return <Hoot as Protocol>::sum::<U>(side, frame);
    }
    let DeviceMessage::Reply(reply) = U::kept(DeviceMessage::decode(frame)) else { return 0 };
    let code = u32::from(reply.code.0);
    if reply.data.is_empty() {
        return code;
    }
    let Ok(position) = U::kept((MotorPosition { motor: Motor::One }).decode_reply(reply)) else { return 0 };
    total([code, position.value_type().0.into(), position.value.0.cast_unsigned()])
}

#[inline]
fn sum_of_answer<U: Use>(reply: &Reply<'_>) -> u32 {
    match U::kept(reply.value()) {
        Some(value @ Value::Long(steps)) => u32::from(value.value_type().0).wrapping_add(steps.cast_unsigned()),
        Some(_) => 0,
        None => bytes(reply.data),
    }
}
