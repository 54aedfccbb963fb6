//! Commands as DMC has them.
