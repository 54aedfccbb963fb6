//! Work of a master: what it has to send, and for whom.

use motion_core::machine::Token;
use motion_core::time::Millis;

use super::Transmit;
use crate::frame::Address;
use crate::message::{JoystickMode, Motor, MotorSetContinuousSpeed, StepsPerSecond};

/// A message of the application that waits, or that waits for its answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Pending {
    pub(super) token: Token,
    pub(super) transmit: Transmit,
}

/// A stop that is not answered yet.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Stop {
    pub(super) transmit: Transmit,
    /// Token of the application; `None` for a stop that the machine added.
    pub(super) token: Option<Token>,
    /// Number of times that the stop, or another one in its place, was sent since it was asked for.
    pub(super) sent: u8,
    /// Whether the stop itself was sent.
    pub(super) is_own: bool,
    /// Time before which the stop is not sent again; `None` if it may be sent.
    pub(super) not_before: Option<Millis>,
    /// Whether an answer came since the stop was sent, which may be that to something else.
    pub(super) is_heard: bool,
}

motion_core::debug! { Stop { transmit token sent is_own not_before is_heard } }

/// The next speed of a motor.
#[expect(clippy::struct_field_names, reason = "the field of the message has this name")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Speed {
    pub(super) token: Token,
    pub(super) to: Address,
    pub(super) motor: Motor,
    pub(super) speed: StepsPerSecond,
}

impl Speed {
    pub(super) fn transmit(self) -> Transmit {
        let Self { to, motor, speed, .. } = self;
        Transmit { to, message: MotorSetContinuousSpeed { motor, speed }.into() }
    }

    /// Whether the motor is to come to rest.
    pub(super) fn is_rest(self) -> bool {
        self.speed.0 == 0.0
    }
}

/// Question that keeps the dead-man of a node from stopping it: joystick mode allows it, and it changes nothing (decision
/// H-25).
pub(super) fn keep_alive(to: Address) -> Transmit {
    Transmit { to, message: JoystickMode {}.into() }
}

/// Reason for which a packet is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Job {
    Request(Pending),
    Stop(Stop),
    Speed(Speed),
    KeepAlive(Address),
    Emergency(Transmit),
}

impl Job {
    /// Packet of the job.
    pub(super) fn transmit(&self) -> Transmit {
        match *self {
            Self::Request(Pending { transmit, .. }) | Self::Stop(Stop { transmit, .. }) | Self::Emergency(transmit) => {
                transmit
            }
            Self::Speed(speed) => speed.transmit(),
            Self::KeepAlive(to) => keep_alive(to),
        }
    }

    /// Token of the command, if the application asked for the job.
    pub(super) const fn token(&self) -> Option<Token> {
        match self {
            Self::Request(request) => Some(request.token),
            Self::Stop(stop) => stop.token,
            Self::Speed(speed) => Some(speed.token),
            Self::KeepAlive(_) | Self::Emergency(_) => None,
        }
    }
}
