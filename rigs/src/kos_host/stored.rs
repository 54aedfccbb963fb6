//! A move that is kept: its message, as it stands on the wire.

use kos_proto::summary::{MoveSummary, SummaryError};
use kos_proto::trajectory::{MoveError, Plan, TrajectoryData};
use kos_proto::{Frame, HostMessage};

/// A move, and what it is to the machines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredMove {
    /// The whole message: what is kept is read again where it is needed.
    message: Vec<u8>,
    summary: MoveSummary,
}

impl StoredMove {
    /// Keeps these blocks.
    ///
    /// # Errors
    ///
    /// [`SummaryError`], if no device plays them.
    pub fn new(data: &TrajectoryData<'_>) -> Result<Self, SummaryError> {
        let summary = MoveSummary::of(data)?;
        let message = HostMessage::SetTrajectoryData(*data);
        let mut bytes = vec![0; message.encoded_len()];
        match message.encode_into(&mut bytes) {
            Ok(_) => Ok(Self { message: bytes, summary }),
            Err(error) => Err(MoveError::from(error).into()),
        }
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

    /// What it is to the machines.
    #[must_use]
    pub const fn summary(&self) -> &MoveSummary {
        &self.summary
    }

    /// Its blocks.
    #[must_use]
    pub fn data(&self) -> TrajectoryData<'_> {
        match Frame::decode(&self.message).map(|frame| HostMessage::decode(&frame)) {
            Ok(Ok(HostMessage::SetTrajectoryData(data))) => data,
            // What was encoded is decoded.
            _ => TrajectoryData::default(),
        }
    }
}
