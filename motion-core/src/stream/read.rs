use embedded_io::Read;

use super::{Frames, Framing};

impl<F: Framing, const N: usize> Frames<F, N> {
    /// Reads once from a reader into the free part of the buffer, and returns the number of bytes. The feature
    /// `embedded-io` adds the dependency of that name, which has no dependencies of its own.
    ///
    /// Call it when [`next`](Self::next) returns `None`, because there may be no room otherwise. Then `Ok(0)` means the
    /// end of the stream; call [`gap`](Self::gap) there, and `next` returns the bytes that are still held.
    ///
    /// # Errors
    ///
    /// The errors of the reader. The bytes that are held stay, so the call can be repeated.
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
    /// // A frame of `Pair` is a `!` and one byte; a slice is a reader.
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
    /// assert_eq!(frames.held(), 1, "an incomplete frame");
    /// # Ok::<(), core::convert::Infallible>(())
    /// ```
    ///
    /// With an asynchronous reader, such as `embedded_io_async::Read`, it is two lines:
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

    /// Frames of a `!` and one byte.
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

    /// A reader that returns at most this many of these bytes at a time, and fails once if the last field is set.
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
            assert!(!buf.is_empty(), "there is room to read into");
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
    fn frames_are_read_in_pieces_and_an_error_loses_no_byte() {
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
