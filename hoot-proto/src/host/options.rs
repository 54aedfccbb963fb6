//! What a master knows and how patient it is.

use crate::frame::Address;
use crate::query::Profile;
use crate::state::debug;

/// Nodes that an emergency stop can address one by one.
pub const MAX_NODES: usize = 8;

/// The nodes of a rig: those that an emergency stop addresses, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Nodes {
    list: [Address; MAX_NODES],
    /// How many of them count; the others are 0.
    len: usize,
}

impl Nodes {
    /// None.
    pub const NONE: Self = Self { list: [Address::MASTER; MAX_NODES], len: 0 };

    /// These and one more; `None` if there are too many, or no node can have that address. Twice is once.
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

    /// Their addresses, in order.
    #[must_use]
    pub fn as_slice(&self) -> &[Address] {
        self.list.get(..self.len).unwrap_or(&self.list)
    }
}

impl Default for Nodes {
    /// The one at [`Address::DEFAULT`].
    fn default() -> Self {
        Self::NONE.with(Address::DEFAULT).unwrap_or(Self::NONE)
    }
}

/// How a master behaves. All times are milliseconds.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Options {
    /// How long to wait for an answer. Default: 500, as public clients do; a node should begin within 100 (hoot,
    /// sections 1.1 and 5).
    pub timeout: u32,
    /// How long to wait for the answer to a start. Default: 3000 (safety decision 1).
    pub start_timeout: u32,
    /// How long to wait where silence is no surprise, or must not hold up the next stop: for the stops of an emergency,
    /// keep-alives and the speeds of a joystick. Default: 150 (decision H-22).
    pub short_timeout: u32,
    /// How far apart packets are sent at least. Default: 60, between the 40 and 90 of public clients (hoot, section 5).
    pub gap: u32,
    /// How long to listen behind an answer, for some requests are answered twice. Default: 40 (hoot, section 5).
    pub settle: u32,
    /// How long to listen for late answers behind a silence, so that they are not taken for answers to what is asked
    /// next. Default: 200 (decision H-18).
    pub drain: u32,
    /// How often to ask again. Default: 2 (hoot, section 5).
    pub retries: u8,
    /// How long to be quiet when addresses have changed. Default: 2600, since nodes blink for 2.5 s (hoot, section 5).
    pub deaf: u32,
    /// How long a node in [`Command::KeepAlive`](super::Command::KeepAlive) is left alone. Default: 400, so that one may
    /// be lost before its dead-man stops it after a second (hoot, section 4.3; decision H-25).
    pub keep_alive: u32,
    /// Whether the bus is behind a bridge: a node's USB or Bluetooth. Default: yes, the safe reading (safety decision 4).
    pub bridge: bool,
    /// The firmware of the nodes. Default: not known.
    pub profile: Profile,
    /// The nodes that an emergency stop addresses. Default: the one at [`Address::DEFAULT`], where every new node is.
    pub nodes: Nodes,
}

debug! { Options { timeout start_timeout short_timeout gap settle drain retries deaf keep_alive bridge profile nodes } }

impl Default for Options {
    fn default() -> Self {
        Self {
            timeout: 500,
            start_timeout: 3000,
            short_timeout: 150,
            gap: 60,
            settle: 40,
            drain: 200,
            retries: 2,
            deaf: 2600,
            keep_alive: 400,
            bridge: true,
            profile: Profile::Unknown,
            nodes: Nodes::default(),
        }
    }
}

/// Makes the builders of times, each at least a millisecond, so that no machine waits for a moment that is now.
macro_rules! times {
    ($($(#[$meta:meta])* $with:ident $field:ident)*) => {
        impl Options {$(
            $(#[$meta])*
            #[must_use]
            pub const fn $with(self, $field: u32) -> Self {
                Self { $field: if $field == 0 { 1 } else { $field }, ..self }
            }
        )*}
    };
}
times! {
    /// The same with another [`timeout`](Self::timeout), at least 1.
    with_timeout timeout
    /// The same with another [`start_timeout`](Self::start_timeout), at least 1.
    with_start_timeout start_timeout
    /// The same with another [`short_timeout`](Self::short_timeout), at least 1.
    with_short_timeout short_timeout
    /// The same with another [`gap`](Self::gap), at least 1.
    with_gap gap
    /// The same with another [`settle`](Self::settle), at least 1.
    with_settle settle
    /// The same with another [`drain`](Self::drain), at least 1.
    with_drain drain
    /// The same with another [`deaf`](Self::deaf), at least 1.
    with_deaf deaf
    /// The same with another [`keep_alive`](Self::keep_alive), at least 1.
    with_keep_alive keep_alive
}

impl Options {
    /// The same with another number of [`retries`](Self::retries).
    #[must_use]
    pub const fn with_retries(self, retries: u8) -> Self {
        Self { retries, ..self }
    }

    /// The same behind a bridge, or on the bus itself.
    #[must_use]
    pub const fn with_bridge(self, bridge: bool) -> Self {
        Self { bridge, ..self }
    }

    /// The same for nodes with this firmware.
    #[must_use]
    pub const fn with_profile(self, profile: Profile) -> Self {
        Self { profile, ..self }
    }

    /// The same with other nodes that an emergency stop addresses.
    #[must_use]
    pub const fn with_nodes(self, nodes: Nodes) -> Self {
        Self { nodes, ..self }
    }
}
