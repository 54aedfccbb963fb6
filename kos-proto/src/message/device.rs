//! The device: addresses in the network, what it is and does, passwords, lamps, identities.

use core::fmt;
use core::net::Ipv4Addr;

use motion_core::wire::{Block16, Bool, Bytes, Field, Newer, Password, Reader, Value, Writer};
use motion_core::{__newtype, flags, message, open_enum};
use zerocopy::ByteOrder;

use super::{Normalized, PlaybackState, Seconds};

message! {
    /// The line is in use. Not answered. Source: kOS, USB; decision K-U6.
    #[derive(Default)]
    pub struct KeepAlive<'a> in BE {}

    /// What do the lamps do? Source: kOS, (Get)`LEDStatus`.
    #[derive(Default)]
    pub struct GetLEDStatus<'a> in BE {}

    /// What is the device, and what does it do at present? Source: kOS, (Get)`DeviceInfo`.
    #[derive(Default)]
    pub struct GetDeviceInfo<'a> in BE {}

    /// Which move is stored? Source: kOS, (Get)`TrajectoryData`.
    #[derive(Default)]
    pub struct GetTrajectoryData<'a> in BE {}

    /// Which of all devices is it? Source: kOS, (Get)`DeviceGUID`.
    #[derive(Default)]
    pub struct GetDeviceGUID<'a> in BE {}

    /// Which platform calibrated the motors? Source: kOS, (Get)`SoftwareID`.
    #[derive(Default)]
    pub struct GetSoftwareID<'a> in BE {}

    /// Where are you in the network? On UDP it finds devices; on TCP it keeps the connection alive.
    ///
    /// Source: kOS, (Get)`NetworkInfo`; decisions K-D2 to K-D5.
    #[derive(Default)]
    pub struct GetNetworkInfo<'a> in BE {
        ;
        /// Whether the device shall answer by broadcast to 255.255.255.255. Left out, it means no.
        limited_response: Option<Bool>,
    }

    /// Where the device is in the network: asked, and every five seconds while no client is connected.
    ///
    /// Source: kOS, `NetworkInfo`; decisions K-D2, K-D3 and K-D6.
    #[derive(Default)]
    pub struct NetworkInfo<'a> in BE {
        /// Whether it got its address from a server.
        dhcp: Bool,
        /// Its hardware address.
        mac_address: MacAddress,
        /// Its address; 0.0.0.0 where it does not know.
        ip_address: Ipv4,
        /// Which bits of the address are the network.
        subnet_mask: Ipv4,
        /// Where the network ends.
        gateway: Ipv4,
        /// What it is.
        device_type: DeviceType,
        /// Unused: 0 (safety decision 9).
        device_addr: u8,
    }

    /// What the device is, and what it does just now.
    ///
    /// The password stands in it in clear, before any is asked for: it keeps friends apart, not strangers out. Devices
    /// of the older dialect end before `photo_count`.
    ///
    /// Source: kOS, `DeviceInfo`; safety decisions 7 and 9, decision K-P7.
    pub struct DeviceInfo<'a> in BE {
        /// What it is.
        device_type: DeviceType,
        /// Unused: 0 (safety decision 9).
        device_addr: u8,
        /// Which kind of move it plays.
        playback_mode: PlaybackMode,
        /// How far it is with it.
        playback_status: PlaybackState,
        /// Which firmware runs on it.
        firmware_version: FirmwareVersion,
        /// Unused: 0 (safety decision 9).
        network_id: u8,
        /// Unused: 0 (safety decision 9).
        hardware_id: u8,
        ;
        /// The password that unlocks it; empty where there is none.
        device_password: Password<'a>,
        /// Its inputs for cameras and triggers.
        aux_input_status: AuxInputs,
        /// Time until a delayed move begins.
        delay_time_remaining: Seconds,
        /// How much of the move is over.
        elapsed_time: Normalized,
        /// Photos taken in this move, meaningful in shoot-move-shoot only.
        photo_count: Newer<u32>,
    }

    /// Password of this session.
    ///
    /// Sent as bytes, which the length counts; with ASCII, peers that count characters agree. Source: kOS,
    /// `UserPassword`; decisions K-T1 to K-T4 and K-P1 to K-P6.
    pub struct UserPassword<'a> in BE {
        ;
        /// The password; empty for none.
        password: Password<'a>,
    }

    /// Password that the device shall store.
    ///
    /// Sent as bytes, as [`UserPassword`] is. Source: kOS, `DevicePassword`; decisions K-T1 to K-T4 and K-P1 to K-P6.
    pub struct DevicePassword<'a> in BE {
        ;
        /// The password; empty for none.
        password: Password<'a>,
    }

    /// The lamps of the device and of its slave. Source: kOS, `LEDStatus`.
    #[derive(Default)]
    pub struct LEDStatus<'a> in BE {
        /// The lamp of the device.
        master_status: LedMode,
        /// The lamp of its slave.
        slave_status: LedMode,
    }

    /// The number that no other device has, 16 bytes. Source: kOS, `DeviceGUID`; decision K-B1.
    pub struct DeviceGUID<'a> in BE {
        ;
        /// The number, in the order of RFC 4122 as far as is known.
        guid: Block16<'a>,
    }

    /// The platform of the client that calibrated the motors; another one voids what it stored.
    ///
    /// Source: kOS, `SoftwareID`; safety decision 9, decision K-P8.
    #[derive(Default)]
    pub struct SoftwareID<'a> in BE {
        /// Its number. The specification lists none.
        platform: u8,
    }
}

impl GetNetworkInfo<'_> {
    /// The question that the device answers by broadcast, or else to the one who asks.
    #[must_use]
    pub fn new(limited_response: bool) -> Self {
        Self { limited_response: Some(limited_response.into()), tail: &[] }
    }
}

impl DeviceGUID<'_> {
    /// The number, if it has 16 bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Option<[u8; 16]> {
        self.guid.0.try_into().ok()
    }
}

open_enum! {
    /// What a device is. Source: kOS, `DeviceType`.
    pub struct DeviceType(u8) {
        /// It does not say.
        UNKNOWN = 0,
        /// Second Shooter Plus.
        SECOND_SHOOTER_PLUS = 3,
        /// Second Shooter Pro.
        SECOND_SHOOTER_PRO = 10,
        /// CineShooter.
        CINE_SHOOTER = 11,
    }

    /// The kind of a move. Source: kOS, `PlaybackMode`.
    pub struct PlaybackMode(u8) {
        /// In one go, for video.
        LIVE_MOTION = 0,
        /// Photos while the motors move.
        TIME_LAPSE_CONTINUOUS = 1,
        /// Shoot, move, shoot.
        TIME_LAPSE_SMS = 2,
    }

    /// What a lamp does. Source: kOS, `LEDStatus`.
    pub struct LedMode(u8) {
        /// Dark.
        OFF = 0,
        /// Lit.
        ON = 1,
        /// Blinking slowly.
        SLOW_BLINK = 2,
        /// Blinking fast.
        FAST_BLINK = 3,
    }
}

flags! {
    /// The inputs for cameras and triggers. Unknown bits are kept. Source: kOS, `AuxInputStatus`.
    pub struct AuxInputs(u8) {
        /// Tip of the plug in the device.
        MASTER_TIP = 0x01,
        /// Ring of the plug in the device.
        MASTER_RING = 0x02,
        /// Tip of the plug in its slave.
        SLAVE_TIP = 0x04,
        /// Ring of the plug in its slave.
        SLAVE_RING = 0x08,
        /// There is a slave.
        SLAVE_PRESENT = 0x10,
    }
}

/// A hardware address in the network.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(transparent)]
pub struct MacAddress(pub Bytes<6>);

impl fmt::Display for MacAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        self.0.0.iter().try_for_each(|byte| write!(f, "{}{byte:02x}", core::mem::replace(&mut separator, ":")))
    }
}

impl From<[u8; 6]> for MacAddress {
    fn from(bytes: [u8; 6]) -> Self {
        Self(Bytes(bytes))
    }
}

__newtype! { MacAddress(Bytes<6>) "" }

/// An address in the network, in network order (decision K-D6).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct Ipv4(pub u32);

impl fmt::Display for Ipv4 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The one of `Ipv4Addr` cannot be proven free of panics.
        let mut separator = "";
        let bytes = self.0.to_be_bytes();
        bytes.iter().try_for_each(|byte| write!(f, "{}{byte}", core::mem::replace(&mut separator, ".")))
    }
}

impl From<Ipv4Addr> for Ipv4 {
    fn from(address: Ipv4Addr) -> Self {
        Self(address.into())
    }
}

impl From<Ipv4> for Ipv4Addr {
    fn from(address: Ipv4) -> Self {
        address.0.into()
    }
}

__newtype! { Ipv4(u32) "" }

/// A firmware: major, minor, release and build.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct FirmwareVersion(pub [u8; 4]);

impl fmt::Display for FirmwareVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [major, minor, release, build] = self.0;
        write!(f, "{major}.{minor}.{release}.{build}")
    }
}

impl fmt::Debug for FirmwareVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "FirmwareVersion({self})")
    }
}

impl Field for FirmwareVersion {
    const SIZE: usize = 4;
    const WIRE: &'static str = "[u8; 4]";

    #[inline]
    fn read<O: ByteOrder>(reader: &mut Reader<'_, O>) -> Option<Self> {
        reader.array().map(Self)
    }

    #[inline]
    fn write<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        writer.array(self.0)
    }

    fn value(&self) -> Value<'_> {
        Value::List(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;

    #[test]
    fn addresses_and_versions_print_as_people_write_them() {
        let address = Ipv4Addr::new(192, 168, 50, 1);
        assert_eq!(format!("{} {}", Ipv4::from(address), Ipv4::default()), "192.168.50.1 0.0.0.0");
        assert_eq!((Ipv4::from(address).0, Ipv4Addr::from(Ipv4(0xc0a8_3201))), (0xc0a8_3201, address));
        assert_eq!(format!("{}", MacAddress::from([0, 0x11, 0x22, 0xab, 0xcd, 0xef])), "00:11:22:ab:cd:ef");
        assert_eq!(format!("{:?}", FirmwareVersion([1, 0, 1, 16])), "FirmwareVersion(1.0.1.16)");
        let inputs = [0x01, 0x02, 0x04, 0x08, 0x10, 0x20].map(|bits| format!("{}", AuxInputs(bits)));
        assert_eq!(inputs, ["MASTER_TIP", "MASTER_RING", "SLAVE_TIP", "SLAVE_RING", "SLAVE_PRESENT", "0x20"]);
    }

    #[test]
    fn a_guid_has_16_bytes_or_is_kept_raw() {
        let guid = |bytes| DeviceGUID { guid: Block16(bytes), tail: &[] }.to_bytes();
        assert_eq!((guid(&[7; 16]), guid(&[7; 15]), guid(&[7; 17])), (Some([7; 16]), None, None));
    }
}
