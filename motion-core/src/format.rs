//! Messages in `defmt` logs, as the text that [`Display`](core::fmt::Display) prints.

#![doc(hidden)]

use core::fmt;

use defmt::{Display2Format, Formatter};

use crate::wire::{Fields, print};

struct Text<'a>(&'static str, &'a dyn Fields);

impl fmt::Display for Text<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        print::message(f, self.0, self.1)
    }
}

/// Logs a message as `name { field: value unit, .. }`.
pub fn message(f: Formatter<'_>, name: &'static str, fields: &dyn Fields) {
    defmt::write!(f, "{}", Display2Format(&Text(name, fields)));
}
