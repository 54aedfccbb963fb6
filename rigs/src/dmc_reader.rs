//! Reader of a DMC line, for rigs and hosts: it joins bytes to frames, and gives up a frame that stays incomplete.

use dmc_proto::{Frame, Frames, Header, Item};
use motion_core::time::Millis;

/// Time without a byte after which an incomplete frame is given up, in milliseconds.
const GAP: u64 = 250;

/// Reader at one end of a line.
#[derive(Debug)]
pub(crate) struct Reader {
    frames: Box<Frames>,
    /// Time at which an incomplete frame is given up.
    until: Option<Millis>,
}

impl Reader {
    pub(crate) fn new() -> Self {
        Self { frames: Box::new(Frames::new()), until: None }
    }

    /// Forgets everything that arrived.
    pub(crate) fn reset(&mut self) {
        self.frames.reset();
        self.until = None;
    }

    /// Number of bytes of an incomplete frame.
    pub(crate) fn held(&self) -> usize {
        self.frames.held()
    }

    /// Time at which something is due.
    pub(crate) const fn wake(&self) -> Option<Millis> {
        self.until
    }

    /// Reads bytes, and gives each item in them to `take`.
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

    /// Gives up an incomplete frame that is due, and gives each item in its bytes to `take`.
    pub(crate) fn give_up(&mut self, now: Millis, mut take: impl FnMut(Item<'_, Frame<'_>, Header>)) {
        if self.until.take_if(|until| *until <= now).is_some() {
            self.frames.gap();
            while let Some(item) = self.frames.next() {
                take(item);
            }
        }
    }
}
