//! The camera: what it is set to, and where a picture is. The table of hoot, section 4.4.

use motion_core::time::Millis;

use super::{Event, Output};
use crate::message::{Milliseconds, ShortMilliseconds, ShortShots};
use crate::state::{debug, set_back, states};

states! {
    /// What the camera does. It is busy in all but the first. Source: hoot, section 4.4.
    pub enum CameraState {
        /// Nothing.
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

/// What a master sets of the camera, and can ask for. Source: hoot, section 2.4.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub struct CameraSettings {
    /// Whether there is a camera.
    pub enable: bool,
    /// How long the shutter is held.
    pub exposure_time: Milliseconds,
    /// How long the focus is held before.
    pub focus_time: ShortMilliseconds,
    /// After how many pictures a program ends; 0 for no end.
    pub max_shots: ShortShots,
    /// How long to wait after a picture.
    pub exposure_delay: ShortMilliseconds,
    /// Whether the focus is held together with the shutter.
    pub focus_with_shutter: bool,
    /// Whether a first release only brings the mirror up.
    pub mirror_up: bool,
    /// The time from one picture of a program to the next.
    pub interval: Milliseconds,
}

debug! { CameraSettings { enable exposure_time focus_time max_shots exposure_delay focus_with_shutter mirror_up interval } }

/// Which release this is, of one picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
enum Release {
    /// The only one.
    #[default]
    Only,
    /// The one that brings the mirror up.
    Mirror,
    /// The one behind that.
    Picture,
}

/// The camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct CameraUnit {
    pub(super) settings: CameraSettings,
    state: CameraState,
    release: Release,
    until: Option<Millis>,
}

impl CameraUnit {
    /// What it is set to.
    #[must_use]
    pub const fn settings(&self) -> &CameraSettings {
        &self.settings
    }

    /// What it does.
    #[must_use]
    pub const fn state(&self) -> CameraState {
        self.state
    }

    /// Whether it does anything.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.state != CameraState::Idle
    }

    pub(super) fn set_back(&mut self, by: u64) {
        self.until = self.until.map(|until| set_back(until, by));
    }

    /// When something is due.
    pub(super) const fn until(&self) -> Option<Millis> {
        self.until
    }

    /// Takes a picture, by two releases if the mirror goes up first. A camera that is busy goes on with what it does
    /// (decision H-15), one that is not enabled does nothing.
    pub(super) fn expose(&mut self, now: Millis, output: &mut Output, mirror_up: bool) {
        if self.settings.enable && !self.is_busy() {
            self.release = if mirror_up { Release::Mirror } else { Release::Only };
            match self.settings.focus_time.0 {
                0 => self.open(now, output),
                time => self.enter(now, output, CameraState::Focus, time.into()),
            }
        }
    }

    /// Lets go of focus and shutter.
    pub(super) fn stop(&mut self, output: &mut Output) {
        if self.is_busy() {
            (self.state, self.release, self.until) = (CameraState::Idle, Release::Only, None);
            self.lines(output);
        }
    }

    /// Goes on, if a moment has come that it waits for, and says whether a picture is to be counted.
    pub(super) fn wake(&mut self, now: Millis, output: &mut Output) -> bool {
        if self.until.is_none_or(|until| now < until) {
            return false;
        }
        match (self.state, self.release) {
            (CameraState::Focus, _) => self.open(now, output),
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

    fn open(&mut self, now: Millis, output: &mut Output) {
        self.enter(now, output, CameraState::Exposing, self.settings.exposure_time.0.into());
    }

    /// Each state takes a millisecond at least.
    fn enter(&mut self, now: Millis, output: &mut Output, state: CameraState, time: u64) {
        self.state = state;
        self.until = Some(now.after(time.max(1)));
        self.lines(output);
    }

    fn lines(&self, output: &mut Output) {
        let shutter = self.state == CameraState::Exposing;
        let focus = self.state == CameraState::Focus || shutter && self.settings.focus_with_shutter;
        output.event(Event::Camera { focus, shutter });
    }
}
