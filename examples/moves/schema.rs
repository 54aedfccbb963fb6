//! The members of a move file, and their conversion to a move.

use std::collections::HashSet;

use motion_core::bezier::Segment;
use motion_core::profile::{Limits, MotionProfile};
use motion_core::trajectory::{Axis, AxisError, FrameRate, FrameTimes, Map, Range, StepScale, StepsOutOfRange};
use motion_core::wire::print::is_hidden;
use serde::Deserialize;
use serde::de::{Deserializer, Error};
use serde_json::Value;

use super::Move;
use super::axis::{Dmc, Hoot, Kos, MoveAxis, Rotations};
use super::ease::{self, Ease, EasedKey};
use super::object::Object;
use crate::program::one_line;

/// Greatest length of a name, in characters.
const LONGEST: usize = 80;
/// Greatest length of a unit, in characters, because it has to fit beside a picture.
const LONGEST_UNIT: usize = 12;
/// Greatest number of axes of a move, more than any device has.
const MOST_AXES: usize = 64;

/// Greatest number of frames of a move, which DMC can count.
const MOST_FRAMES: u32 = dmc_proto::upload::MAX_FRAMES;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    #[serde(rename = "move")]
    _version: Version,
    name: Label<LONGEST>,
    #[serde(deserialize_with = "rate")]
    rate: FrameRate,
    duration: Option<f64>,
    axes: Vec<MoveAxis>,
}

/// Why the parts of a file do not fit together.
#[derive(Debug, thiserror::Error)]
pub(super) enum MoveProblem {
    #[error("there is no axis: \"axes\" needs one")]
    NoAxis,
    #[error("{0} axes are too many: at most {MOST_AXES}")]
    ManyAxes(usize),
    #[error("two axes have the name {0:?}: give each its own name")]
    Twice(String),
    #[error("axes {1:?} and {2:?} have the same {0} motor: give each its own")]
    Shared(&'static str, String, String),
    #[error(
        "\"duration\" is {duration} s, but axis {axis:?} has a key frame at {key} s: make it longer, or leave it out"
    )]
    Short { duration: f64, axis: String, key: f64 },
    #[error("{frames} frames are too many: at most {MOST_FRAMES} can be sent")]
    Long { frames: f64 },
}

impl File {
    pub(super) fn into_move(self) -> Result<Move, MoveProblem> {
        let Self { name: Label(name), rate, duration, axes, .. } = self;
        let last = axes.iter().max_by(|one, other| one.curve().end().total_cmp(&other.curve().end()));
        let last = last.ok_or(MoveProblem::NoAxis)?;
        if axes.len() > MOST_AXES {
            return Err(MoveProblem::ManyAxes(axes.len()));
        }
        let end = last.curve().end();
        let duration = duration.unwrap_or(end);
        if duration < end {
            return Err(MoveProblem::Short { duration, axis: last.name.clone(), key: end });
        }
        let mut names = HashSet::new();
        if let Some(axis) = axes.iter().find(|axis| !names.insert(&axis.name)) {
            return Err(MoveProblem::Twice(axis.name.clone()));
        }
        shared(&axes, "kOS", |axis| axis.kos.map(|kos| kos.motor))?;
        shared(&axes, "DMC", |axis| axis.dmc.map(|dmc| dmc.motor))?;
        shared(&axes, "hoot", |axis| axis.hoot.map(|hoot| (hoot.address, hoot.motor)))?;
        let frames = FrameTimes::covering(0.0, duration, rate).filter(|frames| frames.count <= MOST_FRAMES);
        let frames = frames.ok_or_else(|| MoveProblem::Long { frames: (duration * rate.to_f64()).ceil() })?;
        Ok(Move { name, duration, frames, axes })
    }
}

/// Refuses a motor that is given for two axes.
fn shared<M: PartialEq>(
    axes: &[MoveAxis],
    protocol: &'static str,
    motor: impl Fn(&MoveAxis) -> Option<M>,
) -> Result<(), MoveProblem> {
    for (index, axis) in axes.iter().enumerate() {
        let Some(this) = motor(axis) else { continue };
        if let Some(other) = axes[..index].iter().find(|other| motor(other).is_some_and(|motor| motor == this)) {
            return Err(MoveProblem::Shared(protocol, other.name.clone(), axis.name.clone()));
        }
    }
    Ok(())
}

#[derive(Deserialize)]
#[serde(try_from = "u64")]
struct Version;

impl TryFrom<u64> for Version {
    type Error = String;

    fn try_from(version: u64) -> Result<Self, String> {
        if version == 1 {
            Ok(Self)
        } else {
            Err(format!("\"move\" is version {version}: this program reads version 1"))
        }
    }
}

/// A text for people, of at most `MOST` characters.
#[derive(Deserialize)]
#[serde(try_from = "String")]
struct Label<const MOST: usize>(String);

impl<const MOST: usize> TryFrom<String> for Label<MOST> {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        if text.trim().is_empty() || text.chars().count() > MOST || text.chars().any(is_hidden) {
            return Err(format!(
                "\"{}\" cannot be a name or unit: it needs 1 to {MOST} visible characters",
                one_line(&text)
            ));
        }
        Ok(Self(text))
    }
}

/// The frame rate from a number or a text, with all digits of the file.
fn rate<'de, D: Deserializer<'de>>(deserializer: D) -> Result<FrameRate, D::Error> {
    let text = match Value::deserialize(deserializer)? {
        Value::Number(number) => number.to_string(),
        Value::String(text) => text,
        _ => return Err(D::Error::custom("\"rate\" needs a number, or a fraction such as \"24000/1001\"")),
    };
    let text = text.strip_suffix(".0").unwrap_or(&text);
    text.parse().map_err(|error| D::Error::custom(format!("\"rate\" is {text:?}: {error}")))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileAxis {
    name: Label<LONGEST>,
    unit: Label<LONGEST_UNIT>,
    keys: Vec<Object<FileKey>>,
    limits: Option<Checked>,
    kos: Option<Kos>,
    dmc: Option<Dmc>,
    hoot: Option<Hoot>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileKey {
    time: f64,
    position: f64,
    #[serde(default)]
    ease: Ease,
    arrive: Option<Ease>,
    leave: Option<Ease>,
}

/// Why key frames cannot form an axis. Key frames are counted from 1.
#[derive(Debug, thiserror::Error)]
enum AxisProblem {
    #[error("{0} key frames are too few: an axis needs two")]
    Few(usize),
    #[error("key frame {0} at {1} s is before the start of the move: times are 0 or more")]
    Early(usize, f64),
    #[error("key frame {0} at {1} s is not later than the one before it: put them in the order of time")]
    Order(usize, f64),
    #[error(
        "key frame {0} at {1} s: a handle reaches beyond the other key frame, or away from it: [seconds, units] is its distance, with negative seconds to arrive"
    )]
    Handle(usize, f64),
    #[error("a time or a position is out of range")]
    Range,
    #[error(transparent)]
    Axis(#[from] AxisError),
    #[error("\"kos\": {rotations} rotations at position {position} are beyond its \"range\"")]
    Beyond { position: f64, rotations: f64 },
    #[error("{protocol:?}: at position {position}, {error}: use fewer steps per unit")]
    Steps { protocol: &'static str, position: f64, error: StepsOutOfRange },
}

impl FileAxis {
    fn make(self) -> Result<MoveAxis, AxisProblem> {
        let keys: Vec<EasedKey> = self.keys.iter().map(|Object(key)| key.eased()).collect();
        if keys.len() < 2 {
            return Err(AxisProblem::Few(keys.len()));
        }
        if keys[0].time < 0.0 {
            return Err(AxisProblem::Early(1, keys[0].time));
        }
        if let Some(late) = (1..keys.len()).find(|&index| keys[index].time <= keys[index - 1].time) {
            return Err(AxisProblem::Order(late + 1, keys[late].time));
        }
        let made = |(index, this): (usize, &EasedKey)| {
            let before = index.checked_sub(1).and_then(|index| keys.get(index));
            ease::key(before, this, keys.get(index + 1)).map_err(|_| AxisProblem::Handle(index + 1, this.time))
        };
        let keys = keys.iter().enumerate().map(made).collect::<Result<Vec<_>, _>>()?;
        let segments: Result<Vec<Segment>, _> =
            keys.windows(2).map(|pair| Segment::between(&pair[0], &pair[1])).collect();
        let axis = MoveAxis {
            name: self.name.0,
            unit: self.unit.0,
            keys,
            limits: self.limits.map(|limits| limits.0),
            kos: self.kos,
            dmc: self.dmc,
            hoot: self.hoot,
            segments: segments.map_err(|_| AxisProblem::Range)?,
        };
        let range = Axis::new(&axis.segments, &axis.unit)?.range();
        if let Some(kos) = axis.kos {
            // The tolerance allows for rounding.
            let outside = |position: &f64| !(-1e-9..=1.0 + 1e-9).contains(&kos.normalized.apply(*position));
            if let Some(position) = [range.from, range.to].into_iter().find(outside) {
                return Err(AxisProblem::Beyond { position, rotations: kos.rotations.at(position) });
            }
        }
        let scales = [("dmc", axis.dmc.map(|dmc| dmc.scale)), ("hoot", axis.hoot.map(|hoot| hoot.scale))];
        for (protocol, scale) in scales.into_iter().filter_map(|(protocol, scale)| Some((protocol, scale?))) {
            for position in [range.from, range.to] {
                scale.steps(position).map_err(|error| AxisProblem::Steps { protocol, position, error })?;
            }
        }
        Ok(axis)
    }
}

impl FileKey {
    fn eased(&self) -> EasedKey {
        let Self { time, position, ease, arrive, leave } = *self;
        EasedKey { time, position, arrive: arrive.unwrap_or(ease), leave: leave.unwrap_or(ease) }
    }
}

impl<'de> Deserialize<'de> for MoveAxis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Object(axis): Object<FileAxis> = Object::deserialize(deserializer)?;
        let name = axis.name.0.clone();
        axis.make().map_err(|problem| D::Error::custom(format!("axis {name:?}: {problem}")))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileLimits {
    velocity: f64,
    acceleration: f64,
    jerk: Option<f64>,
}

#[derive(Deserialize)]
#[serde(try_from = "Object<FileLimits>")]
struct Checked(Limits);

impl TryFrom<Object<FileLimits>> for Checked {
    type Error = &'static str;

    fn try_from(Object(FileLimits { velocity, acceleration, jerk }): Object<FileLimits>) -> Result<Self, Self::Error> {
        let limits = Limits { velocity, acceleration, jerk };
        // Limits that are valid for a move of distance 0 are valid for every move.
        MotionProfile::new(0.0, 0.0, limits).map_err(|_| "each of the \"limits\" must be more than 0")?;
        Ok(Self(limits))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileKos {
    motor: u8,
    rotations_per_unit: f64,
    #[serde(default)]
    offset: f64,
    range: [f64; 2],
}

impl TryFrom<Object<FileKos>> for Kos {
    type Error = String;

    fn try_from(Object(file): Object<FileKos>) -> Result<Self, String> {
        let FileKos { motor, rotations_per_unit: per_unit, offset, range: [from, to] } = file;
        numbered("kos", "motor", motor, 1, 10)?;
        let position = |rotations: f64| (rotations - offset) / per_unit;
        // With a scale of 0, positions are not finite.
        let normalized = Map::new(Range::new(position(from), position(to)), Range::UNIT)
            .map_err(|_| "\"kos\" needs \"rotations_per_unit\" other than 0, and a \"range\" with different ends")?;
        Ok(Self { motor, rotations: Rotations { per_unit, offset }, range: Range::new(from, to), normalized })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileDmc {
    motor: u8,
    steps_per_unit: f64,
    #[serde(default)]
    offset: f64,
}

impl TryFrom<Object<FileDmc>> for Dmc {
    type Error = String;

    fn try_from(Object(FileDmc { motor, steps_per_unit, offset }): Object<FileDmc>) -> Result<Self, String> {
        numbered("dmc", "motor", motor, 1, 32)?;
        Ok(Self { motor, scale: scale("dmc", steps_per_unit, offset)? })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileHoot {
    #[serde(default = "usual_address")]
    address: u8,
    motor: u8,
    steps_per_unit: f64,
    #[serde(default)]
    offset: f64,
}

fn usual_address() -> u8 {
    hoot_proto::Address::DEFAULT.0
}

impl TryFrom<Object<FileHoot>> for Hoot {
    type Error = String;

    fn try_from(Object(file): Object<FileHoot>) -> Result<Self, String> {
        let FileHoot { address, motor, steps_per_unit, offset } = file;
        numbered("hoot", "address", address, 2, 255)?;
        numbered("hoot", "motor", motor, 1, 3)?;
        Ok(Self { address, motor, scale: scale("hoot", steps_per_unit, offset)? })
    }
}

fn numbered(protocol: &str, what: &str, number: u8, least: u8, most: u8) -> Result<(), String> {
    if (least..=most).contains(&number) {
        return Ok(());
    }
    Err(format!("\"{protocol}\" has {what} {number}: it is a number from {least} to {most}"))
}

fn scale(protocol: &str, per_unit: f64, offset: f64) -> Result<StepScale, String> {
    StepScale::new(per_unit, offset).map_err(|_| format!("\"{protocol}\" needs \"steps_per_unit\" other than 0"))
}
