//! Options of a master: its nodes, and its times.

use crate::frame::Address;
use crate::query::Profile;

/// Number of nodes that an emergency stop can address one by one.
pub const MAX_NODES: usize = 8;

/// List of the nodes of a rig, in the order in which an emergency stop addresses them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Nodes {
    /// Addresses; those after the first `len` are 0.
    list: [Address; MAX_NODES],
    len: usize,
}

impl Nodes {
    /// The empty list.
    pub const NONE: Self = Self { list: [Address::MASTER; MAX_NODES], len: 0 };
    /// List of the node at [`Address::DEFAULT`], which is the address of every new node.
    pub const DEFAULT: Self = {
        let none = Address::MASTER;
        Self { list: [Address::DEFAULT, none, none, none, none, none, none, none], len: 1 }
    };

    /// Returns the list with one more node; `None` if the list is full, or if no node can have that address. Adding a node
    /// again changes nothing.
    #[must_use]
    pub fn with(mut self, node: Address) -> Option<Self> {
        if !node.is_node() {
            return None;
        }
        if !self.as_slice().contains(&node) {
            *self.list.get_mut(self.len)? = node;
            self.len = self.len.saturating_add(1);
        }
        Some(self)
    }

    /// Addresses of the nodes, in order.
    #[must_use]
    pub fn as_slice(&self) -> &[Address] {
        self.list.get(..self.len).unwrap_or(&self.list)
    }
}

impl Default for Nodes {
    fn default() -> Self {
        Self::DEFAULT
    }
}

motion_core::options! {
    /// Options of a master. All times are in milliseconds.
    pub struct Options {
        /// Time to wait for an answer. Public clients wait 500 ms; a node should begin within 100 ms (hoot, sections 1.1
        /// and 5). The answer to a message that blocks its node is awaited for as long as it blocks.
        ///
        /// A stop without an answer is repeated after this time. If somebody else has just started the program of the node,
        /// which the master cannot know, the node hears nothing for 1.5 s, and the repeated stop hangs it. With 3000 no stop
        /// is repeated so early, but a stop that was lost comes 3 s late. An emergency stop sends several stops in any case
        /// (decision H-41).
        timeout with_timeout: u32 = 500, in 1..=u32::MAX;
        /// Time to wait for an answer whose absence is usual or must not delay the next stop: to a stop in an emergency, to
        /// a keep-alive, and to the speed of a joystick (decision H-22).
        short_timeout with_short_timeout: u32 = 150, in 1..=u32::MAX;
        /// Least time between two packets; public clients leave 40 to 90 ms (hoot, section 5).
        gap with_gap: u32 = 60, in 1..=u32::MAX;
        /// Time to listen after an answer, because some requests are answered twice (hoot, section 5).
        settle with_settle: u32 = 40, in 1..=u32::MAX;
        /// Time to listen for late answers after a silence, and after the line came up, so that they are not taken for
        /// answers to the next request. It is never less than timeout and gap together. With the default, answers may
        /// come 1400 ms after their request (decisions H-18 and H-40).
        drain with_drain: u32 = 900, in 1..=u32::MAX;
        /// Number of times to repeat a message that is not answered and may be repeated (hoot, section 5).
        retries with_retries: u8 = 2;
        /// Time without a packet after which a node in [`Command::KeepAlive`](super::Command::KeepAlive) is asked. One
        /// question may be lost before the dead-man of the node stops it after a second (hoot, section 4.3; decision H-25).
        keep_alive with_keep_alive: u32 = 400, in 1..=u32::MAX;
        /// Whether the bus is behind a bridge, which is the USB or Bluetooth port of a node. The default is the safe
        /// reading (safety decision 4).
        bridge with_bridge: bool = true;
        /// Firmware of the nodes.
        profile with_profile: Profile = Profile::UNKNOWN;
        /// Nodes that an emergency stop addresses: list all nodes of the rig. A broadcast counts as sent to these nodes.
        nodes with_nodes: Nodes = Nodes::DEFAULT;
    }
}
