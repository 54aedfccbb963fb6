//! Greatest distance between two axes.

use super::Axis;
use crate::bezier::print::debug_numbers;
use crate::bezier::{Point, Segment};

/// Greatest distance between the positions of two axes in the time that they share.
#[derive(Clone, Copy, PartialEq)]
pub struct Distance {
    /// A time at which the axes have this distance, in seconds. If an axis jumps at this time, both ends of the jump
    /// count.
    pub time: f64,
    /// The distance, in units.
    pub value: f64,
    /// Upper bound of the distance at all times, in units, except for rounding errors of 1e-12 of the largest
    /// coordinate.
    pub bound: f64,
}

debug_numbers! { Distance { time, value, bound } }

impl Axis<'_> {
    /// The greatest distance between this axis and another one, from the later start to the earlier end; `None` if they
    /// share no time.
    ///
    /// The search halves spans of time, and leaves out spans that cannot exceed the greatest known distance by more
    /// than `tolerance`. So `bound` is at most `value + tolerance`, except if the work is not enough: at most 4096
    /// halvings from one end of a segment, of either axis, to the next. With positions of about 100 units, this is
    /// enough for a tolerance of 1e-3, also at vertical tangents.
    #[must_use]
    pub fn distance(&self, other: &Self, tolerance: f64) -> Option<Distance> {
        let (start, end) = (self.start().max(other.start()), self.end().min(other.end()));
        if start > end {
            return None;
        }
        let most = Distance { time: start, value: 0.0, bound: 0.0 };
        let mut search = Search { most, tolerance };
        let mut from = start;
        while from < end {
            let until = self.next_change(from).min(other.next_change(from)).min(end);
            search.stretch(&Pair(self.piece(from), other.piece(from)), from, until);
            from = until;
        }
        // The last segments may have a duration of 0.
        search.see(end, self.position(end) - other.position(end));
        let Distance { time, value, bound } = search.most;
        Some(Distance { time, value, bound: bound.max(value) })
    }

    /// The next time after `time` at which a segment starts or ends.
    fn next_change(&self, time: f64) -> f64 {
        let index = self.index(time);
        let next = self.segments.get(index.saturating_add(1)).map_or(f64::INFINITY, Segment::start);
        match self.segments.get(index) {
            Some(segment) if segment.end() > time => next.min(segment.end()),
            _ => next,
        }
    }

    /// The segment that counts from a time on, or rest in a gap.
    fn piece(&self, time: f64) -> Piece {
        let segment = self.segment_at(time);
        if segment.duration() > 0.0 && time < segment.end() {
            Piece::Moving(*segment)
        } else {
            Piece::Resting(segment.position(time))
        }
    }
}

/// Motion of an axis in a stretch of time.
enum Piece {
    Moving(Segment),
    Resting(f64),
}

impl Piece {
    fn position(&self, time: f64) -> f64 {
        match self {
            Self::Moving(segment) => segment.position(time),
            Self::Resting(position) => *position,
        }
    }

    /// Greatest distances of the curve from its chord between two times, below and above.
    fn off_chord(&self, from: f64, until: f64) -> (f64, f64) {
        let Self::Moving(segment) = self else { return (0.0, 0.0) };
        let late = segment.split(from).map_or(*segment, |(_, late)| late);
        let part = late.split(until).map_or(late, |(part, _)| part);
        let [first, .., last] = part.points();
        let slope = (last.position - first.position) / (last.time - first.time);
        let off = |p: Point| Point { position: p.position - first.position - slope * (p.time - first.time), ..p };
        if let Ok(off) = Segment::new(part.points().map(off)) {
            off.range()
        } else {
            // The curve is too steep for the range of numbers; the bound is its whole height in both directions.
            let (lowest, highest) = part.range();
            (lowest - highest, highest - lowest)
        }
    }
}

/// Motion of both axes in the same stretch of time.
struct Pair(Piece, Piece);

impl Pair {
    fn difference(&self, time: f64) -> f64 {
        self.0.position(time) - self.1.position(time)
    }
}

/// A span of time, with the differences at both ends and the bound of the difference between them.
struct Span {
    from: (f64, f64),
    until: (f64, f64),
    bound: f64,
}

impl Span {
    fn new(pair: &Pair, from: (f64, f64), until: (f64, f64)) -> Self {
        let (one, other) = (pair.0.off_chord(from.0, until.0), pair.1.off_chord(from.0, until.0));
        // The difference is that of the chords, which is largest at an end, plus the distances from the chords.
        let highest = from.1.max(until.1) + (one.1 - other.0);
        let lowest = from.1.min(until.1) + (one.0 - other.1);
        Self { from, until, bound: highest.max(-lowest) }
    }
}

/// Number of parts of a stretch whose ends are compared before the search.
const PARTS: u32 = 32;
/// Greatest number of halvings in a stretch.
const WORK: u32 = 4096;
/// Greatest number of halvings of one span within another.
const DEPTH: u32 = 64;

/// The search for the greatest distance, with the greatest one found so far.
struct Search {
    most: Distance,
    tolerance: f64,
}

impl Search {
    /// Records the difference at a time, and returns both.
    fn see(&mut self, time: f64, difference: f64) -> (f64, f64) {
        if difference.abs() > self.most.value {
            self.most = Distance { time, value: difference.abs(), ..self.most };
        }
        (time, difference)
    }

    /// Searches a stretch of time in which neither axis changes its segment.
    fn stretch(&mut self, pair: &Pair, from: f64, until: f64) {
        for part in 1..PARTS {
            let time = from + f64::from(part) / f64::from(PARTS) * (until - from);
            self.see(time, pair.difference(time));
        }
        let [from, until] = [from, until].map(|time| self.see(time, pair.difference(time)));
        self.halve(pair, &Span::new(pair, from, until), WORK, DEPTH);
    }

    /// Searches a span of time, and returns the number of halvings that are left.
    fn halve(&mut self, pair: &Pair, span: &Span, work: u32, depth: u32) -> u32 {
        let time = span.from.0 + 0.5 * (span.until.0 - span.from.0);
        let divisible = span.from.0 < time && time < span.until.0;
        let known = span.bound <= self.most.value + self.tolerance;
        let (Some(left), Some(depth), true, false) = (work.checked_sub(1), depth.checked_sub(1), divisible, known)
        else {
            self.most.bound = self.most.bound.max(span.bound);
            return work;
        };
        let middle = self.see(time, pair.difference(time));
        let (early, late) = (Span::new(pair, span.from, middle), Span::new(pair, middle, span.until));
        // The half with the greater bound gets half of the work, plus what the other half does not use.
        let (less, more) = if early.bound < late.bound { (early, late) } else { (late, early) };
        let half = left / 2;
        let spared = self.halve(pair, &less, half, depth);
        self.halve(pair, &more, left.saturating_sub(half).saturating_add(spared), depth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::{Ease, Key};

    fn line(from: (f64, f64), to: (f64, f64)) -> Segment {
        let key = |(time, position)| Key { time, position, arrive: Ease::Linear, leave: Ease::Linear };
        Segment::between(&key(from), &key(to)).unwrap()
    }

    fn apart(one: &[Segment], other: &[Segment]) -> Option<(f64, f64)> {
        let (one, other) = (Axis::new(one, "").unwrap(), Axis::new(other, "").unwrap());
        let found = one.distance(&other, 1e-9)?;
        assert!(found.value <= found.bound && found.bound <= found.value + 1e-9, "{found:?}");
        Some((found.time, found.value))
    }

    #[test]
    fn lines_are_farthest_apart_at_an_end() {
        let (rising, level) = (line((0.0, 0.0), (4.0, 8.0)), line((1.0, 1.0), (3.0, 1.0)));
        assert_eq!(apart(&[rising], &[level]), Some((3.0, 5.0)));
        assert_eq!(apart(&[level], &[rising]), Some((3.0, 5.0)));
        assert_eq!(apart(&[rising], &[line((4.0, 1.0), (5.0, 1.0))]), Some((4.0, 7.0)));
        assert_eq!(apart(&[rising], &[line((4.5, 1.0), (5.0, 1.0))]), None);
    }

    #[test]
    fn the_top_of_a_curve_is_found() {
        // Position is 12 s (1 - s) with s from 0 to 1, so its top is at 3.
        let curve = [(0.0, 0.0), (1.0, 4.0), (2.0, 4.0), (3.0, 0.0)].map(|(time, position)| Point::new(time, position));
        let (curve, level) = (Segment::new(curve).unwrap(), line((0.0, 0.0), (3.0, 0.0)));
        let (time, value) = apart(&[curve], &[level]).unwrap();
        assert!((time - 1.5).abs() < 1e-4 && (value - 3.0).abs() < 1e-9, "{value} at {time}");
    }

    #[test]
    fn gaps_and_jumps_count() {
        let level = line((0.0, 0.0), (9.0, 0.0));
        // It rests at 2 from time 1 to 5, then starts again.
        let gap = [line((0.0, 0.0), (1.0, 2.0)), line((5.0, 0.0), (9.0, 1.0))];
        assert_eq!(apart(&gap, &[level]), Some((1.0, 2.0)));
        // A segment of duration 0 at the end is a jump as well.
        let jump = [level, line((9.0, -7.0), (9.0, -7.0))];
        assert_eq!(apart(&jump, &[level]), Some((9.0, 7.0)));
    }

    /// If the work is not enough, the bound is greater than the value by more than the tolerance.
    #[test]
    fn the_bound_holds_when_the_work_is_not_enough() {
        let curve =
            [(0.0, 0.0), (1.0, 1e6), (2.0, -1e6), (3.0, 0.0)].map(|(time, position)| Point::new(time, position));
        let moved = curve.map(|point| Point::new(point.time, point.position + 1.0));
        let (curve, moved) = ([Segment::new(curve).unwrap()], [Segment::new(moved).unwrap()]);
        let (curve, moved) = (Axis::new(&curve, "").unwrap(), Axis::new(&moved, "").unwrap());
        let found = curve.distance(&moved, 0.0).unwrap();
        assert!(
            (found.value - 1.0).abs() < 1e-9 && found.bound > found.value + 1e-9 && found.bound < 10.0,
            "{found:?}"
        );
        assert_eq!(curve.distance(&moved, f64::NAN).unwrap().bound.to_bits(), found.bound.to_bits());
    }
}
