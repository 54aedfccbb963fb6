//! Shared code of the targets of the machines: bytes as decisions, a machine under the laws, and a faulty line.
//!
//! An input is a list of steps. Each step says how the clock advances, what happens, and with which values. So fuzzers
//! can cut out and join steps. A read beyond the end of the input gives zeros.

use std::collections::{HashSet, VecDeque};
use std::fmt::Debug;
use std::hash::Hash;

use motion_core::machine::{Machine, Output};
use motion_core::time::Millis;
use motion_core::wire::{DecodeError, Messages};

/// Greatest number of steps of an input; bytes after them are ignored.
pub const STEPS: usize = 1000;
/// Greatest length of a printed state or output, in bytes.
const MAX_TEXT: usize = 1 << 16;
/// Greatest number of frames on a line; more are lost.
const MAX_LINE: usize = 64;

/// Defines the target of a world. The world has the fields `now`, `host` and `device`. Its `new` reads the first bytes
/// of an input, and its `act` makes a step from the bytes that follow.
#[macro_export]
macro_rules! fuzz_world {
    ($world:ident) => {
        libfuzzer_sys::fuzz_target!(|input: &[u8]| {
            let mut bytes = $crate::machines::Bytes::new(input);
            let mut world = $world::new(&mut bytes);
            for _ in 0..$crate::machines::STEPS {
                if bytes.is_empty() {
                    break;
                }
                world.now = bytes.clock(world.now, [world.host.wake, world.device.wake]);
                world.act(&mut bytes);
            }
            $crate::machines::print(&world.host.machine);
            $crate::machines::print(&world.device.machine);
        });
    };
}

/// Input that is read from its front.
pub struct Bytes<'i>(&'i [u8]);

impl<'i> Bytes<'i> {
    /// Starts reading an input.
    pub const fn new(input: &'i [u8]) -> Self {
        Self(input)
    }

    /// Whether everything is read.
    pub const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Reads the next byte.
    pub fn byte(&mut self) -> u8 {
        self.few::<1>()[0]
    }

    /// Reads a byte and returns whether it is odd.
    pub fn flag(&mut self) -> bool {
        self.byte() % 2 == 1
    }

    /// Reads the bytes of a number.
    pub fn few<const N: usize>(&mut self) -> [u8; N] {
        let taken = self.take(N);
        std::array::from_fn(|at| taken.get(at).copied().unwrap_or(0))
    }

    /// Reads a length of two bytes, and then as many bytes, if there are so many.
    pub fn some(&mut self) -> &'i [u8] {
        let len = u16::from_le_bytes(self.few());
        self.take(len.into())
    }

    /// Chooses one of several values.
    pub fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[usize::from(self.byte()) % all.len()]
    }

    /// Reads a number for a motor, a speed or a position. Plausible numbers come up more often than others.
    pub fn float(&mut self) -> f32 {
        match self.byte() {
            small @ 0..200 => f32::from(small.cast_signed()) / 4.0,
            200..210 => 25_000.0,
            _ => f32::from_be_bytes(self.few()),
        }
    }

    /// Reads a message of one side. A body that is too short is an error with the number of the message.
    pub fn message<M: Messages<'i>>(&mut self) -> Result<M, (u32, DecodeError)> {
        let number = match usize::from(self.byte()) {
            known if known < 250 => M::ALL[known % M::ALL.len()].number,
            _ => u32::from_le_bytes(self.few()),
        };
        let len = self.byte();
        M::decode_body(number, self.take(len.into())).map_err(|error| (number, error))
    }

    /// Advances the clock: mostly not at all, by a while, or to the time when a machine asks to be woken.
    pub fn clock(&mut self, now: Millis, wakes: [Option<Millis>; 2]) -> Millis {
        let wake = wakes.into_iter().flatten().min().unwrap_or(now).max(now);
        match self.byte() % 16 {
            0..5 => now,
            5..7 => now.after(self.byte().into()),
            7..9 => now.after(u64::from(self.byte()) * 256),
            9..12 => wake,
            12 => wake.after(u64::from(self.byte()) * 16),
            13 => Millis(wake.0.saturating_sub(1)).max(now),
            14 => now.after(1 << 50),
            _ => Millis(now.0.saturating_sub(u64::from(self.byte()) * 16)),
        }
    }

    fn take(&mut self, len: usize) -> &'i [u8] {
        let (taken, rest) = self.0.split_at(len.min(self.0.len()));
        self.0 = rest;
        taken
    }
}

/// Machine under the laws, with the time when it asks to be woken.
pub struct Watched<M> {
    /// The machine.
    pub machine: M,
    /// Time when it asks to be woken.
    pub wake: Option<Millis>,
}

impl<M> Watched<M> {
    /// Starts with a new machine.
    pub const fn new(machine: M) -> Self {
        Self { machine, wake: None }
    }

    /// Makes a step and checks the laws. Afterwards nothing is left to do at this moment, so waking the machine once
    /// more with `wake` changes nothing.
    pub fn step<Send, Event, const SENDS: usize, const EVENTS: usize>(
        &mut self,
        now: Millis,
        input: M::Input<'_>,
        wake: M::Input<'_>,
    ) -> M::Output
    where
        M: Machine<Output = Output<Send, Event, SENDS, EVENTS>> + Clone + Eq + Hash + Debug,
        for<'a> M::Input<'a>: Copy,
        Send: Eq + Hash + Debug,
        Event: Eq + Hash + Debug,
    {
        let (machine, output) = laws::machine::step(self.machine.clone(), now, input);
        let (woken, quiet) = laws::machine::step(machine.clone(), now, wake);
        assert!(quiet.is_quiet(), "something is left to do: {quiet:?}");
        let (again, quiet) = laws::machine::step(woken.clone(), now, wake);
        assert!(quiet.is_quiet() && again == woken, "waking it twice changes it: {quiet:?}");
        (self.machine, self.wake) = (machine, output.wake);
        if !output.is_quiet() {
            print(&output);
        }
        output
    }
}

/// Prints a state or an output, and checks the length of the text.
pub fn print(value: &impl Debug) {
    let len = format!("{value:?}").len();
    assert!(len <= MAX_TEXT, "{len} bytes of text");
}

/// Frames in flight in one direction. No frame overtakes another.
#[derive(Default)]
pub struct Line(VecDeque<Vec<u8>>);

impl Line {
    /// Sends a frame.
    pub fn put(&mut self, frame: &[u8]) {
        if self.0.len() < MAX_LINE {
            self.0.push_back(frame.to_vec());
        }
    }

    /// Takes the next arrival: the frame as it was sent or with a wrong bit, and perhaps again later; or nothing.
    pub fn take(&mut self, bytes: &mut Bytes<'_>) -> Option<Vec<u8>> {
        let mut frame = self.0.pop_front()?;
        match bytes.byte() % 16 {
            0 => return None,
            1 => self.0.push_front(frame.clone()),
            2 => {
                let (at, bit) = (usize::from(bytes.byte()) % frame.len(), bytes.byte() % 8);
                frame[at] ^= 1 << bit;
            }
            _ => {}
        }
        Some(frame)
    }

    /// Loses everything in flight.
    pub fn cut(&mut self) {
        self.0.clear();
    }
}

/// Requests that have not ended. Each request ends once.
#[derive(Default)]
pub struct Tokens {
    last: u32,
    open: HashSet<u32>,
}

impl Tokens {
    /// Returns a new token for a request that begins.
    pub fn begin(&mut self) -> u32 {
        self.last += 1;
        self.open.insert(self.last);
        self.last
    }

    /// Ends a request.
    ///
    /// # Panics
    ///
    /// If the request never began, or ended before.
    pub fn end(&mut self, token: u32) {
        assert!(self.open.remove(&token), "request {token} ends, but is not open");
    }
}
