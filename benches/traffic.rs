//! The traffic that streams are measured with: mixes of messages in random order, always the same.
//!
//! A mix is what a tap on the line sees: both directions in one stream, each message with the side that sent it. Whoever
//! reads it decodes each message as that side's and adds up its fields, so that all of them count. What must come out is
//! known from the values that went in.

use core::array;

use dmc_proto::Dmc;
use dmc_proto::message::{Ack, AckCode, JogSpeed, MotorJog, MotorPositions, RtUploadMoveAxis, StartIndex};
use hoot_proto::Hoot;
use hoot_proto::message::{MotorMove, Reply, ResponseCode, Value as Answer};
use kos_proto::Kos;
use kos_proto::message::{MotorAddress, MotorEntry, MotorInfo, MotorInfos, MotorPlace, MotorPosition, PlaybackStatus};
use kos_proto::message::{RotationsPerSecondSquared, Seconds};
use kos_proto::trajectory::{Axis, Block, Blocks, Point, Points, Segment, TrajectoryData};
use motion_core::fixed::Scaled;
use motion_core::stream::Framing;
use motion_core::wire::{EncodeError, FieldView, Fields, Messages, Value};
use motion_core::zerocopy::little_endian::I32;

/// Who sent a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The one that controls.
    Host,
    /// The one that moves.
    Device,
}

/// A protocol whose messages can be decoded and added up.
pub trait Protocol: Framing + 'static {
    /// The sum of all fields of a message, modulo 2^32.
    fn sum(side: Side, frame: &Self::Frame<'_>) -> u32;
}

/// What became of a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Messages found.
    pub messages: usize,
    /// Their sums, entangled so that their order counts.
    pub value: u32,
}

impl Tally {
    fn add(&mut self, sum: u32) {
        self.messages += 1;
        self.value = self.value.rotate_left(1) ^ sum;
    }
}

/// Messages in one stream.
#[derive(Clone, Debug, Default)]
pub struct Mix {
    /// Their frames, one behind the other.
    pub bytes: Vec<u8>,
    /// Who sent each.
    pub sides: Vec<Side>,
    /// What a reader must find.
    pub tally: Tally,
}

impl Mix {
    /// Who reads the messages, from the first one on.
    #[must_use]
    pub fn reader(&self) -> Reader<'_> {
        Reader { sides: self.sides.iter(), tally: Tally::default() }
    }

    /// Puts a message at the end. `extra` is what a reader adds to the fields.
    fn put(
        &mut self,
        side: Side,
        message: &impl Fields,
        extra: u32,
        encode: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
    ) {
        let mut frame = [0; 4096];
        let len = encode(&mut frame).expect("a message that can be written");
        self.bytes.extend(&frame[..len]);
        self.sides.push(side);
        self.tally.add(sum_of(message).wrapping_add(extra));
    }
}

/// Decodes the frames that a stream gives, and keeps the tally.
#[derive(Clone, Debug)]
pub struct Reader<'a> {
    sides: std::slice::Iter<'a, Side>,
    /// What was found so far.
    pub tally: Tally,
}

impl Reader<'_> {
    /// Decodes the next frame. Frames beyond those of the mix count as the host's.
    #[inline]
    pub fn frame<F: Protocol>(&mut self, frame: &F::Frame<'_>) {
        let side = self.sides.next().copied().unwrap_or(Side::Host);
        self.tally.add(F::sum(side, frame));
    }
}

/// The sum of all fields, found out the slow way, without any decoder.
fn sum_of(message: &dyn Fields) -> u32 {
    let mut sum = 0_u32;
    message.fields(&mut |field: &FieldView<'_>| sum = sum.wrapping_add(raw(field.value)));
    sum
}

fn raw(value: Value<'_>) -> u32 {
    let low = |wide: u64| u32::try_from(wide & 0xFFFF_FFFF).expect("masked");
    match value {
        Value::Unsigned(number) => low(number),
        Value::Signed(number) => low(number.cast_unsigned()),
        Value::Float(number) => number.to_bits(),
        Value::Text(bytes) | Value::Secret(bytes) | Value::Bytes(bytes) => bytes.iter().copied().map(u32::from).sum(),
        Value::List(list) => {
            let mut sum = 0_u32;
            list.each(&mut |item| sum = sum.wrapping_add(raw(item)));
            sum
        }
        Value::Group(fields) => sum_of(fields),
    }
}

/// Adds up, modulo 2^32.
fn total(numbers: impl IntoIterator<Item = u32>) -> u32 {
    numbers.into_iter().fold(0, u32::wrapping_add)
}

fn count(len: usize) -> u32 {
    u32::try_from(len).unwrap_or(u32::MAX)
}

fn bytes(bytes: &[u8]) -> u32 {
    total(bytes.iter().copied().map(u32::from))
}

/// Random numbers from a fixed seed (xorshift).
struct Rng(u32);

impl Rng {
    fn next(&mut self) -> u32 {
        for shift in [13, -17, 5] {
            self.0 ^= if shift > 0 { self.0 << shift } else { self.0 >> -shift };
        }
        self.0
    }

    fn byte(&mut self) -> u8 {
        self.next().to_be_bytes()[0]
    }

    /// A position as a rig has it: some hundred thousand steps either way.
    fn steps(&mut self) -> i32 {
        self.next().cast_signed() >> 12
    }

    /// A part of a whole.
    fn part(&mut self) -> f32 {
        f32::from_bits(0x3F80_0000 | self.next() >> 9) - 1.0
    }

    /// Numbers each kind of message as often as said, in random order.
    fn shuffle<const KINDS: usize>(&mut self, shares: [usize; KINDS]) -> Vec<usize> {
        let mut kinds: Vec<usize> =
            shares.into_iter().enumerate().flat_map(|(kind, share)| std::iter::repeat_n(kind, share)).collect();
        for left in (1..=kinds.len()).rev() {
            kinds.swap(left - 1, self.next() as usize % left);
        }
        kinds
    }
}

const SEED: u32 = 0x2545_F491;

/// DMC: 60 % positions of 16 motors, 20 % acknowledgements, 15 % jogs, 5 % uploads of 256 positions; in the small mix
/// jogs instead of uploads.
#[must_use]
pub fn dmc(uploads: bool) -> Mix {
    use dmc_proto::message::{Motor, MoveTime, Steps};
    use dmc_proto::{DeviceMessage, HostMessage, MessageId, MessageType};

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
    fn sum(side: Side, frame: &dmc_proto::Frame<'_>) -> u32 {
        use dmc_proto::{DeviceMessage, HostMessage};

        let steps = |list: &[I32]| total(list.iter().map(|steps| steps.get().cast_unsigned()));
        let fields = match side {
            Side::Host => match HostMessage::decode(frame) {
                Ok(HostMessage::MotorJog(MotorJog { motor, speed, destination, tail })) => {
                    total([motor.0.into(), speed.0.0.into(), destination.0.cast_unsigned(), bytes(tail)])
                }
                Ok(HostMessage::RtUploadMoveAxis(RtUploadMoveAxis { motor, start_index, positions, tail })) => {
                    total([motor.0.into(), start_index.0, steps(positions), bytes(tail)])
                }
                _ => 0,
            },
            Side::Device => match DeviceMessage::decode(frame) {
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

/// kOS, all from the device: 60 % motor positions, 30 % playback states of 5 motors, 9 % ranges of a motor, 1 % moves of
/// 5 motors with 20 segments each; in the small mix motor positions instead of moves.
#[must_use]
pub fn kos(moves: bool) -> Mix {
    use kos_proto::DeviceMessage;
    use kos_proto::message::{Normalized, Photos, PlaybackState, Rotations, RotationsPerSecond};

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
    // What the fields of these two say is all the same here, as long as each counts.
    let fixed = [(1, &[0x3C; 37][..]), (2, &[0x3D; 21][..])];
    let mut blocks = fixed.map(|(number, body)| Block::decode_body(number, body).expect("as long as its fields")).to_vec();
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
    fn sum(_: Side, frame: &kos_proto::Frame<'_>) -> u32 {
        use kos_proto::DeviceMessage;

        match DeviceMessage::decode(frame) {
            Ok(DeviceMessage::MotorPosition(MotorPosition { motor_address, position, tail })) => {
                total([motor_address.0.into(), position.0.to_bits(), bytes(tail)])
            }
            Ok(DeviceMessage::PlaybackStatus(status)) => {
                let PlaybackStatus { playback_status, elapsed_time, photo_count, motors, tail } = status;
                let photos = photo_count.map_or(0, |photos| photos.0.to_bits());
                let places = motors.iter().map(|place| {
                    u32::from(place.motor_address().0).wrapping_add(place.position().0.to_bits())
                });
                let others = [playback_status.0.into(), elapsed_time.0.to_bits(), photos, count(motors.len()), bytes(tail)];
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
            it.flash_mark_enabled.into(),
            it.flash_mark_type.into(),
            number(it.flash_mark_post_delay),
            it.use_external_trigger.into(),
            it.using_lanc.into(),
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

/// hoot: as many moves, queries, answers and acknowledgements, of 10 to 15 bytes.
#[must_use]
pub fn hoot() -> Mix {
    use hoot_proto::message::{Direction, Motor, StepCount, ValueType};
    use hoot_proto::{Address, DeviceMessage, HostMessage};

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
            1 => host(&mut mix, &HostMessage::MotorPosition(hoot_proto::message::MotorPosition { motor })),
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
    #[inline]
    fn sum(side: Side, frame: &hoot_proto::Frame<'_>) -> u32 {
        use hoot_proto::{DeviceMessage, HostMessage};

        match side {
            Side::Host => match HostMessage::decode(frame) {
                HostMessage::MotorMove(MotorMove { motor, direction, steps }) => {
                    total([motor.get().into(), direction.0.into(), steps.0])
                }
                HostMessage::MotorPosition(query) => query.motor.get().into(),
                _ => 0,
            },
            Side::Device => match DeviceMessage::decode(frame) {
                DeviceMessage::Reply(reply) => total([reply.code.0.into(), sum_of_answer(&reply)]),
                _ => 0,
            },
        }
    }
}

#[inline]
fn sum_of_answer(reply: &Reply<'_>) -> u32 {
    match reply.value() {
        Some(value @ Answer::Long(steps)) => u32::from(value.value_type().0).wrapping_add(steps.cast_unsigned()),
        Some(_) => 0,
        None => bytes(reply.data),
    }
}
