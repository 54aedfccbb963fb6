//! Data of a device: what it is, and what it stores.

use kos_proto::device::{MotorSpecs, Source};
use kos_proto::message::{Bool, DeviceType, LedMode, NetworkInfo, Password};

use super::Setup;
use crate::kos_host::StoredMove;

/// Data that the device stores. The move and the lamps are lost at a reset, and the rest stays.
#[derive(Debug, Clone)]
pub(super) struct Store {
    guid: [u8; 16],
    /// Password, with the NUL after it if texts end with one.
    password: Vec<u8>,
    pub(super) platform: u8,
    pub(super) trajectory: Option<StoredMove>,
    pub(super) leds: (LedMode, LedMode),
}

impl Store {
    pub(super) fn new(setup: &Setup) -> Self {
        let maker = u128::from_be_bytes(*b"kOSrig\x40\0\0\0\0\0\0\0\0\0");
        let mut store = Self {
            guid: (maker | u128::from(setup.number)).to_be_bytes(),
            password: Vec::new(),
            platform: setup.options.platform(),
            trajectory: None,
            leds: (LedMode::OFF, LedMode::OFF),
        };
        store.set_password(&setup.password, setup);
        store
    }

    pub(super) fn password(&self, setup: &Setup) -> &[u8] {
        self.password.strip_suffix(end(setup)).unwrap_or_default()
    }

    pub(super) fn set_password(&mut self, password: &[u8], setup: &Setup) {
        self.password = [password, end(setup)].concat();
    }

    /// Data that a message may need.
    pub(super) fn source<'s>(&'s self, setup: &Setup, motors: &'s [MotorSpecs]) -> Source<'s> {
        let [.., n3, n4, n5, n6, n7] = self.guid;
        let network = NetworkInfo {
            dhcp: Bool::TRUE,
            // The first byte says that the address is administered locally.
            mac_address: [2, n3, n4, n5, n6, n7].into(),
            ip_address: setup.address.into(),
            device_type: DeviceType::SECOND_SHOOTER_PRO,
            ..NetworkInfo::default()
        };
        Source {
            older_dialect: setup.older_dialect,
            device_type: DeviceType::SECOND_SHOOTER_PRO,
            firmware_version: setup.firmware,
            network,
            guid: &self.guid,
            password: Password(&self.password),
            motors,
            trajectory: self.trajectory.as_ref().map(StoredMove::data).unwrap_or_default(),
        }
    }
}

/// End of each text.
const fn end(setup: &Setup) -> &'static [u8] {
    if setup.nul_terminated { b"\0" } else { b"" }
}
