//! Ratios of speed between these crates and peers. README.md says how to run and how to read them.

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

fn main() {
    let chapters: &[benches::report::Chapter<'_>] = &[
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
    benches::report::run("ratios", env!("CARGO_TARGET_TMPDIR"), chapters);
}
