//! Taps: the traffic of both sides of a line, from pieces of bytes to [`Record`]s.

mod dmc;
mod hoot;
mod kos;

use std::fmt::Display;

use motion_core::lint::{Lint, Lints};
use motion_core::stream::{Frames, Framing, Item, Noise};
use motion_core::wire::{DecodeError, EncodeError};

use crate::cli::{Protocol, Stop, Transport};
use crate::record::{Find, Kind, Record, Shown};
use crate::text::{Piece, Side};

/// Callback that gets the records in the order in which they are found.
pub type See<'s> = dyn FnMut(&Record<'_>) -> Result<(), Stop> + 's;

/// Listener on both sides of a line.
pub trait Tap {
    /// Takes the next bytes of one side.
    ///
    /// # Errors
    ///
    /// Errors of `see`.
    fn push(&mut self, piece: Piece<'_>, see: &mut See<'_>) -> Result<(), Stop>;

    /// Reports the rest, after the input has ended.
    ///
    /// # Errors
    ///
    /// Errors of `see`.
    fn end(&mut self, see: &mut See<'_>) -> Result<(), Stop>;
}

/// Makes the tap for a protocol on a transport.
///
/// # Errors
///
/// [`Stop::Usage`] if the protocol does not use the transport.
pub fn tap(protocol: Protocol, transport: Transport) -> Result<Box<dyn Tap>, Stop> {
    let unspoken = |name: &str, transport: &str| {
        Err(Stop::Usage(format!("{name} does not use {transport}: leave out --transport (see --help)")))
    };
    Ok(match (protocol, transport) {
        (Protocol::Kos, Transport::Stream) => Box::new(Stream::<_, { kos::BUFFER }>::new(kos::Kos)),
        (Protocol::Kos, Transport::Datagram) => Box::new(Records::new(kos::Kos)),
        (Protocol::Kos, Transport::Usb) => Box::new(Records::new(kos::Reports)),
        (Protocol::Kos, Transport::UsbFragments) => Box::new(Records::new(kos::Fragments::default())),
        (Protocol::Dmc, Transport::Stream) => Box::new(Stream::<_, { dmc::BUFFER }>::new(dmc::Dmc)),
        (Protocol::Hoot, Transport::Stream) => Box::new(Stream::<_, { hoot::BUFFER }>::new(hoot::Hoot::default())),
        (Protocol::Dmc, Transport::Datagram) => return unspoken("dmc", "datagrams"),
        (Protocol::Dmc, Transport::Usb | Transport::UsbFragments) => return unspoken("dmc", "USB reports"),
        (Protocol::Hoot, Transport::Datagram) => return unspoken("hoot", "datagrams"),
        (Protocol::Hoot, Transport::Usb | Transport::UsbFragments) => return unspoken("hoot", "USB reports"),
    })
}

/// Display of the frames of a protocol. It has state, because the meaning of a reply depends on its request.
trait Show {
    /// Short name of the protocol.
    const NAME: &'static str;
    /// Framing that finds the frames in a stream of the device.
    type Framing: Framing;
    /// Framing that finds the frames in a stream of the host.
    type Requests: for<'a> Framing<Frame<'a> = <Self::Framing as Framing>::Frame<'a>>;

    /// Shows a frame.
    fn show(
        &mut self,
        from: Side,
        frame: &<Self::Framing as Framing>::Frame<'_>,
        see: &mut dyn FnMut(Shown<'_>) -> Result<(), Stop>,
    ) -> Result<(), Stop>;
}

/// Message that was read from a frame, with the findings about it.
struct Read<M> {
    message: Result<M, DecodeError>,
    lints: Vec<Lint>,
    canonical: bool,
}

/// Checks a message that was read from a frame. `bytes` are the whole frame.
fn read<M>(
    bytes: &[u8],
    message: Result<M, DecodeError>,
    lint: impl FnOnce(&M) -> Lints,
    encode: impl FnOnce(&M, &mut [u8]) -> Result<usize, EncodeError>,
) -> Read<M> {
    let mut again = vec![0; bytes.len()];
    let (lints, canonical) = match &message {
        Ok(message) => (lint(message).into_iter().collect(), encode(message, &mut again).is_ok() && again == bytes),
        Err(_) => (Vec::new(), false),
    };
    Read { message, lints, canonical }
}

/// Tap with one stream for each side.
struct Stream<S: Show, const N: usize> {
    show: S,
    host: Half<S::Requests, N>,
    device: Half<S::Framing, N>,
}

/// Stream of one side.
struct Half<F: Framing, const N: usize> {
    frames: Box<Frames<F, N>>,
    place: Place,
}

/// Position in the stream of a side, and the noise found last. The noise grows until something else is found.
struct Place {
    from: Side,
    offset: u64,
    noise: Option<Run>,
}

/// Adjacent bytes that are not a frame.
struct Run {
    kind: Kind,
    why: String,
    offset: u64,
    len: u64,
    start: Vec<u8>,
}

/// Number of bytes of noise that are shown.
const SHOWN: usize = 16;

impl Place {
    const fn new(from: Side) -> Self {
        Self { from, offset: 0, noise: None }
    }

    /// Reports the noise so far.
    fn flush(&mut self, protocol: &'static str, see: &mut See<'_>) -> Result<(), Stop> {
        let Some(Run { kind, why, offset, len, start }) = self.noise.take() else { return Ok(()) };
        let find = Find::Other { kind, why, start: &start };
        see(&Record { offset, len, protocol, from: self.from, find })
    }

    /// Adds bytes that are not a frame to the noise before them.
    fn noise(&mut self, kind: Kind, why: &dyn Display, bytes: &[u8]) {
        let offset = self.offset;
        let run =
            self.noise.get_or_insert_with(|| Run { kind, why: why.to_string(), offset, len: 0, start: Vec::new() });
        let free = SHOWN.saturating_sub(run.start.len());
        run.start.extend(bytes.iter().take(free));
        run.len += len_of(bytes);
        self.offset += len_of(bytes);
    }

    /// Reports that the bytes `start` are not a frame, and counts them.
    fn other(
        &mut self,
        protocol: &'static str,
        kind: Kind,
        why: String,
        start: &[u8],
        see: &mut See<'_>,
    ) -> Result<(), Stop> {
        self.flush(protocol, see)?;
        let (offset, len) = (self.offset, len_of(start));
        self.offset += len;
        let start = start.get(..SHOWN).unwrap_or(start);
        see(&Record { offset, len, protocol, from: self.from, find: Find::Other { kind, why, start } })
    }

    /// Shows a frame and counts its bytes.
    fn frame<S: Show>(
        &mut self,
        show: &mut S,
        frame: &<S::Framing as Framing>::Frame<'_>,
        see: &mut See<'_>,
    ) -> Result<(), Stop> {
        self.flush(S::NAME, see)?;
        let (offset, len, from) = (self.offset, len_of(frame.as_ref()), self.from);
        self.offset += len;
        show.show(from, frame, &mut |shown| {
            see(&Record { offset, len, protocol: S::NAME, from, find: Find::Frame(shown) })
        })
    }
}

fn len_of(bytes: &[u8]) -> u64 {
    bytes.len() as u64
}

impl<F: Framing, const N: usize> Half<F, N> {
    fn new(from: Side) -> Self {
        Self { frames: Box::default(), place: Place::new(from) }
    }

    /// Reports the rest, after the input has ended.
    fn end<S: Show>(&mut self, show: &mut S, see: &mut See<'_>) -> Result<(), Stop>
    where
        F: for<'a> Framing<Frame<'a> = <S::Framing as Framing>::Frame<'a>>,
    {
        // A frame that waits for more bytes will not get them, and good frames may follow its first bytes.
        self.frames.gap();
        self.read(show, &[], true, see)?;
        self.place.flush(S::NAME, see)
    }

    /// Takes the next bytes, and reports the items found so far. `ended` is whether no more bytes will come.
    fn read<S: Show>(&mut self, show: &mut S, mut bytes: &[u8], ended: bool, see: &mut See<'_>) -> Result<(), Stop>
    where
        F: for<'a> Framing<Frame<'a> = <S::Framing as Framing>::Frame<'a>>,
    {
        let Self { frames, place } = self;
        loop {
            match frames.next_from(&mut bytes) {
                None => return Ok(()),
                Some(Item::Frame(frame)) => place.frame(show, &frame, see)?,
                Some(Item::Corrupt { why, bytes, .. }) => {
                    place.flush(S::NAME, see)?;
                    place.noise(Kind::Corrupt, &why, bytes);
                }
                Some(Item::Noise { bytes, why: Noise::CutOff }) if ended && place.noise.is_none() => {
                    place.noise(Kind::Incomplete, &"the input ends inside a frame", bytes);
                }
                Some(Item::Noise { bytes, why }) => place.noise(Kind::Noise, &why, bytes),
                Some(Item::Fatal(why)) => {
                    // A client must close the connection here. A listener may guess and continue.
                    place.other(S::NAME, Kind::Fatal, why.to_string(), &[], see)?;
                    frames.resync();
                }
            }
        }
    }
}

impl<S: Show, const N: usize> Stream<S, N> {
    fn new(show: S) -> Self {
        Self { show, host: Half::new(Side::Host), device: Half::new(Side::Device) }
    }
}

impl<S: Show, const N: usize> Tap for Stream<S, N> {
    fn push(&mut self, piece: Piece<'_>, see: &mut See<'_>) -> Result<(), Stop> {
        let Self { show, host, device } = self;
        // If the sides take turns, noise is shown before the answer to the disturbed message.
        match piece.side {
            Side::Host => {
                device.place.flush(S::NAME, see)?;
                host.read(show, piece.bytes, false, see)
            }
            Side::Device => {
                host.place.flush(S::NAME, see)?;
                device.read(show, piece.bytes, false, see)
            }
        }
    }

    fn end(&mut self, see: &mut See<'_>) -> Result<(), Stop> {
        self.host.end(&mut self.show, see)?;
        self.device.end(&mut self.show, see)
    }
}

/// Protocol whose records are read one at a time: datagrams or reports.
trait Whole: Show {
    /// Length in bytes at which a record is cut off, because the input may have no records.
    const RECORD: usize;

    /// Whether a record is already a message, even if it may still grow.
    fn is_whole(record: &[u8]) -> bool;

    /// Reports a record at its first byte. The caller then moves `place` to the end of the record.
    fn record(&mut self, place: &mut Place, record: &[u8], see: &mut See<'_>) -> Result<(), Stop>;

    /// Reports the rest of the records before, after the input has ended.
    fn end(&mut self, place: &mut Place, see: &mut See<'_>) -> Result<(), Stop> {
        let _ = (place, see);
        Ok(())
    }
}

/// Tap with records of each side.
struct Records<W: Whole> {
    show: W,
    host: Gathered,
    device: Gathered,
}

/// Record that may still grow.
struct Gathered {
    place: Place,
    bytes: Vec<u8>,
}

impl<W: Whole> Records<W> {
    fn new(show: W) -> Self {
        let gathered = |from| Gathered { place: Place::new(from), bytes: Vec::new() };
        Self { show, host: gathered(Side::Host), device: gathered(Side::Device) }
    }

    /// Reports a record.
    fn record(show: &mut W, place: &mut Place, record: &[u8], see: &mut See<'_>) -> Result<(), Stop> {
        let end = place.offset + len_of(record);
        show.record(place, record, see)?;
        // A report is longer than its message. The bytes after the message count, but have no meaning.
        place.offset = end;
        Ok(())
    }
}

impl<W: Whole> Tap for Records<W> {
    fn push(&mut self, piece: Piece<'_>, see: &mut See<'_>) -> Result<(), Stop> {
        let Self { show, host, device } = self;
        let (Gathered { place, bytes }, other) = match piece.side {
            Side::Host => (host, device),
            Side::Device => (device, host),
        };
        // A message is shown before its answer. In dumps of both sides, the lines of a record may be apart.
        if piece.first && W::is_whole(&other.bytes) {
            Self::record(show, &mut other.place, &other.bytes, see)?;
            other.bytes.clear();
        }
        if piece.first && !bytes.is_empty() {
            Self::record(show, place, bytes, see)?;
            bytes.clear();
        }
        for chunk in piece.bytes.chunks(W::RECORD) {
            let free = W::RECORD - bytes.len();
            let (now, later) = chunk.split_at(free.min(chunk.len()));
            bytes.extend_from_slice(now);
            if bytes.len() == W::RECORD {
                Self::record(show, place, bytes, see)?;
                bytes.clear();
            }
            bytes.extend_from_slice(later);
        }
        Ok(())
    }

    fn end(&mut self, see: &mut See<'_>) -> Result<(), Stop> {
        let Self { show, host, device } = self;
        for Gathered { place, bytes } in [host, device] {
            if !bytes.is_empty() {
                Self::record(show, place, bytes, see)?;
                bytes.clear();
            }
            show.end(place, see)?;
        }
        Ok(())
    }
}
