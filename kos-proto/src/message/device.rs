//! Messages about the device: addresses in the network, type and state, passwords, lamps, identities.

use core::fmt;
use core::net::Ipv4Addr;
use core::str::FromStr;

use motion_core::parse::{self, ParseError, ParseProblem};
use motion_core::wire::{Block16, Bool, Bytes, Field, Newer, Password, Reader, Value, Writer};
use motion_core::{__newtype, flags, message, open_enum};
use zerocopy::ByteOrder;

use super::{Normalized, PlaybackState, Seconds};

message! {
    /// Sign that the line is in use. Not answered. Source: kOS, USB; decision K-U6.
    #[derive(Default)]
    pub struct KeepAlive<'a> in BE {}

    /// Question for the lamps. Source: kOS, (Get)`LEDStatus`.
    #[derive(Default)]
    pub struct GetLEDStatus<'a> in BE {}

    /// Question for the type and the state of the device. Source: kOS, (Get)`DeviceInfo`.
    #[derive(Default)]
    pub struct GetDeviceInfo<'a> in BE {}

    /// Question for the stored move. Source: kOS, (Get)`TrajectoryData`.
    #[derive(Default)]
    pub struct GetTrajectoryData<'a> in BE {}

    /// Question for the number that no other device has. Source: kOS, (Get)`DeviceGUID`.
    #[derive(Default)]
    pub struct GetDeviceGUID<'a> in BE {}

    /// Question for the platform that calibrated the motors. Source: kOS, (Get)`SoftwareID`.
    #[derive(Default)]
    pub struct GetSoftwareID<'a> in BE {}

    /// Question for the address of the device in the network.
    ///
    /// On UDP it finds devices; on TCP it keeps the connection alive. Source: kOS, (Get)`NetworkInfo`; decisions K-D2
    /// to K-D5.
    #[derive(Default)]
    pub struct GetNetworkInfo<'a> in BE {
        ;
        /// Whether the device shall answer by broadcast to 255.255.255.255. A message without the field means no.
        limited_response: Option<Bool>,
    }

    /// Address of the device in the network.
    ///
    /// Devices send it as an answer, and every five seconds while no client is connected. Source: kOS, `NetworkInfo`;
    /// decisions K-D2, K-D3 and K-D6.
    #[derive(Default)]
    pub struct NetworkInfo<'a> in BE {
        /// Whether the device got its address from a DHCP server.
        dhcp: Bool,
        /// Hardware address of the device.
        mac_address: MacAddress,
        /// IP address of the device; 0.0.0.0 if the device does not know it.
        ip_address: Ipv4,
        /// Subnet mask: the bits of the address that name the network.
        subnet_mask: Ipv4,
        /// Unused: devices are not found across routers.
        gateway: Ipv4,
        /// Type of the device.
        device_type: DeviceType,
        /// Unused: 0 (safety decision 9).
        device_addr: u8,
    }

    /// Type and present state of the device.
    ///
    /// The message holds the password in clear, and devices send it before they ask for a password. So the password
    /// prevents clients from using each other's devices by mistake, but it does not protect against strangers. Messages
    /// of the older dialect end before `photo_count`.
    ///
    /// Source: kOS, `DeviceInfo`; safety decisions 7 and 9, decision K-P7.
    #[derive(Default)]
    pub struct DeviceInfo<'a> in BE {
        /// Type of the device.
        device_type: DeviceType,
        /// Unused: 0 (safety decision 9).
        device_addr: u8,
        /// Kind of the move that the device plays.
        playback_mode: PlaybackMode,
        /// State of the device in its move.
        playback_status: PlaybackState,
        /// Version of the firmware.
        firmware_version: FirmwareVersion,
        /// Unused: 0 (safety decision 9).
        network_id: u8,
        /// Unused: 0 (safety decision 9).
        hardware_id: u8,
        ;
        /// Password that unlocks the device; empty if there is no password.
        device_password: Password<'a>,
        /// Inputs of the device for cameras and triggers.
        aux_input_status: AuxInputs,
        /// Time until a delayed move begins.
        delay_time_remaining: Seconds,
        /// Elapsed part of the move, 0 to 1.
        elapsed_time: Normalized,
        /// Number of photos taken in this move. It has a meaning in shoot-move-shoot only.
        photo_count: Newer<u32>,
    }

    /// Password of this session.
    ///
    /// The password is sent as bytes, and its length counts bytes. Some peers count characters; with ASCII both counts
    /// are the same. Source: kOS, `UserPassword`; decisions K-T1 to K-T4 and K-P1 to K-P6.
    #[derive(Default)]
    pub struct UserPassword<'a> in BE {
        ;
        /// Password; empty if there is no password.
        password: Password<'a>,
    }

    /// Password that the device shall store.
    ///
    /// The password is sent as bytes, in the same way as [`UserPassword`]. Source: kOS, `DevicePassword`; decisions
    /// K-T1 to K-T4 and K-P1 to K-P6.
    #[derive(Default)]
    pub struct DevicePassword<'a> in BE {
        ;
        /// Password; empty if there is no password.
        password: Password<'a>,
    }

    /// State of the lamps of the device and of its slave. Source: kOS, `LEDStatus`.
    #[derive(Default)]
    pub struct LEDStatus<'a> in BE {
        /// Lamp of the device.
        master_status: LedMode,
        /// Lamp of the slave.
        slave_status: LedMode,
    }

    /// Number of the device, which no other device has: 16 bytes. Source: kOS, `DeviceGUID`; decision K-B1.
    #[derive(Default)]
    pub struct DeviceGUID<'a> in BE {
        ;
        /// Number of the device, probably in the byte order of RFC 4122.
        guid: Block16<'a>,
    }

    /// Platform of the client that calibrated the motors.
    ///
    /// The calibration is void for a client of another platform. Source: kOS, `SoftwareID`; safety decision 9, decision
    /// K-P8.
    #[derive(Default)]
    pub struct SoftwareID<'a> in BE {
        /// Number of the platform. The specification lists no numbers.
        platform: u8,
    }
}

impl GetNetworkInfo<'_> {
    /// Question that the device answers by broadcast if `limited_response` is true, otherwise to the client that asks.
    #[must_use]
    pub fn new(limited_response: bool) -> Self {
        Self { limited_response: Some(limited_response.into()), tail: &[] }
    }
}

impl DeviceGUID<'_> {
    /// Number of the device; `None` if it does not have 16 bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Option<[u8; 16]> {
        self.guid.0.try_into().ok()
    }
}

open_enum! {
    /// Type of a device. Source: kOS, `DeviceType`.
    pub struct DeviceType(u8) {
        /// The device does not say its type.
        UNKNOWN = 0,
        /// Second Shooter Plus.
        SECOND_SHOOTER_PLUS = 3,
        /// Second Shooter Pro.
        SECOND_SHOOTER_PRO = 10,
        /// CineShooter.
        CINE_SHOOTER = 11,
    }

    /// Kind of a move. Source: kOS, `PlaybackMode`.
    pub struct PlaybackMode(u8) {
        /// Live motion, for video.
        LIVE_MOTION = 0,
        /// Time lapse that takes photos while the motors move.
        TIME_LAPSE_CONTINUOUS = 1,
        /// Time lapse that takes photos while the motors rest: shoot, move, shoot.
        TIME_LAPSE_SMS = 2,
    }

    /// State of a lamp. Source: kOS, `LEDStatus`.
    pub struct LedMode(u8) {
        /// The lamp is off.
        OFF = 0,
        /// The lamp is on.
        ON = 1,
        /// The lamp blinks slowly.
        SLOW_BLINK = 2,
        /// The lamp blinks fast.
        FAST_BLINK = 3,
    }
}

flags! {
    /// Inputs for cameras and triggers. Unknown bits are kept. Source: kOS, `AuxInputStatus`.
    pub struct AuxInputs(u8) {
        /// Tip of the plug in the device.
        MASTER_TIP = 0x01,
        /// Ring of the plug in the device.
        MASTER_RING = 0x02,
        /// Tip of the plug in the slave.
        SLAVE_TIP = 0x04,
        /// Ring of the plug in the slave.
        SLAVE_RING = 0x08,
        /// A slave is present.
        SLAVE_PRESENT = 0x10,
    }
}

/// Hardware address in the network.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(transparent)]
pub struct MacAddress(pub Bytes<6>);

impl fmt::Display for MacAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        self.0.0.iter().try_for_each(|byte| write!(f, "{}{byte:02x}", core::mem::replace(&mut separator, ":")))
    }
}

/// Reads what [`Display`](fmt::Display) prints.
impl FromStr for MacAddress {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        parse::bytes::<6>(text, b':', 16).map(Self::from).map_err(|at| ParseError {
            what: "MacAddress",
            why: ParseProblem::Form { at, form: "six bytes such as 00:1b:c5:09:00:01" },
        })
    }
}

impl From<[u8; 6]> for MacAddress {
    fn from(bytes: [u8; 6]) -> Self {
        Self(Bytes(bytes))
    }
}

__newtype! { MacAddress(Bytes<6>) "" }

/// IP address in the network, in network order (decision K-D6).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct Ipv4(pub u32);

impl fmt::Display for Ipv4 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // `Display` of `Ipv4Addr` cannot be proven free of panics.
        let mut separator = "";
        let bytes = self.0.to_be_bytes();
        bytes.iter().try_for_each(|byte| write!(f, "{}{byte}", core::mem::replace(&mut separator, ".")))
    }
}

/// Reads what [`Display`](fmt::Display) prints.
impl FromStr for Ipv4 {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        parse::bytes::<4>(text, b'.', 10).map(|bytes| Self(u32::from_be_bytes(bytes))).map_err(|at| ParseError {
            what: "Ipv4",
            why: ParseProblem::Form { at, form: "four numbers such as 192.168.50.1" },
        })
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

/// Version of a firmware: major, minor, release and build.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct FirmwareVersion(pub [u8; 4]);

impl fmt::Display for FirmwareVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [major, minor, release, build] = self.0;
        write!(f, "{major}.{minor}.{release}.{build}")
    }
}

/// Reads what [`Display`](fmt::Display) prints.
impl FromStr for FirmwareVersion {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        parse::bytes::<4>(text, b'.', 10).map(Self).map_err(|at| ParseError {
            what: "FirmwareVersion",
            why: ParseProblem::Form { at, form: "four numbers such as 1.2.0.15" },
        })
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
