//! What a rig can be told on the command line.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// What to do. Positions and speeds are in the units of the protocol: rotations (kOS), steps (DMC, hoot), a second.
#[derive(Debug, Clone, PartialEq, Subcommand)]
pub enum Command {
    /// Tell what the rig is, and where its motors are.
    Info,
    /// Run a motor for a while.
    #[command(allow_negative_numbers = true)]
    Jog {
        /// Which motor, from 1 on.
        motor: u8,
        /// How fast, a second; backward if negative. Of DMC, in percent of the greatest speed.
        speed: f64,
        /// For how many seconds.
        #[arg(long = "for", value_name = "SECONDS", default_value_t = 1.0)]
        seconds: f64,
    },
    /// Send a motor to a position.
    #[command(allow_negative_numbers = true)]
    Move {
        /// Which motor, from 1 on.
        motor: u8,
        /// Where to.
        position: f64,
        /// How fast, a second [default: a quarter of the greatest; of DMC, what the rig is set to]
        #[arg(long)]
        speed: Option<f64>,
    },
    /// Mark the range in which a motor may go: it is sent to both ends.
    #[command(allow_negative_numbers = true)]
    Calibrate {
        /// Which motor, from 1 on.
        motor: u8,
        /// Where its range begins.
        begin: f64,
        /// Where its range ends.
        end: f64,
    },
    /// Store a move file, and make it ready.
    Upload {
        /// The move file.
        file: PathBuf,
    },
    /// Store a move file, and play it in its own time.
    Run {
        /// The move file.
        file: PathBuf,
        /// From its end to its start.
        #[arg(long)]
        reverse: bool,
    },
    /// Store a move file, and take photos along it: a time lapse, or stop motion.
    Program {
        /// The move file.
        file: PathBuf,
        /// How they are taken.
        #[command(flatten)]
        shots: Shots,
    },
    /// Take one photo.
    Expose {
        /// For how many seconds the shutter is open.
        #[arg(default_value_t = 0.1)]
        seconds: f64,
    },
    /// Stop everything.
    Stop,
}

/// How photos are taken along a move.
#[derive(Debug, Clone, Copy, PartialEq, Args)]
pub struct Shots {
    /// How many photos.
    #[arg(long, default_value_t = 10)]
    pub shots: u32,
    /// Seconds from one photo to the next.
    #[arg(long, default_value_t = 2.0)]
    pub interval: f64,
    /// Seconds for which the shutter is open.
    #[arg(long, default_value_t = 0.1)]
    pub exposure: f64,
    /// Whether the motors go on while the shutter is open; otherwise they rest.
    #[arg(long)]
    pub continuous: bool,
}
