//! Curves of a move, its limits, and where each of the three rigs departs from it.

use std::fmt::Display;
use std::ops::Range;

use kos_proto::message::{Normalized, Seconds};
use kos_proto::trajectory::{Delay, LiveMotion, Loop, Play};
use motion_move::{Excess, Loss, Move, dmc, hoot, kos};
use plot::trace::{self, Line, Traces};
use serde_json::{Value, json};

/// Size of a move file that is surely none, in bytes.
const LARGE: usize = 4 << 20;
/// Greatest number of frames for which the departure of DMC is computed in the page.
const FRAMES: u32 = 1_000_000;

/// Curves of a move file, and the losses of each rig.
pub(crate) fn curves(name: &str, file: &[u8]) -> Result<Value, String> {
    if file.len() > LARGE {
        return Err(format!("{name:?} has {} bytes: that is no move file", file.len()));
    }
    let text = str::from_utf8(file).map_err(|_| format!("{name:?} is not text: open a move file (.json)"))?;
    let read = Move::parse(name, text).map_err(|error| error.to_string())?;
    let axes: Vec<Value> = read
        .axes()
        .iter()
        .map(|axis| {
            let traces = Traces::new(axis, read.duration());
            let (unit, limits) = (axis.unit(), axis.limits());
            let (fast, hard) = (limits.map(|limits| limits.velocity), limits.map(|limits| limits.acceleration));
            let panels = [
                panel("position", unit, &traces.position, &trace::positions(&traces.position), None),
                panel("velocity", &format!("{unit}/s"), &traces.velocity, &trace::rates(&traces.velocity, fast), fast),
                panel(
                    "acceleration",
                    &format!("{unit}/s²"),
                    &traces.acceleration,
                    &trace::rates(&traces.acceleration, hard),
                    hard,
                ),
            ];
            let keys: Vec<_> = axis.keys().iter().map(|key| (key.time, key.position)).collect();
            json!({ "name": axis.name(), "panels": panels, "keys": keys })
        })
        .collect();
    let frames = read.frames();
    Ok(json!({
        "name": read.name(),
        "about": format!("{} s, {} frames at {} per second", read.duration(), frames.count, frames.rate),
        "duration": read.duration(),
        "axes": axes,
        "excesses": lines(read.excesses()),
        "rigs": rigs(&read),
    }))
}

/// A panel: its range of values, the lines within it, and the parts beyond the limit.
fn panel(title: &str, unit: &str, lines: &[Line], values: &Range<f64>, limit: Option<f64>) -> Value {
    let part = |range: Range<f64>| -> Vec<Line> {
        lines.iter().flat_map(|line| trace::clip(line, &range)).filter(|line| line.len() > 1).collect()
    };
    let beyond = limit
        .filter(|limit| *limit < values.end || -*limit > values.start)
        .map(|limit| [part(limit..values.end.max(limit)), part(values.start.min(-limit)..-limit)].concat());
    json!({
        "title": title, "unit": unit, "low": values.start, "high": values.end, "limit": limit,
        "lines": part(values.clone()), "beyond": beyond.unwrap_or_default(),
    })
}

/// What each rig loses of a move.
fn rigs(read: &Move) -> Value {
    #[expect(clippy::cast_possible_truncation, reason = "the protocol has 32-bit numbers")]
    let duration = Seconds(read.duration() as f32);
    let motion = LiveMotion { duration, repeat: Loop::Once, delay: Delay::None, home_speed: Normalized(0.2) };
    let kos = kos::convert(read, Play::Live(motion)).map(|one| losses(&one.losses, &one.excesses));
    let dmc = if read.frames().count > FRAMES {
        Err(format!("the move has {} frames: the page computes at most {FRAMES}", read.frames().count))
    } else {
        dmc::convert(read).map(|one| losses(&one.losses, &one.excesses)).map_err(|error| error.to_string())
    };
    let hoot = hoot::convert(read, hoot::Options::default()).map(|one| losses(&one.losses, &one.excesses));
    let answer = |name: &str, result: Result<Value, String>| match result {
        Ok(value) => json!({ "name": name, "losses": value["losses"], "excesses": value["excesses"] }),
        Err(error) => json!({ "name": name, "error": error }),
    };
    json!([
        answer("kOS", kos.map_err(|error| error.to_string())),
        answer("DMC", dmc),
        answer("hoot", hoot.map_err(|error| error.to_string())),
    ])
}

fn losses(losses: &[Loss], excesses: &[Excess<'_>]) -> Value {
    json!({ "losses": lines(losses), "excesses": lines(excesses) })
}

fn lines(all: impl IntoIterator<Item = impl Display>) -> Vec<String> {
    all.into_iter().map(|one| one.to_string()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CRANE: &str = include_str!("../../examples/moves/crane.json");
    const WHIP: &str = include_str!("../../examples/moves/whip.json");
    const PAN: &str = include_str!("../../examples/moves/pan.json");

    #[test]
    fn each_axis_has_three_panels_whose_lines_are_within_their_values() {
        for file in [CRANE, WHIP, PAN] {
            let answer = curves("a.json", file.as_bytes()).unwrap();
            for axis in answer["axes"].as_array().unwrap() {
                let panels = axis["panels"].as_array().unwrap();
                assert_eq!(panels.len(), 3);
                for panel in panels {
                    let (low, high) = (panel["low"].as_f64().unwrap(), panel["high"].as_f64().unwrap());
                    let points = panel["lines"].as_array().unwrap().iter().flat_map(|line| line.as_array().unwrap());
                    let values: Vec<f64> = points.map(|point| point[1].as_f64().unwrap()).collect();
                    assert!(values.len() > 100 && values.iter().all(|value| (low..=high).contains(value)), "{panel}");
                }
            }
        }
    }

    #[test]
    fn excesses_are_lines_and_parts_of_curves() {
        let answer = curves("whip.json", WHIP.as_bytes()).unwrap();
        assert!(!answer["excesses"].as_array().unwrap().is_empty(), "{}", answer["excesses"]);
        let panels = answer["axes"][0]["panels"].as_array().unwrap();
        assert!(panels.iter().any(|panel| !panel["beyond"].as_array().unwrap().is_empty()));
        assert!(panels[0]["beyond"].as_array().unwrap().is_empty());
    }

    #[test]
    fn each_rig_says_what_it_loses() {
        let answer = curves("pan.json", PAN.as_bytes()).unwrap();
        for rig in answer["rigs"].as_array().unwrap() {
            assert!(rig["losses"][0].as_str().unwrap().contains("axis \"Pan\" is at most"), "{rig}");
        }
        let bare = PAN.replace("\"dmc\": { \"motor\": 1, \"steps_per_unit\": 100 },", "");
        let answer = curves("pan.json", bare.as_bytes()).unwrap();
        assert!(answer["rigs"][1]["error"].as_str().unwrap().contains("no axis has a DMC motor"));
    }

    #[test]
    fn a_broken_move_is_one_line_with_its_place() {
        for (file, why) in [("{", "line 1"), ("{\"move\": 1}", "missing"), ("\u{1b}\n", "line")] {
            let error = curves("a.json", file.as_bytes()).unwrap_err();
            assert!(error.contains(why) && !error.contains('\n'), "{error:?}");
        }
        assert!(curves("a.bin", &[0xFF]).unwrap_err().contains("is not text"));
    }
}
