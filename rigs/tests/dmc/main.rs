//! A DMC host and a simulated device, together.

mod faults;
mod hostile;
mod late;
mod motors;
mod runs;
mod shots;
mod shutter;
mod stage;
mod trouble;
