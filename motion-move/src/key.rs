//! Key frames with their eases, and their conversion to handles.

use motion_core::bezier::{self, Key, Point};

/// Ease of an axis on one side of a key frame. On the outer side of the first and the last key frame it has no effect.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Ease {
    /// Through the key frame without a corner, and never beyond the positions of its neighbours; at rest at the first
    /// and the last key frame, and where the axis changes its direction.
    #[default]
    Smooth,
    /// Straight towards the other key frame.
    Linear,
    /// To rest or from rest, with a flat handle whose length is this part of the time between the key frames, from 0
    /// to 1.
    Flat(f64),
    /// Bezier handle, as its distance from the key frame. It is not beyond the other key frame.
    Handle {
        /// Time, in seconds; 0 or more to leave, 0 or less to arrive.
        seconds: f64,
        /// Position, in units of the axis.
        units: f64,
    },
}

/// Key frame: the position of an axis at a time, and how the axis arrives and leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyFrame {
    /// Time from the start of the move, in seconds, 0 or more.
    pub time: f64,
    /// Position, in units of the axis.
    pub position: f64,
    /// Ease before the key frame.
    pub arrive: Ease,
    /// Ease after the key frame.
    pub leave: Ease,
}

impl KeyFrame {
    /// A key frame with smooth eases.
    #[must_use]
    pub const fn new(time: f64, position: f64) -> Self {
        Self { time, position, arrive: Ease::Smooth, leave: Ease::Smooth }
    }

    /// The same key frame with one ease on both sides.
    #[must_use]
    pub const fn eased(self, ease: Ease) -> Self {
        Self { arrive: ease, leave: ease, ..self }
    }
}

/// Why an ease has no handle.
pub(crate) enum BadEase {
    /// The part is not from 0 to 1, or the handle is not finite.
    Number,
    /// The handle reaches beyond the other key frame, or away from it.
    Handle,
}

/// The key frame with its handles, from the key frames before and after it.
pub(crate) fn key(before: Option<&KeyFrame>, this: &KeyFrame, after: Option<&KeyFrame>) -> Result<Key, BadEase> {
    let slope = slope(before, this, after);
    let ease = |ease: Ease, other: Option<&KeyFrame>| {
        let is_sound = match ease {
            Ease::Smooth | Ease::Linear => true,
            Ease::Flat(part) => (0.0..=1.0).contains(&part),
            Ease::Handle { seconds, units } => seconds.is_finite() && units.is_finite(),
        };
        if !is_sound {
            return Err(BadEase::Number);
        }
        let Some(other) = other else { return Ok(bezier::Ease::Linear) };
        let way = other.time - this.time;
        match ease {
            Ease::Smooth => Ok(bezier::Ease::Handle(Point::new(way / 3.0, slope * way / 3.0))),
            Ease::Linear => Ok(bezier::Ease::Linear),
            Ease::Flat(part) => Ok(bezier::Ease::Flat(part)),
            Ease::Handle { seconds, units } if (0.0..=1.0).contains(&(seconds / way)) => {
                Ok(bezier::Ease::Handle(Point::new(seconds, units)))
            }
            Ease::Handle { .. } => Err(BadEase::Handle),
        }
    };
    let (arrive, leave) = (ease(this.arrive, before)?, ease(this.leave, after)?);
    Ok(Key { time: this.time, position: this.position, arrive, leave })
}

/// Velocity of a smooth axis at a key frame: the mean velocity from the key frame before to the one after, limited so
/// that a curve with handles of one third stays between its neighbours. It is 0 at the ends, and where the axis changes
/// its direction.
fn slope(before: Option<&KeyFrame>, this: &KeyFrame, after: Option<&KeyFrame>) -> f64 {
    let (Some(before), Some(after)) = (before, after) else { return 0.0 };
    let rise = |from: &KeyFrame, to: &KeyFrame| (to.position - from.position) / (to.time - from.time);
    let (arriving, leaving) = (rise(before, this), rise(this, after));
    if arriving * leaving <= 0.0 {
        return 0.0;
    }
    rise(before, after).abs().min(3.0 * arriving.abs()).min(3.0 * leaving.abs()).copysign(leaving)
}
