//! Path that a motor follows in time.

use hoot_proto::message::Steps;
use hoot_proto::program::Plan;
use motion_core::time::Millis;

/// Plan in whole milliseconds, of which `elapsed` were over at the time `since`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lead {
    pub(super) plan: Plan,
    pub(super) elapsed: u32,
    pub(super) since: Millis,
}

impl Lead {
    /// Position on the path at a time.
    pub(super) fn at(&self, now: Millis) -> f64 {
        let gone = u32::try_from(now.since(self.since)).unwrap_or(u32::MAX);
        self.plan.at(self.elapsed.saturating_add(gone)).0.into()
    }

    /// The same path, with a number of steps subtracted from its positions.
    pub(super) fn rebased(self, by: Steps) -> Self {
        let less = |steps: Steps| Steps(steps.0.saturating_sub(by.0));
        Self { plan: Plan { start: less(self.plan.start), stop: less(self.plan.stop), ..self.plan }, ..self }
    }

    /// Whether the path is over.
    pub(super) fn is_over(&self, now: Millis) -> bool {
        now.since(self.since) >= self.plan.travel.0.saturating_sub(self.elapsed).into()
    }
}
