//! The command line of `plot`, and what it does.

use std::ffi::OsString;
use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use examples::moves::{Move, MoveError};
use examples::program::{fail, reason};

/// Draw a move file: position, velocity and acceleration of each axis over time
///
/// Limits are dashed lines. Where a curve is beyond them it is red, and a line of the output says so.
#[derive(Debug, Parser)]
#[command(name = "plot", version)]
struct Args {
    /// The move file, such as examples/moves/crane.json
    file: PathBuf,
    /// The folder for an SVG and a PNG with the name of the file; the current one if nothing is said
    #[arg(long, conflicts_with_all = ["svg", "png"])]
    out: Option<PathBuf>,
    /// Where to write an SVG
    #[arg(long)]
    svg: Option<PathBuf>,
    /// Where to write a PNG
    #[arg(long)]
    png: Option<PathBuf>,
}

/// Why the program ends without a picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Stop {
    /// Help or the version was asked for.
    #[error("{0}")]
    Help(clap::Error),
    /// The command line is wrong.
    #[error("{0}")]
    Usage(String),
    /// The file is no move.
    #[error("{0}")]
    Move(#[from] MoveError),
    /// The picture cannot be drawn.
    #[error("{0}")]
    Draw(#[from] Box<dyn std::error::Error>),
    /// A picture cannot be written.
    #[error("{name}: {error}")]
    File {
        /// The name of the file.
        name: String,
        /// What the operating system says.
        #[source]
        error: io::Error,
    },
    /// The output cannot be written on.
    #[error("{0}")]
    Output(#[from] io::Error),
}

/// Does what a command line asks for, the program's name first; `say` gets the excesses, and the names of the pictures.
///
/// # Errors
///
/// [`Stop`].
pub fn run(args: impl IntoIterator<Item = OsString>, say: &mut impl Write) -> Result<(), Stop> {
    let args: Vec<OsString> = args.into_iter().collect();
    if args.len() < 2 {
        return Err(Stop::Usage("which move file? Try examples/moves/crane.json (see --help)".to_owned()));
    }
    let args = Args::try_parse_from(args)
        .map_err(|error| if error.use_stderr() { Stop::Usage(reason(&error)) } else { Stop::Help(error) })?;
    let subject = Move::read(&args.file)?;
    let (svg, png) = match (args.svg, args.png) {
        (None, None) => {
            let path = args.out.unwrap_or_default().join(args.file.file_name().unwrap_or_default());
            (Some(path.with_extension("svg")), Some(path.with_extension("png")))
        }
        given => given,
    };
    for excess in subject.excesses() {
        writeln!(say, "{excess}")?;
    }
    if let Some(path) = svg {
        write(say, &path, crate::svg(&subject)?.as_bytes())?;
    }
    if let Some(path) = png {
        let mut bytes = Vec::new();
        crate::png(&subject, &mut bytes)?;
        write(say, &path, &bytes)?;
    }
    Ok(())
}

fn write(say: &mut impl Write, path: &Path, bytes: &[u8]) -> Result<(), Stop> {
    let name = path.display().to_string();
    match fs::write(path, bytes) {
        Ok(()) => Ok(writeln!(say, "{name}")?),
        Err(error) => Err(Stop::File { name, error }),
    }
}

/// Ends the program: status 0, or one line on standard error and status 1.
///
/// Help is no failure, nor is a reader of the output that has seen enough.
#[must_use]
pub fn exit(result: Result<(), Stop>) -> ExitCode {
    let result = match result {
        Err(Stop::Help(help)) => help.print().map_err(Stop::from),
        other => other,
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Stop::Output(error)) if error.kind() == ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(stop) => fail("plot", &stop.to_string()),
    }
}
