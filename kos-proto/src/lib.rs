//! kos-proto
