//! Discovery: datagrams over UDP, by which clients and devices find each other.
//!
//! A device without a client announces itself every five seconds; a client listens, and may ask. A datagram is one
//! message; a bad one is dropped alone. Sockets and clock are the caller's.
//!
//! A client keeps the devices it hears of in [`Devices`]:
//!
//! ```
//! use core::net::Ipv4Addr;
//! use kos_proto::discovery::{Datagram, Devices, Event, Input};
//! use motion_core::time::Millis;
//!
//! // What it asks, to be sent to 255.255.255.255:5520.
//! let mut question = [0; 7];
//! Datagram::question(true).encode_into(&mut question)?;
//! assert_eq!(question, *b"\x04\0\x07\0\x02\x01\x01");
//!
//! // What it hears: a device that does not know its address.
//! let bytes = b"\x04\0\x1b\0\x02\x02\x01\0\x11\x22\x33\x44\x55\0\0\0\0\xff\xff\xff\0\xc0\xa8\x32\x01\x0a\0";
//! let source = Ipv4Addr::new(192, 168, 50, 7);
//! let devices: Devices = Devices::default();
//! let (devices, output) = devices.step(Millis(0), Input::Datagram { source: source.into(), bytes });
//! let Ok(Some(Event::Found(device))) = output.heard else { panic!("{output:?}") };
//! assert_eq!(Ipv4Addr::from(device.address()), source);
//!
//! // Fifteen seconds of silence later.
//! let (devices, output) = devices.step(output.wake.expect("something to wait for"), Input::Wake);
//! assert_eq!(output.gone[..], [device]);
//! assert_eq!(devices.iter().count(), 0);
//! # Ok::<(), kos_proto::EncodeError>(())
//! ```
//!
//! Source: kOS, `NetworkInfo`; decisions K-D1 to K-D6. Anyone on the network can say anything: what is found is a
//! suggestion to show to a person.

use core::fmt;

use arrayvec::ArrayVec;
use motion_core::time::Millis;
use motion_core::wire::{Bool, DecodeError, EncodeError};

use crate::message::{GetNetworkInfo, Ipv4, NetworkInfo};
use crate::{DeviceMessage, Frame, FrameError, HostMessage, MessageId, MessageType};

/// The port of TCP, and of discovery unless told otherwise: the specification names none for UDP (decision K-D1).
pub const DEFAULT_PORT: u16 = 5520;
/// Milliseconds between two announcements of a device that no client is connected to, and between two questions of a
/// client that asks (decision K-D2).
pub const ANNOUNCE_EVERY: u64 = 5_000;
/// Milliseconds of silence after which a device is gone: three announcements.
pub const FORGET_AFTER: u64 = 15_000;

/// What a datagram says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Datagram<'a> {
    /// A client asks who is there.
    Question(GetNetworkInfo<'a>),
    /// A device says where it is.
    Announcement(NetworkInfo<'a>),
}

impl<'a> Datagram<'a> {
    /// The question of a client, to be answered by broadcast, or else to the one who asks.
    #[must_use]
    pub fn question(limited_response: bool) -> Self {
        Self::Question(GetNetworkInfo::new(limited_response))
    }

    /// Reads one datagram, from whomever.
    ///
    /// # Errors
    ///
    /// [`DatagramError`], if it is no message, another one, or one that is cut short.
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

    /// Bytes of the datagram.
    #[must_use]
    pub fn encoded_len(&self) -> usize {
        match *self {
            Self::Question(question) => HostMessage::from(question).encoded_len(),
            Self::Announcement(info) => DeviceMessage::from(info).encoded_len(),
        }
    }

    /// Writes the datagram to the front of `out`, and says how many bytes it took.
    ///
    /// # Errors
    ///
    /// [`EncodeError`], if it does not fit.
    pub fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        match *self {
            Self::Question(question) => HostMessage::from(question).encode_into(out),
            Self::Announcement(info) => DeviceMessage::from(info).encode_into(out),
        }
    }
}

/// Why a datagram is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum DatagramError {
    /// It is not one message.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The message is cut short.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// The message is not one of discovery.
    #[error("message {id}, {kind}, is not of discovery")]
    Unrelated {
        /// What it is about.
        id: MessageId,
        /// Whether it sets, asks or answers.
        kind: MessageType,
    },
}

/// A device that announced itself.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Announced {
    /// What it said, but for a tail.
    pub info: NetworkInfo<'static>,
    /// Where the datagram came from.
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

    /// Where to connect to: the address that it said, or, if that is 0.0.0.0, the one it sent from (decision K-D6).
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

/// The devices that a client has heard of, up to `N`, each once by its hardware address.
///
/// A full table takes no more until one is gone: a flood of invented devices does not drive out those that are known.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct Devices<const N: usize = 16> {
    list: ArrayVec<Heard, N>,
}

/// A device, and when it was last heard of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Heard {
    device: Announced,
    at: Millis,
}

/// What [`Devices`] are told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Input<'a> {
    /// A datagram came.
    Datagram {
        /// Where it came from.
        source: Ipv4,
        /// All of it.
        bytes: &'a [u8],
    },
    /// The time has come, or just passed.
    Wake,
}

/// What follows from it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[must_use]
pub struct Output<const N: usize = 16> {
    /// The devices that have been silent for too long, and are forgotten.
    pub gone: ArrayVec<Announced, N>,
    /// What the datagram said that was not known, or why it was dropped.
    pub heard: Result<Option<Event>, DatagramError>,
    /// When to wake next; never, while no device is known.
    pub wake: Option<Millis>,
}

/// What a datagram brought that was not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Event {
    /// A device that was not there.
    Found(Announced),
    /// A device that says something else than before, or from somewhere else.
    Changed(Announced),
    /// A device for which the table has no room.
    NoRoom(Announced),
    /// Some client asks who is there.
    Asked {
        /// Where it asks from.
        source: Ipv4,
        /// Whether a device shall answer by broadcast; if not, to that address.
        limited_response: bool,
    },
}

impl<const N: usize> Devices<N> {
    /// Takes what happened: forgets who was silent for too long, then keeps who was heard of.
    pub fn step(self, now: Millis, input: Input<'_>) -> (Self, Output<N>) {
        let (mut list, mut gone) = (ArrayVec::new(), ArrayVec::new());
        for heard in self.list {
            // There is room: neither list becomes longer than the one that is divided.
            let _ = if now.since(heard.at) < FORGET_AFTER {
                list.try_push(heard).is_ok()
            } else {
                gone.try_push(heard.device).is_ok()
            };
        }
        let mut devices = Self { list };
        let heard = match input {
            Input::Wake => Ok(None),
            Input::Datagram { source, bytes } => Datagram::decode(bytes).map(|said| devices.hear(now, source, &said)),
        };
        let wake = devices.list.iter().map(|heard| heard.at.after(FORGET_AFTER)).min();
        (devices, Output { gone, heard, wake })
    }

    fn hear(&mut self, now: Millis, source: Ipv4, said: &Datagram<'_>) -> Option<Event> {
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
    fn what_is_no_datagram_of_discovery_says_why() {
        assert_eq!(datagram(&Datagram::question(false)), b"\x04\0\x07\0\x02\x01\0");
        let small = EncodeError::BufferTooSmall { needed: 7, have: 6 };
        assert_eq!(Datagram::question(true).encode_into(&mut [0; 6]), Err(small));
        // Without its byte it is a question as well (decision K-D5).
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
        assert_eq!(keep_alive.to_string(), "message KEEP_ALIVE, SET, is not of discovery");
        // What nobody may send is no question either.
        let set = Datagram::decode(&[4, 0, 7, 0, 2, 0, 1]).unwrap_err();
        assert_eq!(set, DatagramError::Unrelated { id: MessageId::NETWORK_INFO, kind: MessageType::SET });
    }

    /// Decision K-D6.
    #[test]
    fn the_address_is_what_it_says_or_else_where_it_sent_from() {
        let at = |ip| Announced { info: info(5, ip), source: SOURCE }.address();
        assert_eq!((at(0), at(0x0a00_0001)), (SOURCE, Ipv4(0x0a00_0001)));
    }

    #[test]
    fn a_device_is_found_once_and_told_of_again_when_it_changes() {
        let (devices, output) = announced(Devices::<4>::default(), 0, info(5, 0));
        let first = Announced { info: info(5, 0), source: SOURCE };
        assert_eq!((output.heard, output.wake), (Ok(Some(Event::Found(first))), Some(Millis(FORGET_AFTER))));

        // The same, and with a tail that nobody knows.
        let (devices, output) = announced(devices, 5_000, NetworkInfo { tail: &[7], ..info(5, 0) });
        assert_eq!((output.heard, output.wake), (Ok(None), Some(Millis(20_000))));

        let (devices, output) = announced(devices, 6_000, info(5, 1));
        let moved = Announced { info: info(5, 1), source: SOURCE };
        assert_eq!(output.heard, Ok(Some(Event::Changed(moved))));

        let (devices, output) = announced(devices, 7_000, info(6, 0));
        assert!(matches!(output.heard, Ok(Some(Event::Found(_)))));
        assert_eq!(output.wake, Some(Millis(21_000)), "the first that may be gone");
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

        // Too late, it is found anew; any datagram tells the time, also a bad one.
        let (devices, output) = announced(devices, 16_000, info(6, 0));
        assert_eq!(output.gone.len(), 1);
        assert!(matches!(output.heard, Ok(Some(Event::Found(_)))));
        let (devices, output) = devices.step(Millis(31_000), Input::Datagram { source: SOURCE, bytes: b"?" });
        assert_eq!((output.gone.len(), output.wake, devices), (1, None, Devices::default()));
        assert_eq!(output.heard, Err(FrameError::BadVersion { found: b'?' }.into()));
    }

    #[test]
    fn a_flood_of_devices_does_not_drive_out_those_that_are_known() {
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
    fn a_question_says_where_to_answer() {
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
