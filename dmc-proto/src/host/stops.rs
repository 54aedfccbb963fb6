//! Stops, and whether they are obeyed: safety decision 1.

use arrayvec::ArrayVec;
use motion_core::time::Millis;

use super::io::{Event, Output, Send, What};
use super::options::{Options, TRIES};
use super::requests::Ids;
use crate::frame::MessageId;
use crate::message::{
    Ack, AckCode, HostMessage, Motor, MotorStop, MotorStopAll, Motors, StopFlags, VirtStop, VirtualMotor,
};

/// What shall stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Stop {
    /// One motor. While a run, a shot or any other coordinated move is followed, or may still begin, this is a stop of
    /// everything, unless the motor is driven by hand (`MotorFlags::LIVE`).
    Motor(Motor),
    /// One virtual motor; likewise.
    Virtual(VirtualMotor),
    /// Everything.
    All,
    /// Everything, without warnings of the device.
    AllSilent,
}

impl Stop {
    /// The stop that a message is.
    pub(super) fn of(message: &HostMessage<'_>) -> Option<Self> {
        match message {
            HostMessage::MotorStop(stop) => Some(Self::Motor(stop.motor)),
            HostMessage::VirtStop(stop) => Some(Self::Virtual(stop.virtual_motor)),
            HostMessage::MotorStopAll(stop) => {
                let silent = stop.flags.unwrap_or_default().contains(StopFlags::SILENT);
                Some(if silent { Self::AllSilent } else { Self::All })
            }
            _ => None,
        }
    }

    pub(super) const fn message(self) -> HostMessage<'static> {
        match self {
            Self::Motor(motor) => HostMessage::MotorStop(MotorStop { motor, tail: &[] }),
            Self::Virtual(virtual_motor) => HostMessage::VirtStop(VirtStop { virtual_motor, tail: &[] }),
            Self::All => HostMessage::MotorStopAll(MotorStopAll { flags: None, tail: &[] }),
            Self::AllSilent => HostMessage::MotorStopAll(MotorStopAll { flags: Some(StopFlags::SILENT), tail: &[] }),
        }
    }

    pub(super) const fn is_all(self) -> bool {
        matches!(self, Self::All | Self::AllSilent)
    }

    /// Whether it is obeyed, if these motors move.
    fn is_obeyed(self, moving: Motors) -> bool {
        match self {
            Self::Motor(motor) => !moving.contains(motor),
            _ => moving == Motors::NONE,
        }
    }
}

/// Different stops that are followed at once; one more is a stop of everything.
const MAX_STOPS: usize = 4;

/// Stops that are not confirmed yet.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub(super) struct Stops {
    slots: ArrayVec<Slot, MAX_STOPS>,
    /// The question whether motors still move, and until when it is waited for.
    question: Option<(MessageId, Millis)>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Slot {
    stop: Stop,
    /// The last ids that it was sent under: the answer to an earlier try is as good.
    ids: ArrayVec<MessageId, { TRIES as usize }>,
    /// How often it was sent, up to one more than it takes to tell.
    tries: u8,
    /// Until when its answer is waited for; `None` if it is asked whether it was obeyed.
    until: Option<Millis>,
}

/// What an acknowledgement means to the stops.
pub(super) enum Acknowledged {
    /// It is of none.
    Other,
    /// This one is obeyed.
    Confirms(Stop),
    /// It does not say that one is obeyed.
    Refuses,
}

/// How a stop is sent.
pub(super) struct Line<'l> {
    pub(super) now: Millis,
    pub(super) options: &'l Options,
    pub(super) ids: &'l mut Ids,
    pub(super) output: &'l mut Output,
}

impl Line<'_> {
    fn patience(&self) -> Millis {
        self.now.after(self.options.times.stop.into())
    }

    fn send(&mut self, what: What) -> MessageId {
        let id = self.ids.next(self.options);
        self.output.send(Send { id, what });
        id
    }
}

impl Slot {
    fn send(&mut self, line: &mut Line<'_>) {
        if self.tries == TRIES {
            line.output.event(Event::StopNotConfirmed(self.stop));
        }
        self.tries = self.tries.saturating_add(1).min(TRIES.saturating_add(1));
        let id = line.send(What::Stop(self.stop));
        if self.ids.is_full() {
            self.ids.pop_at(0);
        }
        if self.ids.try_push(id).is_ok() {
            self.until = Some(line.patience());
        }
    }
}

impl Stops {
    /// Sends a stop and follows it. A stop of everything takes the place of all others.
    pub(super) fn submit(&mut self, stop: Stop, line: &mut Line<'_>) {
        let slot = self.place(stop);
        if let Some(slot) = slot {
            (slot.tries, slot.until) = (0, None);
            slot.send(line);
        }
    }

    /// Keeps a stop while the line is closed: it is sent as soon as that is open again.
    pub(super) fn keep(&mut self, stop: Stop, output: &mut Output) {
        if let Some(slot) = self.place(stop) {
            output.event(Event::StopNotConfirmed(slot.stop));
        }
    }

    /// The place of a stop, old or new.
    fn place(&mut self, stop: Stop) -> Option<&mut Slot> {
        let is_known = self.slots.iter().any(|slot| slot.stop == stop);
        let stop = if is_known || !self.slots.is_full() { stop } else { Stop::All };
        if stop.is_all() {
            self.slots.retain(|slot| slot.stop == stop);
        }
        if !self.slots.iter().any(|slot| slot.stop == stop) {
            let new = Slot { stop, ids: ArrayVec::new(), tries: 0, until: None };
            self.slots.try_push(new).ok()?;
        }
        self.slots.iter_mut().find(|slot| slot.stop == stop)
    }

    /// Whether a message would move what shall stop (decision D-70). What moves motors together, or unknown ones, would.
    pub(super) fn forbid(&self, message: &HostMessage<'_>) -> bool {
        let one = match message {
            HostMessage::MotorMove(message) => Some(Stop::Motor(message.motor)),
            HostMessage::MotorJog(message) => Some(Stop::Motor(message.motor)),
            _ => None,
        };
        let is_moved = |stop: Stop| match (stop, one) {
            (Stop::Motor(_), Some(one)) => stop == one,
            _ => true,
        };
        message.starts_motion() && self.iter().any(is_moved)
    }

    /// The stops that are not confirmed.
    pub(super) fn iter(&self) -> impl Iterator<Item = Stop> {
        self.slots.iter().map(|slot| slot.stop)
    }

    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// The line is gone.
    pub(super) fn link_down(&mut self, output: &mut Output) {
        self.question = None;
        for slot in &mut self.slots {
            (slot.tries, slot.until) = (0, None);
            slot.ids.clear();
            output.event(Event::StopNotConfirmed(slot.stop));
        }
    }

    /// The line is open: what waited is sent.
    pub(super) fn link_up(&mut self, line: &mut Line<'_>) {
        for slot in &mut self.slots {
            slot.send(line);
        }
    }

    /// Takes an acknowledgement. One that refuses a stop leads to the question whether motors move.
    pub(super) fn acknowledged(&mut self, id: MessageId, ack: &Ack<'_>, line: &mut Line<'_>) -> Acknowledged {
        let code = ack.response_code;
        // The id alone is not enough to believe that a stop is obeyed.
        let is_of = |stop: Stop| stop.message().kind() == ack.of || code == Some(AckCode::ERR_CHECKSUM);
        let is_it = |slot: &&mut Slot| slot.ids.contains(&id) && is_of(slot.stop);
        let Some(slot) = self.slots.iter_mut().find(is_it) else { return Acknowledged::Other };
        if code == Some(AckCode::OK) {
            let stop = slot.stop;
            self.slots.retain(|slot| slot.stop != stop);
            line.output.event(Event::Stopped(stop));
            return Acknowledged::Confirms(stop);
        }
        if code == Some(AckCode::ERR_CHECKSUM) && slot.tries < TRIES {
            slot.send(line);
        } else {
            slot.until = None;
        }
        Acknowledged::Refuses
    }

    /// Takes the answer to the question whether motors move: `false`, if it is of another one. While a run may still
    /// begin, that nothing moves proves nothing (decision D-60).
    pub(super) fn status(&mut self, id: MessageId, moving: Motors, armed: bool, line: &mut Line<'_>) -> bool {
        if self.question.is_none_or(|(asked, _)| asked != id) {
            return false;
        }
        self.question = None;
        self.slots.retain(|slot| {
            let is_obeyed = slot.until.is_none() && slot.stop.is_obeyed(moving) && !armed;
            if is_obeyed {
                line.output.event(Event::Stopped(slot.stop));
            } else if slot.until.is_none() {
                slot.send(line);
            }
            !is_obeyed
        });
        true
    }

    /// Asks, and sends again, where an answer is overdue.
    pub(super) fn due(&mut self, line: &mut Line<'_>) {
        let now = line.now;
        for slot in &mut self.slots {
            slot.until = slot.until.filter(|&until| until > now);
        }
        if let Some((_, until)) = self.question {
            if until > now {
                return;
            }
            self.question = None;
            for slot in self.slots.iter_mut().filter(|slot| slot.until.is_none()) {
                slot.send(line);
            }
        } else if self.slots.iter().any(|slot| slot.until.is_none()) {
            let id = line.send(What::Status);
            self.question = Some((id, line.patience()));
        }
    }

    pub(super) fn wake(&self) -> Option<Millis> {
        let until = self.slots.iter().filter_map(|slot| slot.until);
        until.chain(self.question.map(|(_, until)| until)).min()
    }
}
