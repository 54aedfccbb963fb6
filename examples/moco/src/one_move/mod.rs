//! Command `one-move`: converts a move file to all three protocols, and says what each of them loses.

mod play;

use std::io::Write;
use std::path::PathBuf;

use clap::Parser;
use dmc_proto::upload::MoveSource;
use examples::program::{Failure, written};
use kos_proto::message::{Normalized, Seconds};
use kos_proto::trajectory::{Delay, LiveMotion, Loop, Play};
use motion_move::{Excess, Loss, LossKind, Move, MoveAxis, dmc, hoot, kos};
use motion_rigs::hoot_node::Setup;
use serde_json::{Value, json};

use crate::plot::save;

/// Convert a move file to kOS, DMC and hoot: what is converted, what is lost and where, and which limits are exceeded
///
/// Each line begins with the protocol. A loss is a bound: the true difference is not greater.
#[derive(Debug, Clone, PartialEq, Parser)]
pub struct Args {
    /// Move file, such as examples/moves/slide.json
    pub file: PathBuf,
    /// Play the move on three simulated rigs, and draw where they went over where they should into this SVG; by default
    /// the name of the file with `-played.svg`, in the current folder
    #[arg(long, value_name = "OUT.svg", num_args = 0..=1)]
    pub play: Option<Option<PathBuf>>,
    /// Print JSON objects instead of lines: "protocol", "kind" and "text", and numbers
    #[arg(long)]
    pub json: bool,
}

/// Converts the move file, and writes the lines to `output`.
///
/// # Errors
///
/// The move file cannot be read, or the picture cannot be written.
pub fn one_move(args: &Args, output: &mut impl Write) -> Result<(), Failure> {
    let subject = Move::read(&args.file).map_err(Failure::not_done)?;
    let mut lines = Lines { output, json: args.json };
    let converted = Converted::new(&subject);
    converted.print(&mut lines)?;
    let Some(path) = &args.play else { return Ok(()) };
    let stem = args.file.file_stem().unwrap_or_default().to_string_lossy();
    let path = path.clone().unwrap_or_else(|| PathBuf::from(format!("{stem}-played.svg")));
    let mut played = Vec::new();
    for (protocol, result) in play::all(&subject, &converted) {
        match result {
            Ok(tracks) => played.extend(tracks),
            Err(why) => {
                lines.say(protocol, "refused", &format!("the simulated rig does not play it: {why}"), json!({}))?;
            }
        }
    }
    for track in &played {
        let Some(axis) = subject.axes().get(track.axis) else { continue };
        let (time, amount) = track.farthest(axis);
        let (name, unit) = (Some(axis.name().to_owned()), axis.unit().to_owned());
        let loss = Loss { axis: name, time, amount, unit, kind: LossKind::Played };
        lines.loss(track.label, "played", &loss)?;
    }
    let most = Setup::default().limits.velocity;
    for planned in converted.hoot.iter().flat_map(|converted| &converted.planned) {
        let asked = planned.peak() * 1000.0;
        if asked > most {
            let text =
                format!("motor {} has to go at {asked:.0} steps/s, the simulated node goes at {most}", planned.motor);
            lines.say("hoot", "note", &text, json!({}))?;
        }
    }
    let svg = plot::played(&subject, &played).map_err(Failure::not_done)?;
    let name = save(&path, svg.as_bytes())?;
    lines.say("all", "picture", &name, json!({}))
}

/// Output of the command.
struct Lines<'a, W> {
    output: &'a mut W,
    json: bool,
}

impl<W: Write> Lines<'_, W> {
    /// Writes a line. Its `fields` are for JSON.
    fn say(&mut self, protocol: &str, kind: &str, text: &str, mut fields: Value) -> Result<(), Failure> {
        written(if self.json {
            fields["protocol"] = protocol.into();
            fields["kind"] = kind.into();
            fields["text"] = text.into();
            writeln!(self.output, "{fields}")
        } else {
            writeln!(self.output, "{protocol}: {text}")
        })
    }

    fn axis(&mut self, protocol: &str, axis: &MoveAxis, motor: &str) -> Result<(), Failure> {
        let fields = json!({ "axis": axis.name(), "motor": motor });
        self.say(protocol, "axis", &format!("{motor} moves axis {:?}", axis.name()), fields)
    }

    fn loss(&mut self, protocol: &str, kind: &str, loss: &Loss) -> Result<(), Failure> {
        let Loss { axis, time, amount, unit, .. } = loss;
        let fields = json!({ "axis": axis, "time": time, "amount": amount, "unit": unit });
        self.say(protocol, kind, &loss.to_string(), fields)
    }

    fn ends(&mut self, protocol: &str, losses: &[Loss], excesses: &[Excess<'_>]) -> Result<(), Failure> {
        for loss in losses {
            self.loss(protocol, "loss", loss)?;
        }
        for excess in excesses {
            self.say(protocol, "excess", &excess.to_string(), json!({ "axis": excess.axis.name() }))?;
        }
        Ok(())
    }

    fn not(&mut self, protocol: &str, why: &str) -> Result<(), Failure> {
        self.say(protocol, "not_converted", &format!("not converted: {why}"), json!({}))
    }
}

/// Move in all three protocols.
struct Converted<'a> {
    subject: &'a Move,
    kos: Result<kos::Converted<'a>, kos::Error>,
    dmc: Result<dmc::Converted<'a>, dmc::Error>,
    hoot: Result<hoot::Converted<'a>, hoot::Error>,
    keys: Result<hoot::KeyFrames<'a>, hoot::Error>,
}

impl<'a> Converted<'a> {
    #[expect(clippy::cast_possible_truncation, reason = "the protocol has 32-bit numbers")]
    fn new(subject: &'a Move) -> Self {
        let duration = Seconds(subject.duration() as f32);
        let play =
            Play::Live(LiveMotion { duration, repeat: Loop::Once, delay: Delay::None, home_speed: Normalized(0.2) });
        Self {
            subject,
            kos: kos::convert(subject, play),
            dmc: dmc::convert(subject),
            hoot: hoot::convert(subject, hoot::Options::default()),
            keys: hoot::key_frames(subject, hoot::KeyOptions::default()),
        }
    }

    fn print(&self, lines: &mut Lines<'_, impl Write>) -> Result<(), Failure> {
        let axes = self.subject.axes();
        match &self.kos {
            Err(why) => lines.not("kOS", &why.to_string())?,
            Ok(kos::Converted { losses, excesses, .. }) => {
                for (axis, kos) in axes.iter().filter_map(|axis| Some((axis, axis.kos()?))) {
                    lines.axis("kOS", axis, &format!("motor {}", kos.motor))?;
                }
                lines.ends("kOS", losses, excesses)?;
            }
        }
        match &self.dmc {
            Err(why) => lines.not("DMC", &why.to_string())?,
            Ok(converted) => {
                let (frames, rate) = (converted.frame_count(), converted.rate());
                lines.say(
                    "DMC",
                    "frames",
                    &format!("{frames} frames at {rate} per second"),
                    json!({ "frames": frames }),
                )?;
                for (axis, dmc) in axes.iter().filter_map(|axis| Some((axis, axis.dmc()?))) {
                    lines.axis("DMC", axis, &format!("motor {}", dmc.motor))?;
                }
                lines.ends("DMC", &converted.losses, &converted.excesses)?;
            }
        }
        match &self.hoot {
            Err(why) => lines.not("hoot", &why.to_string())?,
            Ok(hoot::Converted { losses, excesses, .. }) => {
                for (axis, hoot) in axes.iter().filter_map(|axis| Some((axis, axis.hoot()?))) {
                    lines.axis("hoot", axis, &format!("motor {} of node {}", hoot.motor, hoot.address))?;
                }
                lines.ends("hoot", losses, excesses)?;
            }
        }
        if let Ok(hoot::KeyFrames { axes, losses, .. }) = &self.keys {
            for keys in axes {
                let text = format!(
                    "motor {} of node {} with later firmware has {} key frames",
                    keys.motor,
                    keys.node.0,
                    keys.keys.len()
                );
                lines.say("hoot", "key_frames", &text, json!({}))?;
            }
            lines.ends("hoot", losses.get(..axes.len()).unwrap_or_default(), &[])?;
        }
        Ok(())
    }
}
