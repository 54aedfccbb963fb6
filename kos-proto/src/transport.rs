//! Transports of kOS.

/// Transport of a connection between client and device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Transport {
    /// Stream in a network, which the password locks.
    Tcp,
    /// Reports over USB, which are never locked (decision K-U7).
    Usb,
}
