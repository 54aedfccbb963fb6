//! Devices that a simulated rig can stand for, and single quirks, by name.
//!
//! ```
//! use rigs::device::Named;
//! use rigs::kos_device::Setup;
//!
//! let setup = Setup::with_motors(2).with_device("mild")?.with_quirks("older-dialect,no-progress")?;
//! assert!(setup.older_dialect && setup.motors.len() == 2);
//! let error = Setup::default().with_device("loud").unwrap_err().to_string();
//! assert!(error.starts_with("kOS has no device \"loud\": it has mild"), "{error}");
//! # Ok::<(), rigs::device::UnknownName>(())
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

    /// Applies a name of a family that is too large for the lists, such as the version of a firmware. Returns false if the
    /// name is not of such a family.
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
            let known = all.iter().map(|choice| choice.name).collect();
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

/// All devices and quirks of a protocol, as text: a line for each.
#[must_use]
pub fn list<S: Named>() -> String {
    let lines = |kind: &str, all: &[Choice<S>]| {
        let width = all.iter().map(|choice| choice.name.len()).max().unwrap_or_default();
        let lines = all.iter().map(|choice| format!("  {:width$}  {}\n", choice.name, choice.about));
        format!("{kind} of {}:\n{}", S::PROTOCOL, lines.collect::<String>())
    };
    lines("Devices", S::DEVICES) + &lines("Quirks", S::QUIRKS)
}
