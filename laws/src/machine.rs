//! What holds of every step of every machine.

use std::fmt::Debug;
use std::hash::{DefaultHasher, Hash, Hasher};

use motion_core::machine::{Machine, Output};
use motion_core::time::Millis;

/// Takes a step, after it has been checked: it is a function, loses nothing, and wakes later than now.
///
/// # Panics
///
/// If one of these does not hold.
pub fn step<M, Send, Event, const SENDS: usize, const EVENTS: usize>(
    machine: M,
    now: Millis,
    input: M::Input<'_>,
) -> (M, M::Output)
where
    M: Machine<Output = Output<Send, Event, SENDS, EVENTS>> + Clone + Eq + Hash + Debug,
    for<'a> M::Input<'a>: Copy,
    Send: Eq + Hash + Debug,
    Event: Eq + Hash + Debug,
{
    let (again, same) = machine.clone().step(now, input);
    let (next, output) = machine.step(now, input);
    assert_eq!((&next, &output), (&again, &same), "a step is a function of state, moment and input");
    assert_eq!(hash(&(&next, &output)), hash(&(&again, &same)), "what is equal has the same hash");
    assert_eq!(output.lost(), 0, "the capacities of an output hold all that follows: {output:?}");
    assert!(output.wake.is_none_or(|wake| wake > now), "a wake is later than {now:?}: {output:?}");
    (next, output)
}

fn hash(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}
