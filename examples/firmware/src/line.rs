//! Line in memory between a host and a device in one program.

use core::convert::Infallible;

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::pipe::Pipe;
use embedded_io_async::{ErrorType, Read, Write};

/// Line in memory: two pipes.
pub struct Line([Pipe<NoopRawMutex, 256>; 2]);

/// End of a line.
pub struct End<'l> {
    from: &'l Pipe<NoopRawMutex, 256>,
    to: &'l Pipe<NoopRawMutex, 256>,
}

impl Line {
    /// Makes a line without bytes.
    #[must_use]
    pub const fn new() -> Self {
        Self([Pipe::new(), Pipe::new()])
    }

    /// Both ends of the line.
    pub fn ends(&self) -> (End<'_>, End<'_>) {
        let [there, back] = &self.0;
        (End { from: back, to: there }, End { from: there, to: back })
    }
}

impl Default for Line {
    fn default() -> Self {
        Self::new()
    }
}

impl ErrorType for End<'_> {
    type Error = Infallible;
}

impl Read for End<'_> {
    async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        Ok(self.from.read(bytes).await)
    }
}

impl Write for End<'_> {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        Ok(self.to.write(bytes).await)
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
