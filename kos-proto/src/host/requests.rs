//! What a client asked and was not told yet: one question of a kind, for there are no numbers to tell answers apart.

use motion_core::time::Millis;

use crate::frame::{MessageId, MessageType};

/// A question.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Get {
    /// Where are you in the network?
    NetworkInfo,
    /// What do the lamps do?
    LedStatus,
    /// Where are the motors, and how far do they go?
    MotorInfo,
    /// What are you, and what do you do?
    DeviceInfo,
    /// Which move have you stored?
    TrajectoryData,
    /// Which of all devices are you?
    DeviceGuid,
    /// Which platform calibrated the motors?
    SoftwareId,
}

impl Get {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::NetworkInfo,
        Self::LedStatus,
        Self::MotorInfo,
        Self::DeviceInfo,
        Self::TrajectoryData,
        Self::DeviceGuid,
        Self::SoftwareId,
    ];

    /// What it is about.
    #[must_use]
    pub const fn id(self) -> MessageId {
        match self {
            Self::NetworkInfo => MessageId::NETWORK_INFO,
            Self::LedStatus => MessageId::LED_STATUS,
            Self::MotorInfo => MessageId::MOTOR_INFO,
            Self::DeviceInfo => MessageId::DEVICE_INFO,
            Self::TrajectoryData => MessageId::TRAJECTORY_DATA,
            Self::DeviceGuid => MessageId::DEVICE_GUID,
            Self::SoftwareId => MessageId::SOFTWARE_ID,
        }
    }

    /// The question about this, if there is one.
    #[must_use]
    pub fn of(id: MessageId) -> Option<Self> {
        Self::ALL.into_iter().find(|get| get.id() == id)
    }
}

/// A number by which the application knows its question again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Token(pub u16);

/// Why a question is not answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Failure {
    /// Nothing came in time.
    NoAnswer,
    /// The device does not know the question.
    Unsupported,
    /// The answer is cut short.
    Malformed,
    /// The connection is lost.
    Closed,
}

/// Who asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Asker {
    /// The machine itself.
    Machine,
    /// The application, by this command.
    Application(Token),
}

/// A question that is not answered yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Pending {
    asker: Asker,
    until: Millis,
}

/// All that was asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Requests([Option<Pending>; Get::ALL.len()]);

impl Requests {
    fn place(&mut self, get: Get) -> Option<&mut Option<Pending>> {
        self.0.iter_mut().zip(Get::ALL).find_map(|(place, this)| (this == get).then_some(place))
    }

    /// Asks; `false` if it is asked already.
    pub(super) fn ask(&mut self, get: Get, asker: Asker, until: Millis) -> bool {
        match self.place(get) {
            Some(place @ None) => {
                *place = Some(Pending { asker, until });
                true
            }
            _ => false,
        }
    }

    /// The answer is there, or will not come: who asked, if anybody did.
    pub(super) fn end(&mut self, get: Get) -> Option<Asker> {
        self.place(get)?.take().map(|pending| pending.asker)
    }

    /// A part of the answer is there.
    pub(super) fn go_on(&mut self, get: Get, until: Millis) {
        if let Some(pending) = self.place(get).and_then(Option::as_mut) {
            pending.until = until;
        }
    }

    /// A question whose time is over.
    pub(super) fn expired(&self, now: Millis) -> Option<Get> {
        let late = |place: &Option<Pending>| place.is_some_and(|pending| pending.until <= now);
        self.0.iter().zip(Get::ALL).find_map(|(place, get)| late(place).then_some(get))
    }

    pub(super) fn deadline(&self) -> Option<Millis> {
        self.0.iter().flatten().map(|pending| pending.until).min()
    }
}

/// What an `UnsupportedMessage` sends back, as much as fits: id and type, from the version byte on.
pub(super) fn echoed(message: &[u8]) -> Option<(MessageId, MessageType)> {
    let &[_, _, _, i0, i1, kind] = message.first_chunk()?;
    Some((MessageId(u16::from_be_bytes([i0, i1])), MessageType(kind)))
}
