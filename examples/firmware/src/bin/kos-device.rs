//! kOS device on the serial port of the board.

#![no_std]
#![no_main]

use embassy_executor::Spawner;
use firmware::{board, kos};

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let Ok(()) = kos::serve(&mut board::start()).await;
}
