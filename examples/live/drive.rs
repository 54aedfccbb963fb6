//! A host for a rig: simulated or real.

fn main() {}
