//! Tests of move files.

use std::path::Path;

use super::*;

pub(crate) const SLIDE: &str = include_str!("../../examples/moves/slide.json");
pub(crate) const CRANE: &str = include_str!("../../examples/moves/crane.json");
pub(crate) const PAN: &str = include_str!("../../examples/moves/pan.json");
pub(crate) const WHIP: &str = include_str!("../../examples/moves/whip.json");

/// The error of a small move in which a part is replaced.
fn error(part: &str, other: &str) -> String {
    assert!(SLIDE.contains(part), "{part}");
    let error = Move::parse("slide.json", &SLIDE.replacen(part, other, 1)).unwrap_err().to_string();
    assert!(error.starts_with("slide.json") && !error.contains(['\n', '\r']), "{error}");
    error
}

#[test]
fn the_sample_files_are_valid_moves() {
    let slide = Move::parse("slide.json", SLIDE).unwrap();
    assert_eq!((slide.frames().count, slide.frames().rate.to_string().as_str()), (193, "24"));
    let axis = &slide.axes()[0];
    let curve = axis.curve();
    assert!(
        [(0.0, 0.0), (0.5, 0.0), (3.0, 250.0), (5.0, 320.0), (7.5, 600.0), (9.0, 600.0)]
            .into_iter()
            .all(|(time, position)| (curve.position(time) - position).abs() < 1e-9)
    );
    let kos = axis.kos().unwrap();
    assert_eq!((kos.motor, kos.normalized.apply(400.0), kos.rotations.at(400.0)), (1, 0.5, 20.0));
    assert_eq!(axis.dmc().unwrap().scale.steps(2.0), Ok(160));
    assert_eq!((axis.hoot().unwrap().address, axis.hoot().unwrap().motor), (3, 1));
    let [crane, pan] = [("crane.json", CRANE), ("pan.json", PAN)].map(|(name, text)| Move::parse(name, text).unwrap());
    for sample in [slide, crane, pan] {
        let excesses: Vec<String> = sample.excesses().map(|excess| excess.to_string()).collect();
        assert_eq!(excesses, [""; 0]);
    }
}

#[test]
fn smooth_eases_have_no_corners_and_stay_between_key_frames() {
    let crane = Move::parse("crane.json", CRANE).unwrap();
    for axis in crane.axes().iter().filter(|axis| axis.name() != "Pan") {
        let corners = motion_core::trajectory::Tolerance::all(1e-9);
        assert_eq!(axis.curve().joints(corners).count(), 0, "{}", axis.name());
        for (segment, pair) in axis.curve().segments().iter().zip(axis.keys().windows(2)) {
            let (least, most) = segment.range();
            let (from, to) = (pair[0].position, pair[1].position);
            assert!(from.min(to) - 1e-9 <= least && most <= from.max(to) + 1e-9, "{}", axis.name());
        }
    }
}

#[test]
fn excesses_name_axis_and_segment() {
    let whip = Move::parse("whip.json", WHIP).unwrap();
    let lines: Vec<String> = whip.excesses().map(|excess| excess.to_string()).collect();
    let expected = [
        "axis \"Pan\", segment 2 from 0.9 s to 1.3 s: a corner at 0.9 s, velocity jumps by 88.461538 degrees/s",
        "axis \"Pan\", segment 2 from 0.9 s to 1.3 s: velocity 150, the limit is 120 degrees/s",
        "axis \"Pan\", segment 3 from 1.3 s to 2.2 s: a corner at 1.3 s, where velocity has no limit",
    ];
    for line in expected {
        assert!(lines.iter().any(|other| other == line), "{line}: {lines:#?}");
    }
}

#[test]
fn a_move_in_motion_at_its_ends_has_the_same_verdict_with_and_without_its_rests() {
    let key = |time: i32, position: i32, ease: &str| {
        format!(r#"{{ "time": {time}, "position": {position}, "ease": {ease} }}"#)
    };
    let verdict = |keys: &[String]| -> Vec<(String, Option<f64>)> {
        let text = format!(
            r#"{{ "move": 1, "name": "Ends", "rate": 24, "axes": [{{ "name": "Slide", "unit": "mm",
                "limits": {{ "velocity": 40, "acceleration": 50 }}, "keys": [{}] }}] }}"#,
            keys.join(",")
        );
        let ends = Move::parse("", &text).unwrap();
        let corners = ends.excesses().filter_map(|excess| match excess.kind {
            ExcessKind::Start(jump) | ExcessKind::Corner(jump) | ExcessKind::End(jump) => {
                Some((excess.to_string(), jump.map(f64::round)))
            }
            _ => None,
        });
        corners.collect()
    };
    for (ease, jumps) in [
        ("\"linear\"", vec![Some(30.0), Some(-30.0)]),
        ("0", vec![Some(30.0), Some(-30.0)]),
        ("\"smooth\"", vec![]),
        ("0.5", vec![]),
    ] {
        let bare = [key(1, 0, ease), key(3, 60, ease)];
        let [first, last] = bare.clone();
        let written = [key(0, 0, "0.5"), first, last, key(4, 60, "0.5")];
        let [bare, written] = [&bare[..], &written[..]].map(verdict);
        let amounts = |verdict: &[(String, Option<f64>)]| verdict.iter().map(|(_, jump)| *jump).collect::<Vec<_>>();
        assert_eq!(amounts(&bare), jumps, "{ease}: {bare:?}");
        assert_eq!(amounts(&written), jumps, "{ease}: {written:?}");
        if let [(start, _), (end, _)] = &bare[..] {
            assert!(start.contains("a corner at 1 s") && start.ends_with("from the rest before it"), "{start}");
            assert!(end.contains("a corner at 3 s") && end.ends_with("to the rest after it"), "{end}");
        }
    }
}

#[test]
fn errors_name_the_problem_and_its_place() {
    for (part, other, expected) in [
        (
            "\"position\": 250",
            "\"postion\": 250",
            "slide.json, line 13, column 38: unknown field `postion`, expected one of `time`, `position`",
        ),
        (
            "\"move\": 1",
            "\"move\": 2",
            "slide.json, line 2, column 13: \"move\" is version 2: this program reads version 1",
        ),
        (
            "\"time\": 5",
            "\"time\": 3",
            "line 21, column 5: axis \"Slide\": key frame 3 at 3 s is not later than the one before it",
        ),
        ("\"time\": 0.5", "\"time\": -1", "key frame 1 at -1 s is before the start of the move"),
        (
            "\"ease\": 0.6",
            "\"ease\": 1.5",
            "line 15, column 59: invalid value: floating point `1.5`, expected \"smooth\", \"linear\", a number from 0 to 1",
        ),
        ("\"ease\": 0.6", "\"ease\": \"slow\"", "string \"slow\", expected \"smooth\""),
        ("\"ease\": 0.6", "\"ease\": 2", "integer `2`, expected \"smooth\""),
        ("\"ease\": 0.6", "\"arrive\": [3, 0]", "key frame 4 at 7.5 s: a handle reaches beyond"),
        ("\"ease\": 0.6", "\"arrive\": [-3, 0]", "key frame 4 at 7.5 s: a handle reaches beyond"),
        ("\"ease\": 0.6", "\"arrive\": [-3]", "line 15, column 62: invalid length 1, expected an array of two numbers"),
        ("\"rate\": 24", "\"rate\": 0", "line 4, column 13: \"rate\" is \"0\": frame rate: 0"),
        ("\"rate\": 24", "\"rate\": 23.97602", "more than 3 decimals"),
        ("\"rate\": 24", "\"rate\": [24]", "a fraction such as \"24000/1001\""),
        (
            "\"duration\": 8",
            "\"duration\": 7",
            "slide.json: \"duration\" is 7 s, but axis \"Slide\" has a key frame at 7.5 s: make it longer",
        ),
        ("\"duration\": 8", "\"duration\": 1e9", "slide.json: 24000000000 frames are too many"),
        ("\"velocity\": 250", "\"velocity\": 0", "each of the \"limits\" must be more than 0"),
        ("\"range\": [0, 40]", "\"range\": [0, 25]", "\"kos\": 30 rotations at position 600 are beyond its \"range\""),
        ("\"range\": [0, 40]", "\"range\": [5, 5]", "a \"range\" with different ends"),
        ("\"rotations_per_unit\": 0.05", "\"rotations_per_unit\": 0", "\"rotations_per_unit\" other than 0"),
        ("\"kos\": { \"motor\": 1", "\"kos\": { \"motor\": 11", "\"kos\" has motor 11: it is a number from 1 to 10"),
        ("\"dmc\": { \"motor\": 1", "\"dmc\": { \"motor\": 0", "\"dmc\" has motor 0: it is a number from 1 to 32"),
        (
            "\"hoot\": { \"motor\": 1",
            "\"hoot\": { \"address\": 1, \"motor\": 1",
            "\"hoot\" has address 1: it is a number from 2 to 255",
        ),
        (
            "\"hoot\": { \"motor\": 1, \"steps_per_unit\": 80",
            "\"hoot\": { \"motor\": 1, \"steps_per_unit\": 0",
            "\"hoot\" needs \"steps_per_unit\" other than 0",
        ),
        ("\"unit\": \"mm\"", "\"unit\": \" \"", "cannot be a name or unit: it needs 1 to 12 visible characters"),
        ("\"name\": \"Slide\"", "\"name\": \"a\\nb\"", "cannot be a name or unit"),
        ("\"unit\": \"mm\"", "\"a\\nb\": 1", "unknown field `a\\nb`"),
        ("\"position\": 250 },", "\"position\": 250 }", "line 14, column 17: expected `,` or `]`"),
        ("\"position\": 250", "\"position\": 1e80", "out of range"),
        ("\"unit\": \"mm\"", "\"unit\": \"m\u{202e}m\"", "\"m\\u{202e}m\" cannot be a name or unit"),
        ("\"unit\": \"mm\"", "\"unit\": \"m\u{9b}\"", "\"m\\u{9b}\" cannot be a name or unit"),
        ("\"unit\": \"mm\"", "\"\u{202e}\": 1", "unknown field `\\u{202e}`"),
        (
            "\"steps_per_unit\": 80 },\n            \"hoot\"",
            "\"steps_per_unit\": 1e9 },\n            \"hoot\"",
            "axis \"Slide\": \"dmc\": at position 600, steps: 600000000000.0 do not fit 32 bits",
        ),
        (
            "\"hoot\": { \"motor\": 1, \"steps_per_unit\": 80",
            "\"hoot\": { \"motor\": 1, \"steps_per_unit\": -4e6",
            "axis \"Slide\": \"hoot\": at position 600, steps: -2400000000.0 do not fit 32 bits",
        ),
    ] {
        let line = error(part, other);
        assert!(line.contains(expected), "{other}: {line}");
    }
    let none = Move::parse("a.json", r#"{ "move": 1, "name": "None", "rate": 24, "axes": [] }"#).unwrap_err();
    assert_eq!(none.to_string(), "a.json: there is no axis: \"axes\" needs one");
    let missing = Move::read(Path::new("no/such/move.json")).unwrap_err().to_string();
    assert!(missing.starts_with("no/such/move.json: No such file"), "{missing}");
}

#[test]
fn only_an_object_is_an_object_and_messages_name_types_of_json() {
    for (part, other, expected) in [
        (
            "{ \"velocity\": 250, \"acceleration\": 450, \"jerk\": 600 }",
            "[250, 450, 600]",
            "invalid type: array, expected an object",
        ),
        ("{ \"time\": 5, \"position\": 320 }", "[5, 320]", "invalid type: array, expected an object"),
        ("\"dmc\": { \"motor\": 1, \"steps_per_unit\": 80 }", "\"dmc\": [1, 80, 0]", "array, expected an object"),
        ("\"time\": 5", "\"time\": \"5\"", "invalid type: string \"5\", expected a number"),
        ("\"velocity\": 250", "\"velocity\": {}", "invalid type: object, expected a number"),
        ("\"dmc\": { \"motor\": 1", "\"dmc\": { \"motor\": 300", "`300`, expected a whole number from 0 to 255"),
        ("\"dmc\": { \"motor\": 1", "\"dmc\": { \"motor\": 1.5", "number `1.5`, expected a whole number"),
        ("\"move\": 1", "\"move\": -1", "integer `-1`, expected a whole number"),
        ("\"range\": [0, 40]", "\"range\": [0]", "invalid length 1, expected an array of two numbers"),
        ("\"range\": [0, 40]", "\"range\": 40", "integer `40`, expected an array of two numbers"),
        ("\"name\": \"Slide\"", "\"name\": 1", "invalid type: integer `1`, expected a string"),
    ] {
        let line = error(part, other);
        assert!(line.contains(expected), "{other}: {line}");
    }
    for text in ["[]", "[1, \"List\", 24, 1, []]", "7", "null"] {
        let line = Move::parse("list.json", text).unwrap_err().to_string();
        assert!(line.ends_with("expected an object"), "{line}");
    }
    let keys = Move::parse("", r#"{ "move": 1, "name": "a", "rate": 24, "axes": {} }"#).unwrap_err().to_string();
    assert!(keys.contains("invalid type: object, expected an array"), "{keys}");
}

#[test]
fn a_byte_order_mark_before_the_text_is_accepted() {
    let marked = format!("\u{feff}{SLIDE}");
    let slide = Move::parse("", SLIDE).unwrap();
    assert_eq!(Move::parse("", &marked).unwrap(), slide);
    let path = std::env::temp_dir().join(format!("utf-16-{}.json", std::process::id()));
    let utf16: Vec<u8> = marked.encode_utf16().flat_map(u16::to_le_bytes).collect();
    std::fs::write(&path, utf16).unwrap();
    assert_eq!(Move::read(&path).unwrap(), slide);
    std::fs::remove_file(path).unwrap();
}

#[test]
fn two_axes_do_not_share_a_name_or_a_motor() {
    let twice = CRANE.replace("\"Focus\"", "\"Pan\"");
    let error = Move::parse("a.json", &twice).unwrap_err().to_string();
    assert_eq!(error, "a.json: two axes have the name \"Pan\": give each its own name");
    let shared = CRANE.replace("\"motor\": 4", "\"motor\": 1");
    let error = Move::parse("a.json", &shared).unwrap_err().to_string();
    assert_eq!(error, "a.json: axes \"Track\" and \"Focus\" have the same DMC motor: give each its own");
}

#[test]
fn a_move_without_duration_ends_at_its_last_key_frame() {
    let short = Move::parse("", &SLIDE.replacen("    \"duration\": 8,\n", "", 1)).unwrap();
    assert_eq!((short.duration().to_bits(), short.frames().count), (7.5_f64.to_bits(), 181));
}
