//! P: cost of the default release profile, beside that of this workspace, which optimises all crates together (fat).
//!
//! The program `instructions` uses the protocols as any program does. It is built with both profiles, and both run in
//! turn, row by row. Its instructions are those that `.ci/instructions` counted and that are committed.

use std::io::{BufRead as _, BufReader, Lines, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

use benches::ratios::timed;
use benches::report::Report;

const COUNTED: &str = include_str!("instructions.txt");

pub(crate) fn instructions(report: &mut Report) {
    let mut table = report.table("instructions");
    for line in COUNTED.lines().filter(|line| !line.starts_with('#')) {
        if let [name, fat, default, ..] = line.split_whitespace().collect::<Vec<_>>()[..] {
            let number = |text: &str| text.parse().expect("a number of instructions");
            table.numbers(name, &[("default", number(default)), ("fat", number(fat))]);
        }
    }
}

pub(crate) fn chapter(report: &mut Report) {
    let mut table = report.table("profiles");
    let (mut default, mut fat) = (Program::new("default-release"), Program::new("release"));
    while let (Some((name, messages)), Some((other, _))) = (default.row(), fat.row()) {
        assert_eq!(name, other, "both programs have the same rows");
        if ["stream", "lend", "pieces", "slice"].iter().any(|row| name.ends_with(row)) {
            let contenders = [timed("default", |times| default.time(times)), timed("fat", |times| fat.time(times))];
            table.row(&name, contenders.map(|contender| contender.per(messages)).into());
        }
        default.ask("0");
        fat.ask("0");
    }
}

/// Program that waits for the number of times that it has to repeat its next row.
struct Program {
    child: Child,
    input: ChildStdin,
    output: Lines<BufReader<ChildStdout>>,
}

impl Program {
    /// Builds the program with a profile, and starts it.
    fn new(profile: &str) -> Self {
        let cargo = Command::new(env!("CARGO"))
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .args(["build", "-q", "--bin", "instructions", "--profile", profile])
            .status();
        assert!(cargo.is_ok_and(|status| status.success()), "the program builds");
        let program = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name(profile).join("instructions");
        let mut child = Command::new(program)
            .arg("times")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the program runs");
        let (input, output) = (child.stdin.take().expect("piped"), child.stdout.take().expect("piped"));
        Self { child, input, output: BufReader::new(output).lines() }
    }

    /// Name of the next row, and the number of its messages.
    fn row(&mut self) -> Option<(String, usize)> {
        let line = self.output.next()?.expect("a line");
        let (name, messages) = line.split_once(' ').expect("a name and a number");
        Some((name.into(), messages.parse().expect("a number of messages")))
    }

    /// Time of so many repetitions of the row.
    fn time(&mut self, times: u32) -> Duration {
        self.ask(&times.to_string());
        let nanos = self.output.next().expect("the program answers").expect("a line");
        Duration::from_nanos(nanos.parse().expect("a number of nanoseconds"))
    }

    fn ask(&mut self, times: &str) {
        writeln!(self.input, "{times}").expect("the program reads");
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // It has ended by itself, unless the bench failed.
        _ = self.child.kill();
        _ = self.child.wait();
    }
}
