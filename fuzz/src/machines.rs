//! Shared code of the targets of the machines: bytes as decisions, and worlds of `laws` on lines that may have any fault.
//!
//! An input is a list of steps. Each step says how the clock advances, what happens, and with which values. So fuzzers
//! can cut out and join steps. A read beyond the end of the input gives zeros.

use std::fmt::Debug;
use std::hash::Hash;

use laws::machine::Follows;
use laws::world::{Fate, Faults, Line, Watched};
use libfuzzer_sys::arbitrary::{Arbitrary, Unstructured};
use motion_core::machine::Machine;
use motion_core::owned::Owned;
use motion_core::time::Millis;
use motion_core::wire::{DecodeError, Messages, Side, draw_borrowed};

/// Greatest number of steps of an input; bytes after them are ignored.
pub const STEPS: usize = 1000;
/// Greatest length of a printed state or output, in bytes.
const MAX_TEXT: usize = 1 << 16;
/// Greatest number of frames on a line; more are lost.
const MAX_LINE: usize = 64;

/// Defines a target. The type has a field `world`. Its `new` reads the first bytes of an input, and its `act` makes a step
/// from the bytes that follow.
#[macro_export]
macro_rules! fuzz_world {
    ($target:ident) => {
        libfuzzer_sys::fuzz_target!(|input: &[u8]| {
            let mut bytes = $crate::machines::Bytes::new(input);
            let mut target = $target::new(&mut bytes);
            for _ in 0..$crate::machines::STEPS {
                if bytes.is_empty() {
                    break;
                }
                let world = &mut target.world;
                world.now = bytes.clock(world.now, [world.host.wake, world.device.wake]);
                target.act(&mut bytes);
            }
            $crate::machines::print(&target.world.host.machine);
            $crate::machines::print(&target.world.device.machine);
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

    /// Draws a message of one side. Some messages are a number and a body as they stand in the input.
    pub fn message<S: Side>(&mut self) -> Drawn<S> {
        if self.byte() >= 250 {
            let number = u32::from_le_bytes(self.few());
            let len = self.byte();
            return Drawn(Owned::from_parts(number, self.take(len.into()).to_vec()));
        }
        let mut u = Unstructured::new(self.0);
        let drawn = Owned::arbitrary(&mut u).unwrap_or_else(|_| Owned::from_parts(0, Vec::new()));
        self.0 = u.take_rest();
        Drawn(drawn)
    }

    /// Draws a message that borrows from the input.
    pub fn borrowed<M: Messages<'i>>(&mut self) -> Option<M> {
        if self.byte() >= 250 {
            let number = u32::from_le_bytes(self.few());
            let len = self.byte();
            return M::decode_body(number, self.take(len.into())).ok();
        }
        let mut u = Unstructured::new(self.0);
        let drawn = draw_borrowed(&mut u).ok();
        self.0 = u.take_rest();
        drawn
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

/// Number and body of a message.
pub struct Drawn<S: Side>(Owned<S>);

impl<S: Side> Drawn<S> {
    /// The message.
    ///
    /// # Errors
    ///
    /// The number of the message, and why its body is none.
    pub fn read(&self) -> Result<S::Message<'_>, (u32, DecodeError)> {
        let number = self.0.number();
        S::Message::decode_body(number, self.0.body()).map_err(|error| (number, error))
    }
}

/// Two machines, and frames as bytes on the line between them. Any fault may happen.
pub type World<H, D> = laws::world::World<H, D, Vec<u8>, Vec<u8>>;

/// Makes the world of two machines at their beginning.
pub fn world<H, D>(host: H, device: D) -> World<H, D>
where
    H: Machine + Clone + Eq + Hash + Debug,
    D: Machine + Clone + Eq + Hash + Debug,
{
    World::new(Millis(1000), host, device, Faults::ANY)
}

/// Takes a step of a machine, if the laws hold, and prints its output. Waking the machine with `wake` at the same time
/// changes nothing.
pub fn step<'a, M>(watched: &mut Watched<M>, now: Millis, input: M::Input<'a>, wake: M::Input<'a>) -> M::Output<'a>
where
    M: Machine + Clone + Eq + Hash + Debug,
    M::Input<'a>: Copy,
    M::Output<'a>: Follows,
{
    let output = watched.step_whole(now, input, wake);
    if !output.is_quiet() {
        print(&output);
    }
    output
}

/// Prints a state or an output, and checks the length of the text.
pub fn print(value: &impl Debug) {
    let len = format!("{value:?}").len();
    assert!(len <= MAX_TEXT, "{len} bytes of text");
}

/// Sends a frame, which is lost if too many are in flight.
pub fn send(line: &mut Line<Vec<u8>>, now: Millis, frame: &[u8]) {
    if line.len() < MAX_LINE {
        line.send(now, frame.to_vec());
    }
}

/// Takes the next arrival: the frame as it was sent or with a wrong bit, and perhaps again later; or nothing.
pub fn arrival(line: &mut Line<Vec<u8>>, bytes: &mut Bytes<'_>) -> Option<Vec<u8>> {
    if line.is_empty() {
        return None;
    }
    let (mut frame, is_undamaged) = line.meet(match bytes.byte() % 16 {
        0 => Fate::Lost,
        1 => Fate::Doubled,
        2 => Fate::Corrupt,
        _ => Fate::Arrives,
    })?;
    if !is_undamaged {
        let (at, bit) = (usize::from(bytes.byte()) % frame.len(), bytes.byte() % 8);
        frame[at] ^= 1 << bit;
    }
    Some(frame)
}
