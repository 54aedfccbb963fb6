//! Tests of the machines of both sides, for each row of the tables of the specification, and with random inputs.

#[path = "machines/app.rs"]
mod app;
#[path = "machines/bench.rs"]
mod bench;
#[path = "machines/connection.rs"]
mod connection;
#[path = "machines/coverage.rs"]
mod coverage;
#[path = "machines/failed_runs.rs"]
mod failed_runs;
#[path = "machines/host.rs"]
mod host;
#[path = "machines/may_move.rs"]
mod may_move;
#[path = "machines/playback.rs"]
mod playback;
#[path = "machines/random.rs"]
mod random;
#[path = "machines/real_time.rs"]
mod real_time;
#[path = "machines/sequences.rs"]
mod sequences;
#[path = "machines/session.rs"]
mod session;
#[path = "machines/stops.rs"]
mod stops;
#[path = "machines/world.rs"]
mod world;
