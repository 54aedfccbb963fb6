//! What a conversion loses.

#![cfg_attr(
    not(all(feature = "kos", feature = "dmc", feature = "hoot")),
    allow(dead_code, reason = "each conversion uses some of it")
)]

use std::fmt;

use crate::axis::MoveAxis;
use crate::moves::Move;
use crate::text::one_line;

/// Difference between a move and its conversion. It prints as one line: how much, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct Loss {
    /// Name of the axis; `None` for the whole move.
    pub axis: Option<String>,
    /// Time of the greatest difference, in seconds from the start of the move.
    pub time: f64,
    /// Greatest difference, in `unit`. The true difference is not greater.
    pub amount: f64,
    /// Unit of the amount.
    pub unit: String,
    /// Cause of the loss.
    pub kind: LossKind,
}

/// Cause of a loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LossKind {
    /// The axis has no motor of this protocol, and is left out. The amount is the distance between its least and its
    /// greatest position.
    LeftOut(&'static str),
    /// Times and positions are rounded to parts of the move and of the range, as numbers of 32 bits.
    Numbers,
    /// The duration is rounded to a number of 32 bits.
    Duration,
    /// Positions are whole steps at whole frames, and motors go straight from frame to frame.
    Frames,
    /// The frame rate is rounded to thousandths of a frame per second. The amount is the difference of the duration.
    Rate,
    /// A planned move follows the curve as near as it can.
    Planned,
    /// Key frames with a velocity, between which the motor follows a cubic, follow the curve as near as they can.
    KeyFrames,
    /// A motor of a rig was measured while the move was played.
    Played,
}

impl Loss {
    /// The loss of an axis, in its unit.
    pub(crate) fn of(axis: &MoveAxis, kind: LossKind, amount: f64, time: f64) -> Self {
        Self { axis: Some(axis.name().to_owned()), time, amount, unit: axis.unit().to_owned(), kind }
    }

    /// A difference of the time at which the move ends.
    pub(crate) fn late(subject: &Move, kind: LossKind, amount: f64) -> Self {
        Self { axis: None, time: subject.duration(), amount, unit: "s".to_owned(), kind }
    }

    /// The losses of the axes that have no motor of a protocol.
    pub(crate) fn left_out(
        subject: &Move,
        protocol: &'static str,
        has_motor: impl Fn(&MoveAxis) -> bool,
    ) -> impl Iterator<Item = Self> {
        subject.axes().iter().filter(move |axis| !has_motor(axis)).map(move |axis| {
            let curve = axis.curve();
            Self::of(axis, LossKind::LeftOut(protocol), curve.range().width(), curve.start())
        })
    }
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.axis {
            Some(axis) => write!(f, "axis {axis:?}")?,
            None => f.write_str("the whole move")?,
        }
        let (amount, time, unit) = (rounded_up(self.amount), thousandths(self.time), one_line(&self.unit));
        match self.kind {
            LossKind::LeftOut(protocol) => {
                return write!(f, " is left out, because it has no {protocol} motor: {amount} {unit} of way");
            }
            LossKind::Duration | LossKind::Rate => write!(f, " ends at most {amount} s from {time} s")?,
            _ => write!(f, " is at most {amount} {unit} away, at {time} s")?,
        }
        f.write_str(match self.kind {
            LossKind::LeftOut(_) => "",
            LossKind::Numbers => " (numbers of 32 bits)",
            LossKind::Duration => " (a duration of 32 bits)",
            LossKind::Frames => " (whole steps, straight from frame to frame)",
            LossKind::Rate => " (a rate in thousandths)",
            LossKind::Planned => " (a planned move)",
            LossKind::KeyFrames => " (key frames with a velocity)",
            LossKind::Played => " (as it was played)",
        })
    }
}

/// An amount with three digits, rounded up.
fn rounded_up(amount: f64) -> String {
    if !(amount > 0.0 && amount.is_finite()) {
        return format!("{amount}");
    }
    #[expect(clippy::cast_possible_truncation, reason = "from -324 to 308")]
    let digits = 2_i32.saturating_sub(amount.log10().floor() as i32);
    let scale = 10_f64.powi(digits);
    // Three digits need no more than what is printed exactly.
    let text = match usize::try_from(digits) {
        Ok(digits) if scale.is_finite() => format!("{:.digits$}", (amount * scale).ceil() / scale),
        Ok(_) => return "0".to_owned(),
        Err(_) => format!("{}", (amount * scale).ceil() / scale),
    };
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

fn thousandths(time: f64) -> String {
    let text = format!("{time:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_have_three_digits_and_are_rounded_up() {
        for (amount, text) in [
            (0.0, "0"),
            (0.012_34, "0.0124"),
            (0.012_3, "0.0123"),
            (1.0, "1"),
            (12.301, "12.4"),
            (90.0, "90"),
            (1_234.5, "1240"),
            (9.999, "10"),
            (3.1e-8, "0.000000031"),
        ] {
            assert_eq!(rounded_up(amount), text);
        }
    }

    #[test]
    fn a_loss_is_one_line() {
        let loss =
            |kind| Loss { axis: Some("Pan".to_owned()), time: 1.25, amount: 0.012_34, unit: "°".to_owned(), kind };
        assert_eq!(
            loss(LossKind::Frames).to_string(),
            "axis \"Pan\" is at most 0.0124 ° away, at 1.25 s (whole steps, straight from frame to frame)"
        );
        assert_eq!(
            loss(LossKind::LeftOut("DMC")).to_string(),
            "axis \"Pan\" is left out, because it has no DMC motor: 0.0124 ° of way"
        );
        let rate = Loss { axis: None, ..loss(LossKind::Rate) };
        assert_eq!(rate.to_string(), "the whole move ends at most 0.0124 s from 1.25 s (a rate in thousandths)");
    }
}
