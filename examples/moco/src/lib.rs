//! Simulated rigs on real transports, and hosts for real rigs.
//!
//! There are two programs: `simulate` is a rig without hardware, and `drive` is a host for simulated and real rigs. In
//! one terminal:
//!
//! ```text
//! $ cargo run --example simulate -- kos
//! kOS rig at 127.0.0.1:5520
//! ```
//!
//! In another terminal:
//!
//! ```text
//! $ cargo run --example drive -- kos 127.0.0.1 run examples/moves/slide.json
//! drive: motor 1 is not calibrated: drive kos ADDRESS calibrate 1 0 40
//! $ cargo run --example drive -- kos 127.0.0.1 calibrate 1 0 40
//! motor 1 is where its range begins
//! motor 1 moves, at 0
//! motor 1 is calibrated: from 0 to 40 rotations
//! $ cargo run --example drive -- kos 127.0.0.1 run examples/moves/slide.json --home-speed 1
//! the motors go to where the move begins
//! the move runs: motor 1 at 0, motor 2 at 0, motor 3 at 0
//! 12 %: motor 1 at 1.016, motor 2 at 0, motor 3 at 0
//! ^Cdrive: interrupted: the rig confirmed the stop
//! ```
//!
//! Meanwhile the rig has logged:
//!
//! ```text
//!   11.633613226s  INFO 127.0.0.1:46152 is connected
//!   11.633707633s  INFO client 0 is connected
//!   11.636001332s  INFO a move is stored
//!   11.636140421s  INFO the motors go to where the move begins
//!   12.732656687s  INFO motor 1 rests at 0.000
//!   12.735376778s  INFO the move is played Forward, in 8000 ms
//!   15.629375361s  INFO everything stops
//!   15.630168588s  INFO motor 1 stops
//!   15.670371218s  INFO motor 1 rests at 12.173
//!   15.671722433s  INFO 127.0.0.1:46152: the client closed the line
//!   15.671783350s  INFO client 0 is gone
//! ```
//!
//! DMC and hoot have serial lines, so their rigs serve pseudo-terminals: `simulate dmc` prints `DMC rig at /dev/pts/0`,
//! and `drive dmc /dev/pts/0 info` connects to it. With `--tcp` they serve TCP instead.
//!
//! # Faults and failures
//!
//! `--faults all` switches all faults on. On serial lines, bytes are lost, doubled, damaged, inserted, late, and split
//! anywhere. Connections break. Devices are silent for a time or are reset, and their motors get stuck. The same
//! `--seed` gives the same random faults, but the clock of the computer decides which bytes they meet. `--device`
//! makes the rig behave as a device of the field does, `--quirks` adds single differences, and `--list` prints the names.
//!
//! A client cannot disturb the other clients. A client that does not read is cut off. A client that sends too much is
//! read only as fast as the rig can follow. A client without a free line is rejected.
//!
//! `drive` ends with status 0 when the command is done, and otherwise with status 1 and one line that says what to do.
//! After Ctrl-C, and after any failure of a command that may have moved a motor, it first stops the motors, over a new
//! connection if necessary. The line says whether the rig confirmed the stop.
//!
//! # Modules
//!
//! | | |
//! |---|---|
//! | [`serve`] | a rig of the crate `rigs` in real time: TCP, pseudo-terminals, datagrams, and a record of its motors |
//! | [`session`] | a host of the crate `rigs` in real time: TCP and serial lines |
//! | [`simulate`], [`drive`] | the two programs |
//! | [`program`] | functions that both programs use |

pub mod drive;
pub mod program;
pub mod serve;
pub mod session;
pub mod simulate;
