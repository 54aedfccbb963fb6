//! Members of a move file, and their conversion to a move.

use motion_core::profile::Limits;
use motion_core::trajectory::{FrameRate, Range};
use serde::Deserialize;
use serde::de::{Deserializer, Error};
use serde_json::Value;

use crate::axis::{self, LONGEST, LONGEST_UNIT, MoveAxis};
use crate::error::{AxisProblem, LabelError, MotorProblem, MoveError, MoveProblem};
use crate::key::{Ease, KeyFrame};
use crate::motor::{Dmc, Hoot, Kos, Rotations, USUAL_ADDRESS};
use crate::moves::Move;
use crate::object::{Object, in_words};
#[cfg(feature = "schema")]
use crate::schema;
use crate::text::one_line;

/// Reads the text of a file.
pub(crate) fn parse(name: &str, text: &str) -> Result<Move, MoveError> {
    let name = name.to_owned();
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    match serde_json::from_str::<Object<MoveFile>>(text) {
        Ok(Object(file)) => file.try_into().map_err(|problem| MoveError::Unfit { name, problem }),
        Err(error) => {
            let (line, column) = (error.line(), error.column());
            let what = one_line(&error.to_string());
            let what = what.strip_suffix(&format!(" at line {line} column {column}")).unwrap_or(&what);
            Err(MoveError::Wrong { name, line, column, what: in_words(what) })
        }
    }
}

impl<'de> Deserialize<'de> for Move {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Object(file): Object<MoveFile> = Object::deserialize(deserializer)?;
        file.try_into().map_err(D::Error::custom)
    }
}

/// Move of all axes of a motion-control rig.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct MoveFile {
    /// Version of this schema.
    #[serde(rename = "move")]
    #[cfg_attr(feature = "schema", schemars(schema_with = "schema::version"))]
    _version: Version,
    /// Name of the move.
    #[cfg_attr(feature = "schema", schemars(schema_with = "schema::name"))]
    name: Label<LONGEST>,
    /// Frames per second: a number, or an exact fraction such as "24000/1001".
    #[serde(deserialize_with = "rate")]
    #[cfg_attr(feature = "schema", schemars(schema_with = "schema::rate"))]
    rate: FrameRate,
    /// Duration of the move, in seconds. By default, it ends at its last key frame.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    duration: Option<f64>,
    /// Axes with different names.
    #[cfg_attr(feature = "schema", schemars(with = "Vec<FileAxis>", length(min = 1, max = 64)))]
    axes: Vec<MoveAxis>,
}

impl TryFrom<MoveFile> for Move {
    type Error = MoveProblem;

    fn try_from(file: MoveFile) -> Result<Self, MoveProblem> {
        Self::new(file.name.0, file.rate, file.duration, file.axes)
    }
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
    type Error = LabelError;

    fn try_from(text: String) -> Result<Self, LabelError> {
        axis::label(&text, MOST).map(|()| Self(text))
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

/// Axis of a move: its curve, its limits, and the motors that move it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct FileAxis {
    /// Name of the axis.
    #[cfg_attr(feature = "schema", schemars(schema_with = "schema::name"))]
    name: Label<LONGEST>,
    /// Unit of all positions of the axis.
    #[cfg_attr(feature = "schema", schemars(schema_with = "schema::unit"))]
    unit: Label<LONGEST_UNIT>,
    /// Key frames in the order of time.
    #[cfg_attr(feature = "schema", schemars(with = "Vec<FileKey>", length(min = 2)))]
    keys: Vec<Object<FileKey>>,
    /// Limits of the axis, in its units.
    #[cfg_attr(feature = "schema", schemars(with = "Option<FileLimits>"))]
    limits: Option<Checked>,
    /// The kOS motor that moves the axis.
    #[cfg_attr(feature = "schema", schemars(with = "Option<FileKos>"))]
    kos: Option<Kos>,
    /// The DMC motor that moves the axis.
    #[cfg_attr(feature = "schema", schemars(with = "Option<FileDmc>"))]
    dmc: Option<Dmc>,
    /// The motor of an NMX that moves the axis.
    #[cfg_attr(feature = "schema", schemars(with = "Option<FileHoot>"))]
    hoot: Option<Hoot>,
}

impl<'de> Deserialize<'de> for MoveAxis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Object(file): Object<FileAxis> = Object::deserialize(deserializer)?;
        let FileAxis { name: Label(name), unit: Label(unit), keys, limits, kos, dmc, hoot } = file;
        let keys = keys.into_iter().map(|Object(key)| key.into()).collect();
        let limits = limits.map(|Checked(limits)| limits);
        axis::AxisBuilder { name, unit, keys, limits, kos, dmc, hoot }.build().map_err(D::Error::custom)
    }
}

/// Key frame: the position of the axis at a time, and how the axis arrives and leaves.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct FileKey {
    /// Time from the start of the move, in seconds.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    time: f64,
    /// Position, in units of the axis.
    position: f64,
    /// Ease on each side that has no ease of its own.
    #[serde(default)]
    ease: Ease,
    /// Ease before the key frame.
    arrive: Option<Ease>,
    /// Ease after the key frame.
    leave: Option<Ease>,
}

impl From<FileKey> for KeyFrame {
    fn from(FileKey { time, position, ease, arrive, leave }: FileKey) -> Self {
        Self { time, position, arrive: arrive.unwrap_or(ease), leave: leave.unwrap_or(ease) }
    }
}

/// Limits of an axis. Each is more than 0.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct FileLimits {
    /// Greatest velocity, in units per second.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    velocity: f64,
    /// Greatest acceleration, in units per second squared.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    acceleration: f64,
    /// Greatest jerk, in units per second cubed.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    jerk: Option<f64>,
}

#[derive(Deserialize)]
#[serde(try_from = "Object<FileLimits>")]
struct Checked(Limits);

impl TryFrom<Object<FileLimits>> for Checked {
    type Error = AxisProblem;

    fn try_from(Object(file): Object<FileLimits>) -> Result<Self, AxisProblem> {
        let limits = Limits { velocity: file.velocity, acceleration: file.acceleration, jerk: file.jerk };
        axis::check(&limits).map(|()| Self(limits))
    }
}

/// Motor of a kOS device.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct FileKos {
    /// Address of the motor.
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 10)))]
    motor: u8,
    /// Rotations per unit; negative if the motor runs against the axis.
    #[cfg_attr(feature = "schema", schemars(extend("not" = { "const": 0 })))]
    rotations_per_unit: f64,
    /// Rotations at position 0.
    #[serde(default)]
    offset: f64,
    /// Calibrated range of the motor, in rotations: two different numbers.
    range: [f64; 2],
}

impl TryFrom<Object<FileKos>> for Kos {
    type Error = MotorProblem;

    fn try_from(Object(file): Object<FileKos>) -> Result<Self, MotorProblem> {
        let FileKos { motor, rotations_per_unit: per_unit, offset, range: [from, to] } = file;
        Self::new(motor, Rotations { per_unit, offset }, Range::new(from, to))
    }
}

/// Motor of a DMC device.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct FileDmc {
    /// Number of the motor.
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 32)))]
    motor: u8,
    /// Steps per unit; negative if the motor runs against the axis.
    #[cfg_attr(feature = "schema", schemars(extend("not" = { "const": 0 })))]
    steps_per_unit: f64,
    /// Steps at position 0.
    #[serde(default)]
    offset: f64,
}

impl TryFrom<Object<FileDmc>> for Dmc {
    type Error = MotorProblem;

    fn try_from(Object(FileDmc { motor, steps_per_unit, offset }): Object<FileDmc>) -> Result<Self, MotorProblem> {
        Self::new(motor, steps_per_unit, offset)
    }
}

/// Motor of an NMX.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct FileHoot {
    /// Address of the node.
    #[serde(default = "usual_address")]
    #[cfg_attr(feature = "schema", schemars(range(min = 2, max = 255)))]
    address: u8,
    /// Number of the motor in the node.
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 3)))]
    motor: u8,
    /// Steps per unit; negative if the motor runs against the axis.
    #[cfg_attr(feature = "schema", schemars(extend("not" = { "const": 0 })))]
    steps_per_unit: f64,
    /// Steps at position 0.
    #[serde(default)]
    offset: f64,
}

fn usual_address() -> u8 {
    USUAL_ADDRESS
}

impl TryFrom<Object<FileHoot>> for Hoot {
    type Error = MotorProblem;

    fn try_from(Object(file): Object<FileHoot>) -> Result<Self, MotorProblem> {
        Self::new(file.address, file.motor, file.steps_per_unit, file.offset)
    }
}
