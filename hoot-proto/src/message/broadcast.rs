//! Broadcasts, which all nodes execute at once, and which no node answers.
//!
//! Numbers of broadcasts are not those of the controller. Every node with USB or Bluetooth is a bridge. Through a
//! bridge, broadcasts reach only the attached node (safety decision 4).

use super::sub::{AnySubAddress, sub_messages};
use crate::frame::Address;

sub_messages! {
    /// Starts or resumes the planned moves of all nodes. Source: hoot, section 2.5.
    pub struct BroadcastStart for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Stops everything in all nodes. Source: hoot, section 2.5.
    pub struct BroadcastStop for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Pauses the planned moves of all nodes. Source: hoot, section 2.5.
    pub struct BroadcastPause for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// Gives all nodes the same address.
    ///
    /// Only one node may be on the bus, because all nodes take the address. Afterwards a node receives nothing for
    /// about 2.5 s, and its USB port keeps the old address until the node is restarted. Source: hoot, section 2.5;
    /// safety decision 5.
    pub struct BroadcastAssignAddress for /** Of no meaning. */ sub_address: AnySubAddress {
        /// New address, 2 to 255. Nodes ignore 0 and 1.
        new_address: Address,
    }
}

impl BroadcastAssignAddress {
    /// Makes the message; `None` unless the address is 2 to 255.
    #[must_use]
    pub const fn new(new_address: Address) -> Option<Self> {
        if new_address.is_node() { Some(Self { sub_address: AnySubAddress(0), new_address }) } else { None }
    }
}
