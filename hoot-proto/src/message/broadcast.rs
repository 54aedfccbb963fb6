//! Broadcasts: what all nodes do at once, and none of them answers.
//!
//! Through a bridge, which every node with USB or Bluetooth is, only the attached node sees them (safety decision 4).

use motion_core::unit;
use motion_core::wire::Visitor;

use super::sub::{Sub, sub_messages};
use crate::frame::Address;

unit! {
    /// The sub-address of a broadcast: nodes ignore it, and it is kept as it came. Send 0.
    pub struct AnySubAddress(u8) "";
}

impl Sub for AnySubAddress {
    fn of(number: u32) -> Self {
        let [.., sub_address] = number.to_be_bytes();
        Self(sub_address)
    }

    fn byte(self) -> u8 {
        self.0
    }

    /// It says nothing.
    fn show(self, _: &mut dyn Visitor) {}
}

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
        address: Address,
    }
}

impl BroadcastAssignAddress {
    /// All nodes take this address; `None` unless it is 2 to 255.
    #[must_use]
    pub const fn new(address: Address) -> Option<Self> {
        if address.0 < 2 { None } else { Some(Self { sub_address: AnySubAddress(0), address }) }
    }
}
