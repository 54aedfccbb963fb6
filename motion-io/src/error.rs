//! Errors of drivers on an operating system.

use std::io;
use std::string::{String, ToString};

use motion_core::wire::EncodeError;

/// Error of a driver.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The line is gone, or cannot be opened.
    #[error("{what}: {why}")]
    Line {
        /// Address or path of a line that cannot be opened, or the name of a line with "is gone".
        what: String,
        /// Reason, and what a person can do.
        why: String,
    },
    /// A message cannot be written. It is lost, and the session goes on.
    #[error("a message cannot be written: {0}")]
    Message(EncodeError),
}

impl Error {
    /// Error of the line with this name.
    pub(crate) fn line(what: impl Into<String>, why: impl Into<String>) -> Self {
        Self::Line { what: what.into(), why: why.into() }
    }

    /// Error of opening a TCP connection.
    pub(crate) fn tcp(address: &str, error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::ConnectionRefused => {
                Self::line(address, "nothing listens there: is the rig on, and is this its port?")
            }
            io::ErrorKind::TimedOut => Self::line(address, "no answer: is the rig on and in this network?"),
            _ => Self::line(address, error.to_string()),
        }
    }

    /// Error of a socket that cannot listen, or cannot send a datagram.
    #[cfg(feature = "kos")]
    pub(crate) fn socket(address: &str, error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::AddrInUse => Self::line(address, "the port is in use: does another program listen there?"),
            _ => Self::line(address, error.to_string()),
        }
    }

    /// Error of opening a serial port.
    #[cfg(any(feature = "serialport", feature = "tokio-serial"))]
    pub(crate) fn serial(path: &str, error: &dyn core::fmt::Display) -> Self {
        Self::line(path, std::format!("{error}: is the rig plugged in, and the port not in use?"))
    }
}
