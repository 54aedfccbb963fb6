//! The figures: three panels for each axis of a move, one panel for each motor of a capture, one below the other.

use std::ops::Range;

use motion_move::{Move, MoveAxis};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::label::{number, tick};
use crate::trace::{self, Line, Traces};
use crate::{Recording, Subject};

/// The name of the font; for an SVG, the viewer uses its own font.
pub(crate) const FONT: &str = "sans-serif";

/// Lengths of the layout, in pixels of the SVG.
const WIDTH: i32 = 1_100;
const LEFT: i32 = 190;
const RIGHT: i32 = 70;
const TITLE: i32 = 64;
const HEADING: i32 = 38;
const PANELS: [i32; 3] = [150, 110, 110];
const GAP: i32 = 8;
const TIMES: i32 = 26;
/// Height of an axis: its name, its panels, and the times below.
const AXIS: i32 = HEADING + PANELS[0] + PANELS[1] + PANELS[2] + 3 * GAP + TIMES;

/// Greatest number of labels of the times.
const TIME_LABELS: u32 = 12;

/// Sizes of text, in pixels of the SVG.
const LARGE: i32 = 22;
const MIDDLE: i32 = 17;
const SMALL: i32 = 14;

const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
const GREY: RGBColor = RGBColor(0x66, 0x66, 0x66);
const FRAME: RGBColor = RGBColor(0xB0, 0xB0, 0xB0);
const GRID: RGBColor = RGBColor(0xEC, 0xEC, 0xEC);
const BEYOND: RGBColor = RGBColor(0xC6, 0x28, 0x28);
/// Colours for the axes in turn, which colour-blind people can distinguish.
const COLOURS: [RGBColor; 4] =
    [RGBColor(0x00, 0x72, 0xB2), RGBColor(0x00, 0x8A, 0x64), RGBColor(0x8E, 0x4F, 0xA8), RGBColor(0xA8, 0x6F, 0x00)];

type Panel<'a, DB> = ChartContext<'a, DB, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
type Drawn<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// Height of a motor of a capture: its name, its panel, and the times below.
const TRACK: i32 = HEADING + PANELS[0] + GAP + TIMES;

/// Width and height of the figure in pixels, each `fine` times as great as in the SVG.
pub(crate) fn size(subject: Subject<'_>, fine: i32) -> (u32, u32) {
    let height = match subject {
        Subject::Move(subject) => subject.axes().iter().fold(TITLE, |height, _| height + AXIS),
        Subject::Recording(subject) => subject.tracks.iter().fold(TITLE, |height, _| height + TRACK),
    };
    ((WIDTH * fine).unsigned_abs(), (height * fine).unsigned_abs())
}

/// Draws the whole figure.
pub(crate) fn draw<DB: DrawingBackend>(subject: Subject<'_>, area: &DrawingArea<DB, Shift>, fine: i32) -> Drawn<DB> {
    let pen = Pen { area, fine };
    area.fill(&WHITE)?;
    match subject {
        Subject::Move(subject) => pen.planned(subject)?,
        Subject::Recording(subject) => pen.recorded(subject)?,
    }
    area.present()
}

/// What the panels of one axis have in common.
struct Across<'a> {
    /// Times from the left to the right.
    span: Range<f64>,
    /// Unit of times, after a number.
    unit: &'a str,
    /// Key frames: times and positions.
    keys: &'a [(f64, f64)],
    colour: RGBColor,
}

/// The contents of a panel.
struct Content<'a> {
    title: &'a str,
    unit: String,
    lines: &'a [Line],
    values: Range<f64>,
    limit: Option<f64>,
    /// Whether key frames are drawn on the line.
    has_keys: bool,
}

/// A pen that draws on an area with `fine` pixels for each pixel of the SVG.
struct Pen<'a, DB: DrawingBackend> {
    area: &'a DrawingArea<DB, Shift>,
    fine: i32,
}

impl<DB: DrawingBackend> Pen<'_, DB> {
    fn title(&self, title: &str, about: &str) -> Drawn<DB> {
        self.text(title, (20, 16), LARGE, INK)?;
        self.text(about, (20, 42), SMALL, GREY)
    }

    fn planned(&self, subject: &Move) -> Drawn<DB> {
        let (seconds, frames) = (number(subject.duration()), subject.frames());
        self.title(subject.name(), &format!("{seconds} s, {} frames at {} per second", frames.count, frames.rate))?;
        let mut top = TITLE;
        for (axis, colour) in subject.axes().iter().zip(COLOURS.iter().cycle()) {
            self.axis(axis, subject.duration(), top, *colour)?;
            top += AXIS;
        }
        Ok(())
    }

    fn recorded(&self, subject: &Recording) -> Drawn<DB> {
        self.title(&subject.title, &subject.about)?;
        let mut top = TITLE;
        for (track, colour) in subject.tracks.iter().zip(COLOURS.iter().cycle()) {
            self.text(&track.name, (20, top + 8), MIDDLE, *colour)?;
            let across = Across { span: track.span.clone(), unit: track.time_unit, keys: &track.keys, colour: *colour };
            let content = Content {
                title: "position",
                unit: track.unit.to_owned(),
                lines: &track.lines,
                values: trace::positions(&track.lines),
                limit: None,
                has_keys: true,
            };
            self.panels(&[content], top + HEADING, &across)?;
            top += TRACK;
        }
        Ok(())
    }

    fn axis(&self, axis: &MoveAxis, duration: f64, top: i32, colour: RGBColor) -> Drawn<DB> {
        let (name, unit, limits) = (axis.name(), axis.unit(), axis.limits());
        let keys: Vec<_> = axis.keys().iter().map(|key| (key.time, key.position)).collect();
        self.text(name, (20, top + 8), MIDDLE, colour)?;
        let Traces { position, velocity, acceleration } = Traces::new(axis, duration);
        let (speed, push) = (limits.map(|limits| limits.velocity), limits.map(|limits| limits.acceleration));
        let contents = [
            Content {
                title: "position",
                unit: unit.to_owned(),
                lines: &position,
                values: trace::positions(&position),
                limit: None,
                has_keys: true,
            },
            Content {
                title: "velocity",
                unit: format!("{unit}/s"),
                lines: &velocity,
                values: trace::rates(&velocity, speed),
                limit: speed,
                has_keys: false,
            },
            Content {
                title: "acceleration",
                unit: format!("{unit}/s²"),
                lines: &acceleration,
                values: trace::rates(&acceleration, push),
                limit: push,
                has_keys: false,
            },
        ];
        self.panels(&contents, top + HEADING, &Across { span: 0.0..duration, unit: " s", keys: &keys, colour })
    }

    fn panels(&self, contents: &[Content<'_>], mut top: i32, across: &Across<'_>) -> Drawn<DB> {
        let mut below = contents.len();
        for (content, height) in contents.iter().zip(PANELS) {
            below -= 1;
            let times = if below == 0 { TIMES } else { 0 };
            let area = self.area.clone().shrink((0, self.px(top)), (self.px(WIDTH), self.px(height + times)));
            let mut builder = ChartBuilder::on(&area);
            builder
                .set_label_area_size(LabelAreaPosition::Left, self.px(LEFT))
                .set_label_area_size(LabelAreaPosition::Bottom, self.px(times))
                .margin_right(self.px(RIGHT));
            let mut panel = builder.build_cartesian_2d(across.span.clone(), content.values.clone())?;
            self.grid(&mut panel, content, across)?;
            self.marks(&mut panel, content, across)?;
            self.curve(&mut panel, content, across)?;
            let line = |number: i32| (20, top + 4 + number * (SMALL + 4));
            self.text(content.title, line(0), SMALL, INK)?;
            self.text(&content.unit, line(1), SMALL, GREY)?;
            if let Some(limit) = content.limit {
                self.text(&format!("limit {}", number(limit)), line(2), SMALL, BEYOND)?;
            }
            top += height + GAP;
        }
        Ok(())
    }

    fn grid(&self, panel: &mut Panel<'_, DB>, content: &Content<'_>, across: &Across<'_>) -> Drawn<DB> {
        let labels = if content.title == "position" { 6_u32 } else { 5 };
        let length = across.span.end - across.span.start;
        let step = (content.values.end - content.values.start) / f64::from(labels);
        panel
            .configure_mesh()
            .x_labels(TIME_LABELS as usize)
            .y_labels(labels as usize)
            .x_label_formatter(&|time| format!("{}{}", tick(*time, length / f64::from(TIME_LABELS)), across.unit))
            .y_label_formatter(&|value| tick(*value, step))
            .label_style(self.style(SMALL, GREY))
            .bold_line_style(self.stroke(GRID))
            .light_line_style(TRANSPARENT)
            .axis_style(self.stroke(FRAME))
            .set_all_tick_mark_size(self.px(4))
            .draw()
    }

    /// Draws the zero line, the times of key frames, and the limits.
    fn marks(&self, panel: &mut Panel<'_, DB>, content: &Content<'_>, across: &Across<'_>) -> Drawn<DB> {
        let Range { start: low, end: high } = content.values;
        let Range { start, end } = across.span;
        let keys =
            across.keys.iter().map(|(time, _)| PathElement::new([(*time, low), (*time, high)], self.stroke(GRID)));
        panel.draw_series(keys)?;
        let zero =
            content.values.contains(&0.0).then(|| PathElement::new([(start, 0.0), (end, 0.0)], self.stroke(FRAME)));
        panel.draw_series(zero)?;
        let limits = content.limit.into_iter().flat_map(|limit| [limit, -limit]);
        for limit in limits.filter(|limit| content.values.contains(limit)) {
            let ends = [(start, limit), (end, limit)];
            let dashes = DashedLineSeries::new(ends, self.px(6), self.px(4), self.stroke(BEYOND));
            panel.draw_series(dashes)?;
            let (x, y) = panel.backend_coord(&(end, limit));
            let style = self.style(SMALL, BEYOND).pos(Pos::new(HPos::Left, VPos::Center));
            self.area.draw(&Text::new("limit", (x + self.px(6), y), style))?;
        }
        Ok(())
    }

    /// Draws the curve, in another colour where it exceeds the limits, and the key frames on it.
    fn curve(&self, panel: &mut Panel<'_, DB>, content: &Content<'_>, across: &Across<'_>) -> Drawn<DB> {
        let colour = across.colour;
        let Range { start: low, end: high } = content.values;
        let limit = content.limit.unwrap_or(f64::INFINITY);
        let shades = [(low..high, colour), (limit..high, BEYOND), (low..-limit, BEYOND)];
        for (values, colour) in shades {
            let parts = content.lines.iter().flat_map(|line| trace::clip(line, &values));
            panel.draw_series(
                parts.map(|part| PathElement::new(part, colour.stroke_width(2 * self.fine.unsigned_abs()))),
            )?;
        }
        let dots = across.keys.iter().copied().filter(|_| content.has_keys);
        panel.draw_series(dots.clone().map(|at| Circle::new(at, self.px(5), WHITE.filled())))?;
        panel.draw_series(dots.map(|at| Circle::new(at, self.px(4), colour.filled())))?;
        Ok(())
    }

    fn text(&self, text: &str, (x, y): (i32, i32), size: i32, colour: RGBColor) -> Drawn<DB> {
        let style = self.style(size, colour).pos(Pos::new(HPos::Left, VPos::Top));
        self.area.draw(&Text::new(text, (self.px(x), self.px(y)), style))
    }

    fn style(&self, size: i32, colour: RGBColor) -> TextStyle<'static> {
        (FONT, size * self.fine).into_font().color(&colour)
    }

    fn stroke(&self, colour: RGBColor) -> ShapeStyle {
        colour.stroke_width(self.fine.unsigned_abs())
    }

    /// A length of the SVG, in pixels of the area.
    fn px(&self, length: i32) -> i32 {
        length * self.fine
    }
}
