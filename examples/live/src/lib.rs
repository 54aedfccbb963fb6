//! Simulated rigs on real transports, and hosts for real rigs.
//!
//! Two programs: `simulate` is a rig without the hardware, and `drive` is a host that can be pointed at either kind. In one
//! terminal:
//!
//! ```text
//! $ cargo run --example simulate -- kos
//! kOS rig at 127.0.0.1:5520
//! ```
//!
//! and in another one:
//!
//! ```text
//! $ cargo run --example drive -- kos 127.0.0.1 run examples/moves/slide.json
//! drive: motor 1 is not calibrated: drive kos ADDRESS calibrate 1 0 40
//! $ cargo run --example drive -- kos 127.0.0.1 calibrate 1 0 40
//! motor 1 is where its range begins
//! motor 1 is on its way, at 0
//! motor 1 is calibrated: from 0 to 40 rotations
//! $ cargo run --example drive -- kos 127.0.0.1 run examples/moves/slide.json --home-speed 1
//! the motors go to where the move begins
//! it runs: motor 1 at 0, motor 2 at 0, motor 3 at 0
//! 12 %: motor 1 at 1.016, motor 2 at 0, motor 3 at 0
//! ^Cdrive: interrupted: the rig confirmed the stop
//! ```
//!
//! Meanwhile the rig has logged
//!
//! ```text
//!   11.633613226s  INFO 127.0.0.1:46152 is connected
//!   11.633707633s  INFO client 0 is connected
//!   11.636001332s  INFO a move is stored
//!   11.636140421s  INFO its motors go to where the move begins
//!   12.732656687s  INFO motor 1 rests at 0.000
//!   12.735376778s  INFO the move is played Forward, in 8000 ms
//!   15.629375361s  INFO everything stops
//!   15.630168588s  INFO motor 1 stops
//!   15.670371218s  INFO motor 1 rests at 12.173
//!   15.671722433s  INFO 127.0.0.1:46152: has hung up
//!   15.671783350s  INFO client 0 is gone
//! ```
//!
//! DMC and hoot have serial lines, so their rigs serve pseudo-terminals: `simulate dmc` says `DMC rig at /dev/pts/0`, and
//! `drive dmc /dev/pts/0 info` asks it. With `--tcp` they serve TCP as well.
//!
//! # What goes wrong
//!
//! `--faults all` lets all happen that can happen: on serial lines bytes are lost, doubled, damaged, late and cut anywhere,
//! and others come between; connections break; devices fall silent, are reset, and their motors get stuck. The same
//! `--seed` draws the same luck; when what meets it is up to the clock of the computer. `--quirks` makes a rig as peculiar
//! as those in the field. Whatever a client does, the rig goes on serving the others: who does not read is cut off, who
//! floods is read no faster than the rig can follow, and one too many is turned away.
//!
//! `drive` ends with status 0 when all is done; otherwise with status 1 and one line that says what to do. On Ctrl-C, and on
//! any trouble behind a command that moves something, it stops the motors first, over a new connection if need be, and
//! the line says whether the rig confirmed that.
//!
//! # How it is built
//!
//! | | |
//! |---|---|
//! | [`serve`] | a rig of the crate `rigs` in real time: TCP, pseudo-terminals, datagrams, a record of its motors |
//! | [`session`] | a host of the crate `rigs` in real time: TCP and serial lines |
//! | [`simulate`], [`drive`] | the two programs |
//! | [`program`] | what they do alike |

pub mod drive;
pub mod program;
pub mod serve;
pub mod session;
pub mod simulate;
