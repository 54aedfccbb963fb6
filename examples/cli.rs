//! The command line of `inspect`, and how the program ends.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use clap::{Parser, ValueEnum};

use crate::program::{Failure, STATUSES, written};
use crate::text::{Format, Senders, Source, SourceError};

/// Show the frames of a motion-control rig as typed messages
///
/// Without arguments, bundled traffic of all three protocols is shown.
#[derive(Clone, Debug, Eq, Parser, PartialEq)]
#[command(name = "inspect", version, after_help = STATUSES)]
pub struct Args {
    /// Protocol of the bytes; only needed for an input
    #[arg(long, value_enum)]
    pub protocol: Option<Protocol>,
    /// Sender of the bytes; not needed if the lines of the input are marked > (host) and < (device)
    #[arg(long, value_enum, requires = "protocol")]
    pub from: Option<Senders>,
    /// Transport that carried the bytes
    #[arg(long, value_enum, default_value_t, requires = "protocol")]
    pub transport: Transport,
    /// Format of the input
    #[arg(long, value_enum, default_value_t, requires = "protocol")]
    pub format: Format,
    /// Print one JSON object per line
    #[arg(long, requires = "protocol")]
    pub json: bool,
    /// Print passwords in clear text
    #[arg(long, requires = "protocol")]
    pub show_secrets: bool,
    /// Input file; - is standard input
    #[arg(default_value = "-", requires = "protocol")]
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

impl From<Stop> for Failure {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::Usage(line) => Self::usage(line),
            stop => Self::not_done(stop),
        }
    }
}

/// Result of the program. A closed output is not a failure, because its reader needs no more.
///
/// # Errors
///
/// [`Failure`], except for a closed output.
pub fn end(result: Result<(), Stop>) -> Result<(), Failure> {
    match result {
        Err(Stop::Output(error)) => written(Err(error)),
        result => Ok(result?),
    }
}

#[cfg(test)]
mod tests {
    use std::io::ErrorKind;

    use super::*;
    use crate::program::{Status, reason};

    fn args(line: &str) -> Args {
        Args::try_parse_from(line.split(' ')).unwrap()
    }

    fn usage(line: &str) -> String {
        reason(&Args::try_parse_from(line.split(' ')).unwrap_err())
    }

    #[test]
    fn each_documented_option_is_accepted() {
        assert_eq!(args("inspect").protocol, None);
        let least = Args {
            protocol: Some(Protocol::Kos),
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
            protocol: Some(Protocol::Hoot),
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
        assert_eq!(end(Err(missing.stop(broken))).unwrap_err().status, Status::NotDone);
        assert_eq!(end(Err(io::Error::from(ErrorKind::BrokenPipe).into())), Ok(()));
        assert_eq!(end(Err(Stop::Usage(String::new()))).unwrap_err().status, Status::Usage);
    }
}
