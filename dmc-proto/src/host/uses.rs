//! Uses of the motors, as the device acknowledged them, and the motors of the uploaded move.

use super::event::Refusal;
use crate::message::{HostMessage, Motor, MotorFlags, MotorPair, Motors, RtShootFrame, RtShootFrame2};
use crate::upload::Track;

/// Uses of the motors on this link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(super) struct Uses {
    enabled: Motors,
    blurred: Motors,
    /// Motors that are known not to be enabled.
    disabled: Motors,
    /// Motors that are driven by hand during a move.
    pub(super) live: Motors,
    /// Motors of the move whose upload this host began last; `None` if it began none: then nobody knows the move.
    axes: Option<Motors>,
    /// Whether that upload has not come to its end.
    is_incomplete: bool,
}

fn only(motor: Motor) -> Motors {
    [motor].into_iter().collect()
}

/// Motors that move in a shot of their own.
fn blurred(pairs: &[MotorPair]) -> Motors {
    pairs.iter().filter(|pair| pair.pos_a() != pair.pos_b()).map(MotorPair::motor).collect()
}

impl Uses {
    /// Keeps the uses of a motor, as the device acknowledged them.
    pub(super) fn set(&mut self, motor: Motor, flags: MotorFlags) {
        self.keep(motor, flags);
        if !flags.contains(MotorFlags::ENABLED) {
            self.disabled.0 |= only(motor).0;
        }
    }

    /// Nobody knows the uses of a motor.
    pub(super) fn unset(&mut self, motor: Motor) {
        self.keep(motor, MotorFlags::empty());
    }

    /// The device has no uses of motors: a host can neither enable nor disable the motor.
    pub(super) fn unsupported(&mut self, motor: Motor) {
        self.keep(motor, MotorFlags::ENABLED | MotorFlags::BLUR);
        self.disabled.0 |= only(motor).0;
    }

    fn keep(&mut self, motor: Motor, flags: MotorFlags) {
        let motor = only(motor).0;
        self.disabled.0 &= !motor;
        for (motors, flag) in [
            (&mut self.enabled, MotorFlags::ENABLED),
            (&mut self.blurred, MotorFlags::BLUR),
            (&mut self.live, MotorFlags::LIVE),
        ] {
            motors.0 = if flags.contains(flag) { motors.0 | motor } else { motors.0 & !motor };
        }
    }

    /// Forgets all uses, because the device may be another one, or have forgotten them.
    pub(super) fn forget(&mut self) {
        *self = Self { axes: self.axes, is_incomplete: self.is_incomplete, ..Self::default() };
    }

    /// An upload begins, of a move without motors as yet.
    pub(super) const fn upload(&mut self) {
        (self.axes, self.is_incomplete) = (Some(Motors::NONE), true);
    }

    /// The upload is complete.
    pub(super) const fn uploaded(&mut self) {
        self.is_incomplete = false;
    }

    /// The device has no move.
    pub(super) const fn without_move(&mut self) {
        (self.axes, self.is_incomplete) = (None, false);
    }

    /// A section of an upload is sent.
    pub(super) fn section(&mut self, track: Track) {
        if let Track::Axis(motor) = track {
            self.axes.get_or_insert_default().0 |= only(motor).0;
        }
    }

    /// A motor that a message would move although the device was not told to use it so, and the flags that are missing.
    pub(super) fn lacking(&self, message: &HostMessage<'_>) -> Option<(Motor, MotorFlags)> {
        let axes = self.axes.unwrap_or(Motors::NONE);
        let (moved, blurred) = match message {
            HostMessage::MotorMove(message) => (only(message.motor), Motors::NONE),
            HostMessage::MotorJog(message) => (only(message.motor), Motors::NONE),
            HostMessage::RtPositionFrame(_) | HostMessage::RtJogAll(_) | HostMessage::RtRunMove(_) => {
                (axes, Motors::NONE)
            }
            HostMessage::RtShootFrame(RtShootFrame { motors, .. })
            | HostMessage::RtShootFrame2(RtShootFrame2 { motors, .. }) => {
                let own = blurred(motors);
                (Motors(axes.0 | own.0), own)
            }
            _ => return None,
        };
        let first = |motors: Motors, flags| Some((motors.iter().next()?, flags));
        first(Motors(moved.0 & !self.enabled.0), MotorFlags::ENABLED)
            .or_else(|| first(Motors(blurred.0 & !self.blurred.0), MotorFlags::BLUR))
    }

    /// Why a message must not move motors along the uploaded move: nobody knows which move that is, or a motor of the `count`
    /// motors of the device would move although the move does not name it, and is not known to be disabled. If this host
    /// began no upload, it does not ask.
    pub(super) fn outside(&self, message: &HostMessage<'_>, count: u8) -> Option<Refusal> {
        let conduct = message.conduct();
        let axes = self.axes.filter(|_| conduct.in_sequence && conduct.may_move())?;
        if self.is_incomplete {
            return Some(Refusal::MoveUnknown);
        }
        let all: Motors = (1..=count).map(Motor).collect();
        Motors(all.0 & !(axes.0 | self.disabled.0 | self.live.0)).iter().next().map(Refusal::NotInMove)
    }

    /// Whether a message would change the uses of a motor of the move, or let another motor take part in the move.
    pub(super) fn changes_move(&self, message: &HostMessage<'_>) -> bool {
        let (HostMessage::MotorConfigure(message), Some(axes)) = (message, self.axes) else { return false };
        let takes_part = message.flags & (MotorFlags::ENABLED | MotorFlags::LIVE) == MotorFlags::ENABLED;
        takes_part || axes.contains(message.motor)
    }
}
