//! What moves all motors together, from the first request to rest: DMC D5.

use motion_core::time::Millis;

use super::io::{Event, Failure, Token, What};
use super::options::{Options, PATIENCE, TRIES};
use super::requests::{Owner, Request, Role};
use super::sequence::{Next, Progress, Reply};
use crate::message::{AckCode, DeviceMessage, FrameNumber, HostMessage, Motors, RtRunMove, RunFlags};

/// A move to a frame, a jog of all motors, a run or a shot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Run {
    goal: Goal,
    /// The application's message.
    begin: Request,
    phase: Phase,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Goal {
    /// To be at rest at a frame.
    Travel,
    /// To run from a frame, for so many milliseconds or a multiple of it.
    Run { start: FrameNumber, lasts: u64, loops: bool },
    /// To shoot, for so many milliseconds.
    Shot { lasts: u64 },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Phase {
    /// The request for the first frame is on its way.
    ToStart,
    /// The application's message is on its way.
    Begins,
    /// It is asked whether motors still move.
    Watch(Watch, Then),
    /// The device waits for the signal to start.
    Ready,
    /// The signal is on its way, or waits to be given again, for the how manieth time.
    Goes(u8, Option<Millis>),
    /// It runs. Should its end not be told, it is asked for then.
    Runs(Millis),
}

/// What comes when all motors stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Then {
    Begin,
    Ready,
    Done,
}

/// Asking until motors stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Watch {
    /// When to give up.
    until: Millis,
    /// When to ask next; `None` while an answer is on its way.
    ask: Option<Millis>,
    /// Whether they stood when asked last.
    stood: bool,
}

impl Watch {
    fn new(now: Millis, options: &Options) -> Self {
        Self { until: now.after(options.times.travel.into()), ask: Some(pause(now, options)), stood: false }
    }
}

fn pause(now: Millis, options: &Options) -> Millis {
    now.after(options.times.pause.into())
}

impl Run {
    /// What a message begins, and what is asked first; `None` if it begins nothing.
    pub(super) fn new(begin: Request, message: &HostMessage<'_>) -> Option<(Self, Request)> {
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
        let (phase, first) = match goal {
            Goal::Run { start, .. } => (Phase::ToStart, Request::own(Owner::Sequence, What::ToFrame(start))?),
            Goal::Travel | Goal::Shot { .. } => (Phase::Begins, begin),
        };
        Some((Self { goal, begin, phase }, first))
    }

    /// Whether all that moves motors has been asked and answered: nothing more is sent but questions.
    pub(super) const fn is_under_way(&self) -> bool {
        matches!(self.phase, Phase::Runs(_) | Phase::Watch(_, Then::Done))
    }

    /// Whether a run or a shot waits for the signal to start.
    pub(super) const fn is_ready(&self) -> bool {
        matches!(self.phase, Phase::Ready)
    }

    /// How far it is.
    pub(super) const fn progress(&self) -> Progress {
        match self.phase {
            Phase::ToStart => Progress::ToStart,
            Phase::Watch(_, Then::Begin) => Progress::Travels,
            Phase::Begins => Progress::Begins,
            Phase::Watch(_, Then::Ready) => Progress::PreRoll,
            Phase::Ready => Progress::Ready,
            Phase::Goes(..) => Progress::Goes,
            Phase::Runs(_) => Progress::Runs,
            Phase::Watch(_, Then::Done) => Progress::Ends,
        }
    }

    /// What follows from an answer.
    pub(super) fn answered(&mut self, now: Millis, token: Token, reply: Reply, options: &Options) -> Next {
        match (&mut self.phase, reply) {
            // It has started already, or is not ready after all: safety decision 2.
            (Phase::Goes(asked, again), Reply::Failed(Failure::Refused(AckCode::ERR_NOT_IN_POSITION)))
                if *asked < TRIES =>
            {
                *asked = asked.saturating_add(1);
                *again = Some(pause(now, options));
                Next::Wait
            }
            (_, Reply::Failed(failure)) => Next::Failed(failure),
            (Phase::ToStart, _) => self.watch(now, Then::Begin, options),
            (Phase::Begins, _) => {
                let then = if self.begin.conduct.role == Role::Arms { Then::Ready } else { Then::Done };
                self.watch(now, then, options)
            }
            (Phase::Watch(watch, then), Reply::Moving(Motors::NONE)) => {
                // A device may stand for a moment between two ways: it has to stand twice, but for the way to the first
                // frame, which is followed by a request that the device refuses if it still moves.
                if watch.stood || *then == Then::Begin {
                    self.stands(token)
                } else {
                    (watch.stood, watch.ask) = (true, Some(pause(now, options)));
                    Next::Wait
                }
            }
            (Phase::Watch(watch, _), _) => {
                (watch.stood, watch.ask) = (false, Some(pause(now, options)));
                Next::Wait
            }
            (Phase::Goes(..), _) => self.started(now, token),
            (Phase::Ready | Phase::Runs(_), _) => Next::Wait,
        }
    }

    fn watch(&mut self, now: Millis, then: Then, options: &Options) -> Next {
        self.phase = Phase::Watch(Watch::new(now, options), then);
        Next::Wait
    }

    fn stands(&mut self, token: Token) -> Next {
        match self.phase {
            Phase::Watch(_, Then::Begin) => {
                self.phase = Phase::Begins;
                Next::Ask(self.begin)
            }
            Phase::Watch(_, Then::Ready) => {
                self.phase = Phase::Ready;
                Next::Tell(Event::Ready(token))
            }
            _ => Next::Done,
        }
    }

    /// The application gives the signal to start.
    pub(super) fn go(&mut self) -> Option<Request> {
        if !self.is_ready() {
            return None;
        }
        self.phase = Phase::Goes(0, None);
        Request::own(Owner::Sequence, What::Go)
    }

    fn started(&mut self, now: Millis, token: Token) -> Next {
        self.phase = Phase::Runs(self.end(now));
        Next::Tell(Event::Started(token))
    }

    /// When it should be over; of a loop, when a pass should be.
    fn end(&self, now: Millis) -> Millis {
        match self.goal {
            Goal::Run { lasts, .. } | Goal::Shot { lasts } => now.after(lasts).after(PATIENCE),
            // A way to a frame never runs.
            Goal::Travel => now.after(PATIENCE),
        }
    }

    /// The device tells where its motors are. As long as it does, a loop goes on.
    pub(super) fn heard(&mut self, now: Millis) {
        if self.loops() && matches!(self.phase, Phase::Runs(_)) {
            self.phase = Phase::Runs(self.end(now));
        }
    }

    const fn loops(&self) -> bool {
        matches!(self.goal, Goal::Run { loops: true, .. })
    }

    /// The device takes the pass that runs, or will run, for the last one. Before it knew of the run, it took nothing.
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

    /// What follows from what the device tells unasked; `None` if nothing does.
    pub(super) fn told(
        &mut self,
        now: Millis,
        token: Token,
        message: &DeviceMessage<'_>,
        options: &Options,
    ) -> Option<Next> {
        match (message, self.phase) {
            (DeviceMessage::RtGo(_), Phase::Watch(_, Then::Ready) | Phase::Ready | Phase::Goes(..)) => {
                Some(self.started(now, token))
            }
            // What ends a pass has begun.
            (DeviceMessage::RtEnd(_), Phase::Goes(..)) if self.loops() => Some(self.started(now, token)),
            (DeviceMessage::RtEnd(_), Phase::Runs(_)) if self.loops() => {
                self.heard(now);
                Some(Next::Tell(Event::PassEnded(token)))
            }
            (DeviceMessage::RtEnd(_), Phase::Goes(..) | Phase::Runs(_)) => Some(self.watch(now, Then::Done, options)),
            _ => None,
        }
    }

    /// What has to be done by now.
    pub(super) fn due(&mut self, now: Millis, options: &Options) -> Next {
        match &mut self.phase {
            Phase::Watch(watch, _) if watch.until <= now => Next::Failed(Failure::Timeout),
            Phase::Watch(watch, _) if watch.ask.is_some_and(|ask| ask <= now) => {
                watch.ask = None;
                ask(What::Status)
            }
            Phase::Goes(_, again) if again.is_some_and(|again| again <= now) => {
                *again = None;
                ask(What::Go)
            }
            Phase::Runs(until) if *until <= now => self.watch(now, Then::Done, options),
            _ => Next::Wait,
        }
    }

    pub(super) fn wake(&self) -> Option<Millis> {
        match self.phase {
            Phase::Watch(Watch { until, ask, .. }, _) => Some(ask.map_or(until, |ask| ask.min(until))),
            Phase::Goes(_, again) => again,
            Phase::Runs(until) => Some(until),
            Phase::ToStart | Phase::Begins | Phase::Ready => None,
        }
    }
}

fn ask(what: What) -> Next {
    Request::own(Owner::Sequence, what).map_or(Next::Failed(Failure::Sequence), Next::Ask)
}

/// How long one pass of a run takes, in milliseconds.
fn lasts(run: &RtRunMove<'_>) -> u64 {
    let frames = u64::from(run.start_frame.0.abs_diff(run.end_frame.0)).saturating_add(1);
    let millis = frames.saturating_mul(1_000_000).checked_div(run.fps_x1000.0.0.into()).unwrap_or(0);
    millis.saturating_add(run.pre_roll_ms.0.into()).saturating_add(run.post_roll_ms.0.into())
}
