//! Move, and its summary for the machines.

use kos_proto::move_summary::SummaryError;
use kos_proto::trajectory::{MoveError, Plan, TrajectoryData};
use kos_proto::{Host, HostMessage, MoveSummary, Owned};

/// Move, and its summary for the machines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredMove {
    message: Owned<Host>,
    summary: MoveSummary,
}

impl StoredMove {
    /// Keeps the blocks of a move.
    ///
    /// # Errors
    ///
    /// [`SummaryError`], if no device plays the move.
    pub fn new(data: &TrajectoryData<'_>) -> Result<Self, SummaryError> {
        let summary = MoveSummary::of(data)?;
        let message = Owned::new(&HostMessage::from(*data)).map_err(MoveError::from)?;
        Ok(Self { message, summary })
    }

    /// Makes the blocks of a plan, and keeps them.
    ///
    /// # Errors
    ///
    /// [`SummaryError`] says what is wrong with the plan, or why no device plays it.
    pub fn of(plan: &Plan<'_>) -> Result<Self, SummaryError> {
        let mut out = vec![0; plan.encoded_len()];
        Self::new(&plan.encode(&mut out)?)
    }

    /// Same move from its end to its begin, which is played forward: see [`TrajectoryData::reversed`].
    ///
    /// # Errors
    ///
    /// [`SummaryError`], if its curves are too short to be mirrored.
    pub fn reversed(&self) -> Result<Self, SummaryError> {
        let data = self.data();
        let mut out = vec![0; data.reversed_len()];
        Self::new(&data.reversed(&mut out)?)
    }

    /// Summary for the machines.
    #[must_use]
    pub const fn summary(&self) -> &MoveSummary {
        &self.summary
    }

    /// Blocks of the move.
    #[must_use]
    pub fn data(&self) -> TrajectoryData<'_> {
        match self.message.message() {
            HostMessage::SetTrajectoryData(data) => data,
            // The message was made of such blocks.
            _ => TrajectoryData::default(),
        }
    }
}
