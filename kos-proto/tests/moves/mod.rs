//! Any bytes as a move, plans of any kind through the builder, and the properties that hold for all of them.

use kos_proto::HostMessage;
use kos_proto::lint::Context;
use kos_proto::message::{
    Motor, MotorAddress, Normalized, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds,
};
use kos_proto::trajectory::bezier::{self, Ease, Key, Motion};
use kos_proto::trajectory::{
    Block, Delay, LiveMotion, Loop, MotorPlan, MoveError, Plan, Play, Points, Style, TimeLapseMotion, Times, Track,
    Trajectory, TrajectoryData, Way,
};
use motion_core::lint::Severity;
use motion_core::wire::Message;

/// Reads any bytes as a move. An accepted move answers every question and can be planned again. A refused move is also
/// refused by lint.
pub(crate) fn read(body: &[u8]) {
    let Ok(data) = TrajectoryData::decode(body) else { return };
    let message = HostMessage::from(data);
    let refused = message.lint(&Context::default()).first_error().is_some();
    let mut again = vec![0; data.encoded_len()];
    assert_eq!((data.encode_into(&mut again), &again[..]), (Ok(body.len()), body));
    match Trajectory::new(&data) {
        Ok(trajectory) => examine(&trajectory),
        Err(error) => {
            assert!(refused || matches!(error, MoveError::Unnamed { .. }), "{error}");
            assert!(format!("{error:?}").len() < 300);
        }
    }
}

/// Times at which every answer must be finite.
const TIMES: [f64; 9] = [f64::NAN, f64::NEG_INFINITY, -1.0, 0.0, 1e-9, 0.3, 1.0, 7.0, f64::INFINITY];

fn examine(trajectory: &Trajectory<'_>) {
    let play = trajectory.play();
    assert!(play.move_time().is_finite() && play.playing_time() <= play.total_time().or(Some(f64::INFINITY)));
    for time in TIMES {
        assert!((0.0..=1.0).contains(&play.elapsed_at(time)), "{time}");
    }
    let motor = |motor_address| Motor {
        motor_address,
        position: Rotations(0.0),
        begin_position: None,
        end_position: Rotations(-50.0),
        max_max_setup_speed: RotationsPerSecond(0.0),
        max_max_move_speed: RotationsPerSecond(20.0),
        max_max_acceleration: RotationsPerSecondSquared(40.0),
    };
    let motors: Vec<_> = trajectory.tracks().map(|track| motor(track.motor())).collect();
    for track in trajectory.tracks() {
        assert_eq!(trajectory.track(track.motor()), Some(track));
        asked(&track);
        for range in [50.0, -0.001, f32::MAX, f32::MIN_POSITIVE] {
            if let Ok(track) = track.in_rotations(Rotations(range)) {
                asked(&track);
            }
        }
    }
    assert!(trajectory.excesses(&Context::default().with_motors(&motors)).all(|excess| excess.to_string().len() < 200));
    assert_eq!(trajectory.excesses(&Context::default()).count(), motors.len());
    planned_again(trajectory);
}

fn asked(track: &Track<'_>) {
    let finite = |rate: Option<f64>| rate.is_none_or(f64::is_finite);
    for time in TIMES {
        let at = track.at(time);
        assert_eq!(at.is_none(), track.is_empty());
        if let Some(Motion { position, velocity, acceleration }) = at {
            assert!(position.is_finite() && finite(velocity) && finite(acceleration), "{time}");
        }
    }
    assert_eq!(track.segments().count(), track.len());
    assert_eq!(track.keys().count(), if track.is_empty() { 0 } else { track.len() + 1 });
    let whole = |peak: Option<f64>| peak.is_none_or(|peak| peak.is_finite() && peak >= 0.0);
    assert!(track.peaks().all(|peaks| whole(peaks.speed) && whole(peaks.acceleration)));
}

/// A move that the builder accepts comes back unchanged.
fn planned_again(trajectory: &Trajectory<'_>) {
    let ways: Vec<Vec<bezier::Segment>> = trajectory.tracks().map(|track| track.segments().collect()).collect();
    let motor = |(track, way)| MotorPlan { motor: Track::motor(&track), way: Way::Segments(way) };
    let motors: Vec<_> = trajectory.tracks().zip(ways.iter().map(Vec::as_slice)).map(motor).collect();
    let mut out = [0; Plan::MAX_LEN];
    let how = trajectory.play();
    let plan = if motors.is_empty() { Plan::without_motors(how) } else { Plan::new(how, &motors) };
    let Ok(data) = plan.encode(&mut out) else { return };
    only_asked_for(&plan, &data);
    let again = Trajectory::new(&data).expect("just planned");
    assert_eq!(again.play(), how);
    for (one, other) in again.tracks().zip(trajectory.tracks()) {
        assert_eq!(one.motor().number(), other.motor().number());
        assert!(one.segments().zip(other.segments()).all(|(one, other)| near(&one, &other, 1.0, 1.0)));
    }
}

/// Law 14: lint finds only the options that were asked for.
fn only_asked_for(plan: &Plan<'_>, data: &TrajectoryData<'_>) {
    let (how, mut wanted) = (plan.play(), Vec::new());
    if let Play::Live(LiveMotion { duration, repeat: Loop::RapidReverse { duration: Some(other), .. }, .. }) = how {
        wanted.extend((other != duration).then_some((Severity::Warning, "rapid_reverse_duration")));
    }
    if let Delay::UntilFloat(_) = how.delay() {
        wanted.push((Severity::Warning, "delay_interval_bits"));
    }
    if *plan == Plan::without_motors(how) {
        wanted.push((Severity::Error, "axis"));
    }
    let lints = HostMessage::from(*data).lint(&Context::default());
    let found: Vec<_> = lints.into_iter().map(|lint| (lint.severity, lint.what)).collect();
    assert_eq!(found, wanted);
}

/// Whether two curves are equal, except for the rounding of the wire.
fn near(one: &bezier::Segment, other: &bezier::Segment, span: f64, range: f64) -> bool {
    const ROUNDING: f64 = 5e-7;
    let pairs = one.points().into_iter().zip(other.points());
    pairs.into_iter().all(|(one, other)| {
        let scale = range.abs().max(other.position.abs());
        (one.time - other.time).abs() <= ROUNDING * span && (one.position - other.position).abs() <= ROUNDING * scale
    })
}

/// Source of numbers from bytes; 0 after the last byte.
struct Source<'a>(&'a [u8]);

impl Source<'_> {
    fn byte(&mut self) -> u8 {
        let (&first, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        first
    }

    /// A number below `count`.
    fn one_of(&mut self, count: u8) -> u8 {
        self.byte() % count
    }

    /// A number from 0 to 1; both ends come up often.
    fn part(&mut self) -> f64 {
        f64::from(u16::from_be_bytes([self.byte(), self.byte()]).saturating_mul(2)) / 65_535.0
    }

    fn bits(&mut self) -> u32 {
        u32::from_be_bytes([self.byte(), self.byte(), self.byte(), self.byte()])
    }

    /// A number of seconds or rotations, more than 0.
    fn amount(&mut self) -> f32 {
        0.01 + f32::from(u16::from_be_bytes([self.byte(), self.byte()])) / 100.0
    }

    fn times(&mut self) -> Times {
        Times::new(self.byte()).unwrap_or(Times::FOREVER)
    }

    fn play(&mut self) -> Play {
        let home_speed = Normalized(0.01 + f32::from(self.byte()) / 300.0);
        let delay = match self.one_of(4) {
            0 => Delay::None,
            1 => Delay::For(Seconds(self.amount())),
            2 => Delay::Until(self.bits() & 0xf_ffff | 0x6553_0000),
            _ => Delay::UntilFloat(self.bits() & 0xf_ffff | 0x6553_0000),
        };
        let kind = self.one_of(6);
        if kind < 4 {
            let duration = Seconds(self.amount());
            let repeat = match kind {
                0 => Loop::Once,
                1 => Loop::Reverse(self.times()),
                2 => Loop::RapidReverse { times: self.times(), duration: None },
                _ => Loop::RapidReverse { times: self.times(), duration: Some(Seconds(self.amount())) },
            };
            return Play::Live(LiveMotion { duration, repeat, delay, home_speed });
        }
        Play::TimeLapse(TimeLapseMotion {
            style: if kind == 4 { Style::Continuous } else { Style::ShootMoveShoot },
            interval: Seconds(self.amount()),
            exposure: Seconds(self.amount()),
            photos: u32::from(self.byte()) + 1,
            photos_before: self.byte().into(),
            photos_after: self.byte().into(),
            delay,
            home_speed,
        })
    }

    /// Key frames from the start to the end of the move, with handles that stay in the range and in their time.
    fn keys(&mut self, span: f64, range: f64) -> Vec<Key> {
        let lengths: Vec<f64> = (0..=self.one_of(6)).map(|_| 0.001 + self.part()).collect();
        let whole: f64 = lengths.iter().sum();
        let mut keys = vec![self.key(0.0, range)];
        for length in &lengths {
            let time = (keys[keys.len() - 1].time + span * length / whole).min(span);
            keys.push(self.key(time, range));
        }
        let last = keys.len() - 1;
        keys[last].time = span;
        for at in 0..last {
            let (from, to) = (keys[at], keys[at + 1]);
            keys[at].leave = self.ease(from, to, range);
            keys[at + 1].arrive = self.ease(to, from, range);
        }
        keys
    }

    fn key(&mut self, time: f64, range: f64) -> Key {
        Key { time, position: range * self.part(), arrive: Ease::Linear, leave: Ease::Linear }
    }

    fn ease(&mut self, from: Key, to: Key, range: f64) -> Ease {
        match self.one_of(3) {
            0 => Ease::Linear,
            1 => Ease::Flat(self.part() / 2.0),
            _ => {
                let time = (to.time - from.time) * self.part() / 2.0;
                Ease::Handle(bezier::Point::new(time, range * self.part() - from.position))
            }
        }
    }
}

/// Checks a sound plan: it becomes blocks, lint finds nothing, and it comes back unchanged, except for rounding.
pub(crate) fn plan(input: &[u8]) {
    let mut source = Source(input);
    let how = source.play();
    let span = how.move_time();
    let given: Vec<(Rotations, Vec<Key>)> = (0..=source.one_of(4))
        .map(|_| {
            let range = source.amount() * if source.one_of(2) == 0 { 1.0 } else { -1.0 };
            (Rotations(range), source.keys(span, range.into()))
        })
        .collect();
    let motor = |(number, (range, keys)): (u8, &'_ (Rotations, Vec<Key>))| (MotorAddress(number), *range, keys.clone());
    let given: Vec<_> = (1_u8..).zip(&given).map(motor).collect();
    let motors: Vec<_> = given
        .iter()
        .map(|(motor, range, keys)| MotorPlan { motor: *motor, way: Way::Keys { range: *range, keys } })
        .collect();
    let plan = Plan::new(how, &motors);

    let mut out = vec![0xa5; plan.encoded_len() + 1];
    assert!(matches!(plan.encode(&mut out[..plan.encoded_len() - 1]), Err(MoveError::Encode(_))));
    let data = plan.encode(&mut out).unwrap_or_else(|error| panic!("{error} in {plan:?}"));
    assert_eq!(data.encoded_len(), 1 + plan.encoded_len());
    only_asked_for(&plan, &data);
    in_order(&data);

    let trajectory = Trajectory::new(&data).expect("just planned");
    let rounded = match (trajectory.play().delay(), how.delay()) {
        (Delay::UntilFloat(one), Delay::UntilFloat(other)) => one.abs_diff(other) <= 64,
        (one, other) => one == other,
    };
    assert!(rounded, "{:?} {how:?}", trajectory.play());
    assert_eq!((trajectory.play().move_time(), trajectory.play().playing_time()), (span, how.playing_time()));
    examine(&trajectory);
    assert_eq!(trajectory.tracks().count(), given.len());
    for (motor, range, keys) in &given {
        let normalized = trajectory.track(*motor).expect("planned");
        let track = normalized.in_rotations(*range).expect("the range of the plan");
        let again: Vec<_> = track.keys().collect();
        assert_eq!(again.len(), keys.len());
        for (one, other) in again.windows(2).zip(keys.windows(2)) {
            let curves = [one, other].map(|keys| bezier::Segment::between(&keys[0], &keys[1]).expect("finite"));
            assert!(near(&curves[0], &curves[1], span, range.0.into()), "{one:?} {other:?}");
        }
        let curves: Vec<_> = normalized.segments().collect();
        for step in 0..=64 {
            let elapsed = f64::from(step) / 64.0;
            let (one, other) = (normalized.at_elapsed(elapsed), track.at(elapsed * span));
            let (one, other) = (one.expect("somewhere").position, other.expect("somewhere").position);
            assert!((one - bisected(&curves, elapsed)).abs() < 1e-6, "{elapsed}");
            assert!((0.0 - 1e-6..=1.0 + 1e-6).contains(&one), "{one}");
            assert!((one - other / f64::from(range.0)).abs() < 1e-4, "{one} {other}");
        }
    }
}

/// Points that were joined are joined on the wire, and times keep their order, rounded or not (decision K-J8).
fn in_order(data: &TrajectoryData<'_>) {
    let mut before = None;
    for block in &data.blocks {
        match block {
            Block::Axis(axis) => {
                assert!(before.is_none_or(|(_, left, _)| left == 0));
                before = Some((0.0, axis.segment_count, None));
            }
            Block::Segment(segment) => {
                let Points(points) = segment.points;
                let (time, left, position) = before.expect("an axis came first");
                assert!(points[0].time == Normalized(time) && position.is_none_or(|end| points[0].position == end));
                assert!(points.is_sorted_by(|one, next| one.time.0 <= next.time.0));
                before = Some((points[3].time.0, left - 1, Some(points[3].position)));
                assert!(left > 1 || points[3].time == Normalized(1.0));
            }
            _ => assert_eq!(before, None, "the settings of the move come first"),
        }
    }
}

/// Position of curves at a time, found by halving the interval of the curve parameter.
fn bisected(curves: &[bezier::Segment], time: f64) -> f64 {
    let curve = curves.iter().rfind(|curve| curve.start() <= time).expect("the first starts at 0");
    let [p0, p1, p2, p3] = curve.points();
    let cubic = |u: f64, [a, b, c, d]: [f64; 4]| {
        let v = 1.0 - u;
        v * v * v * a + 3.0 * v * v * u * b + 3.0 * v * u * u * c + u * u * u * d
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let u = 0.5 * (low + high);
        let early = cubic(u, [p0.time, p1.time, p2.time, p3.time]) <= time;
        (low, high) = if early { (u, high) } else { (low, u) };
    }
    cubic(low, [p0.position, p1.position, p2.position, p3.position])
}

/// Checks a plan of any numbers: it becomes blocks on which lint is silent, or an error, and nothing else.
pub(crate) fn hostile_plan(input: &[u8]) {
    let mut source = Source(input);
    let mut how = source.play();
    let mut number = || f32::from_bits(source.bits());
    match &mut how {
        Play::Live(live) => (live.duration, live.home_speed) = (Seconds(number()), Normalized(number())),
        Play::TimeLapse(photos) => (photos.interval, photos.exposure) = (Seconds(number()), Seconds(number())),
    }
    let range = Rotations(number());
    let span = how.move_time();
    let mut keys = source.keys(span, range.0.into());
    while !source.0.is_empty() {
        let at = usize::from(source.byte()) % keys.len();
        let number = f64::from(f32::from_bits(source.bits()));
        match source.one_of(5) {
            0 => keys[at].time = number,
            1 => keys[at].position = number,
            2 => keys[at].leave = Ease::Flat(number),
            3 => keys[at].arrive = Ease::Handle(bezier::Point::new(number, span)),
            _ => keys[at].leave = Ease::Handle(bezier::Point::new(span, number)),
        }
    }
    let motors = [MotorPlan { motor: MotorAddress(3), way: Way::Keys { range, keys: &keys } }];
    let plan = Plan::new(how, &motors);
    let mut out = [0; Plan::MAX_LEN];
    match plan.encode(&mut out) {
        Ok(data) => {
            only_asked_for(&plan, &data);
            in_order(&data);
            examine(&Trajectory::new(&data).expect("just planned"));
        }
        Err(error) => assert!(format!("{error:?}").len() < 300),
    }
}
