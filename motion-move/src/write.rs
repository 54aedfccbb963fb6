//! Text of move files.

use std::io::{self, Write};

use motion_core::profile::Limits;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use serde_json::ser::{Formatter, PrettyFormatter};

use crate::axis::MoveAxis;
use crate::key::{Ease, KeyFrame};
use crate::motor::{Dmc, Hoot, Kos, USUAL_ADDRESS};
use crate::moves::Move;

/// Greatest whole rate that a file has as a number. A rate in thousandths of a frame per second has 32 bits.
const MOST: u32 = u32::MAX / 1000;

#[expect(clippy::expect_used, reason = "a move has strings and finite numbers only, which can be written")]
pub(crate) fn to_json(subject: &Move) -> String {
    let mut text = Vec::new();
    let layout = Layout { pretty: PrettyFormatter::with_indent(b"    "), depth: 0, are_keys: false };
    subject.serialize(&mut serde_json::Serializer::with_formatter(&mut text, layout)).expect("text and finite numbers");
    text.push(b'\n');
    String::from_utf8(text).expect("JSON is UTF-8")
}

impl Serialize for Move {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut file = serializer.serialize_map(None)?;
        file.serialize_entry("move", &1)?;
        file.serialize_entry("name", self.name())?;
        match self.frames().rate.fraction() {
            (frames @ ..=MOST, 1) => file.serialize_entry("rate", &frames)?,
            (frames, seconds) => file.serialize_entry("rate", &format!("{frames}/{seconds}"))?,
        }
        file.serialize_entry("duration", &Number(self.duration()))?;
        file.serialize_entry("axes", self.axes())?;
        file.end()
    }
}

impl Serialize for MoveAxis {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut axis = serializer.serialize_map(None)?;
        axis.serialize_entry("name", self.name())?;
        axis.serialize_entry("unit", self.unit())?;
        if let Some(Limits { velocity, acceleration, jerk }) = self.limits() {
            let (velocity, acceleration) = (Number(velocity), Number(acceleration));
            axis.serialize_entry("limits", &FileLimits { velocity, acceleration, jerk: jerk.map(Number) })?;
        }
        axis.serialize_entry("keys", self.keys())?;
        if let Some(kos) = self.kos() {
            axis.serialize_entry("kos", &kos)?;
        }
        if let Some(dmc) = self.dmc() {
            axis.serialize_entry("dmc", &dmc)?;
        }
        if let Some(hoot) = self.hoot() {
            axis.serialize_entry("hoot", &hoot)?;
        }
        axis.end()
    }
}

#[derive(Serialize)]
struct FileLimits {
    velocity: Number,
    acceleration: Number,
    #[serde(skip_serializing_if = "Option::is_none")]
    jerk: Option<Number>,
}

impl Serialize for KeyFrame {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut key = serializer.serialize_map(None)?;
        key.serialize_entry("time", &Number(self.time))?;
        key.serialize_entry("position", &Number(self.position))?;
        match (self.arrive, self.leave) {
            (Ease::Smooth, Ease::Smooth) => {}
            (arrive, leave) if arrive == leave => key.serialize_entry("ease", &arrive)?,
            (arrive, leave) => {
                for (name, ease) in [("arrive", arrive), ("leave", leave)] {
                    if ease != Ease::Smooth {
                        key.serialize_entry(name, &ease)?;
                    }
                }
            }
        }
        key.end()
    }
}

impl Serialize for Kos {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut kos = serializer.serialize_map(None)?;
        kos.serialize_entry("motor", &self.motor)?;
        kos.serialize_entry("rotations_per_unit", &Number(self.rotations.per_unit))?;
        offset::<S>(&mut kos, self.rotations.offset)?;
        kos.serialize_entry("range", &[self.range.from, self.range.to].map(Number))?;
        kos.end()
    }
}

impl Serialize for Dmc {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut dmc = serializer.serialize_map(None)?;
        dmc.serialize_entry("motor", &self.motor)?;
        dmc.serialize_entry("steps_per_unit", &Number(self.scale.per_unit()))?;
        offset::<S>(&mut dmc, self.scale.offset())?;
        dmc.end()
    }
}

impl Serialize for Hoot {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut hoot = serializer.serialize_map(None)?;
        if self.address != USUAL_ADDRESS {
            hoot.serialize_entry("address", &self.address)?;
        }
        hoot.serialize_entry("motor", &self.motor)?;
        hoot.serialize_entry("steps_per_unit", &Number(self.scale.per_unit()))?;
        offset::<S>(&mut hoot, self.scale.offset())?;
        hoot.end()
    }
}

fn offset<S: Serializer>(motor: &mut S::SerializeMap, offset: f64) -> Result<(), S::Error> {
    if offset == 0.0 { Ok(()) } else { motor.serialize_entry("offset", &Number(offset)) }
}

/// A number, without `.0` if it is whole.
pub(crate) struct Number(pub(crate) f64);

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        /// Whole numbers up to this one are exact.
        const EXACT: f64 = 9_007_199_254_740_992.0;
        #[expect(clippy::cast_possible_truncation, reason = "whole, and in range")]
        if self.0.fract() == 0.0 && self.0.abs() < EXACT {
            serializer.serialize_i64(self.0 as i64)
        } else {
            serializer.serialize_f64(self.0)
        }
    }
}

/// Layout of a file: a line for each member of the move and of its axes, and a line for each key frame.
struct Layout {
    pretty: PrettyFormatter<'static>,
    /// Number of arrays and objects around the next value.
    depth: u8,
    /// Whether the array or object at depth 4 is an array, which is that of the key frames.
    are_keys: bool,
}

impl Layout {
    /// Whether the values of the innermost array or object have lines of their own.
    fn is_tall(&self) -> bool {
        self.depth < 4 || (self.depth == 4 && self.are_keys)
    }

    fn begin(&mut self, is_array: bool) -> bool {
        self.depth = self.depth.saturating_add(1);
        if self.depth == 4 {
            self.are_keys = is_array;
        }
        self.is_tall()
    }

    fn end(&mut self) -> bool {
        let is_tall = self.is_tall();
        self.depth = self.depth.saturating_sub(1);
        is_tall
    }
}

impl Formatter for Layout {
    fn begin_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        if self.begin(true) { self.pretty.begin_array(out) } else { out.write_all(b"[") }
    }

    fn end_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        if self.end() { self.pretty.end_array(out) } else { out.write_all(b"]") }
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        if self.is_tall() {
            self.pretty.begin_array_value(out, first)
        } else {
            out.write_all(if first { b"" } else { b", " })
        }
    }

    fn end_array_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.pretty.end_array_value(out)
    }

    fn begin_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        if self.begin(false) { self.pretty.begin_object(out) } else { out.write_all(b"{ ") }
    }

    fn end_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        if self.end() { self.pretty.end_object(out) } else { out.write_all(b" }") }
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        if self.is_tall() {
            self.pretty.begin_object_key(out, first)
        } else {
            out.write_all(if first { b"" } else { b", " })
        }
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.pretty.begin_object_value(out)
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.pretty.end_object_value(out)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use motion_core::trajectory::{FrameRate, Range};
    use proptest::option;
    use proptest::prelude::*;

    use super::*;
    use crate::motor::Rotations;

    fn ease(sign: f64) -> impl Strategy<Value = Ease> {
        prop_oneof![
            Just(Ease::Smooth),
            Just(Ease::Linear),
            prop_oneof![Just(0.0), Just(1.0), 0.0..=1.0].prop_map(Ease::Flat),
            (-50.0..50.0).prop_map(|units| Ease::Handle { seconds: 0.0, units }),
            (0.0..=0.1, -50.0..50.0).prop_map(move |(seconds, units)| Ease::Handle { seconds: sign * seconds, units }),
        ]
    }

    prop_compose! {
        /// Any move of two axes that is valid.
        pub(crate) fn any_move()(
            name in "[a-zé\"\\\\ ]{0,20}",
            gaps in prop::collection::vec((0.11..20.0, -1e3..1e3, ease(-1.0), ease(1.0)), 2..7),
            (frames, seconds) in (1_u32..100_000, 1_u32..2_000),
            (limits, jerk) in (option::of([1e-3..1e6, 1e-3..1e6]), option::of(1e-3..1e6)),
            (kos, dmc, hoot) in (option::of(1e-4..1e-2), option::of(-1e5..-1e-3), option::of(1e-3..1e5)),
            (address, offset) in (2_u8..=255, -1e6..1e6),
            more in option::of(0.0..10.0),
        ) -> Move {
            let mut time = -0.11;
            let keys = gaps.into_iter().map(|(gap, position, arrive, leave)| {
                time += gap;
                KeyFrame { time, position, arrive, leave }
            });
            let axis = MoveAxis::builder(format!("{name}1"), "mm").keys(keys.collect::<Vec<_>>());
            let axis = match limits {
                Some([velocity, acceleration]) => axis.limits(Limits { velocity, acceleration, jerk }),
                None => axis,
            };
            let other = MoveAxis::builder("2", "°").keys([KeyFrame::new(1.0, 2.0), KeyFrame::new(3.5, 2.0)]);
            // Handles and flat eases stay within the range of the key frames plus the handles.
            let axis = match kos {
                Some(per_unit) => axis.kos(
                    Kos::new(1, Rotations { per_unit, offset }, Range::new(offset - 20.0, offset + 20.0)).unwrap()
                ),
                None => axis,
            };
            let axis = match dmc { Some(scale) => axis.dmc(Dmc::new(32, scale, offset).unwrap()), None => axis };
            let axis = match hoot { Some(scale) => axis.hoot(Hoot::new(address, 3, scale, offset).unwrap()), None => axis };
            let rate = FrameRate::new(frames, seconds).unwrap();
            let duration = more.map(|more| time.max(3.5) + more);
            Move::new(format!("{name}!"), rate, duration, vec![axis.build().unwrap(), other.build().unwrap()]).unwrap()
        }
    }

    proptest! {
        #[test]
        fn a_written_move_is_read_back_as_the_same(subject in any_move()) {
            let text = subject.to_json();
            prop_assert_eq!(&Move::parse("", &text).unwrap(), &subject, "{}", text);
            let value = serde_json::to_value(&subject).unwrap();
            prop_assert_eq!(serde_json::from_value::<Move>(value).unwrap(), subject);
        }
    }

    #[test]
    fn a_written_move_looks_like_the_samples() {
        for text in [crate::tests::SLIDE, crate::tests::CRANE, crate::tests::PAN, crate::tests::WHIP] {
            let subject = Move::parse("", text).unwrap();
            let written = subject.to_json();
            // The usual address is not written.
            assert_eq!(written, text.replace("\"address\": 3, ", ""));
        }
    }
}
