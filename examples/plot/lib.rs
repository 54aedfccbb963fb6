//! Drawings of moves: position, velocity and acceleration of each axis over time, as SVG and PNG.

mod figure;
mod label;
mod played;
mod trace;

use std::error::Error;
use std::io::Write;

use motion_move::Move;
use plotters::prelude::{BitMapBackend, FontStyle, IntoDrawingArea, SVGBackend};
use plotters::style::register_font;

pub use played::{Played, played};

/// The font Source Sans 3; its licence is in the same folder.
static FONT: &[u8] = include_bytes!("font/SourceSans3-Regular.ttf");

/// Number of pixels of the PNG for each pixel of the SVG, in each direction.
const FINE: i32 = 2;

/// The drawing as SVG.
///
/// # Errors
///
/// The errors of the drawing library.
pub fn svg(subject: &Move) -> Result<String, Box<dyn Error>> {
    font()?;
    let mut text = String::new();
    figure::draw(subject, &SVGBackend::with_string(&mut text, figure::size(subject, 1)).into_drawing_area(), 1)?;
    Ok(text)
}

/// Writes the drawing as PNG, with twice as many pixels as the SVG in each direction.
///
/// # Errors
///
/// The errors of the drawing library and of `out`.
pub fn png(subject: &Move, out: impl Write) -> Result<(), Box<dyn Error>> {
    font()?;
    let (width, height) = figure::size(subject, FINE);
    let mut pixels = vec![0; 3 * width as usize * height as usize];
    let area = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
    figure::draw(subject, &area, FINE)?;
    drop(area);
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels)?;
    Ok(writer.finish()?)
}

fn font() -> Result<(), &'static str> {
    register_font(figure::FONT, FontStyle::Normal, FONT).map_err(|_| "the bundled font cannot be read")
}
