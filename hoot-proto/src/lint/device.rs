//! Lint of messages of nodes.

use motion_core::lint::{Findings as _, Lints, Severity};

use super::{Context, Rules};
use crate::message::{DeviceMessage, Reply, ResponseCode, ValueType};

impl DeviceMessage<'_> {
    /// Findings about this message: what a strict master would refuse, and what a careful node would not send.
    ///
    /// There are no findings about replies that [`Query::reply`](crate::Query::reply) makes for the profile of the
    /// context.
    #[must_use]
    pub fn lint(&self, context: &Context) -> Lints {
        let mut rules = Rules::new(context);
        match self {
            Self::Reply(reply) => rules.reply(reply),
            Self::Other(other) => {
                rules.length(other.payload());
                rules.found.note(
                    Severity::Warning,
                    "address",
                    "not a reply, because it is not addressed to the master",
                );
            }
        }
        rules.found
    }
}

impl Rules<'_> {
    /// Sections 1 and 1.2; safety decision 7.
    fn reply(&mut self, reply: &Reply<'_>) {
        self.length(reply.data);
        self.found.named("response_code", reply.code.0, reply.code.name());
        let Some(value_type) = reply.value_type() else { return };
        if reply.code == ResponseCode::ERROR {
            self.warning("response_code", "an error with data has code 2");
        }
        self.found.named("value_type", value_type.0, value_type.name());
        if value_type.name().is_some() && reply.value().is_none() {
            self.error("value", "longer or shorter than its type says");
        }
        if value_type == ValueType::FLOAT && self.context.profile.float_is_true() != Some(true) {
            self.warning("value", "not reliable: firmware from 2014-10-07 to v0.32 sends garbage as FLOAT");
        }
    }
}
