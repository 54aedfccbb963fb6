//! Curves as lines for drawing, and the range of values that a panel shows.

use std::ops::Range;

use motion_core::bezier::Motion;
use motion_move::MoveAxis;

/// Least number of points for the whole duration of a move.
const POINTS: f64 = 1_200.0;
/// Least number of points from one key frame to the next.
const LEAST: f64 = 40.0;

/// A line: times and values.
pub type Line = Vec<(f64, f64)>;

/// Position, velocity and acceleration of an axis over time.
///
/// Each stretch between key frames is a separate line, so that jumps are gaps. Where a rate has no limit, the line has
/// no point.
pub struct Traces {
    /// Positions, in units of the axis.
    pub position: Vec<Line>,
    /// Velocities, in units per second.
    pub velocity: Vec<Line>,
    /// Accelerations, in units per second squared.
    pub acceleration: Vec<Line>,
}

impl Traces {
    /// The traces of an axis in a move that lasts so many seconds.
    #[must_use]
    pub fn new(axis: &MoveAxis, duration: f64) -> Self {
        let curve = axis.curve();
        let mut traces = Self { position: Vec::new(), velocity: Vec::new(), acceleration: Vec::new() };
        let rest = |time: f64| Motion { velocity: Some(0.0), acceleration: Some(0.0), ..curve.at(time) };
        traces.stretch(0.0..curve.start(), duration, rest);
        for segment in curve.segments() {
            traces.stretch(segment.start()..segment.end(), duration, |time| segment.at(time));
        }
        traces.stretch(curve.end()..duration, duration, rest);
        traces
    }

    fn stretch(&mut self, times: Range<f64>, duration: f64, at: impl Fn(f64) -> Motion) {
        let length = times.end - times.start;
        if length <= 0.0 {
            return;
        }
        let count = (POINTS * length / duration).max(LEAST).ceil();
        let mut lines = [const { Line::new() }; 3];
        let mut point = 0.0;
        while point <= count {
            let time = if point < count { times.start + length * point / count } else { times.end };
            let Motion { position, velocity, acceleration } = at(time);
            for (line, value) in lines.iter_mut().zip([Some(position), velocity, acceleration]) {
                line.extend(value.map(|value| (time, value)));
            }
            point += 1.0;
        }
        let [position, velocity, acceleration] = lines;
        self.position.push(position);
        self.velocity.push(velocity);
        self.acceleration.push(acceleration);
    }
}

/// The range of positions that a panel shows: all positions, and some room.
#[must_use]
pub fn positions(lines: &[Line]) -> Range<f64> {
    let (least, most) = bounds(lines);
    roomy(least, most)
}

/// The range of rates that a panel shows: 0, the limit if it is not far away, and the usual rates.
///
/// At a vertical tangent a rate has no limit. If it were drawn to scale, all other values would be a straight line.
#[must_use]
pub fn rates(lines: &[Line], limit: Option<f64>) -> Range<f64> {
    let mut sizes: Vec<f64> = lines.iter().flatten().map(|(_, rate)| rate.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let usual = sizes.get(sizes.len() * 9 / 10).copied().unwrap_or(0.0).max(limit.unwrap_or(0.0));
    let greatest = sizes.last().copied().unwrap_or(0.0);
    let shown = if greatest > 4.0 * usual && usual > 0.0 { 2.0 * usual } else { greatest };
    let (least, most) = bounds(lines);
    let (mut least, mut most) = (least.clamp(-shown, 0.0), most.clamp(0.0, shown));
    if let Some(limit) = limit.filter(|&limit| limit <= 4.0 * shown) {
        most = if most > 0.0 { most.max(limit) } else { most };
        least = if least < 0.0 { least.min(-limit) } else { least };
    }
    roomy(least, most)
}

fn bounds(lines: &[Line]) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    lines.iter().flatten().fold(none, |(least, most), (_, value)| (least.min(*value), most.max(*value)))
}

fn roomy(least: f64, most: f64) -> Range<f64> {
    let room = if most > least { 0.1 * (most - least) } else { 1.0_f64.max(0.1 * most.abs()) };
    least - room..most + room
}

/// The parts of a line between two values.
#[must_use]
pub fn clip(line: &[(f64, f64)], values: &Range<f64>) -> Vec<Line> {
    let mut parts = vec![Line::new()];
    for pair in line.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        // The point where the line crosses one of the two values.
        let at = |value: f64| {
            let share = ((value - from.1) / (to.1 - from.1)).clamp(0.0, 1.0);
            (from.0 + share * (to.0 - from.0), value)
        };
        let end = |point: (f64, f64)| {
            if point.1 < values.start {
                at(values.start)
            } else if point.1 > values.end {
                at(values.end)
            } else {
                point
            }
        };
        let outside = from.1.max(to.1) < values.start || from.1.min(to.1) > values.end;
        if outside {
            parts.push(Line::new());
            continue;
        }
        let (first, last) = (end(from), end(to));
        if let Some(part) = parts.last_mut() {
            if part.last() != Some(&first) {
                part.push(first);
            }
            part.push(last);
        }
        if last != to {
            parts.push(Line::new());
        }
    }
    parts.retain(|part| part.len() > 1);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_where_they_leave_the_panel() {
        let line = [(0.0, 0.0), (1.0, 4.0), (2.0, 8.0), (3.0, 0.0), (4.0, -4.0)];
        let parts = clip(&line, &(-2.0..6.0));
        assert_eq!(parts, [vec![(0.0, 0.0), (1.0, 4.0), (1.5, 6.0)], vec![(2.25, 6.0), (3.0, 0.0), (3.5, -2.0)]]);
        assert_eq!(clip(&line, &(9.0..10.0)), Vec::<Line>::new());
        assert_eq!(clip(&[(0.0, -9.0), (1.0, 9.0)], &(-3.0..3.0)), [vec![(1.0 / 3.0, -3.0), (2.0 / 3.0, 3.0)]]);
        assert_eq!(clip(&line, &(-9.0..9.0)), [line.to_vec()]);
    }

    #[test]
    fn an_infinite_peak_does_not_flatten_the_other_values() {
        let steep = [(0..1_000).map(|i| (f64::from(i), if i == 500 { 1e12 } else { 2.0 })).collect()];
        assert_eq!(rates(&steep, None), -0.4..4.4);
        assert_eq!(rates(&steep, Some(2.5)), -0.5..5.5);
        let plain = [vec![(0.0, -1.0), (1.0, 2.0)]];
        assert_eq!(rates(&plain, None), -1.3..2.3);
        assert_eq!(rates(&plain, Some(4.0)), -4.8..4.8);
        // A limit far away is not shown.
        assert_eq!(rates(&plain, Some(9.0)), -1.3..2.3);
        assert_eq!(rates(&[], None), -1.0..1.0);
        assert_eq!(positions(&[vec![(0.0, 50.0), (1.0, 50.0)]]), 45.0..55.0);
    }
}
