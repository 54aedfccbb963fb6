//! Commands as hoot has them.
//!
//! | command | what is done |
//! |---|---|
//! | `info` | asks the node for its version, name, state, and for each of its motors |
//! | `jog` | runs a motor with the dead-man on, in joystick mode, and keeps the node alive meanwhile |
//! | `move` | sets the end of the planned move there, and sends the motor to it: a move by a number of steps would go twice as far if the line doubled it |
//! | `calibrate` | sends the motor to the beginning and makes it home (position 0), and to the end and makes it the end limit |
//! | `upload` | stores a planned move for each axis of the node, and sends the motors to its start |
//! | `run` | the same, and plays it by the clock (video mode) |
//! | `program` | the same, and takes photos along it: shoot, move, shoot; with `--continuous` a time lapse |
//! | `expose` | takes a photo |
//! | `stop` | an emergency stop |
//!
//! A planned move knows two places, a time, and how speed is gained and lost: [`plan`] says which axes it can do. While
//! something moves, the dead-man is on: should the program or the line die, the motors stop after a second. When all is
//! done it is switched off; behind a trouble it stays on.
//!
//! hoot has no checksum, and firmware says OK to much that it does not do: what is set is asked for, and what was to move
//! is asked where it is. What sets something in motion is sent once; if nobody answers it, the motors are asked.

mod follow;
mod info;
mod motion;
pub mod plan;
mod talk;

use std::io::Write;

use hoot_proto::Address;
use hoot_proto::host::{Command as MasterCommand, Event as Told, Nodes, Options};
use motion_core::time::Millis;
use rigs::Host;
use rigs::hoot_master::{Event, HootMaster};

use super::{Command, Driven, Stopped, Trouble};
use crate::session::Session;
use talk::Talk;

impl Driven for HootMaster {
    const OPENS: bool = false;

    fn may_move(&self) -> bool {
        HootMaster::may_move(self)
    }

    fn stop_all(&mut self, now: Millis) {
        self.command(now, MasterCommand::EmergencyStop);
    }

    fn stopped(event: &Event) -> Option<Stopped> {
        match event {
            Event::Told(Told::StopConfirmed) => Some(Stopped::Confirmed),
            Event::Told(Told::StopNotConfirmed { node: None }) => Some(Stopped::NotConfirmed),
            _ => None,
        }
    }
}

/// The master for one node.
///
/// # Errors
///
/// [`Trouble::Refused`] if no node can have this address.
pub fn master(node: Address) -> Result<HootMaster, Trouble> {
    let nodes = Nodes::NONE.with(node);
    let nodes = nodes.ok_or_else(|| Trouble::Refused(format!("address {}: nodes have 2 to 255", node.0)))?;
    Ok(HootMaster::new(Options::default().with_nodes(nodes)))
}

/// Does a command at a node, and prints what comes of it. Motors go to where a move begins at this part of their greatest
/// speed.
///
/// # Errors
///
/// [`Trouble`]. Then something may still move: [`Driven::may_move`] says so.
pub async fn drive(
    session: &mut Session<HootMaster>,
    command: &Command,
    node: Address,
    home_speed: f32,
    out: &mut dyn Write,
) -> Result<(), Trouble> {
    let mut talk = Talk::new(session, node, home_speed, out);
    match command {
        Command::Info => talk.info().await,
        Command::Jog { motor, speed, seconds } => talk.jog(*motor, *speed, *seconds).await,
        Command::Move { motor, position, speed } => talk.go(*motor, *position, *speed).await,
        Command::Calibrate { motor, begin, end } => talk.calibrate(*motor, *begin, *end).await,
        Command::Upload { file } => talk.upload(file).await,
        Command::Run { file, reverse } => talk.run(file, *reverse).await,
        Command::Program { file, shots } => talk.program(file, *shots).await,
        Command::Expose { seconds } => talk.expose(*seconds).await,
        Command::Stop => match talk.session.stop().await {
            Stopped::Confirmed => talk.say("all motors rest: the node confirmed it"),
            Stopped::NotConfirmed => Err(Trouble::Failed(format!(
                "node {} did not confirm the stop: cut the power if something moves",
                node.0
            ))),
        },
    }
}
