//! Transports of kOS.

/// Transport of a connection between client and device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
pub enum Transport {
    /// TCP stream in a network. The password locks it.
    Tcp,
    /// Reports over USB. The password never locks them (decision K-U7).
    Usb,
}

motion_core::display! {
    Transport {
        Tcp => "TCP";
        Usb => "USB";
    }
}
