//! Mixes of kOS.

use kos_proto::message::{
    MotorAddress, MotorEntry, MotorInfo, MotorInfos, MotorPlace, MotorPosition, Normalized, Photos, PlaybackState,
    PlaybackStatus, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds,
};
use kos_proto::trajectory::{Axis, Block, Blocks, Point, Points, Segment, TrajectoryData};
use kos_proto::{DeviceMessage, Frame, Kos};
use motion_core::wire::Messages;
use std::array;

use crate::decode::Use;

use super::{Mix, Protocol, Rng, SEED, Side, bytes, count, total};

/// Mix of messages of the device: 60 % motor positions, 30 % playback states of 5 motors, 9 % ranges of a motor and 1 %
/// moves of 5 motors with 20 segments each. The small mix has motor positions instead of moves.
#[must_use]
pub fn kos(moves: bool) -> Mix {
    let (mut mix, mut rng) = (Mix::default(), Rng(SEED));
    let rest = if moves { [1200, 20] } else { [1220, 0] };
    for kind in rng.shuffle([rest[0], 600, 180, rest[1]]) {
        let mut put = |message: &DeviceMessage<'_>| mix.put(Side::Device, message, 0, |out| message.encode_into(out));
        let motor_address = MotorAddress(1 + rng.byte() % 5);
        match kind {
            0 => {
                let position = Rotations(rng.part());
                put(&DeviceMessage::MotorPosition(MotorPosition { motor_address, position, tail: &[] }));
            }
            1 => {
                let motors = [1, 2, 3, 4, 5].map(|motor| MotorPlace::new(MotorAddress(motor), Rotations(rng.part())));
                put(&DeviceMessage::PlaybackStatus(PlaybackStatus {
                    playback_status: PlaybackState::START_FORWARD,
                    elapsed_time: Normalized(rng.part()),
                    photo_count: Some(Photos(7.0)),
                    motors: &motors,
                    tail: &[],
                }));
            }
            2 => {
                let [position, begin, end] = [0; 3].map(|_| Rotations(rng.part()));
                let [setup, speed] = [0; 2].map(|_| RotationsPerSecond(rng.part()));
                let acceleration = RotationsPerSecondSquared(rng.part());
                let motor = [MotorEntry::new(motor_address, position, begin, end, setup, speed, acceleration)];
                put(&DeviceMessage::MotorInfo(MotorInfo { more: false, motors: MotorInfos::New(&motor), tail: &[] }));
            }
            _ => {
                let mut room = [0; 4096];
                let blocks = Blocks::encode(&move_of_5(&mut rng), &mut room).unwrap_or_default();
                put(&DeviceMessage::TrajectoryData(TrajectoryData { blocks, tail: &[] }));
            }
        }
    }
    mix
}

fn move_of_5(rng: &mut Rng) -> Vec<Block<'static>> {
    // The values of these two do not matter here, but each field must count.
    let fixed = [(1, &[0x3C; 37][..]), (2, &[0x3D; 21][..])];
    let mut blocks = fixed
        .map(|(number, body)| Block::decode_body(number, body).expect("the body has the length of its fields"))
        .to_vec();
    for motor_address in [1, 2, 3, 4, 5].map(MotorAddress) {
        blocks.push(Block::Axis(Axis { motor_address, segment_count: 20, tail: &[] }));
        blocks.extend((0..20).map(|segment_number| {
            let points = Points(array::from_fn(|_| Point::new(rng.part(), rng.part())));
            Block::Segment(Segment { motor_address, segment_number, points, tail: &[] })
        }));
    }
    blocks
}

impl<const CAP: usize> Protocol for Kos<CAP> {
    #[inline]
    fn sum<U: Use>(_: Side, frame: &Frame<'_>) -> u32 {
        match U::kept(DeviceMessage::decode(frame)) {
            Ok(DeviceMessage::MotorPosition(MotorPosition { motor_address, position, tail })) => {
                total([motor_address.0.into(), position.0.to_bits(), bytes(tail)])
            }
            Ok(DeviceMessage::PlaybackStatus(status)) => {
                let PlaybackStatus { playback_status, elapsed_time, photo_count, motors, tail } = status;
                let photos = photo_count.map_or(0, |photos| photos.0.to_bits());
                let places = motors
                    .iter()
                    .map(|place| u32::from(place.motor_address().0).wrapping_add(place.position().0.to_bits()));
                let others =
                    [playback_status.0.into(), elapsed_time.0.to_bits(), photos, count(motors.len()), bytes(tail)];
                total(others).wrapping_add(total(places))
            }
            Ok(DeviceMessage::MotorInfo(MotorInfo { motors, tail, .. })) => {
                let ranges = motors.iter().map(|motor| {
                    total([
                        motor.motor_address.0.into(),
                        motor.position.0.to_bits(),
                        motor.begin_position.map_or(0, |position| position.0.to_bits()),
                        motor.end_position.0.to_bits(),
                        motor.max_max_setup_speed.0.to_bits(),
                        motor.max_max_move_speed.0.to_bits(),
                        motor.max_max_acceleration.0.to_bits(),
                    ])
                });
                total([count(motors.len()), total(ranges), bytes(tail)])
            }
            Ok(DeviceMessage::TrajectoryData(TrajectoryData { blocks, tail })) => {
                total([count(blocks.len()), total(blocks.iter().map(|block| sum_of_block(&block))), bytes(tail)])
            }
            _ => 0,
        }
    }
}

#[inline]
fn sum_of_block(block: &Block<'_>) -> u32 {
    let number = |seconds: Seconds| seconds.0.to_bits();
    let fields = match *block {
        Block::Playback(it) => total([
            it.playback_mode.0.into(),
            number(it.duration),
            number(it.rapid_reverse_duration),
            it.loop_after_rapid_reverse.0.into(),
            it.loop_after_reverse.0.into(),
            it.delay_mode.0.into(),
            it.delay_interval_bits.0,
            it.camera_roll_enabled.0.into(),
            number(it.camera_roll_pre_delay),
            number(it.camera_roll_post_delay),
            it.flash_mark_enabled.0.into(),
            it.flash_mark_type.into(),
            number(it.flash_mark_post_delay),
            it.use_external_trigger.0.into(),
            it.using_lanc.0.into(),
            it.return_to_home_percent.0.to_bits(),
            bytes(it.tail),
        ]),
        Block::TimeLapse(it) => total([
            number(it.delay),
            number(it.exposure),
            it.move_photos,
            it.not_used.into(),
            it.pre_move_photos,
            it.post_move_photos,
            bytes(it.tail),
        ]),
        Block::Axis(it) => total([it.motor_address.0.into(), it.segment_count.into(), bytes(it.tail)]),
        Block::Segment(it) => {
            let points = it.points.0.map(|point| point.time.0.to_bits().wrapping_add(point.position.0.to_bits()));
            total([it.motor_address.0.into(), it.segment_number.into(), total(points), bytes(it.tail)])
        }
        _ => 0,
    };
    fields.wrapping_add(block.number())
}
