//! Drawings of the sample files.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use motion_move::{Move, MoveAxis};

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
        for text in subject.axes().iter().map(MoveAxis::name).chain([subject.name()]) {
            assert!(svg.contains(text), "{text}");
        }
        let head = svg.split("viewBox=\"0 0 ").nth(1).unwrap().split('"').next().unwrap();
        let (width, height) = head.split_once(' ').unwrap();
        let (width, height): (f64, f64) = (width.parse().unwrap(), height.parse().unwrap());
        let points = points(&svg);
        assert!(points.len() > 3_000 * subject.axes().len(), "{} points", points.len());
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
