//! The data of a move, as it is uploaded.

use dmc_proto::message::{DmxChannel, FrameNumber, Motor, Motors, Steps, Triggers};
use dmc_proto::upload::MoveSource;

/// A move: the steps of each motor at each frame, and what the lights and outputs do meanwhile.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    first: FrameNumber,
    frames: u32,
    axes: Vec<(Motor, Vec<i32>)>,
    lights: Vec<(DmxChannel, Vec<u8>)>,
    mask: Triggers,
    triggers: Vec<Triggers>,
}

impl Table {
    /// A move of so many frames without motors, whose first frame has this number.
    #[must_use]
    pub const fn new(first: FrameNumber, frames: u32) -> Self {
        Self { first, frames, axes: Vec::new(), lights: Vec::new(), mask: Triggers::NONE, triggers: Vec::new() }
    }

    /// The same, with the steps of a motor: behind the last of them it rests. Of a motor that is given twice, the later
    /// steps count. One without any is left out.
    #[must_use]
    pub fn with(mut self, motor: Motor, steps: Vec<i32>) -> Self {
        self.axes.retain(|(other, _)| *other != motor);
        if !steps.is_empty() {
            self.axes.push((motor, steps));
        }
        self
    }

    /// The same, with the levels of a light: behind the last of them it stays as it is.
    #[must_use]
    pub fn with_light(mut self, channel: DmxChannel, levels: Vec<u8>) -> Self {
        self.lights.retain(|(other, _)| *other != channel);
        if !levels.is_empty() {
            self.lights.push((channel, levels));
        }
        self
    }

    /// The same, switching these outputs: those that are on at each frame. Behind the last of them, all are off.
    #[must_use]
    pub fn with_outputs(self, mask: Triggers, triggers: Vec<Triggers>) -> Self {
        Self { mask, triggers, ..self }
    }

    /// The number of the last frame.
    #[must_use]
    pub fn last_frame(&self) -> FrameNumber {
        let last = i64::from(self.first.0) + i64::from(self.frames.max(1)) - 1;
        FrameNumber(i32::try_from(last).unwrap_or(i32::MAX))
    }

    /// The steps of a motor at a frame; `None` if it is no part of the move, or the frame is not.
    #[must_use]
    pub fn steps(&self, motor: Motor, frame: FrameNumber) -> Option<i32> {
        let (_, steps) = self.axes.iter().find(|(other, _)| *other == motor)?;
        let index = u32::try_from(i64::from(frame.0) - i64::from(self.first.0)).ok()?;
        let index = (index < self.frames).then(|| usize::try_from(index).ok())??;
        steps.get(index).or(steps.last()).copied()
    }
}

impl Default for Table {
    /// One frame without motors.
    fn default() -> Self {
        Self::new(FrameNumber(1), 1)
    }
}

impl MoveSource for Table {
    fn start_frame(&self) -> FrameNumber {
        self.first
    }

    fn frame_count(&self) -> u32 {
        self.frames
    }

    fn motors(&self) -> Motors {
        self.axes.iter().map(|(motor, _)| *motor).collect()
    }

    fn position(&self, motor: Motor, index: u32) -> Steps {
        let frame = i64::from(self.first.0) + i64::from(index);
        let steps = i32::try_from(frame).ok().and_then(|frame| self.steps(motor, FrameNumber(frame)));
        Steps(steps.unwrap_or_default())
    }

    fn has_channel(&self, channel: DmxChannel) -> bool {
        self.lights.iter().any(|(other, _)| *other == channel)
    }

    fn level(&self, channel: DmxChannel, index: u32) -> u8 {
        let light = self.lights.iter().find(|(other, _)| *other == channel);
        light.and_then(|(_, levels)| value(levels, index).or(levels.last())).copied().unwrap_or_default()
    }

    fn mask(&self) -> Triggers {
        self.mask
    }

    fn triggers(&self, index: u32) -> Triggers {
        value(&self.triggers, index).copied().unwrap_or_default()
    }
}

fn value<T>(values: &[T], index: u32) -> Option<&T> {
    values.get(usize::try_from(index).ok()?)
}
