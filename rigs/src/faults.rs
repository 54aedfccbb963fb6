//! Faults of lines and rigs: kind, rate and time, all from a seed.
//!
//! ```
//! use motion_rigs::faults::{Carrier, Faults};
//!
//! assert_eq!(Faults::parse("all", Carrier::Serial)?, Faults::all(Carrier::Serial));
//! let some = Faults::parse("loss=0.01,delay=40", Carrier::Serial)?;
//! assert_eq!((some.loss, some.delay, some.garbage), (0.01, 40, 0.0));
//! // TCP loses nothing. It can only break.
//! assert!(Faults::parse("loss=0.01", Carrier::Stream).is_err());
//! # Ok::<(), motion_rigs::faults::FaultsError>(())
//! ```

use std::fmt;

use motion_core::time::Millis;
use rand::{Rng as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Carrier of bytes, which decides the faults that are possible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Carrier {
    /// Serial line: bytes are lost, doubled or damaged, and other bytes come in between.
    Serial,
    /// TCP: bytes come complete, in order and once, until the connection breaks.
    Stream,
    /// UDP: each datagram comes complete, or is lost, doubled or damaged.
    Datagram,
}

/// Rates of faults. Rates are from 0 to 1, per piece as it is written or read; 0 means never.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Faults {
    /// Rate of pieces that are lost.
    pub loss: f64,
    /// Rate of pieces that come twice.
    pub duplication: f64,
    /// Rate of pieces with one wrong bit.
    pub corruption: f64,
    /// Rate of pieces with random bytes before them.
    pub garbage: f64,
    /// Rate of pieces that are cut in two, or that wait for the next piece and arrive with it as one.
    pub cutting: f64,
    /// Rate of pieces in the middle of which the connection breaks.
    pub break_off: f64,
    /// Greatest delay of a piece, in milliseconds. No piece overtakes another.
    pub delay: u64,
    /// Mean time between two silences of the device, in seconds. For up to a second and a half, the device receives and
    /// sends nothing. Bytes that arrive wait.
    pub silence: f64,
    /// Mean time between two resets, in seconds.
    pub reset: f64,
    /// Mean time between two motors that get stuck, in seconds.
    pub stall: f64,
}

/// Error in a text that should name faults.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct FaultsError(String);

/// Fault that a text can name.
struct Named {
    name: &'static str,
    unit: Unit,
    /// Carriers that can have the fault.
    carriers: &'static [Carrier],
    /// Value that `all` sets.
    usual: f64,
    put: fn(&mut Faults, f64),
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Unit {
    Rate,
    Millis,
    Seconds,
}

const LOSSY: &[Carrier] = &[Carrier::Serial, Carrier::Datagram];
const LINES: &[Carrier] = &[Carrier::Serial, Carrier::Stream];
const ANY: &[Carrier] = &[Carrier::Serial, Carrier::Stream, Carrier::Datagram];

const ALL: [Named; 10] = [
    named("loss", Unit::Rate, 0.02, LOSSY, |it, value| it.loss = value),
    named("duplication", Unit::Rate, 0.02, LOSSY, |it, value| it.duplication = value),
    named("corruption", Unit::Rate, 0.02, LOSSY, |it, value| it.corruption = value),
    named("garbage", Unit::Rate, 0.02, &[Carrier::Serial], |it, value| it.garbage = value),
    named("cutting", Unit::Rate, 0.3, LINES, |it, value| it.cutting = value),
    named("break", Unit::Rate, 0.01, &[Carrier::Stream], |it, value| it.break_off = value),
    named("delay", Unit::Millis, 20.0, ANY, |it, value| it.delay = millis(value)),
    named("silence", Unit::Seconds, 10.0, LINES, |it, value| it.silence = value),
    named("reset", Unit::Seconds, 60.0, LINES, |it, value| it.reset = value),
    named("stall", Unit::Seconds, 60.0, LINES, |it, value| it.stall = value),
];

const fn named(
    name: &'static str,
    unit: Unit,
    usual: f64,
    carriers: &'static [Carrier],
    put: fn(&mut Faults, f64),
) -> Named {
    Named { name, unit, carriers, usual, put }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the reader accepts 0 to 60,000")]
const fn millis(value: f64) -> u64 {
    value as u64
}

impl Faults {
    /// No faults.
    pub const NONE: Self = Self {
        loss: 0.0,
        duplication: 0.0,
        corruption: 0.0,
        garbage: 0.0,
        cutting: 0.0,
        break_off: 0.0,
        delay: 0,
        silence: 0.0,
        reset: 0.0,
        stall: 0.0,
    };

    /// All faults that a carrier can have, at the rates of a bad day.
    #[must_use]
    pub fn all(carrier: Carrier) -> Self {
        let mut all = Self::NONE;
        for named in ALL.iter().filter(|named| named.carriers.contains(&carrier)) {
            (named.put)(&mut all, named.usual);
        }
        all
    }

    /// Reads `all`, `none`, or a list such as `loss=0.01,delay=40`. A name alone has the value that it has in `all`.
    ///
    /// # Errors
    ///
    /// [`FaultsError`] names the wrong part and the values that are allowed.
    pub fn parse(text: &str, carrier: Carrier) -> Result<Self, FaultsError> {
        match text {
            "all" => return Ok(Self::all(carrier)),
            "none" => return Ok(Self::NONE),
            _ => {}
        }
        let mut faults = Self::NONE;
        for part in text.split(',') {
            let (name, value) = part.split_once('=').map_or((part, None), |(name, value)| (name, Some(value)));
            let name = name.trim();
            let named = ALL.iter().find(|named| named.name == name && named.carriers.contains(&carrier));
            let named = named
                .ok_or_else(|| FaultsError(format!("{carrier} has no fault {name:?}: it has {}", names(carrier))))?;
            let value = value.map_or(Ok(named.usual), |value| named.read(value.trim()))?;
            (named.put)(&mut faults, value);
        }
        Ok(faults)
    }
}

impl Named {
    fn read(&self, text: &str) -> Result<f64, FaultsError> {
        let (most, what) = match self.unit {
            Unit::Rate => (1.0, "how often, from 0 to 1"),
            Unit::Millis => (60_000.0, "milliseconds, from 0 to 60000"),
            Unit::Seconds => (1e6, "seconds between two of them, from 0 to 1000000"),
        };
        let value = text.parse().ok().filter(|value| (0.0..=most).contains(value));
        value.ok_or_else(|| FaultsError(format!("{}={text:?}: it needs a number: {what}", self.name)))
    }
}

/// Names of the faults of a carrier.
fn names(carrier: Carrier) -> String {
    let names: Vec<_> = ALL.iter().filter(|named| named.carriers.contains(&carrier)).map(|named| named.name).collect();
    names.join(", ")
}

impl fmt::Display for Carrier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Serial => "a serial line",
            Self::Stream => "TCP",
            Self::Datagram => "UDP",
        })
    }
}

/// Fault of a device as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mishap {
    /// The device receives and sends nothing for this time, in milliseconds.
    Silence(u64),
    /// The power fails for a moment.
    Reset,
    /// A motor gets stuck.
    Stall,
}

/// Times of the faults of a device.
#[derive(Debug, Clone)]
pub struct Mishaps {
    rng: ChaCha8Rng,
    faults: Faults,
    next: [Option<Millis>; 3],
}

impl Mishaps {
    /// Faults from a seed, from a moment on.
    #[must_use]
    pub fn new(faults: Faults, seed: u64, now: Millis) -> Self {
        let mut mishaps = Self { rng: ChaCha8Rng::seed_from_u64(seed), faults, next: [None; 3] };
        mishaps.next = [faults.silence, faults.reset, faults.stall].map(|mean| mishaps.draw(mean, now));
        mishaps
    }

    /// Time of the next fault.
    #[must_use]
    pub fn wake(&self) -> Option<Millis> {
        self.next.iter().flatten().min().copied()
    }

    /// Next fault that is due.
    pub fn next(&mut self, now: Millis) -> Option<Mishap> {
        let due = self.next.iter().position(|next| next.is_some_and(|next| next <= now))?;
        let mean = [self.faults.silence, self.faults.reset, self.faults.stall][due];
        self.next[due] = self.draw(mean, now);
        Some(match due {
            0 => Mishap::Silence(self.rng.random_range(100..=1500)),
            1 => Mishap::Reset,
            _ => Mishap::Stall,
        })
    }

    /// A time from half the mean to one and a half times the mean.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 1.5e9, and more than 0")]
    fn draw(&mut self, mean: f64, now: Millis) -> Option<Millis> {
        (mean > 0.0).then(|| now.after(1 + (mean * self.rng.random_range(500.0..1500.0)) as u64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_as_faults() {
        for carrier in [Carrier::Serial, Carrier::Stream, Carrier::Datagram] {
            assert_eq!(Faults::parse(&names(carrier).replace(' ', ""), carrier), Ok(Faults::all(carrier)));
            assert_eq!(Faults::parse("none", carrier), Ok(Faults::NONE));
        }
        let error = |text| Faults::parse(text, Carrier::Stream).unwrap_err().to_string();
        assert_eq!(error("loss"), "TCP has no fault \"loss\": it has cutting, break, delay, silence, reset, stall");
        assert_eq!(error("cutting=2"), "cutting=\"2\": it needs a number: how often, from 0 to 1");
        assert_eq!(error("delay=-1"), "delay=\"-1\": it needs a number: milliseconds, from 0 to 60000");
        assert!(error("").contains("no fault \"\""));
    }

    #[test]
    fn mishaps_come_from_the_seed() {
        let faults = Faults { silence: 1.0, reset: 10.0, ..Faults::NONE };
        let told = |seed| {
            let mut mishaps = Mishaps::new(faults, seed, Millis(0));
            let mut told = Vec::new();
            while let Some(now) = mishaps.wake().filter(|now| now.0 < 100_000) {
                told.extend(mishaps.next(now).map(|mishap| (now, mishap)));
            }
            told
        };
        assert_eq!(told(1), told(1));
        assert_ne!(told(1), told(2));
        let resets = told(1).iter().filter(|(_, mishap)| *mishap == Mishap::Reset).count();
        assert!((7..=14).contains(&resets) && (70..=140).contains(&(told(1).len() - resets)), "{:?}", told(1));
        assert_eq!(Mishaps::new(Faults::NONE, 1, Millis(0)).wake(), None);
    }
}
