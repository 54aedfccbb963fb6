//! Requests on their way, and those that wait: DMC D5, safety decisions 2 and 3.

use arrayvec::ArrayVec;
use motion_core::time::Millis;

use super::io::{Name, Output, Send, Token, What};
use super::options::{MAX_WINDOW, Options, TRIES};
use crate::frame::{MessageId, MessageType};
use crate::message::HostMessage;

/// How many requests may wait: if there are as many, the application's next one has failed.
pub const MAX_QUEUE: usize = 8;

/// Two places more, that the application cannot take: for a sequence, and for a question after a silence.
const QUEUE: usize = MAX_QUEUE + 2;

/// All requests that there can be.
pub(super) const ALL: usize = MAX_WINDOW + QUEUE;

/// The ids of requests.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub(super) struct Ids(MessageId);

impl Ids {
    pub(super) fn next(&mut self, options: &Options) -> MessageId {
        self.0 = if self.0.0 < options.last_id { self.0.next() } else { MessageId(1) };
        self.0
    }
}

/// Whose request it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Owner {
    Application(Token),
    Sequence,
    /// The machine's own question whether motors move.
    Question,
}

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Request {
    pub(super) owner: Owner,
    pub(super) conduct: Conduct,
    kind: MessageType,
    what: What,
}

/// What may be done with a request, and what it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Conduct {
    pub(super) is_repeatable: bool,
    pub(super) starts_motion: bool,
    pub(super) role: Role,
}

/// What else the machine has to know of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Role {
    Plain,
    /// It says which motors are driven by hand.
    Configures,
    /// It ends a loop.
    StopsLoop,
    /// Because of it, a run or a shot may begin.
    Arms,
}

impl Request {
    /// A message that stays with the application.
    pub(super) fn named(owner: Owner, name: Name, message: &HostMessage<'_>) -> Self {
        Self::new(owner, What::Named(name), message)
    }

    /// A message of the machine's own.
    pub(super) fn own(owner: Owner, what: What) -> Option<Self> {
        what.own().map(|message| Self::new(owner, what, &message))
    }

    fn new(owner: Owner, what: What, message: &HostMessage<'_>) -> Self {
        let (is_repeatable, starts_motion) = (message.is_repeatable(), message.starts_motion());
        let role = match message {
            HostMessage::MotorConfigure(_) => Role::Configures,
            HostMessage::RtStopLoop(_) => Role::StopsLoop,
            HostMessage::RtRunMove(_) | HostMessage::RtShootFrame(_) | HostMessage::RtShootFrame2(_) => Role::Arms,
            _ => Role::Plain,
        };
        let conduct = Conduct { is_repeatable, starts_motion, role };
        Self { owner, conduct, kind: message.kind(), what }
    }
}

/// A request on its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Pending {
    request: Request,
    id: MessageId,
    tries: u8,
    /// Until then its answer is waited for; or, if that is known to be wanted, until it is sent again.
    until: Millis,
    again: bool,
}

/// What becomes of a request whose checksum was wrong.
pub(super) enum Garbled {
    /// There is no such request.
    Unknown,
    /// It is sent again.
    Again,
    /// It is over.
    Over(Request),
}

/// All requests.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub(super) struct Requests {
    window: ArrayVec<Pending, MAX_WINDOW>,
    queue: ArrayVec<Request, QUEUE>,
}

impl Requests {
    /// Lets a request wait for its turn: `false`, if there is no room.
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

    /// Whether somebody has a request here.
    pub(super) fn has(&self, owner: Owner) -> bool {
        self.window.iter().any(|pending| pending.request.owner == owner)
            || self.queue.iter().any(|request| request.owner == owner)
    }

    /// Requests that are sent, with what became of them.
    pub(super) fn pending(&self) -> impl Iterator<Item = (MessageId, MessageType)> {
        self.window.iter().map(|pending| (pending.id, pending.request.kind))
    }

    /// Takes the request that a message of this id and type answers. It may wait to be sent again, if the device got it
    /// twice, and once of that wrong.
    pub(super) fn answered(&mut self, id: MessageId, kind: MessageType) -> Option<Request> {
        let at = self.window.iter().position(|pending| pending.id == id && pending.request.kind == kind)?;
        self.window.pop_at(at).map(|pending| pending.request)
    }

    /// The device says that the checksum of this id was wrong: the request is sent again in a while, if it may be.
    /// Otherwise it is over.
    pub(super) fn garbled(&mut self, now: Millis, id: MessageId, options: &Options) -> Garbled {
        let is_it = |pending: &Pending| pending.id == id && !pending.again;
        let Some(pending) = self.window.iter_mut().find(|pending| is_it(pending)) else { return Garbled::Unknown };
        let request = pending.request;
        if request.conduct.is_repeatable && pending.tries < TRIES {
            pending.again = true;
            pending.until = now.after(options.times.pause.into());
            return Garbled::Again;
        }
        self.window.retain(|pending| !is_it(pending));
        Garbled::Over(request)
    }

    /// Takes away the requests that `which` says, on their way and waiting.
    pub(super) fn cancel(&mut self, which: impl Fn(&Request) -> bool) -> ArrayVec<Request, ALL> {
        let sent = self.window.iter().map(|pending| pending.request);
        let gone = sent.chain(self.queue.iter().copied()).filter(|request| which(request)).take(ALL).collect();
        self.window.retain(|pending| !which(&pending.request));
        self.queue.retain(|request| !which(request));
        gone
    }

    /// Sends again what may be, and takes away what is overdue.
    pub(super) fn due(
        &mut self,
        now: Millis,
        options: &Options,
        ids: &mut Ids,
        output: &mut Output,
    ) -> ArrayVec<Request, MAX_WINDOW> {
        let mut over = ArrayVec::new();
        self.window.retain(|pending| {
            if pending.until > now {
                return true;
            }
            let may = pending.again || (pending.request.conduct.is_repeatable && pending.tries < TRIES);
            if may {
                pending.id = ids.next(options);
                pending.tries = pending.tries.saturating_add(1);
                pending.until = now.after(options.times.request.into());
                pending.again = false;
                output.send(Send { id: pending.id, what: pending.request.what });
                true
            } else {
                over.try_push(pending.request).is_err()
            }
        });
        over
    }

    /// Sends what has its turn. No motion is asked for while another is not answered, and nothing overtakes.
    pub(super) fn send(&mut self, now: Millis, options: &Options, ids: &mut Ids, output: &mut Output) {
        while self.window.len() < options.window.into() {
            let is_moving = self.window.iter().any(|pending| pending.request.conduct.starts_motion);
            let Some(&request) = self.queue.first() else { return };
            if request.conduct.starts_motion && is_moving {
                return;
            }
            self.queue.pop_at(0);
            let id = ids.next(options);
            let until = now.after(options.times.request.into());
            output.send(Send { id, what: request.what });
            if self.window.try_push(Pending { request, id, tries: 1, until, again: false }).is_err() {
                return;
            }
        }
    }

    pub(super) fn wake(&self) -> Option<Millis> {
        self.window.iter().map(|pending| pending.until).min()
    }
}
