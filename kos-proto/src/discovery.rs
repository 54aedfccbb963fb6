//! Discovery: UDP datagrams with which clients and devices find each other.
//!
//! A device without a client announces itself every five seconds. A client listens, and may ask. A datagram is one
//! message, and a bad one is dropped without effect on others. The caller has the sockets and the clock.
//!
//! A client keeps the devices that it heard in [`Devices`]:
//!
//! ```
//! use core::net::Ipv4Addr;
//! use kos_proto::Millis;
//! use kos_proto::discovery::{Datagram, Devices, Event, Input};
//!
//! // The question, to be sent to 255.255.255.255:5520.
//! let mut question = [0; 7];
//! Datagram::question(true).encode_into(&mut question)?;
//! assert_eq!(question, *b"\x04\0\x07\0\x02\x01\x01");
//!
//! // The answer of a device that does not know its address.
//! let bytes = b"\x04\0\x1b\0\x02\x02\x01\0\x11\x22\x33\x44\x55\0\0\0\0\xff\xff\xff\0\xc0\xa8\x32\x01\x0a\0";
//! let source = Ipv4Addr::new(192, 168, 50, 7);
//! let devices: Devices = Devices::default();
//! let (devices, output) = devices.step(Millis(0), Input::Datagram { source: source.into(), bytes });
//! let Ok(Some(Event::Found(device))) = output.heard else { panic!("{output:?}") };
//! assert_eq!(Ipv4Addr::from(device.address()), source);
//!
//! // After fifteen seconds of silence, the device is gone.
//! let (devices, output) = devices.step(output.wake.expect("something to wait for"), Input::Wake);
//! assert_eq!(output.gone[..], [device]);
//! assert_eq!(devices.iter().count(), 0);
//! # Ok::<(), kos_proto::EncodeError>(())
//! ```
//!
//! Source: kOS, `NetworkInfo`; decisions K-D1 to K-D6. Anyone on the network can send anything, so a person should
//! confirm a device that was found.

use core::fmt;

use arrayvec::ArrayVec;
use motion_core::time::Millis;
use motion_core::wire::{Bool, DecodeError, EncodeError};

use crate::message::{GetNetworkInfo, Ipv4, NetworkInfo};
use crate::{DeviceMessage, Frame, FrameError, HostMessage, MessageId, MessageType};

/// Port of TCP, and the default port of discovery. The specification names no port for UDP (decision K-D1).
pub const DEFAULT_PORT: u16 = 5520;
/// Time between two announcements of a device without a client, and between two questions of a client, in milliseconds
/// (decision K-D2).
pub const ANNOUNCE_EVERY: u64 = 5_000;
/// Time of silence after which a device is gone, in milliseconds: three announcements.
pub const FORGET_AFTER: u64 = 15_000;

/// Content of a datagram.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Datagram<'a> {
    /// Question of a client: which devices are there.
    Question(GetNetworkInfo<'a>),
    /// Announcement of a device with its address.
    Announcement(NetworkInfo<'a>),
}

impl<'a> Datagram<'a> {
    /// Question of a client, to be answered by broadcast, or else only to the client.
    #[must_use]
    pub fn question(limited_response: bool) -> Self {
        Self::Question(GetNetworkInfo::new(limited_response))
    }

    /// Reads one datagram of a client or a device.
    ///
    /// # Errors
    ///
    /// [`DatagramError`] if the datagram is not a message, is cut off, or is a message that does not belong to
    /// discovery.
    pub fn decode(bytes: &'a [u8]) -> Result<Self, DatagramError> {
        let frame = Frame::decode(bytes)?;
        if let DeviceMessage::NetworkInfo(info) = DeviceMessage::decode(&frame)? {
            return Ok(Self::Announcement(info));
        }
        match HostMessage::decode(&frame)? {
            HostMessage::GetNetworkInfo(question) => Ok(Self::Question(question)),
            _ => Err(DatagramError::Unrelated { id: frame.id(), kind: frame.kind() }),
        }
    }

    /// Length of the datagram, in bytes.
    #[must_use]
    pub fn encoded_len(&self) -> usize {
        match *self {
            Self::Question(question) => HostMessage::from(question).encoded_len(),
            Self::Announcement(info) => DeviceMessage::from(info).encoded_len(),
        }
    }

    /// Writes the datagram to the front of `out`, and returns the number of bytes written.
    ///
    /// # Errors
    ///
    /// [`EncodeError`] if it does not fit.
    pub fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        match *self {
            Self::Question(question) => HostMessage::from(question).encode_into(out),
            Self::Announcement(info) => DeviceMessage::from(info).encode_into(out),
        }
    }
}

/// Reason why a datagram is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum DatagramError {
    /// The datagram is not exactly one message.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The message is cut off.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// The message does not belong to discovery.
    #[error("message {id}, {kind}, does not belong to discovery")]
    Unrelated {
        /// Identifier of the message.
        id: MessageId,
        /// Type of the message: it sets, asks or answers.
        kind: MessageType,
    },
}

/// Device that announced itself.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Announced {
    /// Announced information, without unknown trailing bytes.
    pub info: NetworkInfo<'static>,
    /// Address that the datagram came from.
    pub source: Ipv4,
}

impl Announced {
    fn new(info: NetworkInfo<'_>, source: Ipv4) -> Self {
        let NetworkInfo { dhcp, mac_address, ip_address, subnet_mask, gateway, device_type, device_addr, tail: _ } =
            info;
        let tail = &[];
        let info = NetworkInfo { dhcp, mac_address, ip_address, subnet_mask, gateway, device_type, device_addr, tail };
        Self { info, source }
    }

    /// Address to connect to: the announced one, or the source of the datagram if the announced one is 0.0.0.0
    /// (decision K-D6).
    #[must_use]
    pub fn address(&self) -> Ipv4 {
        if self.info.ip_address == Ipv4::default() { self.source } else { self.info.ip_address }
    }
}

impl fmt::Debug for Announced {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Announced").field("info", &self.info).field("source", &self.source).finish()
    }
}

/// Devices that a client has heard, up to `N`, each listed once by its hardware address.
///
/// A full table takes no new device until one is gone, so a flood of invented devices cannot remove the known ones.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct Devices<const N: usize = 16> {
    list: ArrayVec<Heard, N>,
}

/// Device, and the time when it was last heard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Heard {
    device: Announced,
    at: Millis,
}

/// Input of [`Devices`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Input<'a> {
    /// A datagram came.
    Datagram {
        /// Address that it came from.
        source: Ipv4,
        /// All its bytes.
        bytes: &'a [u8],
    },
    /// The time to wake has come.
    Wake,
}

/// Output of one step.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[must_use]
pub struct Output<const N: usize = 16> {
    /// Devices that were silent for too long and are forgotten.
    pub gone: ArrayVec<Announced, N>,
    /// News in the datagram, or the reason why it was dropped.
    pub heard: Result<Option<Event>, DatagramError>,
    /// Time of the next wake; `None` while no device is known.
    pub wake: Option<Millis>,
}

/// News in a datagram.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Event {
    /// A device that is new.
    Found(Announced),
    /// A device whose announcement or source address changed.
    Changed(Announced),
    /// A device for which the table has no room.
    NoRoom(Announced),
    /// A client asks which devices are there.
    Asked {
        /// Address of the client.
        source: Ipv4,
        /// Whether a device should answer by broadcast; if not, to the client only.
        limited_response: bool,
    },
}

motion_core::display! {
    Event {
        Found(device) => "found {device}";
        Changed(device) => "changed: {device}";
        NoRoom(device) => "no room for {device}";
        Asked { source, .. } => "{source} asks which devices are there";
    }
}

impl fmt::Display for Announced {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at {}", self.info.device_type, self.address())
    }
}

impl<const N: usize> Devices<N> {
    /// Advances the table: forgets devices that were silent for too long, then stores the announced one.
    pub fn step(self, now: Millis, input: Input<'_>) -> (Self, Output<N>) {
        let (mut list, mut gone) = (ArrayVec::new(), ArrayVec::new());
        for heard in self.list {
            // There is room, because neither list becomes longer than the one that is divided.
            let _ = if now.since(heard.at) < FORGET_AFTER {
                list.try_push(heard).is_ok()
            } else {
                gone.try_push(heard.device).is_ok()
            };
        }
        let mut devices = Self { list };
        let heard = match input {
            Input::Wake => Ok(None),
            Input::Datagram { source, bytes } => {
                Datagram::decode(bytes).map(|said| devices.received(now, source, &said))
            }
        };
        let wake = devices.list.iter().map(|heard| heard.at.after(FORGET_AFTER)).min();
        (devices, Output { gone, heard, wake })
    }

    fn received(&mut self, now: Millis, source: Ipv4, said: &Datagram<'_>) -> Option<Event> {
        let info = match *said {
            Datagram::Announcement(info) => info,
            Datagram::Question(GetNetworkInfo { limited_response, .. }) => {
                return Some(Event::Asked { source, limited_response: limited_response.is_some_and(Bool::get) });
            }
        };
        let device = Announced::new(info, source);
        let heard = Heard { device, at: now };
        if let Some(known) = self.list.iter_mut().find(|known| known.device.info.mac_address == info.mac_address) {
            let was = core::mem::replace(known, heard).device;
            return (was != device).then_some(Event::Changed(device));
        }
        Some(if self.list.try_push(heard).is_ok() { Event::Found(device) } else { Event::NoRoom(device) })
    }

    /// The devices, in the order in which they were found.
    pub fn iter(&self) -> impl Iterator<Item = &Announced> {
        self.list.iter().map(|heard| &heard.device)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::DeviceType;
    use std::vec::Vec;
    use std::{string::ToString, vec};

    const SOURCE: Ipv4 = Ipv4(0xc0a8_3207);

    fn info(mac: u8, ip_address: u32) -> NetworkInfo<'static> {
        NetworkInfo {
            dhcp: Bool::TRUE,
            mac_address: [0, 1, 2, 3, 4, mac].into(),
            ip_address: Ipv4(ip_address),
            subnet_mask: Ipv4(0xffff_ff00),
            gateway: Ipv4(0xc0a8_3201),
            device_type: DeviceType::SECOND_SHOOTER_PRO,
            device_addr: 0,
            tail: &[],
        }
    }

    fn datagram(said: &Datagram<'_>) -> Vec<u8> {
        let mut bytes = vec![0; said.encoded_len()];
        assert_eq!(said.encode_into(&mut bytes), Ok(bytes.len()));
        assert_eq!(Datagram::decode(&bytes).as_ref(), Ok(said));
        bytes
    }

    fn announced<const N: usize>(devices: Devices<N>, now: u64, info: NetworkInfo<'_>) -> (Devices<N>, Output<N>) {
        let bytes = datagram(&Datagram::Announcement(info));
        devices.step(Millis(now), Input::Datagram { source: SOURCE, bytes: &bytes })
    }

    #[test]
    fn other_datagrams_are_errors_that_say_why() {
        assert_eq!(datagram(&Datagram::question(false)), b"\x04\0\x07\0\x02\x01\0");
        let small = EncodeError::BufferTooSmall { needed: 7, have: 6 };
        assert_eq!(Datagram::question(true).encode_into(&mut [0; 6]), Err(small));
        // Without its byte it is also a question (decision K-D5).
        let bare = Datagram::Question(GetNetworkInfo { limited_response: None, tail: &[] });
        assert_eq!(datagram(&bare), b"\x04\0\x06\0\x02\x01");

        let whole = datagram(&Datagram::Announcement(info(5, 0)));
        for len in 0..whole.len() {
            let error = Datagram::decode(&whole[..len]).unwrap_err();
            assert!(matches!(error, DatagramError::Frame(FrameError::Truncated { .. })), "{error}");
        }
        let two = [&whole[..], &whole].concat();
        assert_eq!(Datagram::decode(&two), Err(FrameError::Trailing { extra: 27 }.into()));
        let cut = [&b"\x04\0\x1a"[..], &whole[3..26]].concat();
        let short = DecodeError::Truncated { what: "NetworkInfo", needed: 21, have: 20 };
        assert_eq!(Datagram::decode(&cut), Err(short.into()));
        let keep_alive = Datagram::decode(&[4, 0, 6, 0, 0, 0]).unwrap_err();
        assert_eq!(keep_alive, DatagramError::Unrelated { id: MessageId::KEEP_ALIVE, kind: MessageType::SET });
        assert_eq!(keep_alive.to_string(), "message KEEP_ALIVE, SET, does not belong to discovery");
        // A `Set` of the network information is not a question either.
        let set = Datagram::decode(&[4, 0, 7, 0, 2, 0, 1]).unwrap_err();
        assert_eq!(set, DatagramError::Unrelated { id: MessageId::NETWORK_INFO, kind: MessageType::SET });
    }

    /// Decision K-D6.
    #[test]
    fn the_address_is_the_announced_one_or_the_source() {
        let at = |ip| Announced { info: info(5, ip), source: SOURCE }.address();
        assert_eq!((at(0), at(0x0a00_0001)), (SOURCE, Ipv4(0x0a00_0001)));
    }

    #[test]
    fn a_device_is_found_once_and_reported_again_when_it_changes() {
        let (devices, output) = announced(Devices::<4>::default(), 0, info(5, 0));
        let first = Announced { info: info(5, 0), source: SOURCE };
        assert_eq!((output.heard, output.wake), (Ok(Some(Event::Found(first))), Some(Millis(FORGET_AFTER))));

        // The same announcement with an unknown tail.
        let (devices, output) = announced(devices, 5_000, NetworkInfo { tail: &[7], ..info(5, 0) });
        assert_eq!((output.heard, output.wake), (Ok(None), Some(Millis(20_000))));

        let (devices, output) = announced(devices, 6_000, info(5, 1));
        let moved = Announced { info: info(5, 1), source: SOURCE };
        assert_eq!(output.heard, Ok(Some(Event::Changed(moved))));

        let (devices, output) = announced(devices, 7_000, info(6, 0));
        assert!(matches!(output.heard, Ok(Some(Event::Found(_)))));
        assert_eq!(output.wake, Some(Millis(21_000)), "then the first device may be gone");
        let macs: Vec<_> = devices.iter().map(|device| device.info.mac_address).collect();
        assert_eq!(macs, [info(5, 0).mac_address, info(6, 0).mac_address]);
    }

    #[test]
    fn a_device_is_gone_after_fifteen_seconds_of_silence() {
        let (devices, _) = announced(Devices::<4>::default(), 0, info(5, 0));
        let (devices, _) = announced(devices, 1_000, info(6, 0));
        let (devices, output) = devices.step(Millis(14_999), Input::Wake);
        assert_eq!((output.gone.len(), output.heard, output.wake), (0, Ok(None), Some(Millis(15_000))));
        let (devices, output) = devices.step(Millis(15_000), Input::Wake);
        assert_eq!(output.gone[..], [Announced { info: info(5, 0), source: SOURCE }]);
        assert_eq!(output.wake, Some(Millis(16_000)));

        // An announcement that comes too late is a new device. Any datagram advances the time, even a bad one.
        let (devices, output) = announced(devices, 16_000, info(6, 0));
        assert_eq!(output.gone.len(), 1);
        assert!(matches!(output.heard, Ok(Some(Event::Found(_)))));
        let (devices, output) = devices.step(Millis(31_000), Input::Datagram { source: SOURCE, bytes: b"?" });
        assert_eq!((output.gone.len(), output.wake, devices), (1, None, Devices::default()));
        assert_eq!(output.heard, Err(FrameError::BadVersion { found: b'?' }.into()));
    }

    #[test]
    fn a_flood_of_devices_does_not_remove_known_devices() {
        let (mut devices, mut found) = (Devices::<3>::default(), 0);
        for mac in 0..200 {
            let (next, output) = announced(devices, mac.into(), info(mac, 0));
            found += usize::from(matches!(output.heard, Ok(Some(Event::Found(_)))));
            assert!(matches!(output.heard, Ok(Some(Event::Found(_) | Event::NoRoom(_)))));
            devices = next;
        }
        assert_eq!((found, devices.iter().count()), (3, 3));
        let (devices, output) = announced(devices, 300, info(1, 0));
        assert_eq!(output.heard, Ok(None), "known, and refreshed");
        let (_, output) = announced(devices, 15_299, info(99, 0));
        assert_eq!(output.gone.len(), 2, "room again");
        assert!(matches!(output.heard, Ok(Some(Event::Found(_)))));
    }

    #[test]
    fn a_question_says_where_to_send_the_answer() {
        for (said, limited_response) in [(Datagram::question(true), true), (Datagram::question(false), false)] {
            let input = datagram(&said);
            let input = Input::Datagram { source: SOURCE, bytes: &input };
            let (devices, output) = Devices::<1>::default().step(Millis(0), input);
            assert_eq!(output.heard, Ok(Some(Event::Asked { source: SOURCE, limited_response })));
            assert_eq!((devices, output.wake), (Devices::default(), None));
        }
        let bare = Datagram::Question(GetNetworkInfo { limited_response: None, tail: &[] });
        let input = datagram(&bare);
        let (_, output) = Devices::<1>::default().step(Millis(0), Input::Datagram { source: SOURCE, bytes: &input });
        assert_eq!(output.heard, Ok(Some(Event::Asked { source: SOURCE, limited_response: false })));
    }
}
