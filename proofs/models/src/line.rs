//! One direction of a line: messages in order, and their faults.

use std::collections::VecDeque;

/// Number of faults of each kind that a line may still have. They bound the exploration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Faults {
    /// Messages that may still be lost.
    pub lost: u8,
    /// Messages whose bytes may still be damaged.
    pub corrupt: u8,
    /// Messages that may still come twice.
    pub doubled: u8,
}

/// Fate of the first message on a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fate {
    /// The message arrives.
    Arrives,
    /// The message arrives, and will arrive once more.
    Doubled,
    /// A damaged message arrives, and its receiver can see the damage.
    Corrupt,
    /// The message is lost.
    Lost,
}

/// Messages in flight. They do not overtake each other. A late message stays here while time advances.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Line<Message> {
    messages: VecDeque<Message>,
    faults: Faults,
}

impl<Message: Clone> Line<Message> {
    /// Line without messages.
    #[must_use]
    pub fn new(faults: Faults) -> Self {
        Self { messages: VecDeque::new(), faults }
    }

    /// Sends messages.
    pub fn send(&mut self, messages: impl IntoIterator<Item = Message>) {
        self.messages.extend(messages);
    }

    /// Messages in flight in order, with the data that the model keeps for each.
    pub fn iter(&self) -> impl Iterator<Item = &Message> {
        self.messages.iter()
    }

    /// Messages in flight in order, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Message> {
        self.messages.iter_mut()
    }

    /// Number of messages in flight.
    #[must_use]
    pub fn len(&self) -> usize {
        self.messages.len()
    }

    /// Whether no message is in flight.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.messages.is_empty()
    }

    /// Cuts the link, which loses all messages in flight.
    pub fn cut(&mut self) {
        self.messages.clear();
    }

    /// Possible fates of the first message now.
    pub fn fates(&self) -> impl Iterator<Item = Fate> {
        let Faults { lost, corrupt, doubled } = self.faults;
        let possible =
            [(true, Fate::Arrives), (doubled > 0, Fate::Doubled), (corrupt > 0, Fate::Corrupt), (lost > 0, Fate::Lost)];
        let there = !self.is_empty();
        possible.into_iter().filter(move |(can, _)| there && *can).map(|(_, fate)| fate)
    }

    /// Applies a fate to the first message. Returns what arrives, and whether it is sound; `None` if nothing arrives.
    pub fn meet(&mut self, fate: Fate) -> Option<(Message, bool)> {
        let first = self.messages.pop_front()?;
        match fate {
            Fate::Arrives => Some((first, true)),
            Fate::Doubled => {
                self.faults.doubled = self.faults.doubled.saturating_sub(1);
                self.messages.push_front(first.clone());
                Some((first, true))
            }
            Fate::Corrupt => {
                self.faults.corrupt = self.faults.corrupt.saturating_sub(1);
                Some((first, false))
            }
            Fate::Lost => {
                self.faults.lost = self.faults.lost.saturating_sub(1);
                None
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_counted() {
        let mut line = Line::new(Faults { lost: 1, corrupt: 1, doubled: 1 });
        assert_eq!(line.fates().count(), 0);
        line.send([1, 2, 3]);
        assert_eq!(line.fates().count(), 4);
        assert_eq!(line.meet(Fate::Doubled), Some((1, true)));
        assert_eq!(line.meet(Fate::Lost), None);
        assert_eq!(line.meet(Fate::Corrupt), Some((2, false)));
        assert_eq!(line.fates().collect::<Vec<_>>(), [Fate::Arrives]);
        assert_eq!((line.meet(Fate::Arrives), line.is_empty()), (Some((3, true)), true));
    }
}
