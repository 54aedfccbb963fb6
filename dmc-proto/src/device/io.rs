//! What goes into a device's machine, and what comes out.

use motion_core::machine;
use motion_core::wire::Bool;
use zerocopy::little_endian::I32;

use super::upload::Store;
use crate::frame::{Frame, MessageId, MessageType};
use crate::message::{
    Ack, AckCode, Coordinate, DeviceMessage, Empty, FrameNumber, FramesPerSecond, GioIn, HardStop, Hi, HostMessage,
    JogSpeed, Motor, MotorMoving, MotorPositions, MotorStatus, Motors, MoveTime, Steps, StopReason, Triggers,
    VirtAimPoint, VirtPositions, VirtualMotor, VirtualPosition,
};

/// What happened to a device.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Input<'a> {
    /// The line to the host is open, at boot: the device greets.
    LinkUp,
    /// The line is gone. No stop could come any more, so everything stops (decision D-53).
    LinkDown,
    /// A message arrived.
    Received {
        /// Its id.
        id: MessageId,
        /// The message.
        message: HostMessage<'a>,
        /// What the rig itself has to say to it, were it done now: `OK`, or `ERR_SOFT_UP` and `ERR_SOFT_LOW` of a target
        /// or path beyond a limit that was set, `ERR_PREROLL` and `ERR_POSTROLL`, `ERR_RANGE` of what is out of reach.
        /// The machine knows neither positions nor limits. It does not ask where it refuses anyway, nor ever for a stop.
        rig: AckCode,
    },
    /// A sound frame arrived whose data end before the fields of its message do.
    Malformed(MessageId, MessageType),
    /// A frame with a wrong checksum arrived; these stand in its header.
    Corrupt(MessageId, MessageType),
    /// What was told to be [stored](Event::Store) was, or not, for this reason.
    Stored(Store, AckCode),
    /// These motors move now: for the status. Nothing else follows from it.
    Moving(Motors),
    /// All motors stand: what was asked for last is reached, or the stop is complete. Each [`Event`] that moves or stops
    /// motors is answered by it, once, also if nothing had to move.
    AtRest,
    /// A run or a jog of all motors has come to this frame.
    Frame(FrameNumber),
    /// A run has come to the end of a pass; or a shot is done, and the shutter closed.
    PassEnd,
    /// The operator's own switch says "go".
    OperatorGo,
    /// A motor ran into its limit switch.
    Limit {
        /// Which motor.
        motor: Motor,
        /// Whether it is the upper limit.
        upper: bool,
    },
    /// The emergency stop was pressed, or released.
    EmergencyStop(bool),
    /// The motion engine gave up, because of a motor or of itself.
    Fault(Option<Motor>),
    /// The general purpose inputs that are on, now that they changed; debounced.
    Inputs(Triggers),
    /// The rig aims at another point than it was told.
    Aimed,
    /// The moment has come that the last output asked to be woken at.
    Wake,
}

impl<'a> Input<'a> {
    /// What a frame of the host's brings; `rig` judges its message, as [`Input::Received`] says.
    pub fn frame(frame: &Frame<'a>, rig: impl FnOnce(&HostMessage<'a>) -> AckCode) -> Self {
        match HostMessage::decode(frame) {
            Ok(message) => Self::Received { id: frame.id(), rig: rig(&message), message },
            Err(_) => Self::Malformed(frame.id(), frame.kind()),
        }
    }
}

/// What the rig is told. It does so at once, and before it sends what stands beside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Event {
    /// Stop. A stop is never made softer by another one.
    Stop(Stop),
    /// Switch off all outputs of the uploaded move (safety decision 6).
    TriggersOff,
    /// Do what the message says that was just received: it sets something.
    Apply,
    /// Give the message that was just received to the upload buffer, and tell its answer as [`Input::Stored`].
    Store(Store),
    /// Send a motor to a position.
    Move(Motor, Steps),
    /// Run a motor towards a position, and come to rest there, or at a limit that was set.
    Jog(Motor, JogSpeed, Steps),
    /// Send virtual motors as the message says that was just received.
    MoveVirtual,
    /// Send all motors of the uploaded move to a frame, instead of whatever they do.
    ToFrame(FrameNumber),
    /// Run all motors along the uploaded move, to a frame.
    JogAll(FramesPerSecond, FrameNumber),
    /// Get ready for the run or shot of the message that was just received, and rest where it begins.
    Prepare,
    /// Begin the run or shot that was prepared. Of a shot, also move the shutter.
    Go,
    /// Begin the next pass of the run, from one frame to another.
    NextPass(FrameNumber, FrameNumber),
    /// The pass that runs is the last one.
    LastPass,
    /// The run or shot is over: come to rest behind it.
    PostRoll,
    /// The device takes requests again, after a hard stop.
    Unlocked,
    /// An acknowledgement arrived, which only devices send. It is not answered (decision D-5).
    Acknowledgement(MessageId, MessageType),
    /// The rig reported what fits nothing that it was told.
    Stray,
}

/// Which stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Stop {
    /// One motor, with its own deceleration.
    Motor(Motor),
    /// One virtual motor.
    Virtual(VirtualMotor),
    /// Everything; silent without warnings (safety decision 4).
    All {
        /// Whether to warn nobody.
        silent: bool,
    },
    /// Everything, harder: it is the second time within a second.
    Harder,
    /// Everything, as fast as it can: a limit switch, a fault, the emergency stop.
    Hard,
}

/// A message to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Send {
    /// The id of the request that it answers, or [`MessageId::UNSOLICITED`].
    pub id: MessageId,
    /// What it says.
    pub what: What,
}

/// What a message of the device says; what is long is looked up in the rig when it is [made](Send::message).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum What {
    /// Who the device is.
    Greeting(Hi<'static>),
    /// How a request ended.
    Ack {
        /// The type of the request.
        of: MessageType,
        /// How it ended.
        code: AckCode,
        /// Whether in four bytes (decision D-6).
        wide: bool,
    },
    /// Which inputs are on.
    Inputs(Triggers),
    /// Which motors move.
    Status(Motors),
    /// The motor moves.
    Moving,
    /// Where the motors are; this many of them.
    Positions(MoveTime, u8),
    /// Everything stopped, because of a motor or not.
    HardStop(StopReason, Option<Motor>),
    /// The operator started.
    Go,
    /// The run or shot is done.
    End,
    /// Where the virtual motors are.
    VirtualPositions,
    /// Where the camera is aimed.
    Aim,
}

/// Room for the positions of a message: one for each motor that a device can have.
pub type Scratch = [I32; 32];

/// What only the rig knows, asked when a message is made.
pub trait Rig {
    /// Where a motor is.
    fn position(&self, motor: Motor) -> Steps;

    /// Whether DMX channels are on their way; none is, unless said otherwise.
    fn dmx_moves(&self) -> bool {
        false
    }

    /// Where the virtual motors are. It is asked only of rigs that say they have some.
    fn virtual_positions(&self) -> VirtPositions<'_> {
        let zero = VirtualPosition::default();
        let (track, ew, ns, pan, tilt, roll) = (zero, zero, zero, zero, zero, zero);
        VirtPositions { track, ew, ns, pan, tilt, roll, aim_enabled: None, aim: None, tail: &[] }
    }

    /// Where the camera is aimed. It is asked only of rigs that say they can aim.
    fn aim(&self) -> VirtAimPoint<'_> {
        let zero = Coordinate::default();
        VirtAimPoint { enable: Bool(0), aim_x: zero, aim_y: zero, aim_z: zero, tail: &[] }
    }
}

impl Send {
    /// The message, with what the rig knows. Positions are put into `scratch`.
    #[must_use]
    pub fn message<'s, R: Rig + ?Sized>(&self, rig: &'s R, scratch: &'s mut Scratch) -> DeviceMessage<'s> {
        let empty = Empty { tail: &[] };
        match self.what {
            What::Greeting(hi) => DeviceMessage::Hi(hi),
            What::Ack { of, code, wide } => {
                let tail: &[u8] = if wide { &[0; 2] } else { &[] };
                DeviceMessage::Ack(Ack { tail, ..Ack::new(of, code) })
            }
            What::Inputs(triggers) => DeviceMessage::GioIn(GioIn { triggers, tail: &[] }),
            What::Status(motor_status) => {
                let dmx_status = Bool(rig.dmx_moves().into());
                DeviceMessage::MotorStatus(MotorStatus { motor_status, dmx_status, tail: &[] })
            }
            What::Moving => DeviceMessage::MotorMove(MotorMoving { moving: Bool(1), tail: &[] }),
            What::Positions(move_time, count) => {
                let motors = (1..=count).map(Motor);
                for (place, motor) in scratch.iter_mut().zip(motors) {
                    *place = I32::new(rig.position(motor).0);
                }
                let positions = scratch.get(..count.into()).unwrap_or_default();
                DeviceMessage::MotorGetPosition(MotorPositions { move_time, positions, tail: &[] })
            }
            What::HardStop(reason, motor) => DeviceMessage::MotorHardStop(HardStop { reason, motor, tail: &[] }),
            What::Go => DeviceMessage::RtGo(empty),
            What::End => DeviceMessage::RtEnd(empty),
            What::VirtualPositions => DeviceMessage::VirtGetPosition(rig.virtual_positions()),
            What::Aim => DeviceMessage::VirtAimPoint(rig.aim()),
        }
    }
}

/// Messages of one step at most: positions and end of a run, acknowledgement and positions of a reset, and with either one
/// report of positions that was due.
pub const SENDS: usize = 4;
/// Events of one step at most: a stop and its outputs, what takes its place, and the end of a lock.
pub const EVENTS: usize = 4;

/// What follows from a step. The events come first: what a message tells, is then so.
pub type Output = machine::Output<Send, Event, SENDS, EVENTS>;
