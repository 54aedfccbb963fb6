//! Scenarios of hoot: a master and a simulated node on a virtual clock.

mod bridge;
mod faults;
mod firmware;
mod programs;
mod replay;
mod trouble;
mod usual;
mod world;
