//! Command `plot`: draws a move file, or the moves of a capture.

mod capture;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Parser;
use examples::cli::{self, Protocol, Transport};
use examples::program::{Failure, written};
use examples::text::{Format, Senders};
use motion_move::Move;
use plot::Subject;

/// Draw a move file or a capture: position, velocity and acceleration of each axis over time
///
/// Limits are dashed lines. A curve is red where it exceeds them, and the output has a line for each excess.
///
/// With --protocol, the file is a capture, as `moco inspect` reads it. Moves that a host sends to kOS motors, and uploads
/// to DMC controllers, are drawn with one panel for each motor.
#[derive(Debug, Clone, PartialEq, Parser)]
pub struct Args {
    /// Move file, such as examples/moves/crane.json, or a capture
    pub file: PathBuf,
    /// Protocol of a capture
    #[arg(long, value_enum)]
    pub protocol: Option<Protocol>,
    /// Sender of the bytes of a capture; not needed if its lines are marked > (host) and < (device)
    #[arg(long, value_enum, requires = "protocol")]
    pub from: Option<Senders>,
    /// Transport that carried the bytes of a capture
    #[arg(long, value_enum, default_value_t, requires = "protocol")]
    pub transport: Transport,
    /// Format of a capture
    #[arg(long, value_enum, default_value_t, requires = "protocol")]
    pub format: Format,
    /// Folder for an SVG and a PNG with the name of the file; by default the current folder
    #[arg(long, conflicts_with_all = ["svg", "png"])]
    pub out: Option<PathBuf>,
    /// File for an SVG
    #[arg(long)]
    pub svg: Option<PathBuf>,
    /// File for a PNG
    #[arg(long)]
    pub png: Option<PathBuf>,
}

/// Draws the move file or the capture. The excesses and the names of the pictures are written to `output`.
///
/// # Errors
///
/// The file cannot be read, a capture has no complete move, or a picture cannot be written.
pub fn plot(args: &Args, output: &mut impl Write) -> Result<(), Failure> {
    if let Some(protocol) = args.protocol {
        let capture = cli::Args {
            protocol: Some(protocol),
            from: args.from,
            transport: args.transport,
            format: args.format,
            json: false,
            show_secrets: false,
            file: args.file.clone(),
        };
        let (recording, faults) = capture::read(&capture, protocol)?;
        for fault in faults {
            say(output, &fault)?;
        }
        return draw(args, Subject::from(&recording), output);
    }
    let subject = Move::read(&args.file).map_err(Failure::not_done)?;
    for excess in subject.excesses() {
        say(output, &excess.to_string())?;
    }
    draw(args, Subject::from(&subject), output)
}

fn draw(args: &Args, subject: Subject<'_>, output: &mut impl Write) -> Result<(), Failure> {
    let (svg, png) = match (&args.svg, &args.png) {
        (None, None) => {
            let folder = args.out.clone().unwrap_or_default();
            let path = folder.join(args.file.file_name().unwrap_or_default());
            (Some(path.with_extension("svg")), Some(path.with_extension("png")))
        }
        (svg, png) => (svg.clone(), png.clone()),
    };
    if let Some(path) = svg {
        write(output, &path, plot::svg(subject).map_err(Failure::not_done)?.as_bytes())?;
    }
    if let Some(path) = png {
        let mut bytes = Vec::new();
        plot::png(subject, &mut bytes).map_err(Failure::not_done)?;
        write(output, &path, &bytes)?;
    }
    Ok(())
}

fn write(output: &mut impl Write, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    say(output, &save(path, bytes)?)
}

/// Writes a picture, and returns its name.
pub(crate) fn save(path: &Path, bytes: &[u8]) -> Result<String, Failure> {
    let name = path.display().to_string();
    match fs::write(path, bytes) {
        Ok(()) => Ok(name),
        Err(error) => Err(Failure::not_done(format!("{name}: {error}"))),
    }
}

/// Writes a line. Pictures are drawn even if nobody reads the output.
fn say(output: &mut impl Write, line: &str) -> Result<(), Failure> {
    written(writeln!(output, "{line}"))
}
