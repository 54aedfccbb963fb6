//! The laws for a table that has every kind of part.

// The module imports these as `crate::..`. The library expands the same module for its lints.
use motion_core::{__logged, element, fixed, flags, lint, message, messages, open_enum, side, stream, unit, wire};

#[allow(dead_code, missing_docs, unreachable_pub, reason = "the tables of the library, used here for their laws")]
#[path = "../src/wire/expand.rs"]
mod expand;

use motion_core::wire::Messages;
use proptest::prelude::*;

use expand::Sender;

#[test]
fn every_message_of_the_table() {
    laws::message::table::<Sender>();
}

proptest! {
    #[test]
    fn any_body_of_any_message(number in 0_u32..0x120, body in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = laws::message::any_body::<Sender>(number, &body);
    }

    #[test]
    fn prefixes_and_tails(kind in 0..expand::Everything::ALL.len(), body in proptest::collection::vec(any::<u8>(), 0..60)) {
        laws::message::prefixes::<Sender>(expand::Everything::ALL[kind].number, &body);
    }
}
