//! Tests of the commands that drive nothing: plot, inspect, completions, and the manual.

use std::fs;

use crate::process::{Program, file, folder};
use examples::program::{STATUSES, Status};

/// Path of a sample of the move files.
fn sample(name: &str) -> String {
    format!("{}/../moves/{name}.json", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn plot_writes_the_pictures_that_it_names() {
    let folder = folder("plot_writes_the_pictures_that_it_names");
    let inside = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    for name in ["whip.svg", "whip.png", "only.svg"] {
        let _ = fs::remove_file(inside(name));
    }
    let (whip, out) = (sample("whip"), inside(""));
    let plot = |args: &[&str]| Program::start("plot", args).end();

    let said = plot(&[&whip, "--out", &out]).done();
    assert!(said.contains("whip.svg\n") && said.ends_with("whip.png\n"), "{said}");
    let excess = "axis \"Pan\", segment 2 from 0.9 s to 1.3 s: velocity 150, the limit is 120 degrees/s";
    assert!(said.contains(excess), "{said}");
    assert!(fs::read(inside("whip.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(fs::read(inside("whip.svg")).unwrap().starts_with(b"<svg"));
    plot(&[&whip, "--svg", &inside("only.svg")]).done();
    assert!(fs::read(inside("only.svg")).unwrap().starts_with(b"<svg"));
    assert!(fs::metadata(inside("only.png")).is_err());

    plot(&[]).ended(Status::Usage, "<FILE>");
    plot(&[&whip, "--out", ".", "--svg", "a.svg"]).ended(Status::Usage, "--out");
    plot(&["no.json"]).failed("moco: no.json: No such file");
    plot(&[&whip, "--out", &inside("none")]).failed("none/whip.svg: No such file");
    let bad = file("plot_of_a_broken_file", "{ \"move\": 1,\n  \"nam\": 2 }");
    plot(&[bad.to_str().unwrap()]).failed("move.json, line 2, column 7: unknown field `nam`");
}

#[test]
fn inspect_shows_captures_and_files() {
    let inspect = |args: &[&str]| Program::start("inspect", args).end();
    let said = inspect(&[]).done();
    assert!(["MotorMove", "BroadcastStop", "DeviceInfo"].iter().all(|name| said.contains(name)), "{said}");
    let path = folder("inspect_shows_captures_and_files").join("stop.hex");
    fs::write(&path, "00 00 00 00 00 FF 03 01 04 00\n").unwrap();
    let path = path.to_str().unwrap();
    let said = inspect(&["--protocol", "hoot", "--from", "host", "--json", path]).done();
    assert!(said.starts_with('{') && said.contains("\"MotorStop\"") && said.lines().count() == 1, "{said}");
    inspect(&["--json", path]).usage_in_json("--protocol");
    inspect(&[path]).ended(Status::Usage, "--protocol");
    inspect(&["--protocol", "kos", "--from", "host", "no/such/file"]).failed("moco: no/such/file: ");
}

#[test]
fn completions_of_each_shell_name_all_commands() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = Program::start("completions", &[shell]).end().done();
        for word in ["inspect", "plot", "simulate", "drive", "calibrate"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    Program::start("completions", &["shell"]).end().ended(Status::Usage, "possible values: bash");
}

#[test]
fn the_manual_has_a_page_for_each_command() {
    let pages = folder("the_manual_has_a_page_for_each_command").join("man");
    let _ = fs::remove_dir_all(&pages);
    Program::start("man", &[&pages]).end().done();
    let page = |name: &str| fs::read_to_string(pages.join(format!("{name}.1"))).unwrap();
    for name in [
        "moco",
        "moco-inspect",
        "moco-plot",
        "moco-simulate",
        "moco-drive",
        "moco-completions",
        "moco-man",
        "moco-drive-info",
        "moco-drive-jog",
        "moco-drive-move",
        "moco-drive-calibrate",
        "moco-drive-upload",
        "moco-drive-run",
        "moco-drive-program",
        "moco-drive-expose",
        "moco-drive-stop",
    ] {
        assert!(page(name).contains(".SH SYNOPSIS"), "{name}");
    }
    // Hyphens are escaped in manual pages.
    let statuses = STATUSES.lines().nth(3).unwrap().trim();
    for name in ["moco", "moco-drive", "moco-simulate", "moco-inspect"] {
        assert!(page(name).contains(statuses), "{name}");
    }
    Program::start("man", &["/dev/null/man"]).end().failed("moco: /dev/null/man: ");
}
