//! Output of a command: lines of text, which programs can read as JSON.

use std::fmt;
use std::io::{self, Write};

use serde_json::{Value, json};

/// Meaning of a line, for programs.
#[derive(Debug, Clone, PartialEq)]
pub enum About {
    /// The line is for people only.
    Note,
    /// The line gives the position of a motor.
    Position(At),
    /// The line gives the progress of the command.
    Progress {
        /// Part of the command that is done, from 0 to 1. `None` if it is not known.
        part: Option<f64>,
        /// Positions of motors, as far as they are known.
        positions: Vec<At>,
    },
}

/// Position of a motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct At {
    /// Number of the motor, from 1.
    pub motor: u8,
    /// Position in rotations (kOS) or steps (DMC, hoot).
    pub position: f64,
}

impl About {
    /// Position of a motor.
    #[must_use]
    pub fn position(motor: u8, position: impl Into<f64>) -> Self {
        Self::Position(At { motor, position: position.into() })
    }

    /// Line as a JSON object: `event`, `text`, and what the event gives.
    #[must_use]
    pub fn json(&self, text: &str) -> Value {
        // Numbers of 32 bits have no more digits.
        let short = |number: f64| (number * 1e6).round() / 1e6;
        let at = |at: &At| json!({ "motor": at.motor, "position": short(at.position) });
        match *self {
            Self::Note => json!({ "event": "note", "text": text }),
            Self::Position(At { motor, position }) => {
                json!({ "event": "position", "motor": motor, "position": short(position), "text": text })
            }
            Self::Progress { part, ref positions } => {
                let positions: Vec<Value> = positions.iter().map(at).collect();
                json!({ "event": "progress", "part": part.map(short), "positions": positions, "text": text })
            }
        }
    }
}

/// Receiver of the lines of a command.
pub trait Output {
    /// Writes a line.
    ///
    /// # Errors
    ///
    /// Errors of the output.
    fn line(&mut self, about: About, text: fmt::Arguments<'_>) -> io::Result<()>;
}

/// Writers receive the text.
impl<W: Write> Output for W {
    fn line(&mut self, _: About, text: fmt::Arguments<'_>) -> io::Result<()> {
        writeln!(self, "{text}")?;
        self.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_line_is_an_object_with_an_event_and_a_text() {
        let positions = vec![At { motor: 2, position: 1.5 }];
        for (about, expected) in [
            (About::Note, r#"{"event":"note","text":"a \"rig\""}"#),
            (About::position(1, -3), r#"{"event":"position","motor":1,"position":-3.0,"text":"a \"rig\""}"#),
            (
                About::Progress { part: Some(0.25), positions },
                r#"{"event":"progress","part":0.25,"positions":[{"motor":2,"position":1.5}],"text":"a \"rig\""}"#,
            ),
            (
                About::Progress { part: None, positions: Vec::new() },
                r#"{"event":"progress","part":null,"positions":[],"text":"a \"rig\""}"#,
            ),
        ] {
            assert_eq!(about.json("a \"rig\"").to_string(), expected);
        }
    }
}
