//! Reader: the meaning of the blocks of a move, and the positions of its motors at any time.

use core::fmt;

use motion_core::bezier::{self, Ease, Key, Motion, Point};
use motion_core::lint::Severity;

use super::blocks::{Axis, Blocks, Segment, TrajectoryData};
use super::error::{Amount, MoveError, Place};
use super::limits::{Excess, Limits, Peaks};
use super::play::{Play, Style, TimeLapseMotion};
use super::rules;
use super::values::Points;
use crate::lint::Context;
use crate::message::{MotorAddress, MotorSet, Rotations};

/// Move that was read from blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Trajectory<'a> {
    blocks: Blocks<'a>,
    play: Play,
}

impl<'a> Trajectory<'a> {
    /// Reads a move from blocks in any order.
    ///
    /// A move on which lint only has warnings is accepted, and so is a move without motors.
    ///
    /// # Errors
    ///
    /// [`MoveError`] if lint finds an error in the blocks, or if the specification does not name the kind of move or of
    /// delay.
    pub fn new(data: &TrajectoryData<'a>) -> Result<Self, MoveError> {
        let blocks = data.blocks;
        let mut first = None;
        rules::check(&blocks, &mut |severity, error| {
            if severity == Severity::Error && error != MoveError::NoMotors {
                first.get_or_insert(error);
            }
        });
        if let Some(error) = first {
            return Err(error);
        }
        let missing = |what| MoveError::Contradiction { place: Place::Move, what, note: "is missing" };
        let playback = blocks.playbacks().next().ok_or(missing("playback"))?;
        let time_lapse = blocks.time_lapses().next().ok_or(missing("time_lapse"))?;
        Ok(Self { blocks, play: Play::read(&playback, &time_lapse)? })
    }

    /// Settings for playing the move.
    #[must_use]
    pub const fn play(&self) -> Play {
        self.play
    }

    /// Motors that take part.
    pub(crate) fn motors(&self) -> MotorSet {
        MotorSet::of(self.blocks.axes().map(|axis| axis.motor_address))
    }

    /// Motors and their ways, in the order of their blocks.
    pub fn tracks(&self) -> impl Iterator<Item = Track<'a>> + use<'a> {
        let Self { blocks, play } = *self;
        blocks.axes().map(move |Axis { motor_address: motor, segment_count, .. }| Track {
            blocks,
            motor,
            segment_count,
            move_time: play.move_time(),
            range: 1.0,
            span: 1.0,
        })
    }

    /// Parts of the move that the motors cannot do, according to their known limits and those of the axes that they
    /// drive.
    ///
    /// The speeds of a time lapse follow from its estimated time. They are not checked if the motors stop for each
    /// photo, because the specification does not say how long the motors take between photos. They are also not checked
    /// if the time lapse takes no time.
    pub fn excesses<'m>(&self, known: &Context<'m>) -> impl Iterator<Item = Excess> + use<'a, 'm> {
        let known = *known;
        let stops = matches!(self.play, Play::TimeLapse(TimeLapseMotion { style: Style::ShootMoveShoot, .. }));
        self.tracks().flat_map(move |track| {
            let measured = track.measured(&known);
            let moving = measured.ok().flatten().filter(|_| !stops);
            let excesses = moving.map(|(track, limits)| track.excesses(limits));
            measured.err().into_iter().chain(excesses.into_iter().flatten())
        })
    }

    /// Way of one motor; `None` if the motor does not take part in the move.
    #[must_use]
    pub fn track(&self, motor: MotorAddress) -> Option<Track<'a>> {
        self.tracks().find(|track| track.motor.number() == motor.number())
    }
}

/// Way of a motor.
///
/// Times and positions are parts of the move and of the motor's range, each from 0 to 1, unless the track was converted
/// to seconds and rotations by [`in_rotations`](Self::in_rotations).
#[derive(Clone, Copy, PartialEq)]
pub struct Track<'a> {
    blocks: Blocks<'a>,
    motor: MotorAddress,
    segment_count: u8,
    /// Time of the move, in seconds.
    move_time: f64,
    /// Position that belongs to 1.
    range: f64,
    /// Time that belongs to 1.
    span: f64,
}

impl<'a> Track<'a> {
    /// Motor address.
    #[must_use]
    pub const fn motor(&self) -> MotorAddress {
        self.motor
    }

    /// Number of segments.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.segment_count as usize
    }

    /// Whether there are no segments. Then the motor takes part in the move, but its position is not known.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.segment_count == 0
    }

    /// Same way in seconds from the start of the move, and in rotations from the begin of the motor's range, which ends
    /// at `range`. See [`Motor::range`](crate::message::Motor::range).
    ///
    /// The seconds of a time lapse are an estimate. See [`Play::move_time`].
    ///
    /// # Errors
    ///
    /// [`MoveError`] if the range is 0, NaN or infinite, or if the time lapse takes no time.
    pub fn in_rotations(self, range: Rotations) -> Result<Self, MoveError> {
        let place = Place::Motor(self.motor);
        if !range.0.is_finite() {
            return Err(MoveError::NotFinite { place, what: "range", bits: range.0.to_bits() });
        }
        if range.0 == 0.0 {
            return Err(MoveError::Uncalibrated { motor: self.motor });
        }
        if self.move_time <= 0.0 {
            return Err(MoveError::number(Place::Move, "delay and exposure", 0.0, "is too short for a move"));
        }
        Ok(Self { range: range.0.into(), span: self.move_time, ..self })
    }

    /// Position, speed and acceleration of the motor at a time on the way forward; `None` if there are no segments.
    ///
    /// Before the first segment and after the last one the motor rests at their ends. For the time in a move with
    /// loops, see [`Play::elapsed_at`]. Each call searches the blocks once. For many times,
    /// [`segments`](Self::segments) gives the curves.
    #[must_use]
    pub fn at(&self, time: f64) -> Option<Motion> {
        self.at_elapsed(time / self.span)
    }

    /// Position, speed and acceleration at an elapsed part of the move, 0 to 1, as in `PlaybackStatus` and
    /// [`Play::elapsed_at`]. Otherwise like [`at`](Self::at).
    #[must_use]
    pub fn at_elapsed(&self, elapsed: f64) -> Option<Motion> {
        let begun = |segment: &Segment<'_>| {
            let Points([begin, ..]) = segment.points;
            f64::from(begin.time.0) <= elapsed
        };
        let number = |segment: &Segment<'_>| segment.segment_number;
        let last = self.numbered().filter(begun).max_by_key(number);
        let segment = last.or_else(|| self.numbered().min_by_key(number))?;
        let motion = segment.points.curve().ok()?.at(elapsed);
        Some(Motion {
            position: motion.position * self.range,
            velocity: finite(motion.velocity, self.range / self.span),
            acceleration: finite(motion.acceleration, self.range / self.span / self.span),
        })
    }

    /// Curves in order, in parts of the move and of the range.
    ///
    /// For each curve, at most 255 blocks are searched.
    pub fn segments(&self) -> impl Iterator<Item = bezier::Segment> + use<'a> {
        let track = *self;
        (0..self.segment_count).filter_map(move |number| {
            let segment = track.numbered().find(|segment| segment.segment_number == number)?;
            segment.points.curve().ok()
        })
    }

    /// Key frames with their handles: one more than segments, or none without segments.
    pub fn keys(&self) -> impl Iterator<Item = Key> + use<'a> {
        let track = *self;
        let mut segments = self.segments();
        let mut reached: Option<Key> = None;
        core::iter::from_fn(move || {
            let Some(curve) = segments.next() else { return reached.take() };
            let (from, to) = curve.keys();
            let arrive = reached.map_or(Ease::Linear, |key| key.arrive);
            reached = Some(track.scaled(to));
            Some(Key { arrive, ..track.scaled(from) })
        })
    }

    /// Greatest speed and acceleration of each segment.
    ///
    /// Jumps of the speed between segments or at the start of the move are not included. No motor can follow such a
    /// jump at once.
    pub fn peaks(&self) -> impl Iterator<Item = Peaks> + use<'a> {
        let (range, span) = (self.range.abs(), self.span);
        self.segments().zip(0..=u8::MAX).map(move |(curve, segment)| Peaks {
            segment,
            speed: finite(curve.peak_velocity(), range / span),
            acceleration: finite(curve.peak_acceleration(), range / span / span),
        })
    }

    /// Segments whose speed or acceleration exceeds these limits.
    pub fn excesses(&self, limits: Limits) -> impl Iterator<Item = Excess> + use<'a> {
        let motor = self.motor;
        self.peaks().flat_map(move |peaks| limits.exceeded(motor, peaks))
    }

    /// Way in rotations, and the limits of its motor; `None` if the move takes no time, because then it has no speed.
    fn measured(self, known: &Context<'_>) -> Result<Option<(Self, Limits)>, Excess> {
        let motor = self.motor;
        let found = known.motor(motor).ok_or(Excess::Absent { motor })?;
        let limits = known.kind(motor).map_or(found.into(), |kind| Limits::from(found).and(kind.into()));
        let range = found.range().filter(|range| range.0.is_finite() && range.0 != 0.0);
        let range = range.ok_or(Excess::Uncalibrated { motor })?;
        Ok(self.in_rotations(range).ok().map(|track| (track, limits)))
    }

    /// Segments of this motor, in the order of their blocks.
    fn numbered(&self) -> impl Iterator<Item = Segment<'a>> + use<'a> {
        self.blocks.segments_of(self.motor)
    }

    fn scaled(&self, key: Key) -> Key {
        let point = |Point { time, position }| Point::new(time * self.span, position * self.range);
        let ease = |ease| if let Ease::Handle(handle) = ease { Ease::Handle(point(handle)) } else { ease };
        let Point { time, position } = point(Point::new(key.time, key.position));
        Key { time, position, arrive: ease(key.arrive), leave: ease(key.leave) }
    }
}

// The printing of `f64` in core cannot be proven free of panics.
impl fmt::Debug for Track<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Track")
            .field("motor", &self.motor)
            .field("segment_count", &self.segment_count)
            .field("range", &Amount::shown(self.range))
            .field("span", &Amount::shown(self.span))
            .finish_non_exhaustive()
    }
}

/// Rate in other units; `None` if it is infinite or too great for a number.
fn finite(rate: Option<f64>, unit: f64) -> Option<f64> {
    rate.map(|rate| rate * unit).filter(|rate| rate.is_finite())
}
