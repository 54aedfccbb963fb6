//! What goes into a device machine, and what the rig is told.

use motion_core::wire::{DecodeError, Password};

use super::session::{CloseReason, SessionId};
use crate::HostMessage;
use crate::frame::{MessageId, MessageType};
use crate::message::{
    AuxInputs, ErrorCode, LedMode, MotorAddress, Normalized, Rotations, RotationsPerSecond, RotationsPerSecondSquared,
};
use crate::summary::{Direction, MotorSet, SummaryError, Transport};

/// What happened to a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Input<'a> {
    /// A client is connected, under a number that the caller chooses. One that was there under it is gone.
    Opened {
        /// Which connection.
        session: SessionId,
        /// Over what.
        transport: Transport,
        /// The stored password.
        password: Password<'a>,
    },
    /// The client is gone.
    Closed(SessionId),
    /// A client sent a message.
    Received {
        /// Which client.
        session: SessionId,
        /// What.
        message: HostMessage<'a>,
        /// The password that is stored at this moment.
        password: Password<'a>,
    },
    /// A client sent a message that ends before its fields do.
    Malformed {
        /// Which client.
        session: SessionId,
        /// What it is about.
        id: MessageId,
        /// Whether it sets or asks.
        kind: MessageType,
        /// What is missing.
        error: DecodeError,
    },
    /// What a client sends is no stream of messages: a `Fatal` item (safety decision 6).
    Fatal(SessionId),
    /// A datagram came.
    Datagram(HostMessage<'a>),
    /// The rig says what happened to it.
    Rig(Report),
    /// The time has come, or just passed.
    Wake,
}

/// What the rig says. Positions are as the rig counts, from anywhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Report {
    /// The device runs, and can be connected to.
    Started,
    /// A motor is on its way.
    At(MotorAddress, Rotations),
    /// A motor rests: where it was sent, or where it was stopped. Said of every motor that was told to move, stop or go
    /// home, or to the next place of a move, also if it did not have to move.
    Arrived(MotorAddress, Rotations),
    /// A motor cannot get to where the move begins.
    CannotHome(MotorAddress),
    /// A motor has a fault: `RUNAWAY`, `FAULT` and the like.
    Fault(MotorAddress, ErrorCode),
    /// A motor is there, or not any more.
    Online(MotorAddress, bool),
    /// An input changed.
    Inputs(AuxInputs),
}

/// What the rig shall do, or should know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Event {
    /// Send a motor to a position, as the rig counts.
    Move {
        /// Which.
        motor: MotorAddress,
        /// Where to.
        to: Rotations,
        /// How fast, at most; the rig's own limits stand over it.
        speed: RotationsPerSecond,
        /// How sharply.
        acceleration: RotationsPerSecondSquared,
    },
    /// Stop a motor.
    StopMotor {
        /// Which.
        motor: MotorAddress,
        /// How sharply; `None` for as sharply as is safe.
        acceleration: Option<RotationsPerSecondSquared>,
    },
    /// Stop all motors and the move, close the shutter.
    StopAll,
    /// Send motors to where the move begins, or, to play it back, ends.
    Home {
        /// Which way the move will be played.
        way: Direction,
        /// How fast, as a part of their greatest speed.
        speed: Normalized,
        /// Which.
        motors: MotorSet,
    },
    /// Play the move, all of it, in this time. Should the rig have been late before, it begins now.
    Play {
        /// Which way.
        way: Direction,
        /// How long it takes.
        millis: u64,
    },
    /// Send the motors of the move to the next place: `frame` of `last` parts of the move.
    MoveToFrame {
        /// Which place, from 1.
        frame: u32,
        /// The place where the move ends.
        last: u32,
    },
    /// Open the shutter.
    OpenShutter {
        /// For how long.
        millis: u64,
    },
    /// The move is at its end, and will not go on.
    MoveOver,
    /// Switch the lamps.
    Leds {
        /// Of the device.
        master: LedMode,
        /// Of its slave.
        slave: LedMode,
    },
    /// Store the password of the message that was just given in.
    StorePassword,
    /// Store the move of the message that was just given in.
    StoreTrajectory,
    /// The move of the message that was just given in cannot be played; none is stored now.
    BadTrajectory(SummaryError),
    /// Store the platform that calibrates the motors.
    StorePlatform(u8),
    /// Close a connection.
    Close(SessionId, CloseReason),
    /// Start anew, and say `Started` then.
    Reboot,
    /// Nothing followed from what came.
    Ignored(Ignored),
}

/// What nothing followed from, and why.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Ignored {
    /// The client is locked.
    Locked(SessionId),
    /// The password was wrong.
    WrongPassword(SessionId),
    /// The message ends before its fields do.
    Malformed(SessionId, DecodeError),
    /// The device does not know the message, or would not know what to do with it.
    Unsupported(SessionId),
    /// A client sent what only devices send; it is not answered (decision K-P10).
    NotForDevices(SessionId),
    /// There is no such connection.
    NoSession(SessionId),
    /// The datagram is no question for devices.
    Datagram,
    /// The rig said what cannot be: of no motor, or a position that is no number.
    Report,
    /// The device starts anew.
    Off,
}
