//! Moves as programs of an NMX, and as key frames of its later firmware.
//!
//! A program has one planned move for each motor: two positions, a time, an easing, and lengths of acceleration and
//! deceleration. It cannot follow any curve. [`convert`] finds the planned move that is nearest to each axis, and reports how
//! far it is away; the caller decides whether that is near enough. Two smooth key frames, which are the default of a move
//! file, are exact except for whole steps: their speed is a parabola, and an inverse quadratic easing that accelerates for
//! half of the time and decelerates for the other half has the same speed.
//!
//! Later firmware has key frames, see [`key_frames()`].
//!
//! ```
//! use motion_move::hoot::{self, Options};
//! use motion_move::Move;
//!
//! let pan = Move::parse("pan.json", r#"{ "move": 1, "name": "Pan", "rate": 24, "axes": [{
//!     "name": "Pan", "unit": "°", "keys": [{ "time": 0, "position": 0 }, { "time": 4, "position": 90 }],
//!     "hoot": { "motor": 1, "steps_per_unit": 100 }
//! }] }"#)?;
//! let converted = hoot::convert(&pan, Options::default())?;
//! assert_eq!(converted.planned[0].plan.travel.0, 4000);
//! // One step is a hundredth of a degree.
//! assert!(converted.losses[0].amount < 0.0102);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod fit;
mod keys;

use hoot_proto::message::{
    Easing, Motor, MotorSetEasing, MotorSetLeadIn, MotorSetLeadInLong, MotorSetProgramAcceleration,
    MotorSetProgramDeceleration, MotorSetProgramStart, MotorSetProgramStop, MotorSetTravel, ShortSpan, Span,
};
use hoot_proto::program::Plan;
use hoot_proto::{Address, HostMessage};
use motion_core::trajectory::StepsOutOfRange;

use crate::axis::MoveAxis;
use crate::bound::{self, Far, NOISE};
use crate::limits::{Excess, ExcessKind};
use crate::loss::{Loss, LossKind};
use crate::motor::Hoot;
use crate::moves::Move;
use fit::{counts, share};

pub use keys::{AxisKeys, KeyFrames, KeyOptions, Knot, key_frames};

/// Greatest number of counts at which a planned move is compared with its curve.
const LOOKS: u32 = 1 << 16;
/// Tolerance of the speed of a planned move, as a part of the limit, because its ramps are whole counts.
const TOLERANCE: f64 = 1e-3;

/// Unit of the time of a planned move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Count {
    /// Milliseconds.
    #[default]
    Video,
    /// Photos: this number, spread over the whole move. Motors rest while photos are taken.
    Shots(u32),
    /// Photos at an interval in milliseconds: this number, spread over the whole move. Motors move meanwhile, so the travel is
    /// in milliseconds, and only the lead-in is in photos (decision H-43).
    Lapse {
        /// Number of photos.
        shots: u32,
        /// Interval.
        interval: u32,
    },
}

/// Choices for [`convert`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// Unit of the time.
    pub count: Count,
    /// Whether the move is planned from its end to its start.
    pub reverse: bool,
    /// The node whose motors are planned; `None` for all nodes.
    pub node: Option<Address>,
}

/// Why a move cannot be a program. A curve that no planned move follows is a loss, not an error.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No axis has a motor of an NMX, or of this node.
    #[error("no axis has a motor of {}", .0.map_or("an NMX".to_owned(), |node| format!("node {}", node.0)))]
    NoMotor(Option<Address>),
    /// A time of an axis does not fit into a program.
    #[error("axis {axis:?}: it is too long: the limit is 16,777,215 ms or photos")]
    Long {
        /// Name of the axis.
        axis: String,
    },
    /// A position does not fit.
    #[error("axis {axis:?}: {error}: use fewer steps per unit")]
    Steps {
        /// Name of the axis.
        axis: String,
        /// Number of steps.
        #[source]
        error: StepsOutOfRange,
    },
    /// The number of the motor is not from 1 to 3.
    #[error("axis {axis:?}: hoot has motors 1 to 3")]
    Motor {
        /// Name of the axis.
        axis: String,
    },
    /// The lead-in does not fit the 16 bits that older firmware reads.
    #[error(
        "the lead-in of motor {motor} is {lead_in}, but older firmware allows at most 65535: let the axis start earlier"
    )]
    LeadIn {
        /// The motor.
        motor: Motor,
        /// Its lead-in.
        lead_in: u32,
    },
}

/// Planned move of a motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Planned {
    /// Address of the node.
    pub node: Address,
    /// The motor.
    pub motor: Motor,
    /// The planned move.
    pub plan: Plan,
    /// Time to wait before the move, in milliseconds in video mode, otherwise in photos.
    pub lead_in: u32,
    /// Greatest distance of the planned move from the curve between both ends of each, at 128 places, in steps.
    pub deviation: f64,
}

impl Planned {
    /// Greatest distance from one count to the next, in steps. If counts are milliseconds, it is a thousandth of the speed.
    ///
    /// The distance is an average over several counts, because positions are whole steps.
    #[must_use]
    pub fn peak(&self) -> f64 {
        let span = (self.plan.travel.0 / 50).max(1);
        let places = (0..=self.plan.travel.0.checked_div(span).unwrap_or(0))
            .map(|at| f64::from(self.plan.at(at.saturating_mul(span)).0));
        let ways = places.clone().zip(places.skip(1)).map(|(one, next)| (next - one).abs());
        ways.fold(0.0, f64::max) / f64::from(span)
    }

    /// Longest way from one photo to the next, in steps.
    #[must_use]
    pub fn longest(&self) -> u32 {
        let places = (0..=self.plan.travel.0).map(|at| self.plan.at_shot(at).0);
        let ways = places.clone().zip(places.skip(1)).map(|(one, next)| one.abs_diff(next));
        ways.max().unwrap_or(0)
    }

    /// Makes the travel longer, with its ramps in proportion.
    pub fn stretch(&mut self, more: u32) {
        let before = self.plan.travel.0.max(1);
        let after = before.saturating_add(more);
        for span in [&mut self.plan.travel, &mut self.plan.acceleration, &mut self.plan.deceleration] {
            span.0 = share(after, span.0, before);
        }
    }

    /// Messages that store the planned move in the node. `long_lead_in` says whether its firmware reads a lead-in of 32 bits.
    ///
    /// # Errors
    ///
    /// [`Error::LeadIn`] if the lead-in needs more bits than the firmware reads.
    pub fn messages(&self, long_lead_in: bool) -> Result<[HostMessage<'static>; 7], Error> {
        let Self { motor, plan, lead_in, .. } = *self;
        let lead_in = if long_lead_in {
            MotorSetLeadInLong { motor, lead_in: Span(lead_in) }.into()
        } else {
            let short = u16::try_from(lead_in).map_err(|_| Error::LeadIn { motor, lead_in })?;
            MotorSetLeadIn { motor, lead_in: ShortSpan(short) }.into()
        };
        Ok([
            MotorSetProgramStart { motor, position: plan.start }.into(),
            MotorSetProgramStop { motor, position: plan.stop }.into(),
            MotorSetTravel { motor, travel: plan.travel }.into(),
            MotorSetProgramAcceleration { motor, acceleration: plan.acceleration }.into(),
            MotorSetProgramDeceleration { motor, deceleration: plan.deceleration }.into(),
            MotorSetEasing { motor, easing: plan.easing }.into(),
            lead_in,
        ])
    }

    /// The same move from its end to its start. `all` is the length of the whole move, in counts.
    fn reversed(self, all: u32) -> Self {
        let Plan { start, stop, travel, acceleration, deceleration, easing, .. } = self.plan;
        let plan =
            Plan { start: stop, stop: start, travel, acceleration: deceleration, deceleration: acceleration, easing };
        Self { plan, lead_in: all.saturating_sub(self.lead_in).saturating_sub(travel.0), ..self }
    }

    /// Ramps as they are played, and the speed between them in steps per count.
    fn speed(&self) -> (f64, f64, f64) {
        let Plan { start, stop, travel, acceleration, deceleration, easing, .. } = self.plan;
        let [travel, gain, lose] = [travel, acceleration, deceleration].map(|span| f64::from(span.0));
        let cut = (travel / (gain + lose).max(1.0)).min(1.0);
        let (gain, lose) = (gain * cut, lose * cut);
        // Part of full speed that a ramp has on average.
        let part = match easing {
            Easing::QUADRATIC => 1.0 / 3.0,
            Easing::INVERSE_QUADRATIC => 2.0 / 3.0,
            _ => 0.5,
        };
        (gain, lose, f64::from(stop.0.abs_diff(start.0)) / (travel - (gain + lose) * (1.0 - part)).max(1.0))
    }
}

/// Time of the counts of a program.
struct Clock {
    /// Seconds of a count of the lead-in.
    seconds: f64,
    /// Number of counts of the travel in that time.
    counts_of_travel: u32,
    by_shots: bool,
}

impl Clock {
    fn new(subject: &Move, count: Count) -> Self {
        let photo = |shots: u32| subject.duration() / f64::from(shots.saturating_sub(1).max(1));
        let (seconds, counts_of_travel) = match count {
            Count::Video => (0.001, 1),
            Count::Shots(shots) => (photo(shots), 1),
            Count::Lapse { shots, interval } => (photo(shots), interval.max(1)),
        };
        Self { seconds, counts_of_travel, by_shots: matches!(count, Count::Shots(_)) }
    }

    /// Seconds of a count of the travel.
    fn tick(&self) -> f64 {
        self.seconds / f64::from(self.counts_of_travel)
    }
}

/// Program of one or more nodes.
#[derive(Clone, Debug)]
pub struct Converted<'a> {
    /// Planned moves, in the order of the axes.
    pub planned: Vec<Planned>,
    /// Differences between the move and the program: one for each planned move, and one for each axis that is left out.
    pub losses: Vec<Loss>,
    /// Limits that are exceeded: by the planned moves if counts are milliseconds, otherwise by the curves.
    pub excesses: Vec<Excess<'a>>,
}

/// Converts a move to a program, in which axes without a motor of the nodes are left out.
///
/// The loss of a planned move is its greatest distance from the curve at all whole counts of the move. Between counts a
/// planned move has no position. If there are more than 65,536 counts, that many are looked at, and what plan and curve can
/// move between them is added.
///
/// # Errors
///
/// [`Error`] says why the move cannot be a program.
pub fn convert(subject: &Move, options: Options) -> Result<Converted<'_>, Error> {
    let clock = Clock::new(subject, options.count);
    let all = counts(subject.duration() / clock.seconds).unwrap_or(0);
    let motor = |axis: &MoveAxis| axis.hoot().filter(|hoot| options.node.is_none_or(|node| node.0 == hoot.address));
    let (mut planned, mut losses, mut excesses) = (Vec::new(), Vec::new(), Vec::new());
    for axis in subject.axes() {
        let Some(hoot) = motor(axis) else { continue };
        let this = fit::fit(axis, &hoot, &clock)?;
        let this = if options.reverse { this.reversed(all) } else { this };
        let Far { amount, time } = apart(subject, axis, &this, &clock, options.reverse);
        losses.push(Loss::of(axis, LossKind::Planned, amount / hoot.scale.per_unit().abs(), time));
        if options.count == Count::Video {
            excesses.extend(exceeded(axis, &hoot, &this));
        } else {
            excesses.extend(subject.excesses().filter(|excess| excess.axis.name() == axis.name()));
        }
        planned.push(this);
    }
    if planned.is_empty() {
        return Err(Error::NoMotor(options.node));
    }
    losses.extend(Loss::left_out(subject, "hoot", |axis| motor(axis).is_some()));
    Ok(Converted { planned, losses, excesses })
}

/// The greatest distance of a planned move from its curve, in steps.
fn apart(subject: &Move, axis: &MoveAxis, planned: &Planned, clock: &Clock, reverse: bool) -> Far {
    let Some(Hoot { scale, .. }) = axis.hoot() else { return Far::NONE };
    let (curve, plan, tick) = (axis.curve(), planned.plan, clock.tick());
    let lead_in = planned.lead_in.saturating_mul(clock.counts_of_travel);
    let end = counts(subject.duration() / tick).unwrap_or(0).max(lead_in.saturating_add(plan.travel.0));
    let stride = (end / LOOKS).saturating_add(1);
    let mut far = Far::NONE;
    let looks = (0..=end.checked_div(stride).unwrap_or(0)).map(|look| look.saturating_mul(stride));
    for count in looks.chain([end]) {
        let elapsed = count.saturating_sub(lead_in);
        let at = if clock.by_shots { plan.at_shot(elapsed) } else { plan.at(elapsed) };
        let time = f64::from(count) * tick;
        let time = if reverse { subject.duration() - time } else { time };
        let place = curve.position(time) * scale.per_unit() + scale.offset();
        far = far.or(Far { amount: (place - f64::from(at.0)).abs(), time });
    }
    let range = curve.range();
    let largest = [range.from, range.to].map(|at| (at * scale.per_unit() + scale.offset()).abs());
    let mut amount = far.amount + NOISE * largest[0].max(largest[1]).max(1.0);
    if stride > 1 {
        let between = 0.5 * f64::from(stride);
        let change =
            curve.segments().iter().map(|segment| bound::change(segment, between * tick).0).fold(0.0, f64::max);
        let (.., speed) = planned.speed();
        amount += 2.0 * change * scale.per_unit().abs() + speed * between + 1.0;
    }
    Far { amount, ..far }
}

/// The limits that a planned move in milliseconds exceeds.
fn exceeded<'a>(axis: &'a MoveAxis, hoot: &Hoot, planned: &Planned) -> impl Iterator<Item = Excess<'a>> + use<'a> {
    let (gain, lose, speed) = planned.speed();
    let velocity = speed * 1000.0 / hoot.scale.per_unit().abs();
    // Acceleration of the ramp in which it is greatest: that of a straight ramp, or twice that.
    let most = if planned.plan.easing == Easing::LINEAR { 1.0 } else { 2.0 };
    let ramp = |length: f64| most * velocity / (length / 1000.0);
    let last = axis.curve().segments().len().saturating_sub(1);
    let excesses = axis.limits().map(|limits| {
        let beyond = |rate: f64, limit: f64| rate > limit * (1.0 + TOLERANCE);
        let hard = [gain, lose].into_iter().filter(|length| *length > 0.0).map(ramp).fold(0.0, f64::max);
        let (fast, hard) = (
            beyond(velocity, limits.velocity).then_some(ExcessKind::Velocity(Some(velocity), limits.velocity)),
            beyond(hard, limits.acceleration).then_some(ExcessKind::Acceleration(Some(hard), limits.acceleration)),
        );
        let moves = velocity > 0.0;
        let start = (moves && gain == 0.0).then_some(ExcessKind::Start(Some(velocity)));
        let end = (moves && lose == 0.0).then_some(ExcessKind::End(Some(velocity)));
        [(0, start), (0, fast), (0, hard), (last, end)]
    });
    let found = excesses.into_iter().flatten();
    found.filter_map(move |(segment, kind)| kind.map(|kind| Excess { axis, segment, kind }))
}

#[cfg(test)]
mod tests;
