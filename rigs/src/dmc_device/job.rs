//! Runs and shots: the way of each motor, with its acceleration from rest and its deceleration to rest.

use dmc_proto::message::{Direction, FrameNumber, HostMessage, Motor, MotorPair, RtRunMove, RunFlags, Steps};

use super::store::Store;
use crate::motor::Place;

/// Time in which motors reach their speed before a shutter opens, and come to rest after it closes, in seconds.
const SHOT_ROLL: f64 = 0.25;
/// The same time of dmc-lite.
const VENDOR_ROLL: f64 = 1.0;

/// Habits of a device in its runs and shots.
#[derive(Debug, Clone, Copy)]
pub(super) struct Habits {
    /// See [`Facts::vendor_shots`](super::Facts::vendor_shots).
    pub(super) vendor_shots: bool,
    /// Whether a run goes one frame beyond its last one, if the move has it.
    pub(super) passes_end: bool,
}

/// Run or shot.
#[derive(Debug, Clone)]
pub(super) struct Job {
    pub(super) kind: Kind,
    /// Frame where the pass begins.
    pub(super) from: i32,
    /// Frame where the pass ends.
    pub(super) to: i32,
    /// Speed in frames per second.
    pub(super) rate: f64,
    /// Duration of a pass, in seconds.
    pub(super) seconds: f64,
    /// Time in which the motors reach their speed, in seconds.
    pub(super) up: f64,
    /// Time in which the motors come to rest, in seconds.
    pub(super) down: f64,
    /// Time in the move that the device tells after the pass, in frames.
    pub(super) film: f64,
    /// Ways of the motors that take part.
    pub(super) ways: Vec<Way>,
}

#[derive(Debug, Clone)]
pub(super) enum Kind {
    Run {
        /// Whether lights and outputs follow the move.
        sync: bool,
        flags: RunFlags,
        /// Time for which the shutter is open at each frame, in milliseconds; `None` if it does not open.
        shutter: Option<u64>,
    },
    Shot {
        /// Time for which the shutter is open, in milliseconds.
        exposure: u64,
        /// Time from the start until the shutter opens, in seconds; `None` if the shutter opens when the pass begins.
        opens: Option<f64>,
    },
}

/// Way of one motor in a pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    pub(super) motor: Motor,
    /// First and last position; `None` if the motor follows the uploaded move.
    own: Option<(f64, f64)>,
    begin: Place,
    end: Place,
}

impl Job {
    /// Run or shot of a message; `None` for other messages, and for frames outside the uploaded move. `axes` are the motors
    /// that follow the move. In a shot only the motors move that blur: on the ways of the message, or if it has none, those
    /// of `along` on the way of the uploaded move.
    pub(super) fn of(
        message: &HostMessage<'_>,
        store: &Store,
        (axes, along): (&[Motor], &[Motor]),
        blurs: impl Fn(Motor) -> bool,
        habits: Habits,
    ) -> Option<Self> {
        let vendor = habits.vendor_shots;
        let mut job = match message {
            HostMessage::RtRunMove(run) => Self::run(run, store, habits.passes_end),
            HostMessage::RtShootFrame(shot) => {
                let part = if shot.blur_x10.0.0 == 0 { 1.0 } else { f64::from(shot.blur_x10.0.0.min(1000)) / 1000.0 };
                let goes_back = shot.direction == Direction::BACKWARD;
                // dmc-lite shoots the middle of the way, and goes backwards only along the uploaded move.
                let is_back = goes_back && (!vendor || shot.motors.is_empty());
                let (first, last) =
                    if vendor { (f64::midpoint(1.0, -part), f64::midpoint(1.0, part)) } else { (0.0, part) };
                let (from, to) = if is_back { (last, first) } else { (first, last) };
                let pairs = pairs(shot.frame, shot.motors, store, along, &blurs);
                let job = Self::shot(shot.frame, shot.exposure_ms.0, (from, to), &pairs);
                let film = f64::from(shot.frame.0) + (to - from) / 2.0;
                if vendor { Self { up: VENDOR_ROLL, down: VENDOR_ROLL, film, ..job } } else { job }
            }
            HostMessage::RtShootFrame2(shot) => {
                // The vendor's firmware takes a second for no exposure (decision D-27).
                let exposure = if shot.exposure_ms.0 == 0 { 1000 } else { shot.exposure_ms.0 };
                let part = |angle: u16| f64::from(angle) / 360.0;
                let pairs = pairs(shot.frame, shot.motors, store, along, &blurs);
                let (open, close) = (part(shot.open_angle.0), part(shot.close_angle.0));
                if vendor && close > open {
                    Self::whole_turn(shot.frame, exposure, (open, close), &pairs)
                } else {
                    Self::shot(shot.frame, exposure, (open, close), &pairs)
                }
            }
            _ => return None,
        };
        let is_shot = matches!(job.kind, Kind::Shot { .. });
        for &motor in axes.iter().filter(|_| !(is_shot && vendor)) {
            if job.ways.iter().any(|way| way.motor == motor) {
                continue;
            }
            job.ways.push(Way { motor, own: None, begin: Place::default(), end: Place::default() });
        }
        job.find_ends(store)?;
        Some(job)
    }

    fn run(run: &RtRunMove<'_>, store: &Store, passes_end: bool) -> Self {
        let (from, asked) = (run.start_frame.0, run.end_frame.0);
        let to = if passes_end { beyond(asked, store) } else { asked };
        let rate = f64::from(run.fps_x1000.0.0.max(1)) / 1000.0;
        let flags = run.flags.unwrap_or_default();
        let angle = |angle: Option<_>| angle.map_or(0.0, |degrees: dmc_proto::message::Degrees| f64::from(degrees.0));
        let open = ((angle(run.close_angle) - angle(run.open_angle)) / 360.0 / rate).max(0.0);
        let shutter = flags.contains(RunFlags::CAMERA_EVERY_FRAME).then(|| super::millis(open));
        let seconds = |millis: u32| f64::from(millis) / 1000.0;
        Self {
            kind: Kind::Run { sync: run.sync_dmx.get(), flags, shutter },
            from,
            to,
            rate,
            seconds: (f64::from(to) - f64::from(from)).abs() / rate,
            up: seconds(run.pre_roll_ms.0),
            down: seconds(run.post_roll_ms.0),
            film: f64::from(asked) + f64::from(u8::from(passes_end)),
            ways: Vec::new(),
        }
    }

    fn shot(frame: FrameNumber, exposure: u32, part: (f64, f64), pairs: &[MotorPair]) -> Self {
        let mut ways: Vec<Way> = Vec::new();
        for pair in pairs {
            let (a, b) = (f64::from(pair.pos_a().0), f64::from(pair.pos_b().0));
            let at = |part: f64| a + (b - a) * part;
            let own = Some((at(part.0), at(part.1)));
            let way = Way { motor: pair.motor(), own, begin: Place::default(), end: Place::default() };
            // If a motor is named twice, the later pair counts.
            ways.retain(|other| other.motor != way.motor);
            ways.push(way);
        }
        Self {
            kind: Kind::Shot { exposure: exposure.into(), opens: None },
            from: frame.0,
            to: frame.0,
            rate: 0.0,
            seconds: f64::from(exposure) / 1000.0,
            up: SHOT_ROLL,
            down: SHOT_ROLL,
            film: frame.0.into(),
            ways,
        }
    }

    /// Shot in which motors go all the way between their positions, in the time of a whole turn of the shutter, and rest at
    /// both. The angles only decide when the shutter is open.
    fn whole_turn(frame: FrameNumber, exposure: u32, (open, close): (f64, f64), pairs: &[MotorPair]) -> Self {
        let turn = f64::from(exposure) / 1000.0 / (close - open);
        // In an eighth of the time, a motor that accelerates evenly comes to a fourteenth of the way.
        let job = Self::shot(frame, exposure, (1.0 / 14.0, 13.0 / 14.0), pairs);
        let kind = Kind::Shot { exposure: exposure.into(), opens: Some(open * turn) };
        let (roll, seconds) = (turn / 8.0, turn * 0.75);
        Self { kind, seconds, up: roll, down: roll, film: 0.125 + seconds, ..job }
    }

    /// Continues with another pass.
    pub(super) fn turn(&mut self, from: i32, to: i32, store: &Store) {
        (self.from, self.to, self.film) = (from, to, to.into());
        // The frames were checked before the first pass.
        let _ = self.find_ends(store);
    }

    /// Finds the first and the last position and speed of each motor in a pass; `None` if a frame is outside the move.
    fn find_ends(&mut self, store: &Store) -> Option<()> {
        let (from, to, rate, seconds) = (self.from, self.to, self.rate, self.seconds);
        let way = to.saturating_sub(from).signum();
        for each in &mut self.ways {
            (each.begin, each.end) = if let Some((begin, end)) = each.own {
                let velocity = if seconds > 0.0 { (end - begin) / seconds } else { 0.0 };
                (Place { position: begin, velocity }, Place { position: end, velocity })
            } else {
                let at = |frame: i32| store.position(each.motor, FrameNumber(frame)).map(f64::from);
                let (begin, end) = (at(from)?, at(to)?);
                let first = (at(from.saturating_add(way))? - begin) * rate;
                let last = (end - at(to.saturating_sub(way))?) * rate;
                (Place { position: begin, velocity: first }, Place { position: end, velocity: last })
            };
        }
        Some(())
    }

    /// Frame, with its fraction, that a pass reaches after a time in seconds.
    pub(super) fn moment(&self, seconds: f64) -> f64 {
        let (from, to) = (f64::from(self.from), f64::from(self.to));
        let gone = seconds * self.rate;
        if gone >= (to - from).abs() { to } else { from + gone * (to - from).signum() }
    }

    /// Position and speed of a motor in a pass, after a time in seconds.
    pub(super) fn along(&self, way: &Way, seconds: f64, store: &Store) -> Place {
        if seconds >= self.seconds {
            return way.end;
        }
        if way.own.is_some() {
            return Place { position: way.begin.position + way.begin.velocity * seconds, ..way.begin };
        }
        let moment = self.moment(seconds);
        let back = self.to < self.from;
        // At a frame the motor has its speed up to the next frame.
        let (before, after) =
            if back { (moment.ceil(), moment.ceil() - 1.0) } else { (moment.floor(), moment.floor() + 1.0) };
        let at = |moment: f64| store.between(way.motor, moment).unwrap_or(way.end.position);
        Place { position: at(moment), velocity: (at(after) - at(before)) * self.rate }
    }
}

/// Frame after the last one of a run; the last one itself if the move ends there.
pub(super) fn beyond(to: i32, store: &Store) -> i32 {
    let next = to.saturating_add(1);
    if store.has_frame(FrameNumber(next)) { next } else { to }
}

/// Ways of the motors that blur in a shot of a frame.
fn pairs(
    frame: FrameNumber,
    given: &[MotorPair],
    store: &Store,
    axes: &[Motor],
    blurs: impl Fn(Motor) -> bool,
) -> Vec<MotorPair> {
    if !given.is_empty() {
        return given.iter().copied().filter(|pair| blurs(pair.motor())).collect();
    }
    // The shutter is open from half a frame before the frame to half a frame after it, within the move (decision D-88).
    let way = |&motor: &Motor| {
        store.position(motor, frame)?;
        let at = |moment: f64| store.between(motor, moment).map(|place| Steps(super::steps(place)));
        let frame = f64::from(frame.0);
        Some(MotorPair::new(motor, at(frame - 0.5)?, at(frame + 0.5)?))
    };
    axes.iter().filter(|motor| blurs(**motor)).filter_map(way).collect()
}

impl Way {
    /// Position at which the motor rests before it accelerates for a time in seconds.
    pub(super) fn before(&self, up: f64) -> f64 {
        self.begin.position - self.begin.velocity * up / 2.0
    }

    /// Position at which the motor comes to rest after its end.
    pub(super) fn after(&self, down: f64) -> f64 {
        self.end.position + self.end.velocity * down / 2.0
    }

    /// Whether the motor has a way of its own, and does not follow the uploaded move.
    pub(super) const fn is_own(&self) -> bool {
        self.own.is_some()
    }

    /// Position and speed at the start of the pass.
    pub(super) const fn begin(&self) -> Place {
        self.begin
    }

    /// Position and speed after a part of the acceleration, in seconds. The acceleration is constant.
    pub(super) fn rolls_up(&self, up: f64, seconds: f64) -> Place {
        let part = seconds / up;
        let velocity = self.begin.velocity * part;
        Place { position: self.before(up) + velocity * seconds / 2.0, velocity }
    }

    /// Position and speed after a part of the deceleration, in seconds.
    pub(super) fn rolls_down(&self, down: f64, seconds: f64) -> Place {
        if seconds >= down {
            return Place { position: self.after(down), velocity: 0.0 };
        }
        let velocity = self.end.velocity * (1.0 - seconds / down);
        Place { position: self.end.position + seconds * f64::midpoint(self.end.velocity, velocity), velocity }
    }

    /// Least and greatest position of a pass, without acceleration and deceleration.
    pub(super) fn span(&self, job: &Job, store: &Store) -> (f64, f64) {
        let frames = (job.from.min(job.to)..=job.from.max(job.to)).filter(|_| self.own.is_none());
        let between = frames.filter_map(|frame| store.position(self.motor, FrameNumber(frame))).map(f64::from);
        let ends = [self.begin.position, self.end.position];
        between.chain(ends).fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), at| (least.min(at), most.max(at)))
    }
}
