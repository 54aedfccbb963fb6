//! A DMC host and a simulated device, together.

mod faults;
mod hostile;
mod motors;
#[path = "../recorded/mod.rs"]
mod recorded;
mod replay;
mod runs;
mod shots;
mod stage;
mod trouble;
