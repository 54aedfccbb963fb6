//! What goes into a client machine, and what the application is told.

use motion_core::wire::DecodeError;

use crate::DeviceMessage;
use crate::frame::{MessageId, MessageType};
use crate::message::{
    AuxInputs, ErrorCode, Ipv4, LedMode, MotorAddress, Normalized, Photos, PlaybackState, Rotations,
    RotationsPerSecond, RotationsPerSecondSquared, Seconds,
};
use crate::summary::{Direction, MoveSummary, Transport};

use super::requests::{Failure, Get, Token};
use super::tracker;

/// Where a device is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Endpoint {
    /// In the network, at port 5520.
    Tcp(Ipv4),
    /// On this computer.
    Usb,
}

impl Endpoint {
    /// How it is connected.
    #[must_use]
    pub const fn transport(self) -> Transport {
        match self {
            Self::Tcp(_) => Transport::Tcp,
            Self::Usb => Transport::Usb,
        }
    }
}

/// What happened to a client.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Input<'a> {
    /// The connection that [`Event::Open`] asked for is there.
    Opened,
    /// There is no connection, or not any more.
    Closed,
    /// The device sent a message.
    Received(DeviceMessage<'a>),
    /// The device sent a message that ends before its fields do.
    Malformed {
        /// What it is about.
        id: MessageId,
        /// Whether it answers.
        kind: MessageType,
        /// What is missing.
        error: DecodeError,
    },
    /// What the device sends is no stream of messages: a `Fatal` item (safety decision 6).
    Fatal,
    /// The application wants something.
    Command(Command),
    /// The time has come, or just passed.
    Wake,
}

/// Where to send a motor, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Go {
    /// Which motor.
    pub motor: MotorAddress,
    /// Where to, from the begin of its range; or how far.
    pub position: Rotations,
    /// How fast.
    pub speed: RotationsPerSecond,
    /// How sharply.
    pub acceleration: RotationsPerSecondSquared,
}

/// What the application wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Command {
    /// Stop everything, now, whatever happens, and again until the device confirms it.
    Stop,
    /// Stop a motor.
    StopMotor(MotorAddress),
    /// Be connected to a device, and stay so.
    Connect(Endpoint),
    /// Be connected no more.
    Disconnect,
    /// Say the password again, the one that the application has.
    Unlock,
    /// Give the device another password; the application has it. Refused while anything moves (safety decision 2).
    ChangePassword,
    /// Ask the device something; one question of a kind at a time.
    Get(Get, Token),
    /// Switch the lamps.
    SetLeds {
        /// Of the device.
        master: LedMode,
        /// Of its slave.
        slave: LedMode,
    },
    /// Say which platform calibrates the motors.
    SetPlatform(u8),
    /// Let the device start anew.
    ResetDevice,
    /// Forget the range of a motor, or of all.
    ResetAxis(MotorAddress),
    /// The range of a motor begins where it rests.
    MarkBegin(MotorAddress),
    /// The range of a motor ends where it rests.
    MarkEnd(MotorAddress),
    /// Send a motor to a position. Of many in a short time, the last one counts.
    MoveTo(Go),
    /// Let a motor run, backward if the speed is negative, until it is stopped; say [`Alive`](Self::Alive), or anything
    /// else, again and again meanwhile.
    Jog {
        /// Which motor.
        motor: MotorAddress,
        /// How fast, and which way.
        speed: RotationsPerSecond,
        /// How sharply.
        acceleration: RotationsPerSecondSquared,
    },
    /// Send a motor a distance from where it rests.
    Bump(Go),
    /// The application is there.
    Alive,
    /// Take one photo.
    TakePicture(Seconds),
    /// Store a move, and make it ready.
    Load {
        /// What it is; its blocks are the application's.
        summary: MoveSummary,
        /// Which way it will be played.
        way: Direction,
        /// Whether the motors stay where they are until it is played.
        delay_return: bool,
    },
    /// Play the move that is ready.
    Play,
    /// Store a move, and play it.
    PlayDirect {
        /// What it is; its blocks are the application's.
        summary: MoveSummary,
        /// Which way.
        way: Direction,
    },
    /// Send the motors of the move that is ready to where it begins.
    RapidToFirstKeyFrame,
}

/// Why a command is not followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Refusal {
    /// There is no connection.
    NotConnected,
    /// There is one already, or it is being made.
    Connected,
    /// The device is not ready, or locked.
    NotReady,
    /// A question of this kind, or a calibration, is not answered yet.
    Busy,
    /// A move runs, or is not stopped yet.
    MoveRuns,
    /// Something moves.
    Moves,
    /// No move is ready.
    NoMove,
    /// The device has no such motor.
    NoMotor,
    /// The begin of the range is not marked.
    NotMarked,
    /// A number is none, or not positive where it should be.
    Number,
}

/// Why there is no connection any more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum CloseReason {
    /// The device closed it, or it was never there.
    Ended,
    /// What it sent is no stream of messages.
    Framing,
    /// It did not say what it is.
    NoAnswer,
    /// It was silent for too long.
    Silence,
    /// The application wanted it.
    Asked,
    /// The device starts anew.
    Reset,
}

/// What the application is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Event {
    /// Connect there, then say `Opened` or `Closed`.
    Open(Endpoint),
    /// The connection is over; close it, if it is not closed.
    Closed(CloseReason),
    /// The device wants a password.
    Locked,
    /// The motors are known, or known anew.
    Motors,
    /// The device can be used.
    Ready {
        /// Whether it is another one than expected, or another platform was there, so that ranges that the application
        /// stored mean nothing (safety decision 9).
        ranges_void: bool,
    },
    /// A command is not followed.
    Refused(Refusal),
    /// The question of this command is answered by the message that was just given in.
    Answered(Get, Token),
    /// The question of this command is not answered.
    Failed(Get, Token, Failure),
    /// A stop is not confirmed: of a motor, or of everything. It is sent again as long as there is a connection, and
    /// first of all when there is one again. Use the emergency stop of the rig.
    StopNotConfirmed(Option<MotorAddress>),
    /// The application said nothing while it jogged motors, which were stopped.
    DeadMan,
    /// A motor rests.
    MotorRests(MotorAddress, Rotations),
    /// A motor was sent somewhere, and does not say that it rests: it may be slow, or the word was lost. Until it is
    /// stopped it is taken to move.
    MotorSlow(MotorAddress),
    /// A motor came or went.
    MotorOnline(MotorAddress, bool),
    /// The range of a motor changed, or is void.
    MotorChanged(MotorAddress),
    /// The range that was marked is there.
    Calibrated(MotorAddress),
    /// The range that was marked is not there.
    CalibrationFailed(MotorAddress),
    /// How far the device is with its move.
    Move(Move),
    /// An input changed.
    Inputs(AuxInputs),
    /// Something failed.
    Error(ErrorCode, MotorAddress),
    /// The device does not know a message; its id, if it says so.
    Unsupported(Option<MessageId>),
    /// Something that was not asked, or nobody knows: see the message that was just given in.
    Told(MessageId),
    /// A message ends before its fields do.
    Malformed(MessageId, DecodeError),
    /// What came means nothing just now.
    Ignored,
}

/// What happens to a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Move {
    /// The motors are where it begins.
    Home,
    /// It can be played.
    Ready,
    /// It takes long until it is ready, or begins.
    Slow,
    /// It waits for its time.
    Countdown,
    /// Photos before it are taken.
    PreShoot,
    /// It runs.
    Running(Direction),
    /// So far it is.
    Progress {
        /// What is said of it.
        state: PlaybackState,
        /// How much of it is over.
        elapsed: Normalized,
        /// Photos taken in it, if the device says so.
        photos: Option<Photos>,
    },
    /// It is at its end; a loop or photos may follow.
    EndReached,
    /// Photos behind it are taken.
    PostShot,
    /// All is over, and the device forgot it.
    Finished {
        /// Whether this client stopped it.
        requested: bool,
    },
    /// It cannot be played, and is stopped.
    Failed(ErrorCode),
    /// Something else was refused because it runs.
    Refused,
    /// The connection is lost; what it does now, nobody knows.
    Lost,
    /// It was found again behind a lost connection.
    Found(tracker::State),
    /// The device says something of it that does not fit.
    Unexpected(PlaybackState),
}
