//! Drawings as SVG and PNG, and their subjects.

use std::error::Error;
use std::io::Write;
use std::ops::Range;

use motion_move::Move;
use plotters::prelude::{BitMapBackend, FontStyle, IntoDrawingArea, SVGBackend};
use plotters::style::register_font;

use crate::figure;

/// The font Source Sans 3; its licence is in the same folder.
static FONT: &[u8] = include_bytes!("font/SourceSans3-Regular.ttf");

/// Number of pixels of the PNG for each pixel of the SVG, in each direction.
const FINE: i32 = 2;

/// Subject of a drawing.
#[derive(Clone, Copy, Debug)]
pub enum Subject<'a> {
    /// A planned move.
    Move(&'a Move),
    /// Moves of a capture.
    Recording(&'a Recording),
}

impl<'a> From<&'a Move> for Subject<'a> {
    fn from(subject: &'a Move) -> Self {
        Self::Move(subject)
    }
}

impl<'a> From<&'a Recording> for Subject<'a> {
    fn from(subject: &'a Recording) -> Self {
        Self::Recording(subject)
    }
}

/// Moves of motors that a capture has.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Title of the drawing.
    pub title: String,
    /// Line below the title.
    pub about: String,
    /// Ways of the motors, one panel for each.
    pub tracks: Vec<Track>,
}

/// Way of a motor.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Name of the motor, and of its move if there are several.
    pub name: String,
    /// Unit of the positions.
    pub unit: &'static str,
    /// Times from the left to the right; the end is later than the start.
    pub span: Range<f64>,
    /// Unit of the times, which follows each number.
    pub time_unit: &'static str,
    /// Lines as times and positions.
    pub lines: Vec<Vec<(f64, f64)>>,
    /// Key frames as times and positions, if the capture has them.
    pub keys: Vec<(f64, f64)>,
}

/// The drawing as SVG.
///
/// # Errors
///
/// The errors of the drawing library.
pub fn svg<'a>(subject: impl Into<Subject<'a>>) -> Result<String, Box<dyn Error>> {
    let subject = subject.into();
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
pub fn png<'a>(subject: impl Into<Subject<'a>>, out: impl Write) -> Result<(), Box<dyn Error>> {
    let subject = subject.into();
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
