//! Messages for the camera, which is sub-address 4. A camera can be released in joystick mode too.

use motion_core::message;
use motion_core::wire::Bool;

use super::bounded::bounded;
use super::units::{Milliseconds, ShortMilliseconds, ShortShots};

message! {
    /// Sets whether a camera is there to be released. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraSetEnable in BE {
        /// Whether there is a camera.
        enable: Bool,
    }

    /// Takes a picture, exposed for the time of [`CameraSetExposureTime`].
    ///
    /// Never repeat it by yourself. Source: hoot, section 2.4; safety decisions 1 and 9.
    #[derive(Default)]
    pub struct CameraExpose in BE {}

    /// Sets how long the shutter is held. Source: hoot, section 2.4; safety decision 3.
    #[derive(Default)]
    pub struct CameraSetExposureTime in BE {
        /// Time; at most 16,777,215 ms arrive.
        exposure_time: Milliseconds,
    }

    /// Sets how long the focus is held before a picture. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraSetFocusTime in BE {
        /// Time.
        focus_time: ShortMilliseconds,
    }

    /// Sets after how many pictures the program ends. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraSetMaxShots in BE {
        /// Number of pictures; 0 for no end. It is set in 16 bits, but answered in 32.
        max_shots: ShortShots,
    }

    /// Sets how long to wait after a picture. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraSetExposureDelay in BE {
        /// Time.
        exposure_delay: ShortMilliseconds,
    }

    /// Sets whether the focus is held together with the shutter. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraSetFocusWithShutter in BE {
        /// Whether the focus is held together with the shutter.
        focus_with_shutter: Bool,
    }

    /// Sets whether the mirror goes up first, by a first release. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraSetMirrorUp in BE {
        /// Whether the mirror goes up first.
        mirror_up: Bool,
    }

    /// Sets the time from one picture to the next. It must be long enough for focus, exposure and delay.
    ///
    /// Source: hoot, section 2.4; safety decision 3.
    #[derive(Default)]
    pub struct CameraSetInterval in BE {
        /// Time; at most 16,777,215 ms arrive.
        interval: Milliseconds,
    }

    /// Asks whether a camera is there to be released. The answer is a [`Bool`]. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraEnable in BE {}

    /// Asks whether the camera is busy, from focus to delay. The answer is a [`Bool`]. Source: hoot, sections 2.4 and
    /// 4.4.
    #[derive(Default)]
    pub struct CameraExposing in BE {}

    /// Asks how long the shutter is held. The answer is in [`Milliseconds`]. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraExposureTime in BE {}

    /// Asks how long the focus is held. The answer is in [`ShortMilliseconds`]. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraFocusTime in BE {}

    /// Asks after how many pictures the program ends. The answer is in [`Shots`](super::Shots). Source: hoot, section
    /// 2.4.
    #[derive(Default)]
    pub struct CameraMaxShots in BE {}

    /// Asks how long to wait after a picture. The answer is in [`ShortMilliseconds`]. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraExposureDelay in BE {}

    /// Asks whether the focus is held together with the shutter. The answer is a [`Bool`]. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraFocusWithShutter in BE {}

    /// Asks whether the mirror goes up first. The answer is a [`Bool`], which some builds send as an `INT`. Source:
    /// hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraMirrorUp in BE {}

    /// Asks for the time from one picture to the next. The answer is in [`Milliseconds`]. Source: hoot, section 2.4.
    #[derive(Default)]
    pub struct CameraInterval in BE {}
}

bounded! {
    CameraSetExposureTime(exposure_time: Milliseconds);
    CameraSetInterval(interval: Milliseconds);
}
