//! Reader of a device that does not read frames as the document says. It turns what arrives into frames that a device of the
//! document takes in the same way.

use std::borrow::Cow;

use dmc_proto::frame::{OVERHEAD, encode};
use dmc_proto::message::{AckCode, HostMessage};
use dmc_proto::{DeviceReader, Frame, Header, Item};
use motion_core::time::Millis;
use motion_core::wire::Messages as _;
use tracing::warn;

use super::{Facts, Setup};

/// Greatest type that the vendor's parser accepts, apart from the bit of acknowledgements.
const LAST_TYPE: u16 = 0x03FF;

/// Thing that was read.
#[derive(Debug)]
pub(super) enum Read {
    /// Frame as the document has it.
    Frame(Vec<u8>),
    /// Message with this header, which the device refuses in every state, with this code while it is not locked.
    Refused(Header, AckCode),
}

/// Reader with ways of its own.
#[derive(Debug)]
pub(super) struct Reader {
    frames: Box<DeviceReader>,
    facts: Facts,
    /// Number of bytes of a damaged frame that are still to be dropped.
    drops: usize,
}

impl Reader {
    /// Reader of a device; `None` if the device reads as the document says.
    pub(super) fn of(setup: &Setup) -> Option<Self> {
        let facts = setup.facts;
        let is_own = facts.compares_check || facts.drops_damaged || facts.vendor_parser || !facts.unknown.is_empty();
        is_own.then(|| Self { frames: Box::new(DeviceReader::new(setup.patience)), facts, drops: 0 })
    }

    /// Drops what is held.
    pub(super) fn reset(&mut self) {
        self.frames.reset();
        self.drops = 0;
    }

    /// Number of bytes that are held.
    pub(super) fn held(&self) -> usize {
        self.frames.held()
    }

    /// Time at which the incomplete frame is given up.
    pub(super) fn deadline(&self) -> Option<Millis> {
        self.frames.deadline()
    }

    /// Takes bytes that arrived, and then gives up the incomplete frame if it is overdue. Returns what was read.
    pub(super) fn read(&mut self, now: Millis, mut bytes: &[u8]) -> Vec<Read> {
        let mut found = Vec::new();
        loop {
            while let Some(item) = self.frames.next() {
                if self.drops > 0 {
                    self.drops = self.drops.saturating_sub(item.bytes().len());
                    continue;
                }
                found.extend(match item {
                    Item::Frame(frame) if self.facts.compares_check && !is_canonical(&frame) => {
                        warn!("a message has other check bytes than this device writes");
                        self.facts.damaged(*frame.header())
                    }
                    Item::Frame(frame) => self.facts.sound(&frame),
                    Item::Corrupt { header, why, bytes } => {
                        warn!(%why, "a message arrived damaged");
                        if self.facts.drops_damaged {
                            self.drops = header.frame_len().saturating_sub(bytes.len());
                        }
                        self.facts.damaged(header)
                    }
                    Item::Noise { .. } | Item::Fatal(_) => None,
                });
            }
            if !bytes.is_empty() {
                let taken = self.frames.push(now, bytes);
                bytes = &bytes[taken..];
            } else if self.deadline().is_some_and(|deadline| deadline <= now) {
                self.frames.give_up(now);
            } else {
                return found;
            }
        }
    }
}

impl Facts {
    /// Answer to a damaged message. Only the vendor's parser answers acknowledgements.
    fn damaged(&self, header: Header) -> Option<Read> {
        (self.vendor_parser || !header.kind().is_ack()).then_some(Read::Refused(header, AckCode::ERR_CHECKSUM))
    }

    fn sound(&self, frame: &Frame<'_>) -> Option<Read> {
        let kind = frame.kind();
        if self.vendor_parser && (kind.0 == 0 || kind.request().0 > LAST_TYPE) {
            warn!(request = %kind, "drops a request of an unknown type");
            return None;
        }
        if (self.vendor_parser && kind.is_ack()) || self.unknown.contains(&kind.0) {
            return Some(Read::Refused(*frame.header(), AckCode::ERR_UNSUPPORTED));
        }
        let data = if self.vendor_parser { completed(frame) } else { frame.payload().into() };
        Some(Read::Frame(encoded(frame, &data)))
    }
}

/// Frame with other data, and with the check bytes that this crate writes.
fn encoded(frame: &Frame<'_>, data: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0; data.len() + OVERHEAD];
    encode(frame.id(), frame.kind(), data, &mut bytes).expect("the data of a frame that arrived fits");
    bytes
}

/// Whether a frame has the check bytes that this crate writes. Modulo 255, the bytes 00 and FF are the same.
fn is_canonical(frame: &Frame<'_>) -> bool {
    encoded(frame, frame.payload()) == frame.bytes()
}

/// Data of a request as the vendor's parser takes it, with zeros in the place of what is missing. A move and a new position
/// count only if they have their length.
fn completed<'a>(frame: &Frame<'a>) -> Cow<'a, [u8]> {
    let data = frame.payload();
    if matches!(frame.kind().0, 0x0031 | 0x0035) {
        return if data.len() == 5 { data.into() } else { Cow::default() };
    }
    // The fields that a message cannot do without have fewer bytes than this.
    let longer = (data.len()..data.len() + 64).map(|len| {
        let mut longer = data.to_vec();
        longer.resize(len, 0);
        longer
    });
    let can = |data: &Vec<u8>| HostMessage::decode_body(frame.kind().0.into(), data).is_ok();
    longer.into_iter().find(can).map_or(data.into(), Cow::Owned)
}
