//! What the benches share: traffic mixes and peers.
