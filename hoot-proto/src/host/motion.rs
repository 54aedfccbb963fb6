//! Knowledge of a master about what may still move because of it.

use core::fmt;

use super::{HostMachine, Nodes, StopTarget, Transmit};
use crate::frame::{Address, Table};
use crate::message::{HostMessage, Motor, Reply};
use crate::query::{Profile, Query};

/// Bit of the program of a node, which moves all motors.
const PROGRAM: u8 = 1;
/// Bits of everything in a node.
const ALL: u8 = 0b1111;

const fn bit(motor: Motor) -> u8 {
    match motor {
        Motor::One => 1 << 1,
        Motor::Two => 1 << 2,
        Motor::Three => 1 << 3,
    }
}

/// Bits of what a message moves or stops.
fn parts(message: &HostMessage<'_>) -> u8 {
    let selector = message.selector();
    match Motor::new(selector.sub_address) {
        Some(motor) if selector.table == Table::Node => bit(motor),
        _ => ALL,
    }
}

/// Motors, and programs that move them, of which it is not known that they rest: bits for each address.
///
/// The bits of [`Address::BROADCAST`] stand for all nodes, if a message to all nodes went out while no node was listed.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(super) struct Motion([u8; 256]);

impl Motion {
    pub(super) const NOTHING: Self = Self([0; 256]);

    fn any(&self) -> bool {
        self.0.iter().any(|parts| *parts != 0)
    }

    fn add(&mut self, nodes: &Nodes, to: Address, added: u8) {
        let (one, listed) = ([to], nodes.as_slice());
        let nodes = if to == Address::BROADCAST && !listed.is_empty() { listed } else { &one };
        for node in nodes {
            if let Some(parts) = self.0.get_mut(usize::from(node.0)) {
                *parts |= added;
            }
        }
    }

    /// A packet goes out.
    pub(super) fn sent(&mut self, nodes: &Nodes, Transmit { to, message }: &Transmit) {
        // Another acceleration starts nothing, and a motor that moves already has its bit.
        let starts_nothing = matches!(message, HostMessage::MotorSetContinuousAcceleration(_));
        if message.conduct().may_move() && !starts_nothing {
            self.add(nodes, *to, parts(message));
        }
    }

    /// A stop is not confirmed.
    pub(super) fn not_stopped(&mut self, nodes: &Nodes, target: StopTarget) {
        match target {
            StopTarget::All => self.add(nodes, Address::BROADCAST, ALL),
            StopTarget::Node(node) => self.add(nodes, node, ALL),
            StopTarget::Motor(node, motor) => self.add(nodes, node, bit(motor)),
        }
    }

    /// A node answered a message with OK.
    pub(super) fn answered(&mut self, profile: Profile, Transmit { to, message }: &Transmit, reply: Reply<'_>) {
        let Some(moving) = self.0.get_mut(usize::from(to.0)) else { return };
        let rests = match message {
            HostMessage::Stop(_) | HostMessage::Pause(_) => ALL,
            HostMessage::MotorStop(stop) => bit(stop.motor),
            HostMessage::MotorRunning(query) if query.decode_reply(reply).is_ok_and(|runs| !runs.value.get()) => {
                bit(query.motor)
            }
            HostMessage::RunStatus(query)
                if query.decode_reply(reply).is_ok_and(|state| state.value.is_running(profile) == Some(false)) =>
            {
                PROGRAM
            }
            _ => 0,
        };
        // A program may move a motor again that rests now.
        let stays = if *moving & PROGRAM != 0 && rests & PROGRAM == 0 { 0 } else { rests };
        *moving &= !stays;
    }

    /// All motors of the listed nodes rest. Programs have stopped too, if every stop was answered by an OK. Returns whether
    /// nothing of the listed nodes may move any more.
    pub(super) fn all_rest(&mut self, nodes: &Nodes, all_stops_ok: bool) -> bool {
        let mut all_rest = true;
        for node in nodes.as_slice().iter().chain([&Address::BROADCAST]) {
            if let Some(moving) = self.0.get_mut(usize::from(node.0)) {
                let rests = all_stops_ok || *moving & PROGRAM == 0;
                *moving = if rests { 0 } else { *moving };
                all_rest &= rests;
            }
        }
        all_rest
    }
}

impl fmt::Debug for Motion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Pairs of address and bits. A map could not be proven free of panics.
        f.debug_list().entries((0..=u8::MAX).zip(self.0).filter(|(_, parts)| *parts != 0)).finish()
    }
}

impl HostMachine {
    /// Whether anything may still move because of this master.
    ///
    /// It is true from the moment at which a command that may move something is accepted, until rest is known: a node
    /// answered a stop with OK, said that its motors and its program rest, or an emergency stop is confirmed. It is true
    /// as well while a stop is not confirmed. A link that goes down changes nothing: what was moving may still move.
    ///
    /// What other masters, contacts and people at the node set in motion is not known here.
    #[must_use]
    pub fn may_move(&self) -> bool {
        let waits = self.queue.iter().any(|request| request.transmit.message.conduct().may_move());
        waits || !self.speeds.is_empty() || self.is_stopping() || self.motion.any()
    }
}
