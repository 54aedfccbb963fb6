//! What the fuzz targets share: the protocols as the laws want them, references that share no line with them, and worlds
//! for their machines.

pub mod machines;
pub mod rescan;
pub mod sides;
