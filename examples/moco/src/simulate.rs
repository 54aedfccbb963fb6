//! Command `simulate`: a rig and its lines, as the arguments describe them.

use std::ffi::OsStr;
use std::io::{self, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;

use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use clap::{Arg, Command, Parser, ValueEnum};
use examples::program::{Failure, STATUSES, written};
use motion_rigs::Rig;
use motion_rigs::device::{self, Kind, Named};
use motion_rigs::dmc_device::{self, DmcDevice};
use motion_rigs::faults::{Carrier, Faults};
use motion_rigs::hoot_node::{self, HootNode};
use motion_rigs::kos_device::{self, KosDevice};
use serde_json::json;
use tokio::net::TcpListener;
use tokio::sync::mpsc::UnboundedReceiver;
use tracing::info;

use crate::serve::{Announcer, Door, Options, Record, Server, listen};

/// Run a simulated rig on a real transport, until Ctrl-C.
#[derive(Debug, Clone, PartialEq, Parser)]
#[command(after_help = STATUSES)]
#[expect(clippy::struct_excessive_bools, reason = "flags of a command line")]
pub struct Args {
    /// Protocol of the rig.
    #[arg(value_enum)]
    pub protocol: Protocol,
    /// Address at which to listen for TCP connections.
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::from(Ipv4Addr::LOCALHOST))]
    pub listen: IpAddr,
    /// TCP port; 0 for any free port [default: 5520 for kOS, 5521 for DMC, 5522 for hoot]
    #[arg(long)]
    pub port: Option<u16>,
    /// Announce the rig by datagrams to this address, and answer questions (kOS).
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub announce: Option<SocketAddr>,
    /// Serve a pseudo-terminal, which is the default for DMC and hoot on systems with pseudo-terminals.
    #[arg(long, conflicts_with = "tcp")]
    pub pty: bool,
    /// Serve TCP, which is the default for kOS.
    #[arg(long)]
    pub tcp: bool,
    /// Number of motors of the rig [default: 3 for kOS and hoot, 4 for DMC]
    #[arg(long)]
    pub motors: Option<u8>,
    /// Seed of everything that is random.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Faults: "all", or a list such as "delay=40,reset=20" (an unknown name prints all names).
    #[arg(long, value_name = "LIST")]
    pub faults: Option<String>,
    /// Device of the field that the rig stands for; --list prints all of them, and the default.
    #[arg(long, value_name = "NAME", value_parser = Names(Kind::Device), hide_possible_values = true)]
    pub device: Option<String>,
    /// Single differences of the rig from the device: a list; --list prints all of them.
    #[arg(long, value_name = "LIST", default_value = "", value_parser = Names(Kind::Quirk), hide_possible_values = true)]
    pub quirks: String,
    /// Print the devices and quirks of the protocol, and end.
    #[arg(long)]
    pub list: bool,
    /// Password of the rig (kOS).
    #[arg(long, value_name = "TEXT")]
    pub password: Option<String>,
    /// File for a record of the motors as CSV: milliseconds, motor, position, and moment of the move.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Print JSON objects instead of lines: {"protocol", "address"} when clients can connect, the log with "timestamp" in
    /// seconds, "level" and "message", and with --list {"kind", "name", "about"} for each device and quirk, whose name may be
    /// a pattern.
    #[arg(long)]
    pub json: bool,
    /// Log each message; given twice, also each piece of bytes.
    #[arg(long, short, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// Parser of names of devices or quirks, which completes those of all protocols. Any name is accepted here, because there are
/// patterns for more of them.
#[derive(Debug, Clone)]
struct Names(Kind);

impl TypedValueParser for Names {
    type Value = String;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<String, clap::Error> {
        StringValueParser::new().parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let mut all =
            [names::<kos_device::Setup>(), names::<dmc_device::Setup>(), names::<hoot_node::Setup>()].concat();
        all.retain(|(kind, ..)| *kind == self.0);
        all.sort_by_key(|(_, name, _)| *name);
        all.dedup_by_key(|(_, name, _)| *name);
        Some(Box::new(all.into_iter().map(|(_, name, about)| PossibleValue::new(name).help(about))))
    }
}

/// Kinds, names and meanings of the devices and quirks of a protocol.
fn names<S: Named>() -> Vec<(Kind, &'static str, &'static str)> {
    let devices = S::DEVICES.iter().map(|device| (Kind::Device, device.name, device.about));
    devices.chain(S::QUIRKS.iter().map(|quirk| (Kind::Quirk, quirk.name, quirk.about))).collect()
}

/// Devices and quirks of a protocol, in the form that the arguments ask for.
fn list<S: Named>(args: &Args) -> String {
    if !args.json {
        return format!("{}Device without --device: {}\n", device::list::<S>(), args.protocol.default_device());
    }
    let all = names::<S>().into_iter().chain(S::FAMILIES.iter().copied());
    let objects = all.map(|(kind, name, about)| match kind {
        Kind::Device => {
            let is_default = name == args.protocol.default_device();
            json!({ "kind": "device", "name": name, "about": about, "default": is_default })
        }
        Kind::Quirk => json!({ "kind": "quirk", "name": name, "about": about }),
    });
    objects.map(|object| object.to_string() + "\n").collect()
}

/// Protocol of a rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Protocol {
    /// Kessler kOS: TCP, and UDP for discovery.
    Kos,
    /// Dragonframe DMC: a serial line.
    Dmc,
    /// Dynamic Perception NMX: a serial line.
    Hoot,
}

impl Protocol {
    /// Name of the protocol.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Kos => "kOS",
            Self::Dmc => "DMC",
            Self::Hoot => "hoot",
        }
    }

    /// Name of the protocol on the command line.
    #[must_use]
    pub const fn command(self) -> &'static str {
        match self {
            Self::Kos => "kos",
            Self::Dmc => "dmc",
            Self::Hoot => "hoot",
        }
    }

    /// Device that a simulated rig stands for unless another one is named: one that exists, and that is strict.
    #[must_use]
    pub const fn default_device(self) -> &'static str {
        match self {
            Self::Kos => "printed",
            Self::Dmc => "dmc-lite",
            Self::Hoot => "v0.70",
        }
    }

    /// TCP port of the simulated rig. For kOS it is the port of the protocol; the other protocols define none.
    #[must_use]
    pub const fn port(self) -> u16 {
        match self {
            Self::Kos => kos_proto::discovery::DEFAULT_PORT,
            Self::Dmc => 5521,
            Self::Hoot => 5522,
        }
    }
}

/// Serves the rig until an interrupt. An error is one line that says what to do.
///
/// # Errors
///
/// An argument is not valid for the protocol, or the port, the terminal or the record cannot be opened.
pub async fn simulate(args: &Args, interrupts: UnboundedReceiver<()>) -> Result<(), Failure> {
    if args.list {
        let list = match args.protocol {
            Protocol::Kos => list::<kos_device::Setup>(args),
            Protocol::Dmc => list::<dmc_device::Setup>(args),
            Protocol::Hoot => list::<hoot_node::Setup>(args),
        };
        return written(io::stdout().write_all(list.as_bytes()));
    }
    match args.protocol {
        Protocol::Kos => Box::pin(serve(KosDevice::new(kos(args).map_err(Failure::usage)?), args, interrupts)).await,
        Protocol::Dmc => Box::pin(serve(DmcDevice::new(dmc(args).map_err(Failure::usage)?), args, interrupts)).await,
        Protocol::Hoot => Box::pin(serve(HootNode::new(hoot(args).map_err(Failure::usage)?), args, interrupts)).await,
    }
}

fn kos(args: &Args) -> Result<kos_device::Setup, String> {
    if args.pty {
        return Err("kOS has no serial line: leave out --pty".to_owned());
    }
    let mut setup = kos_device::Setup::with_motors(motors(args, 3, kos_proto::message::MOTORS)?.into());
    setup.password = args.password.clone().unwrap_or_default().into_bytes();
    setup.number = args.seed;
    if let IpAddr::V4(address) = args.listen {
        setup.address = address;
    }
    named(setup, args)
}

fn dmc(args: &Args) -> Result<dmc_device::Setup, String> {
    only_kos(args)?;
    named(dmc_device::Setup::with_motors(motors(args, 4, 32)?), args)
}

fn hoot(args: &Args) -> Result<hoot_node::Setup, String> {
    only_kos(args)?;
    named(hoot_node::Setup::with_motors(motors(args, 3, 3)?), args)
}

/// Setup of the device that the arguments name, with their quirks.
fn named<S: Named>(setup: S, args: &Args) -> Result<S, String> {
    let device = args.device.as_deref().unwrap_or(args.protocol.default_device());
    let setup = setup.with_device(device).and_then(|setup| setup.with_quirks(&args.quirks));
    setup.map_err(|error| error.to_string())
}

fn only_kos(args: &Args) -> Result<(), String> {
    let name = args.protocol.name();
    match (&args.announce, &args.password) {
        (Some(_), _) => Err(format!("{name} has no datagrams: leave out --announce")),
        (None, Some(_)) => Err(format!("{name} has no passwords: leave out --password")),
        (None, None) => Ok(()),
    }
}

fn motors(args: &Args, usual: u8, most: usize) -> Result<u8, String> {
    let motors = args.motors.unwrap_or(usual);
    let can_be = (1..=most).contains(&usize::from(motors));
    can_be.then_some(motors).ok_or_else(|| format!("{} has 1 to {most} motors, not {motors}", args.protocol.name()))
}

/// Faults of the lines, and faults of the datagrams. A list is used for each of them in which all its names exist.
fn faults(args: &Args, carrier: Carrier) -> Result<(Faults, Faults), String> {
    let Some(list) = &args.faults else { return Ok(Default::default()) };
    let (lines, datagrams) = (Faults::parse(list, carrier), Faults::parse(list, Carrier::Datagram));
    match (lines, datagrams) {
        (Ok(lines), datagrams) => Ok((lines, datagrams.unwrap_or_default())),
        (Err(_), Ok(datagrams)) if args.announce.is_some() => Ok((Faults::NONE, datagrams)),
        (Err(error), _) => Err(error.to_string()),
    }
}

async fn serve<R: Rig>(rig: R, args: &Args, mut interrupts: UnboundedReceiver<()>) -> Result<(), Failure> {
    let Args { protocol, seed, .. } = *args;
    let tcp = args.tcp || protocol == Protocol::Kos || !(args.pty || cfg!(unix));
    let carrier = if tcp { Carrier::Stream } else { Carrier::Serial };
    let (faults, of_datagrams) = faults(args, carrier).map_err(Failure::usage)?;
    let listener = if tcp { Some(bind(args).await?) } else { None };
    let announcer = match (&listener, args.announce) {
        (Some(listener), Some(to)) => {
            let here = listener.local_addr().map_err(Failure::not_done)?;
            let announcer = Announcer::bind(here, to, of_datagrams).await;
            Some(announcer.map_err(|error| {
                Failure::not_done(format!("the datagrams of {here}: {error}: choose another --port"))
            })?)
        }
        _ => None,
    };
    let record = args.record.as_deref().map(|path| {
        Record::create(path)
            .map_err(|error| Failure::not_done(format!("{}: {error}: choose another --record", path.display())))
    });
    let record = record.transpose()?;
    let (server, door) = Server::new(rig, Options { faults, seed, record, announcer });
    let address = match listener {
        Some(listener) => {
            let address = listener.local_addr().map_err(Failure::not_done)?;
            tokio::spawn(listen(listener, door));
            address.to_string()
        }
        None => terminal(door)?,
    };
    // A closed output is not a reason to end.
    let _ = if args.json {
        writeln!(io::stdout(), "{}", json!({ "protocol": protocol.command(), "address": address }))
    } else {
        writeln!(io::stdout(), "{} rig at {address}", protocol.name())
    };
    server.run(async { interrupts.recv().await.unwrap_or_default() }).await;
    info!("the end: interrupted");
    Ok(())
}

async fn bind(args: &Args) -> Result<TcpListener, Failure> {
    let address = SocketAddr::new(args.listen, args.port.unwrap_or(args.protocol.port()));
    let why = |error: io::Error| match error.kind() {
        io::ErrorKind::AddrInUse => format!("{address} is in use: choose another --port, or 0 for any free port"),
        io::ErrorKind::AddrNotAvailable => {
            format!("{address} is not an address of this computer: choose another --listen")
        }
        io::ErrorKind::PermissionDenied => format!("{address} is not permitted: choose a --port above 1023"),
        _ => format!("{address}: {error}"),
    };
    TcpListener::bind(address).await.map_err(|error| Failure::not_done(why(error)))
}

#[cfg(unix)]
fn terminal(door: Door) -> Result<String, Failure> {
    let no_terminal = |error| Failure::not_done(format!("no pseudo-terminal can be opened: {error}: use --tcp"));
    let pty = crate::serve::Pty::new().map_err(no_terminal)?;
    let path = pty.path().to_owned();
    tokio::spawn(pty.serve(door));
    Ok(path)
}

#[cfg(not(unix))]
fn terminal(_: Door) -> Result<String, Failure> {
    Err(Failure::usage("this system has no pseudo-terminals: use --tcp"))
}
