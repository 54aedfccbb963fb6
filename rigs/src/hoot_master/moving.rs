//! What may move because of what was sent from here.

use std::collections::BTreeSet;

use hoot_proto::message::Motor;
use hoot_proto::query::{AnyReply, Profile};
use hoot_proto::{Address, HostMessage};

/// The controller: where a program is.
const PROGRAM: u8 = 0;

/// Motors, and programs that move them, of which it is not known that they rest.
#[derive(Debug, Clone, Default)]
pub(super) struct Moving(BTreeSet<(Address, u8)>);

impl Moving {
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// A message is to go out; gives what may move because of it and did not before.
    pub(super) fn asked(&mut self, nodes: &[Address], to: Address, message: &HostMessage<'_>) -> Vec<(Address, u8)> {
        let harmless = matches!(message, HostMessage::MotorSetContinuousAcceleration(_))
            || matches!(message, HostMessage::MotorSetContinuousSpeed(set) if set.speed.0 == 0.0);
        if !message.may_start_motion() || harmless {
            return Vec::new();
        }
        let parts = match message.selector().sub_address {
            part @ 1..=3 if to != Address::BROADCAST => part..=part,
            _ => PROGRAM..=3,
        };
        let to = [to];
        let nodes = if to == [Address::BROADCAST] { nodes } else { &to };
        let all = nodes.iter().flat_map(|node| parts.clone().map(|part| (*node, part)));
        all.filter(|part| self.0.insert(*part)).collect()
    }

    /// It did not go out after all.
    pub(super) fn not_done(&mut self, added: &[(Address, u8)]) {
        for part in added {
            self.0.remove(part);
        }
    }

    /// A request was answered by an OK.
    pub(super) fn done(
        &mut self,
        profile: Profile,
        from: Address,
        message: &HostMessage<'_>,
        answer: Option<AnyReply<'_>>,
    ) {
        match (message, answer) {
            (HostMessage::Stop(_) | HostMessage::Pause(_), _) => self.0.retain(|(node, _)| *node != from),
            (HostMessage::MotorStop(stop), _) => self.rests(from, stop.motor),
            (HostMessage::MotorRunning(query), Some(AnyReply::MotorRunning(answer))) if !answer.value.get() => {
                self.rests(from, query.motor);
            }
            (HostMessage::RunStatus(_), Some(AnyReply::RunStatus(answer)))
                if answer.value.is_running(profile) == Some(false) =>
            {
                self.0.remove(&(from, PROGRAM));
            }
            _ => {}
        }
    }

    /// A motor rests; but a program may move it again.
    fn rests(&mut self, node: Address, motor: Motor) {
        if !self.0.contains(&(node, PROGRAM)) {
            self.0.remove(&(node, motor.get()));
        }
    }
}
