//! Messages of the core protocol: command 1 of every part of a node, whose first data byte selects a command of this
//! protocol.
//!
//! Ask its queries to find out whether a node is there. Do not send command 0 for that, because nodes do not answer it.

use super::sub::{AnySubAddress, sub_messages};
use crate::frame::Address;

sub_messages! {
    /// Does nothing. No node answers it, and no bridge forwards it, so it does not find out whether a node is there.
    ///
    /// Source: hoot, section 1.
    pub struct Noop for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Asks for the version of the core protocol. The answer is a [`CoreVersion`](super::CoreVersion), which is 1.
    ///
    /// Source: hoot, section 1.
    pub struct CoreProtocolVersion for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Asks for the kind of the device. The answer is a [`Text`](super::Text) of eight bytes, `OMAXISVX`. Source: hoot,
    /// section 1.
    pub struct CoreDeviceId for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Asks for the version of the device. The answer is a [`CoreVersion`](super::CoreVersion), 6 in the sheet's
    /// firmware.
    ///
    /// Source: hoot, section 1.
    pub struct CoreDeviceVersion for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Gives the node another address.
    ///
    /// The answer comes after the change. Never repeat it by yourself: ask at the new address instead. Firmware does
    /// not check the address, and accepts 0 and 1 too. Source: hoot, section 1; safety decisions 1 and 5.
    pub struct CoreAssignAddress for /** Of no meaning. */ sub_address: AnySubAddress {
        /// New address, 2 to 255.
        new_address: Address,
    }
}

impl CoreAssignAddress {
    /// Makes the message; `None` unless the address is 2 to 255.
    #[must_use]
    pub const fn new(new_address: Address) -> Option<Self> {
        if new_address.is_node() { Some(Self { sub_address: AnySubAddress(0), new_address }) } else { None }
    }
}
