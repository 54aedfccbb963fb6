//! Inputs of a client machine.

use motion_core::wire::DecodeError;
use motion_core::{display, states};

use super::Token;
use crate::DeviceMessage;
use crate::frame::{Frame, MessageId, MessageType};
use crate::message::{Ipv4, LedMode, MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds};
use crate::move_summary::MoveSummary;
use crate::transport::Transport;

/// Place where a device is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
pub enum Endpoint {
    /// Address in the network, at port 5520.
    Tcp(Ipv4),
    /// USB of this computer.
    Usb,
}

display! {
    Endpoint {
        Tcp(address) => "{address}";
        Usb => "USB";
    }
}

impl Endpoint {
    /// Transport of a connection to the device.
    #[must_use]
    pub const fn transport(self) -> Transport {
        match self {
            Self::Tcp(_) => Transport::Tcp,
            Self::Usb => Transport::Usb,
        }
    }
}

/// Something that happened to a client.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Input<'a> {
    /// The connection that [`Event::Connect`](super::Event::Connect) asked for is there.
    LinkUp,
    /// There is no connection, or not any more.
    LinkDown,
    /// The device sent a message.
    Received(DeviceMessage<'a>),
    /// The device sent a message that ends before its fields do.
    Malformed {
        /// Id of the message.
        id: MessageId,
        /// Type of the message.
        kind: MessageType,
        /// Error of the decoder.
        error: DecodeError,
    },
    /// The bytes from the device are no stream of messages: a `Fatal` item (safety decision 6).
    Fatal,
    /// The application wants something. The end of the command is told under its token.
    Command(Token, Command),
    /// The time of the last wake has come.
    Wake,
}

impl<'a> Input<'a> {
    /// Input for a frame from the device: [`Received`](Self::Received), or [`Malformed`](Self::Malformed).
    #[must_use]
    pub fn received(frame: &Frame<'a>) -> Self {
        match DeviceMessage::decode(frame) {
            Ok(message) => Self::Received(message),
            Err(error) => Self::Malformed { id: frame.id(), kind: frame.kind(), error },
        }
    }
}

/// Motion of a motor to a position, or by a distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Go {
    /// Motor to move.
    pub motor: MotorAddress,
    /// Position, counted from the begin of the range; or distance.
    pub position: Rotations,
    /// Speed. Speed 0 is a stop of the motor (safety decision 3).
    pub speed: RotationsPerSecond,
    /// Acceleration of start and stop.
    pub acceleration: RotationsPerSecondSquared,
}

states! {
    /// Question to the device.
    pub enum Get {
        /// Address in the network.
        NetworkInfo,
        /// State of the lamps.
        LedStatus,
        /// Positions, ranges and limits of the motors.
        MotorInfo,
        /// What the device is, and what it does at present.
        DeviceInfo,
        /// Move that is stored.
        TrajectoryData,
        /// Number that no other device has.
        DeviceGuid,
        /// Platform that calibrated the motors.
        SoftwareId,
    }
}

impl Get {
    /// Message id of the question and its answer.
    #[must_use]
    pub const fn id(self) -> MessageId {
        match self {
            Self::NetworkInfo => MessageId::NETWORK_INFO,
            Self::LedStatus => MessageId::LED_STATUS,
            Self::MotorInfo => MessageId::MOTOR_INFO,
            Self::DeviceInfo => MessageId::DEVICE_INFO,
            Self::TrajectoryData => MessageId::TRAJECTORY_DATA,
            Self::DeviceGuid => MessageId::DEVICE_GUID,
            Self::SoftwareId => MessageId::SOFTWARE_ID,
        }
    }

    /// Question with this message id, if there is one.
    #[must_use]
    pub fn of(id: MessageId) -> Option<Self> {
        Self::ALL.into_iter().find(|get| get.id() == id)
    }
}

/// Something that the application wants.
///
/// Each command ends once, with [`Event::Ended`](super::Event::Ended); the text says how. A command that cannot be
/// followed ends with [`Outcome::Refused`](super::Outcome::Refused).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Command {
    /// Stops everything in this call, in every state, and again until the device confirms it.
    ///
    /// Ends with `Sent`; `Stopped` or `StopNotConfirmed` follows. Without a connection it is refused, told as not
    /// confirmed, and sent first as soon as there is a connection.
    Stop,
    /// Stops a motor in this call, and again until it rests. Ends with `Sent`; `Stopped` or `StopNotConfirmed` follows.
    ///
    /// Without a connection it is refused, told as not confirmed, and sent first as soon as there is a connection.
    StopMotor(MotorAddress),
    /// Connects to a device, and keeps connected. Ends with `Done`; `Ready` or `Locked` follows.
    Connect(Endpoint),
    /// Disconnects. Ends with `Done`.
    Disconnect,
    /// Tells a locked device the password of the application, over TCP, and asks for its motors. Ends with `Sent`; `Ready` or `Locked` follows.
    Unlock,
    /// Gives the device the new password of the application. Refused while anything may move (safety decision 2), and over
    /// USB, which has no password. Ends with `Sent`.
    ChangePassword,
    /// Asks the device something; one question of a kind at a time. Ends with the answer, or with `Failed`.
    Get(Get),
    /// Switches the lamps. Ends with `Sent`.
    SetLeds {
        /// Mode of the lamp of the device.
        master: LedMode,
        /// Mode of the lamp of its slave.
        slave: LedMode,
    },
    /// Tells the device which platform calibrates the motors. Ends with `Sent`.
    SetPlatform(u8),
    /// Starts the device anew. Ends with `Sent`; the connection is lost then.
    ResetDevice,
    /// Forgets the range of a motor, or of all motors. Ends with `Sent`.
    ResetAxis(MotorAddress),
    /// Marks the begin of the range of a motor where it rests. Ends with `Sent`.
    MarkBegin(MotorAddress),
    /// Marks the end of the range of a motor where it rests. Ends with `Done` when the motor has a range.
    MarkEnd(MotorAddress),
    /// Sends a motor to a position. Of many in a short time, the last one counts. Refused if the position is outside the
    /// range that the device reported.
    ///
    /// Ends with `Done` when the motor rests. Ends with `NotConfirmed` instead if the motor was not known to rest before,
    /// such as on the way to another position: nothing in the protocol tells at which of the two the motor rests.
    MoveTo(Go),
    /// Runs a motor until it is stopped, backward if the speed is negative. Ends with `Sent`.
    ///
    /// A motor with a range runs to the end of its range at most. Speed and acceleration are at most what the specification
    /// allows: see [`Motor::jog`](crate::message::Motor::jog).
    ///
    /// The motor is stopped if the application gives no command for the time of
    /// [`dead_man`](super::Options::dead_man), such as [`Alive`](Self::Alive).
    Jog {
        /// Motor to run.
        motor: MotorAddress,
        /// Speed and direction. Speed 0 is a stop of the motor.
        speed: RotationsPerSecond,
        /// Acceleration of start and stop.
        acceleration: RotationsPerSecondSquared,
    },
    /// Sends a motor a distance from where it rests. Ends with `Done` when the motor rests; as after `MoveTo`, with
    /// `NotConfirmed` if the motor was not known to rest before.
    Bump(Go),
    /// Tells the machine that the application is there. Ends with `Done`.
    Alive,
    /// Takes one photo with this exposure. Ends with `Sent`.
    TakePicture(Seconds),
    /// Stores a move and makes it ready. Ends with `Done` when it can be played.
    ///
    /// A move is always played forward, because the specification asks for it. To play one from its end, store it
    /// [reversed](crate::trajectory::TrajectoryData::reversed).
    Load {
        /// Summary of the move; its blocks are the application's.
        summary: MoveSummary,
        /// Whether the motors stay where they are until the move is played.
        delay_return: bool,
    },
    /// Plays the move that is ready. Ends with `Done` when the move is at its end.
    Play,
    /// Stores a move and plays it. Ends with `Done` when the move is at its end.
    PlayDirect {
        /// Summary of the move; its blocks are the application's.
        summary: MoveSummary,
    },
    /// Sends the motors of the move that is ready to where it begins. Ends with `Sent`; `Move::Home` follows.
    RapidToFirstKeyFrame,
}
