//! The controller, its motors, its camera, and broadcasts.

use motion_core::wire::Bool;
use motion_core::{flags, message, open_enum};

use crate::message::sub::{AnySubAddress, sub_messages};
use crate::message::{Motor, Span, Steps};

open_enum! {
    /// Frames a second of a video.
    pub struct FrameRate(u8) {
        /// 30.
        THIRTY = 0,
        /// 24.
        TWENTY_FOUR = 1,
        /// 25.
        TWENTY_FIVE = 2,
    }
}

flags! {
    /// What a node says of itself to [`StatusQuery`].
    pub struct Status(u8) {
        /// The planned move runs.
        RUNNING = 1,
        /// It is paused.
        PAUSED = 2,
        /// It is one of key frames.
        KEY_FRAMES = 4,
        /// It waits for the delay before the start.
        DELAY = 8,
        /// The camera is kept awake.
        KEEP_ALIVE = 16,
        /// It goes to and fro.
        PING_PONG = 32,
    }
}

message! {
    /// Send all motors to where their planned moves begin. Not to be sent again by itself.
    #[derive(Default)]
    pub struct SendAllToStart in BE {}

    /// All planned moves begin where the motors are.
    #[derive(Default)]
    pub struct SetStartHere in BE {}

    /// All planned moves end where the motors are.
    #[derive(Default)]
    pub struct SetStopHere in BE {}

    /// Set the frames a second.
    #[derive(Default)]
    pub struct SetFrameRate in BE {
        /// How many.
        frame_rate: FrameRate,
    }

    /// Swap beginning and end of all planned moves. Not to be sent again by itself.
    #[derive(Default)]
    pub struct SwapStartAndStop in BE {}

    /// Set whether the program Graffik is in control.
    #[derive(Default)]
    pub struct SetGraffikMode in BE {
        /// Whether it is.
        graffik_mode: Bool,
    }

    /// Set whether an app is in control. Some firmware does not answer it.
    #[derive(Default)]
    pub struct SetAppMode in BE {
        /// Whether one is.
        app_mode: Bool,
    }

    /// Asks for what [`SetManualMove`](crate::message::SetManualMove) sets, a `BYTE`; no answer in joystick mode.
    #[derive(Default)]
    pub struct ManualMove in BE {}

    /// How much of the planned move is done, in percent? Asks for a `BYTE`.
    #[derive(Default)]
    pub struct PercentDone in BE {}

    /// Which motors are there? Asks for a `BYTE`, of which the lowest bit is motor 1.
    #[derive(Default)]
    pub struct MotorsAttached in BE {}

    /// How long does the planned move take, in milliseconds? Asks for an `ULONG`.
    #[derive(Default)]
    pub struct TotalTime in BE {}

    /// Is the planned move over? Asks for a `BYTE`.
    #[derive(Default)]
    pub struct IsComplete in BE {}

    /// How many frames a second? Asks for a `BYTE`, a [`FrameRate`].
    #[derive(Default)]
    pub struct FrameRateQuery in BE {}

    /// Does any motor move? Asks for a `BYTE`.
    #[derive(Default)]
    pub struct AnyRunning in BE {}

    /// Can all motors move as fast as is planned? Asks for a `BYTE`.
    #[derive(Default)]
    pub struct IsValid in BE {}

    /// Which motors have no current while they rest? Asks for a `BYTE`, of which the lowest bit is motor 1.
    #[derive(Default)]
    pub struct MotorsAsleep in BE {}

    /// How many controllers are there?
    #[derive(Default)]
    pub struct ControllerCount in BE {}

    /// What is your status? Asks for a `BYTE`, a [`Status`].
    #[derive(Default)]
    pub struct StatusQuery in BE {}

    /// Is the program Graffik in control? Asks for a `BYTE`.
    #[derive(Default)]
    pub struct GraffikMode in BE {}

    /// How many bytes of memory are free? Asks for an `INT`.
    #[derive(Default)]
    pub struct FreeMemory in BE {}

    /// Set what is told on the USB port for debugging; answered by a `BYTE`.
    #[derive(Default)]
    pub struct SetDebugOutput in BE {
        /// What.
        debug_output: u8,
    }

    /// Test yourself. The answer comes before the test, which moves motors.
    #[derive(Default)]
    pub struct TestYourself in BE {}

    /// Set whether the camera is in test mode.
    #[derive(Default)]
    pub struct CameraSetTestMode in BE {
        /// Whether it is.
        test_mode: Bool,
    }

    /// Set whether the camera is kept awake.
    #[derive(Default)]
    pub struct CameraSetKeepAlive in BE {
        /// Whether it is.
        keep_alive: Bool,
    }

    /// Set whether an external intervalometer says when pictures are taken.
    #[derive(Default)]
    pub struct CameraSetIntervalometer in BE {
        /// Whether it does.
        intervalometer: Bool,
    }

    /// How many pictures have been taken?
    #[derive(Default)]
    pub struct CameraShots in BE {}

    /// Is the camera in test mode? Asks for a `BYTE`.
    #[derive(Default)]
    pub struct CameraTestMode in BE {}

    /// Is the camera kept awake? Asks for a `BYTE`.
    #[derive(Default)]
    pub struct CameraKeepAlive in BE {}

    /// Does an external intervalometer say when pictures are taken? Asks for a `BYTE`.
    ///
    /// A known client asks for it by 113, by mistake.
    #[derive(Default)]
    pub struct CameraIntervalometer in BE {}
}

sub_messages! {
    /// Set how long the motor rests at the end of its planned move. To be set after the lead-in, which clears it.
    ///
    /// Without data, the same number was a step of the planned move:
    /// [`MotorStepForward`](crate::message::MotorStepForward).
    pub struct MotorSetLeadOut for /** Which motor. */ motor: Motor {
        /// How long; no more than 16,777,215 arrives.
        lead_out: Span,
    }

    /// Find the finest microsteps that the planned move allows. Answered by a `BYTE`: what was set, or 0.
    pub struct MotorFindMicrostep for /** Which motor. */ motor: Motor {}

    /// The planned move begins here.
    pub struct MotorSetStartHere for /** Which motor. */ motor: Motor {}

    /// The planned move ends here.
    pub struct MotorSetStopHere for /** Which motor. */ motor: Motor {}

    /// Go to a position. Not to be sent again by itself.
    pub struct MotorSendTo for /** Which motor. */ motor: Motor {
        /// Where to.
        position: Steps,
    }

    /// Set where the end limit is.
    pub struct MotorSetEnd for /** Which motor. */ motor: Motor {
        /// Where.
        position: Steps,
    }

    /// Set whether all motors do stop motion. Some firmware does not answer it.
    pub struct MotorSetStopMotion for /** Of no meaning. */ motor: Motor {
        /// Whether they do.
        stop_motion: Bool,
    }

    /// Go on by one step of the planned move. Not to be sent again by itself.
    pub struct MotorStepForward for /** Which motor. */ motor: Motor {}

    /// Go back by one step of the planned move. Not to be sent again by itself.
    pub struct MotorStepBack for /** Which motor. */ motor: Motor {}

    /// Can the motor move as fast as is planned? Asks for a `BYTE`.
    pub struct MotorIsValid for /** Which motor. */ motor: Motor {}

    /// How long does the motor rest at the end of its planned move? Asks for an `ULONG`.
    pub struct MotorLeadOut for /** Which motor. */ motor: Motor {}

    /// The program Graffik is in control, over USB. Nodes answer it, and v0.70 also starts the key frames: do not send it
    /// there.
    pub struct BroadcastGraffikUsb for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// The program Graffik is in control, over Bluetooth.
    pub struct BroadcastGraffikBluetooth for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// All nodes: start or resume the key frames.
    pub struct BroadcastKeyStart for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// All nodes: stop the key frames.
    pub struct BroadcastKeyStop for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// All nodes: pause the key frames.
    pub struct BroadcastKeyPause for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// What is your address? All nodes answer, at once, with a `BYTE`: only one may be on the bus.
    pub struct BroadcastGetAddress for /** Of no meaning. */ sub_address: AnySubAddress {}
}
