//! Events of a device machine: what the rig has to do, or should know.

use motion_core::display;
use motion_core::wire::{DecodeError, Password};

use super::clients::{DisconnectReason, SessionId};
use crate::message::{
    Direction, LedMode, MotorAddress, MotorSet, Normalized, Rotations, RotationsPerSecond, RotationsPerSecondSquared,
};
use crate::move_summary::SummaryError;
use crate::trajectory::TrajectoryData;

/// Something that the rig has to do, or should know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Event<'a> {
    /// Send a motor to a position.
    Move {
        /// Motor to move.
        motor: MotorAddress,
        /// Position, as the rig counts.
        to: Rotations,
        /// Greatest speed; the rig's own limits stand over it.
        speed: RotationsPerSecond,
        /// Acceleration of start and stop.
        acceleration: RotationsPerSecondSquared,
    },
    /// Stop a motor.
    StopMotor {
        /// Motor to stop.
        motor: MotorAddress,
        /// Acceleration; `None` for the greatest that is safe.
        acceleration: Option<RotationsPerSecondSquared>,
    },
    /// Stop all motors and the move, and close the shutter.
    StopAll,
    /// Send motors to where the move begins, or ends if it will be played in reverse.
    Home {
        /// Direction in which the move will be played.
        way: Direction,
        /// Speed, as a part of the greatest speed of each motor.
        speed: Normalized,
        /// Motors of the move.
        motors: MotorSet,
    },
    /// Play the whole move in this time. It begins now, even if the rig was late before.
    Play {
        /// Direction in which the move is played.
        way: Direction,
        /// Duration in milliseconds.
        millis: u64,
    },
    /// Send the motors of the move to the next place: `frame` of `last` parts of the move.
    MoveToFrame {
        /// Number of the place, from 1.
        frame: u32,
        /// Number of the place where the move ends.
        last: u32,
    },
    /// Open the shutter.
    OpenShutter {
        /// Exposure in milliseconds.
        millis: u64,
    },
    /// The move is at its end and will not go on.
    MoveOver,
    /// Switch the lamps.
    Leds {
        /// Mode of the lamp of the device.
        master: LedMode,
        /// Mode of the lamp of its slave.
        slave: LedMode,
    },
    /// Store this password.
    StorePassword(Password<'a>),
    /// Store this move, in place of the one that is stored.
    StoreTrajectory(TrajectoryData<'a>),
    /// A client sent a move that cannot be played. The one that was stored is forgotten.
    BadTrajectory(SummaryError),
    /// Store the platform that calibrates the motors.
    StorePlatform(u8),
    /// Close a connection.
    Disconnect {
        /// Number of the connection.
        session: SessionId,
        /// Reason why it is closed.
        reason: DisconnectReason,
    },
    /// Start the device anew, and report [`Started`](super::Report::Started) then.
    Reboot,
    /// An input was ignored.
    Ignored(Ignored),
}

impl Event<'_> {
    /// Returns the same event if it can be kept; `None` if it lends a part of a message.
    #[must_use]
    pub const fn to_static(&self) -> Option<Event<'static>> {
        Some(match *self {
            Self::StorePassword(_) | Self::StoreTrajectory(_) => return None,
            Self::Move { motor, to, speed, acceleration } => Event::Move { motor, to, speed, acceleration },
            Self::StopMotor { motor, acceleration } => Event::StopMotor { motor, acceleration },
            Self::StopAll => Event::StopAll,
            Self::Home { way, speed, motors } => Event::Home { way, speed, motors },
            Self::Play { way, millis } => Event::Play { way, millis },
            Self::MoveToFrame { frame, last } => Event::MoveToFrame { frame, last },
            Self::OpenShutter { millis } => Event::OpenShutter { millis },
            Self::MoveOver => Event::MoveOver,
            Self::Leds { master, slave } => Event::Leds { master, slave },
            Self::BadTrajectory(error) => Event::BadTrajectory(error),
            Self::StorePlatform(platform) => Event::StorePlatform(platform),
            Self::Disconnect { session, reason } => Event::Disconnect { session, reason },
            Self::Reboot => Event::Reboot,
            Self::Ignored(why) => Event::Ignored(why),
        })
    }
}

/// Reason why an input was ignored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Ignored {
    /// The client is locked.
    Locked(SessionId),
    /// The password was wrong.
    WrongPassword(SessionId),
    /// The message ends before its fields do.
    Malformed(SessionId, DecodeError),
    /// The device does not know the message, or a value in it.
    Unsupported(SessionId),
    /// A client sent a message that only devices send; it is not answered (decision K-P10).
    NotForDevices(SessionId),
    /// There is no such connection.
    NoSession(SessionId),
    /// The datagram is no question for devices.
    Datagram,
    /// The rig reported something that cannot be: about no motor, or a position that is NaN or infinite.
    Report,
    /// The device starts anew.
    Off,
}

display! {
    Event<'_> {
        Move { motor, to, speed, .. } => "move motor {motor} to {to} rotations at {speed} rotations/s";
        StopMotor { motor, .. } => "stop motor {motor}";
        StopAll => "stop everything, and close the shutter";
        Home { way: Direction::Forward, .. } => "send the motors to where the move begins";
        Home { way: Direction::Reverse, .. } => "send the motors to where the move ends";
        Play { way, millis } => "play the move {way} in {millis} ms";
        MoveToFrame { frame, last } => "go to place {frame} of {last}";
        OpenShutter { millis } => "open the shutter for {millis} ms";
        MoveOver => "the move is over";
        Leds { master, slave } => "switch the lamps: device {master}, slave {slave}";
        StorePassword(_) => "store the password";
        StoreTrajectory(_) => "store the move";
        BadTrajectory(error) => "the move that arrived cannot be played: {error}";
        StorePlatform(platform) => "store platform {platform}";
        Disconnect { session, reason } => "close connection {session}: {reason}";
        Reboot => "start the device anew";
        Ignored(why) => "ignored: {why}";
    }

    Ignored {
        Locked(session) => "connection {session} is locked";
        WrongPassword(session) => "the password of connection {session} is wrong";
        Malformed(session, error) => "a message on connection {session} is malformed: {error}";
        Unsupported(session) => "the device does not know a message on connection {session}, or a value in it";
        NotForDevices(session) => "a message on connection {session} is one that only devices send";
        NoSession(session) => "there is no connection {session}";
        Datagram => "the datagram is no question for devices";
        Report => "the report of the rig cannot be";
        Off => "the device starts anew";
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn an_event_prints_what_the_rig_has_to_do() {
        let text = |event: Event<'_>| event.to_string();
        assert_eq!(text(Event::Play { way: Direction::Forward, millis: 1500 }), "play the move forward in 1500 ms");
        let close = Event::Disconnect { session: SessionId(2), reason: DisconnectReason::Silence };
        assert_eq!(text(close), "close connection 2: the client was silent for too long");
        let wrong = Event::Ignored(Ignored::WrongPassword(SessionId(1)));
        assert_eq!(text(wrong), "ignored: the password of connection 1 is wrong");
    }

    #[test]
    fn no_event_prints_a_password() {
        assert_eq!(Event::StorePassword(Password(b"secret")).to_string(), "store the password");
    }
}
