//! Answer of the rig to a request if it were done now. It depends on the limits that were set, and on pre-rolls.

use dmc_proto::device::{Quirks, State};
use dmc_proto::message::{AckCode, FrameNumber, HostMessage, Motor, MotorFlags, RunFlags};

use super::core::Core;
use super::index;
use super::job::{Habits, Job, Kind};

impl Core {
    /// Code for a request: `OK`, or the reason why the rig cannot do it.
    pub(super) fn judge(&self, message: &HostMessage<'_>) -> AckCode {
        let ignores_limits = self.setup.facts.ignores_limits;
        let refused = match message {
            HostMessage::MotorMove(_) | HostMessage::RtPositionFrame(_) | HostMessage::RtJogAll(_)
                if ignores_limits =>
            {
                None
            }
            HostMessage::RtShootFrame(_) | HostMessage::RtShootFrame2(_) if ignores_limits => None,
            HostMessage::MotorMove(it) => self.beyond(it.motor, it.position.0.into()),
            HostMessage::RtPositionFrame(it) => {
                let mut positions = self.axes().map(|motor| (motor, self.store.position(motor, it.frame)));
                positions.find_map(|(motor, at)| self.beyond(motor, at?.into()))
            }
            // The machine refuses a jog while other motors move, and a run from no frame, so that no check is needed.
            HostMessage::RtJogAll(it) if matches!(self.state, State::Idle | State::JogAll) => {
                self.beyond_along(it.destination)
            }
            HostMessage::RtRunMove(_) if self.stood_on.is_none() => None,
            _ if self.state == State::Idle => {
                let job = self.job(message);
                job.and_then(|job| self.beyond_job(&job))
            }
            _ => None,
        };
        refused.unwrap_or(AckCode::OK)
    }

    /// Number of motors.
    pub(super) fn count(&self) -> u8 {
        u8::try_from(self.motors.len()).unwrap_or(u8::MAX)
    }

    /// Motors of the uploaded move that are enabled, except those that are driven by hand.
    pub(super) fn axes(&self) -> impl Iterator<Item = Motor> {
        (1..=self.count())
            .map(Motor)
            .filter(|motor| self.store.has(*motor) && self.has_use(*motor, MotorFlags::ENABLED))
            .filter(|motor| !self.has_use(*motor, MotorFlags::LIVE))
    }

    /// Whether a motor has a use.
    fn has_use(&self, motor: Motor, flag: MotorFlags) -> bool {
        let tuning = index(motor).and_then(|index| self.tuning.get(index));
        tuning.is_some_and(|tuning| tuning.flags.contains(flag))
    }

    /// Run or shot of a message.
    pub(super) fn job(&self, message: &HostMessage<'_>) -> Option<Job> {
        let blurs = |motor| self.has_use(motor, MotorFlags::ENABLED | MotorFlags::BLUR);
        let axes: Vec<_> = self.axes().collect();
        let along = if self.setup.facts.blurs_along_move { &axes[..] } else { &[] };
        let habits = Habits {
            vendor_shots: self.setup.facts.vendor_shots,
            passes_end: self.setup.options.quirks().contains(Quirks::RESTS_BEYOND),
        };
        Job::of(message, &self.store, (&axes, along), blurs, habits)
    }

    /// Code for a position of a motor that is beyond a limit that was set.
    fn beyond(&self, motor: Motor, position: f64) -> Option<AckCode> {
        let tuning = self.tuning.get(index(motor)?)?;
        if tuning.upper.is_some_and(|upper| position > f64::from(upper.0)) {
            return Some(AckCode::ERR_SOFT_UP);
        }
        tuning.lower.is_some_and(|lower| position < f64::from(lower.0)).then_some(AckCode::ERR_SOFT_LOW)
    }

    /// Code for the way to a frame, if it leads beyond a limit.
    fn beyond_along(&self, to: FrameNumber) -> Option<AckCode> {
        let from = super::steps(self.moment().or(self.stood_on.map(|frame| f64::from(frame.0)))?);
        self.store.position(self.axes().next()?, to)?;
        let frames = from.min(to.0)..=from.max(to.0);
        let mut places = frames.flat_map(|frame| self.axes().map(move |motor| (motor, FrameNumber(frame))));
        places.find_map(|(motor, frame)| self.beyond(motor, self.store.position(motor, frame)?.into()))
    }

    /// Code for a run or a shot, if it leads beyond a limit.
    fn beyond_job(&self, job: &Job) -> Option<AckCode> {
        let spans = job.ways.iter().map(|way| (way.motor, way.span(job, &self.store)));
        let mut ends = spans.flat_map(|(motor, (least, most))| [(motor, least), (motor, most)]);
        if !self.setup.facts.ignores_limits
            && let Some(code) = ends.find_map(|(motor, position)| self.beyond(motor, position))
        {
            return Some(code);
        }
        // In a run back and forth, a pass begins and a pass ends at each end.
        let there_and_back = matches!(job.kind, Kind::Run { flags, .. } if flags.contains(RunFlags::PING_PONG));
        let (up, down) = if there_and_back { (job.up.max(job.down), job.up.max(job.down)) } else { (job.up, job.down) };
        let is_beyond = |motor: Motor, at: f64| !is_step(at) || self.beyond(motor, at).is_some();
        if job.ways.iter().any(|way| is_beyond(way.motor, way.before(up))) {
            return Some(AckCode::ERR_PREROLL);
        }
        let is_after = job.ways.iter().any(|way| is_beyond(way.motor, way.after(down)));
        is_after.then_some(AckCode::ERR_POSTROLL)
    }
}

/// Whether a position fits a number of steps.
fn is_step(position: f64) -> bool {
    (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&position)
}
