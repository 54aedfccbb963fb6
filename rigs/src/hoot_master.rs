//! A hoot master.
