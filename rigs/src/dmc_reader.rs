//! Loops over the reader of a DMC line, the same for rigs and hosts.

use motion_core::stream::{Framing, Item, TimedFrames};
use motion_core::time::Millis;

/// Reads bytes that arrived at a moment, and gives each item in them to `take`.
pub(crate) fn receive<F: Framing, const N: usize>(
    reader: &mut TimedFrames<F, N>,
    now: Millis,
    mut bytes: &[u8],
    mut take: impl FnMut(Item<'_, F::Frame<'_>, F::Header>),
) {
    while !bytes.is_empty() {
        let taken = reader.push(now, bytes);
        bytes = &bytes[taken..];
        while let Some(item) = reader.next() {
            take(item);
        }
    }
}

/// Gives up the frames that are overdue, and gives each item in their bytes to `take`.
pub(crate) fn give_up<F: Framing, const N: usize>(
    reader: &mut TimedFrames<F, N>,
    now: Millis,
    mut take: impl FnMut(Item<'_, F::Frame<'_>, F::Header>),
) {
    while reader.deadline().is_some_and(|deadline| deadline <= now) {
        reader.give_up(now);
        while let Some(item) = reader.next() {
            take(item);
        }
    }
}
