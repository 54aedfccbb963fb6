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

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MoveFile {
    #[serde(rename = "move")]
    _version: Version,
    name: Label<LONGEST>,
    #[serde(deserialize_with = "rate")]
    rate: FrameRate,
    duration: Option<f64>,
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

impl<'de> Deserialize<'de> for MoveAxis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Object(file): Object<FileAxis> = Object::deserialize(deserializer)?;
        let FileAxis { name: Label(name), unit: Label(unit), keys, limits, kos, dmc, hoot } = file;
        let keys = keys.into_iter().map(|Object(key)| key.into()).collect();
        let limits = limits.map(|Checked(limits)| limits);
        axis::AxisBuilder { name, unit, keys, limits, kos, dmc, hoot }.build().map_err(D::Error::custom)
    }
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

impl From<FileKey> for KeyFrame {
    fn from(FileKey { time, position, ease, arrive, leave }: FileKey) -> Self {
        Self { time, position, arrive: arrive.unwrap_or(ease), leave: leave.unwrap_or(ease) }
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
    type Error = AxisProblem;

    fn try_from(Object(file): Object<FileLimits>) -> Result<Self, AxisProblem> {
        let limits = Limits { velocity: file.velocity, acceleration: file.acceleration, jerk: file.jerk };
        axis::check(&limits).map(|()| Self(limits))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FileKos {
    motor: u8,
    rotations_per_unit: f64,
    #[serde(default)]
    offset: f64,
    range: [f64; 2],
}

impl TryFrom<Object<FileKos>> for Kos {
    type Error = MotorProblem;

    fn try_from(Object(file): Object<FileKos>) -> Result<Self, MotorProblem> {
        let FileKos { motor, rotations_per_unit: per_unit, offset, range: [from, to] } = file;
        Self::new(motor, Rotations { per_unit, offset }, Range::new(from, to))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FileDmc {
    motor: u8,
    steps_per_unit: f64,
    #[serde(default)]
    offset: f64,
}

impl TryFrom<Object<FileDmc>> for Dmc {
    type Error = MotorProblem;

    fn try_from(Object(FileDmc { motor, steps_per_unit, offset }): Object<FileDmc>) -> Result<Self, MotorProblem> {
        Self::new(motor, steps_per_unit, offset)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FileHoot {
    #[serde(default = "usual_address")]
    address: u8,
    motor: u8,
    steps_per_unit: f64,
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
