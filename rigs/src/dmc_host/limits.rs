//! Limits that the host set. Some devices do not look at them in moves and jogs, so the host does.

use std::collections::BTreeMap;

use dmc_proto::message::{AckCode, HostMessage, Motor, MotorJog, MotorMove, MotorSetLimits, Steps};

use super::Positions;

/// Limits of the motors on this link, as the device acknowledged them.
#[derive(Debug, Default)]
pub(super) struct Limits(BTreeMap<Motor, (i32, i32)>);

impl Limits {
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Keeps the limits of a message.
    pub(super) fn set(&mut self, message: &MotorSetLimits<'_>) {
        let lower = if message.lower_enable.get() { message.lower.0 } else { i32::MIN };
        let upper = if message.upper_enable.get() { message.upper.0 } else { i32::MAX };
        self.0.insert(message.motor, (lower, upper));
    }

    /// Message whose destination is within the limits.
    ///
    /// # Errors
    ///
    /// The code with which a device that looks at limits would refuse the message: a move leads beyond a limit, or a jog
    /// leads further away from a limit that the motor has passed.
    pub(super) fn within(
        &self,
        message: HostMessage<'static>,
        positions: Option<&Positions>,
    ) -> Result<HostMessage<'static>, AckCode> {
        let range = |motor: Motor| self.0.get(&motor).copied();
        match message {
            HostMessage::MotorMove(MotorMove { motor, position, .. }) => match range(motor) {
                Some((lower, _)) if position.0 < lower => Err(AckCode::ERR_SOFT_LOW),
                Some((_, upper)) if position.0 > upper => Err(AckCode::ERR_SOFT_UP),
                _ => Ok(message),
            },
            HostMessage::MotorJog(jog @ MotorJog { motor, destination: Steps(to), .. }) => {
                let Some((lower, upper)) = range(motor) else { return Ok(message) };
                let places = positions.map(|positions| &positions.positions[..]).unwrap_or_default();
                match places.get(usize::from(motor.0).saturating_sub(1)) {
                    Some(here) if *here > upper && to > *here => Err(AckCode::ERR_SOFT_UP),
                    Some(here) if *here < lower && to < *here => Err(AckCode::ERR_SOFT_LOW),
                    _ => Ok(MotorJog { destination: Steps(to.min(upper).max(lower)), ..jog }.into()),
                }
            }
            _ => Ok(message),
        }
    }
}
