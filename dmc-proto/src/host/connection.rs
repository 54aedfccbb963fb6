//! How far a connection is: DMC D5.

use motion_core::time::Millis;

use crate::message::Hi;

/// How far a connection is, for those who look at it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum State {
    /// The line is not open.
    Closed,
    /// The device is asked who it is.
    Greeting,
    /// The device does not say who it is.
    Silent,
    /// The application configures the device.
    Configuring,
    /// Everything can be sent.
    Up,
}

impl State {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Closed, Self::Greeting, Self::Silent, Self::Configuring, Self::Up];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Closed => "Closed",
            Self::Greeting => "Greeting",
            Self::Silent => "Silent",
            Self::Configuring => "Configuring",
            Self::Up => "Up",
        }
    }
}

/// How far a connection is, with all that belongs to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Connection {
    Closed,
    /// How many greetings were sent, and until when the last one may be answered.
    Greeting(u8, Millis),
    Silent,
    /// Whether the application says that it is done.
    Configuring(bool),
    Up,
}

impl Connection {
    pub(super) const fn state(self) -> State {
        match self {
            Self::Closed => State::Closed,
            Self::Greeting(..) => State::Greeting,
            Self::Silent => State::Silent,
            Self::Configuring(_) => State::Configuring,
            Self::Up => State::Up,
        }
    }
}

/// What can be kept of a greeting: all but what is behind its fields.
pub(super) fn kept(hi: &Hi<'_>) -> Hi<'static> {
    let Hi { name, fw_major, fw_minor, fw_rev, motor_count, dmx_count, gio_out_count, gio_in_count, .. } = *hi;
    let Hi { hw_limit_count, upload_frame_count, capabilities, protocol_version, .. } = *hi;
    Hi {
        name,
        fw_major,
        fw_minor,
        fw_rev,
        motor_count,
        dmx_count,
        gio_out_count,
        gio_in_count,
        hw_limit_count,
        upload_frame_count,
        capabilities,
        protocol_version,
        tail: &[],
    }
}
