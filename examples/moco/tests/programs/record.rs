//! Recorded motion of the motors of a rig, and the planned motion.

use std::path::Path;

/// Row of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row {
    pub(crate) millis: u64,
    pub(crate) motor: u8,
    pub(crate) position: f64,
    pub(crate) moment: Option<f64>,
}

/// Planned motion of a motor.
pub(crate) struct Planned<F> {
    pub(crate) motor: u8,
    /// First and last moment.
    pub(crate) moments: (f64, f64),
    /// Number of moments in a second.
    pub(crate) rate: f64,
    /// Position at a moment.
    pub(crate) position: F,
    /// Greatest distance of the motor from the planned position.
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
    /// Checks that the motor was at its planned position at each moment, that it was neither early nor late, and that
    /// no part of the move is missing.
    #[track_caller]
    pub(crate) fn check(&self, rows: &[Row]) {
        let Self { motor, moments: (first, last), rate, ref position, tolerance } = *self;
        let rows: Vec<_> = rows.iter().filter(|row| row.motor == motor).collect();
        let path: Vec<_> = rows.iter().filter_map(|row| Some((row.millis, row.position, row.moment?))).collect();
        for &(millis, is, moment) in &path {
            let planned = position(moment);
            assert!((is - planned).abs() <= tolerance, "{is} at moment {moment} ({millis} ms), planned {planned}");
        }
        // There are no rows for a motor that stands, and a busy computer may delay rows.
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

/// Last position of a motor.
#[track_caller]
pub(crate) fn last(rows: &[Row], motor: u8) -> f64 {
    rows.iter().rfind(|row| row.motor == motor).expect("each motor has a row").position
}

/// Whether a position equals the goal, except for the last digits.
pub(crate) fn is_at(position: f64, goal: f64) -> bool {
    (position - goal).abs() < 1e-6
}
