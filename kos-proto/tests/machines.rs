//! The machines of both sides, row by row of the tables in `docs/machines-kos.md`.

mod machines {
    mod bench;
    mod calibration;
    mod capacity;
    mod client;
    mod connect;
    mod hand;
    mod lapse;
    mod link;
    mod playback;
    mod random;
    mod rows;
    mod stops;
    mod together;
    mod tracker;
}
