//! What a device is built of, and how it behaves.

use std::net::Ipv4Addr;

use kos_proto::device::{MotorProfile, Options};
use kos_proto::message::{AxisKind, MotorType, RotationsPerSecond, RotationsPerSecondSquared};
use motion_core::trajectory::Range;

/// How a device is built, what it stores at first, and its quirks.
///
/// ```
/// use rigs::kos_device::Setup;
///
/// let setup = Setup { password: b"gaffer".to_vec(), ..Setup::with_motors(2) }.with_quirks("older-dialect")?;
/// assert!(setup.older_dialect && setup.motors.len() == 2);
/// # Ok::<(), rigs::kos_device::QuirkError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// How the machine behaves; its motors are those of [`motors`](Self::motors).
    pub options: Options,
    /// Whether it speaks the older dialect.
    pub older_dialect: bool,
    /// The stored password; empty for none.
    pub password: Vec<u8>,
    /// The motors, motor 1 first: at most ten.
    pub motors: Vec<MotorSetup>,
    /// Where it is in the network, as it tells; 0.0.0.0 if it does not know.
    pub address: Ipv4Addr,
    /// The number that tells it from others: it makes the hardware address and the GUID.
    pub number: u64,
}

/// A motor of a device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorSetup {
    /// What it says of itself, and keeps.
    pub profile: MotorProfile,
    /// Its ends, in rotations from where it is at first; `None` if it can go anywhere.
    pub travel: Option<Range>,
}

impl MotorSetup {
    /// A motor that does what the specification allows such an axis, and can go anywhere.
    #[must_use]
    pub fn new(kind: AxisKind) -> Self {
        let speed = kind.max_speed().unwrap_or(RotationsPerSecond(200.0));
        let acceleration = kind.max_acceleration().unwrap_or(RotationsPerSecondSquared(50.0));
        let fiz = matches!(kind, AxisKind::Focus | AxisKind::Iris | AxisKind::Zoom);
        let profile = MotorProfile {
            motor_type: if fiz { MotorType::FIZ } else { MotorType::AXIS },
            max_max_setup_speed: speed,
            max_max_move_speed: speed,
            max_max_acceleration: acceleration,
        };
        Self { profile, travel: None }
    }

    /// The same between two ends.
    #[must_use]
    pub const fn within(self, travel: Range) -> Self {
        Self { travel: Some(travel), ..self }
    }
}

impl Default for Setup {
    /// A slider with a head, without a password.
    fn default() -> Self {
        Self::with_motors(3)
    }
}

/// A text that names no quirk.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("a kOS device has no quirk {0:?}: it has {QUIRKS}", QUIRKS = names())]
pub struct QuirkError(String);

type Quirk = fn(&mut Setup);

const QUIRKS: [(&str, Quirk); 6] = [
    ("older-dialect", |setup| setup.older_dialect = true),
    ("begin-nonzero", |setup| setup.options.quirk_begin_nonzero = true),
    ("empty-password", |setup| setup.options.require_empty_password = true),
    ("stop-when-alone", |setup| setup.options.stop_when_alone = true),
    ("push-address", |setup| setup.options.push_every = Some(5000)),
    ("no-progress", |setup| setup.options.progress_every = None),
];

fn names() -> String {
    QUIRKS.map(|(name, _)| name).join(", ")
}

impl Setup {
    /// A device with so many motors: slider, pan, tilt, focus, zoom, and sliders.
    #[must_use]
    pub fn with_motors(count: usize) -> Self {
        let head = [AxisKind::Slider, AxisKind::Pan, AxisKind::Tilt, AxisKind::Focus, AxisKind::Zoom];
        let kinds = head.into_iter().chain(std::iter::repeat(AxisKind::Slider));
        Self {
            options: Options::default(),
            older_dialect: false,
            password: Vec::new(),
            motors: kinds.map(MotorSetup::new).take(count.min(kos_proto::summary::MOTORS)).collect(),
            address: Ipv4Addr::UNSPECIFIED,
            number: 1,
        }
    }

    /// With the quirks of a list such as `older-dialect,no-progress`: `older-dialect`, `begin-nonzero` (the count of
    /// positions stays when a range is marked), `empty-password` (the empty one has to be said), `stop-when-alone`,
    /// `push-address` (told over TCP every five seconds), `no-progress` (a move that runs is not told of).
    ///
    /// # Errors
    ///
    /// [`QuirkError`] says which there are.
    pub fn with_quirks(mut self, text: &str) -> Result<Self, QuirkError> {
        for name in text.split(',').map(str::trim) {
            let (_, quirk) =
                QUIRKS.iter().find(|(known, _)| *known == name).ok_or_else(|| QuirkError(name.to_owned()))?;
            quirk(&mut self);
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quirks_are_named() {
        let all = Setup::default().with_quirks(&names()).unwrap();
        assert!(all.older_dialect && all.options.quirk_begin_nonzero && all.options.require_empty_password);
        assert!(all.options.stop_when_alone && all.options.push_every == Some(5000));
        assert_eq!(all.options.progress_every, None);
        let error = Setup::default().with_quirks("loud").unwrap_err().to_string();
        assert!(error.starts_with("a kOS device has no quirk \"loud\": it has older-dialect, "), "{error}");
        assert_eq!(Setup::with_motors(99).motors.len(), 10);
    }
}
