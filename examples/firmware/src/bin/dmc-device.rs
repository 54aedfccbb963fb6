//! DMC device on the serial port of the board.

#![no_std]
#![no_main]

use embassy_executor::Spawner;
use firmware::{board, dmc};

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let Ok(()) = dmc::serve(&mut board::start()).await;
}
