//! What arrives at either end of a DMC line: bytes in pieces, and a frame that is given up when they cease.

use dmc_proto::{Frame, Frames, Header, Item};
use motion_core::time::Millis;

/// Milliseconds without a byte, after which a frame that is not whole will not be.
const GAP: u64 = 250;

/// What arrives at one end of a line.
#[derive(Debug)]
pub(crate) struct Reader {
    frames: Box<Frames>,
    /// When a frame that is not whole is given up.
    until: Option<Millis>,
}

impl Reader {
    pub(crate) fn new() -> Self {
        Self { frames: Box::new(Frames::new()), until: None }
    }

    /// Forgets what has arrived.
    pub(crate) fn reset(&mut self) {
        self.frames.reset();
        self.until = None;
    }

    /// Bytes of a frame that is not whole.
    pub(crate) fn held(&self) -> usize {
        self.frames.held()
    }

    /// When there is something to give up.
    pub(crate) const fn wake(&self) -> Option<Millis> {
        self.until
    }

    /// Bytes arrived; `take` gets what is in them.
    pub(crate) fn receive(&mut self, now: Millis, bytes: &[u8], mut take: impl FnMut(Item<'_, Frame<'_>, Header>)) {
        let mut rest = bytes;
        while !rest.is_empty() {
            let taken = self.frames.push(rest);
            rest = &rest[taken..];
            while let Some(item) = self.frames.next() {
                take(item);
            }
        }
        self.until = (self.frames.held() > 0).then(|| now.after(GAP));
    }

    /// Gives up what is due; `take` gets what is in it.
    pub(crate) fn give_up(&mut self, now: Millis, mut take: impl FnMut(Item<'_, Frame<'_>, Header>)) {
        if self.until.take_if(|until| *until <= now).is_some() {
            self.frames.gap();
            while let Some(item) = self.frames.next() {
                take(item);
            }
        }
    }
}
