//! Requests of the application, and their messages.

use std::sync::LazyLock;

use dmc_proto::host::StopTarget;
use dmc_proto::message::{
    Capabilities, FrameNumber, FramesPerSecond, Hi, HostMessage, JogSpeed, Milliseconds, Motor, MotorJog, MotorMove,
    MotorPair, MotorStatusRequest, Motors, Name, RtJogAll, RtPositionFrame, RtRunMove, RtShootFrame2, RtStopLoop,
    RtUploadMoveBegin, RunFlags, Scaled, Steps,
};
use dmc_proto::upload::MoveSource;

/// A shot names its motor, so that it needs no upload.
static SHOT: LazyLock<[MotorPair; 1]> = LazyLock::new(|| [MotorPair::new(Motor(1), Steps(0), Steps(9))]);
const LAST: FrameNumber = FrameNumber(4);

/// Request of the application, made once, at any moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Want {
    /// Send a motor to a position.
    Move(u8),
    /// Run a motor.
    Jog(u8),
    /// Ask which motors move.
    Status,
    /// Upload a move of one motor.
    Upload,
    /// Send all motors to the first frame.
    ToFrame,
    /// Run all motors to the last frame.
    JogAll,
    /// Run the move once, or in a loop.
    Run(RunFlags),
    /// Take a shot.
    Shoot,
    /// End the loop.
    StopLoop,
    /// Stop.
    Stop(StopTarget),
}

impl Want {
    /// Whether the request begins a sequence.
    #[must_use]
    pub const fn is_sequence(self) -> bool {
        matches!(self, Self::Upload | Self::ToFrame | Self::JogAll | Self::Run(_) | Self::Shoot)
    }

    /// Message of the request; `None` for a stop, which is a command.
    #[must_use]
    pub fn message(self) -> Option<HostMessage<'static>> {
        let tail: &[u8] = &[];
        let (first, fps_x1000) = (FrameNumber(1), FramesPerSecond(Scaled(10_000)));
        Some(match self {
            Self::Move(motor) => MotorMove { motor: Motor(motor), position: Steps(5), tail }.into(),
            Self::Jog(motor) => {
                let (motor, destination) = (Motor(motor), Steps(i32::MAX));
                MotorJog { motor, speed: JogSpeed::FULL, destination, tail }.into()
            }
            Self::Status => MotorStatusRequest::default().into(),
            Self::Upload => RtUploadMoveBegin { start_frame: first, end_frame: LAST, tail }.into(),
            Self::ToFrame => RtPositionFrame { frame: first, tail }.into(),
            Self::JogAll => RtJogAll { fps_x1000, destination: LAST, tail }.into(),
            Self::Run(flags) => RtRunMove {
                fps_x1000,
                start_frame: first,
                end_frame: LAST,
                pre_roll_ms: Milliseconds(200),
                post_roll_ms: Milliseconds(100),
                flags: Some(flags),
                ..RtRunMove::default()
            }
            .into(),
            Self::Shoot => RtShootFrame2 {
                frame: first,
                exposure_ms: Milliseconds(500),
                open_angle: 0.into(),
                close_angle: 180.into(),
                motors: &*SHOT,
                tail,
            }
            .into(),
            Self::StopLoop => RtStopLoop::default().into(),
            Self::Stop(_) => return None,
        })
    }
}

/// Uploaded move: one motor, one section.
pub(super) struct Ramp;

impl MoveSource for Ramp {
    fn start_frame(&self) -> FrameNumber {
        FrameNumber(1)
    }

    fn frame_count(&self) -> u32 {
        LAST.0.unsigned_abs()
    }

    fn motors(&self) -> Motors {
        Motors(1)
    }

    fn position(&self, _: Motor, index: u32) -> Steps {
        Steps(index.cast_signed())
    }
}

/// Greeting of the device: two motors, and every capability.
pub(super) fn hi() -> Hi<'static> {
    Hi {
        name: Name::truncated("model"),
        fw_major: 1,
        fw_minor: 0,
        fw_rev: 0,
        motor_count: 2,
        dmx_count: 0,
        gio_out_count: 0,
        gio_in_count: 0,
        hw_limit_count: 1,
        upload_frame_count: 100,
        capabilities: Capabilities(0x07ff),
        protocol_version: Some(2),
        tail: &[],
    }
}
