//! Messages that a client machine sends, by name. What is long comes from a [`Source`].

use motion_core::wire::{Bool, Conduct, Password};

use super::input::{Get, Go};
use crate::HostMessage;
use crate::message::{
    BumpPositionSpeedAcceleration, DevicePassword, GetDeviceGUID, GetDeviceInfo, GetLEDStatus, GetMotorInfo,
    GetNetworkInfo, GetSoftwareID, GetTrajectoryData, KeepAlive, LEDStatus, LedMode, MarkBeginPosition,
    MarkEndPosition, MotorAddress, RapidToFirstKeyFrame, ResetAxis, ResetDevice, Seconds, SetPositionSpeedAcceleration,
    SetupPlayback, SoftwareID, StartPlayback, StopPlayback, TakePicture, UserPassword,
};
use crate::trajectory::TrajectoryData;

/// Owner of a password.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PasswordOf<'a> {
    /// Password that the device told.
    Device(Password<'a>),
    /// Password that the application has.
    User,
    /// New password that the application has.
    New,
}

/// Message to send over the connection, except [`Discover`](Self::Discover).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Transmit<'a> {
    /// Question who is there: a datagram to 255.255.255.255.
    Discover,
    /// Sign that the line is in use.
    KeepAlive,
    /// Question.
    Get(Get),
    /// Password of this session.
    UserPassword(PasswordOf<'a>),
    /// Password that the device shall store: the new one.
    DevicePassword,
    /// Move that the device shall store.
    Trajectory,
    /// Modes of the lamps.
    Leds {
        /// Mode of the lamp of the device.
        master: LedMode,
        /// Mode of the lamp of its slave.
        slave: LedMode,
    },
    /// Platform that calibrates the motors.
    Platform(u8),
    /// Restart of the device.
    ResetDevice,
    /// Motor whose range is forgotten, or all.
    ResetAxis(MotorAddress),
    /// Motor whose range begins where it is.
    MarkBegin(MotorAddress),
    /// Motor whose range ends where it is.
    MarkEnd(MotorAddress),
    /// Preparation of the move.
    Setup {
        /// Whether the motors stay where they are.
        delay_return: bool,
    },
    /// Start of the move.
    Start,
    /// Stop of everything.
    StopPlayback,
    /// Way of the motors to where the move begins.
    RapidToFirstKeyFrame,
    /// Photo with this exposure.
    TakePicture(Seconds),
    /// Motion of a motor to a position; a stop if the speed is 0.
    MoveTo(Go),
    /// Motion of a motor by a distance.
    Bump(Go),
}

/// Data that only the application has, borrowed to make messages.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// Password that the application has.
    pub user_password: Password<'a>,
    /// Password that the device shall have.
    pub new_password: Password<'a>,
    /// Move of the last `Load` or `PlayDirect`.
    pub trajectory: TrajectoryData<'a>,
}

impl Default for Source<'_> {
    /// Source without passwords and move.
    fn default() -> Self {
        let none = Password(&[]);
        Self { user_password: none, new_password: none, trajectory: TrajectoryData::default() }
    }
}

impl Transmit<'_> {
    /// Returns the same if it can be kept; `None` if it lends the password that the device told.
    #[must_use]
    pub const fn to_static(&self) -> Option<Transmit<'static>> {
        Some(match *self {
            Self::UserPassword(PasswordOf::Device(_)) => return None,
            Self::UserPassword(PasswordOf::User) => Transmit::UserPassword(PasswordOf::User),
            Self::UserPassword(PasswordOf::New) => Transmit::UserPassword(PasswordOf::New),
            Self::Discover => Transmit::Discover,
            Self::KeepAlive => Transmit::KeepAlive,
            Self::Get(get) => Transmit::Get(get),
            Self::DevicePassword => Transmit::DevicePassword,
            Self::Trajectory => Transmit::Trajectory,
            Self::Leds { master, slave } => Transmit::Leds { master, slave },
            Self::Platform(platform) => Transmit::Platform(platform),
            Self::ResetDevice => Transmit::ResetDevice,
            Self::ResetAxis(motor) => Transmit::ResetAxis(motor),
            Self::MarkBegin(motor) => Transmit::MarkBegin(motor),
            Self::MarkEnd(motor) => Transmit::MarkEnd(motor),
            Self::Setup { delay_return } => Transmit::Setup { delay_return },
            Self::Start => Transmit::Start,
            Self::StopPlayback => Transmit::StopPlayback,
            Self::RapidToFirstKeyFrame => Transmit::RapidToFirstKeyFrame,
            Self::TakePicture(exposure) => Transmit::TakePicture(exposure),
            Self::MoveTo(go) => Transmit::MoveTo(go),
            Self::Bump(go) => Transmit::Bump(go),
        })
    }
}

impl<'a> Transmit<'a> {
    /// Conduct of the message: what it does, and whether it may be sent again.
    #[must_use]
    pub fn conduct(&self) -> Conduct {
        self.message(&Source::default()).conduct()
    }

    /// Message to encode, with what `source` has for it.
    #[must_use]
    pub fn message<'s>(&self, source: &Source<'s>) -> HostMessage<'s>
    where
        'a: 's,
    {
        let tail = &[][..];
        match *self {
            Self::Discover => GetNetworkInfo::new(true).into(),
            Self::KeepAlive => KeepAlive::default().into(),
            Self::Get(get) => get.message(),
            Self::UserPassword(of) => {
                let password = match of {
                    PasswordOf::Device(password) => password,
                    PasswordOf::User => source.user_password,
                    PasswordOf::New => source.new_password,
                };
                UserPassword { password, tail }.into()
            }
            Self::DevicePassword => DevicePassword { password: source.new_password, tail }.into(),
            Self::Trajectory => source.trajectory.into(),
            Self::Leds { master, slave } => LEDStatus { master_status: master, slave_status: slave, tail }.into(),
            Self::Platform(platform) => SoftwareID { platform, tail }.into(),
            Self::ResetDevice => ResetDevice::default().into(),
            Self::ResetAxis(motor_address) => ResetAxis { motor_address, tail }.into(),
            Self::MarkBegin(motor_address) => MarkBeginPosition { motor_address, tail }.into(),
            Self::MarkEnd(motor_address) => MarkEndPosition { motor_address, tail }.into(),
            // Direction 0, because the specification asks for it (decision K-J7).
            Self::Setup { delay_return } => {
                SetupPlayback { delay_return: delay_return.into(), ..SetupPlayback::default() }.into()
            }
            Self::Start => StartPlayback::default().into(),
            Self::StopPlayback => StopPlayback::default().into(),
            Self::RapidToFirstKeyFrame => RapidToFirstKeyFrame::default().into(),
            Self::TakePicture(exposure) => TakePicture { motor_address: MotorAddress::ALL, exposure, tail }.into(),
            Self::MoveTo(Go { motor, position, speed, acceleration }) => {
                SetPositionSpeedAcceleration::move_to(motor, position, speed, acceleration).into()
            }
            Self::Bump(Go { motor, position, speed, acceleration }) => {
                let (motor_address, delta) = (motor, position);
                BumpPositionSpeedAcceleration { motor_address, delta, speed, acceleration, tail }.into()
            }
        }
    }
}

impl Get {
    /// Message of the question.
    fn message<'a>(self) -> HostMessage<'a> {
        match self {
            Self::NetworkInfo => GetNetworkInfo { limited_response: Some(Bool::FALSE), tail: &[] }.into(),
            Self::LedStatus => GetLEDStatus::default().into(),
            Self::MotorInfo => GetMotorInfo::default().into(),
            Self::DeviceInfo => GetDeviceInfo::default().into(),
            Self::TrajectoryData => GetTrajectoryData::default().into(),
            Self::DeviceGuid => GetDeviceGUID::default().into(),
            Self::SoftwareId => GetSoftwareID::default().into(),
        }
    }
}
