//! Axes of a move.

use motion_core::bezier::{Key, Segment};
use motion_core::profile::{Limits, MotionProfile};
use motion_core::trajectory::Axis;
use motion_core::wire::print::is_hidden;

use crate::error::{AxisProblem, LabelError, MoveProblem};
use crate::key::{self, BadEase, KeyFrame};
use crate::motor::{Dmc, Hoot, Kos};

/// Greatest length of a name, in characters.
pub(crate) const LONGEST: usize = 80;
/// Greatest length of a unit, in characters, because it has to fit beside a picture.
pub(crate) const LONGEST_UNIT: usize = 12;

/// Axis of a move: its curve, its limits, and the motors that move it.
#[derive(Clone, Debug, PartialEq)]
pub struct MoveAxis {
    parts: AxisBuilder,
    segments: Vec<Segment>,
}

impl MoveAxis {
    /// A builder of an axis from its name and the unit of its positions.
    pub fn builder(name: impl Into<String>, unit: impl Into<String>) -> AxisBuilder {
        let (name, unit) = (name.into(), unit.into());
        AxisBuilder { name, unit, keys: Vec::new(), limits: None, kos: None, dmc: None, hoot: None }
    }

    /// The builder of this axis, to make another one that differs.
    pub fn to_builder(&self) -> AxisBuilder {
        self.parts.clone()
    }

    /// Name of the axis.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.parts.name
    }

    /// Unit of the positions.
    #[must_use]
    pub fn unit(&self) -> &str {
        &self.parts.unit
    }

    /// Key frames, at least two, in the order of time.
    #[must_use]
    pub fn keys(&self) -> &[KeyFrame] {
        &self.parts.keys
    }

    /// Limits of the axis, in its units, if it has them.
    #[must_use]
    pub fn limits(&self) -> Option<Limits> {
        self.parts.limits
    }

    /// The kOS motor that moves the axis.
    #[must_use]
    pub fn kos(&self) -> Option<Kos> {
        self.parts.kos
    }

    /// The DMC motor that moves the axis.
    #[must_use]
    pub fn dmc(&self) -> Option<Dmc> {
        self.parts.dmc
    }

    /// The NMX motor that moves the axis.
    #[must_use]
    pub fn hoot(&self) -> Option<Hoot> {
        self.parts.hoot
    }

    /// Positions of the axis over time, in its units and in seconds from the start of the move.
    #[must_use]
    #[expect(
        clippy::missing_panics_doc,
        clippy::expect_used,
        reason = "the segments were checked when the axis was built"
    )]
    pub fn curve(&self) -> Axis<'_> {
        Axis::new(&self.segments, self.unit()).expect("segments in the order of time")
    }
}

/// Builder of a [`MoveAxis`].
#[derive(Clone, Debug, PartialEq)]
#[must_use]
pub struct AxisBuilder {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) keys: Vec<KeyFrame>,
    pub(crate) limits: Option<Limits>,
    pub(crate) kos: Option<Kos>,
    pub(crate) dmc: Option<Dmc>,
    pub(crate) hoot: Option<Hoot>,
}

impl AxisBuilder {
    /// Adds a key frame after the others.
    pub fn key(mut self, key: KeyFrame) -> Self {
        self.keys.push(key);
        self
    }

    /// Replaces all key frames.
    pub fn keys(self, keys: impl IntoIterator<Item = KeyFrame>) -> Self {
        Self { keys: keys.into_iter().collect(), ..self }
    }

    /// Sets the limits.
    pub fn limits(self, limits: Limits) -> Self {
        Self { limits: Some(limits), ..self }
    }

    /// Sets the kOS motor.
    pub fn kos(self, kos: Kos) -> Self {
        Self { kos: Some(kos), ..self }
    }

    /// Sets the DMC motor.
    pub fn dmc(self, dmc: Dmc) -> Self {
        Self { dmc: Some(dmc), ..self }
    }

    /// Sets the NMX motor.
    pub fn hoot(self, hoot: Hoot) -> Self {
        Self { hoot: Some(hoot), ..self }
    }

    /// The axis.
    ///
    /// # Errors
    ///
    /// [`MoveProblem::Axis`], which names the axis and, if a key frame is wrong, its number.
    pub fn build(self) -> Result<MoveAxis, MoveProblem> {
        let axis = self.name.clone();
        self.make().map_err(|problem| MoveProblem::Axis { axis, problem })
    }

    fn make(mut self) -> Result<MoveAxis, AxisProblem> {
        label(&self.name, LONGEST)?;
        label(&self.unit, LONGEST_UNIT)?;
        if let Some(limits) = &self.limits {
            check(limits)?;
        }
        self.kos = self.kos.map(Kos::checked).transpose()?;
        self.dmc = self.dmc.map(Dmc::checked).transpose()?;
        self.hoot = self.hoot.map(Hoot::checked).transpose()?;
        let axis = MoveAxis { segments: segments(&self.keys)?, parts: self };
        let MoveAxis { segments, parts } = &axis;
        let range = Axis::new(segments, &parts.unit)?.range();
        if let Some(kos) = parts.kos {
            // The tolerance allows for rounding.
            let outside = |position: &f64| !(-1e-9..=1.0 + 1e-9).contains(&kos.normalized.apply(*position));
            if let Some(position) = [range.from, range.to].into_iter().find(outside) {
                return Err(AxisProblem::Beyond { position, rotations: kos.rotations.at(position) });
            }
        }
        let scales = [("dmc", parts.dmc.map(|dmc| dmc.scale)), ("hoot", parts.hoot.map(|hoot| hoot.scale))];
        for (protocol, scale) in scales.into_iter().filter_map(|(protocol, scale)| Some((protocol, scale?))) {
            for position in [range.from, range.to] {
                scale.steps(position).map_err(|error| AxisProblem::Steps { protocol, position, error })?;
            }
        }
        Ok(axis)
    }
}

/// The curves between key frames.
fn segments(frames: &[KeyFrame]) -> Result<Vec<Segment>, AxisProblem> {
    if frames.len() < 2 {
        return Err(AxisProblem::Few(frames.len()));
    }
    let mut latest = None::<f64>;
    for (frame, key) in frames.iter().zip(1..) {
        let time = frame.time;
        if !(time.is_finite() && frame.position.is_finite()) {
            return Err(AxisProblem::Range { key });
        }
        if time < 0.0 {
            return Err(AxisProblem::Early { key, time });
        }
        if latest.is_some_and(|latest| time <= latest) {
            return Err(AxisProblem::Order { key, time });
        }
        latest = Some(time);
    }
    let (mut keys, mut before, mut rest) = (Vec::<Key>::new(), None, frames.iter());
    while let Some(this) = rest.next() {
        let (key, time) = (keys.len().saturating_add(1), this.time);
        keys.push(key::key(before, this, rest.as_slice().first()).map_err(|bad| match bad {
            BadEase::Number => AxisProblem::Ease { key, time },
            BadEase::Handle => AxisProblem::Handle { key, time },
        })?);
        before = Some(this);
    }
    let pairs = keys.iter().zip(keys.iter().skip(1)).zip(1..);
    pairs.map(|((from, to), key)| Segment::between(from, to).map_err(|_| AxisProblem::Range { key })).collect()
}

/// Checks a name or a unit, a text for people.
pub(crate) fn label(text: &str, most: usize) -> Result<(), LabelError> {
    if text.trim().is_empty() || text.chars().count() > most || text.chars().any(is_hidden) {
        return Err(LabelError { text: text.to_owned(), most });
    }
    Ok(())
}

/// Checks limits. Limits that are valid for a move of distance 0 are valid for every move.
pub(crate) fn check(limits: &Limits) -> Result<(), AxisProblem> {
    MotionProfile::new(0.0, 0.0, *limits).map(|_| ()).map_err(|_| AxisProblem::Limits)
}
