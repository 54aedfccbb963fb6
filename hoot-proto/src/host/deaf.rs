//! Nodes that may be deaf: decision H-41.
//!
//! A node hears nothing while it carries out certain messages ([`Conduct::blocks`](crate::Conduct::blocks)). If two packets
//! wait at it meanwhile, its firmware hangs until the power is cycled. So a node that may be deaf is sent one packet at most:
//! the stop of its controller, or on a bus without a bridge the stop of all nodes. After the line came up, the packet may be
//! a query. The next packet is sent when the node has answered, or 3 s after the one before.
//!
//! A start is answered when its block is over. So after the line came up, an answer without a value may be that to a start of
//! somebody else, until the nodes have answered a query.

use arrayvec::ArrayVec;
use motion_core::time::Millis;

use super::{Nodes, Transmit};
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

/// Address that the receivers of a message get.
const fn new_address(message: &HostMessage<'_>) -> Option<Address> {
    match message {
        HostMessage::SetAddress(set) => Some(set.new_address),
        HostMessage::CoreAssignAddress(assign) => Some(assign.new_address),
        HostMessage::BroadcastAssignAddress(assign) => Some(assign.new_address),
        _ => None,
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

/// Whether two packets, or a packet and a node, may have to do with the same node.
fn meet(one: Address, other: Address) -> bool {
    one == other || one == Address::BROADCAST || other == Address::BROADCAST
}

/// A packet that may wait at a node that may be deaf.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Waits {
    /// Address of the packet, and the other address of the same node if it gets another one.
    at: [Address; 2],
    /// Time at which the node has read the packet.
    until: Millis,
}

/// Number of packets that may wait at nodes that may be deaf. One more is not sent.
const MAX_WAITING: usize = 16;

/// Nodes that may be deaf.
#[derive(Clone, PartialEq, Eq, Hash, Default)]
pub(super) struct Deaf {
    /// Time at which all nodes hear again; `None` if they hear now.
    until: Option<Millis>,
    nodes: Addresses,
    /// Whether a command of this master is a reason. Otherwise it is that the line came up.
    by_command: bool,
    /// Both addresses of the node that gets another one.
    renamed: Option<[Address; 2]>,
    waiting: ArrayVec<Waits, MAX_WAITING>,
    /// Time until which a node may answer a command of somebody else from before the line came up.
    foreign_until: Option<Millis>,
}

motion_core::debug! { Deaf { until nodes by_command renamed waiting foreign_until } }

impl Deaf {
    fn extend(&mut self, until: Millis) {
        self.until = Some(self.until.map_or(until, |before| before.max(until)));
    }

    /// The line came up. A node may be deaf because of a command of somebody else.
    pub(super) fn link_up(&mut self, now: Millis) {
        self.foreign_until = Some(now.after(LONGEST.into()));
        self.extend(now.after(LONGEST.into()));
        self.nodes = Addresses::ALL;
    }

    /// Whether the answer to a packet that asks for no value may be that to a start of somebody else: the receiver, or a
    /// listed node, has not answered since the line came up.
    pub(super) fn may_answer_others(&self, nodes: &Nodes, to: Address) -> bool {
        self.foreign_until.is_some() && nodes.as_slice().iter().chain([&to]).any(|node| self.is_deaf(*node))
    }

    /// A packet goes out, or was answered, because of which its receivers may be deaf from now on.
    pub(super) fn begins(&mut self, now: Millis, Transmit { to, message }: &Transmit) {
        self.extend(now.after(blocks(message).into()));
        self.by_command = true;
        let new_address = new_address(message);
        self.renamed = new_address.map(|new_address| [*to, new_address]).or(self.renamed);
        if *to == Address::BROADCAST {
            self.nodes = Addresses::ALL;
        }
        for address in new_address.into_iter().chain([*to]) {
            self.nodes.set(address, true);
        }
    }

    /// A packet goes out. If its node is deaf, the node reads it when the longest time is over.
    pub(super) fn sent(&mut self, now: Millis, to: Address) {
        if self.is_deaf(to) {
            let at = self.both(to);
            // There is room, because nothing else is allowed.
            let _ = self.waiting.try_push(Waits { at, until: now.after(LONGEST.into()) });
        }
    }

    /// A node has answered, so it hears.
    pub(super) fn hears(&mut self, node: Address) {
        for address in self.both(node).into_iter().chain([node]) {
            self.nodes.set(address, false);
        }
        self.waiting.retain(|waits| !waits.at.contains(&node));
        if self.nodes.is_empty() {
            *self = Self::default();
        }
    }

    /// Addresses of a node. A packet to all nodes waits at each of them.
    fn both(&self, node: Address) -> [Address; 2] {
        self.renamed.filter(|both| both.contains(&node) || both.contains(&Address::BROADCAST)).unwrap_or([node; 2])
    }

    pub(super) fn expire(&mut self, now: Millis) {
        self.waiting.retain(|waits| now < waits.until);
        self.foreign_until = self.foreign_until.filter(|until| now < *until);
        if self.until.is_some_and(|until| now >= until) {
            *self = Self::default();
        }
    }

    /// Time at which a node hears again, or has read a packet.
    pub(super) fn until(&self) -> Option<Millis> {
        self.waiting.iter().map(|waits| waits.until).chain(self.until).chain(self.foreign_until).min()
    }

    /// Whether a node may be deaf; for [`Address::BROADCAST`], whether any may be.
    pub(super) fn is_deaf(&self, node: Address) -> bool {
        if node == Address::BROADCAST { !self.nodes.is_empty() } else { self.nodes.contains(node) }
    }

    /// Whether a packet may wait at a node that may be deaf: the stop of the controller or of all nodes. If it is only not
    /// known what the nodes did before the line came up, a query may wait too.
    fn may_wait(&self, message: &HostMessage<'_>) -> bool {
        let is_stop = matches!(message, HostMessage::Stop(_) | HostMessage::BroadcastStop(_));
        is_stop || message.query().is_some() && !self.by_command
    }

    /// Whether a packet may be sent as it is. A node becomes deaf only if no packet waits for it, and one node at a time gets
    /// another address.
    pub(super) fn allows(&self, Transmit { to, message }: &Transmit) -> bool {
        let waits = self.waiting.iter().any(|waits| waits.at.iter().any(|at| meet(*at, *to)));
        if self.is_deaf(*to) {
            self.may_wait(message) && !waits && !self.waiting.is_full()
        } else {
            blocks(message) == 0 || !waits && (self.renamed.is_none() || new_address(message).is_none())
        }
    }

    /// Packet to send now in order to stop what a stop stops: the stop itself, or that of the controller if its node may be
    /// deaf; `None` if a packet waits there already.
    pub(super) fn stop_for(&self, stop: &Transmit) -> Option<Transmit> {
        let of_controller = Transmit { to: stop.to, message: message::Stop {}.into() };
        let first = if stop.to == Address::BROADCAST { *stop } else { of_controller };
        [*stop, first].into_iter().find(|transmit| self.allows(transmit))
    }

    pub(super) fn set_back(&mut self, by: Millis) {
        let waiting = self.waiting.iter_mut().map(|waits| &mut waits.until);
        for until in waiting.chain(&mut self.until).chain(&mut self.foreign_until) {
            *until = Millis(until.since(by));
        }
    }
}
