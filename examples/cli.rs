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
    /// What the bytes speak
    #[arg(long, value_enum)]
    pub protocol: Protocol,
    /// Who sent the bytes; text whose lines are marked > (host) and < (device) says it itself
    #[arg(long, value_enum)]
    pub from: Option<Senders>,
    /// What carried the bytes
    #[arg(long, value_enum, default_value_t)]
    pub transport: Transport,
    /// How the input holds the bytes
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Print one JSON object a line
    #[arg(long)]
    pub json: bool,
    /// Print passwords as they are
    #[arg(long)]
    pub show_secrets: bool,
    /// The input; - is standard input
    #[arg(default_value = "-")]
    pub file: PathBuf,
}

/// What the bytes speak.
#[derive(Clone, Copy, Debug, Eq, PartialEq, ValueEnum)]
pub enum Protocol {
    /// Kessler kOS
    Kos,
    /// Dragonframe DMC
    Dmc,
    /// hoot, on the serial bus of NMX controllers
    Hoot,
}

/// What carried the bytes.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq, ValueEnum)]
pub enum Transport {
    /// TCP or a serial line: frames in a row, cut anywhere
    #[default]
    Stream,
    /// UDP: each record of the input is a datagram
    #[value(alias = "udp")]
    Datagram,
    /// USB HID: reports in a row, a message each
    Usb,
    /// The same, but a message goes on in the next report: an assumption that no device has confirmed
    UsbFragments,
}

/// What a command line asks for.
#[derive(Clone, Debug, Eq, PartialEq)]
pub enum Request {
    /// The bundled captures: nothing was said.
    Bundled,
    /// An input.
    Inspect(Args),
}

/// An open input.
pub struct Input {
    /// Its bytes.
    pub source: Source<Box<dyn Read>>,
    /// Its length in bytes, where it is a file.
    pub length: Option<u64>,
}

/// Why the program ends before its input does.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Stop {
    /// Help or the version was asked for.
    #[error("{0}")]
    Help(clap::Error),
    /// The command line is wrong.
    #[error("{0}")]
    Usage(String),
    /// The input cannot be read on.
    #[error("{name}: {error}")]
    Input {
        /// The name of the input.
        name: String,
        /// What is wrong with it.
        #[source]
        error: SourceError,
    },
    /// The output cannot be written on.
    #[error("{0}")]
    Output(#[from] io::Error),
}

/// Understands a command line, the program's name first.
///
/// # Errors
///
/// [`Stop::Help`] and [`Stop::Usage`].
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
    /// [`Stop::Input`].
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

    /// The input's failure, under the input's name.
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
/// Help is no failure, nor is a reader of the output that has seen enough.
#[must_use]
pub fn exit(result: Result<(), Stop>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Stop::Help(help)) => end(help.print()),
        Err(Stop::Output(error)) => end(Err(error)),
        Err(stop) => fail("inspect", &stop.to_string()),
    }
}

/// Ends the program after its last output.
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
    fn the_command_line_is_the_documented_one() {
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
    fn bad_usage_is_one_line() {
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
    fn help_and_a_closed_output_are_no_failures() {
        for line in ["inspect --help", "inspect -h", "inspect --version", "inspect -V"] {
            assert!(matches!(request_of(line), Err(Stop::Help(_))), "{line}");
        }
        let closed = io::Error::from(ErrorKind::BrokenPipe);
        assert_eq!(exit(Err(closed.into())), ExitCode::SUCCESS);
        let full = io::Error::from(ErrorKind::StorageFull);
        assert_eq!(exit(Err(full.into())), ExitCode::FAILURE);
    }

    #[test]
    fn unreadable_input_is_named() {
        let missing = args("inspect --protocol kos --from host no/such/file");
        let stop = missing.open().map(drop).unwrap_err();
        assert!(stop.to_string().starts_with("no/such/file: "), "{stop}");
        let folder = args("inspect --protocol kos --from host .");
        let stop = folder.open().map(drop).unwrap_err();
        assert!(stop.to_string().starts_with(".: "), "{stop}");
        let stop = args("inspect --protocol kos").stop(SourceError::Unsaid);
        assert!(stop.to_string().starts_with("standard input: "), "{stop}");
        // A broken pipe at the input is a failure.
        let broken = SourceError::from(io::Error::from(ErrorKind::BrokenPipe));
        assert_eq!(exit(Err(missing.stop(broken))), ExitCode::FAILURE);
    }
}
