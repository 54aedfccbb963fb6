//! Command `drive`: it does a command, and stops all motors if the command fails.

use std::io;
use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use clap::Parser;
use examples::program::{STATUSES, Status};
use motion_rigs::dmc_host::DmcHost;
use motion_rigs::kos_host::KosHost;
use tokio::sync::mpsc::UnboundedReceiver;

use super::address::Address;
use super::printer::{Form, Printer};
use super::{Command, Driven, Trouble, dmc, foreign, hoot, kos};
use crate::session::{Session, Target};
use crate::simulate::Protocol;

/// Drive a rig, simulated or real.
#[derive(Debug, Clone, PartialEq, Parser)]
#[command(after_help = STATUSES)]
pub struct Args {
    /// Protocol of the rig.
    #[arg(value_enum)]
    pub protocol: Protocol,
    /// Address of the rig: HOST or HOST:PORT; a serial device such as /dev/ttyUSB0 or COM3 (DMC, hoot); or
    /// udp://ADDRESS:PORT to wait there for a rig that announces itself (kOS).
    pub address: String,
    /// Command to do.
    #[command(subcommand)]
    pub command: Command,
    /// Password of the rig (kOS) [default: the password that the rig reports]
    #[arg(long, global = true, value_name = "TEXT")]
    pub password: Option<String>,
    /// TCP port of a rig that announced itself (kOS).
    #[arg(long, global = true, default_value_t = kos_proto::discovery::DEFAULT_PORT)]
    pub port: u16,
    /// Time to wait for an announcement, in seconds (kOS).
    #[arg(long, global = true, value_name = "SECONDS", default_value_t = 15)]
    pub wait: u16,
    /// Speed with which motors go to the start of a move, as a part of their greatest speed (kOS, hoot).
    #[arg(long, global = true, value_name = "PART", default_value_t = kos::Options::default().home_speed)]
    pub home_speed: f32,
    /// Speed of the serial line, in bits per second [default: 115200 for DMC, 57600 for hoot]
    #[arg(long, global = true)]
    pub baud: Option<u32>,
    /// Time to wait for an answer before a request is sent again, in milliseconds (DMC) [default: 500]
    #[arg(long, global = true, value_name = "MILLISECONDS", value_parser = clap::value_parser!(u32).range(1..))]
    pub timeout: Option<u32>,
    /// Address of the node, from 2 to 255 (hoot).
    #[arg(long, global = true, default_value_t = hoot_proto::Address::DEFAULT.0, value_parser = clap::value_parser!(u8).range(2..))]
    pub node: u8,
    /// Print one JSON object per line: "event" ("note", "position", "progress", or "done" at the end), "text", "motor",
    /// "position", "part" (from 0 to 1), "positions".
    #[arg(long, global = true)]
    pub json: bool,
    /// Log events of the line; given twice, also each message; given three times, also each piece of bytes.
    #[arg(long, short, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// Does the command of the arguments.
///
/// # Errors
///
/// [`Trouble`], as one line that says what to do. All motors are stopped by then, or the line says that the stop is not
/// confirmed.
pub async fn drive(args: &Args, interrupts: UnboundedReceiver<()>) -> Result<(), Trouble> {
    match command(args, interrupts).await {
        // Somebody wants that everything rests, and it is not known.
        Err(trouble) if args.command == Command::Stop && trouble.status() != Status::Usage => {
            Err(Trouble::MayMove(trouble.to_string()))
        }
        done => done,
    }
}

async fn command(args: &Args, interrupts: UnboundedReceiver<()>) -> Result<(), Trouble> {
    let address = Address::parse(&args.address, args.protocol)?;
    let form = match args.verbose {
        _ if args.json => Form::Json,
        0 => Form::of_terminal(),
        // The log and a bar would be mixed.
        _ => Form::Text,
    };
    let mut out = Printer::new(io::stdout(), form);
    let command = &args.command;
    let done = match args.protocol {
        Protocol::Kos => {
            let mut interrupts = interrupts;
            let target = tokio::select! {
                biased;
                Some(()) = interrupts.recv() => return Err(Trouble::Interrupted),
                target = find(args, &address) => target?,
            };
            let password = args.password.as_deref().map(str::as_bytes);
            let host = KosHost::new(kos_proto::host::Options::default(), password);
            let options = kos::Options { home_speed: args.home_speed, ..kos::Options::default() };
            let flow = async |session: &mut _| kos::drive(session, command, &options, &mut out).await;
            Box::pin(with(args.protocol, host, target, interrupts, flow)).await
        }
        Protocol::Dmc => {
            let baud = args.baud.unwrap_or(115_200);
            let target = address.target(baud).await?;
            let host = DmcHost::new(dmc::options(baud, args.timeout));
            let flow = async |session: &mut _| dmc::drive(session, command, &mut out).await;
            Box::pin(with(args.protocol, host, target, interrupts, flow)).await
        }
        Protocol::Hoot => {
            let target = address.target(args.baud.unwrap_or(57_600)).await?;
            let node = hoot_proto::Address(args.node);
            let flow = async |session: &mut _| hoot::drive(session, command, node, args.home_speed, &mut out).await;
            Box::pin(with(args.protocol, hoot::master(node)?, target, interrupts, flow)).await
        }
    };
    done.inspect(|()| out.done())
}

/// Address of a kOS rig. If it is unknown, waits for an announcement.
async fn find(args: &Args, address: &Address) -> Result<Target, Trouble> {
    let Address::Announced(ours) = *address else { return address.target(0).await };
    let found = kos::discover(ours, None, Duration::from_secs(args.wait.into()), false).await?;
    let first = found.first().map(|device| IpAddr::V4(device.address().into()));
    let rig = first.ok_or_else(|| Trouble::Line(format!("{ours}: no kOS rig announced itself")))?;
    Ok(Target::Tcp(SocketAddr::new(rig, args.port)))
}

/// Does a command over a line. If the command fails, motors that it set in motion are stopped. If it is interrupted,
/// everything is stopped.
///
/// A device that speaks another protocol than `protocol` obeys no stop, so nothing waits for one.
async fn with<H: Driven>(
    protocol: Protocol,
    host: H,
    target: Target,
    interrupts: UnboundedReceiver<()>,
    flow: impl AsyncFnOnce(&mut Session<H>) -> Result<(), Trouble>,
) -> Result<(), Trouble> {
    let mut session = Session::connect(host, target, interrupts).await?;
    let done = flow(&mut session).await;
    let may_move = session.host().may_move();
    if let (Err(Trouble::Line(_) | Trouble::Lost(_) | Trouble::Failed(_)), Some(spoken)) =
        (&done, foreign::spoken(session.heard()))
        && spoken != protocol
    {
        let line = foreign::line(spoken, protocol);
        return Err(if may_move {
            Trouble::MayMove(format!("{line}, or press the emergency stop"))
        } else {
            Trouble::Refused(line)
        });
    }
    let trouble = match done {
        Ok(()) if !may_move => return Ok(()),
        Ok(()) => Trouble::Failed("the command is done, but the rig did not report that all motors rest".to_owned()),
        Err(trouble) if !may_move && !matches!(trouble, Trouble::Interrupted) => return Err(trouble),
        // The stop is already confirmed, as far as it can be.
        Err(trouble @ Trouble::MayMove(_)) => return Err(trouble),
        Err(trouble) => trouble,
    };
    Err(Trouble::Stopped(Box::new(trouble), session.stop().await))
}
