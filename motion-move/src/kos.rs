//! Moves as trajectories of kOS.
//!
//! ```
//! use kos_proto::message::{Normalized, Seconds};
//! use kos_proto::trajectory::{Delay, LiveMotion, Loop, Play};
//! use motion_move::{Move, kos};
//!
//! let pan = Move::parse("pan.json", r#"{ "move": 1, "name": "Pan", "rate": 24, "axes": [{
//!     "name": "Pan", "unit": "°", "keys": [{ "time": 0, "position": 0 }, { "time": 4, "position": 90 }],
//!     "kos": { "motor": 1, "rotations_per_unit": 0.05, "range": [0, 5] }
//! }] }"#)?;
//! let (repeat, delay, home_speed) = (Loop::Once, Delay::None, Normalized(0.2));
//! let play = Play::Live(LiveMotion { duration: Seconds(4.0), repeat, delay, home_speed });
//! let converted = kos::convert(&pan, play)?;
//! // `data` is the message that uploads the move.
//! assert_eq!(converted.data().blocks.len(), 4);
//! assert!(converted.losses[0].amount < 1e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use kos_proto::message::MotorAddress;
use kos_proto::trajectory::bezier::Segment;
use kos_proto::trajectory::{self, MotorPlan, Plan, Play, Trajectory, TrajectoryData, Way};
use kos_proto::{Host, HostMessage, Owned};
use motion_core::bezier::OutOfRange;
use motion_core::trajectory::{Map, MapError, Range};

use crate::axis::MoveAxis;
use crate::bound::{self, Cubic, Far, NOISE};
use crate::limits::Excess;
use crate::loss::{Loss, LossKind};
use crate::motor::Kos;
use crate::moves::Move;

/// Number of places of a segment at which the place of the greatest difference is sought. Its amount needs no places.
const LOOKS: u32 = 32;
/// Shortest part of a segment that is cut, as a part of the move: a few steps of a number of 32 bits near 1.
const SHORTEST: f64 = 1e-6;

/// Why a move cannot be a trajectory.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No axis has a kOS motor.
    #[error("no axis has a kOS motor: give one a \"kos\" motor in its file")]
    NoMotor,
    /// The duration of the move is 0, or too great.
    #[error("the duration: {0}")]
    Duration(#[from] MapError),
    /// The curve of an axis is too large.
    #[error("axis {axis:?}: {error}")]
    Curve {
        /// Name of the axis.
        axis: String,
        /// The problem.
        #[source]
        error: OutOfRange,
    },
    /// The blocks of the move are not a trajectory.
    #[error(transparent)]
    Plan(#[from] trajectory::MoveError),
}

/// Move as blocks of a trajectory.
#[derive(Clone, Debug)]
pub struct Converted<'a> {
    message: Owned<Host>,
    /// Differences between the move and the trajectory: one for each axis with a kOS motor, one for each axis without, and one
    /// if the duration is rounded.
    pub losses: Vec<Loss>,
    /// Limits that the axes with a kOS motor exceed. The limits of the rig are not known here: see
    /// [`Trajectory::excesses`].
    pub excesses: Vec<Excess<'a>>,
}

impl Converted<'_> {
    /// Blocks of the move, for the message that uploads it.
    #[must_use]
    pub fn data(&self) -> TrajectoryData<'_> {
        match self.message.message() {
            HostMessage::SetTrajectoryData(data) => data,
            // The message was made of such blocks.
            _ => TrajectoryData::default(),
        }
    }
}

/// Converts a move to a trajectory, in which axes without a kOS motor are left out.
///
/// The curves are sent as they are, and only rounded to numbers of 32 bits. The amount of that loss is a bound by closed
/// formulas: the greatest change of a position, and the greatest change of a time multiplied by the greatest speed. Its time
/// is the one with the greatest difference at 32 places of each segment.
///
/// In a time lapse the device advances from photo to photo; the trajectory is the same, over the whole move.
///
/// # Errors
///
/// [`Error`] says why the move cannot be a trajectory.
pub fn convert(subject: &Move, play: Play) -> Result<Converted<'_>, Error> {
    let axes: Vec<(&MoveAxis, Kos)> = subject.axes().iter().filter_map(|axis| Some((axis, axis.kos()?))).collect();
    if axes.is_empty() {
        return Err(Error::NoMotor);
    }
    let time = Map::new(Range::new(0.0, subject.duration()), Range::UNIT)?;
    let mut ways = Vec::new();
    for (axis, kos) in &axes {
        let mapped = bound::whole(axis, subject.duration()).and_then(|segments| {
            let mapped = segments.iter().map(|segment| segment.mapped(&time, &kos.normalized));
            mapped.collect::<Result<Vec<_>, _>>()
        });
        let way = mapped.and_then(|mapped| {
            let planned: Vec<_> = mapped.iter().flat_map(parts).collect();
            Ok((planned.iter().map(in_order).collect::<Result<Vec<_>, _>>()?, planned))
        });
        let (ordered, planned) = way.map_err(|error| Error::Curve { axis: axis.name().to_owned(), error })?;
        ways.push((MotorAddress(kos.motor), ordered, planned));
    }
    let motors: Vec<_> =
        ways.iter().map(|(motor, ordered, _)| MotorPlan { motor: *motor, way: Way::Segments(ordered) }).collect();
    let whole = Plan::new(play, &motors);
    let mut out = vec![0; whole.encoded_len()];
    let data = whole.encode(&mut out)?;

    let trajectory = Trajectory::new(&data)?;
    let mut losses = Vec::new();
    for ((axis, kos), (motor, _, planned)) in axes.iter().zip(&ways) {
        let Some(track) = trajectory.track(*motor) else { continue };
        let sent: Vec<_> = track.segments().collect();
        let Far { amount, time } = apart(planned, &sent);
        let amount = (amount / kos.normalized.scale()).abs() + NOISE * largest(axis);
        losses.push(Loss::of(axis, LossKind::Numbers, amount, time * subject.duration()));
    }
    if let Play::Live(live) = play {
        let late = (f64::from(live.duration.0) - subject.duration()).abs();
        losses.extend((late > 0.0).then(|| Loss::late(subject, LossKind::Duration, late)));
    }
    losses.extend(Loss::left_out(subject, "kOS", |axis| axis.kos().is_some()));
    let message = Owned::new(&HostMessage::from(data)).map_err(trajectory::MoveError::from)?;
    let excesses = subject.excesses().filter(|excess| excess.axis.kos().is_some()).collect();
    Ok(Converted { message, losses, excesses })
}

/// The segment in parts whose handles are in the order of time, as the protocol wants them, from 0 to 1. Where the handles of
/// a segment overlap, it is cut at the place where time runs slowest. If one part would be too short for the protocol, the
/// handles have no order yet.
fn parts(segment: &Segment) -> impl Iterator<Item = Segment> + use<> {
    let [t0, t1, t2, t3] = segment.points().map(|point| point.time);
    let slowest = (t1 - t0 - (t2 - t1)) / (t1 - t0 - 2.0 * (t2 - t1) + (t3 - t2));
    let parts = if t1 > t2 { segment.split(Cubic([t0, t1, t2, t3]).at(slowest)) } else { None };
    let parts = parts.filter(|(before, after)| before.duration().min(after.duration()) > SHORTEST);
    let (first, second) = parts.map_or((*segment, None), |(before, after)| (before, Some(after)));
    [Some(first), second].into_iter().flatten()
}

/// The segment with its handles in the order of time: handles that overlap meet in the middle, and none is beyond an end.
fn in_order(segment: &Segment) -> Result<Segment, OutOfRange> {
    let [start, mut leave, mut arrive, end] = segment.points();
    if leave.time > arrive.time {
        let middle = 0.5 * (leave.time + arrive.time);
        (leave.time, arrive.time) = (middle, middle);
    }
    for handle in [&mut leave, &mut arrive] {
        handle.time = handle.time.max(start.time).min(end.time);
    }
    Segment::new([start, leave, arrive, end])
}

fn largest(axis: &MoveAxis) -> f64 {
    let range = axis.curve().range();
    range.from.abs().max(range.to.abs())
}

/// Bound of the distance between planned and sent segments, in parts of the range, and the part of the move that has the
/// greatest distance at some places.
fn apart(planned: &[Segment], sent: &[Segment]) -> Far {
    let (mut later, mut farther, mut place) = (0.0_f64, 0.0_f64, Far::NONE);
    for (one, other) in planned.iter().zip(sent) {
        for (one, other) in one.points().into_iter().zip(other.points()) {
            later = later.max((one.time - other.time).abs());
            farther = farther.max((one.position - other.position).abs());
        }
        for look in 0..=LOOKS {
            let time = one.start() + one.duration() * f64::from(look) / f64::from(LOOKS);
            place = place.or(Far { amount: (one.position(time) - other.position(time)).abs(), time });
        }
    }
    let (mut change, mut is_steep) = (0.0_f64, false);
    for (most, steep) in planned.iter().map(|segment| bound::change(segment, later)) {
        (change, is_steep) = (change.max(most), is_steep || steep);
    }
    // The time may begin in one segment and end in the next one. By their speeds, they share the change; otherwise not.
    let change = if is_steep { 2.0 * change } else { change };
    Far { amount: farther + change + NOISE, time: place.time }
}

#[cfg(test)]
mod tests {
    use kos_proto::message::{Normalized, Seconds};
    use kos_proto::trajectory::{Delay, LiveMotion, Loop};
    use proptest::prelude::*;

    use super::*;
    use crate::tests::{PAN, SLIDE};
    use crate::write::tests::any_move;

    #[expect(clippy::cast_possible_truncation, reason = "the protocol has 32 bits")]
    fn live(subject: &Move) -> Play {
        let (repeat, delay, home_speed) = (Loop::Once, Delay::None, Normalized(0.1));
        Play::Live(LiveMotion { duration: Seconds(subject.duration() as f32), repeat, delay, home_speed })
    }

    #[test]
    fn the_samples_lose_less_than_a_thousandth_of_a_millimetre_or_degree() {
        for (text, amount) in [(SLIDE, 1e-3), (PAN, 1e-4)] {
            let subject = Move::parse("", text).unwrap();
            let converted = convert(&subject, live(&subject)).unwrap();
            let [loss] = &converted.losses[..] else { panic!("{:?}", converted.losses) };
            assert!(loss.kind == LossKind::Numbers && loss.amount > 0.0 && loss.amount < amount, "{loss}");
            assert!(converted.excesses.is_empty());
        }
    }

    proptest! {
        #[test]
        fn what_is_played_is_within_the_loss(
            subject in any_move().prop_filter("kOS", |subject| subject.axes()[0].kos().is_some()),
            at in prop::collection::vec(0.0..=1.0, 32),
        ) {
            let converted = convert(&subject, live(&subject)).unwrap();
            let data = converted.data();
            let trajectory = Trajectory::new(&data).unwrap();
            let (axis, loss) = (&subject.axes()[0], &converted.losses[0]);
            let kos = axis.kos().unwrap();
            let track = trajectory.track(MotorAddress(kos.motor)).unwrap();
            let keys = axis.keys().iter().map(|key| key.time / subject.duration());
            for part in at.into_iter().chain(keys) {
                let played = kos.normalized.inverse().unwrap().apply(track.at_elapsed(part).unwrap().position);
                let off = (played - axis.curve().position(part * subject.duration())).abs();
                prop_assert!(off <= loss.amount, "{} at {}: {}", off, part, loss);
            }
        }
    }
}
