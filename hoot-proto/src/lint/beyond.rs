//! Lint of messages for later firmware.

use motion_core::lint::{Findings as _, Lints};
use motion_core::wire::{FieldView, Fields, Value};

use super::{Context, Rules};
use crate::beyond::HostMessage;
use crate::frame::Table;
use crate::message::MAX_ARRIVING;

impl HostMessage<'_> {
    /// Findings about this message: what a node would misread, and what a careful master would not send.
    #[must_use]
    pub fn lint(&self, context: &Context) -> Lints {
        let mut rules = Rules::new(context);
        if let Self::Other(other) = self {
            rules.length(other.payload());
            return rules.found;
        }
        rules.joystick(self.selector());
        rules.running(self.selector());
        // Only older firmware refuses unknown commands, and it knows none of these.
        rules.has(context.profile.is_silent());
        if self.selector().table == Table::Broadcast {
            rules.bridge();
        }
        self.fields(&mut |field: &FieldView<'_>| match field.value {
            Value::Unsigned(number) => {
                rules.found.range(field.name, i64::try_from(number).unwrap_or(i64::MAX), 0, MAX_ARRIVING);
            }
            Value::Float(number) => rules.found.finite(field.name, number),
            _ => {}
        });
        rules.found
    }
}
