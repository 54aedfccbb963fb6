//! Laws of every step of every machine.

use std::fmt::Debug;
use std::hash::{DefaultHasher, Hash, Hasher};

use motion_core::machine::{Machine, Output};
use motion_core::time::Millis;

/// Output of a machine, as the laws look at it.
pub trait Follows: Eq + Hash + Debug {
    /// Number of effects that had no room.
    fn lost(&self) -> u16;
    /// Time at which the machine wants to be woken.
    fn wake(&self) -> Option<Millis>;
    /// Whether nothing is to be sent or told.
    fn is_quiet(&self) -> bool;
}

impl<Transmit, Event, const N: usize> Follows for Output<Transmit, Event, N>
where
    Transmit: Eq + Hash + Debug,
    Event: Eq + Hash + Debug,
{
    fn lost(&self) -> u16 {
        self.lost()
    }

    fn wake(&self) -> Option<Millis> {
        self.wake
    }

    fn is_quiet(&self) -> bool {
        self.effects.is_empty()
    }
}

/// Takes a step and checks it: a step is a function, loses no effect, and wakes later than now.
///
/// # Panics
///
/// If one of these laws is broken.
pub fn step<'a, M>(machine: M, now: Millis, input: M::Input<'a>) -> (M, M::Output<'a>)
where
    M: Machine + Clone + Eq + Hash + Debug,
    M::Input<'a>: Copy,
    M::Output<'a>: Follows,
{
    let (again, same) = machine.clone().step(now, input);
    let (next, output) = machine.step(now, input);
    assert_eq!((&next, &output), (&again, &same), "a step is a function of state, moment and input");
    assert_eq!(hash(&(&next, &output)), hash(&(&again, &same)), "equal values have the same hash");
    assert_eq!(output.lost(), 0, "an output has room for all that follows: {output:?}");
    assert!(output.wake().is_none_or(|wake| wake > now), "a wake is later than {now:?}: {output:?}");
    (next, output)
}

fn hash(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}
