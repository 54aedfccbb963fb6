//! The builder: a move as people mean it becomes blocks, or an error that says what, where and how much.

use core::iter;

use motion_core::bezier::{self, Ease, Key};
use motion_core::wire::{Message, Row};

use super::blocks::{Axis, Block, Blocks, Playback, Segment, TimeLapse, TrajectoryData};
use super::error::{Amount, MoveError, Place};
use super::play::Play;
use super::rules;
use super::values::{Point, Points};
use crate::message::{Motor, MotorAddress, Normalized, Rotations};

/// A move that is to become blocks: how it is played, and the way of each motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan<'a> {
    play: Play,
    motors: &'a [MotorPlan<'a>],
    without_motors: bool,
}

/// The way of one motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorPlan<'a> {
    /// Which motor, 1 to 10; the mark of focus, iris and zoom is left out when it is written (decision K-M2).
    pub motor: MotorAddress,
    /// Where it goes.
    pub way: Way<'a>,
}

/// Where a motor goes in the time of the move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Way<'a> {
    /// From key frame to key frame: at least two, the first at the begin of the move and the last at its end.
    Keys {
        /// Where the motor's range ends, in rotations from its begin; not 0: see [`Motor::range`].
        range: Rotations,
        /// Times in seconds from the begin of the move, to its [`move_time`](Play::move_time); positions in rotations
        /// from the begin of the range, as commands count.
        keys: &'a [Key],
    },
    /// Curves in parts of the move and of the range, each from 0 to 1.
    Segments(&'a [bezier::Segment]),
}

impl<'a> MotorPlan<'a> {
    /// The way of a motor that the device told of, from key frame to key frame.
    ///
    /// # Errors
    ///
    /// [`MoveError::Uncalibrated`], if its range is not known.
    pub fn new(motor: &Motor, keys: &'a [Key]) -> Result<Self, MoveError> {
        let (motor, range) = (motor.motor_address, motor.range());
        let range = range.ok_or(MoveError::Uncalibrated { motor })?;
        Ok(Self { motor, way: Way::Keys { range, keys } })
    }
}

impl<'a> Plan<'a> {
    /// Bytes that the blocks of any move fit into.
    pub const MAX_LEN: usize = FIXED_LEN + AXIS_LEN + (Blocks::MAX - FIXED_BLOCKS - 1) * SEGMENT_LEN;

    /// A move of motors.
    #[must_use]
    pub const fn new(play: Play, motors: &'a [MotorPlan<'a>]) -> Self {
        Self { play, motors, without_motors: false }
    }

    /// A move in which nothing moves but the shutter.
    ///
    /// The specification wants a motor, so a strict device refuses it, and lint does (decision K-J1).
    #[must_use]
    pub const fn without_motors(play: Play) -> Self {
        Self { play, motors: &[], without_motors: true }
    }

    /// How it is played.
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

    /// Writes the blocks to the front of `out`, and lends them from there.
    ///
    /// What it writes, lint finds nothing in: but for a time of its own for the way back, for a moment as IEEE number,
    /// and for a move without motors, which all have to be asked for.
    ///
    /// # Errors
    ///
    /// [`MoveError`], if there are too many blocks, they do not fit, or they would be no move. Then what stands in `out`
    /// has no meaning.
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

    /// Seconds that the move takes once, more than 0.
    fn span(&self) -> Result<f64, MoveError> {
        let span = self.play.move_time();
        let what = match self.play {
            Play::Live(_) => "duration",
            Play::TimeLapse(_) => "delay and exposure",
        };
        let none = MoveError::number(Place::Move, what, Amount::shown(span).0, "is no time for a move");
        if span > 0.0 { Ok(span) } else { Err(none) }
    }
}

/// `Playback` and `TimeLapse`.
const FIXED_BLOCKS: usize = 2;
const FIXED_LEN: usize = block_len(Playback::LAYOUT).saturating_add(block_len(TimeLapse::LAYOUT));
const AXIS_LEN: usize = block_len(Axis::LAYOUT);
const SEGMENT_LEN: usize = block_len(Segment::LAYOUT);

/// Bytes of a block of these fields.
const fn block_len(fields: &[Row]) -> usize {
    let (mut len, mut fields) = (Block::HEADER_LEN, fields);
    while let Some((field, rest)) = fields.split_first() {
        len = len.saturating_add(field.size);
        fields = rest;
    }
    len
}

impl MotorPlan<'_> {
    /// Its axis, and its segments one behind the other; what comes after an error has no meaning.
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
    /// How many segments it has.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self {
            Self::Keys { keys, .. } => keys.len().saturating_sub(1),
            Self::Segments(segments) => segments.len(),
        }
    }

    /// Whether it has none, and so goes nowhere.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The points of a segment as they are written.
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
        // Lint takes a little less or more for the ends of the move; what is made here meets them.
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

/// What rounding may do to a number between 0 and 1.
const ROUNDING: f32 = f32::EPSILON;

/// The points in parts of a span and a range, as the wire has them.
///
/// Rounding keeps the order of numbers, so times stay sorted, and equal points equal. But two that should be equal, and
/// were computed apart, may come out in turn; then they are made equal.
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

/// A part of a whole, as the wire has it; what is beside 0 or 1 by rounding alone is 0 or 1.
#[expect(clippy::cast_possible_truncation, reason = "rounds to the nearest; the rules find what is infinite")]
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

/// Whether a key frame lies in the range, said in rotations.
fn inside(key: &Key, range: Rotations, place: Place) -> Result<(), MoveError> {
    let position = Rotations(Amount::shown(key.position).0);
    let outside = MoveError::Outside { place, position, range };
    let inside = (0.0..=1.0).contains(&part(key.position / f64::from(range.0)));
    if inside { Ok(()) } else { Err(outside) }
}

/// Which number of two key frames no curve can have: an infinite one, none at all, or one beyond all rigs.
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
