//! Sequences that move all motors together, from the first request to rest: DMC D5.

use motion_core::machine::Token;
use motion_core::time::Millis;

use super::event::{Event, Outcome, Refusal};
use super::options::{Options, PATIENCE, SHOT, TRIES};
use super::progress::{Next, Progress};
use super::requests::{Owner, Reply, Request};
use super::transmit::Contents;
use crate::message::{AckCode, DeviceMessage, FrameNumber, HostMessage, RtRunMove, RunFlags};

/// A move to a frame, a jog of all motors, a run or a shot.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Run {
    goal: Goal,
    /// Message of the application that asked for it.
    begin: Request,
    /// Whether the device opens the shutter of the camera.
    opens_shutter: bool,
    phase: Phase,
    /// Token of the signal to start, as long as that has not ended.
    go: Option<Token>,
    /// Whether a motor was moved while the device ran, which may have ended the run.
    is_doubtful: bool,
}

motion_core::debug! { Run { goal begin opens_shutter phase go is_doubtful } }

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Goal {
    /// To be at rest on a frame.
    Travel,
    /// To run from a frame. One pass takes `lasts` milliseconds.
    Run { start: FrameNumber, lasts: u64, loops: bool },
    /// To shoot, for `lasts` milliseconds.
    Shot { lasts: u64 },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Phase {
    /// The request for the first frame is on its way.
    ToStart,
    /// The application's message is on its way.
    Begins,
    /// The device is asked whether motors still move.
    Watch(Watch, Then),
    /// The device waits for the signal to start.
    Armed,
    /// The signal was sent. The number counts its refusals; the time is when to send it again.
    Goes(u8, Option<Millis>),
    /// The device runs. If its end is not told until then, the host asks for it.
    Runs(Millis),
}

/// What follows when all motors rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Then {
    Begin,
    Arm,
    End,
}

/// Questions until the motors rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Watch {
    /// When to give up.
    until: Millis,
    /// When to ask next; `None` while an answer is on its way.
    ask: Option<Millis>,
    /// Whether the motors rested at the last answer.
    rested: bool,
}

impl Watch {
    fn new(now: Millis, options: &Options) -> Self {
        Self { until: now.after(options.travel_timeout().into()), ask: Some(pause(now, options)), rested: false }
    }
}

fn pause(now: Millis, options: &Options) -> Millis {
    now.after(options.pause().into())
}

impl Run {
    /// The run that a message begins, and the first request; `None` if the message begins none.
    ///
    /// A shot of a loaded move goes to its frame first: its message alone moves only blurred motors on some devices (decision
    /// D-77).
    pub(super) fn new(begin: Request, message: &HostMessage<'_>, is_loaded: bool) -> Option<(Self, Request)> {
        let goal = match message {
            HostMessage::RtPositionFrame(_) | HostMessage::RtJogAll(_) => Goal::Travel,
            HostMessage::RtRunMove(run) => {
                let flags = run.flags.unwrap_or_default();
                let loops = flags.intersects(RunFlags::LOOP | RunFlags::PING_PONG);
                Goal::Run { start: run.start_frame, lasts: lasts(run), loops }
            }
            HostMessage::RtShootFrame(shot) => Goal::Shot { lasts: shot.exposure_ms.0.into() },
            HostMessage::RtShootFrame2(shot) => Goal::Shot { lasts: shot.exposure_ms.0.into() },
            _ => return None,
        };
        let start = match (goal, message) {
            (Goal::Run { start, .. }, _) => Some(start),
            (_, HostMessage::RtShootFrame(shot)) if is_loaded => Some(shot.frame),
            (_, HostMessage::RtShootFrame2(shot)) if is_loaded => Some(shot.frame),
            _ => None,
        };
        let (phase, first) = start.map_or((Phase::Begins, begin), |start| {
            (Phase::ToStart, Request::own(Owner::Sequence, Contents::ToFrame(start)))
        });
        Some((Self { goal, begin, opens_shutter: message.opens_shutter(), phase, go: None, is_doubtful: false }, first))
    }

    /// Whether the device may have opened the shutter for the run, and may leave it open after this end (decision D-86). A
    /// device that refuses the message of the run itself has not opened it.
    pub(super) const fn may_leave_shutter_open(&self, end: &Outcome<'_>) -> bool {
        let may_have_begun = match self.phase {
            Phase::ToStart | Phase::Watch(_, Then::Begin) => false,
            Phase::Begins => !matches!(end, Outcome::Refused(_)),
            _ => true,
        };
        self.opens_shutter && may_have_begun && !matches!(end, Outcome::Done(_))
    }

    /// Whether all that moves motors was sent and answered: nothing more is sent except questions.
    pub(super) const fn is_under_way(&self) -> bool {
        matches!(self.phase, Phase::Runs(_) | Phase::Watch(_, Then::End))
    }

    pub(super) const fn progress(&self) -> Progress {
        match self.phase {
            Phase::ToStart => Progress::ToStart,
            Phase::Watch(_, Then::Begin) => Progress::Travels,
            Phase::Begins => Progress::Begins,
            Phase::Watch(_, Then::Arm) => Progress::PreRoll,
            Phase::Armed => Progress::Armed,
            Phase::Goes(..) => Progress::Goes,
            Phase::Runs(_) => Progress::Runs,
            Phase::Watch(_, Then::End) => Progress::Ends,
        }
    }

    /// Next step after an answer.
    pub(super) fn answered(&mut self, now: Millis, options: &Options, token: Token, reply: &Reply<'_>) -> Next {
        match (&mut self.phase, reply) {
            // The run has started already, or is not ready after all: safety decision 2.
            (Phase::Goes(refused, again), Reply::Refused(AckCode::ERR_NOT_IN_POSITION)) if *refused < TRIES => {
                *refused = refused.saturating_add(1);
                *again = Some(pause(now, options));
                Next::Wait
            }
            (_, Reply::Refused(code)) => Next::End(Outcome::Refused(Refusal::Device(*code))),
            (_, Reply::Unclear) => Next::End(Outcome::NotConfirmed),
            (Phase::ToStart, _) => self.watch(now, options, Then::Begin),
            (Phase::Begins, _) => {
                let then = if self.begin.arms() { Then::Arm } else { Then::End };
                self.watch(now, options, then)
            }
            (Phase::Watch(watch, then), reply) if reply.rests() => {
                // A device may rest for a moment between two ways, so it has to rest twice. The way to the first frame is
                // an exception: the request after it is refused if motors still move.
                if watch.rested || *then == Then::Begin {
                    self.rests(token)
                } else {
                    (watch.rested, watch.ask) = (true, Some(pause(now, options)));
                    Next::Wait
                }
            }
            (Phase::Watch(watch, _), _) => {
                (watch.rested, watch.ask) = (false, Some(pause(now, options)));
                Next::Wait
            }
            (Phase::Goes(..), _) => self.started(now, token),
            (Phase::Armed | Phase::Runs(_), _) => Next::Wait,
        }
    }

    fn watch(&mut self, now: Millis, options: &Options, then: Then) -> Next {
        self.phase = Phase::Watch(Watch::new(now, options), then);
        Next::Wait
    }

    fn rests(&mut self, token: Token) -> Next {
        match self.phase {
            Phase::Watch(_, Then::Begin) => {
                self.phase = Phase::Begins;
                Next::Ask(self.begin)
            }
            Phase::Watch(_, Then::Arm) => {
                self.phase = Phase::Armed;
                Next::Tell(Event::Armed(token))
            }
            _ if self.is_doubtful => Next::End(Outcome::NotConfirmed),
            _ => Next::End(Outcome::Done(None)),
        }
    }

    /// A motor that is driven by hand moves to a position. Some devices end what runs by that, and do not tell its end
    /// (decision D-98).
    pub(super) fn motor_moves(&mut self) {
        self.is_doubtful |= matches!(self.phase, Phase::Goes(..) | Phase::Runs(_));
    }

    /// The application gives the signal to start. Returns `None` if nothing waits for it.
    pub(super) fn go(&mut self, token: Token) -> Option<Request> {
        if self.phase != Phase::Armed {
            return None;
        }
        self.phase = Phase::Goes(0, None);
        self.go = Some(token);
        Some(Request::own(Owner::Sequence, Contents::Go))
    }

    /// Takes the token of the signal to start, once the run has started.
    pub(super) fn signal_done(&mut self) -> Option<Token> {
        self.go.take_if(|_| !matches!(self.phase, Phase::Goes(..)))
    }

    /// Token of the signal to start, if that has not ended.
    pub(super) const fn signal(&self) -> Option<Token> {
        self.go
    }

    fn started(&mut self, now: Millis, token: Token) -> Next {
        self.phase = Phase::Runs(self.end(now));
        Next::Tell(Event::Started(token))
    }

    /// Time at which the run should be over; of a loop, the pass.
    fn end(&self, now: Millis) -> Millis {
        match self.goal {
            Goal::Run { lasts, .. } => now.after(lasts).after(PATIENCE),
            Goal::Shot { lasts } => now.after(lasts).after(SHOT),
            // A way to a frame never runs.
            Goal::Travel => now.after(PATIENCE),
        }
    }

    /// The device tells where its motors are. As long as it does, a loop goes on.
    pub(super) fn position_received(&mut self, now: Millis) {
        if self.loops() && matches!(self.phase, Phase::Runs(_)) {
            self.phase = Phase::Runs(self.end(now));
        }
    }

    const fn loops(&self) -> bool {
        matches!(self.goal, Goal::Run { loops: true, .. })
    }

    /// The device takes the pass that runs, or will run, as the last one. Before it knew of the run, it took nothing.
    pub(super) fn loop_ends(&mut self, now: Millis) {
        if matches!(self.progress(), Progress::ToStart | Progress::Travels | Progress::Begins) {
            return;
        }
        if let Goal::Run { loops, .. } = &mut self.goal {
            *loops = false;
        }
        if matches!(self.phase, Phase::Runs(_)) {
            self.phase = Phase::Runs(self.end(now));
        }
    }

    /// Next step after what the device tells by itself; `None` if that does not concern the run.
    pub(super) fn unsolicited(
        &mut self,
        now: Millis,
        options: &Options,
        token: Token,
        message: &DeviceMessage<'_>,
    ) -> Option<Next> {
        match (message, self.phase) {
            (DeviceMessage::RtGo(_), Phase::Watch(_, Then::Arm) | Phase::Armed | Phase::Goes(..)) => {
                Some(self.started(now, token))
            }
            // A pass that ends has begun.
            (DeviceMessage::RtEnd(_), Phase::Goes(..)) if self.loops() => Some(self.started(now, token)),
            (DeviceMessage::RtEnd(_), Phase::Runs(_)) if self.loops() => {
                self.is_doubtful = false;
                self.position_received(now);
                Some(Next::Tell(Event::PassEnded(token)))
            }
            (DeviceMessage::RtEnd(_), Phase::Goes(..) | Phase::Runs(_)) => {
                self.is_doubtful = false;
                Some(self.watch(now, options, Then::End))
            }
            (DeviceMessage::RtEnd(_), Phase::Watch(_, Then::End)) if self.is_doubtful && !self.loops() => {
                self.is_doubtful = false;
                Some(self.watch(now, options, Then::End))
            }
            _ => None,
        }
    }

    /// Next step at a deadline.
    pub(super) fn due(&mut self, now: Millis, options: &Options) -> Next {
        match &mut self.phase {
            Phase::Watch(watch, _) if watch.until <= now => Next::End(Outcome::NotConfirmed),
            Phase::Watch(watch, _) if watch.ask.is_some_and(|ask| ask <= now) => {
                watch.ask = None;
                Next::Ask(Request::own(Owner::Sequence, Contents::Status))
            }
            Phase::Goes(_, again) if again.is_some_and(|again| again <= now) => {
                *again = None;
                Next::Ask(Request::own(Owner::Sequence, Contents::Go))
            }
            Phase::Runs(until) if *until <= now => self.watch(now, options, Then::End),
            _ => Next::Wait,
        }
    }

    pub(super) fn wake(&self) -> Option<Millis> {
        match self.phase {
            Phase::Watch(Watch { until, ask, .. }, _) => Some(ask.map_or(until, |ask| ask.min(until))),
            Phase::Goes(_, again) => again,
            Phase::Runs(until) => Some(until),
            Phase::ToStart | Phase::Begins | Phase::Armed => None,
        }
    }
}

/// Duration of one pass of a run, in milliseconds.
fn lasts(run: &RtRunMove<'_>) -> u64 {
    let frames = u64::from(run.start_frame.0.abs_diff(run.end_frame.0)).saturating_add(1);
    let millis = frames.saturating_mul(1_000_000).checked_div(run.fps_x1000.0.0.into()).unwrap_or(0);
    millis.saturating_add(run.pre_roll_ms.0.into()).saturating_add(run.post_roll_ms.0.into())
}
