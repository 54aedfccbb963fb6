//! Data of a move for an upload.

use dmc_proto::message::{DmxChannel, FrameNumber, Motor, Motors, Steps, Triggers};
use dmc_proto::upload::MoveSource;

/// Move: the steps of each motor at each frame, the levels of lights, and the outputs that are on.
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
    /// Move without motors, with the number of its first frame and its number of frames.
    #[must_use]
    pub const fn new(first: FrameNumber, frames: u32) -> Self {
        Self { first, frames, axes: Vec::new(), lights: Vec::new(), mask: Triggers::NONE, triggers: Vec::new() }
    }

    /// Returns the move with the steps of a motor, from the first frame on. After the last step, the motor rests. If a motor
    /// is given twice, the later steps count. A motor without steps is left out.
    #[must_use]
    pub fn with(mut self, motor: Motor, steps: Vec<i32>) -> Self {
        self.axes.retain(|(other, _)| *other != motor);
        if !steps.is_empty() {
            self.axes.push((motor, steps));
        }
        self
    }

    /// Returns the move with the levels of a light, from the first frame on. After the last level, the light stays as it is.
    #[must_use]
    pub fn with_light(mut self, channel: DmxChannel, levels: Vec<u8>) -> Self {
        self.lights.retain(|(other, _)| *other != channel);
        if !levels.is_empty() {
            self.lights.push((channel, levels));
        }
        self
    }

    /// Returns the move with the outputs that it switches, and those that are on at each frame. After the last of these,
    /// all outputs are off.
    #[must_use]
    pub fn with_outputs(self, mask: Triggers, triggers: Vec<Triggers>) -> Self {
        Self { mask, triggers, ..self }
    }

    /// Number of the last frame.
    #[must_use]
    pub fn last_frame(&self) -> FrameNumber {
        let last = i64::from(self.first.0) + i64::from(self.frames.max(1)) - 1;
        FrameNumber(i32::try_from(last).unwrap_or(i32::MAX))
    }

    /// Frame of the move that is nearest to a frame.
    pub(super) fn nearest(&self, frame: FrameNumber) -> FrameNumber {
        frame.min(self.last_frame()).max(self.first)
    }

    /// Steps of a motor at a frame; `None` if the motor or the frame is not part of the move.
    #[must_use]
    pub fn steps(&self, motor: Motor, frame: FrameNumber) -> Option<i32> {
        let (_, steps) = self.axes.iter().find(|(other, _)| *other == motor)?;
        let index = u32::try_from(i64::from(frame.0) - i64::from(self.first.0)).ok()?;
        let index = (index < self.frames).then(|| usize::try_from(index).ok())??;
        steps.get(index).or(steps.last()).copied()
    }
}

impl Default for Table {
    /// Move of one frame without motors.
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
