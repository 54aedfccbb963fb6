//! What kind of command a message is: what stops, what may set something in motion.

use crate::frame::Address;
use crate::message::HostMessage;

impl HostMessage<'_> {
    /// Whether it stops motors: what a machine sends before all else, and again until it is answered.
    ///
    /// Source: hoot, safety decisions 1 and 2.
    #[must_use]
    pub const fn is_stop(&self) -> bool {
        matches!(
            self,
            Self::Stop(_) | Self::Pause(_) | Self::MotorStop(_) | Self::BroadcastStop(_) | Self::BroadcastPause(_)
        )
    }

    /// Whether it may set a motor in motion, or redirect one: what a stop takes out of a queue. What has no type may.
    ///
    /// Source: hoot, safety decision 1.
    #[must_use]
    pub const fn may_start_motion(&self) -> bool {
        matches!(
            self,
            Self::Start(_)
                | Self::BroadcastStart(_)
                | Self::ReturnHome(_)
                | Self::MotorSendHome(_)
                | Self::MotorSendToEnd(_)
                | Self::MotorSendToStart(_)
                | Self::MotorSendToStop(_)
                | Self::MotorSetContinuousSpeed(_)
                | Self::MotorSetContinuousAcceleration(_)
                | Self::MotorMove(_)
                | Self::MotorRun(_)
                | Self::MotorStepForward(_)
                | Self::MotorStepBack(_)
                | Self::Other(_)
        )
    }

    /// Whether this stop concerns what another message would set in motion: a motor's stop that motor and what moves
    /// all of them, a node's the node, a broadcast everything.
    pub(super) fn stops(&self, to: Address, message: &HostMessage<'_>, their: Address) -> bool {
        let is_broadcast = matches!(self, Self::BroadcastStop(_) | Self::BroadcastPause(_));
        let (stop, other) = (self.selector().sub_address, message.selector().sub_address);
        let same_part = stop == 0 || other == 0 || stop == other;
        is_broadcast || their == Address::BROADCAST || to == their && same_part
    }

    /// Whether the node has another address behind it, and is deaf for a while.
    pub(super) const fn changes_address(&self) -> bool {
        matches!(self, Self::SetAddress(_) | Self::CoreAssignAddress(_) | Self::BroadcastAssignAddress(_))
    }
}
