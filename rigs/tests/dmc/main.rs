//! A DMC host and a simulated device, together.

mod failed;
mod faults;
mod hostile;
mod late;
mod motors;
#[path = "../recorded/mod.rs"]
mod recorded;
mod replay;
mod runs;
mod shots;
mod shutter;
mod stage;
mod trouble;
