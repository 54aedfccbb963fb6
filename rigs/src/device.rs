//! Devices that a simulated rig can stand for, and single quirks, by name.
//!
//! ```
//! use motion_rigs::device::Named;
//! use motion_rigs::kos_device::Setup;
//!
//! let setup = Setup::with_motors(2).with_device("mild")?.with_quirks("older-dialect,no-progress")?;
//! assert!(setup.older_dialect && setup.motors.len() == 2);
//! let error = Setup::default().with_device("loud").unwrap_err().to_string();
//! assert!(error.starts_with("kOS has no device \"loud\": it has mild"), "{error}");
//! # Ok::<(), motion_rigs::device::UnknownName>(())
//! ```

use std::fmt;

/// Device or quirk with its name.
#[derive(Debug, Clone, Copy)]
pub struct Choice<S> {
    /// Name, as users type it.
    pub name: &'static str,
    /// Meaning of the name, in one line.
    pub about: &'static str,
    /// Changes a setup.
    pub apply: fn(&mut S),
}

impl<S> Choice<S> {
    pub(crate) const fn new(name: &'static str, about: &'static str, apply: fn(&mut S)) -> Self {
        Self { name, about, apply }
    }
}

/// Setup of a rig that can stand for devices by name.
pub trait Named: Sized + 'static {
    /// Name of the protocol, for errors.
    const PROTOCOL: &'static str;
    /// Devices, in the order of a list. The first one is `mild`: a rig as the documents describe it, without the surprises
    /// of real devices.
    const DEVICES: &'static [Choice<Self>];
    /// Quirks, which can be added to each device.
    const QUIRKS: &'static [Choice<Self>];

    /// Families of names that are too many for the lists, as a pattern such as `unsupported=ACTION` and its meaning.
    const FAMILIES: &'static [(Kind, &'static str, &'static str)] = &[];

    /// Applies a name of a [family](Self::FAMILIES). Returns false if the name is not of a family.
    fn apply_other(&mut self, kind: Kind, name: &str) -> bool {
        let _ = (kind, name);
        false
    }

    /// The same rig as the named device. Choose the device before quirks, because it decides all quirks.
    ///
    /// # Errors
    ///
    /// [`UnknownName`] lists all devices.
    fn with_device(mut self, name: &str) -> Result<Self, UnknownName> {
        self.apply(Kind::Device, name)?;
        Ok(self)
    }

    /// The same rig with the quirks of a list such as `older-dialect,no-progress`.
    ///
    /// # Errors
    ///
    /// [`UnknownName`] lists all quirks.
    fn with_quirks(mut self, list: &str) -> Result<Self, UnknownName> {
        for name in list.split(',').map(str::trim).filter(|name| !name.is_empty()) {
            self.apply(Kind::Quirk, name)?;
        }
        Ok(self)
    }

    /// Applies a name of a kind.
    ///
    /// # Errors
    ///
    /// [`UnknownName`] lists all names of the kind.
    fn apply(&mut self, kind: Kind, name: &str) -> Result<(), UnknownName> {
        let all = match kind {
            Kind::Device => Self::DEVICES,
            Kind::Quirk => Self::QUIRKS,
        };
        if let Some(choice) = all.iter().find(|choice| choice.name == name) {
            (choice.apply)(self);
        } else if !self.apply_other(kind, name) {
            let known = names::<Self>(kind).map(|(name, _)| name).collect();
            return Err(UnknownName { protocol: Self::PROTOCOL, kind, name: name.to_owned(), known });
        }
        Ok(())
    }
}

/// Kind of a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Device.
    Device,
    /// Quirk of a device.
    Quirk,
}

/// Name that is not the name of a device, or of a quirk.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{protocol} has no {kind} {name:?}: it has {}", known.join(", "))]
pub struct UnknownName {
    protocol: &'static str,
    kind: Kind,
    name: String,
    known: Vec<&'static str>,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Device => "device",
            Self::Quirk => "quirk",
        })
    }
}

/// Names of a kind with their meaning, patterns of families last.
fn names<S: Named>(kind: Kind) -> impl Iterator<Item = (&'static str, &'static str)> {
    let single = match kind {
        Kind::Device => S::DEVICES,
        Kind::Quirk => S::QUIRKS,
    };
    let families = S::FAMILIES.iter().filter(move |(of, ..)| *of == kind);
    single.iter().map(|choice| (choice.name, choice.about)).chain(families.map(|(_, name, about)| (*name, *about)))
}

/// All devices and quirks of a protocol, as text: a line for each.
#[must_use]
pub fn list<S: Named>() -> String {
    let lines = |title: &str, kind| {
        let width = names::<S>(kind).map(|(name, _)| name.len()).max().unwrap_or_default();
        let lines = names::<S>(kind).map(|(name, about)| format!("  {name:width$}  {about}\n"));
        format!("{title} of {}:\n{}", S::PROTOCOL, lines.collect::<String>())
    };
    lines("Devices", Kind::Device) + &lines("Quirks", Kind::Quirk)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{dmc_device, hoot_node, kos_device};

    fn names_are_known<S: Named + Default + fmt::Debug>() {
        let usual = format!("{:?}", S::default());
        for quirk in S::QUIRKS {
            let changed = S::default().with_quirks(quirk.name).unwrap();
            assert!(format!("{changed:?}") != usual, "{} changes nothing", quirk.name);
        }
        let list = list::<S>();
        for (kind, pattern, about) in S::FAMILIES {
            assert!(list.contains(pattern) && list.contains(about), "{list}");
            let error = S::default().apply(*kind, "loud").unwrap_err().to_string();
            assert!(error.contains(pattern), "{error}");
        }
        let setups: Vec<_> = S::DEVICES.iter().map(|device| S::default().with_device(device.name).unwrap()).collect();
        let setups: Vec<_> = setups.iter().map(|setup| format!("{setup:?}")).collect();
        for (at, setup) in setups.iter().enumerate() {
            assert!(!setups[..at].contains(setup), "{} is the same as another device", S::DEVICES[at].name);
        }
    }

    #[test]
    fn each_name_of_the_lists_has_an_effect() {
        names_are_known::<kos_device::Setup>();
        names_are_known::<dmc_device::Setup>();
        names_are_known::<hoot_node::Setup>();
    }
}
