//! Host and rig on one line, on a virtual clock.

use motion_core::time::Millis;

use crate::faults::{Carrier, Faults, Mishap, Mishaps};
use crate::line::Line;
use crate::{Host, LineId, Outgoing, Rig};

/// Time from the request to the open line, in milliseconds.
const CONNECT: u64 = 5;

/// Line that both use.
const LINE: LineId = LineId(0);

/// Host, rig, the line between them, and a clock.
///
/// A serial line is open from the start, and opens again after a reset. Over TCP the host asks for the connection.
#[derive(Debug, Clone)]
pub struct Scene<H, R> {
    /// Host of the scene.
    pub host: H,
    /// Rig of the scene.
    pub rig: R,
    /// Faults of the bytes in flight.
    faults: Faults,
    carrier: Carrier,
    mishaps: Mishaps,
    seed: u64,
    now: Millis,
    up: Line,
    down: Line,
    state: State,
}

/// End of the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The host.
    Host,
    /// The rig.
    Rig,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Closed,
    Opening(Millis),
    Open,
}

impl<H: Host, R: Rig> Scene<H, R> {
    /// Scene at time 0. The same seed gives the same scene.
    #[must_use]
    pub fn new(host: H, rig: R, carrier: Carrier, faults: Faults, seed: u64) -> Self {
        let state = if carrier == Carrier::Serial { State::Opening(Millis(0)) } else { State::Closed };
        let lines = (Line::new(faults, seed), Line::new(faults, seed));
        let mishaps = Mishaps::new(faults, seed, Millis(0));
        let now = Millis(0);
        Self { host, rig, faults, carrier, mishaps, seed, now, up: lines.0, down: lines.1, state }
    }

    /// Present time.
    #[must_use]
    pub const fn now(&self) -> Millis {
        self.now
    }

    /// Number of bytes in flight in both directions.
    #[must_use]
    pub fn held(&self) -> usize {
        self.up.held() + self.down.held()
    }

    /// Gives a command to the host.
    pub fn command(&mut self, command: H::Command) {
        self.host.command(self.now, command);
        self.settle();
    }

    /// Puts bytes on the line as if one side had sent them.
    pub fn inject(&mut self, from: Side, bytes: &[u8]) {
        match from {
            Side::Host => self.up.push(self.now, bytes),
            Side::Rig => self.down.push(self.now, bytes),
        }
        self.settle();
    }

    /// Cuts the line, like a pulled plug. A serial line is plugged in again at once.
    pub fn unplug(&mut self) {
        match self.state {
            State::Open => {
                self.rig.close(self.now, LINE);
                self.host.close(self.now, LINE);
            }
            // The host that asked for the line learns that it cannot be opened.
            State::Opening(_) if self.carrier != Carrier::Serial => self.host.close(self.now, LINE),
            State::Opening(_) | State::Closed => {}
        }
        self.state = match self.carrier {
            Carrier::Serial => State::Opening(self.now.after(CONNECT)),
            _ => State::Closed,
        };
        self.settle();
    }

    /// Interrupts the power of the rig for a moment.
    pub fn reset(&mut self) {
        self.rig.reset(self.now);
        self.unplug();
    }

    /// Runs up to a moment and gives each event of the host to `look`. Stops when `look` returns a value.
    pub fn run<T>(&mut self, until: Millis, mut look: impl FnMut(&mut Self, H::Event) -> Option<T>) -> Option<T> {
        loop {
            while let Some(event) = self.host.next_event() {
                if let Some(found) = look(self, event) {
                    return Some(found);
                }
            }
            let next = self.wake().filter(|next| *next <= until);
            self.now = self.now.max(next.unwrap_or(until));
            self.work();
            next?;
        }
    }

    /// Time of the next thing that happens.
    fn wake(&self) -> Option<Millis> {
        let opening = if let State::Opening(at) = self.state { Some(at) } else { None };
        let wakes = [self.host.wake(), self.rig.wake(), self.mishaps.wake(), self.up.wake(), self.down.wake(), opening];
        wakes.into_iter().flatten().min()
    }

    /// Does everything that is due now.
    fn work(&mut self) {
        if let State::Opening(at) = self.state
            && at <= self.now
        {
            self.state = State::Open;
            self.seed = self.seed.wrapping_add(2);
            self.up = Line::new(self.faults, self.seed);
            self.down = Line::new(self.faults, self.seed.wrapping_add(1));
            self.rig.open(self.now, LINE);
            self.host.open(self.now, LINE);
        }
        self.rig.advance(self.now);
        self.host.advance(self.now);
        while let Some(mishap) = self.mishaps.next(self.now) {
            match mishap {
                Mishap::Silence(millis) => {
                    self.up.hold(self.now.after(millis));
                    self.down.hold(self.now.after(millis));
                }
                Mishap::Reset => self.reset(),
                Mishap::Stall => self.rig.stall(self.now),
            }
        }
        self.settle();
        while let Some(bytes) = self.up.pop(self.now) {
            self.rig.receive(self.now, LINE, &bytes);
            self.settle();
        }
        while let Some(bytes) = self.down.pop(self.now) {
            self.host.receive(self.now, LINE, &bytes);
            self.settle();
        }
        if self.state == State::Open && (self.up.is_broken() || self.down.is_broken()) {
            self.unplug();
        }
    }

    /// Carries out the requests of both sides.
    fn settle(&mut self) {
        while let Some(outgoing) = self.host.poll() {
            match outgoing {
                Outgoing::Bytes(LINE, bytes) if self.state == State::Open => self.up.push(self.now, &bytes),
                Outgoing::Open(LINE) => self.state = State::Opening(self.now.after(CONNECT)),
                Outgoing::HangUp(LINE) => self.unplug(),
                _ => {}
            }
        }
        while let Some(outgoing) = self.rig.poll() {
            match outgoing {
                Outgoing::Bytes(LINE, bytes) if self.state == State::Open => self.down.push(self.now, &bytes),
                Outgoing::HangUp(LINE) => self.unplug(),
                _ => {}
            }
        }
    }
}
