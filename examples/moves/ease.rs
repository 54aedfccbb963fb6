//! Eases as in move files, and their conversion to handles.

use std::fmt;

use motion_core::bezier::{self, Key, Point};
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Unexpected, Visitor};

/// Ease of an axis on one side of a key frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Ease {
    #[default]
    Smooth,
    Linear,
    Flat(f64),
    Handle(f64, f64),
}

impl<'de> Deserialize<'de> for Ease {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = Ease;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"smooth\", \"linear\", a number from 0 to 1, or a handle [seconds, units]")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Ease, E> {
                match text {
                    "smooth" => Ok(Ease::Smooth),
                    "linear" => Ok(Ease::Linear),
                    _ => Err(E::invalid_value(Unexpected::Str(text), &self)),
                }
            }

            fn visit_f64<E: Error>(self, part: f64) -> Result<Ease, E> {
                if (0.0..=1.0).contains(&part) {
                    Ok(Ease::Flat(part))
                } else {
                    Err(E::invalid_value(Unexpected::Float(part), &self))
                }
            }

            fn visit_u64<E: Error>(self, part: u64) -> Result<Ease, E> {
                match part {
                    0 => Ok(Ease::Flat(0.0)),
                    1 => Ok(Ease::Flat(1.0)),
                    _ => Err(E::invalid_value(Unexpected::Unsigned(part), &self)),
                }
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Ease, A::Error> {
                let (seconds, units) = Deserialize::deserialize(SeqAccessDeserializer::new(list))?;
                Ok(Ease::Handle(seconds, units))
            }
        }
        deserializer.deserialize_any(Any)
    }
}

/// A key frame of a file, with the ease of each side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EasedKey {
    pub(super) time: f64,
    pub(super) position: f64,
    pub(super) arrive: Ease,
    pub(super) leave: Ease,
}

/// Error: a handle of the key frame reaches beyond the other key frame, or away from it.
pub(super) struct BadHandle;

/// The key frame with its handles, from the key frames before and after it.
pub(super) fn key(before: Option<&EasedKey>, this: &EasedKey, after: Option<&EasedKey>) -> Result<Key, BadHandle> {
    let slope = slope(before, this, after);
    let ease = |ease: Ease, other: Option<&EasedKey>| {
        let Some(other) = other else { return Ok(bezier::Ease::Linear) };
        let way = other.time - this.time;
        match ease {
            Ease::Smooth => Ok(bezier::Ease::Handle(Point::new(way / 3.0, slope * way / 3.0))),
            Ease::Linear => Ok(bezier::Ease::Linear),
            Ease::Flat(part) => Ok(bezier::Ease::Flat(part)),
            Ease::Handle(seconds, units) if (0.0..=1.0).contains(&(seconds / way)) => {
                Ok(bezier::Ease::Handle(Point::new(seconds, units)))
            }
            Ease::Handle(..) => Err(BadHandle),
        }
    };
    let (arrive, leave) = (ease(this.arrive, before)?, ease(this.leave, after)?);
    Ok(Key { time: this.time, position: this.position, arrive, leave })
}

/// Velocity of a smooth axis at a key frame: the mean velocity from the key frame before to the one after, limited so
/// that a curve with handles of one third stays between its neighbours. It is 0 at the ends, and where the axis changes
/// its direction.
fn slope(before: Option<&EasedKey>, this: &EasedKey, after: Option<&EasedKey>) -> f64 {
    let (Some(before), Some(after)) = (before, after) else { return 0.0 };
    let rise = |from: &EasedKey, to: &EasedKey| (to.position - from.position) / (to.time - from.time);
    let (arriving, leaving) = (rise(before, this), rise(this, after));
    if arriving * leaving <= 0.0 {
        return 0.0;
    }
    rise(before, after).abs().min(3.0 * arriving.abs()).min(3.0 * leaving.abs()).copysign(leaving)
}
