//! Camera of a device.

use std::collections::VecDeque;

use motion_core::time::Millis;

/// Photo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Photo {
    /// Time at which the shutter opened.
    pub opened: Millis,
    /// Time at which the shutter closed, or will close.
    pub closes: Millis,
    /// Seconds of the move at which the shutter opened, if a move was played.
    pub moment: Option<f64>,
}

/// Camera. It counts its photos, and keeps the last ones.
#[derive(Debug, Clone, Default)]
pub(super) struct Camera {
    photos: VecDeque<Photo>,
    count: u64,
}

impl Camera {
    /// Number of photos that are kept.
    const KEPT: usize = 4096;

    pub(super) fn open(&mut self, photo: Photo) {
        if self.photos.len() == Self::KEPT {
            self.photos.pop_front();
        }
        self.photos.push_back(photo);
        self.count += 1;
    }

    /// Closes the shutter early.
    pub(super) fn close(&mut self, now: Millis) {
        if let Some(photo) = self.photos.back_mut() {
            photo.closes = photo.closes.min(now.max(photo.opened));
        }
    }

    pub(super) const fn count(&self) -> u64 {
        self.count
    }

    pub(super) fn photos(&self) -> impl Iterator<Item = &Photo> {
        self.photos.iter()
    }
}
