//! Answers that may still come: decisions H-18 and H-40.
//!
//! Nothing in an answer tells what it answers. So while the answer to an earlier packet may still come, an answer is not
//! taken for the answer to a later packet. It is only counted. An answer with a value is never taken for one without a
//! value, nor the other way round, so each of the two kinds has a doubt of its own.

use motion_core::time::Millis;

use crate::message::{HostMessage, Reply};

/// Answers of one kind that may still come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
struct Owed {
    /// Time until which they may come; `None` if none is awaited.
    until: Option<Millis>,
    /// Number of packets of which no answer has come.
    packets: u8,
    /// The same number, if answers that come together are copies of one answer.
    packets_if_copied: u8,
    /// Time until which an answer may be a copy of the one before; `None` if there is none.
    copies_until: Option<Millis>,
    /// Whether there may be more, from before the line came up.
    is_open: bool,
}

/// Answers that may still come, of both kinds.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub(super) struct Doubt {
    plain: Owed,
    value: Owed,
}

/// Whether the answer to a message may be one without a value, and one with a value.
fn kinds(message: &HostMessage<'_>) -> [bool; 2] {
    let is_unknown = matches!(message, HostMessage::Other(_));
    let asks = message.query().is_some();
    [is_unknown || !asks, is_unknown || asks]
}

impl Doubt {
    fn all(&self, message: &HostMessage<'_>, is_met: impl Fn(&Owed) -> bool) -> bool {
        let [plain, value] = kinds(message);
        (!plain || is_met(&self.plain)) && (!value || is_met(&self.value))
    }

    /// The line came up: answers to packets of others may come until then.
    pub(super) const fn link_up(&mut self, until: Millis) {
        let open = Owed { until: Some(until), packets: 0, packets_if_copied: 0, copies_until: None, is_open: true };
        *self = Self { plain: open, value: open };
    }

    /// This number of answers to a message may come until then.
    pub(super) fn owe(&mut self, message: &HostMessage<'_>, packets: u8, until: Millis) {
        for (owed, is_kind) in [&mut self.plain, &mut self.value].into_iter().zip(kinds(message)) {
            if is_kind {
                owed.packets = owed.packets.saturating_add(packets);
                owed.packets_if_copied = owed.packets_if_copied.saturating_add(packets);
                owed.until = Some(owed.until.map_or(until, |before| before.max(until)));
            }
        }
    }

    /// Counts an answer that is not taken for the answer to anything. If more are owed, they come by `until`; copies of it
    /// come by `copies_until`.
    pub(super) fn arrived(&mut self, reply: Reply<'_>, until: Millis, copies_until: Millis) {
        let is_plain = reply.data.is_empty() && (reply.is_ok() || self.plain.packets > 0);
        let owed = if is_plain { &mut self.plain } else { &mut self.value };
        owed.until = owed.until.map(|before| match (owed.is_open, owed.packets) {
            (true, 1..) => before,
            (false, 0 | 1) => before.min(until),
            _ => before.max(until),
        });
        owed.packets = owed.packets.saturating_sub(1);
        if owed.until.is_some() && owed.copies_until.replace(copies_until).is_none() {
            owed.packets_if_copied = owed.packets_if_copied.saturating_sub(1);
        }
    }

    /// Forgets answers that come too late, if they come.
    pub(super) fn expire(&mut self, now: Millis) {
        for owed in [&mut self.plain, &mut self.value] {
            if owed.until.is_some_and(|until| now >= until) {
                *owed = Owed::default();
            }
            owed.copies_until = owed.copies_until.filter(|until| now < *until);
        }
    }

    /// Whether the answer to a message cannot be the answer to something else.
    pub(super) fn is_clear(&self, message: &HostMessage<'_>) -> bool {
        self.all(message, |owed| owed.until.is_none())
    }

    /// Whether as many answers have come as are owed that could be taken for the answer to a message.
    pub(super) fn is_counted(&self, message: &HostMessage<'_>) -> bool {
        self.all(message, |owed| owed.packets_if_copied == 0 && !owed.is_open)
    }

    /// Whether no answer of either kind may come.
    pub(super) const fn is_over(&self) -> bool {
        self.plain.until.is_none() && self.value.until.is_none()
    }

    /// Time at which one of the kinds is clear.
    pub(super) fn until(&self) -> Option<Millis> {
        self.plain.until.into_iter().chain(self.value.until).min()
    }

    pub(super) fn set_back(&mut self, by: Millis) {
        for owed in [&mut self.plain, &mut self.value] {
            owed.until = owed.until.map(|until| Millis(until.since(by)));
            owed.copies_until = owed.copies_until.map(|until| Millis(until.since(by)));
        }
    }
}
