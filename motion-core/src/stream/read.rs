use embedded_io::Read;

use super::{Frames, Framing};

impl<F: Framing, const N: usize> Frames<F, N> {
    /// Reads once, as much as there is and has room; says how many bytes. Feature `embedded-io`; it adds the dependency
    /// of that name, which has none.
    ///
    /// Call it when [`next`](Self::next) has nothing more to give, since else there may be no room. Then `Ok(0)` is the
    /// end of the stream, and after a [`gap`](Self::gap) `next` gives what was held.
    ///
    /// # Errors
    ///
    /// Those of the reader. What is held stays, so it can be tried again.
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
    /// // The frames of `Pair` are a `!` and one byte; a slice is a reader.
    /// let mut serial_line = &b"!a!b..!c!"[..];
    /// let mut frames = Frames::<Pair, 4>::new();
    /// let mut found = Vec::new();
    /// while frames.read_from(&mut serial_line)? > 0 {
    ///     while let Some(item) = frames.next() {
    ///         if let Item::Frame(frame) = item {
    ///             found.push(frame[1]);
    ///         }
    ///     }
    /// }
    /// assert_eq!(found, *b"abc");
    /// assert_eq!(frames.held(), 1, "a frame that was cut off");
    /// # Ok::<(), core::convert::Infallible>(())
    /// ```
    ///
    /// Of an asynchronous reader, such as `embedded_io_async::Read`, the same in two lines:
    ///
    /// ```text
    /// let n = reader.read(frames.spare_mut()).await?;
    /// frames.commit(n);
    /// ```
    pub fn read_from<R: Read>(&mut self, reader: &mut R) -> Result<usize, R::Error> {
        let n = reader.read(self.spare_mut())?;
        self.commit(n);
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;
    use crate::stream::{Head, Item, Noise};

    /// A `!` and one byte.
    enum Pair {}

    impl Framing for Pair {
        const MAX: usize = 2;
        type Header = ();
        type Frame<'a> = &'a [u8];
        type Memo<const N: usize> = ();

        fn head(bytes: &[u8]) -> Head {
            if bytes[0] == b'!' { Head::Total(2) } else { Head::Skip(1, Noise::NoMarker) }
        }
        fn header(_: &[u8]) -> Option<()> {
            Some(())
        }
        fn frame(bytes: &[u8]) -> Option<&[u8]> {
            Some(bytes)
        }
    }

    /// Gives `0` bytes at most at a time, and fails once in between.
    struct Line<'a>(usize, &'a [u8], bool);

    #[derive(Debug, PartialEq, thiserror::Error)]
    #[error("parity")]
    struct Parity;

    impl embedded_io::Error for Parity {
        fn kind(&self) -> embedded_io::ErrorKind {
            embedded_io::ErrorKind::InvalidData
        }
    }

    impl embedded_io::ErrorType for Line<'_> {
        type Error = Parity;
    }

    impl Read for Line<'_> {
        fn read(&mut self, buf: &mut [u8]) -> Result<usize, Parity> {
            assert!(!buf.is_empty(), "nothing can be read into no room");
            if core::mem::take(&mut self.2) {
                return Err(Parity);
            }
            let n = buf.len().min(self.1.len()).min(self.0);
            buf[..n].copy_from_slice(&self.1[..n]);
            self.1 = &self.1[n..];
            Ok(n)
        }
    }

    #[test]
    fn pieces_become_frames_and_an_error_loses_nothing() {
        for most in 1..9 {
            let mut frames = Frames::<Pair, 5>::new();
            let mut found = Vec::new();
            let mut line = Line(most, b"!a.!b!c!", false);
            let mut reads = 0;
            loop {
                reads += 1;
                line.2 = reads == 3;
                match frames.read_from(&mut line) {
                    Err(error) => assert_eq!((error, reads), (Parity, 3)),
                    Ok(0) => break,
                    Ok(n) => assert!(n <= most),
                }
                while let Some(item) = frames.next() {
                    found.extend_from_slice(item.bytes());
                }
            }
            assert_eq!((&found[..], frames.held()), (&b"!a.!b!c"[..], 1));
            frames.gap();
            assert!(matches!(frames.next(), Some(Item::Noise { bytes: b"!", why: Noise::CutOff })));
        }
    }
}
