//! Objects of JSON, and the words for the types of JSON in messages.

use std::fmt;
use std::marker::PhantomData;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};

/// Members that only an object has. Serde by itself takes a list for an object whose members have that order.
pub(crate) struct Object<T>(pub(crate) T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Object<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Members<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Members<T> {
            type Value = Object<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, members: A) -> Result<Object<T>, A::Error> {
                T::deserialize(MapAccessDeserializer::new(members)).map(Object)
            }
        }
        deserializer.deserialize_map(Members(PhantomData))
    }
}

/// Names of types that serde has in its messages, each with the words for people who know JSON.
const FOUND: [(&str, &str); 3] = [
    ("invalid type: sequence, ", "invalid type: array, "),
    ("invalid type: map, ", "invalid type: object, "),
    ("invalid type: floating point ", "invalid type: number "),
];
const EXPECTED: [(&str, &str); 6] = [
    (", expected a sequence", ", expected an array"),
    (", expected a tuple of size 2", ", expected an array of two numbers"),
    (", expected an array of length 2", ", expected an array of two numbers"),
    (", expected f64", ", expected a number"),
    (", expected u8", ", expected a whole number from 0 to 255"),
    (", expected u64", ", expected a whole number"),
];

/// A message of serde in the words of JSON.
pub(crate) fn in_words(message: &str) -> String {
    let found = FOUND.into_iter().find_map(|(name, words)| Some(format!("{words}{}", message.strip_prefix(name)?)));
    let message = found.unwrap_or_else(|| message.to_owned());
    let expected =
        EXPECTED.into_iter().find_map(|(name, words)| Some(format!("{}{words}", message.strip_suffix(name)?)));
    expected.unwrap_or(message)
}
