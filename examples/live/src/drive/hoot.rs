//! Commands as hoot has them.
