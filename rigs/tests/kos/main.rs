//! A kOS client and a device on one line: what people do with a rig, and what goes wrong meanwhile.

mod bench;
mod calibration;
mod devices;
mod faults;
mod lapse;
mod live;
mod trouble;
