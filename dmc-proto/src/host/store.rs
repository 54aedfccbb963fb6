//! Messages of commands that have not ended.

use motion_core::wire::EncodeError;

use super::Token;
use crate::frame::{Frame, MessageId};
use crate::message::HostMessage;

/// Bytes before each message: its token and its length.
const HEAD: usize = 6;

/// Messages by their tokens, in a memory of `N` bytes, one after the other.
#[derive(Debug, Clone)]
pub(super) struct Store<const N: usize> {
    memory: [u8; N],
    used: usize,
}

impl<const N: usize> Store<N> {
    pub(super) const fn new() -> Self {
        Self { memory: [0; N], used: 0 }
    }

    /// Adds a message.
    pub(super) fn insert(&mut self, token: Token, message: &HostMessage<'_>) -> Result<(), EncodeError> {
        let free = self.memory.get_mut(self.used..).unwrap_or_default();
        let have = free.len().saturating_sub(HEAD);
        let needed = message.encoded_len();
        let Some((head, place)) = free.split_at_mut_checked(HEAD).filter(|_| needed <= have) else {
            return Err(EncodeError::BufferTooSmall { needed, have });
        };
        let len = message.encode_into(MessageId::UNSOLICITED, place)?;
        let bytes = token.0.to_le_bytes().into_iter().chain(u16::try_from(len).unwrap_or_default().to_le_bytes());
        for (place, byte) in head.iter_mut().zip(bytes) {
            *place = byte;
        }
        self.used = self.used.saturating_add(HEAD).saturating_add(len).min(N);
        Ok(())
    }

    /// Place and length of a message, with its head.
    fn find(&self, token: Token) -> Option<(usize, usize)> {
        let mut at = 0_usize;
        while let Some(&[a, b, c, d, low, high, ..]) = self.memory.get(at..self.used) {
            let len = HEAD.saturating_add(u16::from_le_bytes([low, high]).into());
            if u32::from_le_bytes([a, b, c, d]) == token.0 {
                return Some((at, len));
            }
            at = at.saturating_add(len);
        }
        None
    }

    /// Whether the command with this token has not ended.
    pub(super) fn contains(&self, token: Token) -> bool {
        self.find(token).is_some()
    }

    /// Message of a command.
    pub(super) fn get(&self, token: Token) -> Option<HostMessage<'_>> {
        let (at, len) = self.find(token)?;
        let frame = self.memory.get(at.saturating_add(HEAD)..at.saturating_add(len))?;
        HostMessage::decode(&Frame::decode(frame).ok()?).ok()
    }

    /// Removes the message of a command that ended.
    pub(super) fn remove(&mut self, token: Token) {
        let Some((at, len)) = self.find(token) else { return };
        for from in at.saturating_add(len)..self.used {
            let byte = self.memory.get(from).copied().unwrap_or_default();
            if let Some(to) = self.memory.get_mut(from.saturating_sub(len)) {
                *to = byte;
            }
        }
        self.used = self.used.saturating_sub(len);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::{Motor, MotorMove, MotorStatusRequest, Steps};

    fn to(position: i32) -> HostMessage<'static> {
        MotorMove { motor: Motor(1), position: Steps(position), tail: &[] }.into()
    }

    #[test]
    fn messages_are_kept_until_they_are_removed() {
        // Three moves of 17 bytes each.
        let mut store = Store::<{ 3 * (HEAD + 17) }>::new();
        for number in 1..=3 {
            assert_eq!(store.insert(Token(number), &to(number.try_into().unwrap())), Ok(()));
        }
        let more = HostMessage::from(MotorStatusRequest::default());
        let error = store.insert(Token(4), &more).unwrap_err();
        assert!(matches!(error, EncodeError::BufferTooSmall { have: 0, .. }), "{error}");
        store.remove(Token(2));
        store.remove(Token(2));
        assert_eq!(store.insert(Token(4), &more), Ok(()));
        let kept = [1, 2, 3, 4].map(|number| store.get(Token(number)));
        assert_eq!(kept, [Some(to(1)), None, Some(to(3)), Some(more)]);
        assert!(store.contains(Token(4)) && !store.contains(Token(2)));
    }
}
