//! One direction of a line, and the faults of its bytes.

use std::collections::VecDeque;

use motion_core::time::Millis;
use rand::{Rng as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::faults::Faults;

/// Bytes in flight.
#[derive(Debug, Clone)]
pub struct Line {
    faults: Faults,
    rng: ChaCha8Rng,
    /// Pieces with their times of arrival, in order.
    pieces: VecDeque<(Millis, Vec<u8>)>,
    /// Arrival of the last piece.
    last: Millis,
    /// Time before which nothing arrives.
    silent: Millis,
    /// Number of bytes in the pieces.
    held: usize,
    is_broken: bool,
}

impl Line {
    /// Line without any bytes.
    #[must_use]
    pub fn new(faults: Faults, seed: u64) -> Self {
        let rng = ChaCha8Rng::seed_from_u64(seed);
        Self { faults, rng, pieces: VecDeque::new(), last: Millis(0), silent: Millis(0), held: 0, is_broken: false }
    }

    /// Sends a piece.
    pub fn push(&mut self, now: Millis, bytes: &[u8]) {
        let Faults { loss, duplication, corruption, garbage, cutting, break_off, .. } = self.faults;
        if self.is_broken || bytes.is_empty() || self.chance(loss) {
            return;
        }
        if self.chance(garbage) {
            let noise: Vec<u8> = (0..self.rng.random_range(1..=40)).map(|_| self.rng.random()).collect();
            self.put(now, noise);
        }
        let mut piece = bytes.to_vec();
        if self.chance(corruption) {
            let at = self.rng.random_range(0..piece.len());
            piece[at] ^= 1 << self.rng.random_range(0..8);
        }
        if self.chance(break_off) {
            piece.truncate(self.rng.random_range(0..piece.len()));
            self.is_broken = true;
        }
        if self.chance(duplication) {
            self.put(now, piece.clone());
        }
        if piece.len() > 1 && self.chance(cutting) {
            let rest = piece.split_off(self.rng.random_range(1..piece.len()));
            self.put(now, piece);
            self.put(now, rest);
        } else if self.chance(cutting)
            && let Some((due, before)) = self.pieces.back_mut()
            && *due >= now
        {
            self.held += piece.len();
            before.extend(piece);
        } else {
            self.put(now, piece);
        }
    }

    /// Delays every arrival to this moment at least.
    pub fn hold(&mut self, until: Millis) {
        self.silent = self.silent.max(until);
    }

    /// Time when the next piece arrives.
    #[must_use]
    pub fn wake(&self) -> Option<Millis> {
        self.pieces.front().map(|(due, _)| (*due).max(self.silent))
    }

    /// Next piece that has arrived.
    pub fn pop(&mut self, now: Millis) -> Option<Vec<u8>> {
        self.wake().filter(|due| *due <= now)?;
        let (_, piece) = self.pieces.pop_front()?;
        self.held -= piece.len();
        Some(piece)
    }

    /// Whether the line broke, and everything in flight has arrived.
    #[must_use]
    pub fn is_broken(&self) -> bool {
        self.is_broken && self.pieces.is_empty()
    }

    /// Number of bytes in flight.
    #[must_use]
    pub const fn held(&self) -> usize {
        self.held
    }

    fn put(&mut self, now: Millis, piece: Vec<u8>) {
        if !piece.is_empty() {
            let late = self.rng.random_range(0..=self.faults.delay);
            self.last = self.last.max(now.after(late));
            self.held += piece.len();
            self.pieces.push_back((self.last, piece));
        }
    }

    fn chance(&mut self, rate: f64) -> bool {
        rate > 0.0 && self.rng.random_bool(rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faults::Carrier;

    /// Bytes that arrive of ten thousand pieces of ten bytes, sent one millisecond apart.
    fn sent(faults: Faults, seed: u64) -> (Vec<u8>, Line) {
        let mut line = Line::new(faults, seed);
        let mut arrived = Vec::new();
        for now in 0..20_000 {
            if now < 10_000 {
                line.push(Millis(now), &[u8::try_from(now % 250).unwrap(); 10]);
            }
            while let Some(piece) = line.pop(Millis(now)) {
                arrived.extend(piece);
            }
            assert_eq!(line.held(), line.pieces.iter().map(|(_, piece)| piece.len()).sum::<usize>());
        }
        (arrived, line)
    }

    #[test]
    fn without_faults_everything_arrives_at_once() {
        let mut line = Line::new(Faults::NONE, 1);
        line.push(Millis(5), b"one");
        assert_eq!((line.wake(), line.held()), (Some(Millis(5)), 3));
        assert_eq!(line.pop(Millis(4)), None);
        assert_eq!(line.pop(Millis(5)), Some(b"one".to_vec()));
        line.hold(Millis(9));
        line.push(Millis(6), b"two");
        assert_eq!((line.pop(Millis(8)), line.pop(Millis(9))), (None, Some(b"two".to_vec())));
    }

    #[test]
    fn tcp_is_only_late_and_cut_until_it_breaks() {
        let faults = Faults { break_off: 0.0, ..Faults::all(Carrier::Stream) };
        let whole: Vec<u8> = (0..10_000_u32).flat_map(|now| [u8::try_from(now % 250).unwrap(); 10]).collect();
        assert_eq!(sent(faults, 1).0, whole);
        let (part, line) = sent(Faults::all(Carrier::Stream), 1);
        assert!(line.is_broken() && part.len() < whole.len());
        assert_eq!(part, whole[..part.len()]);
    }

    #[test]
    fn each_fault_changes_what_arrives() {
        let faults = Faults::all(Carrier::Serial);
        let usual = |got: usize, rate: f64| (f64::from(u32::try_from(got).unwrap()) / 100_000.0 - rate).abs() < 0.01;
        let bytes = |faults| sent(faults, 7).0.len();
        assert!(usual(bytes(Faults { loss: faults.loss, ..Faults::NONE }), 0.98));
        assert!(usual(bytes(Faults { duplication: faults.duplication, ..Faults::NONE }), 1.02));
        assert!(usual(bytes(Faults { garbage: faults.garbage, ..Faults::NONE }), 1.04));
        let clean = sent(Faults::NONE, 7).0;
        let damaged = sent(Faults { corruption: faults.corruption, ..Faults::NONE }, 7).0;
        let wrong = clean.iter().zip(&damaged).filter(|(one, other)| one != other).count();
        assert!(clean.len() == damaged.len() && (100..300).contains(&wrong), "{wrong}");
        assert_eq!(sent(faults, 7).0, sent(faults, 7).0, "the same seed");
        assert_ne!(sent(faults, 7).0, sent(faults, 8).0, "another seed");
    }
}
