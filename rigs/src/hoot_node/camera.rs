//! The camera at a node: two lines, and what they made of it.

use std::collections::VecDeque;

use motion_core::time::Millis;
use tracing::info;

/// How many photos are remembered; of earlier ones only their number is.
pub const PHOTOS: usize = 4096;

/// A photo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Photo {
    /// When the shutter opened.
    pub opened: Millis,
    /// When it closed.
    pub closed: Millis,
}

/// A camera that is released by its focus and its shutter.
#[derive(Debug, Clone, Default)]
pub struct Camera {
    photos: VecDeque<Photo>,
    taken: u64,
    opened: Option<Millis>,
    is_focused: bool,
}

impl Camera {
    /// How many photos were taken.
    #[must_use]
    pub const fn taken(&self) -> u64 {
        self.taken
    }

    /// The last photos, at most [`PHOTOS`].
    pub fn photos(&self) -> impl Iterator<Item = &Photo> {
        self.photos.iter()
    }

    /// Whether the shutter is open.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        self.opened.is_some()
    }

    /// Whether the focus is held.
    #[must_use]
    pub const fn is_focused(&self) -> bool {
        self.is_focused
    }

    /// Its lines are so from now on.
    pub(super) fn lines(&mut self, now: Millis, focus: bool, shutter: bool) {
        self.is_focused = focus;
        match self.opened {
            None if shutter => self.opened = Some(now),
            Some(opened) if !shutter => {
                self.opened = None;
                self.taken += 1;
                if self.photos.len() == PHOTOS {
                    self.photos.pop_front();
                }
                self.photos.push_back(Photo { opened, closed: now });
                info!("photo {} of {} ms", self.taken, now.since(opened));
            }
            _ => {}
        }
    }
}
