//! Scaled integers (placeholder: being written).
use core::fmt;
/// A number stored as an integer, `SCALE` times as large.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct Scaled<T, const SCALE: u32>(pub T);
impl<T: fmt::Display, const SCALE: u32> fmt::Display for Scaled<T, SCALE> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result { self.0.fmt(f) }
}
/// x1000
pub type Milli<T = i32> = Scaled<T, 1000>;
/// x100
pub type Centi<T = i32> = Scaled<T, 100>;
/// x10
pub type Deci<T = i32> = Scaled<T, 10>;
