//! Tests of the commands that drive nothing: plot, inspect, completions, and the manual.

use std::fs;

use serde_json::Value;

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
fn one_move_tells_what_each_protocol_loses_and_plays_it() {
    let one_move = |args: &[&str]| Program::start("one-move", args).end();
    let said = one_move(&[&sample("pan")]).done();
    for line in [
        "kOS: motor 1 moves axis \"Pan\"\n",
        "DMC: axis \"Pan\" is at most 0.0103 ° away, at 0.686 s (whole steps, straight from frame to frame)\n",
        "hoot: axis \"Pan\" is at most 0.0101 ° away, at 1.34 s (a planned move)\n",
    ] {
        assert!(said.contains(line), "{line}: {said}");
    }
    let said = one_move(&[&sample("crane")]).done();
    assert!(
        said.contains("kOS: not converted: no axis has a kOS motor") && said.contains("(a rate in thousandths)"),
        "{said}"
    );

    let picture = folder("one_move_tells_what_each_protocol_loses_and_plays_it").join("pan.svg");
    let _ = fs::remove_file(&picture);
    let said = one_move(&[&sample("pan"), "--json", "--play", picture.to_str().unwrap()]).done();
    let lines: Vec<Value> = said.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let amount = |protocol: &str, kind: &str| {
        let found = lines.iter().find(|line| line["protocol"] == protocol && line["kind"] == kind);
        found.unwrap_or_else(|| panic!("{protocol} {kind}: {said}"))["amount"].as_f64().unwrap()
    };
    // What the rigs play is within the losses. A simulated kOS motor is where single precision has it.
    for (protocol, more) in [("kOS", 1e-4), ("DMC", 1e-9), ("hoot", 1e-9)] {
        let (loss, played) = (amount(protocol, "loss"), amount(protocol, "played"));
        assert!(0.0 < played && played <= loss + more, "{protocol}: {played} of {loss}");
    }
    let svg = fs::read_to_string(&picture).unwrap();
    assert!(
        svg.starts_with("<svg") && ["kOS", "DMC", "hoot", "Pan across the table"].iter().all(|text| svg.contains(text))
    );

    one_move(&[]).ended(Status::Usage, "<FILE>");
    one_move(&["no.json"]).failed("moco: no.json: No such file");
    one_move(&[&sample("pan"), "--play", "none/pan.svg"]).failed("none/pan.svg: No such file");
    let bad = file("one_move_of_a_broken_file", "{ \"move\": 1,\n  \"nam\": 2 }");
    one_move(&[bad.to_str().unwrap()]).failed("move.json, line 2, column 7: unknown field `nam`");
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
        for word in ["inspect", "plot", "one-move", "simulate", "drive", "calibrate"] {
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
