//! A simulated rig on a real transport.

fn main() {}
