//! dmc-proto
