//! Messages that arrive, for the log.

use motion_core::stream::{Frames, Framing, Item};
use tracing::{Level, debug, enabled};

/// Listener on a line. It listens only if the log shows messages, because a session reads the line anyway.
#[derive(Debug)]
pub(crate) struct Tap<F: Framing, const N: usize>(Option<Box<Frames<F, N>>>);

impl<F: Framing, const N: usize> Tap<F, N> {
    pub(crate) fn new() -> Self {
        Self(enabled!(Level::DEBUG).then(Box::default))
    }

    /// Hears bytes, and notes the text of each frame, and what is no frame.
    pub(crate) fn hear(&mut self, from: &str, bytes: &[u8], text: fn(&[u8]) -> String) {
        let Some(frames) = &mut self.0 else { return };
        let mut rest = bytes;
        while let Some(item) = frames.next_from(&mut rest) {
            match item {
                Item::Frame(frame) => debug!("{from} {}", text(frame.as_ref())),
                Item::Noise { bytes, why } => debug!("{from} {} bytes are left out: {why}", bytes.len()),
                Item::Corrupt { why, .. } => debug!("{from} {why}"),
                Item::Fatal(why) => return debug!("{from} no stream of messages: {why}"),
            }
        }
    }
}
