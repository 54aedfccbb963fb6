//! Ways that a motor is led along, moment by moment.

use hoot_proto::message::Steps;
use hoot_proto::program::Plan;
use motion_core::time::Millis;

/// A way that a motor is led along.
#[derive(Debug, Clone, Copy)]
pub(super) enum Lead {
    /// A plan in milliseconds, at whose moment `elapsed` it was at `since`. Between two milliseconds there is nothing.
    Plan { plan: Plan, elapsed: u32, since: Millis },
    /// Evenly from here to there: what a time lapse does from one picture to the next.
    Line { from: f64, to: f64, since: Millis, millis: u64 },
}

impl Lead {
    /// Where the motor is to be.
    #[expect(clippy::cast_precision_loss, reason = "milliseconds between two pictures")]
    pub(super) fn at(&self, now: Millis) -> f64 {
        match *self {
            Self::Plan { plan, elapsed, since } => {
                let gone = u32::try_from(now.since(since)).unwrap_or(u32::MAX);
                plan.at(elapsed.saturating_add(gone)).0.into()
            }
            Self::Line { to, .. } if self.is_over(now) => to,
            Self::Line { from, to, since, millis } => from + (to - from) * now.since(since) as f64 / millis as f64,
        }
    }

    /// The same, where positions count from so many steps on.
    pub(super) fn rebased(self, by: Steps) -> Self {
        match self {
            Self::Plan { plan, elapsed, since } => {
                let less = |steps: Steps| Steps(steps.0.saturating_sub(by.0));
                Self::Plan { plan: Plan { start: less(plan.start), stop: less(plan.stop), ..plan }, elapsed, since }
            }
            Self::Line { from, to, since, millis } => {
                let by = f64::from(by.0);
                Self::Line { from: from - by, to: to - by, since, millis }
            }
        }
    }

    /// Whether it has come to its end.
    pub(super) fn is_over(&self, now: Millis) -> bool {
        match *self {
            Self::Plan { plan, elapsed, since } => now.since(since) >= plan.travel.0.saturating_sub(elapsed).into(),
            Self::Line { since, millis, .. } => now.since(since) >= millis,
        }
    }
}
