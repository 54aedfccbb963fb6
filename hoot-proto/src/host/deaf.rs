//! Nodes that may be deaf: decision H-41.
//!
//! A node hears nothing while it carries out certain messages ([`Conduct::blocks`](crate::Conduct::blocks)). If two packets
//! wait at it meanwhile, its firmware hangs until the power is cycled. So a node that may be deaf is sent one packet at most:
//! the stop of its controller, or on a bus without a bridge the stop of all nodes.

use motion_core::time::Millis;

use super::Transmit;
use crate::frame::{Address, Table};
use crate::message::{self, HostMessage};

/// Longest time for which any node is deaf, in milliseconds.
const LONGEST: u16 = 3000;

/// Longest time for which the receivers of a message may be deaf because of it, in milliseconds. A command without a type
/// may do what any other does.
pub(super) fn blocks(message: &HostMessage<'_>) -> u16 {
    let selector = message.selector();
    let may_be_any = selector.table == Table::Broadcast || selector.table == Table::Node && selector.command < 100;
    match message {
        HostMessage::Other(_) if may_be_any => LONGEST,
        message => message.conduct().blocks,
    }
}

/// Set of addresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
struct Addresses([u32; 8]);

impl Addresses {
    const ALL: Self = Self([u32::MAX; 8]);

    fn place(address: Address) -> (usize, u32) {
        (usize::from(address.0 / 32), 1_u32.rotate_left(u32::from(address.0 % 32)))
    }

    fn contains(&self, address: Address) -> bool {
        let (word, bit) = Self::place(address);
        self.0.get(word).is_some_and(|bits| bits & bit != 0)
    }

    fn set(&mut self, address: Address, is_in: bool) {
        let (word, bit) = Self::place(address);
        if let Some(bits) = self.0.get_mut(word) {
            *bits = if is_in { *bits | bit } else { *bits & !bit };
        }
    }

    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Why nodes may be deaf.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
enum Cause {
    /// Nobody knows what the nodes did before the line came up.
    #[default]
    LinkUp,
    /// A command to a node, or to all nodes.
    Command(Address),
}

/// Nodes that may be deaf.
#[derive(Clone, PartialEq, Eq, Hash, Default)]
pub(super) struct Deaf {
    /// Time at which all nodes hear again; `None` if they hear now.
    until: Option<Millis>,
    cause: Cause,
    nodes: Addresses,
    /// Nodes of these at which a stop of the controller waits.
    stopped: Addresses,
    /// Whether a stop waits at each of them: that of all nodes, or that of the only node behind these addresses.
    is_all_stopped: bool,
    /// Whether all these addresses are those of one node, because it gets another one.
    is_one: bool,
}

motion_core::debug! { Deaf { until cause nodes stopped is_all_stopped is_one } }

impl Deaf {
    /// The line came up. A node may still be deaf because of a command of somebody else. Only the number of stops is limited
    /// then.
    pub(super) fn link_up(&mut self, now: Millis) {
        let until = now.after(LONGEST.into());
        self.until = Some(self.until.map_or(until, |before| before.max(until)));
        self.nodes = Addresses::ALL;
    }

    /// A packet goes out, or was answered, because of which its receivers may be deaf from now on.
    pub(super) fn begins(&mut self, now: Millis, Transmit { to, message }: &Transmit) {
        let until = Some(now.after(blocks(message).into()));
        let new_address = match message {
            HostMessage::SetAddress(set) => Some(set.new_address),
            HostMessage::CoreAssignAddress(assign) => Some(assign.new_address),
            HostMessage::BroadcastAssignAddress(assign) => Some(assign.new_address),
            _ => None,
        };
        *self = Self { until, cause: Cause::Command(*to), is_one: new_address.is_some(), ..Self::default() };
        if *to == Address::BROADCAST {
            self.nodes = Addresses::ALL;
        }
        for address in new_address.into_iter().chain([*to]) {
            self.nodes.set(address, true);
        }
    }

    /// A stop goes out.
    pub(super) fn stops(&mut self, to: Address) {
        if to == Address::BROADCAST || self.is_one {
            self.is_all_stopped |= self.is_deaf(to);
        } else if self.nodes.contains(to) {
            self.stopped.set(to, true);
        }
    }

    /// A node has answered, so it hears.
    pub(super) fn hears(&mut self, node: Address) {
        self.nodes.set(node, false);
        self.stopped.set(node, false);
        self.end_if_all_hear();
    }

    /// Every command and every stop has been answered, so the nodes hear to which they went.
    pub(super) fn all_answered(&mut self) {
        for (deaf, stopped) in self.nodes.0.iter_mut().zip(self.stopped.0) {
            *deaf &= !stopped;
        }
        self.stopped = Addresses::default();
        match self.cause {
            Cause::Command(to) if to != Address::BROADCAST => *self = Self::default(),
            _ => self.end_if_all_hear(),
        }
    }

    pub(super) fn expire(&mut self, now: Millis) {
        if self.until.is_some_and(|until| now >= until) {
            *self = Self::default();
        }
    }

    fn end_if_all_hear(&mut self) {
        if self.nodes.is_empty() {
            *self = Self::default();
        }
    }

    pub(super) const fn until(&self) -> Option<Millis> {
        self.until
    }

    /// Whether a node may be deaf; for [`Address::BROADCAST`], whether any may be.
    pub(super) fn is_deaf(&self, node: Address) -> bool {
        if node == Address::BROADCAST { !self.nodes.is_empty() } else { self.nodes.contains(node) }
    }

    /// Whether a stop waits at a node that may be deaf; for [`Address::BROADCAST`], at any.
    fn is_stopped(&self, node: Address) -> bool {
        let is_one = if node == Address::BROADCAST { !self.stopped.is_empty() } else { self.stopped.contains(node) };
        self.is_all_stopped || is_one
    }

    /// Whether a packet may be sent as it is.
    pub(super) fn allows(&self, Transmit { to, message }: &Transmit) -> bool {
        let is_the_stop = matches!(message, HostMessage::Stop(_) | HostMessage::BroadcastStop(_));
        let is_limited = message.conduct().is_stop() || self.cause != Cause::LinkUp;
        !self.is_deaf(*to) || !is_limited || is_the_stop && !self.is_stopped(*to)
    }

    /// Packet to send now in order to stop what a stop stops: the stop itself, or that of the controller if its node may be
    /// deaf; `None` if a stop waits there already.
    pub(super) fn stop_for(&self, stop: &Transmit) -> Option<Transmit> {
        let of_controller = Transmit { to: stop.to, message: message::Stop {}.into() };
        let first = if stop.to == Address::BROADCAST { *stop } else { of_controller };
        [*stop, first].into_iter().find(|transmit| self.allows(transmit))
    }

    pub(super) fn set_back(&mut self, by: Millis) {
        self.until = self.until.map(|until| Millis(until.since(by)));
    }
}
