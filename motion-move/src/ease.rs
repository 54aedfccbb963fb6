//! Eases in move files.

use std::fmt;

use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Unexpected, Visitor};
use serde::ser::{Serialize, Serializer};

use crate::key::Ease;
use crate::write::Number;

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
                Ok(Ease::Handle { seconds, units })
            }
        }
        deserializer.deserialize_any(Any)
    }
}

impl Serialize for Ease {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match *self {
            Self::Smooth => serializer.serialize_str("smooth"),
            Self::Linear => serializer.serialize_str("linear"),
            Self::Flat(part) => Number(part).serialize(serializer),
            Self::Handle { seconds, units } => [seconds, units].map(Number).serialize(serializer),
        }
    }
}
