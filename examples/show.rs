//! Execution of `inspect`: the frames of an input, or of the bundled captures.

use std::io::{self, BufWriter, IsTerminal, Write};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::cli::{Args, Input, Protocol, Stop, Transport};
use crate::print::Printer;
use crate::record::{Json, Record};
use crate::tap::tap;
use crate::text::{Format, Source, SourceError};

/// Real frames of each protocol, in both directions, with some noise and one corrupt frame.
const CAPTURES: [(Protocol, &str, &str); 3] = [
    (Protocol::Dmc, "Dragonframe DMC, serial: examples/captures/dmc.txt", include_str!("captures/dmc.txt")),
    (Protocol::Kos, "Kessler kOS, TCP: examples/captures/kos.txt", include_str!("captures/kos.txt")),
    (Protocol::Hoot, "NMX / MoCoBus, RS-485: examples/captures/hoot.txt", include_str!("captures/hoot.txt")),
];

/// Size from which a file gets a progress bar, in bytes.
const LARGE: u64 = 8 << 20;

/// Shows the input that the arguments name, or without a protocol the bundled captures.
///
/// # Errors
///
/// [`Stop`] if the program ends before the end of its input.
pub fn show(args: &Args) -> Result<(), Stop> {
    match args.protocol {
        None => bundled(),
        Some(protocol) => inspect(args, protocol),
    }
}

fn bundled() -> Result<(), Stop> {
    let mut printer = Printer::new(output(), false);
    for (protocol, title, capture) in CAPTURES {
        printer.title(title)?;
        let mut source = Source::new(capture.as_bytes(), Format::Auto, None).map_err(|error| named(title, error))?;
        let mut tap = tap(protocol, Transport::Stream)?;
        let mut see = |record: &Record<'_>| Ok(printer.record(record)?);
        while let Some(piece) = source.next_piece().map_err(|error| named(title, error))? {
            tap.push(piece, &mut see)?;
        }
        tap.end(&mut see)?;
        printer.summary()?;
    }
    Ok(())
}

fn named(title: &str, error: SourceError) -> Stop {
    Stop::Input { name: title.to_owned(), error }
}

fn inspect(args: &Args, protocol: Protocol) -> Result<(), Stop> {
    let mut tap = tap(protocol, args.transport)?;
    let Input { mut source, length } = args.open()?;
    let progress = progress(length);
    let mut printer = Printer::new(output(), args.show_secrets);
    let mut json = BufWriter::new(io::stdout().lock());
    let mut see = |record: &Record<'_>| {
        if args.json {
            Json { record, secrets: args.show_secrets }.write_line(&mut json)?;
        } else {
            printer.record(record)?;
        }
        Ok(())
    };
    let result = loop {
        match source.next_piece() {
            Ok(Some(piece)) => tap.push(piece, &mut see)?,
            Ok(None) => break Ok(()),
            Err(error) => break Err(args.stop(error)),
        }
        progress.set_position(source.bytes_read());
    };
    // Frames before a bad line are shown as well.
    tap.end(&mut see)?;
    progress.finish_and_clear();
    if args.json {
        json.flush()?;
    } else if result.is_ok() || !printer.is_silent() {
        printer.summary()?;
    }
    result
}

/// Standard output, in colour if it is a terminal that supports colour.
fn output() -> impl Write {
    let choice = anstream::AutoStream::choice(&io::stdout());
    anstream::AutoStream::new(Box::new(BufWriter::new(io::stdout().lock())) as Box<dyn Write>, choice)
}

fn progress(length: Option<u64>) -> ProgressBar {
    match length {
        Some(length) if length >= LARGE && io::stderr().is_terminal() => {
            let style = ProgressStyle::with_template("{wide_bar} {bytes} of {total_bytes}, {eta} left");
            let bar = ProgressBar::new(length);
            bar.enable_steady_tick(Duration::from_millis(200));
            if let Ok(style) = style {
                bar.set_style(style);
            }
            bar
        }
        _ => ProgressBar::hidden(),
    }
}
