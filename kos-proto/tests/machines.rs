//! Tests of the machines of both sides, for each row of the tables in `docs/machines-kos.md`.

mod machines {
    mod bench;
    mod calibration;
    mod capacity;
    mod client;
    mod connect;
    mod lapse;
    mod link;
    mod motors;
    mod playback;
    mod random;
    mod rest;
    mod rows;
    mod session;
    mod stops;
    mod together;
    mod tracker;
    mod without_moves;
    mod world;
}
