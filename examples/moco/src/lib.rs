//! Program `moco` for motion-control rigs.
//!
//! | command | what it does |
//! |---|---|
//! | `moco inspect` | shows the frames of a capture as typed messages |
//! | `moco plot` | draws a move file, or the moves of a capture |
//! | `moco one-move` | converts a move file to all three protocols, says what each loses, and plays it on simulated rigs |
//! | `moco simulate` | runs a rig without hardware |
//! | `moco drive` | controls a simulated or real rig |
//! | `moco completions`, `moco man` | write completions for a shell, and manual pages |
//!
//! In one terminal:
//!
//! ```text
//! $ moco simulate kos
//! kOS rig at 127.0.0.1:5520
//! ```
//!
//! In another terminal:
//!
//! ```text
//! $ moco drive kos 127.0.0.1 run examples/moves/slide.json
//! moco: motor 1 is not calibrated: moco drive kos ADDRESS calibrate 1 0 40
//! $ moco drive kos 127.0.0.1 calibrate 1 0 40
//! motor 1 is where its range begins
//! motor 1 moves, at 0
//! motor 1 is calibrated: from 0 to 40 rotations
//! $ moco drive kos 127.0.0.1 run examples/moves/slide.json --home-speed 1
//! the motors go to where the move begins
//! the move runs: motor 1 at 0, motor 2 at 0, motor 3 at 0
//! 12 %: motor 1 at 1.016, motor 2 at 0, motor 3 at 0
//! ^Cmoco: interrupted: the rig confirmed the stop
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
//! DMC and hoot have serial lines, so their rigs serve pseudo-terminals: `moco simulate dmc` prints `DMC rig at /dev/pts/0`.
//! With `--tcp` they serve TCP instead.
//!
//! ```text
//! $ moco drive dmc /dev/pts/0 info
//! "Simulated DMC", firmware 1.0.0
//! 4 motors, 16 lights, 8 outputs, 8 inputs
//! room for 10000 frames; capabilities: REAL_TIME | SHOOT_FRAME | SHOOT_FRAME2 | LOOP | CAMERA_TRIGGER
//! motor 1 rests at 0 steps
//! motor 2 rests at 0 steps
//! motor 3 rests at 0 steps
//! motor 4 rests at 0 steps
//! $ moco drive hoot /dev/pts/1 run examples/moves/pan.json
//! motor 1: from 0 to 9000, deviation at most 1
//! 0.1 of 4.5 s: motor 1 at 0
//! 1.2 of 4.5 s: motor 1 at 893
//! 2.3 of 4.5 s: motor 1 at 4071
//! 3.4 of 4.5 s: motor 1 at 7514
//! the move is done, and all motors rest at its end
//! ```
//!
//! At a terminal, `moco drive` shows the progress of uploads and moves as a bar instead of lines.
//!
//! `moco simulate` prints the address of the rig as soon as clients can connect. Ctrl-C ends it, with status 0.
//!
//! Real rigs are heavy. Use `moco drive` with one only if an emergency stop that needs no software is within reach. If the
//! program is killed, or its cable is cut, a kOS move goes on, as its protocol requires. A hoot program goes on, unless the
//! dead-man switch of the node stops it after a second. A DMC jog goes on until the rig notices or reaches a limit, because
//! DMC has no keep-alive.
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
//! After Ctrl-C, and after any failure of a command that may have moved a motor, `moco drive` first stops the motors, over a
//! new connection if necessary. Then it ends with one line on standard error that says what to do, and whether the rig
//! confirmed the stop.
//!
//! The exit statuses of all commands are those of [`Status`](examples::program::Status), and 0 if a command is done.
//!
//! # JSON
//!
//! With `--json`, each line is an object. All texts are those of the lines without `--json`.
//!
//! | command | standard output | standard error |
//! |---|---|---|
//! | `inspect` | an object for each frame | |
//! | `one-move` | `protocol`, `kind` and `text` of each line; `axis`, `time`, `amount` and `unit` of a `loss`, and of what a rig `played` | |
//! | `simulate` | `protocol` and `address`, when clients can connect; with `--list` `kind`, `name` and `about` of each device and quirk, and of devices whether they are the `default` | the log: `timestamp` in seconds, `level`, `message` |
//! | `drive` | `event` of each line, see below | the log, with `-v` |
//! | each, if it fails | | `error` and the exit `status` |
//!
//! | event | fields | meaning |
//! |---|---|---|
//! | `note` | `text` | for people |
//! | `position` | `motor`, `position`, `text` | position of a motor at rest, or now: rotations (kOS) or steps (DMC, hoot) |
//! | `progress` | `part`, `positions`, `text` | part of the command that is done, from 0 to 1, `null` if it is not known; `motor` and `position` of each motor that is known |
//! | `done` | | the command is done; without this event it is not |
//!
//! # Modules
//!
//! | | |
//! |---|---|
//! | [`serve`] | a rig of the crate `rigs` in real time: TCP, pseudo-terminals, datagrams, and a record of its motors |
//! | [`session`] | a host of the crate `rigs` in real time: TCP and serial lines |
//! | [`plot`](mod@plot), [`one_move`](mod@one_move), [`simulate`], [`drive`] | the commands; `inspect` is in the package `examples` |
//! | [`program`] | functions that several commands use |

pub mod drive;
mod hosted;
pub mod one_move;
pub mod plot;
pub mod program;
pub mod serve;
pub mod session;
pub mod simulate;
