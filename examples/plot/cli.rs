//! The command line of `plot`, and its execution.

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
/// Limits are dashed lines. A curve is red where it exceeds them, and the output has a line for each excess.
#[derive(Debug, Parser)]
#[command(name = "plot", version)]
struct Args {
    /// The move file, such as examples/moves/crane.json
    file: PathBuf,
    /// The folder for an SVG and a PNG with the name of the file; by default the current folder
    #[arg(long, conflicts_with_all = ["svg", "png"])]
    out: Option<PathBuf>,
    /// The file for an SVG
    #[arg(long)]
    svg: Option<PathBuf>,
    /// The file for a PNG
    #[arg(long)]
    png: Option<PathBuf>,
}

/// Why the program ends without a picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CliError {
    /// The command line asks for the help or the version.
    #[error("{0}")]
    Help(clap::Error),
    /// The command line is wrong.
    #[error("{0}")]
    Usage(String),
    /// The file cannot be read as a move.
    #[error("{0}")]
    Move(#[from] MoveError),
    /// The picture cannot be drawn.
    #[error("{0}")]
    Draw(#[from] Box<dyn std::error::Error>),
    /// A picture cannot be written.
    #[error("{name}: {error}")]
    File {
        /// Name of the file.
        name: String,
        /// The error of the operating system.
        #[source]
        error: io::Error,
    },
    /// The standard output cannot be written.
    #[error("{0}")]
    Output(#[from] io::Error),
}

/// Executes a command line, which begins with the name of the program. The excesses and the names of the pictures are
/// written to `output`.
///
/// # Errors
///
/// [`CliError`].
pub fn run(args: impl IntoIterator<Item = OsString>, output: &mut impl Write) -> Result<(), CliError> {
    let args: Vec<OsString> = args.into_iter().collect();
    if args.len() < 2 {
        return Err(CliError::Usage("which move file? Try examples/moves/crane.json (see --help)".to_owned()));
    }
    let args = Args::try_parse_from(args)
        .map_err(|error| if error.use_stderr() { CliError::Usage(reason(&error)) } else { CliError::Help(error) })?;
    let subject = Move::read(&args.file)?;
    let (svg, png) = match (args.svg, args.png) {
        (None, None) => {
            let path = args.out.unwrap_or_default().join(args.file.file_name().unwrap_or_default());
            (Some(path.with_extension("svg")), Some(path.with_extension("png")))
        }
        given => given,
    };
    for excess in subject.excesses() {
        writeln!(output, "{excess}")?;
    }
    if let Some(path) = svg {
        write(output, &path, crate::svg(&subject)?.as_bytes())?;
    }
    if let Some(path) = png {
        let mut bytes = Vec::new();
        crate::png(&subject, &mut bytes)?;
        write(output, &path, &bytes)?;
    }
    Ok(())
}

fn write(output: &mut impl Write, path: &Path, bytes: &[u8]) -> Result<(), CliError> {
    let name = path.display().to_string();
    match fs::write(path, bytes) {
        Ok(()) => Ok(writeln!(output, "{name}")?),
        Err(error) => Err(CliError::File { name, error }),
    }
}

/// The exit code of the program: 0, or 1 after one line on standard error.
///
/// Help is a success. So is a broken pipe, which means that the reader of the output has stopped reading.
#[must_use]
pub fn exit(result: Result<(), CliError>) -> ExitCode {
    let result = match result {
        Err(CliError::Help(help)) => help.print().map_err(CliError::from),
        other => other,
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(CliError::Output(error)) if error.kind() == ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => fail("plot", &error.to_string()),
    }
}
