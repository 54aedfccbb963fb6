//! Simulated rig with its host, on the clock of the page.

mod dmc;
mod hoot;
mod kos;

use std::mem;

use examples::tap::{Tap, tap};
use examples::text::{Piece, Side};
use motion_core::time::Millis;
use motion_rigs::device::{Choice, Named};
use motion_rigs::motor::Motor;
use motion_rigs::{Host, LineId, Outgoing, Party as _, Rig, dmc_device, hoot_node, kos_device};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::inspect::{Rows, protocol};

const LINE: LineId = LineId(0);
/// Longest time that passes in one call, in milliseconds. A page that was hidden does not catch up.
const LONGEST: u32 = 1000;
/// Greatest number of events of the clock in one call, more than any rig has in that time.
const TURNS: u32 = 100_000;
/// Time between two signs that a jog is still held, in milliseconds.
const ALIVE: u64 = 200;

/// Jog button that is held down.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Held {
    /// Number of the motor, from 1.
    pub motor: u8,
    /// Direction of the jog.
    pub forward: bool,
}

/// Use of a host: the commands behind the buttons of the page.
trait Control {
    type Host: Host;

    /// Whether the host requests its line itself.
    const ASKS: bool;
    /// Unit of positions.
    const UNIT: &'static str;
    /// Half of the width of a bar at first, in that unit.
    const SPAN: f64;

    /// Connects the host, if it requests its line itself.
    fn connect(&mut self, _: &mut Self::Host, _: Millis) {}
    /// Begins a jog.
    fn jog(&mut self, host: &mut Self::Host, now: Millis, held: Held);
    /// Says that the jog is still held.
    fn alive(&mut self, host: &mut Self::Host, now: Millis, held: Held);
    /// Ends a jog.
    fn release(&mut self, host: &mut Self::Host, now: Millis, motor: u8);
    /// Moves a motor by a short way.
    fn go(&mut self, host: &mut Self::Host, now: Millis, motor: u8);
    /// Stops everything, and forgets commands that wait.
    fn stop(&mut self, host: &mut Self::Host, now: Millis);
    /// Takes an event of the host. Returns what it says to the user.
    fn event(&mut self, host: &mut Self::Host, now: Millis, event: <Self::Host as Host>::Event) -> Note;
    /// Whether commands can be given.
    fn is_ready(&self, host: &Self::Host) -> bool;
}

/// What an event says to the user.
#[derive(Default)]
struct Note {
    line: Option<String>,
    /// Whether a stop of everything is confirmed, if the event says that.
    stopped: Option<bool>,
}

impl Note {
    #[expect(clippy::needless_pass_by_value, reason = "events are made where they are told")]
    fn line(line: impl ToString) -> Self {
        Self { line: Some(line.to_string()), stopped: None }
    }
}

/// Rig that is switched on, with its host.
pub(crate) trait Stage {
    fn connect(&mut self);
    fn go(&mut self, motor: u8);
    fn stop(&mut self);
    fn advance(&mut self, millis: u32, held: Option<Held>);
    /// State of the rig, and the messages and notes since the last report.
    fn report(&mut self) -> Value;
}

/// Report without a rig.
pub(crate) fn none() -> Value {
    json!({ "on": false, "stop": "no rig is switched on: nothing moves", "rows": [], "notes": [], "motors": [] })
}

/// Protocols with their devices.
pub(crate) fn devices() -> Value {
    fn all<S: Named>(key: &str, name: &str) -> Value {
        let device = |device: &Choice<S>| json!({ "name": device.name, "about": device.about });
        json!({ "protocol": key, "name": name, "devices": S::DEVICES.iter().map(device).collect::<Vec<_>>() })
    }
    json!([
        all::<kos_device::Setup>("kos", "Kessler kOS"),
        all::<dmc_device::Setup>("dmc", "Dragonframe DMC"),
        all::<hoot_node::Setup>("hoot", "NMX / MoCoBus (hoot)"),
    ])
}

/// Switches a device on.
pub(crate) fn start(name: &str, device: &str) -> Result<Box<dyn Stage>, String> {
    protocol(name)?;
    match name {
        "kos" => kos::start(device),
        "dmc" => dmc::start(device),
        _ => hoot::start(device),
    }
}

/// Host and rig with the line between them. What passes the line is shown.
struct Scene<C: Control, R: Rig> {
    control: C,
    host: C::Host,
    rig: R,
    line: Box<dyn Tap>,
    now: Millis,
    is_open: bool,
    held: Option<Held>,
    /// Whether a jog that is held counts no more, because of a stop, until it is let go.
    is_barred: bool,
    /// Time at which the jog is told to be held the next time.
    alive: Millis,
    stop: &'static str,
    rows: Rows,
    notes: Vec<Value>,
    /// Least and greatest position that the bar of each motor shows.
    bars: Vec<(f64, f64)>,
}

impl<C: Control, R: Rig> Scene<C, R> {
    fn new(control: C, host: C::Host, rig: R, name: &str) -> Result<Self, String> {
        let line = tap(protocol(name)?, examples::cli::Transport::Stream).map_err(|stop| stop.to_string())?;
        let bars = rig.motors().iter().map(|motor| bar(motor, C::SPAN)).collect();
        Ok(Self {
            control,
            host,
            rig,
            line,
            now: Millis(0),
            is_open: false,
            held: None,
            is_barred: false,
            alive: Millis(0),
            stop: "",
            rows: Rows::default(),
            notes: Vec::new(),
            bars,
        })
    }

    fn note(&mut self, line: &str) {
        self.notes.push(json!({ "time": self.now.0, "line": line }));
    }

    fn open(&mut self) {
        if !mem::replace(&mut self.is_open, true) {
            self.rig.open(self.now, LINE);
            self.host.open(self.now, LINE);
        }
    }

    fn close(&mut self) {
        if mem::take(&mut self.is_open) {
            self.rig.close(self.now, LINE);
            self.host.close(self.now, LINE);
        }
    }

    /// Carries bytes between host and rig, and takes the events of the host, until both wait.
    fn settle(&mut self) {
        for _ in 0..TURNS {
            if let Some(outgoing) = self.host.poll() {
                match outgoing {
                    Outgoing::Bytes(LINE, bytes) if self.is_open => {
                        self.show(Side::Host, &bytes);
                        self.rig.receive(self.now, LINE, &bytes);
                    }
                    Outgoing::Open(LINE) => self.open(),
                    Outgoing::HangUp(LINE) => self.close(),
                    _ => {}
                }
            } else if let Some(outgoing) = self.rig.poll() {
                match outgoing {
                    Outgoing::Bytes(LINE, bytes) if self.is_open => {
                        self.show(Side::Device, &bytes);
                        self.host.receive(self.now, LINE, &bytes);
                    }
                    Outgoing::HangUp(LINE) => self.close(),
                    _ => {}
                }
            } else if let Some(event) = self.host.next_event() {
                let Note { line, stopped } = self.control.event(&mut self.host, self.now, event);
                if let Some(line) = line {
                    self.note(&line);
                }
                match stopped {
                    Some(true) => self.stop = "the rig confirmed the stop",
                    Some(false) => self.stop = "the stop is NOT confirmed: press the emergency stop",
                    None => {}
                }
            } else {
                return;
            }
        }
    }

    fn show(&mut self, side: Side, bytes: &[u8]) {
        let rows = &mut self.rows;
        let piece = Piece { side, first: true, bytes };
        // The callback does not fail.
        let _ = self.line.push(piece, &mut |record| {
            rows.add(record);
            Ok(())
        });
    }

    /// Begins, keeps or ends a jog, as the button says.
    fn hold(&mut self, held: Option<Held>) {
        self.is_barred &= held.is_some();
        let held = held.filter(|_| !self.is_barred && self.control.is_ready(&self.host));
        if held != self.held {
            if let Some(before) = self.held {
                self.control.release(&mut self.host, self.now, before.motor);
            }
            self.held = held;
            if let Some(held) = held {
                self.stop = "";
                self.control.jog(&mut self.host, self.now, held);
                self.alive = self.now.after(ALIVE);
            }
            self.settle();
        }
    }
}

fn bar(motor: &Motor, span: f64) -> (f64, f64) {
    let at = motor.at(Millis(0)).position;
    (at - span, at + span)
}

impl<C: Control, R: Rig> Stage for Scene<C, R> {
    fn connect(&mut self) {
        if C::ASKS {
            self.control.connect(&mut self.host, self.now);
        } else {
            self.open();
        }
        self.settle();
    }

    fn go(&mut self, motor: u8) {
        if self.control.is_ready(&self.host) {
            self.stop = "";
            self.control.go(&mut self.host, self.now, motor);
            self.settle();
        } else {
            self.note("the rig is not connected: connect first");
        }
    }

    fn stop(&mut self) {
        self.stop = "STOP is sent, and not confirmed yet";
        (self.held, self.is_barred) = (None, true);
        // Without a line nothing can be stopped.
        if !self.is_open && !C::ASKS {
            self.open();
        }
        self.control.stop(&mut self.host, self.now);
        self.settle();
    }

    fn advance(&mut self, millis: u32, held: Option<Held>) {
        self.hold(held);
        let until = self.now.after(millis.min(LONGEST).into());
        for _ in 0..TURNS {
            let alive = self.held.map(|_| self.alive);
            let next = [self.host.wake(), self.rig.wake(), alive].into_iter().flatten().min();
            let next = next.filter(|next| *next <= until);
            self.now = self.now.max(next.unwrap_or(until));
            self.rig.advance(self.now);
            self.host.advance(self.now);
            if let Some(held) = self.held.filter(|_| self.alive <= self.now) {
                self.alive = self.now.after(ALIVE);
                self.control.alive(&mut self.host, self.now, held);
            }
            self.settle();
            if next.is_none() {
                break;
            }
        }
    }

    fn report(&mut self) -> Value {
        let now = self.now;
        let motors = (1..).zip(self.rig.motors()).zip(&mut self.bars);
        let motors: Vec<Value> = motors.map(|((number, motor), bar): ((u8, &Motor), _)| {
            let place = motor.at(now);
            *bar = (bar.0.min(place.position), bar.1.max(place.position));
            json!({ "number": number, "position": place.position, "velocity": place.velocity, "low": bar.0, "high": bar.1 })
        }).collect();
        let rows = mem::take(&mut self.rows.shown);
        json!({
            "on": true,
            "time": now.0,
            "ready": self.control.is_ready(&self.host),
            "stop": self.stop,
            "unit": C::UNIT,
            "motors": motors,
            "rows": rows,
            "count": self.rows.count,
            "notes": mem::take(&mut self.notes),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every device of every protocol.
    fn all() -> impl Iterator<Item = (String, String)> {
        devices().as_array().unwrap().clone().into_iter().flat_map(|protocol| {
            let key = protocol["protocol"].as_str().unwrap().to_owned();
            let devices = protocol["devices"].as_array().unwrap().clone();
            devices.into_iter().map(move |device| (key.clone(), device["name"].as_str().unwrap().to_owned()))
        })
    }

    fn pass(stage: &mut dyn Stage, times: usize, held: Option<Held>) {
        for _ in 0..times {
            stage.advance(50, held);
        }
    }

    /// Position and velocity of motor 1, after the report.
    fn first(report: &Value) -> (f64, f64) {
        let motor = &report["motors"][0];
        (motor["position"].as_f64().unwrap(), motor["velocity"].as_f64().unwrap())
    }

    #[test]
    fn a_mild_rig_connects_jogs_goes_and_stops() {
        for (protocol, unit) in [("kos", "rev"), ("dmc", "steps"), ("hoot", "microsteps")] {
            let mut stage = start(protocol, "mild").unwrap();
            stage.connect();
            pass(&mut *stage, 40, None);
            let report = stage.report();
            assert!(report["ready"] == true && report["unit"] == unit, "{protocol}: {report}");
            assert!(!report["rows"].as_array().unwrap().is_empty(), "{protocol}");
            let (before, _) = first(&report);

            let held = Some(Held { motor: 1, forward: true });
            pass(&mut *stage, 60, held);
            let (there, fast) = first(&stage.report());
            assert!(there > before && fast > 0.0, "{protocol}: from {before} to {there}, {fast}");
            pass(&mut *stage, 60, None);
            let (rests, speed) = first(&stage.report());
            assert!(speed == 0.0 && rests >= there, "{protocol}: {speed}");

            stage.go(1);
            pass(&mut *stage, 100, None);
            let report = stage.report();
            assert!(first(&report).0 > rests && first(&report).1 == 0.0, "{protocol}: {report}");

            pass(&mut *stage, 20, held);
            stage.stop();
            assert_ne!(stage.report()["stop"], "", "{protocol}");
            // The button is still held.
            pass(&mut *stage, 100, held);
            let report = stage.report();
            assert_eq!(report["stop"], "the rig confirmed the stop", "{protocol}: {report}");
            assert!(first(&report).1 == 0.0, "{protocol}: {report}");
        }
    }

    #[test]
    fn a_stop_works_in_every_state_of_every_device() {
        for (protocol, device) in all() {
            for before in 0..4 {
                let mut stage = start(&protocol, &device).unwrap();
                if before > 0 {
                    stage.connect();
                    pass(&mut *stage, if before == 1 { 0 } else { 40 }, None);
                }
                match before {
                    2 => stage.go(1),
                    3 => pass(&mut *stage, 10, Some(Held { motor: 1, forward: false })),
                    _ => {}
                }
                stage.stop();
                assert!(!stage.report()["stop"].as_str().unwrap().is_empty());
                pass(&mut *stage, 300, None);
                let report = stage.report();
                let rests = report["motors"].as_array().unwrap().iter().all(|motor| motor["velocity"] == 0.0);
                let told = report["stop"].as_str().unwrap();
                assert!(
                    rests && told != "STOP is sent, and not confirmed yet",
                    "{protocol} {device} {before}: {report}"
                );
            }
        }
    }

    #[test]
    fn an_unknown_device_is_an_error_that_lists_the_others() {
        let error = start("kos", "loud").err().unwrap();
        assert!(error.contains("it has mild"), "{error}");
        assert!(start("x", "mild").is_err());
    }
}
