//! Commands for a rig on the command line.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// Command for a rig. Positions are in rotations (kOS) or steps (DMC, hoot), and speeds in the same per second.
#[derive(Debug, Clone, PartialEq, Subcommand)]
pub enum Command {
    /// Print what the rig is, and the positions of its motors.
    Info,
    /// Run a motor for a time.
    #[command(allow_negative_numbers = true)]
    Jog {
        /// Number of the motor, from 1.
        motor: u8,
        /// Speed, per second (kOS, hoot) or in percent of the greatest speed (DMC). Negative is backward.
        speed: f64,
        /// Duration in seconds.
        #[arg(long = "for", value_name = "SECONDS", default_value_t = 1.0)]
        seconds: f64,
    },
    /// Send a motor to a position.
    #[command(allow_negative_numbers = true)]
    Move {
        /// Number of the motor, from 1.
        motor: u8,
        /// Position to move to.
        position: f64,
        /// Speed, per second [default: a quarter of the greatest (kOS, hoot), the setting of the rig (DMC)]
        #[arg(long)]
        speed: Option<f64>,
    },
    /// Set the range in which a motor may move. The motor moves to both ends.
    #[command(allow_negative_numbers = true)]
    Calibrate {
        /// Number of the motor, from 1.
        motor: u8,
        /// Position at which the range begins.
        begin: f64,
        /// Position at which the range ends.
        end: f64,
    },
    /// Store a move file on the rig, and make the move ready. On hoot, the motors go to the start of the move.
    Upload {
        /// The move file.
        file: PathBuf,
    },
    /// Store a move file on the rig, and play the move in real time.
    Run {
        /// The move file.
        file: PathBuf,
        /// Play the move from its end to its start.
        #[arg(long)]
        reverse: bool,
    },
    /// Store a move file on the rig, and take photos along the move: a time lapse, or stop motion.
    Program {
        /// The move file.
        file: PathBuf,
        /// Settings of the photos.
        #[command(flatten)]
        shots: Shots,
    },
    /// Take one photo.
    Expose {
        /// Time for which the shutter is open, in seconds.
        #[arg(default_value_t = 0.1)]
        seconds: f64,
    },
    /// Stop everything.
    Stop,
}

/// Settings of the photos along a move.
#[derive(Debug, Clone, Copy, PartialEq, Args)]
pub struct Shots {
    /// Number of photos.
    #[arg(long, default_value_t = 10)]
    pub shots: u32,
    /// Time from one photo to the next, in seconds.
    #[arg(long, default_value_t = 2.0)]
    pub interval: f64,
    /// Time for which the shutter is open, in seconds.
    #[arg(long, default_value_t = 0.1)]
    pub exposure: f64,
    /// Let the motors move while the shutter is open; otherwise they rest.
    #[arg(long)]
    pub continuous: bool,
}
