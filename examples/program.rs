//! Failure of a program: one line that says why, and status 1.

use std::io::{self, Write};
use std::process::ExitCode;

use motion_core::wire::print::is_hidden;

/// Prints a failure as one line on standard error. Returns the exit status of the program.
#[must_use]
pub fn fail(program: &str, message: &str) -> ExitCode {
    // If standard error is closed, the failure cannot be reported.
    let _ = writeln!(io::stderr(), "{program}: {}", one_line(message));
    ExitCode::FAILURE
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
    use clap::Parser;

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
}
