//! Commands as kOS has them.
