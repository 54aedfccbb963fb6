//! Motors of a device: their positions, ranges, and limits of speed and acceleration.

use motion_core::wire::{Counted, DecodeError, EncodeError, Fields, Message, Row, Visitor};
use motion_core::{__message_features, element, message};

use super::dialect::{Dialect, exact};
use super::{MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared, SetPositionSpeedAcceleration};
use crate::trajectory::Limits;

message! {
    /// Question for the positions, ranges and limits of the motors. Source: kOS, (Get)`MotorInfo`.
    #[derive(Default)]
    pub struct GetMotorInfo<'a> in BE {}
}

element! {
    /// One motor of a [`MotorInfo`].
    pub struct MotorEntry in BE, "motor_count" {
        /// Address of the motor.
        motor_address: MotorAddress,
        /// Position of the motor, between `begin_position` and `end_position` once the motor is calibrated.
        position: Rotations,
        /// Begin of the range: 0 in the specification, but not on every device.
        begin_position: Rotations,
        /// End of the range. Until the motor is calibrated, the begin and the end are 0.
        end_position: Rotations,
        /// Greatest speed of the motor when it is moved by hand.
        max_max_setup_speed: RotationsPerSecond,
        /// Greatest speed of the motor in a move.
        max_max_move_speed: RotationsPerSecond,
        /// Greatest acceleration of the motor.
        max_max_acceleration: RotationsPerSecondSquared,
    }

    /// One motor of a [`MotorInfo`] of the older dialect, where every range begins at 0.
    pub struct OldMotorEntry in BE, "motor_count" {
        /// Address of the motor.
        motor_address: MotorAddress,
        /// Position of the motor.
        position: Rotations,
        /// End of the range. Until the motor is calibrated, the begin and the end are 0.
        end_position: Rotations,
        /// Greatest speed of the motor when it is moved by hand.
        max_max_setup_speed: RotationsPerSecond,
        /// Greatest speed of the motor in a move.
        max_max_move_speed: RotationsPerSecond,
        /// Greatest acceleration of the motor.
        max_max_acceleration: RotationsPerSecondSquared,
    }
}

/// Position, range and limits of a motor, as a device of either dialect reports them.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Motor {
    /// Address of the motor.
    pub motor_address: MotorAddress,
    /// Position of the motor, as the device reports it: see [`relative_position`](Self::relative_position).
    pub position: Rotations,
    /// Begin of the range; `None` in the older dialect, where every range begins at 0.
    pub begin_position: Option<Rotations>,
    /// End of the range. Until the motor is calibrated, the begin and the end are 0.
    pub end_position: Rotations,
    /// Greatest speed of the motor when it is moved by hand.
    pub max_max_setup_speed: RotationsPerSecond,
    /// Greatest speed of the motor in a move.
    pub max_max_move_speed: RotationsPerSecond,
    /// Greatest acceleration of the motor.
    pub max_max_acceleration: RotationsPerSecondSquared,
}

impl Motor {
    /// Whether the motor is calibrated: the ends of its range are known. A motor is not calibrated if both are 0 (decision
    /// K-M5).
    #[must_use]
    pub fn is_calibrated(&self) -> bool {
        self.end_position.0 != 0.0 || self.begin() != 0.0
    }

    /// Notes that the range is void.
    pub(crate) fn forget_range(&mut self) {
        self.begin_position = self.begin_position.map(|_| Rotations(0.0));
        self.end_position = Rotations(0.0);
    }

    /// Position of the motor as commands count it, from the begin of the range; `None` until the motor is calibrated.
    ///
    /// Devices report positions between the begin and the end of the range, and the begin need not be 0. They take
    /// commands from 0 to the length of the range.
    #[must_use]
    pub fn relative_position(&self) -> Option<Rotations> {
        self.is_calibrated().then(|| Rotations(self.position.0 - self.begin()))
    }

    /// Length of the range, which may be negative; `None` until the motor is calibrated.
    ///
    /// Commands take positions from 0 to this.
    #[must_use]
    pub fn range(&self) -> Option<Rotations> {
        self.is_calibrated().then(|| Rotations(self.end_position.0 - self.begin()))
    }

    /// Message that runs the motor until it is stopped, backward if the speed is negative.
    ///
    /// A motor that is calibrated runs to the end of its range at most: to `range` or to 0, whichever is in that direction. A
    /// motor that is not calibrated is sent [`JOG_DISTANCE`](super::JOG_DISTANCE) away. Speed and acceleration are at most
    /// what the specification allows for any kind of axis (decisions K-M6 and K-M7).
    #[must_use]
    pub fn jog(
        &self,
        speed: RotationsPerSecond,
        acceleration: RotationsPerSecondSquared,
    ) -> SetPositionSpeedAcceleration<'static> {
        let motor = MotorAddress(self.motor_address.number());
        let jog = SetPositionSpeedAcceleration::jog(motor, speed, acceleration);
        let position = self.range().map_or(jog.position, |Rotations(range)| {
            Rotations(if speed.0 < 0.0 { range.min(0.0) } else { range.max(0.0) })
        });
        let most = Self::most();
        SetPositionSpeedAcceleration {
            position,
            speed: RotationsPerSecond(at_most(jog.speed.0, most.speed.0)),
            acceleration: RotationsPerSecondSquared(at_most(acceleration.0, most.acceleration.0)),
            ..jog
        }
    }

    /// Message that stops the motor, with its greatest acceleration that the specification allows for any kind of axis
    /// (safety decision 3, decision K-M6).
    #[must_use]
    pub fn stop(&self) -> SetPositionSpeedAcceleration<'static> {
        let acceleration = RotationsPerSecondSquared(at_most(self.max_max_acceleration.0, Self::most().acceleration.0));
        let motor = MotorAddress(self.motor_address.number());
        SetPositionSpeedAcceleration::stop(motor, self.relative_position(), acceleration)
    }

    /// Lowest limits of all kinds of axis, because nothing tells which axis the motor turns.
    fn most() -> Limits {
        let [first, rest @ ..] = AxisKind::ALL.map(Limits::from);
        rest.into_iter().fold(first, Limits::and)
    }

    fn begin(&self) -> f32 {
        self.begin_position.map_or(0.0, Rotations::get)
    }
}

/// Number, or the greatest one that is allowed. NaN and infinite numbers stay as they are.
const fn at_most(number: f32, most: f32) -> f32 {
    if number.is_finite() && number > most { most } else { number }
}

/// Kind of axis that a motor turns. No message says it; the builder of the rig knows it (decision K-M6).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum AxisKind {
    /// Carriage on rails.
    Slider,
    /// Head that turns sideways.
    Pan,
    /// Head that turns up and down.
    Tilt,
    /// Focus ring of a lens.
    Focus,
    /// Iris ring of a lens. The specification sets no limits for it.
    Iris,
    /// Zoom ring of a lens.
    Zoom,
}

impl AxisKind {
    /// All kinds of axis.
    pub const ALL: [Self; 6] = [Self::Slider, Self::Pan, Self::Tilt, Self::Focus, Self::Iris, Self::Zoom];

    /// Greatest speed that the specification allows for the kind of axis; `None` if it says nothing.
    ///
    /// A motor may have other limits, which its `MotorInfo` says. The lower limit counts. Source: kOS,
    /// `SetPositionSpeedAcceleration` and `BumpPositionSpeedAcceleration`.
    #[must_use]
    pub const fn max_speed(self) -> Option<RotationsPerSecond> {
        match self {
            Self::Slider | Self::Pan => Some(RotationsPerSecond(165.0)),
            Self::Tilt => Some(RotationsPerSecond(65.0)),
            Self::Focus | Self::Zoom => Some(RotationsPerSecond(200.0)),
            Self::Iris => None,
        }
    }

    /// Greatest acceleration that the specification allows for the kind of axis; `None` if it says nothing.
    #[must_use]
    pub const fn max_acceleration(self) -> Option<RotationsPerSecondSquared> {
        match self {
            Self::Slider | Self::Pan => Some(RotationsPerSecondSquared(100.0)),
            Self::Tilt | Self::Focus | Self::Zoom => Some(RotationsPerSecondSquared(50.0)),
            Self::Iris => None,
        }
    }
}

motion_core::debug! {
    Motor {
        motor_address position begin_position end_position max_max_setup_speed max_max_move_speed max_max_acceleration
    }
}

impl From<&MotorEntry> for Motor {
    #[inline]
    fn from(entry: &MotorEntry) -> Self {
        Self {
            motor_address: entry.motor_address(),
            position: entry.position(),
            begin_position: Some(entry.begin_position()),
            end_position: entry.end_position(),
            max_max_setup_speed: entry.max_max_setup_speed(),
            max_max_move_speed: entry.max_max_move_speed(),
            max_max_acceleration: entry.max_max_acceleration(),
        }
    }
}

impl From<&OldMotorEntry> for Motor {
    #[inline]
    fn from(entry: &OldMotorEntry) -> Self {
        Self {
            motor_address: entry.motor_address(),
            position: entry.position(),
            begin_position: None,
            end_position: entry.end_position(),
            max_max_setup_speed: entry.max_max_setup_speed(),
            max_max_move_speed: entry.max_max_move_speed(),
            max_max_acceleration: entry.max_max_acceleration(),
        }
    }
}

motion_core::__logged! {
    /// Motors of a [`MotorInfo`], in either dialect.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum MotorInfos<'a> {
        /// Motors as the specification describes them. A list without motors is always of this dialect.
        New(&'a [MotorEntry]),
        /// Motors of a device of the older dialect, at least one.
        Old(&'a [OldMotorEntry]),
    }
}

impl<'a> MotorInfos<'a> {
    /// Number of motors in the list.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self {
            Self::New(motors) => motors.len(),
            Self::Old(motors) => motors.len(),
        }
    }

    /// Whether the list has no motors.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Motors of the list, in the same form for both dialects.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = Motor> + use<'a> {
        let (new, old): (&[MotorEntry], &[OldMotorEntry]) = match *self {
            Self::New(motors) => (motors, &[]),
            Self::Old(motors) => (&[], motors),
        };
        new.iter().map(Motor::from).chain(old.iter().map(Motor::from))
    }
}

mod newer {
    use super::{Counted, MotorEntry, message};

    message! {
        pub(super) struct MotorInfo<'a> in BE {
            ;
            motors: Counted<'a, MotorEntry>,
        }
    }
}

mod older {
    use super::{Counted, OldMotorEntry, message};

    message! {
        pub(super) struct MotorInfo<'a> in BE {
            ;
            motors: Counted<'a, OldMotorEntry>,
        }
    }
}

motion_core::__logged! {
    /// Positions, ranges and limits of motors, mostly of one motor a message.
    ///
    /// `more` is set in all messages of an answer except the last. A motor takes 25 bytes, or 21 in the older dialect; the
    /// length of the message tells the dialect. Source: kOS, `MotorInfo`;
    /// safety decision 7, decisions K-F10, K-M3 to K-M6.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct MotorInfo<'a> {
        /// Whether another message of the same answer follows. The message then has the type 0x82.
        pub more: bool,
        /// Motors of the message.
        pub motors: MotorInfos<'a>,
        /// Bytes after the known fields, kept as they came.
        pub tail: &'a [u8],
    }
}

impl<'a> MotorInfo<'a> {
    const MORE: u32 = 0x8000;

    fn body(&self) -> Dialect<newer::MotorInfo<'a>, older::MotorInfo<'a>> {
        match self.motors {
            MotorInfos::New(motors) => Dialect::Newer(newer::MotorInfo { motors: Counted(motors), tail: self.tail }),
            MotorInfos::Old(motors) => Dialect::Older(older::MotorInfo { motors: Counted(motors), tail: self.tail }),
        }
    }

    /// Whether the body has exactly the length of the older layout, with at least one motor.
    fn is_older(body: &[u8]) -> bool {
        body.split_first().is_some_and(|(&count, entries)| {
            count > 0 && usize::from(count).checked_mul(size_of::<OldMotorEntry>()) == Some(entries.len())
        })
    }
}

impl<'a> Message<'a> for MotorInfo<'a> {
    const LAYOUT: &'static [Row] = newer::MotorInfo::LAYOUT;

    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        Self::decode_as(0, body)
    }

    #[inline]
    fn decode_as(number: u32, body: &'a [u8]) -> Result<Self, DecodeError> {
        let more = number & Self::MORE != 0;
        if Self::is_older(body) {
            let older::MotorInfo { motors: Counted(motors), tail } = older::MotorInfo::decode(body)?;
            Ok(Self { more, motors: MotorInfos::Old(motors), tail })
        } else {
            let newer::MotorInfo { motors: Counted(motors), tail } = newer::MotorInfo::decode(body)?;
            Ok(Self { more, motors: MotorInfos::New(motors), tail })
        }
    }

    #[inline]
    fn number(&self, declared: u32) -> u32 {
        if self.more { declared | Self::MORE } else { declared }
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        self.body().encoded_len()
    }

    #[inline]
    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        if let MotorInfos::Old(motors) = self.motors {
            exact("MotorInfo.motors", self.tail)?;
            if motors.is_empty() {
                return Err(EncodeError::OutOfRange { what: "MotorInfo.motor_count", value: 0, min: 1, max: 255 });
            }
        }
        self.body().encode_into(out)
    }
}

impl Fields for MotorInfo<'_> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        self.body().fields(visitor);
    }
}

__message_features! { 'a [MotorInfo<'a>] MotorInfo }

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn entry(motor: u8, position: f32, begin: f32, end: f32) -> MotorEntry {
        let speed = RotationsPerSecond(165.0);
        let (position, begin, end) = (Rotations(position), Rotations(begin), Rotations(end));
        MotorEntry::new(MotorAddress(motor), position, begin, end, speed, speed, RotationsPerSecondSquared(100.0))
    }

    fn old_entry(motor: u8) -> OldMotorEntry {
        let speed = RotationsPerSecond(165.0);
        let (position, end) = (Rotations(1.0), Rotations(2.0));
        OldMotorEntry::new(MotorAddress(motor), position, end, speed, speed, RotationsPerSecondSquared(100.0))
    }

    fn encode(motors: MotorInfos<'_>, tail: &[u8]) -> Result<Vec<u8>, EncodeError> {
        let info = MotorInfo { more: false, motors, tail };
        let mut out = std::vec![0; info.encoded_len()];
        info.encode_into(&mut out).map(|_| out)
    }

    #[test]
    fn both_dialects_look_alike() {
        let new = [entry(1, 3.0, 2.0, 6.0), entry(0x84, 0.0, 0.0, 0.0), entry(2, -1.0, -40.0, 0.0)];
        let old = [old_entry(3)];
        let motors: Vec<_> = MotorInfos::New(&new).iter().chain(MotorInfos::Old(&old).iter()).collect();
        let begins: Vec<_> = motors.iter().map(|motor| motor.begin_position).collect();
        assert_eq!(begins, [Some(Rotations(2.0)), Some(Rotations(0.0)), Some(Rotations(-40.0)), None]);
        let relative: Vec<_> = motors.iter().map(|motor| (motor.relative_position(), motor.range())).collect();
        let rev = |number| Some(Rotations(number));
        assert_eq!(relative, [(rev(1.0), rev(4.0)), (None, None), (rev(39.0), rev(40.0)), (rev(1.0), rev(2.0))]);
        assert_eq!((motors[1].motor_address.number(), motors[1].motor_address.is_fiz()), (4, true));
    }

    /// Nothing tells which axis a motor turns, so the lowest limits of all kinds count (decision K-M6).
    #[test]
    fn stops_and_jogs_keep_the_limits_of_the_specification() {
        let of = |address, most| {
            let (speed, steepest) = (RotationsPerSecond(166.7), RotationsPerSecondSquared(most));
            let none = Rotations(0.0);
            Motor::from(&MotorEntry::new(MotorAddress(address), none, none, none, speed, speed, steepest))
        };
        for (address, most, expected) in
            [(1, 200.0, 50.0), (1, 40.0, 40.0), (0x84, 200.0, 50.0), (1, f32::INFINITY, 50.0)]
        {
            let stop = of(address, most).stop();
            assert!(stop.is_stop() && stop.motor_address == MotorAddress(address & 0x7f));
            assert_eq!(stop.acceleration, RotationsPerSecondSquared(expected), "{address} {most}");
        }
        for address in [1, 0x84] {
            let jog = of(address, 200.0).jog(RotationsPerSecond(-250.0), RotationsPerSecondSquared(200.0));
            assert_eq!((jog.speed, jog.acceleration), (RotationsPerSecond(65.0), RotationsPerSecondSquared(50.0)));
        }
    }

    #[test]
    fn the_length_tells_the_dialects_apart() {
        let new = [entry(1, 3.0, 2.0, 6.0), entry(2, 0.0, 0.0, 0.0)];
        let old = [old_entry(1), old_entry(2)];
        for len in 0..=2 {
            let (new, old) = (MotorInfos::New(&new[..len]), MotorInfos::Old(&old[..len]));
            let bytes = encode(new, &[]).unwrap();
            assert_eq!(MotorInfo::decode(&bytes), Ok(MotorInfo { more: false, motors: new, tail: &[] }));
            let bytes = encode(new, &[7; 4]).unwrap();
            assert_eq!(MotorInfo::decode(&bytes), Ok(MotorInfo { more: false, motors: new, tail: &[7; 4] }));
            if len > 0 {
                let bytes = encode(old, &[]).unwrap();
                assert_eq!(MotorInfo::decode(&bytes), Ok(MotorInfo { more: false, motors: old, tail: &[] }));
                let truncated =
                    DecodeError::Truncated { what: "MotorInfo.motors", needed: 1 + 25 * len, have: 21 * len };
                assert_eq!(MotorInfo::decode(&bytes[..21 * len]), Err(truncated));
            }
        }
    }

    #[test]
    fn what_would_be_read_as_the_newer_dialect_is_not_written_as_the_older() {
        let old = [old_entry(1)];
        let tail = EncodeError::Tail { what: "MotorInfo.motors", len: 4 };
        assert_eq!(encode(MotorInfos::Old(&old), &[0; 4]), Err(tail));
        let none = EncodeError::OutOfRange { what: "MotorInfo.motor_count", value: 0, min: 1, max: 255 };
        assert_eq!(encode(MotorInfos::Old(&[]), &[]), Err(none));
    }
}
