//! The core protocol: command 1 of every part of a node, with commands of its own in the first byte of its data.
//!
//! Its queries are what to ask to learn whether a node is there; command 0 is not, since nodes are silent at it.

use super::sub::{AnySubAddress, sub_messages};
use crate::frame::Address;

sub_messages! {
    /// Nothing. No node answers it, and no bridge passes it on: it is no way to find out whether a node is there.
    ///
    /// Source: hoot, section 1.
    pub struct Noop for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Which version of the core protocol do you speak? Asks for a [`CoreVersion`](super::CoreVersion), which is 1.
    ///
    /// Source: hoot, section 1.
    pub struct CoreProtocolVersion for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// What are you? Asks for a [`Text`](super::Text) of eight bytes, `OMAXISVX`. Source: hoot, section 1.
    pub struct CoreDeviceId for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Which version are you of? Asks for a [`CoreVersion`](super::CoreVersion), 6 in the sheet's firmware.
    ///
    /// Source: hoot, section 1.
    pub struct CoreDeviceVersion for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Take this address.
    ///
    /// The answer comes after the change. Not to be sent again by itself: ask at the new address instead. The firmware
    /// does not look at the address, and takes 0 and 1 too. Source: hoot, section 1; safety decisions 1 and 5.
    pub struct CoreAssignAddress for /** Of no meaning. */ sub_address: AnySubAddress {
        /// The new address, 2 to 255.
        new_address: Address,
    }
}

impl CoreAssignAddress {
    /// Take this address; `None` unless it is 2 to 255.
    #[must_use]
    pub const fn new(new_address: Address) -> Option<Self> {
        if new_address.is_node() { Some(Self { sub_address: AnySubAddress(0), new_address }) } else { None }
    }
}
