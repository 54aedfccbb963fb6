//! Broadcasts: what all nodes do at once, and none of them answers.
//!
//! Their numbers are not those of the controller. Through a bridge, which every node with USB or Bluetooth is, only the
//! attached node sees them (safety decision 4).

use super::sub::{AnySubAddress, sub_messages};
use crate::frame::Address;

sub_messages! {
    /// All nodes: start or resume the planned moves. Source: hoot, section 2.5.
    pub struct BroadcastStart for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// All nodes: stop everything. Source: hoot, section 2.5.
    pub struct BroadcastStop for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// All nodes: pause the planned moves. Source: hoot, section 2.5.
    pub struct BroadcastPause for /** Of no meaning. */ sub_address: AnySubAddress {}

    /// All nodes: take this address.
    ///
    /// Only one node may be on the bus, or all take the same address. A node is deaf for some 2.5 s afterwards; its USB
    /// port keeps the old address until it is restarted. Source: hoot, section 2.5; safety decision 5.
    pub struct BroadcastAssignAddress for /** Of no meaning. */ sub_address: AnySubAddress {
        /// The new address, 2 to 255. Nodes ignore 0 and 1.
        new_address: Address,
    }
}

impl BroadcastAssignAddress {
    /// All nodes take this address; `None` unless it is 2 to 255.
    #[must_use]
    pub const fn new(new_address: Address) -> Option<Self> {
        if new_address.is_node() { Some(Self { sub_address: AnySubAddress(0), new_address }) } else { None }
    }
}
