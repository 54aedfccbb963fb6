//! Commands to the controller, the motors and the camera, and broadcasts.

use motion_core::wire::Bool;
use motion_core::{flags, message, open_enum};

use crate::message::sub::{AnySubAddress, sub_messages};
use crate::message::{Motor, Span, Steps};

open_enum! {
    /// Number of frames per second of a video.
    pub struct FrameRate(u8) {
        /// 30 frames per second.
        THIRTY = 0,
        /// 24 frames per second.
        TWENTY_FOUR = 1,
        /// 25 frames per second.
        TWENTY_FIVE = 2,
    }
}

flags! {
    /// Status of a node, the answer to [`StatusQuery`].
    pub struct Status(u8) {
        /// The planned move runs.
        RUNNING = 1,
        /// The planned move is paused.
        PAUSED = 2,
        /// The planned move has key frames.
        KEY_FRAMES = 4,
        /// The planned move waits for the delay before its start.
        DELAY = 8,
        /// The camera is kept awake.
        KEEP_ALIVE = 16,
        /// The planned move goes to and fro.
        PING_PONG = 32,
    }
}

message! {
    /// Sends all motors to the starts of their planned moves. Never repeat it by yourself.
    #[derive(Default)]
    pub struct SendAllToStart in BE {}

    /// Makes the present positions the starts of all planned moves.
    #[derive(Default)]
    pub struct SetStartHere in BE {}

    /// Makes the present positions the ends of all planned moves.
    #[derive(Default)]
    pub struct SetStopHere in BE {}

    /// Sets the number of frames per second.
    #[derive(Default)]
    pub struct SetFrameRate in BE {
        /// Number of frames per second.
        frame_rate: FrameRate,
    }

    /// Swaps beginning and end of all planned moves. Never repeat it by yourself.
    #[derive(Default)]
    pub struct SwapStartAndStop in BE {}

    /// Sets whether the program Graffik is in control.
    #[derive(Default)]
    pub struct SetGraffikMode in BE {
        /// Whether Graffik is in control.
        graffik_mode: Bool,
    }

    /// Sets whether an app is in control. Some firmware does not answer it.
    #[derive(Default)]
    pub struct SetAppMode in BE {
        /// Whether an app is in control.
        app_mode: Bool,
    }

    /// Asks for the setting of [`SetManualMove`](crate::message::SetManualMove). The answer is a `BYTE`, in
    /// v0.70 an `INT`; in joystick mode there is none.
    #[derive(Default)]
    pub struct ManualMove in BE {}

    /// Asks for the part of the planned move that is done, in percent. The answer is a `BYTE`.
    #[derive(Default)]
    pub struct PercentDone in BE {}

    /// Asks which motors are there. The answer is a `BYTE`, of which the lowest bit is motor 1.
    #[derive(Default)]
    pub struct MotorsAttached in BE {}

    /// Asks for the duration of the planned move, in milliseconds. The answer is a `ULONG`.
    #[derive(Default)]
    pub struct TotalTime in BE {}

    /// Asks whether the planned move is over. The answer is a `BYTE`.
    #[derive(Default)]
    pub struct IsComplete in BE {}

    /// Asks for the number of frames per second. The answer is a `BYTE`, a [`FrameRate`].
    #[derive(Default)]
    pub struct FrameRateQuery in BE {}

    /// Asks whether any motor moves. The answer is a `BYTE`.
    #[derive(Default)]
    pub struct AnyRunning in BE {}

    /// Asks whether all motors can move as fast as planned. The answer is a `BYTE`.
    #[derive(Default)]
    pub struct IsValid in BE {}

    /// Asks which motors have no current while they rest. The answer is a `BYTE`, of which the lowest bit is motor 1.
    #[derive(Default)]
    pub struct MotorsAsleep in BE {}

    /// Asks for the number of controllers.
    #[derive(Default)]
    pub struct ControllerCount in BE {}

    /// Asks for the status of the node. The answer is a `BYTE`, a [`Status`].
    #[derive(Default)]
    pub struct StatusQuery in BE {}

    /// Asks whether the program Graffik is in control. The answer is a `BYTE`, in v0.70 an `INT`.
    #[derive(Default)]
    pub struct GraffikMode in BE {}

    /// Asks for the number of bytes of memory that are free. The answer is an `INT`.
    #[derive(Default)]
    pub struct FreeMemory in BE {}

    /// Sets what is printed on the USB port for debugging. The answer is a `BYTE`.
    #[derive(Default)]
    pub struct SetDebugOutput in BE {
        /// Setting.
        debug_output: u8,
    }

    /// Lets the node test itself. The answer comes before the test, which moves motors.
    #[derive(Default)]
    pub struct TestYourself in BE {}

    /// Sets whether the camera is in test mode.
    #[derive(Default)]
    pub struct CameraSetTestMode in BE {
        /// Whether the camera is in test mode.
        test_mode: Bool,
    }

    /// Sets whether the camera is kept awake.
    #[derive(Default)]
    pub struct CameraSetKeepAlive in BE {
        /// Whether the camera is kept awake.
        keep_alive: Bool,
    }

    /// Sets whether an external intervalometer decides when pictures are taken.
    #[derive(Default)]
    pub struct CameraSetIntervalometer in BE {
        /// Whether the intervalometer decides.
        intervalometer: Bool,
    }

    /// Asks for the number of pictures that were taken.
    #[derive(Default)]
    pub struct CameraShots in BE {}

    /// Asks whether the camera is in test mode. The answer is a `BYTE`.
    #[derive(Default)]
    pub struct CameraTestMode in BE {}

    /// Asks whether the camera is kept awake. The answer is a `BYTE`.
    #[derive(Default)]
    pub struct CameraKeepAlive in BE {}

    /// Asks whether an external intervalometer decides when pictures are taken. The answer is a `BYTE`.
    ///
    /// A known client sends 113 for it by mistake.
    #[derive(Default)]
    pub struct CameraIntervalometer in BE {}
}

sub_messages! {
    /// Sets the lead-out: how long the motor rests at the end of its planned move. Set it after the lead-in, which
    /// clears it.
    ///
    /// Without data, the same number meant a step of the planned move:
    /// [`MotorStepForward`](crate::message::MotorStepForward).
    pub struct MotorSetLeadOut for /** The motor. */ motor: Motor {
        /// Time; at most 16,777,215 arrives.
        lead_out: Span,
    }

    /// Finds the finest microsteps that the planned move allows. The answer is a `BYTE`: the setting, or 0.
    pub struct MotorFindMicrostep for /** The motor. */ motor: Motor {}

    /// Makes the present position the start of the planned move.
    pub struct MotorSetStartHere for /** The motor. */ motor: Motor {}

    /// Makes the present position the end of the planned move.
    pub struct MotorSetStopHere for /** The motor. */ motor: Motor {}

    /// Sends the motor to a position. Never repeat it by yourself.
    pub struct MotorSendTo for /** The motor. */ motor: Motor {
        /// Position.
        position: Steps,
    }

    /// Gives the present position of the motor another number. Nothing moves, and stored positions keep their numbers.
    pub struct MotorSetPosition for /** The motor. */ motor: Motor {
        /// Number of the present position.
        position: Steps,
    }

    /// Sets the position of the end limit.
    pub struct MotorSetEnd for /** The motor. */ motor: Motor {
        /// Position.
        position: Steps,
    }

    /// Sets whether all motors do stop motion. Some firmware does not answer it.
    pub struct MotorSetStopMotion for /** Of no meaning. */ motor: Motor {
        /// Whether all motors do stop motion.
        stop_motion: Bool,
    }

    /// Moves the motor on by one step of the planned move. Never repeat it by yourself.
    pub struct MotorStepForward for /** The motor. */ motor: Motor {}

    /// Moves the motor back by one step of the planned move. Never repeat it by yourself.
    pub struct MotorStepBack for /** The motor. */ motor: Motor {}

    /// Asks whether the motor can move as fast as planned. The answer is a `BYTE`.
    pub struct MotorIsValid for /** The motor. */ motor: Motor {}

    /// Asks how long the motor rests at the end of its planned move. The answer is a `ULONG`.
    pub struct MotorLeadOut for /** The motor. */ motor: Motor {}

    /// Tells that the program Graffik is in control, over USB. Nodes answer it, and v0.70 also starts the key frames,
    /// so do not send it to v0.70.
    pub struct BroadcastGraffikUsb for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Tells that the program Graffik is in control, over Bluetooth.
    pub struct BroadcastGraffikBluetooth for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Starts or resumes the key frames of all nodes.
    pub struct BroadcastKeyStart for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Stops the key frames of all nodes.
    pub struct BroadcastKeyStop for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Pauses the key frames of all nodes.
    pub struct BroadcastKeyPause for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Asks for the address of a node. All nodes answer at once, with a `BYTE`, so only one may be on the bus.
    pub struct BroadcastGetAddress for /** Of no meaning. */ sub_address: AnySubAddress {}
}
