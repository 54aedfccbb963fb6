//! One direction of a line: messages in order, and what may become of them.

use std::collections::VecDeque;

/// How many faults a line may still have, of each kind. Together they bound the exploration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Faults {
    /// Messages that may be lost.
    pub lost: u8,
    /// Messages whose bytes may be damaged.
    pub corrupt: u8,
    /// Messages that may come twice.
    pub doubled: u8,
}

/// What happens to the message that is first on a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fate {
    /// It arrives.
    Arrives,
    /// It arrives, and will arrive once more.
    Doubled,
    /// Something arrives that its receiver can tell from a message.
    Corrupt,
    /// Nothing arrives.
    Lost,
}

/// Messages on their way, which do not overtake each other; delay is that they stay here while time goes on.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Line<Message> {
    messages: VecDeque<Message>,
    faults: Faults,
}

impl<Message: Clone> Line<Message> {
    /// An empty line.
    #[must_use]
    pub fn new(faults: Faults) -> Self {
        Self { messages: VecDeque::new(), faults }
    }

    /// Sends messages.
    pub fn send(&mut self, messages: impl IntoIterator<Item = Message>) {
        self.messages.extend(messages);
    }

    /// Those on their way, in their order, with whatever the model keeps beside them.
    pub fn iter(&self) -> impl Iterator<Item = &Message> {
        self.messages.iter()
    }

    /// The same, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Message> {
        self.messages.iter_mut()
    }

    /// How many are on their way.
    #[must_use]
    pub fn len(&self) -> usize {
        self.messages.len()
    }

    /// Whether none is.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.messages.is_empty()
    }

    /// The link is cut: what is on its way is gone.
    pub fn cut(&mut self) {
        self.messages.clear();
    }

    /// What may become of the first message now.
    pub fn fates(&self) -> impl Iterator<Item = Fate> {
        let Faults { lost, corrupt, doubled } = self.faults;
        let possible =
            [(true, Fate::Arrives), (doubled > 0, Fate::Doubled), (corrupt > 0, Fate::Corrupt), (lost > 0, Fate::Lost)];
        let there = !self.is_empty();
        possible.into_iter().filter(move |(can, _)| there && *can).map(|(_, fate)| fate)
    }

    /// Lets it happen. What arrives, and whether it is sound; `None` if nothing does.
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
