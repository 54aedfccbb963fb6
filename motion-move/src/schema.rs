//! JSON Schema of move files.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema, schema_for};

use crate::axis::{LONGEST, LONGEST_UNIT};
use crate::file::MoveFile;
use crate::key::Ease;

/// JSON Schema of move files, draft 2020-12, as in the file `schema/move-1.json` of this crate.
///
/// It refuses most files that [`Move::parse`](crate::Move::parse) refuses. It cannot say what depends on several members:
/// the order of key frames, the reach of handles, and whether the range of a motor is large enough.
#[must_use]
pub fn schema() -> serde_json::Value {
    let mut schema = schema_for!(MoveFile);
    schema.insert("title".to_owned(), "Move file, version 1".into());
    schema.to_value()
}

pub(crate) fn version(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "const": 1 })
}

pub(crate) fn name(_: &mut SchemaGenerator) -> Schema {
    label(LONGEST)
}

pub(crate) fn unit(_: &mut SchemaGenerator) -> Schema {
    label(LONGEST_UNIT)
}

/// A text that is not only blanks.
fn label(most: usize) -> Schema {
    json_schema!({ "type": "string", "minLength": 1, "maxLength": most, "pattern": "\\S" })
}

pub(crate) fn rate(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "anyOf": [
        { "type": "number", "exclusiveMinimum": 0 },
        { "type": "string", "pattern": "^[0-9]+(\\.[0-9]{1,3}|/[0-9]+)?$" },
    ] })
}

impl JsonSchema for Ease {
    fn schema_name() -> Cow<'static, str> {
        "Ease".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Ease of the axis on one side of a key frame.",
            "anyOf": [
                {
                    "description": "Through the key frame without a corner, and never beyond the positions of its neighbours.",
                    "const": "smooth",
                },
                { "description": "Straight towards the other key frame.", "const": "linear" },
                {
                    "description": "To rest or from rest, with a flat handle whose length is this part of the time between the key frames.",
                    "type": "number",
                    "minimum": 0,
                    "maximum": 1,
                },
                {
                    "description": "Bezier handle, as its distance from the key frame: seconds, negative to arrive, and units.",
                    "type": "array",
                    "items": { "type": "number" },
                    "minItems": 2,
                    "maxItems": 2,
                },
            ],
        })
    }
}
