//! Program that writes the dissectors and the page of all messages.

use std::process::ExitCode;
use std::{fs, io};

fn main() -> ExitCode {
    match write() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn write() -> io::Result<()> {
    for (path, text) in wireshark::files() {
        println!("{}", path.display());
        fs::write(wireshark::root().join(path), text)?;
    }
    Ok(())
}
