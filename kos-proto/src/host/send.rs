//! What a client sends: named, and made a message with what only the application has.

use motion_core::wire::{Bool, Empty, Password};

use super::io::Go;
use super::requests::Get;
use crate::HostMessage;
use crate::message::{
    BumpPositionSpeedAcceleration, GetNetworkInfo, LEDStatus, LedMode, MarkBeginPosition, MarkEndPosition,
    MotorAddress, ResetAxis, Seconds, SetPassword, SetPositionSpeedAcceleration, SetupPlayback, SoftwareID,
    StartPlayback, TakePicture,
};
use crate::summary::Direction;
use crate::trajectory::TrajectoryData;

/// Which password.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PasswordOf {
    /// That of the `DeviceInfo` that was just given in.
    Device,
    /// The one that the application has.
    User,
    /// The new one that the application has.
    New,
}

/// What to send, over the connection, but for [`Question`](Self::Question). What is long comes from a [`Source`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Send {
    /// Who is there? A datagram to 255.255.255.255.
    Question,
    /// The line is in use.
    KeepAlive,
    /// A question.
    Get(Get),
    /// The password of this session.
    UserPassword(PasswordOf),
    /// Another password for the device: the new one.
    DevicePassword,
    /// The move.
    Trajectory,
    /// What the lamps shall do.
    Leds {
        /// Of the device.
        master: LedMode,
        /// Of its slave.
        slave: LedMode,
    },
    /// The platform that calibrates the motors.
    Platform(u8),
    /// Start anew.
    ResetDevice,
    /// Forget a range.
    ResetAxis(MotorAddress),
    /// The range begins here.
    MarkBegin(MotorAddress),
    /// The range ends here.
    MarkEnd(MotorAddress),
    /// Make the move ready.
    Setup {
        /// For which way.
        way: Direction,
        /// Whether the motors stay where they are.
        delay_return: bool,
    },
    /// Play the move.
    Start(Direction),
    /// Stop everything.
    StopPlayback,
    /// Go to where the move begins.
    RapidToFirstKeyFrame,
    /// Take one photo.
    TakePicture(Seconds),
    /// Go to a position; stop, if the speed is 0.
    MoveTo(Go),
    /// Go a distance.
    Bump(Go),
}

/// What the application has, borrowed where a message is made.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// The password of the `DeviceInfo` that was just given in.
    pub device_password: Password<'a>,
    /// The password that the application has.
    pub user_password: Password<'a>,
    /// The password that the device shall have.
    pub new_password: Password<'a>,
    /// The move.
    pub trajectory: TrajectoryData<'a>,
}

impl Default for Source<'_> {
    /// No password, and no move.
    fn default() -> Self {
        let none = Password(&[]);
        Self { device_password: none, user_password: none, new_password: none, trajectory: TrajectoryData::default() }
    }
}

impl Source<'_> {
    const fn password(&self, of: PasswordOf) -> Password<'_> {
        match of {
            PasswordOf::Device => self.device_password,
            PasswordOf::User => self.user_password,
            PasswordOf::New => self.new_password,
        }
    }
}

impl Send {
    /// Whether it may be sent again, without the application wanting it: questions, passwords, what says the same
    /// twice, and stops. Nothing else is: it might move something twice.
    #[must_use]
    pub fn is_repeatable(&self) -> bool {
        match self {
            Self::Question
            | Self::KeepAlive
            | Self::Get(_)
            | Self::UserPassword(_)
            | Self::Leds { .. }
            | Self::Platform(_)
            | Self::StopPlayback => true,
            Self::MoveTo(go) => go.speed.0 == 0.0,
            Self::DevicePassword
            | Self::Trajectory
            | Self::ResetDevice
            | Self::ResetAxis(_)
            | Self::MarkBegin(_)
            | Self::MarkEnd(_)
            | Self::Setup { .. }
            | Self::Start(_)
            | Self::RapidToFirstKeyFrame
            | Self::TakePicture(_)
            | Self::Bump(_) => false,
        }
    }

    /// The message, with what `source` has for it.
    #[must_use]
    pub fn message<'s>(&self, source: &'s Source<'s>) -> HostMessage<'s> {
        let (tail, empty) = (&[][..], Empty { tail: &[] });
        match *self {
            Self::Question => HostMessage::GetNetworkInfo(GetNetworkInfo::new(true)),
            Self::KeepAlive => HostMessage::KeepAlive(empty),
            Self::Get(get) => get.message(),
            Self::UserPassword(of) => HostMessage::SetUserPassword(SetPassword { password: source.password(of), tail }),
            Self::DevicePassword => HostMessage::SetDevicePassword(SetPassword { password: source.new_password, tail }),
            Self::Trajectory => HostMessage::SetTrajectoryData(source.trajectory),
            Self::Leds { master, slave } => {
                HostMessage::SetLEDStatus(LEDStatus { master_status: master, slave_status: slave, tail })
            }
            Self::Platform(platform) => HostMessage::SetSoftwareID(SoftwareID { platform, tail }),
            Self::ResetDevice => HostMessage::ResetDevice(empty),
            Self::ResetAxis(motor_address) => HostMessage::ResetAxis(ResetAxis { motor_address, tail }),
            Self::MarkBegin(motor_address) => HostMessage::MarkBeginPosition(MarkBeginPosition { motor_address, tail }),
            Self::MarkEnd(motor_address) => HostMessage::MarkEndPosition(MarkEndPosition { motor_address, tail }),
            Self::Setup { way, delay_return } => HostMessage::SetupPlayback(SetupPlayback {
                direction: way.as_sent(),
                start_time: Seconds(0.0),
                delay_return: delay_return.into(),
                tail,
            }),
            Self::Start(way) => {
                HostMessage::StartPlayback(StartPlayback { direction: way.as_sent(), start_time: Seconds(0.0), tail })
            }
            Self::StopPlayback => HostMessage::StopPlayback(empty),
            Self::RapidToFirstKeyFrame => HostMessage::RapidToFirstKeyFrame(empty),
            Self::TakePicture(exposure) => {
                HostMessage::TakePicture(TakePicture { motor_address: MotorAddress::ALL, exposure, tail })
            }
            Self::MoveTo(Go { motor, position, speed, acceleration }) => HostMessage::SetPositionSpeedAcceleration(
                SetPositionSpeedAcceleration::move_to(motor, position, speed, acceleration),
            ),
            Self::Bump(Go { motor, position, speed, acceleration }) => {
                HostMessage::BumpPositionSpeedAcceleration(BumpPositionSpeedAcceleration {
                    motor_address: motor,
                    delta: position,
                    speed,
                    acceleration,
                    tail,
                })
            }
        }
    }
}

impl Get {
    /// The message that asks it.
    const fn message(self) -> HostMessage<'static> {
        let empty = Empty { tail: &[] };
        match self {
            Self::NetworkInfo => {
                HostMessage::GetNetworkInfo(GetNetworkInfo { limited_response: Some(Bool::FALSE), tail: &[] })
            }
            Self::LedStatus => HostMessage::GetLEDStatus(empty),
            Self::MotorInfo => HostMessage::GetMotorInfo(empty),
            Self::DeviceInfo => HostMessage::GetDeviceInfo(empty),
            Self::TrajectoryData => HostMessage::GetTrajectoryData(empty),
            Self::DeviceGuid => HostMessage::GetDeviceGUID(empty),
            Self::SoftwareId => HostMessage::GetSoftwareID(empty),
        }
    }
}
