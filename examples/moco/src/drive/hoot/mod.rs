//! Commands with hoot.
//!
//! | command | effect |
//! |---|---|
//! | `info` | asks the node for its version, name and state, and for each of its motors |
//! | `jog` | runs a motor, with the dead-man switch on and keep-alive messages |
//! | `move` | moves the motor by the number of steps from where it rests to the position |
//! | `calibrate` | moves the motor to both ends of the range, and sets them as home (position 0) and, if the firmware has limits, as the end limit |
//! | `upload` | stores a planned move for each axis of the node, and sends the motors to their start |
//! | `run` | as `upload`, then plays the move in real time (video mode), without photos |
//! | `program` | as `upload`, then takes photos along the move: shoot, move, shoot; with `--continuous` a time lapse |
//! | `expose` | takes a photo; refused if the firmware may be too old for it |
//! | `stop` | makes an emergency stop |
//!
//! Motors go to their places by a number of steps, because the commands that send them to a position ignore the speed in
//! firmware since 2014-11-03 (decision H-42).
//!
//! Some firmware chooses the microsteps of all motors when a program starts, and keeps them when it is switched off. There,
//! steps are those of a new node: four microsteps, and sixteen for motors 2 and 3 from v0.23 on. They are set before a motor
//! moves (decision H-81). A program moves no motor without an axis: its planned move begins and ends where it is (decision
//! H-82).
//!
//! Danger: if the node inverts the direction of a motor, or receives the move twice, the motor goes away from its place. All
//! motors are stopped when a position shows it, which is some hundreds of milliseconds later.
//!
//! A planned move has two positions, a time, and the lengths of acceleration and deceleration. [`plan`] says which axes
//! it can follow. While something moves, the dead-man switch is on: if the program or the line fails, the motors stop
//! after a second. It is switched off when all is done. After a failure it stays on.
//!
//! hoot has no checksum, and firmware answers OK to many messages that it does not execute. So each setting is read
//! back, and each motor is asked for its position after its move. A message that starts motion is sent once; if it is
//! not answered, the motors are asked.

mod follow;
mod info;
mod motion;
pub mod plan;
mod talk;

use hoot_proto::Address;
use hoot_proto::host::{Command as MasterCommand, Event as MachineEvent, Nodes, Options, StopTarget, Token};
use motion_core::time::Millis;
use motion_rigs::Host;
use motion_rigs::hoot_master::{Event, HootMaster};

use super::output::Output;
use super::{Command, Driven, OBEYED, Stopped, Trouble};
use crate::session::Session;
use talk::Talk;

impl Driven for HootMaster {
    fn may_move(&self) -> bool {
        self.machine().may_move()
    }

    fn stop_all(&mut self, now: Millis) {
        self.command(now, (Token::default(), MasterCommand::EmergencyStop));
    }

    fn stopped(event: &Event) -> Option<Stopped> {
        match event {
            Event::Machine(MachineEvent::Stopped(StopTarget::All)) => Some(Stopped::Confirmed),
            Event::Machine(MachineEvent::StopNotConfirmed(StopTarget::All)) => Some(Stopped::NotConfirmed),
            _ => None,
        }
    }
}

/// Makes the master for one node.
///
/// # Errors
///
/// [`Trouble::Refused`] if no node can have this address.
pub fn master(node: Address) -> Result<HootMaster, Trouble> {
    let nodes = Nodes::NONE.with(node);
    let nodes = nodes.ok_or_else(|| Trouble::Refused(format!("address {}: nodes have addresses 2 to 255", node.0)))?;
    Ok(HootMaster::new(Options::new().with_nodes(nodes)))
}

/// Does a command at a node, and prints its results. `home_speed` is the speed with which motors go to the start of a
/// move, as a part of their greatest speed.
///
/// # Errors
///
/// [`Trouble`]. After it, motors may still move; see [`Driven::may_move`].
pub async fn drive(
    session: &mut Session<HootMaster>,
    command: &Command,
    node: Address,
    home_speed: f32,
    out: &mut dyn Output,
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
            Stopped::Confirmed => talk.print("all motors rest: the node confirmed it"),
            Stopped::Obeyed => Err(Trouble::MayMove(OBEYED.to_owned())),
            Stopped::NotConfirmed => Err(Trouble::Failed(format!(
                "node {} did not confirm the stop: switch its power off if a motor moves",
                node.0
            ))),
        },
    }
}
