//! Camera, and a record of its photos.

use std::collections::VecDeque;

use motion_core::time::Millis;
use tracing::info;

/// Greatest number of photos in the record.
const RECORD: usize = 10_000;

/// Photo of the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Photo {
    /// Time at which the shutter opened.
    pub at: Millis,
    /// Time at which the shutter closed; `None` while it is open.
    pub until: Option<Millis>,
    /// Frame of the move; `None` for a photo that a request took without a move.
    pub frame: Option<i32>,
}

/// Camera with one shutter.
#[derive(Debug, Clone, Default)]
pub(super) struct Camera {
    photos: VecDeque<Photo>,
    count: u64,
    /// Time at which the shutter closes by itself.
    closes: Option<Millis>,
    pub(super) is_filming: bool,
}

impl Camera {
    /// Opens the shutter, for a time in milliseconds or until it is closed.
    pub(super) fn open(&mut self, now: Millis, time: Option<u64>, frame: Option<i32>) {
        self.close(now);
        self.count += 1;
        info!(number = self.count, frame, "photo");
        if self.photos.len() == RECORD {
            self.photos.pop_front();
        }
        self.photos.push_back(Photo { at: now, until: None, frame });
        self.closes = time.map(|time| now.after(time));
        self.advance(now);
    }

    /// Closes the shutter, if it is open.
    pub(super) fn close(&mut self, now: Millis) {
        if let Some(photo) = self.photos.back_mut().filter(|photo| photo.until.is_none()) {
            photo.until = Some(now);
            self.closes = None;
        }
    }

    /// Leaves the shutter open until it is closed, if it is open.
    pub(super) const fn stay_open(&mut self) {
        self.closes = None;
    }

    pub(super) fn advance(&mut self, now: Millis) {
        if let Some(closes) = self.closes.filter(|closes| *closes <= now) {
            self.close(closes);
        }
    }

    pub(super) const fn wake(&self) -> Option<Millis> {
        self.closes
    }

    pub(super) const fn count(&self) -> u64 {
        self.count
    }

    pub(super) fn photos(&self) -> impl Iterator<Item = &Photo> {
        self.photos.iter()
    }
}
