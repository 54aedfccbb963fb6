//! Paths that a motor follows in time.

use hoot_proto::message::Steps;
use hoot_proto::program::Plan;
use motion_core::time::Millis;

/// Path of a motor in time.
#[derive(Debug, Clone, Copy)]
pub(super) enum Lead {
    /// A plan in whole milliseconds, of which `elapsed` were over at the time `since`.
    Plan { plan: Plan, elapsed: u32, since: Millis },
    /// An even motion, as in a time lapse from one picture to the next.
    Line { from: f64, to: f64, since: Millis, millis: u64 },
}

impl Lead {
    /// Position on the path at a time.
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

    /// The same path, with a number of steps subtracted from its positions.
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

    /// Whether the path is over.
    pub(super) fn is_over(&self, now: Millis) -> bool {
        match *self {
            Self::Plan { plan, elapsed, since } => now.since(since) >= plan.travel.0.saturating_sub(elapsed).into(),
            Self::Line { since, millis, .. } => now.since(since) >= millis,
        }
    }
}
