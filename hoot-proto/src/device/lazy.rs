//! Message that is decoded when it is asked for.

use core::fmt;
use core::hash::{Hash, Hasher};

use motion_core::wire::Messages;

use crate::frame::{Frame, Selector};
use crate::message::HostMessage;

/// Message that is decoded when it is asked for.
///
/// Firmware that does not ask for it does not contain the decoder of all messages, which is long.
#[derive(Clone, Copy)]
pub struct LazyMessage<'a>(Form<'a>);

#[derive(Clone, Copy)]
enum Form<'a> {
    Decoded(HostMessage<'a>),
    Data(Selector, &'a [u8]),
}

impl<'a> LazyMessage<'a> {
    /// Message of a packet.
    pub(super) fn of(frame: &Frame<'a>) -> Self {
        let (selector, data) = frame.request();
        Self(Form::Data(selector, data))
    }

    /// The message.
    #[must_use]
    pub fn get(self) -> HostMessage<'a> {
        match self.0 {
            Form::Decoded(message) => message,
            Form::Data(selector, data) => {
                let number = selector.number();
                HostMessage::decode_or_other(number, data)
            }
        }
    }
}

impl<'a> From<HostMessage<'a>> for LazyMessage<'a> {
    fn from(message: HostMessage<'a>) -> Self {
        Self(Form::Decoded(message))
    }
}

impl PartialEq for LazyMessage<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}

impl Eq for LazyMessage<'_> {}

impl Hash for LazyMessage<'_> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.get().hash(state);
    }
}

impl fmt::Display for LazyMessage<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.get().fmt(f)
    }
}

impl fmt::Debug for LazyMessage<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.get(), f)
    }
}

#[cfg(feature = "defmt")]
impl motion_core::defmt::Format for LazyMessage<'_> {
    fn format(&self, f: motion_core::defmt::Formatter<'_>) {
        motion_core::defmt::Format::format(&self.get(), f);
    }
}
