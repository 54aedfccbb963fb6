//! Camera of a node, which is controlled by two lines.

use std::collections::VecDeque;

use motion_core::time::Millis;
use tracing::info;

/// Number of photos that are remembered. Earlier photos are only counted.
pub const PHOTOS: usize = 4096;

/// Photo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Photo {
    /// Time at which the shutter opened.
    pub opened: Millis,
    /// Time at which the shutter closed.
    pub closed: Millis,
}

/// Camera with a focus and a shutter.
#[derive(Debug, Clone, Default)]
pub struct Camera {
    photos: VecDeque<Photo>,
    taken: u64,
    opened: Option<Millis>,
    is_focused: bool,
}

impl Camera {
    /// Number of photos that were taken.
    #[must_use]
    pub const fn taken(&self) -> u64 {
        self.taken
    }

    /// Last photos, at most [`PHOTOS`].
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

    /// Sets the lines of the camera.
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
