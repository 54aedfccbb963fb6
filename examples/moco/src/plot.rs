//! Command `plot`: draws a move file.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Parser;
use examples::program::{Failure, written};
use motion_move::Move;

/// Draw a move file: position, velocity and acceleration of each axis over time
///
/// Limits are dashed lines. A curve is red where it exceeds them, and the output has a line for each excess.
#[derive(Debug, Clone, PartialEq, Parser)]
pub struct Args {
    /// Move file, such as examples/moves/crane.json
    pub file: PathBuf,
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

/// Draws the move file. The excesses and the names of the pictures are written to `output`.
///
/// # Errors
///
/// The move file cannot be read, or a picture cannot be written.
pub fn plot(args: &Args, output: &mut impl Write) -> Result<(), Failure> {
    let subject = Move::read(&args.file).map_err(Failure::not_done)?;
    let (svg, png) = match (&args.svg, &args.png) {
        (None, None) => {
            let folder = args.out.clone().unwrap_or_default();
            let path = folder.join(args.file.file_name().unwrap_or_default());
            (Some(path.with_extension("svg")), Some(path.with_extension("png")))
        }
        (svg, png) => (svg.clone(), png.clone()),
    };
    for excess in subject.excesses() {
        say(output, &excess.to_string())?;
    }
    if let Some(path) = svg {
        write(output, &path, plot::svg(&subject).map_err(Failure::not_done)?.as_bytes())?;
    }
    if let Some(path) = png {
        let mut bytes = Vec::new();
        plot::png(&subject, &mut bytes).map_err(Failure::not_done)?;
        write(output, &path, &bytes)?;
    }
    Ok(())
}

fn write(output: &mut impl Write, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let name = path.display().to_string();
    fs::write(path, bytes).map_err(|error| Failure::not_done(format!("{name}: {error}")))?;
    say(output, &name)
}

/// Writes a line. Pictures are drawn even if nobody reads the output.
fn say(output: &mut impl Write, line: &str) -> Result<(), Failure> {
    written(writeln!(output, "{line}"))
}
