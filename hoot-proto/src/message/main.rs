//! The controller itself: sub-address 0.

use motion_core::fixed::Centi;
use motion_core::wire::{
    DecodeError, EncodeError, FieldView, Fields, Message, PartKind, Row, Value as Shown, Visitor, place,
};
use motion_core::{message, open_enum, unit};

use super::Name;

message! {
    /// Start or resume the planned move.
    ///
    /// Never send it again by itself: a retry after an operator's stop would move the rig. The answer may take 3 s.
    /// Source: hoot, section 2.1; safety decision 1.
    pub struct Start in BE {}

    /// Pause the planned move. Source: hoot, section 2.1.
    pub struct Pause in BE {}

    /// Stop everything and forget how far the planned move was.
    ///
    /// The firmware refuses it in joystick mode: for an emergency, stop each motor first with
    /// [`MotorStop`](super::MotorStop). Source: hoot, section 2.1; safety decision 2.
    pub struct Stop in BE {}

    /// Does the planned move run? Asks for a [`RunState`]. Source: hoot, section 2.2.
    pub struct RunStatus in BE {}

    /// What is the node called? Asks for a [`Text`](super::Text), mostly of ten bytes. Source: hoot, section 2.2.
    pub struct NameQuery in BE {}

    /// What is the supply voltage? Asks for [`Volts`]. Source: hoot, section 2.2.
    pub struct Voltage in BE {}
}

open_enum! {
    /// Whether the planned move runs. The firmware of the published sheet says 0 or 1 only, and 0 for paused.
    ///
    /// Source: hoot, sections 2.2 and 4.2. The sheet's firmware calls 1 what later firmware calls 2: ask for the
    /// firmware's version before you read 1.
    pub struct RunState(u8) {
        /// It does not.
        STOPPED = 0,
        /// It runs, says the sheet's firmware; it is paused, says firmware since 2014-12-03.
        RUNNING_OR_PAUSED = 1,
        /// It runs.
        RUNNING = 2,
        /// It waits for the delay before the start.
        DELAY = 3,
        /// It still takes a picture.
        STILL_SHOOTING = 4,
        /// It runs to and fro.
        PING_PONG = 5,
    }
}

unit! {
    /// A voltage in hundredths of a volt, on the wire as well.
    pub struct Volts(Centi<i32>) "V";
}

/// Give the node a name, 1 to 10 bytes of it. Source: hoot, section 2.1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SetName {
    /// What it is to be called.
    pub name: Name,
}

impl<'a> Message<'a> for SetName {
    const LAYOUT: &'static [Row] = &place([Row {
        name: "name",
        wire: "text[1..=10]",
        offset: None,
        size: 1,
        part: PartKind::Rest,
        unit: "",
        element: &[],
    }]);

    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        let what = "SetName";
        match (Name::from_bytes(body), body.len()) {
            (Some(name), _) => Ok(Self { name }),
            (None, 0) => Err(DecodeError::Truncated { what, needed: 1, have: 0 }),
            (None, len) => Err(DecodeError::Trailing { what, extra: len.saturating_sub(Name::MAX) }),
        }
    }

    fn encoded_len(&self) -> usize {
        self.name.as_bytes().len()
    }

    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let needed = self.encoded_len();
        let small = EncodeError::BufferTooSmall { needed, have: out.len() };
        out.get_mut(..needed).ok_or(small)?.copy_from_slice(self.name.as_bytes());
        Ok(needed)
    }
}

impl Fields for SetName {
    fn fields(&self, visitor: &mut dyn Visitor) {
        let value = Shown::Text(self.name.as_bytes());
        visitor.visit(&FieldView { name: "name", unit: "", value, text: &self.name });
    }
}

motion_core::__message_features! { 'a [SetName] SetName }
