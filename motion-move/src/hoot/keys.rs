//! Moves as key frames of later firmware.

use hoot_proto::Address;
use hoot_proto::beyond::{
    Axis, HostMessage, KeyEnd, KeyPosition, KeySetAxis, KeySetCount, KeySetPosition, KeySetTime, KeySetVelocity,
    KeyTime, KeyVelocity,
};
use hoot_proto::message::Motor;
use motion_core::bezier::{Motion, Point, Segment};
use motion_core::trajectory;

use super::Error;
use crate::axis::MoveAxis;
use crate::bound::{self, Far, NOISE, change};
use crate::limits::Excess;
use crate::loss::{Loss, LossKind};
use crate::moves::Move;

/// Number of parts of a piece at whose ends it is compared with the curve.
const LOOKS: u32 = 64;
/// Greatest change of a number by rounding to 32 bits, as a part of it.
const ROUNDING: f64 = f32::EPSILON as f64 / 2.0;
/// Milliseconds of a second.
const MS: f64 = 1000.0;

/// Choices for [`key_frames()`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeyOptions {
    /// Distance from the curve that needs no further key frame, in steps.
    pub tolerance: f64,
    /// Greatest number of key frames of an axis. More than the move has are made only up to this number. How many a node
    /// can store is not published.
    pub most: u16,
    /// The node whose motors get key frames; `None` for all nodes.
    pub node: Option<Address>,
}

impl Default for KeyOptions {
    /// A tolerance of one step, at most 20 key frames, all nodes.
    fn default() -> Self {
        Self { tolerance: 1.0, most: 20, node: None }
    }
}

/// Key frame as it is sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knot {
    /// Time, in milliseconds of the video.
    pub time: f32,
    /// Position, in steps.
    pub position: f32,
    /// Velocity, in steps per millisecond.
    pub velocity: f32,
}

/// Key frames of a motor.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisKeys {
    /// Address of the node.
    pub node: Address,
    /// The motor.
    pub motor: Motor,
    /// Key frames, at least two, the first at the start of the move and the last at its end.
    pub keys: Vec<Knot>,
}

impl AxisKeys {
    /// Position at a time in milliseconds, in steps: between key frames the cubic with their positions and velocities.
    #[must_use]
    pub fn position(&self, time: f64) -> f64 {
        let after = self.keys.partition_point(|key| f64::from(key.time) <= time);
        let before = after.checked_sub(1).and_then(|index| self.keys.get(index));
        match (before, self.keys.get(after)) {
            (Some(from), Some(to)) => {
                let [t0, p0, v0] = [from.time, from.position, from.velocity].map(f64::from);
                let [t1, p1, v1] = [to.time, to.position, to.velocity].map(f64::from);
                cubic([t0, t1], [p0, p1], [v0, v1]).at((time - t0) / (t1 - t0))
            }
            (Some(key), None) | (None, Some(key)) => key.position.into(),
            (None, None) => 0.0,
        }
    }

    /// Messages that store the key frames in the node, in the order in which they are sent. Firmware of the published sheet
    /// does not know them.
    pub fn messages(&self) -> impl Iterator<Item = HostMessage<'static>> {
        let axis = match self.motor {
            Motor::One => 0,
            Motor::Two => 1,
            Motor::Three => 2,
        };
        let count = i16::try_from(self.keys.len()).unwrap_or(i16::MAX);
        let head = [KeySetAxis { axis: Axis(axis) }.into(), KeySetCount { count }.into()];
        let keys = self.keys.iter().flat_map(|key| {
            [
                KeySetTime { time: KeyTime(key.time) }.into(),
                KeySetPosition { position: KeyPosition(key.position) }.into(),
                KeySetVelocity { velocity: KeyVelocity(key.velocity) }.into(),
            ]
        });
        head.into_iter().chain(keys).chain([KeyEnd {}.into()])
    }
}

/// Key frames of one or more nodes, and what they lose.
#[derive(Debug, Clone)]
pub struct KeyFrames<'a> {
    /// Key frames of each motor, in the order of the axes.
    pub axes: Vec<AxisKeys>,
    /// Differences between the move and the key frames: one for each motor, and one for each axis that is left out.
    pub losses: Vec<Loss>,
    /// Limits that the curves exceed.
    pub excesses: Vec<Excess<'a>>,
}

/// Converts a move to key frames of later firmware, in which axes without a motor of the nodes are left out.
///
/// Between key frames the firmware follows the cubic that has their positions and velocities. Smooth and straight eases are
/// such cubics. For other eases, and at corners, where a key frame would need two velocities, key frames are added until the
/// distance is within the tolerance, or there are as many as allowed.
///
/// The loss is exact, except for rounding, where the curve is such a cubic. Otherwise it is a bound: the greatest distance
/// at 65 places from key frame to key frame, and what both curves can move between these places by their greatest
/// acceleration or speed. The firmware sets the speed of a motor some times a second; what that loses is not known.
///
/// # Errors
///
/// [`Error`] says why there are no such key frames.
pub fn key_frames(subject: &Move, options: KeyOptions) -> Result<KeyFrames<'_>, Error> {
    let motor = |axis: &MoveAxis| axis.hoot().filter(|hoot| options.node.is_none_or(|node| node.0 == hoot.address));
    let (mut axes, mut losses) = (Vec::new(), Vec::new());
    for axis in subject.axes() {
        let Some(hoot) = motor(axis) else { continue };
        let number = Motor::new(hoot.motor).ok_or_else(|| Error::Motor { axis: axis.name().to_owned() })?;
        let long = Error::Long { axis: axis.name().to_owned() };
        let scaled = scaled(axis, subject.duration()).ok_or(long.clone())?;
        let (keys, Far { amount, time }) = fitted(&scaled, axis, &options).ok_or(long)?;
        losses.push(Loss::of(axis, LossKind::KeyFrames, amount / hoot.scale.per_unit().abs(), time / MS));
        axes.push(AxisKeys { node: Address(hoot.address), motor: number, keys });
    }
    if axes.is_empty() {
        return Err(Error::NoMotor(options.node));
    }
    losses.extend(Loss::left_out(subject, "hoot", |axis| motor(axis).is_some()));
    let excesses = subject.excesses().filter(|excess| motor(excess.axis).is_some()).collect();
    Ok(KeyFrames { axes, losses, excesses })
}

/// The whole axis in milliseconds and steps, not rounded.
fn scaled(axis: &MoveAxis, duration: f64) -> Option<Vec<Segment>> {
    let scale = axis.hoot()?.scale;
    let place = |at: Point| Point::new(at.time * MS, at.position * scale.per_unit() + scale.offset());
    let segments = bound::whole(axis, duration).ok()?;
    segments.iter().map(|segment| Segment::new(segment.points().map(place)).ok()).collect()
}

/// The key frames of an axis, and their greatest distance from it in steps.
fn fitted(segments: &[Segment], axis: &MoveAxis, options: &KeyOptions) -> Option<(Vec<Knot>, Far)> {
    let curve = trajectory::Axis::new(segments, axis.unit()).ok()?;
    let mut times: Vec<f64> = segments.iter().map(Segment::start).chain([curve.end()]).collect();
    let mut pieces: Vec<Far> = pairs(&times).map(|(from, to)| apart(segments, from, to)).collect();
    while times.len() < options.most.into() {
        let worst = (0..pieces.len()).max_by(|one, other| amount(&pieces, *one).total_cmp(&amount(&pieces, *other)))?;
        let (from, to) = (*times.get(worst)?, *times.get(worst.checked_add(1)?)?);
        // Half a millisecond is the shortest piece: nothing follows it.
        if amount(&pieces, worst) <= options.tolerance || to - from < 1.0 {
            break;
        }
        let middle = 0.5 * (from + to);
        times.insert(worst.checked_add(1)?, middle);
        pieces.splice(worst..=worst, [apart(segments, from, middle), apart(segments, middle, to)]);
    }
    let far = pieces.iter().fold(Far::NONE, |far, piece| far.or(*piece));
    let range = curve.range();
    let largest = range.from.abs().max(range.to.abs());
    // Rounding moves each key frame, and a time or a velocity moves the curve as far as it goes at its speed.
    let knots: Vec<Knot> = times.iter().map(|&time| knot(segments, time)).collect();
    let speed = pairs(&times).map(|(from, to)| piece(segments, from, to).1).fold(0.0, f64::max);
    let rounding = ROUNDING * (largest + 2.0 * speed * curve.end()) + NOISE * largest.max(1.0);
    Some((knots, Far { amount: far.amount + rounding, ..far }))
}

fn amount(pieces: &[Far], index: usize) -> f64 {
    pieces.get(index).map_or(0.0, |piece| piece.amount)
}

fn pairs(times: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    times.iter().copied().zip(times.iter().copied().skip(1))
}

/// Position and velocity of a curve at a time. At a corner, the velocity is the mean of both sides, and at a vertical tangent it
/// is 0.
fn place(segments: &[Segment], time: f64) -> (f64, f64) {
    let touching = segments.iter().filter(|segment| segment.start() <= time && time <= segment.end());
    let (mut position, mut sum, mut count) = (0.0, 0.0, 0.0);
    for Motion { position: at, velocity, .. } in touching.map(|segment| segment.at(time)) {
        (position, sum, count) = (at, sum + velocity.unwrap_or(0.0), count + 1.0);
    }
    (position, if count > 0.0 { sum / count } else { 0.0 })
}

#[expect(clippy::cast_possible_truncation, reason = "the protocol has numbers of 32 bits")]
fn knot(segments: &[Segment], time: f64) -> Knot {
    let (position, velocity) = place(segments, time);
    Knot { time: time as f32, position: position as f32, velocity: velocity as f32 }
}

/// The cubic from one key frame to the next, over the part of the time between them.
fn cubic([t0, t1]: [f64; 2], [p0, p1]: [f64; 2], [v0, v1]: [f64; 2]) -> bound::Cubic {
    let third = (t1 - t0) / 3.0;
    bound::Cubic([p0, p0 + v0 * third, p1 - v1 * third, p1])
}

/// The cubic between two times, its greatest speed and its greatest acceleration.
fn piece(segments: &[Segment], from: f64, to: f64) -> (bound::Cubic, f64, f64) {
    let ((p0, v0), (p1, v1)) = (place(segments, from), place(segments, to));
    let cubic = cubic([from, to], [p0, p1], [v0, v1]);
    let bound::Cubic([d0, d1, d2, d3]) = cubic;
    let (length, ways) = (to - from, [d1 - d0, d2 - d1, d3 - d2]);
    // The control points of velocity and acceleration are bounds of them.
    let speed = ways.map(|way| (3.0 * way / length).abs()).into_iter().fold(0.0, f64::max);
    let [w0, w1, w2] = ways;
    let push = (6.0 * (w1 - w0).abs().max((w2 - w1).abs())) / (length * length);
    (cubic, speed, push)
}

/// The exact difference, if time is even along the curve too, as with handles of one third.
fn difference(curve: &Segment, cubic: &bound::Cubic) -> Option<bound::Cubic> {
    let ([p0, p1, p2, p3], bound::Cubic([d0, d1, d2, d3])) = (curve.points(), *cubic);
    let third = curve.duration() / 3.0;
    let is_even = |from: Point, to: Point| (to.time - from.time - third).abs() <= NOISE * to.time.abs();
    let is_cubic = is_even(p0, p1) && is_even(p1, p2) && is_even(p2, p3);
    is_cubic.then_some(bound::Cubic([p0.position - d0, p1.position - d1, p2.position - d2, p3.position - d3]))
}

/// Bound of the distance between the curve and the cubic from one time to another.
fn apart(segments: &[Segment], from: f64, to: f64) -> Far {
    let (cubic, speed, push) = piece(segments, from, to);
    let Some(curve) = segments.iter().find(|segment| segment.start() <= from && to <= segment.end()) else {
        return Far { amount: f64::INFINITY, time: from };
    };
    let part = bound::between(curve, from, to);
    if let Some(apart) = difference(&part, &cubic) {
        let (amount, u) = apart.farthest(0.0, 1.0);
        return Far { amount, time: from + (to - from) * u };
    }
    let mut far = Far { time: from, ..Far::NONE };
    for look in 0..=LOOKS {
        let u = f64::from(look) / f64::from(LOOKS);
        let time = from + (to - from) * u;
        far = far.or(Far { amount: (curve.position(time) - cubic.at(u)).abs(), time });
    }
    let step = (to - from) / f64::from(LOOKS);
    let by_speed = change(&part, 0.5 * step).0 + speed * 0.5 * step;
    let between = match part.peak_acceleration() {
        Some(most) => by_speed.min((most + push) * step * step / 8.0),
        None => by_speed,
    };
    Far { amount: far.amount + between, ..far }
}
