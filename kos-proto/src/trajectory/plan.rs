//! Builder: turns a move in seconds and rotations into blocks, or into an error that names the fault, its place and its
//! size.

use core::iter;

use motion_core::bezier::{self, Ease, Key};
use motion_core::wire::{Message, Row};

use super::blocks::{Axis, Block, Blocks, Playback, Segment, TimeLapse, TrajectoryData};
use super::error::{Amount, MoveError, Place};
use super::play::Play;
use super::rules;
use super::values::{Point, Points};
use crate::message::{Motor, MotorAddress, Normalized, Rotations};

/// Plan of a move: how it is played, and the way of each motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan<'a> {
    play: Play,
    motors: &'a [MotorPlan<'a>],
    without_motors: bool,
}

/// Way of one motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorPlan<'a> {
    /// Motor address, 1 to 10. The flag for focus, iris and zoom is left out when the address is written (decision
    /// K-M2).
    pub motor: MotorAddress,
    /// Way of the motor.
    pub way: Way<'a>,
}

/// Path of a motor over the time of the move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Way<'a> {
    /// Key frames: at least two, the first at the start of the move and the last at its end.
    Keys {
        /// End of the motor's range, in rotations from the begin of the range; not 0. See [`Motor::range`].
        range: Rotations,
        /// Key frames. Times are in seconds from the start of the move, up to its [`move_time`](Play::move_time).
        /// Positions are in rotations from the begin of the range, as in commands.
        keys: &'a [Key],
    },
    /// Curves in parts of the move and of the range, each from 0 to 1.
    Segments(&'a [bezier::Segment]),
}

impl<'a> MotorPlan<'a> {
    /// Way of a motor that the device reported, from key frame to key frame.
    ///
    /// # Errors
    ///
    /// [`MoveError::Uncalibrated`] if the range of the motor is not known.
    pub fn new(motor: &Motor, keys: &'a [Key]) -> Result<Self, MoveError> {
        let (motor, range) = (motor.motor_address, motor.range());
        let range = range.ok_or(MoveError::Uncalibrated { motor })?;
        Ok(Self { motor, way: Way::Keys { range, keys } })
    }
}

impl<'a> Plan<'a> {
    /// Bytes that are enough for the blocks of any move.
    pub const MAX_LEN: usize = FIXED_LEN + AXIS_LEN + (Blocks::MAX - FIXED_BLOCKS - 1) * SEGMENT_LEN;

    /// Plan of a move with motors.
    #[must_use]
    pub const fn new(play: Play, motors: &'a [MotorPlan<'a>]) -> Self {
        Self { play, motors, without_motors: false }
    }

    /// Plan of a move in which only the shutter moves.
    ///
    /// The specification requires a motor, so a strict device refuses this move, and lint reports an error (decision
    /// K-J1).
    #[must_use]
    pub const fn without_motors(play: Play) -> Self {
        Self { play, motors: &[], without_motors: true }
    }

    /// Settings for playing the move.
    #[must_use]
    pub const fn play(&self) -> Play {
        self.play
    }

    /// Bytes that [`encode`](Self::encode) needs; the message takes seven more.
    #[must_use]
    pub fn encoded_len(&self) -> usize {
        let axis = |motor: &MotorPlan<'_>| motor.way.len().saturating_mul(SEGMENT_LEN).saturating_add(AXIS_LEN);
        self.motors.iter().map(axis).fold(FIXED_LEN, usize::saturating_add)
    }

    /// Writes the blocks to the front of `out`, and borrows them from there.
    ///
    /// Lint is silent on the result, except for three options that must be asked for: another time for the rapid way
    /// back, a moment as an IEEE number, and a move without motors.
    ///
    /// # Errors
    ///
    /// [`MoveError`] if there are too many blocks, if they do not fit, or if they would not be a move. Then the content
    /// of `out` has no meaning.
    pub fn encode<'o>(&self, out: &'o mut [u8]) -> Result<TrajectoryData<'o>, MoveError> {
        let segments = self.motors.iter().map(|motor| motor.way.len());
        let needed = segments.fold(self.motors.len().saturating_add(FIXED_BLOCKS), usize::saturating_add);
        if needed > Blocks::MAX {
            return Err(MoveError::TooManyBlocks { needed });
        }
        let (playback, time_lapse) = self.play.blocks()?;
        let span = self.span()?;
        let fixed = [Block::Playback(playback), Block::TimeLapse(time_lapse)].map(Ok);
        let motors = self.motors.iter().flat_map(|motor| motor.blocks(span));
        let blocks = Blocks::write(needed, self.encoded_len(), fixed.into_iter().chain(motors), out)?;

        let mut first = None;
        rules::check(&blocks, &mut |_, error| {
            let asked_for = match error {
                MoveError::NoMotors => self.without_motors,
                MoveError::OtherRapidReverse { .. } | MoveError::FloatMoment => true,
                _ => false,
            };
            if !asked_for {
                first.get_or_insert(error);
            }
        });
        match first {
            Some(error) => Err(error),
            None => Ok(TrajectoryData { blocks, tail: &[] }),
        }
    }

    /// Time that the move takes once, in seconds; more than 0.
    fn span(&self) -> Result<f64, MoveError> {
        let span = self.play.move_time();
        let what = match self.play {
            Play::Live(_) => "duration",
            Play::TimeLapse(_) => "delay and exposure",
        };
        let none = MoveError::number(Place::Move, what, Amount::shown(span).0, "is too short for a move");
        if span > 0.0 { Ok(span) } else { Err(none) }
    }
}

/// Number of `Playback` and `TimeLapse` blocks.
const FIXED_BLOCKS: usize = 2;
const FIXED_LEN: usize = block_len(Playback::LAYOUT).saturating_add(block_len(TimeLapse::LAYOUT));
const AXIS_LEN: usize = block_len(Axis::LAYOUT);
const SEGMENT_LEN: usize = block_len(Segment::LAYOUT);

/// Bytes of a block with these fields.
const fn block_len(fields: &[Row]) -> usize {
    let (mut len, mut fields) = (Block::HEADER_LEN, fields);
    while let Some((field, rest)) = fields.split_first() {
        len = len.saturating_add(field.size);
        fields = rest;
    }
    len
}

impl MotorPlan<'_> {
    /// The axis block, then the segment blocks in order. Blocks after an error have no meaning.
    fn blocks(&self, span: f64) -> impl Iterator<Item = Result<Block<'static>, MoveError>> {
        let motor_address = MotorAddress(self.motor.number());
        iter::once(self.axis(motor_address)).chain((0..=u8::MAX).take(self.way.len()).map(move |segment_number| {
            let place = Place::Segment(motor_address, segment_number);
            let points = self.way.points(segment_number, place, span)?;
            Ok(Block::Segment(Segment { motor_address, segment_number, points, tail: &[] }))
        }))
    }

    fn axis(&self, motor_address: MotorAddress) -> Result<Block<'static>, MoveError> {
        let place = Place::Motor(motor_address);
        let segment_count = match u8::try_from(self.way.len()) {
            Ok(count) if count > 0 => count,
            _ => return Err(MoveError::Contradiction { place, what: "way", note: "has no segment" }),
        };
        if let Way::Keys { range, .. } = self.way {
            if !range.0.is_finite() {
                return Err(MoveError::NotFinite { place, what: "range", bits: range.0.to_bits() });
            }
            if range.0 == 0.0 {
                return Err(MoveError::Uncalibrated { motor: motor_address });
            }
        }
        Ok(Block::Axis(Axis { motor_address, segment_count, tail: &[] }))
    }
}

impl Way<'_> {
    /// Number of segments.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self {
            Self::Keys { keys, .. } => keys.len().saturating_sub(1),
            Self::Segments(segments) => segments.len(),
        }
    }

    /// Whether there are no segments, so that the way leads nowhere.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Points of a segment as they are written.
    fn points(&self, number: u8, place: Place, span: f64) -> Result<Points, MoveError> {
        let at = usize::from(number);
        let missing = MoveError::Contradiction { place, what: "segment", note: "is missing" };
        let points = match *self {
            Self::Segments(segments) => rounded(segments.get(at).ok_or(missing)?, 1.0, 1.0),
            Self::Keys { range, keys } => {
                let (Some(from), Some(to)) = (keys.get(at), keys.get(at.saturating_add(1))) else {
                    return Err(missing);
                };
                inside(from, range, place)?;
                inside(to, range, place)?;
                let curve = bezier::Segment::between(from, to).map_err(|_| not_finite(place, from, to))?;
                rounded(&curve, span, range.0.into())
            }
        };
        // Lint tolerates small differences at the ends of the move. This builder meets the ends exactly.
        let Points([begin, .., end]) = points;
        let (first, last) = (number == 0, at.saturating_add(1) == self.len());
        let error = |time: Normalized, note| Err(MoveError::number(place, "points", time.0, note));
        match (begin.time, end.time) {
            (time, _) if first && time != Normalized(0.0) => error(time, rules::LATE),
            (_, time) if last && time != Normalized(1.0) => error(time, rules::EARLY),
            _ => Ok(points),
        }
    }
}

/// Greatest change of a number between 0 and 1 by rounding.
const ROUNDING: f32 = f32::EPSILON;

/// Points in parts of a span and a range, as they are on the wire.
///
/// Rounding keeps the order of numbers, so times stay sorted and equal points stay equal. But two numbers that should
/// be equal and were computed separately may change their order. Such numbers are made equal.
fn rounded(curve: &bezier::Segment, span: f64, range: f64) -> Points {
    let [begin, out, into, end] =
        curve.points().map(|point| Point::new(part(point.time / span), part(point.position / range)));
    let (first, last) = (begin.time.0, end.time.0);
    let not_before = |time: f32, least: f32| if time < least && time + ROUNDING >= least { least } else { time };
    let not_after = |time: f32, most: f32| if time > most && time - ROUNDING <= most { most } else { time };
    let into_time = not_after(into.time.0, last);
    let out_time = not_after(not_before(out.time.0, first), into_time);
    Points([begin, Point::new(out_time, out.position.0), Point::new(into_time, into.position.0), end])
}

/// Part of a whole, as it is on the wire. A number that differs from 0 or 1 only by rounding becomes 0 or 1.
#[expect(clippy::cast_possible_truncation, reason = "rounds to the nearest; the rules report infinite numbers")]
fn part(part: f64) -> f32 {
    let part = part as f32;
    if part.abs() <= ROUNDING {
        0.0
    } else if (part - 1.0).abs() <= ROUNDING {
        1.0
    } else {
        part
    }
}

/// Whether a key frame lies in the range, which is in rotations.
fn inside(key: &Key, range: Rotations, place: Place) -> Result<(), MoveError> {
    let position = Rotations(Amount::shown(key.position).0);
    let outside = MoveError::Outside { place, position, range };
    let inside = (0.0..=1.0).contains(&part(key.position / f64::from(range.0)));
    if inside { Ok(()) } else { Err(outside) }
}

/// Finds the number of two key frames that no curve can have: NaN, infinite, or far beyond any rig.
fn not_finite(place: Place, from: &Key, to: &Key) -> MoveError {
    let numbers = |ease| match ease {
        Ease::Linear => [0.0, 0.0],
        Ease::Flat(part) => [part, 0.0],
        Ease::Handle(handle) => [handle.time, handle.position],
    };
    let ([leave_time, leave_position], [arrive_time, arrive_position]) = (numbers(from.leave), numbers(to.arrive));
    let named = [
        ("time", from.time),
        ("time", to.time),
        ("leave", leave_time),
        ("leave", leave_position),
        ("arrive", arrive_time),
        ("arrive", arrive_position),
    ];
    let mut shown = named.iter().map(|&(what, number)| (what, Amount::shown(number).0));
    let (what, number) = shown.find(|(_, number)| !number.is_finite()).unwrap_or(("handle", f32::INFINITY));
    MoveError::NotFinite { place, what, bits: number.to_bits() }
}
