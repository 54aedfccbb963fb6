//! Sets of motors, by their numbers.

use super::MotorAddress;

/// Greatest number of motors that a device has (decision K-M1).
pub const MOTORS: usize = MotorAddress::LAST.0 as usize;

/// Set of motors, by their numbers 1 to 10.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
pub struct MotorSet(u16);

impl MotorSet {
    /// Set without motors.
    pub const NONE: Self = Self(0);

    const FIRST: u8 = 1;
    const LAST: u8 = MotorAddress::LAST.0;

    /// Set of the given motors. Addresses that no motor can have are left out.
    #[must_use]
    pub fn of(motors: impl IntoIterator<Item = MotorAddress>) -> Self {
        let mut set = Self::NONE;
        motors.into_iter().for_each(|motor| set.insert(motor));
        set
    }

    const fn bit(motor: MotorAddress) -> u16 {
        match motor.number() {
            number @ Self::FIRST..=Self::LAST => 1_u16.wrapping_shl(number as u32),
            _ => 0,
        }
    }

    /// Whether a motor is in the set.
    #[must_use]
    pub const fn contains(self, motor: MotorAddress) -> bool {
        self.0 & Self::bit(motor) != 0
    }

    /// Whether the set has no motors.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Adds a motor, unless no motor can have the address.
    pub const fn insert(&mut self, motor: MotorAddress) {
        self.0 |= Self::bit(motor);
    }

    /// Set of the motors of both sets.
    #[must_use]
    pub const fn with(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// Set of the motors that the other set does not have.
    #[must_use]
    pub const fn without(self, others: Self) -> Self {
        Self(self.0 & !others.0)
    }

    /// Removes a motor.
    pub const fn remove(&mut self, motor: MotorAddress) {
        self.0 &= !Self::bit(motor);
    }

    /// Motors of the set, by their numbers.
    pub fn iter(self) -> impl Iterator<Item = MotorAddress> {
        (Self::FIRST..=Self::LAST).map(MotorAddress).filter(move |&motor| self.contains(motor))
    }
}

/// A list of the numbers of the motors.
#[cfg(feature = "serde")]
impl motion_core::serde::Serialize for MotorSet {
    fn serialize<S: motion_core::serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}

#[cfg(feature = "serde")]
impl<'de> motion_core::serde::Deserialize<'de> for MotorSet {
    fn deserialize<D: motion_core::serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        use motion_core::serde::de::{Error, SeqAccess, Unexpected, Visitor};

        struct Motors;

        impl<'de> Visitor<'de> for Motors {
            type Value = MotorSet;

            fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str("a list of motors, 1 to 10")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut motors: A) -> Result<MotorSet, A::Error> {
                let mut set = MotorSet::NONE;
                while let Some(motor) = motors.next_element()? {
                    set.insert(motor);
                    if !set.contains(motor) {
                        return Err(A::Error::invalid_value(Unexpected::Unsigned(motor.0.into()), &self));
                    }
                }
                Ok(set)
            }
        }

        deserializer.deserialize_seq(Motors)
    }
}
