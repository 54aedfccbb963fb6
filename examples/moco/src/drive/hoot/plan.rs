//! Axes of move files as planned moves of a node, if they are near enough to their curves.

use hoot_proto::Address;
use motion_move::Move;
use motion_move::hoot::{self, Error, Options, Planned};

use crate::drive::Trouble;

pub use motion_move::hoot::Count;

/// Greatest deviation of a planned move, as a part of its distance.
const CLOSE: f64 = 0.01;

/// Makes the planned moves of a node from a move file.
///
/// # Errors
///
/// [`Trouble::Refused`] if the move has no axis for the node, or if a planned move or the rig cannot do it.
pub fn plans(file: &Move, node: Address, count: Count, reverse: bool) -> Result<Vec<Planned>, Trouble> {
    let refused = |why: String| Err(Trouble::Refused(why));
    let axes = file.axes().iter().filter(|axis| axis.hoot().is_some_and(|hoot| hoot.address == node.0));
    if let Some(axis) = axes.clone().find(|axis| axis.keys().len() != 2) {
        return refused(format!(
            "axis {:?}: it has {} key frames, but a planned move has two: remove those between the first and the last",
            axis.name(),
            axis.keys().len()
        ));
    }
    let planned = match hoot::convert(file, Options { count, reverse, node: Some(node) }) {
        Ok(converted) => converted.planned,
        Err(Error::NoMotor(_)) => {
            let address = node.0;
            return refused(format!(
                "the move has no axis for node {address}: give one a \"hoot\" with \"address\": {address} and a \"motor\""
            ));
        }
        Err(error) => return refused(error.to_string()),
    };
    if let Some((axis, this)) = axes.zip(&planned).find(|(_, this)| !is_close(this)) {
        return refused(format!(
            "axis {:?}: its curve is {:.0} steps away from any planned move: use smooth key frames, or straight ones",
            axis.name(),
            this.deviation
        ));
    }
    if let Some(excess) = file.excesses().next() {
        return refused(format!("the move exceeds a limit: {excess}"));
    }
    Ok(planned)
}

/// Whether a planned move is near enough to its curve.
fn is_close(planned: &Planned) -> bool {
    let way = CLOSE * f64::from(planned.plan.start.0.abs_diff(planned.plan.stop.0));
    // Photos are whole numbers, so half the distance from one to the next is the best precision.
    let close = if planned.plan.travel.0 > 1000 { way } else { way.max(planned.peak() / 2.0) };
    planned.deviation <= close.max(2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAN: &str = include_str!("../../../../moves/pan.json");
    const NODE: Address = Address::DEFAULT;

    fn pan(part: &str, other: &str) -> Move {
        assert!(PAN.contains(part));
        Move::parse("pan.json", &PAN.replacen(part, other, 1)).unwrap()
    }

    fn refused(part: &str, other: &str) -> String {
        match plans(&pan(part, other), NODE, Count::Video, false) {
            Err(Trouble::Refused(why)) => why,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_move_that_cannot_be_planned_is_refused() {
        let key = "{ \"time\": 4.5";
        let three = refused(key, &format!("{{ \"time\": 2, \"position\": 50 }}, {key}"));
        assert!(three.contains("axis \"Pan\": it has 3 key frames"), "{three}");
        let fast = refused("\"velocity\": 40", "\"velocity\": 20");
        assert!(fast.contains("exceeds a limit: axis \"Pan\"") && fast.contains("limit is 20"), "{fast}");
        let straight = refused("\"position\": 90 }", "\"position\": 90, \"ease\": \"linear\" }");
        assert!(straight.contains("a corner at 4.5 s"), "{straight}");
        let wild = refused("\"position\": 90 }", "\"position\": 90, \"arrive\": [-4, 20] }");
        assert!(wild.contains("steps away"), "{wild}");
        let none = refused("\"hoot\": { ", "\"hoot\": { \"address\": 4, ");
        assert!(none.contains("no axis for node 3"), "{none}");
        let long = pan("\"duration\": 5,", "").to_json().replace("\"duration\": 4.5", "\"duration\": 20000");
        let long = Move::parse("", &long.replace("\"time\": 4.5", "\"time\": 20000")).unwrap();
        let long = plans(&long, NODE, Count::Video, false).unwrap_err().to_string();
        assert!(long.contains("axis \"Pan\": it is too long"), "{long}");
    }
}
