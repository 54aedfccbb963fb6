//! Pictures of moves that rigs played: where they went over where they should, and the distance between both.

use std::error::Error;
use std::ops::Range;

use motion_move::{Move, MoveAxis};
use plotters::prelude::*;

use crate::figure::FONT;
use crate::label::tick;
use crate::trace::{Line, positions};

/// Width of the picture, and heights of a heading and of both panels of an axis, in pixels.
const WIDTH: u32 = 1_100;
const HEADING: u32 = 44;
const PANELS: [u32; 2] = [200, 120];
/// Width of the labels beside a panel, and height of those below it, in pixels.
const LABELS: [u32; 2] = [110, 26];
/// Number of places of the planned curve.
const PLACES: u32 = 1_200;

/// The line of what should be, and those of what was, which colour-blind people can distinguish.
const PLANNED: RGBColor = RGBColor(0xB0, 0xB0, 0xB0);
const COLOURS: [RGBColor; 3] = [RGBColor(0x00, 0x72, 0xB2), RGBColor(0xD5, 0x5E, 0x00), RGBColor(0x8E, 0x4F, 0xA8)];

/// Way of a motor while a move was played.
#[derive(Clone, Debug, PartialEq)]
pub struct Played {
    /// Label of the rig, such as its protocol. Ways with the same label have the same colour.
    pub label: &'static str,
    /// Number of the axis in the move, from 0.
    pub axis: usize,
    /// Times in seconds of the move, and positions in units of the axis.
    pub places: Line,
}

impl Played {
    /// The greatest distance from the axis, in its units, and the time at which it was there.
    #[must_use]
    pub fn farthest(&self, axis: &MoveAxis) -> (f64, f64) {
        let off = off(self, axis);
        off.into_iter().fold((0.0, 0.0), |most, (time, off)| if off.abs() > most.1 { (time, off.abs()) } else { most })
    }
}

/// The distance from an axis over time.
fn off(played: &Played, axis: &MoveAxis) -> Line {
    let curve = axis.curve();
    played.places.iter().map(|&(time, place)| (time, place - curve.position(time))).collect()
}

/// The picture as SVG: for each axis a panel of positions, and one of distances.
///
/// # Errors
///
/// The errors of the drawing library.
pub fn played(subject: &Move, ways: &[Played]) -> Result<String, Box<dyn Error>> {
    let each = HEADING + PANELS[0] + PANELS[1] + 2 * LABELS[1];
    let count = u32::try_from(subject.axes().len())?;
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (WIDTH, HEADING + each * count)).into_drawing_area();
        area.fill(&WHITE)?;
        let (head, axes) = area.split_vertically(HEADING);
        let style = |size: u32, colour: RGBColor| (FONT, size).into_font().color(&colour);
        head.draw_text(subject.name(), &style(22, BLACK), (20, 12))?;
        let labels = labels(ways);
        for ((number, axis), area) in
            subject.axes().iter().enumerate().zip(axes.split_evenly((subject.axes().len(), 1)))
        {
            let (heading, panels) = area.split_vertically(HEADING);
            heading.draw_text(&format!("{}, {}", axis.name(), axis.unit()), &style(17, BLACK), (20, 16))?;
            let (above, below) = panels.split_vertically(PANELS[0] + LABELS[1]);
            let ours = || ways.iter().filter(move |way| way.axis == number);
            for (place, label) in (0..).zip(&labels) {
                if ours().any(|way| way.label == *label) {
                    heading.draw_text(label, &style(15, colour(&labels, label)), (600 + 90 * place, 18))?;
                }
            }
            let curve = axis.curve();
            let planned = (0..=PLACES).map(|place| subject.duration() * f64::from(place) / f64::from(PLACES));
            let planned: Line = planned.map(|time| (time, curve.position(time))).collect();
            let mut lines = vec![(PLANNED.stroke_width(6), planned)];
            lines.extend(ours().map(|way| (colour(&labels, way.label).stroke_width(2), way.places.clone())));
            panel(&above, subject.duration(), &lines)?;
            let offs: Vec<_> = ours().map(|way| (colour(&labels, way.label).stroke_width(1), off(way, axis))).collect();
            panel(&below, subject.duration(), &offs)?;
        }
        area.present()?;
    }
    Ok(text)
}

/// Labels of all ways, each once.
fn labels(ways: &[Played]) -> Vec<&'static str> {
    let mut labels = Vec::new();
    for way in ways {
        if !labels.contains(&way.label) {
            labels.push(way.label);
        }
    }
    labels
}

fn colour(labels: &[&str], label: &str) -> RGBColor {
    let place = labels.iter().position(|other| *other == label).unwrap_or(0);
    COLOURS.into_iter().cycle().nth(place).unwrap_or(BLACK)
}

fn panel<DB: DrawingBackend>(
    area: &DrawingArea<DB, plotters::coord::Shift>,
    duration: f64,
    lines: &[(ShapeStyle, Line)],
) -> Result<(), DrawingAreaErrorKind<DB::ErrorType>> {
    let all: Vec<Line> = lines.iter().map(|(_, line)| line.clone()).collect();
    let values: Range<f64> = if all.iter().any(|line| !line.is_empty()) { positions(&all) } else { -1.0..1.0 };
    let step = (values.end - values.start) / 5.0;
    let mut chart = ChartBuilder::on(area)
        .set_label_area_size(LabelAreaPosition::Left, LABELS[0])
        .set_label_area_size(LabelAreaPosition::Bottom, LABELS[1])
        .margin_right(30)
        .margin_top(4)
        .build_cartesian_2d(0.0..duration, values)?;
    chart
        .configure_mesh()
        .y_labels(5)
        .x_label_formatter(&|time| format!("{} s", tick(*time, duration / 12.0)))
        .y_label_formatter(&|value| tick(*value, step))
        .label_style((FONT, 14))
        .light_line_style(TRANSPARENT)
        .draw()?;
    for (style, line) in lines {
        chart.draw_series(LineSeries::new(line.iter().copied(), *style))?;
    }
    Ok(())
}
