//! Errors of drivers on an operating system.

use std::io;
use std::string::{String, ToString};

use motion_core::wire::EncodeError;

/// Error of a driver.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A line or a socket cannot be opened, or the socket cannot send a datagram.
    #[error("{what}: {why}")]
    NotOpened {
        /// Address, path or name of the line.
        what: String,
        /// Reason, and what a person can do.
        why: String,
    },
    /// The line was open, and is lost.
    #[error("{what} is gone: {why}")]
    Lost {
        /// Name of the line.
        what: String,
        /// Reason, and what a person can do.
        why: String,
    },
    /// A message cannot be written. It is lost, and the session goes on.
    #[error("a message cannot be written: {0}")]
    Message(EncodeError),
}

impl Error {
    /// Error of a line with this name that cannot be opened.
    pub(crate) fn not_opened(what: &str, why: impl Into<String>) -> Self {
        Self::NotOpened { what: what.into(), why: why.into() }
    }

    /// Error of opening a TCP connection.
    pub(crate) fn tcp(address: &str, error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::ConnectionRefused => {
                Self::not_opened(address, "nothing listens there: is the rig on, and is this its port?")
            }
            io::ErrorKind::TimedOut => Self::not_opened(address, "no answer: is the rig on and in this network?"),
            _ => Self::not_opened(address, error.to_string()),
        }
    }

    /// Error of a socket that cannot listen, or cannot send a datagram.
    #[cfg(feature = "kos")]
    pub(crate) fn socket(address: &str, error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::AddrInUse => {
                Self::not_opened(address, "the port is in use: does another program listen there?")
            }
            _ => Self::not_opened(address, error.to_string()),
        }
    }

    /// Error of opening a serial port.
    #[cfg(any(feature = "serialport", feature = "tokio-serial"))]
    pub(crate) fn serial(path: &str, error: &dyn core::fmt::Display) -> Self {
        Self::not_opened(path, std::format!("{error}: is the rig plugged in, and the port not in use?"))
    }
}
