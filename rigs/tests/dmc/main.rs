//! A DMC host and a simulated device, together.

mod runs;
mod stage;
