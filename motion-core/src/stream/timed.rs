//! Frames that have to be whole in time.

use core::fmt;

use super::{Frames, Framing, Item};
use crate::options;
use crate::time::Millis;

options! {
    /// Time that an incomplete frame gets, from its first byte on: the time of all its bytes on the line, and a margin.
    pub struct Patience {
        /// Speed of the line, in bits per second. A byte takes ten bits.
        line_speed with_line_speed: u32 = 115_200, in 1..=u32::MAX;
        /// Time that is added to the time on the line, in milliseconds: the greatest pause inside a frame.
        margin with_margin: u32 = 100;
    }
}

impl Patience {
    /// Time that a frame of this length gets, in milliseconds.
    fn of(self, len: usize) -> u64 {
        // 32 bits are enough for frames of 429 kB, and small processors do not have to divide more.
        let bits = u32::try_from(len).unwrap_or(u32::MAX).saturating_mul(10_000);
        u64::from(bits.div_ceil(self.line_speed.max(1))).saturating_add(self.margin.into())
    }
}

/// [`Frames`] that knows the time, and gives up a frame that is not whole in time.
///
/// A damaged length announces bytes that never come. Without a deadline, all that follows is taken for a part of that frame
/// until as many bytes have arrived. The deadline counts from the first byte of the frame, and later pieces do not put it
/// off. So a wrong length costs no more than the time of that frame on the line and the margin. At the deadline only this
/// frame is given up. The frames inside it are found, and one that has just begun gets its own time.
///
/// ```
/// # use motion_core::stream::{Framing, Head, Noise};
/// # enum Shout {}
/// # impl Framing for Shout {
/// #     const MAX: usize = 2 + 255;
/// #     type Header = ();
/// #     type Frame<'a> = &'a [u8];
/// #     type Memo<const N: usize> = ();
/// #     fn head(bytes: &[u8]) -> Head {
/// #         match bytes {
/// #             [b'!', len, ..] => Head::Total(2 + usize::from(*len)),
/// #             [b'!'] => Head::More(2),
/// #             _ => Head::Skip(1, Noise::NoMarker),
/// #         }
/// #     }
/// #     fn header(_: &[u8]) -> Option<()> { Some(()) }
/// #     fn frame(bytes: &[u8]) -> Option<&[u8]> { Some(bytes) }
/// # }
/// use motion_core::stream::{Item, Patience, TimedFrames};
/// use motion_core::time::Millis;
///
/// // A frame of `Shout` is a `!`, the length of a text, and the text.
/// let mut frames = TimedFrames::<Shout, 1024>::new(Patience::default().with_line_speed(9600));
/// let mut texts = Vec::new();
/// // The second byte is damaged: it announces 250 bytes, which take 263 ms.
/// for (now, piece) in [(0, &b"!\xfa"[..]), (100, b"!\x02yo"), (300, b"!\x05He")] {
///     assert_eq!(frames.push(Millis(now), piece), piece.len());
///     assert!(frames.next().is_none());
///     assert_eq!(frames.deadline(), Some(Millis(363)), "later pieces do not put it off");
/// }
/// frames.give_up(Millis(363));
/// while let Some(item) = frames.next() {
///     if let Item::Frame(frame) = item {
///         texts.push(frame[2..].to_vec());
///     }
/// }
/// assert_eq!(texts, [b"yo"]);
/// assert_eq!(frames.deadline(), Some(Millis(408)), "the frame that began at 300 has its own time");
/// ```
pub struct TimedFrames<F: Framing, const N: usize> {
    frames: Frames<F, N>,
    patience: Patience,
    /// Time at which the first byte of the incomplete frame arrived, unless that is new.
    first: Millis,
    /// Whether another frame is incomplete now than at the last push.
    is_new: bool,
    /// Time of the last piece, its number of bytes, and the time of the piece before it.
    last: (Millis, usize),
    before: Millis,
}

impl<F: Framing, const N: usize> TimedFrames<F, N> {
    /// Number of bytes that [`push`](Self::push) always takes after [`next`](Self::next) has returned `None`.
    pub const PIECE: usize = Frames::<F, N>::PIECE;

    /// Makes an empty buffer at the start of a stream.
    #[must_use]
    pub const fn new(patience: Patience) -> Self {
        let zero = Millis(0);
        Self { frames: Frames::new(), patience, first: zero, is_new: true, last: (zero, 0), before: zero }
    }

    /// Last `len` bytes that were taken as an item. They stay until bytes are added.
    #[doc(hidden)]
    #[must_use]
    pub fn taken(&self, len: usize) -> &[u8] {
        self.frames.taken(len)
    }

    /// Whether bytes were added at which [`next`](Self::next) did not look yet.
    #[doc(hidden)]
    #[must_use]
    pub const fn has_unseen(&self) -> bool {
        self.frames.has_unseen()
    }

    /// Number of bytes that are not part of an item yet.
    #[must_use]
    pub const fn held(&self) -> usize {
        self.frames.held()
    }

    /// Adds bytes that arrived at a moment, as many as there is room for, and returns their number, as
    /// [`Frames::push`] does. Then call [`next`](Self::next) until it returns `None`.
    #[must_use = "the bytes that were not taken have to be pushed again"]
    pub fn push(&mut self, now: Millis, bytes: &[u8]) -> usize {
        self.first = self.first();
        self.is_new = self.frames.held() == 0;
        let taken = self.frames.push(bytes);
        (self.before, self.last) = (self.last.0, (now, taken));
        taken
    }

    /// Returns the next item, borrowed until the following call; `None` if more bytes are needed.
    #[expect(clippy::should_implement_trait, reason = "an iterator cannot lend from itself")]
    pub fn next(&mut self) -> Option<Item<'_, F::Frame<'_>, F::Header>> {
        let item = self.frames.next();
        self.is_new |= item.is_some();
        item
    }

    /// Time at which the first byte of the incomplete frame arrived. If that byte is not in the last piece, it is the
    /// latest time at which it can have arrived.
    fn first(&self) -> Millis {
        let (last, len) = self.last;
        match self.is_new {
            false => self.first,
            true if self.frames.held() <= len => last,
            true => self.before,
        }
    }

    /// Time at which the incomplete frame has to be whole; `None` if no byte is held.
    #[must_use]
    pub fn deadline(&self) -> Option<Millis> {
        (self.frames.held() > 0).then(|| self.first().after(self.patience.of(self.frames.needed())))
    }

    /// Gives up the incomplete frame if its deadline has come. Then call [`next`](Self::next) until it returns `None`.
    ///
    /// Push all bytes that have arrived first: bytes that arrived in time can be read late, and complete the frame.
    ///
    /// Another incomplete frame may be overdue after it: repeat both until the [`deadline`](Self::deadline) is later.
    pub fn give_up(&mut self, now: Millis) {
        if self.deadline().is_some_and(|deadline| deadline <= now) {
            self.frames.give_up();
            self.is_new = true;
        }
    }

    /// Drops all bytes that are held, for a new connection.
    pub fn reset(&mut self) {
        self.frames.reset();
        self.is_new = true;
    }
}

impl<F: Framing, const N: usize> fmt::Debug for TimedFrames<F, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TimedFrames")
            .field("held", &self.held())
            .field("deadline", &self.deadline())
            .finish_non_exhaustive()
    }
}
