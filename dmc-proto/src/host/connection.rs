//! States of a connection: DMC D5.

use motion_core::states;
use motion_core::time::Millis;

use crate::message::Hi;

states! {
    /// State of a connection.
    #[non_exhaustive]
    pub enum State {
        /// There is no link.
        Offline,
        /// The device is asked who it is.
        Greeting,
        /// The device does not say who it is.
        Silent,
        /// The application configures the device.
        Configuring,
        /// Everything can be sent.
        Ready,
    }
}

/// State of a connection, with all that belongs to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Connection {
    Offline,
    /// Number of greetings that were sent, and until when the last one may be answered.
    Greeting(u8, Millis),
    Silent,
    /// Whether the application said that it is done.
    Configuring(bool),
    Ready,
}

impl Connection {
    pub(super) const fn state(self) -> State {
        match self {
            Self::Offline => State::Offline,
            Self::Greeting(..) => State::Greeting,
            Self::Silent => State::Silent,
            Self::Configuring(_) => State::Configuring,
            Self::Ready => State::Ready,
        }
    }
}

/// The greeting without the bytes after its fields, so that it borrows nothing.
pub(super) const fn without_tail(hi: &Hi<'_>) -> Hi<'static> {
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
