//! The camera: sub-address 4. It has no joystick gate: a camera can be released in joystick mode.

use motion_core::message;
use motion_core::wire::Bool;

use super::bounded::bounded;
use super::units::{Milliseconds, ShortMilliseconds, ShortShots};

message! {
    /// Set whether a camera is there to be released. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraSetEnable in BE {
        /// Whether it is.
        enable: Bool,
    }

    /// Take a picture, exposed for the time of [`CameraSetExposureTime`].
    ///
    /// Not to be sent again by itself. Source: hoot, section 2.4; safety decisions 1 and 9.
    #[derive(Default)]
    pub struct CameraExpose in BE {}

    /// Set how long the shutter is held. Source: hoot, section 2.4; safety decision 3.
    #[derive(Default)]
    pub struct CameraSetExposureTime in BE {
        /// How long; no more than 16,777,215 arrives.
        exposure_time: Milliseconds,
    }

    /// Set how long the focus is held before a picture. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraSetFocusTime in BE {
        /// How long.
        focus_time: ShortMilliseconds,
    }

    /// Set after how many pictures the program ends. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraSetMaxShots in BE {
        /// How many, 0 for no end. It is asked for in 32 bits, but set in 16.
        max_shots: ShortShots,
    }

    /// Set how long to wait after a picture. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraSetExposureDelay in BE {
        /// How long.
        exposure_delay: ShortMilliseconds,
    }

    /// Set whether the focus is held together with the shutter. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraSetFocusWithShutter in BE {
        /// Whether it is.
        focus_with_shutter: Bool,
    }

    /// Set whether the mirror goes up first, by a first release. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraSetMirrorUp in BE {
        /// Whether it does.
        mirror_up: Bool,
    }

    /// Set the time from one picture to the next; it has to be long enough for focus, exposure and delay.
    ///
    /// Source: hoot, section 2.4; safety decision 3.
    #[derive(Default)]
    pub struct CameraSetInterval in BE {
        /// How long; no more than 16,777,215 arrives.
        interval: Milliseconds,
    }

    /// Is there a camera to be released? Asks for a [`Bool`]. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraEnable in BE {}

    /// Is the camera busy? Asks for a [`Bool`], which is a yes from focus to delay. Source: hoot, sections 2.4 and 4.4.
    #[derive(Default)]
    pub struct CameraExposing in BE {}

    /// How long is the shutter held? Asks for [`Milliseconds`]. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraExposureTime in BE {}

    /// How long is the focus held? Asks for [`ShortMilliseconds`]. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraFocusTime in BE {}

    /// After how many pictures does the program end? Asks for [`Shots`](super::Shots). Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraMaxShots in BE {}

    /// How long is the wait after a picture? Asks for [`ShortMilliseconds`]. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraExposureDelay in BE {}

    /// Is the focus held together with the shutter? Asks for a [`Bool`]. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraFocusWithShutter in BE {}

    /// Does the mirror go up first? Asks for a [`Bool`], which some builds say as an `INT`. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraMirrorUp in BE {}

    /// What is the time from one picture to the next? Asks for [`Milliseconds`]. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraInterval in BE {}
}

bounded! {
    CameraSetExposureTime(exposure_time: Milliseconds);
    CameraSetInterval(interval: Milliseconds);
}
