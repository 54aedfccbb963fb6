//! A move of all axes of a rig.

use std::collections::HashSet;
use std::fs::File;
use std::path::Path;

use motion_core::trajectory::{FrameRate, FrameTimes};

use crate::axis::{self, MoveAxis};
use crate::error::{MoveError, MoveProblem};
use crate::limits::{self, Excess};
use crate::text::{one_line, read_text};
use crate::{file, write};

/// Greatest number of axes of a move, more than any device has.
pub(crate) const MOST_AXES: usize = 64;

/// Greatest number of frames of a move, which DMC can count.
pub(crate) const MOST_FRAMES: u32 = 1 << 31;

/// A move of all axes of a rig in the same time.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    name: String,
    duration: f64,
    frames: FrameTimes,
    axes: Vec<MoveAxis>,
}

impl Move {
    /// A move from its name, its frame rate and its axes.
    ///
    /// The duration is in seconds. Without it, the move ends at its last key frame.
    ///
    /// # Errors
    ///
    /// [`MoveProblem`] if there is no axis or more than 64, two axes have the same name or the same motor, a key frame is
    /// later than the end, the frames are too many, or the name is not valid.
    pub fn new(
        name: impl Into<String>,
        rate: FrameRate,
        duration: Option<f64>,
        axes: Vec<MoveAxis>,
    ) -> Result<Self, MoveProblem> {
        let name = name.into();
        axis::label(&name, axis::LONGEST)?;
        let last = axes.iter().max_by(|one, other| one.curve().end().total_cmp(&other.curve().end()));
        let last = last.ok_or(MoveProblem::NoAxis)?;
        if axes.len() > MOST_AXES {
            return Err(MoveProblem::ManyAxes(axes.len()));
        }
        let end = last.curve().end();
        let duration = duration.unwrap_or(end);
        if duration < end || duration.is_nan() {
            return Err(MoveProblem::Short { duration, axis: last.name().to_owned(), key: end });
        }
        let mut names = HashSet::new();
        if let Some(axis) = axes.iter().find(|axis| !names.insert(axis.name())) {
            return Err(MoveProblem::Twice(axis.name().to_owned()));
        }
        shared(&axes, "kOS", |axis| axis.kos().map(|kos| kos.motor))?;
        shared(&axes, "DMC", |axis| axis.dmc().map(|dmc| dmc.motor))?;
        shared(&axes, "hoot", |axis| axis.hoot().map(|hoot| (hoot.address, hoot.motor)))?;
        let frames = FrameTimes::covering(0.0, duration, rate).filter(|frames| frames.count <= MOST_FRAMES);
        let frames = frames.ok_or_else(|| MoveProblem::Long { frames: (duration * rate.to_f64()).ceil() })?;
        Ok(Self { name, duration, frames, axes })
    }

    /// Reads a move from a file, in UTF-8, or in UTF-16 with a byte order mark.
    ///
    /// # Errors
    ///
    /// [`MoveError`].
    pub fn read(path: &Path) -> Result<Self, MoveError> {
        let name = one_line(&path.display().to_string());
        match File::open(path).and_then(read_text) {
            Ok(text) => Self::parse(&name, &text),
            Err(error) => Err(MoveError::Unreadable { name, error }),
        }
    }

    /// Reads a move from the text of a file, which may begin with a byte order mark; `name` is used in errors.
    ///
    /// # Errors
    ///
    /// [`MoveError`].
    pub fn parse(name: &str, text: &str) -> Result<Self, MoveError> {
        file::parse(name, text)
    }

    /// Text of a file with this move, with a line for each key frame. It is read back as the same move.
    #[must_use]
    pub fn to_json(&self) -> String {
        write::to_json(self)
    }

    /// Name of the move.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Duration, in seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Frames, from the start to the first one that is not before the end.
    #[must_use]
    pub fn frames(&self) -> FrameTimes {
        self.frames
    }

    /// Axes with their curves and motors, at least one.
    #[must_use]
    pub fn axes(&self) -> &[MoveAxis] {
        &self.axes
    }

    /// The places where curves exceed the limits of their axis, in the order of axes and time.
    pub fn excesses(&self) -> impl Iterator<Item = Excess<'_>> {
        self.axes.iter().flat_map(limits::excesses)
    }
}

/// Refuses a motor that is given for two axes.
fn shared<M: PartialEq>(
    axes: &[MoveAxis],
    protocol: &'static str,
    motor: impl Fn(&MoveAxis) -> Option<M>,
) -> Result<(), MoveProblem> {
    let mut rest = axes.iter();
    while let Some(one) = rest.next() {
        let Some(this) = motor(one) else { continue };
        if let Some(other) = rest.as_slice().iter().find(|other| motor(other).is_some_and(|motor| motor == this)) {
            let (one, other) = (one.name().to_owned(), other.name().to_owned());
            return Err(MoveProblem::Shared { protocol, one, other });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use motion_core::profile::Limits;

    use super::*;
    use crate::{AxisProblem, Dmc, Ease, KeyFrame};

    #[test]
    #[cfg(feature = "dmc")]
    fn the_greatest_number_of_frames_is_that_of_the_protocol() {
        assert_eq!(MOST_FRAMES, dmc_proto::upload::MAX_FRAMES);
    }

    #[test]
    fn a_move_in_code_is_the_move_of_its_file() {
        let ease = Ease::Flat(0.6);
        let axis = MoveAxis::builder("Slide", "mm")
            .limits(Limits { velocity: 250.0, acceleration: 450.0, jerk: None })
            .key(KeyFrame::new(0.5, 0.0))
            .key(KeyFrame { arrive: Ease::Handle { seconds: -1.0, units: -2.5 }, ..KeyFrame::new(3.0, 250.0) })
            .key(KeyFrame::new(7.5, 600.0).eased(ease))
            .dmc(Dmc::new(1, 80.0, 0.0).unwrap());
        let built = Move::new("Slide", FrameRate::new(24, 1).unwrap(), Some(8.0), vec![axis.build().unwrap()]).unwrap();
        let text = r#"{ "move": 1, "name": "Slide", "rate": 24, "duration": 8, "axes": [{
            "name": "Slide", "unit": "mm", "limits": { "velocity": 250, "acceleration": 450 },
            "keys": [
                { "time": 0.5, "position": 0 },
                { "time": 3, "position": 250, "arrive": [-1, -2.5] },
                { "time": 7.5, "position": 600, "ease": 0.6 }
            ],
            "dmc": { "motor": 1, "steps_per_unit": 80 }
        }] }"#;
        assert_eq!(built, Move::parse("", text).unwrap());
    }

    #[test]
    fn errors_of_a_move_in_code_name_axis_and_key_frame() {
        let frames = [KeyFrame::new(0.0, 0.0), KeyFrame::new(1.0, 5.0), KeyFrame::new(2.0, 9.0)];
        let error = |change: fn(&mut [KeyFrame; 3])| {
            let mut frames = frames;
            change(&mut frames);
            MoveAxis::builder("Pan", "°").keys(frames).build().unwrap_err().to_string()
        };
        for (line, expected) in [
            (error(|keys| keys[1].time = 2.0), "key frame 3 at 2 s is not later"),
            (error(|keys| keys[1].time = f64::NAN), "key frame 2: a time or a position is out of range"),
            (error(|keys| keys[2].position = f64::INFINITY), "key frame 3: a time or a position is out of range"),
            (error(|keys| keys[0].position = 1e300), "key frame 1: a time or a position is out of range"),
            (error(|keys| keys[1].leave = Ease::Flat(1.5)), "key frame 2 at 1 s: an ease is a number from 0 to 1"),
            (error(|keys| keys[2].leave = Ease::Flat(f64::NAN)), "key frame 3 at 2 s: an ease is a number"),
            (
                error(|keys| keys[1].arrive = Ease::Handle { seconds: 0.5, units: 0.0 }),
                "key frame 2 at 1 s: a handle reaches beyond",
            ),
        ] {
            assert!(line.starts_with("axis \"Pan\": ") && line.contains(expected), "{line}");
        }
        let builder = MoveAxis::builder("Pan", "°").keys(frames);
        let bad = builder.clone().limits(Limits { velocity: 0.0, acceleration: 1.0, jerk: None }).build();
        assert!(matches!(bad, Err(MoveProblem::Axis { problem: AxisProblem::Limits, .. })), "{bad:?}");
        let dmc = Dmc { motor: 33, ..Dmc::new(1, 80.0, 0.0).unwrap() };
        assert!(builder.clone().dmc(dmc).build().unwrap_err().to_string().contains("\"dmc\" has motor 33"));
        let (axis, rate) = (builder.build().unwrap(), FrameRate::new(24, 1).unwrap());
        let of = |duration, axes| Move::new("Pan", rate, Some(duration), axes).unwrap_err().to_string();
        assert_eq!(of(1.0, vec![]), "there is no axis: \"axes\" needs one");
        assert!(of(1.0, vec![axis.clone()]).contains("axis \"Pan\" has a key frame at 2 s"));
        assert!(of(f64::NAN, vec![axis.clone()]).contains("\"duration\" is NaN s"));
        assert!(of(f64::INFINITY, vec![axis.clone()]).contains("inf frames are too many"));
        assert!(of(2.0, vec![axis.clone(), axis]).contains("two axes have the name"));
    }
}
