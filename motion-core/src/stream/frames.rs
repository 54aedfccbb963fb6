//! The buffer that collects bytes in pieces and finds frames in them.

use core::fmt;

use super::{Corrupt, Fatal, Framing, Head, Item, Memo, Noise};

/// Buffer of a stream that finds its frames. It holds at most `N` bytes, at least twice [`Framing::MAX`].
///
/// There are two ways to use it:
///
/// - Give each piece of received bytes to [`next_from`](Self::next_from), again and again until it returns `None`.
/// - If the bytes arrive in an interrupt, or are read straight into the buffer: [`push`](Self::push) bytes, or read them into
///   [`spare_mut`](Self::spare_mut) and [`commit`](Self::commit) them. Then call [`next`](Self::next) until it returns `None`.
///   After that there is always room for more bytes.
///
/// A buffer smaller than twice the longest frame does not compile. Half of the buffer must be free when the other half
/// moves to its start, because moving would cost more than reading otherwise.
pub struct Frames<F: Framing, const N: usize> {
    buf: [u8; N],
    /// Position of the first byte that no item has taken.
    start: usize,
    /// Position of the first byte that is not filled.
    end: usize,
    /// Position up to which the buffer was looked at in vain. Only with more bytes another look can find something new.
    seen: usize,
    /// Position of the last gap. A frame before the gap gets no byte from after it.
    gap: usize,
    /// Number of bytes to come that are known to be noise, and why the run of noise began.
    skip: (usize, Noise),
    /// Whether a corrupt frame was reported and no valid frame has come since.
    episode: bool,
    /// Whether fatal errors become noise, until the next valid frame.
    resync: bool,
    /// Number of bytes that valid frames in the buffer have to take before frames are lent from outside it again.
    wary: usize,
    /// Number of bytes skipped and moved, and of headers read without finding a frame.
    work: usize,
    memo: F::Memo<N>,
}

/// Length of a short piece in bytes, below which no frame is lent.
const SHORT: usize = 128;

/// Result of a look at the bytes from some position on, with its length in bytes.
enum Found {
    /// A frame of the length that its header says, valid or not.
    Frame(usize),
    Noise(usize, Noise),
    Fatal(Fatal),
    /// Perhaps a frame; the judgement needs this many bytes in all.
    Open(usize),
}

impl<F: Framing, const N: usize> Frames<F, N> {
    /// Number of bytes that [`push`](Self::push) always takes after [`next`](Self::next) has returned `None`.
    pub const PIECE: usize = N.saturating_sub(F::MAX.saturating_mul(2)).saturating_add(1);

    /// An empty buffer at the start of a stream. All its bytes are zero, so that a static buffer takes no flash.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(N >= F::MAX.saturating_mul(2), "the buffer must hold twice the longest frame") }
        Self {
            buf: [0; N],
            start: 0,
            end: 0,
            seen: 0,
            gap: 0,
            skip: (0, Noise::NoMarker),
            episode: false,
            resync: false,
            wary: 0,
            work: 0,
            memo: F::Memo::NEW,
        }
    }

    /// Number of bytes that are not part of an item yet.
    #[inline]
    #[must_use]
    pub const fn held(&self) -> usize {
        self.end.saturating_sub(self.start)
    }

    /// Whether bytes were added at which [`next`](Self::next) did not look yet.
    #[doc(hidden)]
    #[inline]
    #[must_use]
    pub const fn has_unseen(&self) -> bool {
        self.end > self.seen
    }

    /// Last `len` bytes that were taken as an item. They stay until bytes are added.
    #[doc(hidden)]
    #[must_use]
    pub fn taken(&self, len: usize) -> &[u8] {
        self.buf.get(self.start.saturating_sub(len)..self.start).unwrap_or_default()
    }

    /// Work done so far, for tests: bytes skipped, moved, read or summed, and headers read without finding a frame.
    ///
    /// It grows at most in proportion to the number of bytes received, which tests and fuzz targets check. The count
    /// wraps around.
    #[doc(hidden)]
    #[must_use]
    pub fn work(&self) -> usize {
        self.work.wrapping_add(self.memo.work())
    }

    /// Adds received bytes, as many as there is room for, and returns their number.
    ///
    /// At least one byte is added, if `bytes` is not empty and [`next`](Self::next) has returned `None`.
    #[inline]
    #[must_use = "the bytes that were not taken have to be pushed again"]
    pub fn push(&mut self, bytes: &[u8]) -> usize {
        // Serial lines deliver single bytes, so this case has to be fast.
        let end = self.end;
        if let ([byte], Some(slot)) = (bytes, self.buf.get_mut(end)) {
            *slot = *byte;
            self.end = end.saturating_add(1);
            return 1;
        }
        self.push_many(bytes)
    }

    /// The rest of [`push`](Self::push). It is not inlined, to leave more registers to a loop over single bytes.
    #[inline(never)]
    fn push_many(&mut self, bytes: &[u8]) -> usize {
        let end = self.end;
        if let Some(spare) = self.buf.get_mut(end..).and_then(|spare| spare.get_mut(..bytes.len())) {
            spare.copy_from_slice(bytes);
            self.end = end.wrapping_add(bytes.len());
            return bytes.len();
        }
        let spare = self.room(bytes.len());
        let n = spare.len().min(bytes.len());
        if let (Some(spare), Some(bytes)) = (spare.get_mut(..n), bytes.get(..n)) {
            spare.copy_from_slice(bytes);
        }
        self.commit(n);
        n
    }

    /// Room for bytes to be received. Report them with [`commit`](Self::commit).
    ///
    /// It is never empty when [`next`](Self::next) has returned `None`.
    #[inline]
    pub fn spare_mut(&mut self) -> &mut [u8] {
        self.room(N / 2)
    }

    /// Adds the first `n` bytes of [`spare_mut`](Self::spare_mut) as received, or all bytes if there are fewer.
    #[inline]
    pub fn commit(&mut self, n: usize) {
        self.end = self.end.saturating_add(n).min(N);
    }

    /// Reports that the line fell silent: an incomplete frame will not be completed.
    ///
    /// After it, [`next`](Self::next) gives up incomplete frames, until no byte is held. Bytes that arrive later never
    /// complete a frame from before the gap, whether `next` was called in between or not. Only the last gap is
    /// remembered: call `next` until it returns `None` before you report another gap.
    pub fn gap(&mut self) {
        self.gap = self.end;
        if self.held() == 0 {
            self.skip.0 = 0;
        } else {
            self.seen = 0;
        }
    }

    /// Gives up the incomplete frame at the start of the held bytes, because it is not whole in time. The search goes on
    /// after it, so that frames inside it are found, and the last one of them may still be completed.
    ///
    /// Call it when [`next`](Self::next) has returned `None`, and call `next` again after it.
    pub fn give_up(&mut self) {
        if self.held() > 0 {
            self.gap = self.gap.max(self.start.saturating_add(1));
            self.seen = 0;
        }
    }

    /// Number of bytes that the incomplete frame at the start of the held bytes needs in all, as far as they tell; 0 if
    /// no byte is held.
    ///
    /// It holds after [`next`](Self::next) has returned `None`.
    #[must_use]
    pub const fn needed(&self) -> usize {
        if self.held() == 0 { 0 } else { self.seen.saturating_add(1).saturating_sub(self.start) }
    }

    /// Continues after a fatal error: fatal errors become noise, until the next valid frame.
    ///
    /// Bytes of a payload can look like a frame, so this may find wrong frames; a new connection cannot. It does
    /// nothing if the stream has no fatal error.
    pub fn resync(&mut self) {
        let bytes = self.buf.get(self.start..self.reach()).unwrap_or_default();
        self.resync |= self.skip.0 == 0 && !bytes.is_empty() && matches!(F::head(bytes), Head::Fatal(_));
    }

    /// Drops all bytes that are held, for a new connection.
    pub fn reset(&mut self) {
        self.start = self.end;
        self.move_down();
        self.seen = 0;
        self.skip.0 = 0;
        self.episode = false;
        self.resync = false;
        self.wary = 0;
    }

    /// The next item, borrowed until the following call; `None` if more bytes are needed.
    #[inline]
    #[expect(clippy::should_implement_trait, reason = "an iterator cannot lend from itself")]
    pub fn next(&mut self) -> Option<Item<'_, F::Frame<'_>, F::Header>> {
        if self.has_unseen() { self.look() } else { None }
    }

    /// The next item of the held bytes and of the received `bytes` after them; `None` if more bytes are needed. Then
    /// `bytes` is empty, because all of it was taken.
    ///
    /// It is [`push`](Self::push) and [`next`](Self::next) in one, and finds the same items. While more than 128 bytes are
    /// left, a frame that lies whole in them is lent from there, and not copied. The rest goes through the buffer: the
    /// beginning of a frame that `bytes` cuts off, noise, and what follows noise up to the next valid frames.
    ///
    /// ```
    /// # use motion_core::stream::{Frames, Framing, Head, Item, Noise};
    /// # enum Pair {}
    /// # impl Framing for Pair {
    /// #     const MAX: usize = 2;
    /// #     type Header = ();
    /// #     type Frame<'a> = &'a [u8];
    /// #     type Memo<const N: usize> = ();
    /// #     fn head(bytes: &[u8]) -> Head {
    /// #         if bytes[0] == b'!' { Head::Total(2) } else { Head::Skip(1, Noise::NoMarker) }
    /// #     }
    /// #     fn header(_: &[u8]) -> Option<()> { Some(()) }
    /// #     fn frame(bytes: &[u8]) -> Option<&[u8]> { Some(bytes) }
    /// # }
    /// // A frame of `Pair` is a `!` and one byte.
    /// let mut frames = Frames::<Pair, 4>::new();
    /// let mut found = Vec::new();
    /// for mut received in [&b"!a!b!"[..], b"c!d"] {
    ///     while let Some(item) = frames.next_from(&mut received) {
    ///         if let Item::Frame(frame) = item {
    ///             found.push(frame[1]);
    ///         }
    ///     }
    /// }
    /// assert_eq!(found, *b"abcd");
    /// ```
    ///
    /// After an [`Item::Fatal`], the rest of `bytes` is not taken.
    #[inline]
    pub fn next_from<'s, 'b: 's>(&'s mut self, bytes: &mut &'b [u8]) -> Option<Item<'s, F::Frame<'s>, F::Header>> {
        // A short piece is copied faster than its frames are lent, because it cuts off nearly as many frames as it holds.
        if bytes.len() > SHORT && self.held() == 0 && self.wary == 0 {
            if let Head::Total(len @ 1..) = F::head(bytes) {
                if let Some((frame, after)) = bytes.split_at_checked(len) {
                    match F::frame(frame) {
                        Some(read) if F::Memo::<N>::is_sound(frame) => {
                            *bytes = after;
                            self.episode = false;
                            self.resync = false;
                            return Some(Item::Frame(read));
                        }
                        _ => self.doubt(len),
                    }
                }
            }
        }
        if (1..=SHORT).contains(&bytes.len()) {
            let taken = self.push(bytes);
            *bytes = bytes.get(taken..).unwrap_or_default();
        }
        if !bytes.is_empty() {
            self.fill(bytes);
        }
        self.next()
    }

    /// Remembers that a frame of `len` bytes outside the buffer is not valid. The buffer judges it again, and knows what it
    /// summed. So a frame may be judged outside only after a quarter of its bytes has gone through the buffer: then no byte
    /// is summed outside more than four times for each byte received.
    #[cold]
    fn doubt(&mut self, len: usize) {
        self.wary = (len / 4).saturating_add(1);
        self.work = self.work.wrapping_add(len);
    }

    /// Takes bytes for [`next_from`](Self::next_from), until an item is held or no byte is left.
    #[inline(never)]
    fn fill(&mut self, bytes: &mut &[u8]) {
        while !bytes.is_empty() && !self.has_item() {
            // Of a frame that a piece cut off, only the rest is taken, so that the frames after it are lent. After noise, all
            // bytes go through the buffer.
            let is_exact = bytes.len() > SHORT && self.wary == 0 && self.held() > 0;
            let most = if is_exact { self.needed().saturating_sub(self.held()) } else { bytes.len() };
            let taken = self.push_many(bytes.get(..most).unwrap_or(bytes));
            *bytes = bytes.get(taken..).unwrap_or_default();
        }
    }

    /// Whether [`next`](Self::next) finds an item in the held bytes, and not only the beginning of a frame.
    fn has_item(&mut self) -> bool {
        if !self.has_unseen() {
            return false;
        }
        self.work = self.work.wrapping_add(1);
        let bytes = self.buf.get(self.start..self.reach()).unwrap_or_default();
        // A whole frame is an item, valid or not, and is not verified twice.
        if self.skip.0 > 0 || matches!(F::head(bytes), Head::Total(len @ 1..) if len <= bytes.len()) {
            return true;
        }
        let Found::Open(need) = self.judge(self.start) else { return true };
        self.seen = self.start.saturating_add(need).saturating_sub(1);
        false
    }

    /// The part of [`next`](Self::next) after the check that there are new bytes.
    ///
    /// Nearly all looks find a frame or the beginning of one. These cases stay here, where no answer is built in memory
    /// and no register has to be saved, which makes short frames twice as fast. All other cases are not inlined.
    #[inline(never)]
    fn look(&mut self) -> Option<Item<'_, F::Frame<'_>, F::Header>> {
        if self.skip.0 > 0 {
            return self.look_closely();
        }
        let (from, reach) = (self.start, self.reach());
        let bytes = self.buf.get(from..reach)?;
        match F::head(bytes) {
            Head::Total(len @ 1..) if len <= bytes.len() => {
                if !self.memo.verify(self.buf.get(..reach).unwrap_or_default(), from, len) {
                    return self.corrupt(len);
                }
                // Borrowed again, for the returned item. The optimiser removes the second checks of bounds and header.
                let bytes = self.buf.get(from..reach).and_then(|bytes| bytes.get(..len)).unwrap_or_default();
                let item = F::frame(bytes).map_or(Item::Noise { bytes, why: Noise::Refused }, Item::Frame);
                self.episode = false;
                self.resync = false;
                self.wary = self.wary.saturating_sub(len);
                self.start = from.wrapping_add(len);
                self.seen = self.start;
                Some(item)
            }
            Head::Total(need) | Head::More(need) if need > bytes.len() && need <= F::MAX && !self.cut_off() => {
                self.seen = from.wrapping_add(need).wrapping_sub(1);
                None
            }
            _ => self.look_closely(),
        }
    }

    /// Looks at bytes that are no frame and no beginning of a frame that may still be completed.
    #[cold]
    #[inline(never)]
    fn look_closely(&mut self) -> Option<Item<'_, F::Frame<'_>, F::Header>> {
        let (known, why) = self.skip;
        match if known > 0 { Found::Noise(known, why) } else { self.judge(self.start) } {
            Found::Noise(len, why) => {
                let run = self.run_on(len, why);
                Some(Item::Noise { bytes: self.take(run), why })
            }
            Found::Open(need) => {
                self.seen = self.start.saturating_add(need).saturating_sub(1);
                None
            }
            Found::Fatal(why) => Some(Item::Fatal(why)),
            Found::Frame(len) => self.corrupt(len),
        }
    }

    /// Reports a whole frame of `len` bytes that does not verify: as corrupt once in an episode, otherwise as noise.
    #[cold]
    #[inline(never)]
    #[expect(clippy::unnecessary_wraps, reason = "it builds the answer of its callers in place")]
    fn corrupt(&mut self, len: usize) -> Option<Item<'_, F::Frame<'_>, F::Header>> {
        let bytes = self.buf.get(self.start..self.reach()).unwrap_or_default();
        let (header, lost) = (F::header(bytes), F::give_up(bytes));
        if self.episode {
            let run = self.run_on(lost, Noise::Checksum);
            return Some(Item::Noise { bytes: self.take(run), why: Noise::Checksum });
        }
        self.episode = true;
        self.wary = self.wary.max(1);
        let bytes = self.take(lost.max(1).min(len));
        Some(match header {
            Some(header) => Item::Corrupt { header, why: Corrupt::Checksum { len }, bytes },
            None => Item::Noise { bytes, why: Noise::Checksum },
        })
    }

    /// Judges the bytes from `at` on, of which there is at least one.
    // In firmware the code has to be short, because it has to be stored.
    #[cfg_attr(target_os = "none", inline(never))]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    #[cfg_attr(
        not(target_os = "none"),
        expect(clippy::inline_always, reason = "the large answer is never built in memory: floods cost a third less")
    )]
    fn judge(&mut self, at: usize) -> Found {
        let filled = self.buf.get(..self.reach()).unwrap_or_default();
        let bytes = filled.get(at..).unwrap_or_default();
        match F::head(bytes) {
            Head::Total(len @ 1..) if len <= bytes.len() => {
                if self.memo.verify(filled, at, len) || !self.episode {
                    Found::Frame(len)
                } else {
                    Found::Noise(F::give_up(bytes), Noise::Checksum)
                }
            }
            Head::Total(_) | Head::More(_) if self.cut_off() => Found::Noise(F::give_up(bytes), Noise::CutOff),
            Head::Total(total) | Head::More(total) => {
                let need = total.max(bytes.len().saturating_add(1));
                // The buffer may have no room for more than the longest frame, so the wait might never end.
                if need > F::MAX { Found::Noise(1, Noise::TooLong { total, max: F::MAX }) } else { Found::Open(need) }
            }
            Head::Skip(len, why) => Found::Noise(len, why),
            Head::Fatal(_) if self.resync => Found::Noise(F::resync(bytes), Noise::Resync),
            Head::Fatal(why) => Found::Fatal(why),
        }
    }

    /// Extends noise that began with `len` bytes as far as it reaches, so that it becomes one item. Returns the number
    /// of its bytes that have arrived.
    fn run_on(&mut self, len: usize, why: Noise) -> usize {
        let reach = self.reach();
        let mut at = self.start.saturating_add(len.max(1));
        let mut looks = 1_usize;
        while at < reach {
            looks = looks.wrapping_add(1);
            // The next look finds anything else again, as an item of its own.
            let Found::Noise(len, _) = self.judge(at) else { break };
            at = at.saturating_add(len.max(1));
        }
        let end = at.min(reach);
        let run = end.saturating_sub(self.start);
        self.skip = (if self.cut_off() { 0 } else { at.saturating_sub(end) }, why);
        self.wary = self.wary.max(1);
        self.work = self.work.wrapping_add(run).wrapping_add(looks);
        run
    }

    /// Whether a gap ends the bytes that are looked at.
    #[inline]
    const fn cut_off(&self) -> bool {
        self.gap > self.start
    }

    /// Position up to which the frame at `start` can reach: the gap, or else the last byte.
    #[inline]
    const fn reach(&self) -> usize {
        if self.cut_off() { self.gap } else { self.end }
    }

    /// Takes the next `len` bytes from the stream.
    #[inline]
    fn take(&mut self, len: usize) -> &[u8] {
        let from = self.start;
        self.start = from.saturating_add(len).min(self.end);
        self.seen = self.start;
        self.buf.get(from..self.start).unwrap_or_default()
    }

    /// Room for `wanted` bytes, or for fewer if that would move too many bytes.
    #[inline]
    fn room(&mut self, wanted: usize) -> &mut [u8] {
        if self.start > 0 && (self.start == self.end || wanted > N.saturating_sub(self.end)) {
            self.move_down();
        }
        self.buf.get_mut(self.end..).unwrap_or_default()
    }

    /// Moves the held bytes to the start of the buffer, if they are not more than the bytes taken since the last move.
    fn move_down(&mut self) {
        let (start, held) = (self.start, self.held());
        if held > start {
            return;
        }
        if held > 0 {
            if let Some((to, from)) = self.buf.split_at_mut_checked(start) {
                if let (Some(to), Some(from)) = (to.get_mut(..held), from.get(..held)) {
                    to.copy_from_slice(from);
                }
            }
        }
        self.work = self.work.wrapping_add(held);
        self.memo.shift(start);
        self.gap = self.gap.saturating_sub(start);
        self.seen = self.seen.saturating_sub(start);
        self.start = 0;
        self.end = held;
    }
}

impl<F: Framing, const N: usize> Default for Frames<F, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<F: Framing, const N: usize> fmt::Debug for Frames<F, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Frames").field("held", &self.held()).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A framing that breaks every promise: each byte decides what the header claims.
    enum Liar {}

    impl Framing for Liar {
        const MAX: usize = 4;
        type Header = ();
        type Frame<'a> = &'a [u8];
        type Memo<const N: usize> = ();

        fn head(bytes: &[u8]) -> Head {
            let n = usize::from(bytes[0] >> 3) * if bytes[0] > 250 { usize::MAX / 31 } else { 1 };
            match bytes[0] % 4 {
                0 => Head::More(n),
                1 => Head::Total(n),
                2 => Head::Skip(n, Noise::NoMarker),
                _ => Head::Fatal(Fatal::BadVersion { found: bytes[0], expected: 0 }),
            }
        }
        fn header(_: &[u8]) -> Option<()> {
            None
        }
        fn frame(bytes: &[u8]) -> Option<&[u8]> {
            (bytes.len() % 2 == 0).then_some(bytes)
        }
        fn give_up(bytes: &[u8]) -> usize {
            usize::from(bytes[0]) % 9
        }
        fn resync(bytes: &[u8]) -> usize {
            usize::from(bytes[0]) % 7
        }
    }

    #[test]
    fn a_wrong_framing_can_neither_stall_the_stream_nor_lose_a_byte() {
        let mut frames = Frames::<Liar, 9>::new();
        let (mut pushed, mut taken) = (0, 0);
        for byte in 0..=255_u8 {
            for mut piece in [&[byte][..], &[byte, byte.wrapping_mul(77), 3, 4], &[byte; 30]] {
                while !piece.is_empty() {
                    let n = frames.push(piece);
                    assert!(n > 0, "no room");
                    piece = &piece[n..];
                    pushed += n;
                    if byte % 16 == 0 {
                        frames.gap();
                    }
                    while let Some(item) = frames.next() {
                        let (fatal, len) = (matches!(item, Item::Fatal(_)), item.bytes().len());
                        assert!(fatal || len > 0, "an empty item");
                        taken += len;
                        if fatal {
                            frames.resync();
                        }
                    }
                }
            }
            frames.gap();
            while let Some(item) = frames.next() {
                taken += item.bytes().len();
            }
            assert_eq!((frames.held(), taken), (0, pushed));
        }
    }

    #[test]
    fn a_wrong_framing_can_not_stall_what_is_lent() {
        let mut frames = Frames::<Liar, 9>::new();
        let (mut pushed, mut taken) = (0, 0);
        for byte in 0..=255_u8 {
            for len in [1, 3, 200] {
                let piece = [byte, byte.wrapping_mul(77), 8, 4, 9].repeat(len);
                let mut rest = &piece[..];
                while let Some(item) = frames.next_from(&mut rest) {
                    let (fatal, len) = (matches!(item, Item::Fatal(_)), item.bytes().len());
                    assert!(fatal || len > 0, "an empty item");
                    taken += len;
                    if fatal {
                        frames.resync();
                    }
                }
                assert!(rest.is_empty(), "bytes were left");
                pushed += piece.len();
                assert_eq!(taken + frames.held(), pushed);
            }
        }
    }

    #[test]
    fn work_counts_what_is_moved_and_skipped() {
        let mut frames = Frames::<Liar, 9>::new();
        // Two bytes of noise, of which the second has not arrived, then three bytes that wait for a fourth.
        assert_eq!(frames.push(&[16 + 2]), 1);
        assert!(matches!(frames.next(), Some(Item::Noise { bytes: [18], .. })));
        assert_eq!(frames.work(), 2, "one look, and one byte skipped");
        assert_eq!(frames.push(&[9, 32, 0, 0]), 4);
        assert!(matches!(frames.next(), Some(Item::Noise { bytes: [9], .. })));
        assert!(frames.next().is_none());
        assert_eq!(frames.work(), 5, "the other byte skipped, and one look after it");
        // The three bytes begin at 2, which is too near to the start to move them.
        assert_eq!(frames.push(&[0; 9]), 4);
        assert_eq!((frames.work(), frames.held()), (5, 7));
        assert!(matches!(frames.next(), Some(Item::Noise { bytes: [32, 0, ..], .. })));
        while frames.next().is_some() {}
        let (work, held) = (frames.work(), frames.held());
        assert!(held > 0);
        assert_eq!(frames.push(&[0; 3]), 3);
        assert_eq!(frames.work(), work + held, "the held bytes were moved");
    }
}
