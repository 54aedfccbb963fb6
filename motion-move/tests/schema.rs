//! The JSON Schema of move files: it is current, and it refuses what a schema can know.

use motion_move::Move;
use serde_json::{Value, json};

const COMMITTED: &str = include_str!("../schema/move-1.json");
const SLIDE: &str = include_str!("../../examples/moves/slide.json");
const CRANE: &str = include_str!("../../examples/moves/crane.json");
const PAN: &str = include_str!("../../examples/moves/pan.json");
const WHIP: &str = include_str!("../../examples/moves/whip.json");

/// Why a value does not match a schema of ours, as the path to the wrong part. It knows the keywords that our schema has, and
/// panics at any other, so that no keyword is passed over.
fn mismatch(root: &Value, schema: &Value, value: &Value, path: &str) -> Option<String> {
    let wrong = |keyword: &str| Some(format!("{path}: {keyword}"));
    for (keyword, expected) in schema.as_object().expect("schemas are objects") {
        let number = |compare: fn(f64, f64) -> bool| {
            value.as_f64().is_none_or(|value| compare(value, expected.as_f64().unwrap()))
        };
        let length = value.as_str().map(|text| text.chars().count()).or(value.as_array().map(Vec::len));
        let long = |compare: fn(u64, u64) -> bool| {
            length.is_none_or(|length| compare(length as u64, expected.as_u64().unwrap()))
        };
        let matches = match keyword.as_str() {
            "$schema" | "title" | "description" | "default" | "format" | "$defs" => true,
            "$ref" => {
                let target = root.pointer(expected.as_str().unwrap().strip_prefix('#').unwrap()).unwrap();
                match mismatch(root, target, value, path) {
                    None => true,
                    found => return found,
                }
            }
            "type" => {
                let types = expected.as_array().cloned().unwrap_or_else(|| vec![expected.clone()]);
                types.iter().any(|name| match name.as_str().unwrap() {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "number" => value.is_number(),
                    "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
                    "null" => value.is_null(),
                    other => panic!("unknown type {other}"),
                })
            }
            // 1 and 1.0 are the same number.
            "const" => value == expected || value.as_f64().is_some_and(|number| Some(number) == expected.as_f64()),
            "not" => mismatch(root, expected, value, path).is_some(),
            "anyOf" => match &expected.as_array().unwrap()[..] {
                // An optional member: what is wrong in it is told.
                [one, null] if *null == json!({ "type": "null" }) => {
                    match mismatch(root, one, value, path).filter(|_| !value.is_null()) {
                        None => true,
                        found => return found,
                    }
                }
                all => all.iter().any(|one| mismatch(root, one, value, path).is_none()),
            },
            "required" => {
                let names = expected.as_array().unwrap().iter();
                value
                    .as_object()
                    .is_none_or(|members| names.clone().all(|name| members.contains_key(name.as_str().unwrap())))
            }
            "properties" => {
                for (name, schema) in expected.as_object().unwrap() {
                    if let Some(found) =
                        value.get(name).and_then(|value| mismatch(root, schema, value, &format!("{path}/{name}")))
                    {
                        return Some(found);
                    }
                }
                true
            }
            "additionalProperties" => {
                assert_eq!(expected, false);
                value
                    .as_object()
                    .is_none_or(|members| members.keys().all(|name| schema["properties"].get(name).is_some()))
            }
            "items" => {
                let found = value.as_array().into_iter().flatten().zip(0..);
                let mut found =
                    found.filter_map(|(value, at)| mismatch(root, expected, value, &format!("{path}/{at}")));
                match found.next() {
                    None => true,
                    found => return found,
                }
            }
            "minItems" | "minLength" => long(|value, least| value >= least),
            "maxItems" | "maxLength" => long(|value, most| value <= most),
            "minimum" => number(|value, least| value >= least),
            "maximum" => number(|value, most| value <= most),
            "exclusiveMinimum" => number(|value, least| value > least),
            "pattern" if expected == "\\S" => {
                value.as_str().is_none_or(|text| text.chars().any(|char| !char.is_whitespace()))
            }
            "pattern" => {
                let digits = |text: &str| !text.is_empty() && text.chars().all(|char| char.is_ascii_digit());
                value.as_str().is_none_or(|text| match (text.split_once('/'), text.split_once('.')) {
                    (Some((one, other)), _) => digits(one) && digits(other),
                    (_, Some((one, other))) => digits(one) && digits(other) && other.len() <= 3,
                    _ => digits(text),
                })
            }
            other => panic!("unknown keyword {other}"),
        };
        if !matches {
            return wrong(keyword);
        }
    }
    None
}

fn verdict(text: &str) -> Option<String> {
    let schema = serde_json::from_str(COMMITTED).unwrap();
    mismatch(&schema, &schema, &serde_json::from_str(text).unwrap(), "")
}

#[test]
fn the_committed_schema_is_current() {
    assert_eq!(
        serde_json::from_str::<Value>(COMMITTED).unwrap(),
        motion_move::schema(),
        "cargo run -p motion-move --features schema --example schema > motion-move/schema/move-1.json"
    );
}

#[test]
fn the_sample_files_match_the_schema_and_so_does_what_is_written() {
    for text in [SLIDE, CRANE, PAN, WHIP] {
        assert_eq!(verdict(text), None);
        assert_eq!(verdict(&Move::parse("", text).unwrap().to_json()), None);
    }
}

#[test]
fn a_schema_refuses_broken_files_as_the_parser_does() {
    for (part, other, place) in [
        ("\"position\": 250", "\"postion\": 250", "/axes/0/keys/1: "),
        ("\"move\": 1", "\"move\": 2", "/move: const"),
        ("\"time\": 0.5", "\"time\": -1", "/axes/0/keys/0/time: minimum"),
        ("\"ease\": 0.6", "\"ease\": 1.5", "/axes/0/keys/3/ease: anyOf"),
        ("\"ease\": 0.6", "\"ease\": \"slow\"", "/axes/0/keys/3/ease: anyOf"),
        ("\"ease\": 0.6", "\"ease\": [-3]", "/axes/0/keys/3/ease: anyOf"),
        ("\"rate\": 24", "\"rate\": 0", "/rate: anyOf"),
        ("\"rate\": 24", "\"rate\": [24]", "/rate: anyOf"),
        ("\"rate\": 24", "\"rate\": \"24/x\"", "/rate: anyOf"),
        ("\"velocity\": 250", "\"velocity\": 0", "/axes/0/limits/velocity: exclusiveMinimum"),
        ("\"rotations_per_unit\": 0.05", "\"rotations_per_unit\": 0", "/axes/0/kos/rotations_per_unit: not"),
        ("\"kos\": { \"motor\": 1", "\"kos\": { \"motor\": 11", "/axes/0/kos/motor: maximum"),
        ("\"dmc\": { \"motor\": 1", "\"dmc\": { \"motor\": 0", "/axes/0/dmc/motor: minimum"),
        ("\"dmc\": { \"motor\": 1", "\"dmc\": { \"motor\": 1.5", "/axes/0/dmc/motor: type"),
        ("\"hoot\": { \"motor\": 1", "\"hoot\": { \"address\": 1, \"motor\": 1", "/axes/0/hoot/address: minimum"),
        ("\"unit\": \"mm\"", "\"unit\": \" \"", "/axes/0/unit: pattern"),
        ("\"unit\": \"mm\"", "\"unit\": \"thirteen chars\"", "/axes/0/unit: maxLength"),
        ("{ \"time\": 5, \"position\": 320 }", "[5, 320]", "/axes/0/keys/2: type"),
        ("\"range\": [0, 40]", "\"range\": [0]", "/axes/0/kos/range: minItems"),
    ] {
        assert!(SLIDE.contains(part), "{part}");
        let text = SLIDE.replacen(part, other, 1);
        assert!(Move::parse("", &text).is_err(), "{other}");
        let found = verdict(&text).unwrap_or_default();
        assert!(found.starts_with(place), "{other}: {found:?}");
    }
    let mut slide: Value = serde_json::from_str(SLIDE).unwrap();
    slide["axes"] = json!([]);
    assert_eq!(verdict(&slide.to_string()), Some("/axes: minItems".to_owned()));
}
