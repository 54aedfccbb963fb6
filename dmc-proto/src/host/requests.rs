//! Requests under way, and those that wait: DMC D5, safety decisions 2 and 3.

use arrayvec::ArrayVec;
use motion_core::debug;
use motion_core::machine::Token;
use motion_core::time::Millis;
use motion_core::wire::{Conduct, Purpose};

use super::options::{MAX_WINDOW, Options, TRIES};
use super::transmit::{Contents, Output, Source, Transmit};
use crate::frame::{MessageId, MessageType};
use crate::message::{AckCode, DeviceMessage, HostMessage, Motor, MotorFlags, MotorStatusRequest, Motors};

/// Number of requests that may wait. If as many wait, the application's next one is refused.
pub const MAX_QUEUE: usize = 8;

/// Places in the queue. The application cannot take the last two: one is for a sequence, one for a question after a
/// silence.
const QUEUE: usize = MAX_QUEUE + 2;

/// Greatest number of requests.
pub(super) const ALL: usize = MAX_WINDOW + QUEUE;

/// Ids of requests, one after the other.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Ids {
    used: MessageId,
    /// Id after which the count begins again.
    greatest: u32,
}

impl Ids {
    /// Ids from `first` to `greatest`, then from 1 on.
    pub(super) const fn new(first: u32, greatest: u32) -> Self {
        Self { used: MessageId(first.saturating_sub(1)), greatest }
    }

    pub(super) fn next(&mut self) -> MessageId {
        self.used = if self.used.0 < self.greatest { self.used.next() } else { MessageId(1) };
        self.used
    }
}

/// Whose request it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Owner {
    Application(Token),
    Sequence,
    /// The machine itself asks whether motors move.
    Question,
}

/// Request to the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Request {
    pub(super) owner: Owner,
    pub(super) conduct: Conduct,
    pub(super) role: Role,
    kind: MessageType,
    contents: Contents,
}

/// What the machine has to know of a request besides its conduct.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Role {
    Plain,
    /// It sets the uses of a motor.
    Configures(Motor, MotorFlags),
    /// It moves one motor to a position.
    MovesOne,
    /// It ends a loop.
    StopsLoop,
    /// It opens the shutter of the camera, or closes it.
    Shutter(bool),
}

impl Request {
    /// Request whose message the application holds.
    pub(super) fn of_application(owner: Owner, source: Source, message: &HostMessage<'_>) -> Self {
        Self::new(owner, Contents::Application(source), message)
    }

    /// Request whose message the machine makes.
    pub(super) fn own(owner: Owner, contents: Contents) -> Self {
        Self::new(owner, contents, &contents.message(|_| MotorStatusRequest::default().into()))
    }

    fn new(owner: Owner, contents: Contents, message: &HostMessage<'_>) -> Self {
        let role = match message {
            HostMessage::MotorConfigure(message) => Role::Configures(message.motor, message.flags),
            HostMessage::MotorMove(_) => Role::MovesOne,
            HostMessage::RtStopLoop(_) => Role::StopsLoop,
            HostMessage::GioCam(_) => Role::Shutter(message.opens_shutter()),
            _ => Role::Plain,
        };
        Self { owner, conduct: message.conduct(), role, kind: message.kind(), contents }
    }

    /// Motor whose uses the request sets.
    const fn configures(&self) -> Option<Motor> {
        match self.role {
            Role::Configures(motor, _) => Some(motor),
            _ => None,
        }
    }

    /// Whether both requests set the uses of the same motor. The one that the device gets last counts.
    pub(super) fn configures_as(&self, other: &Self) -> bool {
        self.configures().is_some_and(|motor| other.configures() == Some(motor))
    }

    /// Whether a run or a shot may begin because of the request.
    pub(super) const fn arms(&self) -> bool {
        matches!(self.conduct.purpose, Purpose::Arms)
    }
}

/// Request that was sent.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(super) struct Pending {
    pub(super) request: Request,
    /// Times that it was sent. An answer to an earlier one counts as well.
    pub(super) tries: ArrayVec<Try, { TRIES as usize }>,
    /// Whether something that may move was sent after the try that was answered: the answer can be older than that motion.
    pub(super) is_outdated: bool,
    /// Until when its answer is waited for. If its frame arrived damaged, until when it is not sent again.
    until: Millis,
    is_damaged: bool,
}

debug! { Pending { request tries is_outdated until is_damaged } }

/// Try of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Try {
    id: MessageId,
    /// Whether something that may move was sent after it.
    is_outdated: bool,
}

impl Pending {
    /// Sends the request, or sends it again.
    fn send(&mut self, now: Millis, output: &mut Output<'_>, options: &Options, ids: &mut Ids) {
        let id = ids.next();
        output.transmit(Transmit { id, contents: self.request.contents });
        // There is room: no request is sent more often.
        let _ = self.tries.try_push(Try { id, is_outdated: false });
        (self.until, self.is_damaged) = (now.after(options.request_timeout().into()), false);
    }

    /// Whether the request may be sent again.
    fn may_repeat(&self) -> bool {
        self.request.conduct.repeatable && !self.tries.is_full()
    }

    /// Id of the last try.
    fn id(&self) -> MessageId {
        self.tries.last().map_or(MessageId::UNSOLICITED, |last| last.id)
    }

    /// Try with this id.
    fn tried(&self, id: MessageId) -> Option<Try> {
        self.tries.iter().find(|tried| tried.id == id).copied()
    }
}

/// End of a request, except that it was called off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reply<'a> {
    Acknowledged,
    Answered(DeviceMessage<'a>),
    Refused(AckCode),
    /// No answer came, or one that does not say how it ended.
    Unclear,
}

impl Reply<'_> {
    /// Whether the device says that no motor moves.
    pub(super) const fn rests(&self) -> bool {
        matches!(self, Self::Answered(DeviceMessage::MotorStatus(status)) if status.motor_status.0 == Motors::NONE.0)
    }

    /// Whether the device refused because of the request itself. Other refusals do not say that nothing moves: motors may
    /// move because of an earlier request, and nobody knows what it was that arrived damaged.
    pub(super) const fn is_plain_refusal(&self) -> bool {
        matches!(self, Self::Refused(code) if !matches!(*code, AckCode::ERR_MOVING | AckCode::ERR_CHECKSUM))
    }
}

/// What becomes of a request whose frame arrived damaged.
pub(super) enum Damaged {
    /// There is no such request.
    Unknown,
    /// It is sent again.
    Again,
    /// It is over.
    Over(Pending),
}

/// Requests under way and waiting.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub(super) struct Requests {
    window: ArrayVec<Pending, MAX_WINDOW>,
    queue: ArrayVec<Request, QUEUE>,
}

impl Requests {
    /// Lets a request wait for its turn. Returns `false` if there is no room.
    pub(super) fn submit(&mut self, request: Request) -> bool {
        let room = match request.owner {
            Owner::Application(_) => MAX_QUEUE,
            Owner::Sequence | Owner::Question => QUEUE,
        };
        self.queue.len() < room && self.queue.try_push(request).is_ok()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.window.is_empty() && self.queue.is_empty()
    }

    /// Whether there is such a request, under way or waiting.
    pub(super) fn any(&self, which: impl Fn(&Request) -> bool) -> bool {
        self.sent().any(&which) || self.queue.iter().any(which)
    }

    /// Requests under way.
    pub(super) fn sent(&self) -> impl Iterator<Item = &Request> {
        self.window.iter().map(|pending| &pending.request)
    }

    /// Ids and types of the requests under way.
    pub(super) fn pending(&self) -> impl Iterator<Item = (MessageId, MessageType)> {
        self.window.iter().map(|pending| (pending.id(), pending.request.kind))
    }

    /// Takes the request that a message of this id and type answers. The request may wait to be sent again: the device
    /// may have got it twice, and damaged once.
    pub(super) fn answered(&mut self, id: MessageId, kind: MessageType) -> Option<Pending> {
        let tried = |pending: &Pending| pending.tried(id).filter(|_| pending.request.kind == kind);
        let (at, tried) = self.window.iter().enumerate().find_map(|(at, pending)| Some((at, tried(pending)?)))?;
        let pending = self.window.pop_at(at)?;
        Some(Pending { is_outdated: tried.is_outdated, ..pending })
    }

    /// The device says that the frame of this id arrived damaged: the request is sent again after a pause, if it may be.
    /// Otherwise it is over. Of an earlier try, the last one is still under way.
    pub(super) fn damaged(&mut self, now: Millis, options: &Options, id: MessageId) -> Damaged {
        let found = self.window.iter().position(|pending| pending.tried(id).is_some());
        let Some((at, pending)) = found.and_then(|at| Some((at, self.window.get_mut(at)?))) else {
            return Damaged::Unknown;
        };
        if pending.id() != id {
            return Damaged::Again;
        }
        if pending.is_damaged {
            return Damaged::Unknown;
        }
        if pending.may_repeat() {
            pending.is_damaged = true;
            pending.until = now.after(options.pause().into());
            return Damaged::Again;
        }
        self.window.pop_at(at).map_or(Damaged::Unknown, Damaged::Over)
    }

    /// Takes the requests away that `which` names, with whether each was sent.
    pub(super) fn cancel(&mut self, which: impl Fn(&Request) -> bool) -> ArrayVec<(Request, bool), ALL> {
        let sent = self.sent().map(|request| (*request, true));
        let waiting = self.queue.iter().map(|request| (*request, false));
        let gone = sent.chain(waiting).filter(|(request, _)| which(request)).take(ALL).collect();
        self.window.retain(|pending| !which(&pending.request));
        self.queue.retain(|request| !which(request));
        gone
    }

    /// Sends again what may be sent again, and takes away what is overdue.
    pub(super) fn due(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        options: &Options,
        ids: &mut Ids,
    ) -> ArrayVec<Pending, MAX_WINDOW> {
        let (mut over, mut moves, mut at) = (ArrayVec::new(), false, 0_usize);
        while let Some(pending) = self.window.get_mut(at) {
            let is_due = pending.until <= now;
            if is_due && !pending.may_repeat() {
                // There is room: both lists are equally long.
                let _ = self.window.pop_at(at).map(|pending| over.try_push(pending));
                continue;
            }
            if is_due {
                moves |= pending.request.conduct.may_move();
                pending.send(now, output, options, ids);
            }
            at = at.saturating_add(1);
        }
        self.outdate(moves);
        over
    }

    /// Sends what has its turn. Nothing that may move is sent while such a request is not answered, nor new uses of a motor
    /// while the last ones are not. No request overtakes another.
    pub(super) fn send(&mut self, now: Millis, output: &mut Output<'_>, options: &Options, ids: &mut Ids) {
        while self.window.len() < options.window().into() {
            let Some(&request) = self.queue.first() else { return };
            let moves = request.conduct.may_move();
            if self.sent().any(|sent| (moves && sent.conduct.may_move()) || request.configures_as(sent)) {
                return;
            }
            self.queue.pop_at(0);
            self.outdate(moves);
            let tries = ArrayVec::new();
            let mut pending = Pending { request, tries, is_outdated: false, until: now, is_damaged: false };
            pending.send(now, output, options, ids);
            if self.window.try_push(pending).is_err() {
                return;
            }
        }
    }

    /// Something that may move was sent: what is under way already says nothing of that motion.
    fn outdate(&mut self, moves: bool) {
        for tried in self.window.iter_mut().flat_map(|pending| &mut pending.tries) {
            tried.is_outdated |= moves;
        }
    }

    pub(super) fn wake(&self) -> Option<Millis> {
        self.window.iter().map(|pending| pending.until).min()
    }
}
