//! USB: messages in HID reports of 64 bytes, for either side.
//!
//! A report is its id, 1, and 63 bytes: one message, and padding without meaning. The caller finds, opens and polls the
//! device. The specification names neither vendor id nor product id.
//!
//! ```
//! use kos_proto::usb::{self, Report};
//! use kos_proto::{Frame, HostMessage};
//! use kos_proto::message::GetDeviceInfo;
//!
//! let report = Report::encode(&HostMessage::from(GetDeviceInfo::default()))?;
//! assert_eq!(report.as_ref().len(), 64);
//!
//! // Some libraries hand out reports without their id.
//! for buffer in [report.as_ref(), &report.as_ref()[1..]] {
//!     let frame = usb::decode(buffer).expect("a message");
//!     assert!(matches!(HostMessage::decode(&frame), Ok(HostMessage::GetDeviceInfo(_))));
//! }
//! # Ok::<(), kos_proto::EncodeError>(())
//! ```
//!
//! # Messages longer than a report
//!
//! No trajectory fits into a report, and the specification does not say how one travels over USB. [`Report`] refuses
//! messages that do not fit. [`Fragments`] and [`Reassembly`] make the simplest assumption, that a message continues in
//! the next report. **No device has confirmed it**, so their constructors are named `assume`. The pieces have no
//! numbers: if a piece in the middle is lost, later bytes may complete the message. Read such a message back from the
//! device before it is played.
//!
//! Source: kOS, USB; safety decision 4, decisions K-U1 to K-U8.

use motion_core::time::Millis;
use motion_core::wire::{EncodeError, Envelope, Messages};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

use crate::frame::{Frame, FrameError, Kos, MAX_FRAME, VERSION};

/// Id of every report: its first byte.
pub const REPORT_ID: u8 = 0x01;
/// Bytes of a report that are free for a message.
pub const CAPACITY: usize = 63;
/// Bytes of a report, including its id (decision K-U1).
pub const REPORT_LEN: usize = size_of::<Report>();
/// Time between two keep-alives of a client that sends nothing else, in milliseconds (decision K-U6).
pub const KEEP_ALIVE_EVERY: u64 = 4_000;
/// Time after which the next piece of a message is too late, in milliseconds (safety decision 4).
pub const CONTINUE_WITHIN: u64 = 100;

/// Longest buffer that a HID library fills with one report, because some libraries add a byte.
const LONGEST_BUFFER: usize = REPORT_LEN + 1;

/// One report as it is sent: always 64 bytes, with the id first and zeros after the message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub struct Report {
    id: u8,
    data: [u8; CAPACITY],
}

impl Report {
    /// Keep-alive that a client sends every [`KEEP_ALIVE_EVERY`] milliseconds, so that the device does not take it for
    /// gone. There is no answer.
    pub const KEEP_ALIVE: Self = {
        let mut data = [0; CAPACITY];
        [data[0], data[2]] = [VERSION, 6];
        Self { id: REPORT_ID, data }
    };

    /// Puts a typed message into a report: a [`HostMessage`](crate::HostMessage) or a
    /// [`DeviceMessage`](crate::DeviceMessage).
    ///
    /// # Errors
    ///
    /// [`EncodeError::TooLong`] if the message does not fit, and the other reasons why a message cannot be written.
    pub fn encode<'m, M: Messages<'m>>(message: &M) -> Result<Self, EncodeError> {
        let mut report = Self::filled(&[]);
        let (number, body_len) = (message.number(), message.body_len());
        fits(<Kos>::frame_len(number, body_len))?;
        <Kos>::seal((), number, body_len, &mut report.data, |place| message.encode_body(place))?;
        Ok(report)
    }

    /// Puts a message that is encoded already into a report.
    ///
    /// # Errors
    ///
    /// [`EncodeError::TooLong`] if the message does not fit.
    pub fn new(message: Frame<'_>) -> Result<Self, EncodeError> {
        fits(message.bytes().len())?;
        Ok(Self::filled(message.bytes()))
    }

    /// Report with as much of `bytes` as fits, and zeros after it.
    fn filled(bytes: &[u8]) -> Self {
        let mut data = [0; CAPACITY];
        data.iter_mut().zip(bytes).for_each(|(place, byte)| *place = *byte);
        Self { id: REPORT_ID, data }
    }
}

/// All 64 bytes of the report.
impl AsRef<[u8]> for Report {
    fn as_ref(&self) -> &[u8] {
        self.as_bytes()
    }
}

const fn fits(len: usize) -> Result<(), EncodeError> {
    if len <= CAPACITY { Ok(()) } else { Err(EncodeError::TooLong { what: "USB report", len, max: CAPACITY }) }
}

/// Reason why a report holds no message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A buffer whose length is not 1 to 65 bytes.
    #[error("USB report: {found} bytes, should be 1 to {LONGEST_BUFFER}")]
    BadLength {
        /// Length of the buffer, in bytes.
        found: usize,
    },
    /// A report that starts neither with the id of a report nor with a message (decision K-U2).
    #[error("USB report: id is {found}, should be {REPORT_ID}")]
    BadId {
        /// First byte of the report.
        found: u8,
    },
    /// Content that is not a message, or only part of one.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// A message that came complete, but is too long for the buffer of [`Reassembly`]. Its reports are consumed.
    #[error("USB message: {total} bytes, at most {max} fit")]
    TooLong {
        /// Length of the message, in bytes.
        total: usize,
        /// Length of the buffer, in bytes.
        max: usize,
    },
}

/// Finds the message in a report as a HID library returns it: with or without its id, 1 to 65 bytes.
///
/// Bytes after the message are padding, and are not searched for a second message (decision K-U5).
///
/// # Errors
///
/// [`ReportError`]. A [`FrameError::Truncated`] in it means that the message is longer than the report.
pub fn decode(report: &[u8]) -> Result<Frame<'_>, ReportError> {
    let data = data(report, is_numbered(report))?;
    match Frame::decode(data) {
        Err(FrameError::Trailing { extra }) => {
            let (message, _) = data.split_at_checked(data.len().saturating_sub(extra)).unwrap_or_default();
            Ok(Frame::decode(message)?)
        }
        whole => Ok(whole?),
    }
}

/// Whether a report that starts a message carries its id. Otherwise the message is at its front.
fn is_numbered(report: &[u8]) -> bool {
    report.first() != Some(&VERSION)
}

/// Content of a report after its id, which may already be removed.
fn data(report: &[u8], numbered: bool) -> Result<&[u8], ReportError> {
    let data = match report {
        [] => return Err(ReportError::BadLength { found: 0 }),
        _ if report.len() > LONGEST_BUFFER => return Err(ReportError::BadLength { found: report.len() }),
        [REPORT_ID, data @ ..] if numbered => data,
        [found, ..] if numbered => return Err(ReportError::BadId { found: *found }),
        data => data,
    };
    Ok(data.get(..CAPACITY).unwrap_or(data))
}

/// Whether a report is a complete message, followed by zeros only.
fn stands_alone(report: &[u8]) -> bool {
    let (Ok(message), Ok(data)) = (decode(report), data(report, is_numbered(report))) else { return false };
    data.iter().skip(message.bytes().len()).all(|&byte| byte == 0)
}

/// Iterator over the reports of a message of any length, by an assumption that no device has confirmed.
///
/// Send the reports without anything between them: any other message, even a keep-alive, ends the message.
///
/// ```
/// use kos_proto::Frame;
/// use kos_proto::usb::Fragments;
///
/// let message = [&[4, 0, 100, 0, 0x12, 0, 0][..], &[0xff; 93]].concat();
/// let reports = Fragments::assume(Frame::decode(&message)?).expect("no piece looks like a message");
/// assert_eq!(reports.len(), 2);
/// # Ok::<(), kos_proto::FrameError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Fragments<'a> {
    rest: &'a [u8],
}

impl<'a> Fragments<'a> {
    /// Cuts a message into reports of 63 bytes each, and assumes that the device joins them again.
    ///
    /// # Errors
    ///
    /// [`Ambiguous`] if a piece of the message looks like a message of its own. A device that missed the piece before
    /// would act on it.
    pub fn assume(message: Frame<'a>) -> Result<Self, Ambiguous> {
        let all = Self { rest: message.bytes() };
        // A library at the receiver may remove the id.
        let is_message = |report: &Report| decode(report.as_bytes()).is_ok() || decode(&report.data).is_ok();
        match all.clone().enumerate().skip(1).find(|(_, report)| is_message(report)) {
            Some((index, _)) => Err(Ambiguous { index }),
            None => Ok(all),
        }
    }
}

impl Iterator for Fragments<'_> {
    type Item = Report;

    fn next(&mut self) -> Option<Report> {
        if self.rest.is_empty() {
            return None;
        }
        let (piece, rest) = self.rest.split_at_checked(CAPACITY).unwrap_or((self.rest, &[]));
        self.rest = rest;
        Some(Report::filled(piece))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let len = self.rest.len().div_ceil(CAPACITY);
        (len, Some(len))
    }
}

impl ExactSizeIterator for Fragments<'_> {}

/// Error about a piece of a long message that looks like a message of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[error("USB report {index} of the message would be taken for a message of its own")]
pub struct Ambiguous {
    /// Number of the report, counted from 0.
    pub index: usize,
}

/// Joins reports to messages of up to `N` bytes, by an assumption that no device has confirmed.
///
/// A message that fits into one report is returned at once, and is borrowed from the report. A longer one waits for its
/// other pieces, for at most [`CONTINUE_WITHIN`] milliseconds each. A report that is itself a complete message,
/// followed by zeros only, ends the wait. So a lost piece never swallows a `StopPlayback` (safety decision 4).
///
/// ```
/// use kos_proto::usb::{Fragments, Reassembly};
/// use kos_proto::{Frame, HostMessage};
/// use motion_core::time::Millis;
///
/// let message = [&[4, 0, 100, 0x12, 0x34, 0][..], &[0xff; 94]].concat();
/// let message = Frame::decode(&message)?;
/// let mut reassembly: Reassembly<1024> = Reassembly::assume();
/// for (now, report) in (0..).map(Millis).zip(Fragments::assume(message).expect("clear")) {
///     if let Some(whole) = reassembly.push(now, report.as_ref()).message.expect("sound reports") {
///         assert_eq!(whole, message);
///     }
/// }
/// assert_eq!(reassembly.held(), 0);
/// # Ok::<(), kos_proto::FrameError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Reassembly<const N: usize = MAX_FRAME> {
    buf: [u8; N],
    partial: Option<Partial>,
}

/// Message of which some pieces have come.
#[derive(Debug, Clone, Copy)]
struct Partial {
    needed: usize,
    have: usize,
    /// Whether the reports carry their id. Later reports may start with any byte, so the first one decides.
    numbered: bool,
    last: Millis,
}

impl<const N: usize> Reassembly<N> {
    /// Reassembly that waits for a message, and assumes that a long message continues in the next report.
    #[must_use]
    pub const fn assume() -> Self {
        Self { buf: [0; N], partial: None }
    }

    /// Number of bytes held of an incomplete message.
    #[must_use]
    pub fn held(&self) -> usize {
        self.partial.map_or(0, |partial| partial.have)
    }

    /// Time when the incomplete message is given up, unless a report comes before.
    #[must_use]
    pub fn deadline(&self) -> Option<Millis> {
        self.partial.map(|partial| partial.last.after(CONTINUE_WITHIN))
    }

    /// Gives up the incomplete message if its next report is too late. [`push`](Self::push) does so too.
    pub fn expire(&mut self, now: Millis) -> Option<Dropped> {
        let Partial { needed, have, .. } =
            self.partial.take_if(|partial| now.since(partial.last) >= CONTINUE_WITHIN)?;
        Some(Dropped::Late { needed, have })
    }

    /// Takes one report as a HID library returns it: with or without its id, 1 to 65 bytes.
    ///
    /// A report that is refused for its length or its id does not change the incomplete message.
    pub fn push<'a>(&'a mut self, now: Millis, report: &'a [u8]) -> Received<'a> {
        let dropped = self.expire(now).or_else(|| {
            let Partial { needed, have, .. } = self.partial.take_if(|_| stands_alone(report))?;
            Some(Dropped::Interrupted { needed, have })
        });
        let message = match self.partial {
            Some(partial) => self.go_on(partial, now, report),
            None => self.begin(now, report),
        };
        Received { dropped, message }
    }

    fn begin<'a>(&mut self, now: Millis, report: &'a [u8]) -> Result<Option<Frame<'a>>, ReportError> {
        let numbered = is_numbered(report);
        match (decode(report), data(report, numbered)) {
            (Err(ReportError::Frame(FrameError::Truncated { needed, .. })), Ok(data)) if data.len() == CAPACITY => {
                self.partial = Some(Partial { needed, have: CAPACITY, numbered, last: now });
                self.keep(0, data);
                Ok(None)
            }
            (whole, _) => whole.map(Some),
        }
    }

    fn go_on(&mut self, partial: Partial, now: Millis, report: &[u8]) -> Result<Option<Frame<'_>>, ReportError> {
        let data = data(report, partial.numbered)?;
        let Partial { needed, have, .. } = partial;
        let piece = data.get(..needed.saturating_sub(have)).unwrap_or(data);
        self.keep(have, piece);
        let have = have.saturating_add(piece.len());
        if have < needed && data.len() == CAPACITY {
            self.partial = Some(Partial { have, last: now, ..partial });
            return Ok(None);
        }
        self.partial = None;
        if have < needed {
            return Err(FrameError::Truncated { needed, have }.into());
        }
        let bytes = self.buf.get(..needed).ok_or(ReportError::TooLong { total: needed, max: N })?;
        Ok(Some(Frame::decode(bytes)?))
    }

    /// Stores a piece. A piece that does not fit belongs to a message that is too long, and is only counted.
    fn keep(&mut self, at: usize, piece: &[u8]) {
        if let Some(place) = self.buf.get_mut(at..).and_then(|free| free.get_mut(..piece.len())) {
            place.copy_from_slice(piece);
        }
    }
}

impl<const N: usize> Default for Reassembly<N> {
    fn default() -> Self {
        Self::assume()
    }
}

/// Result of one report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use]
pub struct Received<'a> {
    /// Incomplete message that was given up because of this report.
    pub dropped: Option<Dropped>,
    /// Complete message; `None` while pieces of it are missing.
    ///
    /// [`FrameError::Truncated`] means that a piece was shorter than a full report. Its message is given up too.
    pub message: Result<Option<Frame<'a>>, ReportError>,
}

/// Reason why an incomplete message was given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
pub enum Dropped {
    /// The next report came too late.
    #[error("USB message: have {have} of {needed} bytes, the next report came too late")]
    Late {
        /// Length of the message, in bytes.
        needed: usize,
        /// Number of bytes that came.
        have: usize,
    },
    /// The next report was another message.
    #[error("USB message: have {have} of {needed} bytes, the next report was another message")]
    Interrupted {
        /// Length of the message, in bytes.
        needed: usize,
        /// Number of bytes that came.
        have: usize,
    },
}
