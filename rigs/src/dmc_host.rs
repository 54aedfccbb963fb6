//! A DMC host.
