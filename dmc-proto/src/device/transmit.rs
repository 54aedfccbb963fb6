//! Messages that a device sends, and all that follows from an input.

use motion_core::machine;
use motion_core::wire::{Bool, EncodeError};
use zerocopy::little_endian::I32;

use super::event::Event;
use crate::frame::{MessageId, MessageType};
use crate::message::{
    Ack, AckCode, Coordinate, DeviceMessage, GioIn, HardStop, Hi, HostMessage, Motor, MotorMoving, MotorPositions,
    MotorStatus, Motors, MoveTime, RtEnd, RtGo, Steps, StopReason, Triggers, VirtAimPoint, VirtPositions,
    VirtualPosition,
};

/// Message to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Transmit {
    /// Id of the request that it answers, or [`MessageId::UNSOLICITED`].
    pub id: MessageId,
    /// Contents of the message.
    pub contents: Contents,
}

/// Contents of a message that a device sends. What only the rig knows is asked when the message is
/// [made](Transmit::message).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Contents {
    /// Greeting: who the device is.
    Greeting(Hi<'static>),
    /// Acknowledgement of a request.
    Ack {
        /// Type of the request.
        of: MessageType,
        /// How the request ended.
        code: AckCode,
        /// Whether the code is sent in four bytes (decision D-6).
        wide: bool,
    },
    /// Inputs that are on.
    Inputs(Triggers),
    /// Motors that move.
    Status(Motors),
    /// News that the motor moves.
    Moving,
    /// Time in the move, and positions of this many motors.
    Positions(MoveTime, u8),
    /// News that everything stopped, with the reason, and the motor if one is the cause.
    HardStop(StopReason, Option<Motor>),
    /// News that the operator started.
    Go,
    /// News that the run or shot is done.
    End,
    /// Positions of the virtual motors.
    VirtualPositions,
    /// Point at which the camera is aimed.
    Aim,
}

/// Room for the positions of a message: one for each motor that a device can have.
pub type Scratch = [I32; 32];

/// Knowledge of the rig that a session needs: judgements of messages, and what messages tell.
pub trait Rig {
    /// Answer of the rig to a message if it were done now, as [`Input::Received`](super::Input::Received) says. A
    /// [`Session`](super::Session) asks for it. A rig without limits answers [`AckCode::OK`].
    fn verdict(&self, message: &HostMessage<'_>) -> AckCode;

    /// Position of a motor.
    fn position(&self, motor: Motor) -> Steps;

    /// Time in the move that a message with positions tells, if the rig knows better than the machine. The machine tells the
    /// frame on which the motors are.
    fn move_time(&self) -> Option<MoveTime> {
        None
    }

    /// Whether DMX channels change. The default is no.
    fn dmx_moves(&self) -> bool {
        false
    }

    /// Positions of the virtual motors. Only rigs that say they have some are asked.
    fn virtual_positions(&self) -> VirtPositions<'_> {
        let zero = VirtualPosition::default();
        let (track, ew, ns, pan, tilt, roll) = (zero, zero, zero, zero, zero, zero);
        VirtPositions { track, ew, ns, pan, tilt, roll, aim_enabled: None, aim: None, tail: &[] }
    }

    /// Point at which the camera is aimed. Only rigs that say they can aim are asked.
    fn aim(&self) -> VirtAimPoint<'_> {
        let zero = Coordinate::default();
        VirtAimPoint { enable: Bool(0), aim_x: zero, aim_y: zero, aim_z: zero, tail: &[] }
    }
}

impl Transmit {
    /// Writes the message to the front of `out`, with what the rig knows, and returns its length.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn encode_into<R: Rig + ?Sized>(&self, rig: &R, out: &mut [u8]) -> Result<usize, EncodeError> {
        self.message(rig, &mut Scratch::default()).encode_into(self.id, out)
    }

    /// Makes the message, with what the rig knows. Positions are put into `scratch`.
    #[must_use]
    pub fn message<'s, R: Rig + ?Sized>(&self, rig: &'s R, scratch: &'s mut Scratch) -> DeviceMessage<'s> {
        match self.contents {
            Contents::Greeting(hi) => hi.into(),
            Contents::Ack { of, code, wide } => {
                let tail: &[u8] = if wide { &[0; 2] } else { &[] };
                Ack { tail, ..Ack::new(of, code) }.into()
            }
            Contents::Inputs(triggers) => GioIn { triggers, tail: &[] }.into(),
            Contents::Status(motor_status) => {
                MotorStatus { motor_status, dmx_status: Bool(rig.dmx_moves().into()), tail: &[] }.into()
            }
            Contents::Moving => MotorMoving { moving: Bool(1), tail: &[] }.into(),
            Contents::Positions(move_time, count) => {
                let motors = (1..=count).map(Motor);
                for (place, motor) in scratch.iter_mut().zip(motors) {
                    *place = I32::new(rig.position(motor).0);
                }
                let positions = scratch.get(..count.into()).unwrap_or_default();
                let move_time = rig.move_time().unwrap_or(move_time);
                MotorPositions { move_time, positions, tail: &[] }.into()
            }
            Contents::HardStop(reason, motor) => HardStop { reason, motor, tail: &[] }.into(),
            Contents::Go => RtGo::default().into(),
            Contents::End => RtEnd::default().into(),
            Contents::VirtualPositions => rig.virtual_positions().into(),
            Contents::Aim => rig.aim().into(),
        }
    }
}

/// Greatest number of effects of one call:
///
/// - 2 things for the rig to do: a stop, or what takes the place of a run, and its outputs off;
/// - 2 messages that tell of it: positions and the end of a run, or an acknowledgement and positions;
/// - 1 report of positions that was due;
/// - 1 end of a lock.
pub const EFFECTS: usize = 6;

/// One thing that follows from an input.
pub type Effect<'a> = machine::Effect<Transmit, Event<'a>>;

/// All that follows from an input. What the rig has to do stands before the messages that tell of it, a stop first.
pub type Output<'a> = machine::Output<Transmit, Event<'a>, EFFECTS>;
