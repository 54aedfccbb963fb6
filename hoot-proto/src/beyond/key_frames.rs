//! Commands for key frames: sub-address 5. A move is sent axis by axis and key by key, and [`KeyEnd`] ends it.
//!
//! Floats are IEEE numbers in requests. Answers echo them in hundredths, as a `LONG`.

use motion_core::{message, open_enum, unit};

use crate::message::ShortMilliseconds;

open_enum! {
    /// State of the key frames.
    pub struct KeyRunState(u8) {
        /// The key frames do not run.
        STOPPED = 0,
        /// The key frames run.
        RUNNING = 1,
        /// The key frames are paused.
        PAUSED = 2,
    }
}

unit! {
    /// Axis, 0 to 2: the motors, counted from 0.
    pub struct Axis(i16) "";
    /// Key frame, counted from 0.
    pub struct KeyFrame(i16) "";
    /// Time of a program: frames, or milliseconds of a video.
    pub struct KeyTime(f32) "";
    /// Duration of a video, in milliseconds.
    pub struct VideoTime(i32) "ms";
    /// Position of a key frame.
    pub struct KeyPosition(f32) "steps";
    /// Velocity in steps per frame, or per millisecond.
    pub struct KeyVelocity(f32) "";
}

message! {
    /// Chooses the axis for the commands that follow. The answer echoes it, as an `INT`.
    #[derive(Default)]
    pub struct KeySetAxis in BE {
        /// Axis.
        axis: Axis,
    }

    /// Sets the number of keys of the axis, and forgets its old keys. The answer echoes it, as an `INT`.
    #[derive(Default)]
    pub struct KeySetCount in BE {
        /// Number of keys.
        count: i16,
    }

    /// Sets the time of the next key. Never repeat it by yourself, because the repetition would be for another key.
    #[derive(Default)]
    pub struct KeySetTime in BE {
        /// Time.
        time: KeyTime,
    }

    /// Sets the position of the next key. Never repeat it by yourself, because the repetition would be for another key.
    #[derive(Default)]
    pub struct KeySetPosition in BE {
        /// Position.
        position: KeyPosition,
    }

    /// Sets the velocity at the next key. Never repeat it by yourself, because the repetition would be for another key.
    #[derive(Default)]
    pub struct KeySetVelocity in BE {
        /// Velocity.
        velocity: KeyVelocity,
    }

    /// Sets how often the speed of the motors is set anew. The answer echoes it, as a `UINT`.
    #[derive(Default)]
    pub struct KeySetUpdateRate in BE {
        /// Time between two settings.
        update_rate: ShortMilliseconds,
    }

    /// Ends the keys of the axis.
    #[derive(Default)]
    pub struct KeyEnd in BE {}

    /// Sets the duration of a video. The answer echoes it, as a `LONG`.
    #[derive(Default)]
    pub struct KeySetVideoTime in BE {
        /// Duration.
        video_time: VideoTime,
    }

    /// Starts or resumes the key frames. Never repeat it by yourself.
    #[derive(Default)]
    pub struct KeyStart in BE {}

    /// Pauses the key frames.
    #[derive(Default)]
    pub struct KeyPause in BE {}

    /// Stops the key frames.
    #[derive(Default)]
    pub struct KeyStop in BE {}

    /// Takes up the backlash of all motors. Never repeat it by yourself. Some firmware does not answer it.
    #[derive(Default)]
    pub struct KeyTakeUpBacklash in BE {}

    /// Prints all keys on the USB port.
    #[derive(Default)]
    pub struct KeyPrint in BE {}

    /// Asks for the number of keys of the axis. The answer is an `INT`.
    #[derive(Default)]
    pub struct KeyCount in BE {}

    /// Asks how often the speed of the motors is set anew, in milliseconds. The answer is an `INT`.
    #[derive(Default)]
    pub struct KeyUpdateRate in BE {}

    /// Asks for the position of the axis at a time. The answer is in hundredths, a `LONG`.
    #[derive(Default)]
    pub struct KeyPositionAt in BE {
        /// Time.
        time: KeyTime,
    }

    /// Asks for the speed of the axis at a time. The answer is in hundredths, a `LONG`.
    #[derive(Default)]
    pub struct KeyVelocityAt in BE {
        /// Time.
        time: KeyTime,
    }

    /// Asks for the acceleration of the axis at a time. The answer is in hundredths, a `LONG`.
    #[derive(Default)]
    pub struct KeyAccelerationAt in BE {
        /// Time.
        time: KeyTime,
    }

    /// Asks whether the motor can move as fast as the keys demand. The answer is a `BYTE`.
    #[derive(Default)]
    pub struct KeyVelocityIsValid in BE {}

    /// Asks whether the motor can accelerate as the keys demand. The answer is a `BYTE`.
    #[derive(Default)]
    pub struct KeyAccelerationIsValid in BE {}

    /// Asks for the duration of a video, in milliseconds.
    #[derive(Default)]
    pub struct KeyVideoTime in BE {}

    /// Asks whether the key frames run. The answer is a [`KeyRunState`].
    #[derive(Default)]
    pub struct KeyRunStateQuery in BE {}

    /// Asks how long the key frames have run, in milliseconds.
    #[derive(Default)]
    pub struct KeyRunTime in BE {}

    /// Asks for the greatest run time of the key frames, in milliseconds.
    #[derive(Default)]
    pub struct KeyMaxTime in BE {}

    /// Asks for the part of the key frames that is done, in percent.
    #[derive(Default)]
    pub struct KeyPercentDone in BE {}

    /// Asks for the time of a key. The answer is a `LONG`.
    #[derive(Default)]
    pub struct KeyTimeOf in BE {
        /// Key.
        key_frame: KeyFrame,
    }

    /// Asks for the position of the axis at a key. The answer is a `LONG`.
    #[derive(Default)]
    pub struct KeyPositionOf in BE {
        /// Key.
        key_frame: KeyFrame,
    }

    /// Asks for the speed of the axis at a key. The answer is in hundredths, a `LONG`.
    #[derive(Default)]
    pub struct KeyVelocityOf in BE {
        /// Key.
        key_frame: KeyFrame,
    }
}
