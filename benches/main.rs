//! Ratios of speed between these crates and peers, and targets for them.
//!
//! `cargo bench -p benches --bench ratios -- [CHAPTER]... [--quick]` measures the chapters, or all of them, and ends with
//! one table of the targets. README.md says how to read it.
//!
//! `CHAPTER count TABLE ROW CONTENDER TIMES` repeats the work of one contender that many times. The difference of two runs
//! under `valgrind --tool=callgrind` is the number of instructions.

mod curves;
mod dmc;
mod fletcher;
mod floods;
mod hoot;
mod kos;
mod parsers;
mod peers;
mod profiles;
mod steps;
mod stream;
mod targets;

use std::path::Path;

use benches::report::Report;

type Chapter = (&'static str, fn(&mut Report));

const CHAPTERS: [Chapter; 11] = [
    ("fletcher", fletcher::chapter),
    ("dmc", dmc::chapter),
    ("kos", kos::chapter),
    ("hoot", hoot::chapter),
    ("parsers", parsers::chapter),
    ("stream", stream::chapter),
    ("floods", floods::chapter),
    ("curves", curves::chapter),
    ("machines", steps::chapter),
    ("instructions", profiles::instructions),
    ("profiles", profiles::chapter),
];

fn main() {
    let (options, args): (Vec<_>, Vec<_>) = std::env::args().skip(1).partition(|arg| arg.starts_with("--"));
    let quick = options.iter().any(|option| option == "--quick" || option == "--test");
    let (wanted, count) = match args.iter().position(|arg| arg == "count") {
        Some(at) => (&args[..at], args[at + 1..].first_chunk().cloned()),
        None => (&args[..], None),
    };
    let mut report = count.map_or_else(|| Report::new(quick), Report::counting);
    for (name, chapter) in CHAPTERS {
        if wanted.is_empty() || wanted.iter().any(|wanted| name.contains(wanted)) {
            chapter(&mut report);
        }
    }
    report.finish(targets::TARGETS, &Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("ratios.json"));
    if quick {
        println!("This was a quick run: everything runs, but the numbers say nothing.");
    }
}
