//! What every stream obeys, whatever its protocol: laws 8, 9 and 10 of the design.
//!
//! A reading feeds a stream in pieces, with gaps at given places, and collects the items. While it
//! does, it holds each step against the laws that need no second opinion: bytes are conserved, a
//! corrupt frame is reported once an episode, a fatal error stays until the caller gives it up, and
//! after a gap nothing waits. [`check`] adds those that compare readings.
//!
//! ```
//! # use laws::stream::check;
//! # use motion_core::stream::{Framing, Head, Noise};
//! # enum Line {}
//! # impl Framing for Line {
//! #     const MAX: usize = 2;
//! #     type Header = ();
//! #     type Frame<'a> = &'a [u8];
//! #     type Memo<const N: usize> = ();
//! #     fn head(bytes: &[u8]) -> Head {
//! #         if bytes[0] == b'!' { Head::Total(2) } else { Head::Skip(1, Noise::NoMarker) }
//! #     }
//! #     fn header(_: &[u8]) -> Option<()> { Some(()) }
//! #     fn frame(bytes: &[u8]) -> Option<&[u8]> { Some(bytes) }
//! # }
//! // A protocol whose frames are a `!` and one byte, fed in pieces of three bytes.
//! let rescan = |bytes: &[u8]| if bytes.len() > 1 && bytes[0] == b'!' { Ok(2) } else { Err(1) };
//! let items = check::<Line, 4>(b"ab!c!", &[], || 3, rescan);
//! assert_eq!(items.len(), 3);
//! ```

use std::fmt::Debug;

use motion_core::stream::{Corrupt, Fatal, Frames, Framing, Item, Noise};

/// An item that outlives the buffer. Neighbouring noise is one item, with the reason of its first byte.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "the fields are those of `Item`")]
pub enum Owned<H> {
    Frame(Vec<u8>),
    Corrupt { header: H, why: Corrupt, bytes: Vec<u8> },
    Noise { bytes: Vec<u8>, why: Noise },
    Fatal(Fatal),
}

/// What became of a stream.
#[derive(Clone, Debug)]
pub struct Reading<H> {
    /// The items in order.
    pub items: Vec<Owned<H>>,
    /// What [`Frames::work`] said in the end.
    pub work: usize,
}

/// When the items of a gap are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drain {
    /// At once.
    AtGap,
    /// After more bytes have arrived.
    AfterGap,
}

/// How a stream gets its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feed {
    /// By [`Frames::push`]. Its items come from [`Frames::next`].
    Push,
    /// By [`Frames::next_from`], which lends frames from the pieces.
    Lend,
}

/// Reads `stream` in pieces of the lengths that `cut` gives, the line silent at the positions `gaps`
/// (ascending) and at the end. A fatal error is followed by a resync.
///
/// # Panics
/// If the reading breaks a law.
pub fn read<F: Framing, const N: usize>(
    stream: &[u8],
    gaps: &[usize],
    drain: Drain,
    feed: Feed,
    cut: impl FnMut() -> usize,
) -> Reading<F::Header> {
    read_late::<F, N>(stream, gaps, &[], drain, feed, cut)
}

/// Reads a stream as [`read`] does. At the positions `late` (ascending), the incomplete frame is given up.
fn read_late<F: Framing, const N: usize>(
    stream: &[u8],
    gaps: &[usize],
    late: &[usize],
    drain: Drain,
    feed: Feed,
    mut cut: impl FnMut() -> usize,
) -> Reading<F::Header> {
    let mut reader = Reader::<F, N>::new(feed);
    // Whether nothing can be had from the bytes that are held.
    let mut is_drained = true;
    for segment in segments(stream, gaps) {
        let mut rest = segment;
        while !rest.is_empty() {
            let next = late.get(late.partition_point(|late| *late <= reader.received));
            let most = next.map_or(usize::MAX, |next| next - reader.received).min(rest.len());
            let (mut piece, later) = rest.split_at(cut().clamp(1, most));
            rest = later;
            while !piece.is_empty() {
                if feed == Feed::Push {
                    let least = if is_drained { Frames::<F, N>::PIECE.min(piece.len()) } else { 0 };
                    let taken = reader.frames.push(piece);
                    assert!(taken > 0 && taken >= least, "no room although nothing more was to be had");
                    piece = &piece[taken..];
                    reader.received += taken;
                }
                reader.drain(&mut piece);
                assert!(feed == Feed::Push || piece.is_empty(), "bytes were left although nothing more was to be had");
                is_drained = true;
            }
            if late.binary_search(&reader.received).is_ok() {
                let held = reader.frames.held();
                reader.frames.give_up();
                reader.drain(&mut &[][..]);
                assert!(held == 0 || reader.frames.held() < held, "the incomplete frame was not given up");
            }
        }
        reader.frames.gap();
        is_drained = drain == Drain::AtGap;
        if is_drained {
            reader.drain_all();
        }
    }
    reader.drain_all();
    let bytes: Vec<u8> = reader.items.iter().flat_map(Owned::bytes).copied().collect();
    assert!(bytes == stream, "the items, put end to end, are not the stream");
    Reading { work: reader.frames.work(), items: reader.items }
}

/// Reads `stream` whole, byte by byte and in pieces of the lengths that `cut` gives, and demands that
/// all readings give the same items, and the same frames as a rescan does. Returns the items.
///
/// Two more readings give up the incomplete frame at positions that `cut` gives too. Which frames are found then depends on
/// the pieces. Each of them is one that a rescan finds in its bytes.
///
/// The rescan knows nothing of buffers. It is given the rest of the stream up to the next gap, and
/// says what stands there: a whole sound frame of so many bytes (`Ok`), or so many bytes to leave
/// behind (`Err`).
///
/// # Panics
/// If a law is broken.
pub fn check<F: Framing, const N: usize>(
    stream: &[u8],
    gaps: &[usize],
    mut cut: impl FnMut() -> usize,
    rescan: impl Fn(&[u8]) -> Result<usize, usize>,
) -> Vec<Owned<F::Header>> {
    let Reading { items, .. } = read::<F, N>(stream, gaps, Drain::AtGap, Feed::Push, || usize::MAX);
    same(&items, &read::<F, N>(stream, gaps, Drain::AtGap, Feed::Lend, || usize::MAX).items, "lent from one piece");
    for drain in [Drain::AtGap, Drain::AfterGap] {
        same(&items, &read::<F, N>(stream, gaps, drain, Feed::Push, &mut cut).items, "cut into pieces");
        same(&items, &read::<F, N>(stream, gaps, drain, Feed::Push, || 1).items, "cut into single bytes");
        // Long pieces are read in another way than short ones.
        let mut times = [1, 16].into_iter().cycle();
        let lens = || cut().saturating_mul(times.next().unwrap_or(1));
        same(&items, &read::<F, N>(stream, gaps, drain, Feed::Lend, lens).items, "lent from short and long pieces");
    }
    let found = items.iter().filter_map(|item| if let Owned::Frame(bytes) = item { Some(&bytes[..]) } else { None });
    let wanted = segments(stream, gaps).flat_map(|segment| rescanned(segment, &rescan));
    assert!(found.eq(wanted), "other frames than a rescan finds");

    let ends = std::iter::repeat_with(&mut cut).scan(0, |end: &mut usize, len| {
        *end = end.saturating_add(len.max(1));
        (*end < stream.len()).then_some(*end)
    });
    let late: Vec<usize> = ends.collect();
    let in_pieces = read_late::<F, N>(stream, gaps, &late, Drain::AtGap, Feed::Push, &mut cut);
    let in_bytes = read_late::<F, N>(stream, gaps, &late, Drain::AfterGap, Feed::Push, || 1);
    let lent = read_late::<F, N>(stream, gaps, &late, Drain::AtGap, Feed::Lend, || cut().saturating_mul(16));
    for item in in_pieces.items.iter().chain(&in_bytes.items).chain(&lent.items) {
        if let Owned::Frame(bytes) = item {
            assert_eq!(rescan(bytes), Ok(bytes.len()), "a frame that a rescan does not find");
        }
    }
    items
}

/// The frames that a rescan finds in bytes without a gap.
fn rescanned(segment: &[u8], rescan: impl Fn(&[u8]) -> Result<usize, usize>) -> Vec<&[u8]> {
    let mut frames = Vec::new();
    let mut rest = segment;
    while !rest.is_empty() {
        let found = rescan(rest);
        let (Ok(len) | Err(len)) = found;
        let (bytes, later) = rest.split_at(len.min(rest.len()));
        frames.extend(found.is_ok().then_some(bytes));
        rest = later;
    }
    frames
}

/// The parts of a stream between its gaps.
fn segments<'a>(stream: &'a [u8], gaps: &'a [usize]) -> impl Iterator<Item = &'a [u8]> {
    let ends = gaps.iter().copied().chain([stream.len()]).map(|at| at.min(stream.len()));
    ends.scan(0, |from, to| {
        let segment = &stream[*from..to];
        *from = to;
        Some(segment)
    })
}

fn same<H: Debug + PartialEq>(one: &[Owned<H>], other: &[Owned<H>], how: &str) {
    for (at, (one, other)) in one.iter().zip(other).enumerate() {
        assert_eq!(one, other, "item {at} differs when {how}");
    }
    assert_eq!(one.len(), other.len(), "number of items when {how}");
}

impl<H> Owned<H> {
    /// The bytes that the item takes from the stream.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::Frame(bytes) | Self::Corrupt { bytes, .. } | Self::Noise { bytes, .. } => bytes,
            Self::Fatal(_) => &[],
        }
    }
}

struct Reader<F: Framing, const N: usize> {
    frames: Box<Frames<F, N>>,
    feed: Feed,
    items: Vec<Owned<F::Header>>,
    received: usize,
    /// Bytes in `items`.
    taken: usize,
    /// A corrupt frame was reported, and no good one since.
    episode: bool,
}

impl<F: Framing, const N: usize> Reader<F, N> {
    fn new(feed: Feed) -> Self {
        Self { frames: Box::new(Frames::new()), feed, items: Vec::new(), received: 0, taken: 0, episode: false }
    }

    /// Collects items until there are no more. Bytes of `piece` are taken only if they are lent.
    fn drain(&mut self, piece: &mut &[u8]) {
        loop {
            let before = piece.len();
            let item = match self.feed {
                Feed::Push => self.frames.next(),
                Feed::Lend => self.frames.next_from(piece),
            };
            self.received += before - piece.len();
            let Some(item) = item else { break };
            let len = item.bytes().len();
            assert!(len > 0 || matches!(item, Item::Fatal(_)), "an item without bytes");
            self.taken += len;
            match item {
                Item::Frame(frame) => {
                    self.episode = false;
                    self.items.push(Owned::Frame(frame.as_ref().to_vec()));
                }
                Item::Corrupt { header, why, bytes } => {
                    assert!(!self.episode, "a second corrupt frame in one episode");
                    self.episode = true;
                    self.items.push(Owned::Corrupt { header, why, bytes: bytes.to_vec() });
                }
                Item::Noise { bytes, why } => match self.items.last_mut() {
                    Some(Owned::Noise { bytes: before, .. }) => before.extend(bytes),
                    _ => self.items.push(Owned::Noise { bytes: bytes.to_vec(), why }),
                },
                Item::Fatal(why) => {
                    assert!(!matches!(self.items.last(), Some(Owned::Fatal(_))), "a fatal error outlived a resync");
                    self.items.push(Owned::Fatal(why));
                    let again = self.frames.next();
                    assert!(matches!(again, Some(Item::Fatal(same)) if same == why), "a fatal error went by itself");
                    self.frames.resync();
                }
            }
            assert_eq!(self.received, self.taken + self.frames.held(), "bytes in are items and bytes held");
        }
        assert_eq!(self.received, self.taken + self.frames.held(), "bytes in are items and bytes held");
    }

    /// Collects all items after a gap, when nothing may wait.
    fn drain_all(&mut self) {
        self.drain(&mut &[][..]);
        assert_eq!(self.frames.held(), 0, "bytes wait although a gap says that no more will come");
    }
}
