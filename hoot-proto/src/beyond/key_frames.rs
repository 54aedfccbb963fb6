//! Key frames: sub-address 5. A move is sent key by key, axis by axis, and ended by [`KeyEnd`].
//!
//! Floats are IEEE numbers in requests; the answers echo them in hundredths, as `LONG`.

use motion_core::{message, open_enum, unit};

use crate::message::ShortMilliseconds;

open_enum! {
    /// Whether the key frames run.
    pub struct KeyRunState(u8) {
        /// They do not.
        STOPPED = 0,
        /// They do.
        RUNNING = 1,
        /// They are paused.
        PAUSED = 2,
    }
}

unit! {
    /// One of the axes, 0 to 2: the motors, counted from 0.
    pub struct Axis(i16) "";
    /// One of the key frames, counted from 0.
    pub struct KeyFrame(i16) "";
    /// A time of a program: frames, or milliseconds of a video.
    pub struct KeyTime(f32) "";
    /// How long a video takes.
    pub struct VideoTime(i32) "ms";
    /// A position of a key frame.
    pub struct KeyPosition(f32) "steps";
    /// Steps a frame, or a millisecond.
    pub struct KeyVelocity(f32) "";
}

message! {
    /// Choose the axis that the commands behind this one are about. The answer echoes it, as an `INT`.
    #[derive(Default)]
    pub struct KeySetAxis in BE {
        /// Which.
        axis: Axis,
    }

    /// Set how many keys the axis has, and forget those it had. The answer echoes it, as an `INT`.
    #[derive(Default)]
    pub struct KeySetCount in BE {
        /// How many.
        count: i16,
    }

    /// Set the time of the next key. Not to be sent again by itself: it would be that of another key.
    #[derive(Default)]
    pub struct KeySetTime in BE {
        /// When.
        time: KeyTime,
    }

    /// Set the position of the next key. Not to be sent again by itself: it would be that of another key.
    #[derive(Default)]
    pub struct KeySetPosition in BE {
        /// Where.
        position: KeyPosition,
    }

    /// Set the velocity at the next key. Not to be sent again by itself: it would be that of another key.
    #[derive(Default)]
    pub struct KeySetVelocity in BE {
        /// How fast.
        velocity: KeyVelocity,
    }

    /// Set how often the speed of the motors is set anew. The answer echoes it, as an `UINT`.
    #[derive(Default)]
    pub struct KeySetUpdateRate in BE {
        /// How often.
        update_rate: ShortMilliseconds,
    }

    /// The axis has all its keys.
    #[derive(Default)]
    pub struct KeyEnd in BE {}

    /// Set how long a video takes. The answer echoes it, as a `LONG`.
    #[derive(Default)]
    pub struct KeySetVideoTime in BE {
        /// How long.
        video_time: VideoTime,
    }

    /// Start or resume the key frames. Not to be sent again by itself.
    #[derive(Default)]
    pub struct KeyStart in BE {}

    /// Pause the key frames.
    #[derive(Default)]
    pub struct KeyPause in BE {}

    /// Stop the key frames.
    #[derive(Default)]
    pub struct KeyStop in BE {}

    /// Take up the backlash of all motors. Not to be sent again by itself. Some firmware does not answer it.
    #[derive(Default)]
    pub struct KeyTakeUpBacklash in BE {}

    /// Print all keys on the USB port.
    #[derive(Default)]
    pub struct KeyPrint in BE {}

    /// How many keys has the axis? Asks for an `INT`.
    #[derive(Default)]
    pub struct KeyCount in BE {}

    /// How often is the speed of the motors set anew, in milliseconds? Asks for an `INT`.
    #[derive(Default)]
    pub struct KeyUpdateRate in BE {}

    /// Where is the axis at a time? Asks for hundredths, a `LONG`.
    #[derive(Default)]
    pub struct KeyPositionAt in BE {
        /// When.
        time: KeyTime,
    }

    /// How fast is the axis at a time? Asks for hundredths, a `LONG`.
    #[derive(Default)]
    pub struct KeyVelocityAt in BE {
        /// When.
        time: KeyTime,
    }

    /// How does the axis gain speed at a time? Asks for hundredths, a `LONG`.
    #[derive(Default)]
    pub struct KeyAccelerationAt in BE {
        /// When.
        time: KeyTime,
    }

    /// Can the motor move as fast as the keys want it? Asks for a `BYTE`.
    #[derive(Default)]
    pub struct KeyVelocityIsValid in BE {}

    /// Can the motor gain speed as the keys want it? Asks for a `BYTE`.
    #[derive(Default)]
    pub struct KeyAccelerationIsValid in BE {}

    /// How long does a video take, in milliseconds?
    #[derive(Default)]
    pub struct KeyVideoTime in BE {}

    /// Do the key frames run? Asks for a [`KeyRunState`].
    #[derive(Default)]
    pub struct KeyRunStateQuery in BE {}

    /// How long have the key frames run, in milliseconds?
    #[derive(Default)]
    pub struct KeyRunTime in BE {}

    /// How long do the key frames run at most, in milliseconds?
    #[derive(Default)]
    pub struct KeyMaxTime in BE {}

    /// How much of the key frames is done, in percent?
    #[derive(Default)]
    pub struct KeyPercentDone in BE {}

    /// When is a key? Asks for a `LONG`.
    #[derive(Default)]
    pub struct KeyTimeOf in BE {
        /// Which key.
        key_frame: KeyFrame,
    }

    /// Where is the axis at a key? Asks for a `LONG`.
    #[derive(Default)]
    pub struct KeyPositionOf in BE {
        /// Which key.
        key_frame: KeyFrame,
    }

    /// How fast is the axis at a key? Asks for hundredths, a `LONG`.
    #[derive(Default)]
    pub struct KeyVelocityOf in BE {
        /// Which key.
        key_frame: KeyFrame,
    }
}
