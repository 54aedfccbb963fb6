//! What the fuzz targets share: the protocols as the laws want them, and references that share no line with them.

pub mod rescan;
pub mod sides;
