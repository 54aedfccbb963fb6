//! The buffer between bytes in pieces and frames.

use core::fmt;

use super::{Corrupt, Fatal, Framing, Head, Item, Memo, Noise};

/// A stream's bytes that wait to become items: at most `N`, which is at least twice
/// [`Framing::MAX`].
///
/// Use it in a circle: [`push`](Self::push) bytes (or read them into [`spare_mut`](Self::spare_mut)
/// and [`commit`](Self::commit) them), then call [`next`](Self::next) until it has nothing more to
/// give. The first half of the circle then always has room, and makes progress.
///
/// A buffer smaller than twice the longest frame does not compile: half a buffer must be free when
/// the other half moves down, or moving would cost more than reading.
pub struct Frames<F: Framing, const N: usize> {
    buf: [u8; N],
    /// First byte that no item has taken.
    start: usize,
    /// First byte that is not filled.
    end: usize,
    /// Before the buffer is filled up to here, another look tells nothing new.
    wake: usize,
    /// Where the last gap lies. Frames before it get no byte from behind it.
    gap: usize,
    /// How many bytes to come are noise already, and why the run of noise began.
    skip: (usize, Noise),
    /// A corrupt frame was reported, and no good one has come since.
    episode: bool,
    /// What would be fatal is noise, until the next good frame.
    resync: bool,
    /// Bytes skipped and moved, and headers looked at in vain.
    work: usize,
    memo: F::Memo<N>,
}

/// What the bytes from some place on turn out to be, and how long it is.
enum Found {
    /// As many bytes as its header says, sound or not.
    Frame(usize),
    Noise(usize, Noise),
    Fatal(Fatal),
    /// Perhaps a frame: this many bytes in all will tell more.
    Open(usize),
}

impl<F: Framing, const N: usize> Frames<F, N> {
    /// An empty buffer, at the start of a stream.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(N >= F::MAX.saturating_mul(2), "the buffer must hold twice the longest frame") }
        Self {
            buf: [0; N],
            start: 0,
            end: 0,
            wake: 1,
            gap: 0,
            skip: (0, Noise::NoMarker),
            episode: false,
            resync: false,
            work: 0,
            memo: F::Memo::NEW,
        }
    }

    /// How many bytes wait to become items.
    #[inline]
    #[must_use]
    pub const fn held(&self) -> usize {
        self.end.saturating_sub(self.start)
    }

    /// How much was done so far: bytes skipped, moved, read or summed, and headers looked at in vain.
    ///
    /// It grows with the number of bytes received, whatever they are; tests hold that against it. The
    /// count wraps around.
    #[must_use]
    pub fn work(&self) -> usize {
        self.work.wrapping_add(self.memo.work())
    }

    /// Takes bytes that were received, as many as there is room for, and says how many.
    ///
    /// Takes at least one, if there is one and [`next`](Self::next) has nothing more to give.
    #[inline]
    #[must_use = "the bytes that were not taken have to be pushed again"]
    pub fn push(&mut self, bytes: &[u8]) -> usize {
        // Serial lines bring bytes one by one: that has to be cheap.
        let end = self.end;
        if let ([byte], Some(slot)) = (bytes, self.buf.get_mut(end)) {
            *slot = *byte;
            self.end = end.saturating_add(1);
            return 1;
        }
        self.push_many(bytes)
    }

    /// [`push`](Self::push), out of line: a loop over single bytes has no registers to spare for it.
    #[inline(never)]
    fn push_many(&mut self, bytes: &[u8]) -> usize {
        let spare = self.room(bytes.len());
        let n = spare.len().min(bytes.len());
        if let (Some(spare), Some(bytes)) = (spare.get_mut(..n), bytes.get(..n)) {
            spare.copy_from_slice(bytes);
        }
        self.commit(n);
        n
    }

    /// Room for bytes to be received. [`commit`](Self::commit) those that were.
    ///
    /// It is never empty when [`next`](Self::next) has nothing more to give.
    #[inline]
    pub fn spare_mut(&mut self) -> &mut [u8] {
        self.room(N / 2)
    }

    /// Takes the first `n` bytes of [`spare_mut`](Self::spare_mut) as received, or all if there are
    /// fewer.
    #[inline]
    pub fn commit(&mut self, n: usize) {
        self.end = self.end.saturating_add(n).min(N);
    }

    /// Takes note that the line has fallen silent: what waits for more bytes will not get them.
    ///
    /// After it, [`next`](Self::next) gives up what it waited for, until nothing is held. Bytes that
    /// arrive later are never joined to those from before, whether `next` was called in between or
    /// not. Only the last gap is remembered: call `next` until it has nothing more to give before
    /// another one.
    pub fn gap(&mut self) {
        self.gap = self.end;
        if self.held() == 0 {
            self.skip.0 = 0;
        } else {
            self.wake = 0;
        }
    }

    /// Leaves a fatal error behind: what would be fatal is noise, until the next good frame.
    ///
    /// Bytes of a payload can look like a frame, so this is a gamble; a new connection is not. Does
    /// nothing if the stream is in order.
    pub fn resync(&mut self) {
        let bytes = self.buf.get(self.start..self.reach()).unwrap_or_default();
        self.resync |= self.skip.0 == 0 && !bytes.is_empty() && matches!(F::head(bytes), Head::Fatal(_));
    }

    /// Forgets everything held: a new connection begins.
    pub fn reset(&mut self) {
        self.start = self.end;
        self.move_down();
        self.wake = 1;
        self.skip.0 = 0;
        self.episode = false;
        self.resync = false;
    }

    /// The next item, lent until the following call; `None` when more bytes are needed.
    #[inline]
    #[expect(clippy::should_implement_trait, reason = "an iterator cannot lend from itself")]
    pub fn next(&mut self) -> Option<Item<'_, F::Frame<'_>, F::Header>> {
        if self.end < self.wake { None } else { self.look() }
    }

    /// What [`next`](Self::next) does once there is something to look at.
    ///
    /// Nearly all looks find a frame, or the beginning of one. These stay here, where no answer is built in memory and no
    /// register has to be saved: that makes short frames twice as fast. All else is out of line.
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
                // Borrowed anew, to be lent; neither bounds nor header are looked at again, the optimiser knows them.
                let bytes = self.buf.get(from..reach).and_then(|bytes| bytes.get(..len)).unwrap_or_default();
                let item = F::frame(bytes).map_or(Item::Noise { bytes, why: Noise::Refused }, Item::Frame);
                self.episode = false;
                self.resync = false;
                self.start = from.wrapping_add(len);
                self.wake = self.start.wrapping_add(1);
                Some(item)
            }
            Head::Total(need) | Head::More(need) if need > bytes.len() && need <= F::MAX && !self.cut_off() => {
                self.wake = from.wrapping_add(need);
                None
            }
            _ => self.look_closely(),
        }
    }

    /// Looks at what is no frame, nor the beginning of one that may still come.
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
                self.wake = self.start.saturating_add(need);
                None
            }
            Found::Fatal(why) => Some(Item::Fatal(why)),
            Found::Frame(len) => self.corrupt(len),
        }
    }

    /// Reports a whole frame of `len` bytes that does not verify: once an episode as that, and else as noise.
    #[cold]
    #[inline(never)]
    #[expect(clippy::unnecessary_wraps, reason = "it writes the answer of its callers, which do nothing more")]
    fn corrupt(&mut self, len: usize) -> Option<Item<'_, F::Frame<'_>, F::Header>> {
        let bytes = self.buf.get(self.start..self.reach()).unwrap_or_default();
        let (header, lost) = (F::header(bytes), F::give_up(bytes));
        if self.episode {
            let run = self.run_on(lost, Noise::Checksum);
            return Some(Item::Noise { bytes: self.take(run), why: Noise::Checksum });
        }
        self.episode = true;
        let bytes = self.take(lost.max(1).min(len));
        Some(match header {
            Some(header) => Item::Corrupt { header, why: Corrupt::Checksum { len }, bytes },
            None => Item::Noise { bytes, why: Noise::Checksum },
        })
    }

    /// Judges the bytes from `at` on, of which there is at least one.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "the large answer is never built in memory: floods cost a third less")]
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
                // To wait for more than the longest frame would be to wait for ever.
                if need > F::MAX { Found::Noise(1, Noise::TooLong { total, max: F::MAX }) } else { Found::Open(need) }
            }
            Head::Skip(len, why) => Found::Noise(len, why),
            Head::Fatal(_) if self.resync => Found::Noise(F::resync(bytes), Noise::Resync),
            Head::Fatal(why) => Found::Fatal(why),
        }
    }

    /// Goes on over noise that began with `len` bytes, for as far as it reaches, so that it becomes one
    /// item. Says how many bytes of it are there.
    fn run_on(&mut self, len: usize, why: Noise) -> usize {
        let reach = self.reach();
        let mut at = self.start.saturating_add(len.max(1));
        let mut looks = 1_usize;
        while at < reach {
            looks = looks.wrapping_add(1);
            // Anything else is found again by the next look, as an item of its own.
            let Found::Noise(len, _) = self.judge(at) else { break };
            at = at.saturating_add(len.max(1));
        }
        let end = at.min(reach);
        let run = end.saturating_sub(self.start);
        self.skip = (if self.cut_off() { 0 } else { at.saturating_sub(end) }, why);
        self.work = self.work.wrapping_add(run).wrapping_add(looks);
        run
    }

    /// Whether a gap ends what is looked at.
    #[inline]
    const fn cut_off(&self) -> bool {
        self.gap > self.start
    }

    /// How far the frame at `start` can reach: to the gap, or else to the last byte.
    #[inline]
    const fn reach(&self) -> usize {
        if self.cut_off() { self.gap } else { self.end }
    }

    /// Takes the next `len` bytes out of the stream.
    #[inline]
    fn take(&mut self, len: usize) -> &[u8] {
        let from = self.start;
        self.start = from.saturating_add(len).min(self.end);
        self.wake = self.start.saturating_add(1);
        self.buf.get(from..self.start).unwrap_or_default()
    }

    /// Room for as many bytes as `wanted`, or fewer if that would move too much.
    #[inline]
    fn room(&mut self, wanted: usize) -> &mut [u8] {
        if self.start > 0 && (self.start == self.end || wanted > N.saturating_sub(self.end)) {
            self.move_down();
        }
        self.buf.get_mut(self.end..).unwrap_or_default()
    }

    /// Moves what is held to the start of the buffer, if that costs no more than was taken since the
    /// last time.
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
        self.wake = self.wake.saturating_sub(start);
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

    /// A framing that breaks every promise: each byte says what the header claims.
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
    fn a_framing_that_lies_can_neither_stall_the_stream_nor_lose_a_byte() {
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
    fn work_counts_what_is_moved_and_skipped() {
        let mut frames = Frames::<Liar, 9>::new();
        // Two bytes of noise, of which one is yet to come, then three bytes that wait for a fourth.
        assert_eq!(frames.push(&[16 + 2]), 1);
        assert!(matches!(frames.next(), Some(Item::Noise { bytes: [18], .. })));
        assert_eq!(frames.work(), 2, "a look, and a byte skipped");
        assert_eq!(frames.push(&[9, 32, 0, 0]), 4);
        assert!(matches!(frames.next(), Some(Item::Noise { bytes: [9], .. })));
        assert!(frames.next().is_none());
        assert_eq!(frames.work(), 5, "the other byte skipped, a look behind it");
        // The three begin at 1 or 2: too near to the start to be moved.
        assert_eq!(frames.push(&[0; 9]), 5);
        assert_eq!((frames.work(), frames.held()), (5, 8));
        assert!(matches!(frames.next(), Some(Item::Noise { bytes: [32, 0, ..], .. })));
        while frames.next().is_some() {}
        let (work, held) = (frames.work(), frames.held());
        assert!(held > 0);
        assert_eq!(frames.push(&[0; 3]), 3);
        assert_eq!(frames.work(), work + held, "those that wait were moved");
    }
}
