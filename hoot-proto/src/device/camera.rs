//! The camera: its settings, and the steps of a picture. The table of hoot, section 4.4.

use motion_core::states;
use motion_core::time::Millis;

use super::{Effects, Event};
use crate::message::{Milliseconds, ShortMilliseconds, ShortShots};

states! {
    /// State of the camera. It is busy in all states except the first. Source: hoot, section 4.4.
    #[derive(Default)]
    pub enum CameraState {
        /// The camera does nothing.
        #[default]
        Idle,
        /// The focus is held.
        Focus,
        /// The shutter is held.
        Exposing,
        /// The picture is being stored.
        Delay,
    }
}

/// Settings of the camera, which a master can write and ask for. Source: hoot, section 2.4.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub struct CameraSettings {
    /// Whether there is a camera.
    pub enable: bool,
    /// Time for which the shutter is held.
    pub exposure_time: Milliseconds,
    /// Time for which the focus is held before the shutter.
    pub focus_time: ShortMilliseconds,
    /// Number of pictures after which a program ends; 0 for no end.
    pub max_shots: ShortShots,
    /// Time to wait after a picture.
    pub exposure_delay: ShortMilliseconds,
    /// Whether the focus is held together with the shutter.
    pub focus_with_shutter: bool,
    /// Whether a first release brings the mirror up, and takes no picture.
    pub mirror_up: bool,
    /// Time from one picture of a program to the next.
    pub interval: Milliseconds,
}

motion_core::debug! { CameraSettings { enable exposure_time focus_time max_shots exposure_delay focus_with_shutter mirror_up interval } }

/// Role of a release in a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
enum Release {
    /// The only release.
    #[default]
    Only,
    /// The release that brings the mirror up.
    Mirror,
    /// The release after that.
    Picture,
    /// The only release, without a focus and without a delay.
    Bare,
}

/// The camera of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct CameraUnit {
    pub(super) settings: CameraSettings,
    state: CameraState,
    release: Release,
    until: Option<Millis>,
}

impl CameraUnit {
    /// Settings of the camera.
    #[must_use]
    pub const fn settings(&self) -> &CameraSettings {
        &self.settings
    }

    /// State of the camera.
    #[must_use]
    pub const fn state(&self) -> CameraState {
        self.state
    }

    /// Whether the camera does anything.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.state != CameraState::Idle
    }

    pub(super) fn set_back(&mut self, by: Millis) {
        self.until = self.until.map(|until| Millis(until.since(by)));
    }

    /// Time at which the next step is due.
    pub(super) const fn until(&self) -> Option<Millis> {
        self.until
    }

    /// Takes a picture, by two releases if the mirror goes up first. A busy camera goes on with its picture (decision
    /// H-15); a camera that is not enabled does nothing.
    pub(super) fn expose(&mut self, now: Millis, output: &mut Effects, mirror_up: bool) {
        if self.settings.enable && !self.is_busy() {
            self.release = if mirror_up { Release::Mirror } else { Release::Only };
            match self.settings.focus_time.0 {
                0 => self.open(now, output),
                time => self.enter(now, output, CameraState::Focus, time.into()),
            }
        }
    }

    /// Takes a picture as firmware does on command: only by the shutter, and without a camera too. An exposure of 0 takes none.
    pub(super) fn expose_bare(&mut self, now: Millis, output: &mut Effects) {
        if !self.is_busy() && self.settings.exposure_time.0 > 0 {
            self.release = Release::Bare;
            self.open(now, output);
        }
    }

    /// Releases focus and shutter.
    pub(super) fn stop(&mut self, output: &mut Effects) {
        if self.is_busy() {
            (self.state, self.release, self.until) = (CameraState::Idle, Release::Only, None);
            self.lines(output);
        }
    }

    /// Takes the next step if it is due, and returns whether a picture is to be counted.
    pub(super) fn wake(&mut self, now: Millis, output: &mut Effects) -> bool {
        if self.until.is_none_or(|until| now < until) {
            return false;
        }
        match (self.state, self.release) {
            (CameraState::Focus, _) => self.open(now, output),
            (CameraState::Exposing, Release::Bare) => {
                self.stop(output);
                return true;
            }
            (CameraState::Exposing, release) => {
                self.enter(now, output, CameraState::Delay, self.settings.exposure_delay.0.into());
                return release != Release::Picture;
            }
            (CameraState::Delay, Release::Mirror) => {
                self.release = Release::Picture;
                self.open(now, output);
            }
            (CameraState::Delay | CameraState::Idle, _) => {
                (self.state, self.release, self.until) = (CameraState::Idle, Release::Only, None);
            }
        }
        false
    }

    fn open(&mut self, now: Millis, output: &mut Effects) {
        self.enter(now, output, CameraState::Exposing, self.settings.exposure_time.0.into());
    }

    /// Enters a state for a time, which is at least a millisecond.
    fn enter(&mut self, now: Millis, output: &mut Effects, state: CameraState, time: u64) {
        self.state = state;
        self.until = Some(now.after(time.max(1)));
        self.lines(output);
    }

    fn lines(&self, output: &mut Effects) {
        let shutter = self.state == CameraState::Exposing;
        let focus = self.state == CameraState::Focus || shutter && self.settings.focus_with_shutter;
        output.event(Event::Camera { focus, shutter });
    }
}
