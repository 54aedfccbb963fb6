//! A host and a device, each watched for the laws of machines, and the line between them that loses, doubles and damages
//! messages.
//!
//! Tests, fuzz targets and model checks build their worlds on it. They add what is theirs: the rig behind the device, what
//! the application asks for, and what must hold.

use std::collections::{BTreeSet, VecDeque};
use std::fmt::Debug;
use std::hash::Hash;

use motion_core::machine::{Machine, Token};
use motion_core::time::Millis;

use crate::machine::{Follows, step};

/// A machine, and when it wants to be woken.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Watched<M> {
    /// The machine.
    pub machine: M,
    /// Time at which the machine wants to be woken.
    pub wake: Option<Millis>,
}

impl<M: Machine + Clone + Eq + Hash + Debug> Watched<M> {
    /// Watches a machine from its beginning.
    pub const fn new(machine: M) -> Self {
        Self { machine, wake: None }
    }

    /// Takes a step, if the [laws of every step](crate::machine::step) hold.
    ///
    /// # Panics
    ///
    /// If a law is broken.
    pub fn step<'a>(&mut self, now: Millis, input: M::Input<'a>) -> M::Output<'a>
    where
        M::Input<'a>: Copy,
        M::Output<'a>: Follows,
    {
        let (machine, output) = step(self.machine.clone(), now, input);
        (self.machine, self.wake) = (machine, output.wake());
        output
    }

    /// Takes a step that leaves nothing to do: waking the machine at once, with `wake`, has no effect, and waking it again
    /// changes nothing.
    ///
    /// # Panics
    ///
    /// If a law is broken.
    pub fn step_whole<'a>(&mut self, now: Millis, input: M::Input<'a>, wake: M::Input<'a>) -> M::Output<'a>
    where
        M::Input<'a>: Copy,
        M::Output<'a>: Follows,
    {
        let output = self.step(now, input);
        let (woken, quiet) = step(self.machine.clone(), now, wake);
        assert!(quiet.is_quiet(), "a step leaves nothing to do: {quiet:?}");
        let (again, quiet) = step(woken.clone(), now, wake);
        assert!(quiet.is_quiet() && again == woken, "waking a machine twice changes nothing: {quiet:?}");
        output
    }
}

/// Number of faults that a line may still have, of each kind. `u8::MAX` is without end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Faults {
    /// Messages that may be lost.
    pub lost: u8,
    /// Messages whose bytes may be damaged.
    pub corrupt: u8,
    /// Messages that may arrive twice.
    pub doubled: u8,
}

impl Faults {
    /// Any number of faults of every kind.
    pub const ANY: Self = Self { lost: u8::MAX, corrupt: u8::MAX, doubled: u8::MAX };
}

/// What happens to the message that is first on a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fate {
    /// The message arrives.
    Arrives,
    /// The message arrives, and will arrive once more.
    Doubled,
    /// The message arrives damaged, so that its receiver can tell.
    Corrupt,
    /// The message does not arrive.
    Lost,
}

impl Fate {
    /// Every fate.
    pub const ALL: [Self; 4] = [Self::Arrives, Self::Doubled, Self::Corrupt, Self::Lost];
}

/// One direction of a line: messages on their way, which do not overtake each other.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Line<T> {
    items: VecDeque<(Millis, T)>,
    faults: Faults,
}

impl<T> Default for Line<T> {
    /// An empty line without faults.
    fn default() -> Self {
        Self::new(Faults::default())
    }
}

impl<T> Line<T> {
    /// An empty line that may have these faults.
    #[must_use]
    pub const fn new(faults: Faults) -> Self {
        Self { items: VecDeque::new(), faults }
    }

    /// Puts a message on its way, to arrive at a moment, or with the message before it if that arrives later.
    pub fn send(&mut self, due: Millis, message: T) {
        let due = self.items.back().map_or(due, |(last, _)| due.max(*last));
        self.items.push_back((due, message));
    }

    /// Time at which the next message arrives.
    #[must_use]
    pub fn due(&self) -> Option<Millis> {
        self.items.front().map(|(due, _)| *due)
    }

    /// Messages on their way, in order.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.items.iter().map(|(_, message)| message)
    }

    /// Messages on their way, in order, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.items.iter_mut().map(|(_, message)| message)
    }

    /// Number of messages on their way.
    #[must_use]
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether no message is on its way.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// Lets the first message arrive at a moment, unless it arrives earlier already.
    pub fn hasten(&mut self, moment: Millis) {
        if let Some((due, _)) = self.items.front_mut() {
            *due = moment.min(*due);
        }
    }

    /// Lets all messages arrive so many milliseconds earlier, because the clock is set back.
    pub fn set_back(&mut self, by: u64) {
        for (due, _) in &mut self.items {
            *due = Millis(due.since(Millis(by)));
        }
    }

    /// Loses all messages on their way: the link is cut.
    pub fn cut(&mut self) {
        self.items.clear();
    }

    /// Fates that the first message may meet; none if no message is on its way.
    pub fn fates(&self) -> impl Iterator<Item = Fate> {
        let (faults, there) = (self.faults, !self.is_empty());
        Fate::ALL.into_iter().filter(move |fate| there && faults.left(*fate) > 0)
    }
}

impl<T: Clone> Line<T> {
    /// Lets the first message meet its fate: the message, if one arrives, and whether it is undamaged.
    ///
    /// A fate for which the line has no fault left is that of a good line.
    pub fn meet(&mut self, fate: Fate) -> Option<(T, bool)> {
        let fate = self.fates().find(|possible| *possible == fate).unwrap_or(Fate::Arrives);
        self.faults.use_up(fate);
        if fate == Fate::Doubled {
            return self.iter().next().map(|message| (message.clone(), true));
        }
        let (_, message) = self.items.pop_front()?;
        (fate != Fate::Lost).then_some((message, fate == Fate::Arrives))
    }
}

impl Faults {
    const fn left(self, fate: Fate) -> u8 {
        match fate {
            Fate::Arrives => u8::MAX,
            Fate::Doubled => self.doubled,
            Fate::Corrupt => self.corrupt,
            Fate::Lost => self.lost,
        }
    }

    const fn use_up(&mut self, fate: Fate) {
        let left = match fate {
            Fate::Arrives => return,
            Fate::Doubled => &mut self.doubled,
            Fate::Corrupt => &mut self.corrupt,
            Fate::Lost => &mut self.lost,
        };
        if *left < u8::MAX {
            *left = left.saturating_sub(1);
        }
    }
}

/// Requests of the application: each ends exactly once.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub struct Tokens {
    last: u32,
    open: BTreeSet<u32>,
}

impl Tokens {
    /// Begins a request, under a token that no other request had.
    pub fn begin(&mut self) -> Token {
        self.last += 1;
        self.open.insert(self.last);
        Token(self.last)
    }

    /// Ends a request.
    ///
    /// # Panics
    ///
    /// If the request never began, or has ended before.
    pub fn end(&mut self, token: Token) {
        assert!(self.open.remove(&token.0), "{token:?} ends, and is not open");
    }

    /// Requests that have not ended.
    pub fn open(&self) -> impl Iterator<Item = Token> {
        self.open.iter().map(|&token| Token(token))
    }
}

/// A host, a device and both directions of the line between them, on a clock.
///
/// `Up` is what travels to the device, `Down` what travels to the host.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct World<H, D, Up, Down> {
    /// What time it is.
    pub now: Millis,
    /// The host.
    pub host: Watched<H>,
    /// The device.
    pub device: Watched<D>,
    /// Messages on their way to the device.
    pub up: Line<Up>,
    /// Messages on their way to the host.
    pub down: Line<Down>,
}

/// What comes next in a [`World`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Next {
    /// A message arrives at the device.
    Up,
    /// A message arrives at the host.
    Down,
    /// The world's own moment, that was asked about.
    Own,
    /// The device wants to be woken.
    WakeDevice,
    /// The host wants to be woken.
    WakeHost,
}

impl<H, D, Up, Down> World<H, D, Up, Down>
where
    H: Machine + Clone + Eq + Hash + Debug,
    D: Machine + Clone + Eq + Hash + Debug,
{
    /// Two machines at their beginning, and a line with the same faults in both directions.
    pub const fn new(now: Millis, host: H, device: D, faults: Faults) -> Self {
        Self {
            now,
            host: Watched::new(host),
            device: Watched::new(device),
            up: Line::new(faults),
            down: Line::new(faults),
        }
    }

    /// Takes a step of the host.
    ///
    /// # Panics
    ///
    /// If a law of machines is broken.
    pub fn step_host<'a>(&mut self, input: H::Input<'a>) -> H::Output<'a>
    where
        H::Input<'a>: Copy,
        H::Output<'a>: Follows,
    {
        self.host.step(self.now, input)
    }

    /// Takes a step of the device.
    ///
    /// # Panics
    ///
    /// If a law of machines is broken.
    pub fn step_device<'a>(&mut self, input: D::Input<'a>) -> D::Output<'a>
    where
        D::Input<'a>: Copy,
        D::Output<'a>: Follows,
    {
        self.device.step(self.now, input)
    }

    /// What comes next, and when; messages before deadlines. `own` is a moment of the caller's, such as that of a motor
    /// that arrives.
    #[must_use]
    pub fn next(&self, own: Option<Millis>) -> Option<(Millis, Next)> {
        let all = [
            (self.up.due(), Next::Up),
            (self.down.due(), Next::Down),
            (own, Next::Own),
            (self.device.wake, Next::WakeDevice),
            (self.host.wake, Next::WakeHost),
        ];
        let due = all.into_iter().filter_map(|(due, next)| due.map(|due| (due, next)));
        due.min_by_key(|(due, _)| *due).map(|(due, next)| (due.max(self.now), next))
    }

    /// Moves the clock to what comes next, if that is not after `end`; otherwise to `end`, and nothing comes.
    pub fn pass(&mut self, end: Millis, own: Option<Millis>) -> Option<Next> {
        let next = self.next(own).filter(|(due, _)| *due <= end);
        self.now = self.now.max(next.map_or(end, |(due, _)| due));
        next.map(|(_, next)| next)
    }

    /// Loses all messages on their way: the link is cut.
    pub fn cut(&mut self) {
        self.up.cut();
        self.down.cut();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_counts_its_faults_and_keeps_the_order() {
        let mut line = Line::<u8>::new(Faults { lost: 1, corrupt: 1, doubled: 1 });
        assert_eq!((line.fates().count(), line.meet(Fate::Lost)), (0, None), "no fault is used up by nothing");
        for (due, message) in [(5, 1), (3, 2), (9, 3), (9, 4)] {
            line.send(Millis(due), message);
        }
        assert_eq!(line.fates().count(), 4);
        assert_eq!(line.meet(Fate::Doubled), Some((1, true)));
        assert_eq!(line.meet(Fate::Lost), None);
        assert_eq!((line.due(), line.meet(Fate::Corrupt)), (Some(Millis(5)), Some((2, false))));
        assert_eq!(line.fates().collect::<Vec<_>>(), [Fate::Arrives]);
        line.hasten(Millis(7));
        line.hasten(Millis(8));
        line.set_back(2);
        assert_eq!(line.due(), Some(Millis(5)));
        assert_eq!(line.meet(Fate::Lost), Some((3, true)), "no fault is left");
        assert_eq!((line.len(), line.meet(Fate::Arrives), line.is_empty()), (1, Some((4, true)), true));
    }

    #[test]
    fn a_line_with_any_faults_never_runs_out_of_them() {
        let mut line = Line::new(Faults::ANY);
        for number in 0..1000 {
            line.send(Millis(0), number);
            assert_eq!(line.meet(Fate::Lost), None);
        }
        assert_eq!(line.fates().count(), 0);
    }

    #[test]
    #[should_panic(expected = "is not open")]
    fn a_request_that_ends_twice_is_noticed() {
        let mut tokens = Tokens::default();
        let token = tokens.begin();
        tokens.end(token);
        assert_eq!(tokens.open().count(), 0);
        tokens.end(token);
    }
}
