//! What a request may do: start motion, stop it, be sent again.

use super::HostMessage;

impl HostMessage<'_> {
    /// Whether it stops motors. A stop waits for nothing, and is sent again until it is known to be obeyed (safety
    /// decision 1).
    #[must_use]
    pub const fn is_stop(&self) -> bool {
        matches!(self, Self::MotorStop(_) | Self::MotorStopAll(_) | Self::VirtStop(_))
    }

    /// Whether a motor may move because of it. After a stop none of these is sent any more (safety decision 1).
    ///
    /// A message of an unknown type may do anything.
    #[must_use]
    pub const fn starts_motion(&self) -> bool {
        matches!(
            self,
            Self::MotorMove(_)
                | Self::MotorJog(_)
                | Self::RtPositionFrame(_)
                | Self::RtRunMove(_)
                | Self::RtShootFrame(_)
                | Self::RtShootFrame2(_)
                | Self::RtGo(_)
                | Self::RtJogAll(_)
                | Self::VirtMove(_)
                | Self::VirtJog(_)
                | Self::VirtJogOnLine(_)
                | Self::VirtAimPoint(_)
                | Self::Other(_)
        )
    }

    /// Whether it may be sent again, where nobody knows if it arrived: twice is then the same as once (safety decision 2,
    /// DMC D5).
    ///
    /// Not a jog, nor what begins a run or a shot, nor another number for where a motor stands; nor what is of an unknown
    /// type.
    #[must_use]
    pub const fn is_repeatable(&self) -> bool {
        !matches!(
            self,
            Self::MotorJog(_)
                | Self::MotorResetPosition(_)
                | Self::RtRunMove(_)
                | Self::RtShootFrame(_)
                | Self::RtShootFrame2(_)
                | Self::RtGo(_)
                | Self::RtJogAll(_)
                | Self::VirtJog(_)
                | Self::VirtJogOnLine(_)
                | Self::Other(_)
        )
    }
}
