//! Parsers with other libraries, other parsers of the field, and parsers as users write them by hand.

pub(crate) mod bytes;
pub(crate) mod dmc;
pub(crate) mod field;
pub(crate) mod hoot;
pub(crate) mod kos;
