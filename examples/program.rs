//! End of a program: its exit status, and one line that says why.

use std::env;
use std::io::{self, ErrorKind, Write};
use std::process::ExitCode;

use clap::Parser;
use motion_core::wire::print::is_hidden;
use serde_json::json;

/// Exit statuses of all programs, as their help shows them.
pub const STATUSES: &str = "\
Exit status:
  0    the command is done
  1    it is not done, and nothing moves that it has set in motion
  2    the command line is wrong, and nothing was done
  3    a motor may still move: the stop is not confirmed, or the rig does not say that all rest
  130  Ctrl-C ended it, and everything is at rest

If the status is not 0, standard error has one line that says why. With --json, that line is a JSON object such as \
{\"error\":\"wrong password\",\"status\":1}.";

/// Exit status of a program that has failed. A program that has done its command ends with status 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Status 1: the command is not done, and nothing moves that it has set in motion.
    NotDone = 1,
    /// Status 2: the command line is wrong, and nothing was done.
    Usage = 2,
    /// Status 3: a motor may still move, because the rig did not confirm a stop, or does not say that all motors rest.
    MayMove = 3,
    /// Status 130: Ctrl-C ended the program, and everything is at rest.
    Interrupted = 130,
}

/// Failure of a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// Status with which the program ends.
    pub status: Status,
    /// Line that says why.
    pub line: String,
}

impl Failure {
    /// Failure of a command that is not done.
    #[must_use]
    #[expect(clippy::needless_pass_by_value, reason = "results are mapped by it")]
    pub fn not_done(line: impl ToString) -> Self {
        Self { status: Status::NotDone, line: line.to_string() }
    }

    /// Failure of a wrong command line.
    #[must_use]
    #[expect(clippy::needless_pass_by_value, reason = "results are mapped by it")]
    pub fn usage(line: impl ToString) -> Self {
        Self { status: Status::Usage, line: line.to_string() }
    }
}

/// Result of writing the output. A closed output is not a failure, because its reader needs no more.
///
/// # Errors
///
/// [`Status::NotDone`] for any other error of the output.
pub fn written(result: io::Result<()>) -> Result<(), Failure> {
    match result {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::not_done(error)),
        _ => Ok(()),
    }
}

/// Runs a program: parses its command line, does what it says, and prints a failure as one line on standard error.
#[must_use]
pub fn run<T: Parser>(name: &str, act: impl FnOnce(T) -> Result<(), Failure>) -> ExitCode {
    match arguments().and_then(|args| args.map_or(Ok(()), act)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let is_json = env::args_os().any(|arg| arg == "--json");
            // If standard error is closed, the failure cannot be reported.
            let _ = writeln!(io::stderr(), "{}", report(name, &failure, is_json));
            ExitCode::from(failure.status as u8)
        }
    }
}

/// Parses the command line. `None` after help and version, which are printed.
fn arguments<T: Parser>() -> Result<Option<T>, Failure> {
    match T::try_parse() {
        Ok(args) => Ok(Some(args)),
        Err(error) if error.use_stderr() => Err(Failure::usage(reason(&error))),
        Err(help) => written(help.print()).map(|()| None),
    }
}

/// Line about a failure.
fn report(name: &str, failure: &Failure, is_json: bool) -> String {
    let Failure { status, line } = failure;
    if is_json {
        json!({ "error": line, "status": *status as u8 }).to_string()
    } else {
        format!("{name}: {}", one_line(line))
    }
}

/// Reason why clap rejects a command line: the first paragraph of its message.
#[must_use]
pub fn reason(error: &clap::Error) -> String {
    let message = error.to_string();
    let reason = message.split("\n\n").next().unwrap_or_default();
    let words: Vec<&str> = reason.strip_prefix("error: ").unwrap_or(reason).split_whitespace().collect();
    format!("{} (see --help)", words.join(" "))
}

/// Escapes line ends and all other characters that [`is_hidden`] names, because names of files and rigs may contain them.
#[must_use]
pub fn one_line(message: &str) -> String {
    let escape = |char: char| match char {
        char if is_hidden(char) => char.escape_default().to_string(),
        char => char.to_string(),
    };
    message.chars().map(escape).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Parser)]
    struct Args {
        #[arg(long)]
        seed: u64,
    }

    #[test]
    fn a_usage_error_is_one_line() {
        for (line, expected) in [
            ("x", "the following required arguments were not provided: --seed <SEED>"),
            ("x --seed \u{1b}", "invalid value"),
            ("x --speed 1", "unexpected argument '--speed' found"),
        ] {
            let reason = one_line(&reason(&Args::try_parse_from(line.split(' ')).unwrap_err()));
            assert!(reason.starts_with(expected) && !reason.contains(char::is_control), "{reason:?}");
        }
        assert_eq!(one_line("a\nb\u{1b}é\u{85}\u{202e}"), "a\\nb\\u{1b}é\\u{85}\\u{202e}");
    }

    #[test]
    fn a_failure_is_one_line_of_text_or_json() {
        let failure = Failure { status: Status::MayMove, line: "a \"rig\"\nmoves".to_owned() };
        assert_eq!(report("moco", &failure, false), "moco: a \"rig\"\\nmoves");
        assert_eq!(report("moco", &failure, true), r#"{"error":"a \"rig\"\nmoves","status":3}"#);
    }

    #[test]
    fn a_closed_output_is_not_a_failure() {
        assert_eq!(written(Err(ErrorKind::BrokenPipe.into())), Ok(()));
        assert_eq!(written(Err(ErrorKind::StorageFull.into())).unwrap_err().status, Status::NotDone);
    }

    #[test]
    fn the_help_names_each_status() {
        for status in [Status::NotDone, Status::Usage, Status::MayMove, Status::Interrupted] {
            assert!(STATUSES.contains(&format!("\n  {:<3}  ", status as u8)), "{status:?}");
        }
    }
}
