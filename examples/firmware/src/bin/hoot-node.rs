//! Hoot node on the serial port of the board.

#![no_std]
#![no_main]

use embassy_executor::Spawner;
use firmware::{board, hoot};

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let Ok(()) = hoot::serve(&mut board::start()).await;
}
