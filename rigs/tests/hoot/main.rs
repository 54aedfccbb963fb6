//! Scenarios of hoot: a master and a simulated node on a virtual clock.

mod bridge;
mod deaf;
mod faults;
mod firmware;
mod programs;
#[path = "../recorded/mod.rs"]
mod recorded;
mod replay;
mod trouble;
mod usual;
mod world;
