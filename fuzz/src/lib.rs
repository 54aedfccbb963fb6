//! Shared code of the fuzz targets: references that share no line with the libraries, and worlds for the machines.

pub mod drawn;
pub mod machines;
pub mod rescan;
