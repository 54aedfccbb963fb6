//! The command line of `inspect`, and how the program ends.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, ValueEnum};

use crate::program::{fail, reason};
use crate::text::{Format, Senders, Source, SourceError};

/// Show the frames of a motion-control rig as typed messages
///
/// Without arguments, bundled traffic of all three protocols is shown.
#[derive(Clone, Debug, Eq, Parser, PartialEq)]
#[command(name = "inspect", version)]
pub struct Args {
    /// Protocol of the bytes
    #[arg(long, value_enum)]
    pub protocol: Protocol,
    /// Sender of the bytes; not needed if the lines of the input are marked > (host) and < (device)
    #[arg(long, value_enum)]
    pub from: Option<Senders>,
    /// Transport that carried the bytes
    #[arg(long, value_enum, default_value_t)]
    pub transport: Transport,
    /// Format of the input
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Print one JSON object per line
    #[arg(long)]
    pub json: bool,
    /// Print passwords in clear text
    #[arg(long)]
    pub show_secrets: bool,
    /// Input file; - is standard input
    #[arg(default_value = "-")]
    pub file: PathBuf,
}

/// Protocol of the bytes.
#[derive(Clone, Copy, Debug, Eq, PartialEq, ValueEnum)]
pub enum Protocol {
    /// Kessler kOS
    Kos,
    /// Dragonframe DMC
    Dmc,
    /// hoot, on the serial bus of NMX controllers
    Hoot,
}

/// Transport that carried the bytes.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq, ValueEnum)]
pub enum Transport {
    /// TCP or a serial line: a stream of frames, which may be split anywhere
    #[default]
    Stream,
    /// UDP: each record of the input is one datagram
    #[value(alias = "udp")]
    Datagram,
    /// USB HID: each report holds one message
    Usb,
    /// USB HID: a message may continue in the next report; no device has confirmed this assumption
    UsbFragments,
}

/// Task that a command line asks for.
#[derive(Clone, Debug, Eq, PartialEq)]
pub enum Request {
    /// Show the bundled captures, because there are no arguments.
    Bundled,
    /// Show an input.
    Inspect(Args),
}

/// An open input.
pub struct Input {
    /// Bytes of the input, each piece with its side.
    pub source: Source<Box<dyn Read>>,
    /// Length of the input in bytes, if the input is a file.
    pub length: Option<u64>,
}

/// Reason why the program ends before the end of its input.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Stop {
    /// Help or the version was asked for.
    #[error("{0}")]
    Help(clap::Error),
    /// The command line is wrong.
    #[error("{0}")]
    Usage(String),
    /// The input cannot be read any further.
    #[error("{name}: {error}")]
    Input {
        /// Name of the input.
        name: String,
        /// Failure of the input.
        #[source]
        error: SourceError,
    },
    /// The output cannot be written.
    #[error("{0}")]
    Output(#[from] io::Error),
}

/// Parses a command line, whose first argument is the name of the program.
///
/// # Errors
///
/// [`Stop::Help`] if help or the version was asked for, [`Stop::Usage`] if the command line is wrong.
pub fn request(args: impl IntoIterator<Item = OsString>) -> Result<Request, Stop> {
    let args: Vec<OsString> = args.into_iter().collect();
    if args.len() < 2 {
        return Ok(Request::Bundled);
    }
    match Args::try_parse_from(args) {
        Ok(args) => Ok(Request::Inspect(args)),
        Err(error) if error.use_stderr() => Err(Stop::Usage(reason(&error))),
        Err(error) => Err(Stop::Help(error)),
    }
}

impl Args {
    /// Opens the input.
    ///
    /// # Errors
    ///
    /// [`Stop::Input`] if the file cannot be opened, or if its sender is unknown.
    pub fn open(&self) -> Result<Input, Stop> {
        let open = || {
            let (input, length): (Box<dyn Read>, _) = if self.is_standard_input() {
                (Box::new(io::stdin().lock()), None)
            } else {
                let file = File::open(&self.file)?;
                let about = file.metadata()?;
                (Box::new(file), about.is_file().then_some(about.len()))
            };
            let source = Source::new(input, self.format, self.from)?;
            Ok(Input { source, length })
        };
        open().map_err(|error| self.stop(error))
    }

    /// Adds the name of the input to a failure of the input.
    #[must_use]
    pub fn stop(&self, error: SourceError) -> Stop {
        let name = if self.is_standard_input() { "standard input".to_owned() } else { self.file.display().to_string() };
        Stop::Input { name, error }
    }

    fn is_standard_input(&self) -> bool {
        self.file == Path::new("-")
    }
}

/// Ends the program: status 0, or one line on standard error and status 1.
///
/// Help is not a failure. A closed output is not a failure either, because its reader needs no more.
#[must_use]
pub fn exit(result: Result<(), Stop>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Stop::Help(help)) => end(help.print()),
        Err(Stop::Output(error)) => end(Err(error)),
        Err(stop) => fail("inspect", &stop.to_string()),
    }
}

/// Ends the program after its last output, with status 0 if that succeeded or the output was closed.
fn end(output: io::Result<()>) -> ExitCode {
    match output {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => fail("inspect", &error.to_string()),
        _ => ExitCode::SUCCESS,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request_of(line: &str) -> Result<Request, Stop> {
        request(line.split(' ').map(OsString::from))
    }

    fn args(line: &str) -> Args {
        match request_of(line) {
            Ok(Request::Inspect(args)) => args,
            other => panic!("{other:?}"),
        }
    }

    fn usage(line: &str) -> String {
        match request_of(line) {
            Err(Stop::Usage(text)) => text,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn each_documented_option_is_accepted() {
        assert_eq!(request_of("inspect").unwrap(), Request::Bundled);
        let least = Args {
            protocol: Protocol::Kos,
            from: None,
            transport: Transport::Stream,
            format: Format::Auto,
            json: false,
            show_secrets: false,
            file: "-".into(),
        };
        assert_eq!(args("inspect --protocol kos"), least);
        assert_eq!(args("inspect --protocol kos -"), least);
        let most = Args {
            protocol: Protocol::Hoot,
            from: Some(Senders::Both),
            transport: Transport::Usb,
            format: Format::Xxd,
            json: true,
            show_secrets: true,
            file: "a.hex".into(),
        };
        let line = "inspect a.hex --json --show-secrets --protocol=hoot --from both \
                    --transport usb --format xxd";
        assert_eq!(args(line), most);
        for (option, values) in [
            ("protocol", "kos dmc hoot"),
            ("from", "host device both"),
            ("transport", "stream datagram udp usb usb-fragments"),
            ("format", "auto raw hex xxd"),
        ] {
            for value in values.split(' ') {
                let others = if option == "protocol" { "" } else { " --protocol dmc" };
                args(&format!("inspect --{option} {value}{others}"));
            }
        }
    }

    #[test]
    fn a_usage_error_is_one_line() {
        for (line, expected) in [
            ("inspect --json", "--protocol"),
            ("inspect a.hex", "--protocol"),
            ("inspect --protocol dfmoco", "possible values: kos, dmc, hoot"),
            ("inspect --protocol kos --jason", "--jason"),
            ("inspect --protocol kos a b", "'b'"),
            ("inspect --protocol kos --protocol dmc", "--protocol"),
            ("inspect --protocol kos --format", "--format"),
            ("inspect --protocol k\no\u{1b}s", "possible values"),
        ] {
            let text = usage(line);
            assert!(text.contains(expected), "{text}");
            assert!(!text.contains(['\n', '\r']), "{text:?}");
        }
        assert_eq!(exit(request_of("inspect --json").map(drop)), ExitCode::FAILURE);
    }

    #[test]
    fn help_and_a_closed_output_are_not_failures() {
        for line in ["inspect --help", "inspect -h", "inspect --version", "inspect -V"] {
            assert!(matches!(request_of(line), Err(Stop::Help(_))), "{line}");
        }
        let closed = io::Error::from(ErrorKind::BrokenPipe);
        assert_eq!(exit(Err(closed.into())), ExitCode::SUCCESS);
        let full = io::Error::from(ErrorKind::StorageFull);
        assert_eq!(exit(Err(full.into())), ExitCode::FAILURE);
    }

    #[test]
    fn an_input_error_names_the_input() {
        let missing = args("inspect --protocol kos --from host no/such/file");
        let stop = missing.open().map(drop).unwrap_err();
        assert!(stop.to_string().starts_with("no/such/file: "), "{stop}");
        let folder = args("inspect --protocol kos --from host .");
        let stop = folder.open().map(drop).unwrap_err();
        assert!(stop.to_string().starts_with(".: "), "{stop}");
        let stop = args("inspect --protocol kos").stop(SourceError::Unsaid);
        assert!(stop.to_string().starts_with("standard input: "), "{stop}");
        // A broken pipe is a failure if it is the input.
        let broken = SourceError::from(io::Error::from(ErrorKind::BrokenPipe));
        assert_eq!(exit(Err(missing.stop(broken))), ExitCode::FAILURE);
    }
}
