//! Stops, and whether they are obeyed: safety decision 1.

use arrayvec::ArrayVec;
use motion_core::time::Millis;

use super::event::{Event, StopTarget};
use super::options::{Options, TRIES};
use super::requests::Ids;
use super::transmit::{Contents, Output, Transmit, transmit_padding, transmit_stop};
use crate::frame::MessageId;
use crate::message::{Ack, AckCode, HostMessage, Motors};

/// Number of different stops that are followed at once. One more is a stop of everything.
const MAX_STOPS: usize = 4;

/// Stops that are not confirmed.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub(super) struct Stops {
    slots: ArrayVec<Slot, MAX_STOPS>,
    /// Until when the answer to the question whether motors still move is waited for; `None` if the question is not asked.
    question: Option<Millis>,
}

/// Ids of the last tries. An answer to an earlier try counts as well.
type Tries = ArrayVec<MessageId, { TRIES as usize }>;

#[derive(Clone, PartialEq, Eq, Hash)]
struct Slot {
    target: StopTarget,
    /// Ids under which the stop was sent.
    ids: Tries,
    /// Ids of the questions whether motors still move that were asked after the stop was sent.
    questions: Tries,
    /// Number of times that the stop was sent, up to one more than it takes to tell the application.
    tries: u8,
    /// Until when the answer is waited for; `None` if the device is asked whether motors still move.
    until: Option<Millis>,
    /// Whether the device answered anything to the last try, or to the question after it.
    is_answered: bool,
}

motion_core::debug! { Slot { target ids questions tries until is_answered } }

/// Meaning of an acknowledgement to the stops.
pub(super) enum Acknowledged {
    /// It acknowledges no stop.
    Other,
    /// This stop is obeyed.
    Confirms(StopTarget),
    /// It does not say that a stop is obeyed.
    Refuses,
}

/// Meaning of a status to the stops.
pub(super) enum StatusMeaning {
    /// It answers another question.
    Other,
    /// It is the answer to the question of the stops.
    Answer {
        /// Whether nothing moves, after a stop of everything.
        all_rest: bool,
    },
}

impl Slot {
    fn send(&mut self, now: Millis, output: &mut Output<'_>, options: &Options, ids: &mut Ids) {
        let id = ids.next();
        transmit_stop(output, Transmit { id, contents: Contents::Stop(self.target) });
        if self.tries == TRIES {
            output.event(Event::StopNotConfirmed(self.target));
        }
        self.tries = self.tries.saturating_add(1).min(TRIES.saturating_add(1));
        remember(&mut self.ids, id);
        self.until = Some(patience(now, options));
        self.is_answered = false;
    }

    /// Whether the device may wait for the end of a frame that was cut off, and take the stop for a part of it.
    const fn is_silent(&self) -> bool {
        self.until.is_none() && !self.is_answered && self.tries <= TRIES
    }

    /// Forgets what was sent over a link that is gone.
    fn start_over(&mut self) {
        *self = Self::new(self.target);
    }

    fn new(target: StopTarget) -> Self {
        Self { target, ids: Tries::new(), questions: Tries::new(), tries: 0, until: None, is_answered: false }
    }
}

/// Keeps the id of the last try, in the place of the oldest one.
fn remember(tries: &mut Tries, id: MessageId) {
    if tries.is_full() {
        tries.pop_at(0);
    }
    // There is room now.
    let _ = tries.try_push(id);
}

fn patience(now: Millis, options: &Options) -> Millis {
    now.after(options.stop_timeout().into())
}

/// Whether a stop is obeyed when these motors move.
fn is_obeyed(target: StopTarget, moving: Motors) -> bool {
    match target {
        StopTarget::Motor(motor) => !moving.contains(motor),
        _ => moving == Motors::NONE,
    }
}

impl Stops {
    /// Sends a stop and follows it. A stop of everything takes the place of all others.
    pub(super) fn submit(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        options: &Options,
        ids: &mut Ids,
        target: StopTarget,
    ) {
        if let Some(slot) = self.place(target) {
            (slot.tries, slot.until) = (0, None);
            slot.send(now, output, options, ids);
            self.end_question();
        }
    }

    /// Keeps a stop while there is no link: it is sent as soon as there is one.
    pub(super) fn keep(&mut self, output: &mut Output<'_>, target: StopTarget) {
        if let Some(slot) = self.place(target) {
            output.event(Event::StopNotConfirmed(slot.target));
        }
    }

    /// The slot of a stop, old or new.
    fn place(&mut self, target: StopTarget) -> Option<&mut Slot> {
        let is_followed = self.iter().any(|followed| followed == target);
        let target = if is_followed || !self.slots.is_full() { target } else { StopTarget::All };
        if target.is_all() {
            self.slots.retain(|slot| slot.target == target);
        }
        if !self.iter().any(|followed| followed == target) {
            self.slots.try_push(Slot::new(target)).ok()?;
        }
        self.slots.iter_mut().find(|slot| slot.target == target)
    }

    /// Whether a message would move what has to stop (decision D-70). A message that moves motors together, or unknown
    /// motors, would.
    pub(super) fn forbid(&self, message: &HostMessage<'_>) -> bool {
        let one = match message {
            HostMessage::MotorMove(message) => Some(StopTarget::Motor(message.motor)),
            HostMessage::MotorJog(message) => Some(StopTarget::Motor(message.motor)),
            _ => None,
        };
        let is_moved = |target: StopTarget| match (target, one) {
            (StopTarget::Motor(_), Some(one)) => target == one,
            _ => true,
        };
        message.conduct().may_move() && self.iter().any(is_moved)
    }

    /// Targets of the stops that are not confirmed.
    pub(super) fn iter(&self) -> impl Iterator<Item = StopTarget> {
        self.slots.iter().map(|slot| slot.target)
    }

    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// The link is gone.
    pub(super) fn link_down(&mut self, output: &mut Output<'_>) {
        self.question = None;
        for slot in &mut self.slots {
            slot.start_over();
            output.event(Event::StopNotConfirmed(slot.target));
        }
    }

    /// The link is open: the stops that wait are sent.
    pub(super) fn link_up(&mut self, now: Millis, output: &mut Output<'_>, options: &Options, ids: &mut Ids) {
        for slot in &mut self.slots {
            slot.send(now, output, options, ids);
        }
    }

    /// Takes an acknowledgement. A stop that arrived damaged is sent again at once, until it was sent three times. Any
    /// other refusal changes nothing: the next try comes in its time.
    pub(super) fn acknowledged(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        options: &Options,
        ids: &mut Ids,
        (id, ack): (MessageId, &Ack<'_>),
    ) -> Acknowledged {
        let code = ack.response_code;
        // The id alone is not enough to believe that a stop is obeyed.
        let is_of =
            |target: StopTarget| HostMessage::from(target).kind() == ack.of || code == Some(AckCode::ERR_CHECKSUM);
        let is_it = |slot: &&mut Slot| slot.ids.contains(&id) && is_of(slot.target);
        let Some(slot) = self.slots.iter_mut().find(is_it) else { return Acknowledged::Other };
        if code == Some(AckCode::OK) {
            let target = slot.target;
            self.slots.retain(|slot| slot.target != target);
            self.end_question();
            output.event(Event::Stopped(target));
            return Acknowledged::Confirms(target);
        }
        slot.is_answered = true;
        if code == Some(AckCode::ERR_CHECKSUM) && slot.tries < TRIES {
            slot.send(now, output, options, ids);
        }
        Acknowledged::Refuses
    }

    /// Takes a status. While a run may still begin, that nothing moves proves nothing (decision D-60). If motors move, the
    /// next try comes in its time.
    pub(super) fn status(
        &mut self,
        output: &mut Output<'_>,
        (id, moving, is_armed): (MessageId, Motors, bool),
    ) -> StatusMeaning {
        if !self.slots.iter().any(|slot| slot.questions.contains(&id)) {
            return StatusMeaning::Other;
        }
        let mut all_rest = false;
        self.slots.retain(|slot| {
            if !slot.questions.contains(&id) {
                return true;
            }
            slot.is_answered = true;
            let is_obeyed = is_obeyed(slot.target, moving) && !is_armed;
            if is_obeyed {
                all_rest |= slot.target.is_all();
                output.event(Event::Stopped(slot.target));
            }
            !is_obeyed
        });
        self.end_question();
        StatusMeaning::Answer { all_rest }
    }

    /// Ends the question if no stop needs its answer.
    fn end_question(&mut self) {
        self.question = self.question.filter(|_| self.slots.iter().any(|slot| slot.until.is_none()));
    }

    /// Asks, and sends again, where an answer is overdue: a stop and its question by turns, a timeout apart, whatever the
    /// device answers.
    pub(super) fn due(&mut self, now: Millis, output: &mut Output<'_>, options: &Options, ids: &mut Ids) {
        for slot in &mut self.slots {
            slot.until = slot.until.filter(|&until| until > now);
        }
        if self.question.is_some_and(|until| until > now) {
            return;
        }
        let is_asked = self.question.take().is_some();
        if !self.slots.iter().any(|slot| slot.until.is_none()) {
            return;
        }
        let overdue = |slot: &&mut Slot| slot.until.is_none();
        if is_asked {
            return self.slots.iter_mut().filter(overdue).for_each(|slot| slot.send(now, output, options, ids));
        }
        if self.slots.iter().any(Slot::is_silent) {
            transmit_padding(output, options, options.stop_timeout());
        }
        let id = ids.next();
        output.transmit(Transmit { id, contents: Contents::Status });
        self.question = Some(patience(now, options));
        self.slots.iter_mut().filter(overdue).for_each(|slot| remember(&mut slot.questions, id));
    }

    pub(super) fn wake(&self) -> Option<Millis> {
        let until = self.slots.iter().filter_map(|slot| slot.until);
        until.chain(self.question).min()
    }
}
