//! The sample files, drawn by the library and by the program.

use std::ffi::OsString;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use examples::moves::Move;
use plot::cli;

fn samples() -> impl Iterator<Item = PathBuf> {
    let moves = Path::new(env!("CARGO_MANIFEST_DIR")).join("../moves");
    ["slide", "crane", "pan", "whip"].into_iter().map(move |name| moves.join(name).with_extension("json"))
}

/// The coordinates x and y of the points of all lines of an SVG.
fn points(svg: &str) -> Vec<(f64, f64)> {
    let lists = svg.split("points=\"").skip(1).filter_map(|rest| rest.split('"').next());
    let pairs = lists.flat_map(|list| list.split_whitespace().filter_map(|pair| pair.split_once(',')));
    pairs.map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())).collect()
}

#[test]
fn every_axis_has_its_curves_inside_the_picture() {
    for path in samples() {
        let subject = Move::read(&path).unwrap();
        let svg = plot::svg(&subject).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        for text in subject.axes.iter().map(|axis| &axis.name).chain([&subject.name]) {
            assert!(svg.contains(text.as_str()), "{text}");
        }
        let head = svg.split("viewBox=\"0 0 ").nth(1).unwrap().split('"').next().unwrap();
        let (width, height) = head.split_once(' ').unwrap();
        let (width, height): (f64, f64) = (width.parse().unwrap(), height.parse().unwrap());
        let points = points(&svg);
        assert!(points.len() > 3_000 * subject.axes.len(), "{} points", points.len());
        for (x, y) in points {
            assert!((0.0..=width).contains(&x) && (0.0..=height).contains(&y), "({x}, {y}) in {}", path.display());
        }
    }
}

#[test]
fn pictures_have_the_colours_of_the_curves() {
    for path in samples() {
        let subject = Move::read(&path).unwrap();
        let mut bytes = Vec::new();
        plot::png(&subject, &mut bytes).unwrap();
        let mut reader = png::Decoder::new(Cursor::new(&bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert!(info.width == 2_200 && info.height > 900, "{} by {}", info.width, info.height);
        let pixels = pixels.as_chunks::<3>().0;
        // The first axis is blue, and most of the picture is white.
        let count = |wanted: [u8; 3]| pixels.iter().filter(|&&pixel| pixel == wanted).count();
        assert!(count([0x00, 0x72, 0xB2]) > 5_000 && count([0xFF; 3]) > pixels.len() / 2);
        let red = count([0xC6, 0x28, 0x28]);
        assert!(red > 500, "{red} red pixels in {}", path.display());
    }
}

fn run(args: &[&str]) -> Result<String, String> {
    let mut said = Vec::new();
    let args = ["plot"].iter().chain(args).map(OsString::from);
    let result = cli::run(args, &mut said).map_err(|error| {
        let line = error.to_string();
        assert_eq!(line.lines().count(), 1, "{line}");
        assert_eq!(cli::exit(Err(error)), ExitCode::FAILURE);
        line
    });
    result.map(|()| String::from_utf8(said).unwrap())
}

#[test]
fn the_program_writes_the_pictures_that_it_names() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pictures");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let inside = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let whip = samples().last().unwrap();
    let whip = whip.to_str().unwrap();

    let said = run(&[whip, "--out", &inside("")]).unwrap();
    assert!(said.contains("whip.svg\n") && said.ends_with("whip.png\n"), "{said}");
    assert!(
        said.contains("axis \"Pan\", segment 2 from 0.9 s to 1.3 s: velocity 150, the limit is 120 degrees/s"),
        "{said}"
    );
    assert!(fs::read(inside("whip.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(fs::read(inside("whip.svg")).unwrap().starts_with(b"<svg"));
    run(&[whip, "--svg", &inside("only.svg")]).unwrap();
    assert!(fs::read(inside("only.svg")).unwrap().starts_with(b"<svg") && !Path::new(&inside("only.png")).exists());

    assert!(run(&[]).unwrap_err().starts_with("which move file? Try examples/moves/crane.json"));
    assert!(run(&["no.json"]).unwrap_err().starts_with("no.json: No such file"));
    assert!(run(&[whip, "--out", &inside("none")]).unwrap_err().contains("none/whip.svg: No such file"));
    assert!(run(&[whip, "--out", ".", "--svg", "a.svg"]).unwrap_err().contains("--out"));
    fs::write(inside("bad.json"), "{ \"move\": 1,\n  \"nam\": 2 }").unwrap();
    assert!(run(&[&inside("bad.json")]).unwrap_err().contains("bad.json, line 2, column 7: unknown field `nam`"));
    let help = cli::run(["plot", "--help"].map(OsString::from), &mut Vec::new()).unwrap_err();
    assert_eq!(cli::exit(Err(help)), ExitCode::SUCCESS);
}
