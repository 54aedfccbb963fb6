//! hoot-proto
