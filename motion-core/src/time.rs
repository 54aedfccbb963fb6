//! Time as the crates of this family know it: milliseconds that the caller counts.

/// Moment, in milliseconds since a moment of the caller's choice.
///
/// No crate of this family reads a clock. The caller of a machine or a stream says what time it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Millis(pub u64);

impl Millis {
    /// The moment `millis` milliseconds later. The greatest moment has no later one.
    #[must_use]
    pub const fn after(self, millis: u64) -> Self {
        Self(self.0.saturating_add(millis))
    }

    /// Milliseconds from `earlier` to this moment; 0 if `earlier` is later.
    #[must_use]
    pub const fn since(self, earlier: Self) -> u64 {
        self.0.saturating_sub(earlier.0)
    }
}
