//! What the motors of a rig did, and what they should have done.

use std::path::Path;

/// A row of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row {
    pub(crate) millis: u64,
    pub(crate) motor: u8,
    pub(crate) position: f64,
    pub(crate) moment: Option<f64>,
}

/// A way as it was planned.
pub(crate) struct Planned<F> {
    pub(crate) motor: u8,
    /// From the first moment to the last.
    pub(crate) moments: (f64, f64),
    /// How many moments there are in a second.
    pub(crate) rate: f64,
    /// The position at each of them.
    pub(crate) position: F,
    /// How far off the motor may be.
    pub(crate) tolerance: f64,
}

impl Row {
    pub(crate) fn read(path: &Path) -> Vec<Self> {
        let text = std::fs::read_to_string(path).unwrap();
        let rows = text.lines().skip(1).map(|line| {
            let mut parts = line.split(',');
            let mut next = || parts.next().unwrap_or_else(|| panic!("{line:?}"));
            let (millis, motor, position, moment) = (next(), next(), next(), next());
            let moment = (!moment.is_empty()).then(|| moment.parse().unwrap());
            let (millis, motor) = (millis.parse().unwrap(), motor.parse().unwrap());
            Self { millis, motor, position: position.parse().unwrap(), moment }
        });
        rows.collect()
    }
}

impl<F: Fn(f64) -> f64> Planned<F> {
    /// The motor was where it was planned at each moment of the move, came by no sooner or later than planned, and left
    /// nothing out.
    #[track_caller]
    pub(crate) fn check(&self, rows: &[Row]) {
        let Self { motor, moments: (first, last), rate, ref position, tolerance } = *self;
        let rows: Vec<_> = rows.iter().filter(|row| row.motor == motor).collect();
        let path: Vec<_> = rows.iter().filter_map(|row| Some((row.millis, row.position, row.moment?))).collect();
        for &(millis, is, moment) in &path {
            let planned = position(moment);
            assert!((is - planned).abs() <= tolerance, "{is} at moment {moment} ({millis} ms), planned {planned}");
        }
        // A row says nothing of a motor that stands, and a computer that is busy has other things to do for a while.
        let gap = rate * 0.3;
        let mut from = first;
        for pair in path.windows(2) {
            let [(before, _, moment), (after, _, next)] = *pair else { unreachable!() };
            #[expect(clippy::cast_precision_loss, reason = "minutes of milliseconds")]
            let passed = (after - before) as f64 / 1000.0 * rate;
            assert!(((next - moment).abs() - passed).abs() <= rate * 0.002, "{moment} to {next} in {passed}");
        }
        let mut reached: Vec<f64> = path.iter().map(|&(_, _, moment)| moment).collect();
        reached.push(last);
        reached.sort_by(f64::total_cmp);
        for moment in reached {
            let stands = (position(moment) - position(from)).abs() <= tolerance;
            assert!(moment - from <= gap || stands, "nothing from moment {from} to {moment}");
            from = from.max(moment);
        }
        assert!(path.len() > 100, "{} rows", path.len());
    }
}

/// Where a motor was last.
#[track_caller]
pub(crate) fn last(rows: &[Row], motor: u8) -> f64 {
    rows.iter().rfind(|row| row.motor == motor).expect("each motor has a row").position
}

/// Whether a motor is where it should be, but for the last digits.
pub(crate) fn is_at(position: f64, goal: f64) -> bool {
    (position - goal).abs() < 1e-6
}
