//! Moves: what the builder makes and refuses, what the reader reads, and the positions and limits. The rules are K-J1
//! to K-J15.

mod moves;
mod recorded;

use kos_proto::lint::Context;
use kos_proto::message::{
    AxisKind, Motor, MotorAddress, Normalized, PlaybackMode, Rotations, RotationsPerSecond, RotationsPerSecondSquared,
    Seconds,
};
use kos_proto::trajectory::bezier::{self, Ease, Key};
use kos_proto::trajectory::{
    Axis, Block, Blocks, Delay, DelayInterval, DelayMode, Excess, Limits, LiveMotion, Loop, LoopCount, MotorPlan,
    MoveError, Place, Plan, Play, Playback, Points, Segment, Style, TimeLapse, TimeLapseMotion, Times, Trajectory,
    TrajectoryData, Way,
};
use kos_proto::{EncodeError, HostMessage};
use motion_core::lint::Severity;
use motion_core::wire::{Message, Messages};
use proptest::collection::vec;
use proptest::prelude::*;

const MOTOR: MotorAddress = MotorAddress(2);
const RANGE: Rotations = Rotations(50.0);

const LIVE: LiveMotion =
    LiveMotion { duration: Seconds(10.0), repeat: Loop::Once, delay: Delay::None, home_speed: Normalized(1.0) };

const PHOTOS: TimeLapseMotion = TimeLapseMotion {
    style: Style::Continuous,
    interval: Seconds(5.0),
    exposure: Seconds(0.5),
    photos: 300,
    photos_before: 2,
    photos_after: 2,
    delay: Delay::None,
    home_speed: Normalized(1.0),
};

const fn key(time: f64, position: f64) -> Key {
    Key { time, position, arrive: Ease::Linear, leave: Ease::Linear }
}

/// Straight way through the whole range in the whole time of the move.
fn straight() -> bezier::Segment {
    bezier::Segment::between(&key(0.0, 0.0), &key(1.0, 1.0)).unwrap()
}

fn curve(points: [(f64, f64); 4]) -> bezier::Segment {
    bezier::Segment::new(points.map(|(time, position)| bezier::Point::new(time, position))).unwrap()
}

/// Motor without a range: both its ends are 0 (decision K-M5).
fn uncalibrated() -> Motor {
    Motor { begin_position: Some(Rotations(0.0)), ..motor(0.0) }
}

fn motor(end: f32) -> Motor {
    Motor {
        motor_address: MotorAddress(0x80 | MOTOR.0),
        position: Rotations(20.0),
        begin_position: Some(Rotations(10.0)),
        end_position: Rotations(end),
        max_max_setup_speed: RotationsPerSecond(165.0),
        max_max_move_speed: RotationsPerSecond(8.0),
        max_max_acceleration: RotationsPerSecondSquared(4.0),
    }
}

fn segments(segments: &[bezier::Segment]) -> MotorPlan<'_> {
    MotorPlan { motor: MOTOR, way: Way::Segments(segments) }
}

/// Blocks of a plan, or the builder's error as text.
fn built(play: Play, motors: &[MotorPlan<'_>]) -> Result<Vec<u8>, String> {
    let mut out = [0; Plan::MAX_LEN];
    let data = Plan::new(play, motors).encode(&mut out).map_err(|error| error.to_string())?;
    let mut body = vec![0; data.encoded_len()];
    data.encode_into(&mut body).unwrap();
    Ok(body)
}

/// Blocks of a move with a straight way of one motor.
fn played(play: Play) -> Result<Vec<u8>, String> {
    built(play, &[segments(&[straight()])])
}

/// Error of the builder about such a move.
fn refused(play: Play) -> String {
    played(play).unwrap_err()
}

fn live(live: LiveMotion) -> Play {
    Play::Live(live)
}

/// Settings that the reader finds in blocks, or its error as text.
fn read(blocks: &[Block<'_>]) -> Result<Play, String> {
    let mut out = [0; 4096];
    let data = TrajectoryData { blocks: Blocks::encode(blocks, &mut out).unwrap(), tail: &[] };
    Trajectory::new(&data).map(|trajectory| trajectory.play()).map_err(|error| error.to_string())
}

/// Blocks of a move as a device may store them.
fn blocks(body: &[u8]) -> Vec<Block<'_>> {
    TrajectoryData::decode(body).unwrap().blocks.iter().collect()
}

fn playback(body: &[u8]) -> Playback<'_> {
    let Some(Block::Playback(playback)) = blocks(body).first().copied() else { panic!("the first block") };
    playback
}

/// Decisions K-J1 to K-J5, K-J10: the builder makes the moves of the vectors, byte by byte.
#[test]
fn the_moves_of_the_vectors_are_built() {
    let until = Delay::Until(1_700_000_000);
    let third = Loop::RapidReverse { times: Times::new(3).unwrap(), duration: None };
    let thirty = Delay::For(Seconds(30.0));
    let (one, three) = (MotorAddress(1), MotorAddress(3));
    let sms = TimeLapseMotion {
        style: Style::ShootMoveShoot,
        interval: Seconds(2.0),
        exposure: Seconds(1.0),
        photos: 10,
        photos_before: 0,
        photos_after: 0,
        ..PHOTOS
    };
    let cases = [
        ("traj/live-minimal", one, live(LIVE)),
        (
            "traj/live-rapid-loop3-delay30",
            three,
            live(LiveMotion { duration: Seconds(8.0), repeat: third, delay: thirty, ..LIVE }),
        ),
        ("traj/delay-until-u32", one, live(LiveMotion { delay: until, ..LIVE })),
        ("traj/delay-until-f32", one, live(LiveMotion { delay: Delay::UntilFloat(1_700_000_000), ..LIVE })),
        ("traj/timelapse-continuous", one, Play::TimeLapse(PHOTOS)),
        ("traj/timelapse-sms", MOTOR, Play::TimeLapse(sms)),
    ];
    let vectors = recorded::vectors();
    for (name, motor, play) in cases {
        let wanted = vectors.iter().find(|vector| vector["name"] == name).map(recorded::bytes).unwrap();
        let body = built(play, &[MotorPlan { motor, ..segments(&[straight()]) }]).unwrap();
        assert_eq!(body, wanted[6..], "{name}");
        assert_eq!(read(&blocks(&body)), Ok(play), "{name}");
    }
}

/// Decision K-J1.
#[test]
fn a_move_is_written_in_order_and_read_in_any_order() {
    let halves = [
        curve([(0.0, 0.0), (0.1, 0.0), (0.4, 0.5), (0.5, 0.5)]),
        curve([(0.5, 0.5), (0.6, 0.5), (0.9, 1.0), (1.0, 1.0)]),
    ];
    let body = built(live(LIVE), &[segments(&halves), MotorPlan { motor: MotorAddress(1), ..segments(&halves) }]);
    let body = body.unwrap();
    let mut blocks = blocks(&body);
    let ids: Vec<_> = blocks.iter().map(Messages::number).collect();
    assert_eq!(ids, [1, 2, 5, 6, 6, 5, 6, 6]);
    let Block::TimeLapse(TimeLapse { move_photos: 0, .. }) = blocks[1] else { panic!("zeros in a live move") };

    let mut out = [0; 4096];
    let mut tracks = Vec::new();
    for _ in 0..2 {
        let data = TrajectoryData { blocks: Blocks::encode(&blocks, &mut out).unwrap(), tail: &[] };
        let track = Trajectory::new(&data).unwrap().track(MOTOR).unwrap();
        tracks.push(track.segments().collect::<Vec<_>>());
        assert!((track.at(0.75).unwrap().position - halves[1].position(0.75)).abs() < 1e-6);
        blocks.reverse();
    }
    assert_eq!(tracks[0], tracks[1]);
    for missing in [0, 1] {
        let mut rest = blocks.clone();
        rest.remove(missing);
        let name = ["playback", "time_lapse"][missing];
        assert_eq!(read(&rest), Err(format!("move: {name} is missing")));
    }
}

/// Decision K-J1: a strict device requires a motor.
#[test]
fn a_move_without_motors_has_to_be_asked_for() {
    assert_eq!(built(live(LIVE), &[]), Err("move: no motor takes part".into()));
    let mut out = [0; Plan::MAX_LEN];
    let data = Plan::without_motors(Play::TimeLapse(PHOTOS)).encode(&mut out).unwrap();
    let trajectory = Trajectory::new(&data).unwrap();
    assert_eq!((trajectory.play(), trajectory.tracks().count()), (Play::TimeLapse(PHOTOS), 0));
    assert_eq!(trajectory.track(MOTOR), None);
    let refused = HostMessage::from(data).encode_checked(&Context::default(), &mut [0; 100]);
    assert!(matches!(refused, Err(EncodeError::Refused(lint)) if lint.what == "axis"));
    assert_eq!(built(live(LIVE), &[segments(&[])]), Err("motor 2: way has no segment".into()));
    let lonely = [key(0.0, 0.0)];
    let lonely = MotorPlan::new(&motor(60.0), &lonely).unwrap();
    assert_eq!(built(live(LIVE), &[lonely]), Err("motor 2: way has no segment".into()));
}

/// Decision K-J2: 255 blocks, in any division among motors.
#[test]
fn a_move_has_at_most_255_blocks() {
    let keys = |count: u8| (0..=count).map(|at| key(f64::from(at) * 10.0 / f64::from(count), 1.0)).collect::<Vec<_>>();
    for motors in [1_u8, 2, 10] {
        let segments = 253 - motors;
        let longest = keys(segments - (motors - 1));
        let short = keys(1);
        let way = |keys| Way::Keys { range: RANGE, keys };
        let plan =
            |number| MotorPlan { motor: MotorAddress(number), way: way(if number == 1 { &longest } else { &short }) };
        let mut plans: Vec<_> = (1..=motors).map(plan).collect();
        let mut out = [0; Plan::MAX_LEN];
        let plan = Plan::new(live(LIVE), &plans);
        let data = plan.encode(&mut out).unwrap();
        assert_eq!((data.blocks.len(), data.encoded_len()), (255, 1 + plan.encoded_len()));
        assert_eq!(motors == 1, plan.encoded_len() == Plan::MAX_LEN);
        assert_eq!(
            Trajectory::new(&data).unwrap().tracks().map(|track| track.keys().count()).max(),
            Some(longest.len())
        );

        let more = keys(segments - (motors - 1) + 1);
        plans[0].way = way(&more);
        let error = MoveError::TooManyBlocks { needed: 256 };
        assert_eq!(Plan::new(live(LIVE), &plans).encode(&mut out), Err(error));
    }
    let small = EncodeError::BufferTooSmall { needed: 106, have: 105 };
    let (straight, mut out) = ([straight()], [0; 105]);
    let plan = [segments(&straight)];
    let plan = Plan::new(live(LIVE), &plan);
    assert_eq!((plan.encoded_len(), plan.encode(&mut out)), (106, Err(MoveError::Encode(small))));
    assert_eq!(Plan::MAX_LEN, 9393);
}

/// Decision K-J3, safety decision 5.
#[test]
fn a_moment_is_an_integer_unless_a_float_is_asked_for() {
    let until = |delay| live(LiveMotion { delay, ..LIVE });
    let written = |delay| {
        let body = played(until(delay)).unwrap();
        (playback(&body).delay_mode, playback(&body).delay_interval_bits, read(&blocks(&body)).unwrap().delay())
    };
    let moment = 1_700_000_001;
    let bits = DelayInterval(moment);
    assert_eq!(written(Delay::Until(moment)), (DelayMode::UNTIL, bits, Delay::Until(moment)));
    let float = DelayInterval(0x4eca_a7e2);
    assert_eq!(written(Delay::UntilFloat(moment)), (DelayMode::UNTIL, float, Delay::UntilFloat(1_700_000_000)));
    assert_eq!(written(Delay::For(Seconds(1.5))).1, DelayInterval(0x3fc0_0000));
    assert_eq!(written(Delay::None), (DelayMode::NONE, DelayInterval(0), Delay::None));

    let wrong = "move: the moment 1321205760 would be read as an IEEE number";
    assert_eq!(refused(until(Delay::Until(1_321_205_760))), wrong);
    let wrong = "move: the moment 1000000000 is not from 2004 to 2038";
    assert_eq!(refused(until(Delay::UntilFloat(1_000_000_000))), wrong);
    assert_eq!(refused(until(Delay::For(Seconds(-1.0)))), "move: delay_interval_bits: -1.0 is negative");
    let none = refused(until(Delay::For(Seconds(f32::NAN))));
    assert_eq!(none, "move: delay_interval_bits: 0x7fc00000 is no finite number");
}

/// Decisions K-J4 and K-J10.
#[test]
fn only_one_kind_of_loop_counts() {
    assert_eq!([0, 255].map(Times::new), [None, None]);
    let times = Times::new(254).unwrap();
    assert_eq!((times.count(), Times::FOREVER.count()), (Some(254), None));
    let written = |repeat| {
        let body = played(live(LiveMotion { repeat, ..LIVE })).unwrap();
        assert_eq!(read(&blocks(&body)), Ok(live(LiveMotion { repeat, ..LIVE })));
        (playback(&body).loop_after_rapid_reverse, playback(&body).loop_after_reverse)
    };
    let forever = Loop::RapidReverse { times: Times::FOREVER, duration: None };
    assert_eq!(written(Loop::Once), (LoopCount::NONE, LoopCount::NONE));
    assert_eq!(written(Loop::Reverse(times)), (LoopCount::NONE, LoopCount(254)));
    assert_eq!(written(forever), (LoopCount::FOREVER, LoopCount::NONE));

    for (name, error) in [
        ("traj/both-loops", "move: loop_after_reverse cannot be set with loop_after_rapid_reverse"),
        ("traj/timelapse-with-loop", "move: loop_after_reverse is set, but a time lapse does not loop"),
    ] {
        let vectors = recorded::vectors();
        let message = vectors.iter().find(|vector| vector["name"] == name).map(recorded::bytes).unwrap();
        assert_eq!(read(&blocks(&message[6..])), Err(error.into()));
    }
}

/// Decision K-J5.
#[test]
fn a_rapid_way_back_takes_as_long_as_the_move_unless_set() {
    let rapid = |duration| {
        let repeat = Loop::RapidReverse { times: Times::new(1).unwrap(), duration };
        live(LiveMotion { repeat, ..LIVE })
    };
    let written = |play| {
        let body = played(play).unwrap();
        assert_eq!(read(&blocks(&body)), Ok(play));
        playback(&body).rapid_reverse_duration
    };
    assert_eq!(written(live(LIVE)), LIVE.duration);
    assert_eq!(written(rapid(None)), LIVE.duration);
    assert_eq!(written(rapid(Some(Seconds(2.5)))), Seconds(2.5));
    let none = "move: rapid_reverse_duration: 0.0 is too short for a way back";
    assert_eq!(refused(rapid(Some(Seconds(0.0)))), none);
    assert_eq!(refused(rapid(Some(Seconds(-2.0)))), "move: rapid_reverse_duration: -2.0 is negative");
}

/// Decision K-J6, safety decision 9.
#[test]
fn the_speed_on_the_way_to_the_start_is_above_0_and_at_most_1() {
    let home = |part| {
        let home_speed = Normalized(part);
        let live = played(live(LiveMotion { home_speed, ..LIVE }));
        let photos = played(Play::TimeLapse(TimeLapseMotion { home_speed, ..PHOTOS }));
        assert_eq!(live.is_ok(), photos.is_ok());
        live.map(|body| playback(&body).return_to_home_percent.0)
    };
    assert_eq!((home(1.0), home(0.01)), (Ok(1.0), Ok(0.01)));
    let wrong = |text| Err(format!("move: return_to_home_percent: {text}"));
    assert_eq!(home(0.0), wrong("0.0 may never bring the motors to the start"));
    assert_eq!(home(50.0), wrong("50.0 is not in 0 to 1"));
    assert_eq!(home(-0.5), wrong("-0.5 is negative"));
    assert_eq!(home(f32::INFINITY), wrong("0x7f800000 is no finite number"));
}

/// Decision K-J8.
#[test]
fn segments_join_from_the_start_to_the_end() {
    let wrong = |way: &[bezier::Segment]| built(live(LIVE), &[segments(way)]).unwrap_err();
    let first = curve([(0.0, 0.0), (0.1, 0.0), (0.4, 0.5), (0.5, 0.5)]);
    let begins = |time, position| curve([(time, position), (0.7, 0.5), (0.9, 1.0), (1.0, 1.0)]);
    assert_eq!(
        wrong(&[first, begins(0.625, 0.5)]),
        "motor 2, segment 1: starts at [0.625, 0.5], the segment before ends at [0.5, 0.5]"
    );
    assert!(built(live(LIVE), &[segments(&[first, begins(0.50005, 0.49995)])]).is_ok());
    assert_eq!(wrong(&[first]), "motor 2, segment 0: points: 0.5 is the end of the last segment, not 1");
    assert_eq!(
        wrong(&[begins(0.25, 0.0)]),
        "motor 2, segment 0: points: 0.25 is the start of the first segment, not 0"
    );
    // Lint tolerates these ends. The builder refuses them.
    let late = begins(5e-5, 0.0);
    assert!(wrong(&[late]).ends_with("is the start of the first segment, not 0"));
    let early = curve([(0.0, 0.0), (0.1, 0.0), (0.9, 1.0), (0.99995, 1.0)]);
    assert!(wrong(&[early]).ends_with("is the end of the last segment, not 1"));
    let one = |points| wrong(&[curve(points)]);
    assert_eq!(
        one([(0.0, 0.0), (0.75, 0.0), (0.25, 1.0), (1.0, 1.0)]),
        "motor 2, segment 0: points: 0.25 is earlier than the point before"
    );
    assert_eq!(
        one([(0.0, 0.0), (0.25, 0.0), (0.5, 1.0), (1.0, 1.5)]),
        "motor 2, segment 0: points: 1.5 is not in 0 to 1"
    );
    assert!(
        one([(0.0, 0.0), (0.25, -1.0), (0.5, 1.0), (1.0, 1.0)])
            .ends_with("is a position of the curve outside the range"),
    );
    let still_inside = curve([(0.0, 0.5), (0.25, -0.1), (0.5, 1.1), (1.0, 0.5)]);
    assert!(built(live(LIVE), &[segments(&[still_inside])]).is_ok());
    // In f32 these two times are the same.
    let parts = [straight().split(0.5).unwrap(), straight().split(0.5 + 1e-9).unwrap()];
    let between = parts[1].0.split(0.5).unwrap().1;
    let collapsed = "motor 2, segment 1: points: 0.5 is both start and end";
    assert_eq!(wrong(&[parts[0].0, between, parts[1].1]), collapsed);
}

/// Decision K-J8: points that were equal and in order stay so on the wire, however they are rounded.
#[test]
fn rounding_keeps_the_order_of_points() {
    for hundredths in 1..=1000_u16 {
        let (exact, near) = (f64::from(hundredths) / 100.0, f32::from(hundredths) / 100.0);
        let keys = [key(0.0, 0.0), key(exact / 3.0, exact), key(exact, exact)];
        let way = Way::Keys { range: Rotations(near), keys: &keys };
        let body = built(live(LiveMotion { duration: Seconds(near), ..LIVE }), &[MotorPlan { motor: MOTOR, way }]);
        let body = body.unwrap_or_else(|error| panic!("{error}: {near}"));
        let (Block::Segment(first), Block::Segment(last)) = (blocks(&body)[3], blocks(&body)[4]) else { panic!() };
        assert_eq!(first.points.0[3], last.points.0[0]);
        assert_eq!((last.points.0[3].time, last.points.0[3].position), (Normalized(1.0), Normalized(1.0)));
    }
    // Times that should be equal, and differ by one step of f32.
    let (step, third) = (f64::from(f32::EPSILON) / 4.0, f64::from(0.3_f32));
    let handles = |out: f64, into: f64| curve([(0.0, 0.0), (out, 0.0), (into, 0.5), (third, 0.5)]);
    let rest = |out: f64| curve([(third, 0.5), (out, 0.5), (0.9, 1.0), (1.0, 1.0)]);
    for (first, last) in [
        (handles(0.1, third + step), rest(0.5)),
        (handles(third, third - step), rest(0.5)),
        (handles(0.1, 0.2), rest(third - step)),
    ] {
        let body = built(live(LIVE), &[segments(&[first, last])]).unwrap();
        let segments = [blocks(&body)[3], blocks(&body)[4]];
        let times = segments.map(|block| {
            let Block::Segment(segment) = block else { panic!("a segment") };
            segment.points.0.map(|point| point.time.0)
        });
        assert!(times.as_flattened().is_sorted(), "{times:?}");
    }
}

/// Decision K-J8: key frames in seconds and rotations.
#[test]
fn key_frames_lie_in_the_move_and_the_range() {
    let way = |range, keys: &[Key]| {
        built(live(LIVE), &[MotorPlan { motor: MOTOR, way: Way::Keys { range: Rotations(range), keys } }])
    };
    let there = |range: f32| [key(0.0, 0.0), key(10.0, range.into())];
    assert_eq!(way(50.0, &there(50.0)), way(-2.5, &there(-2.5)), "ranges may be negative");
    let outside = "motor 2, segment 1: 51.0 rev is not in 0 to 50.0";
    assert_eq!(way(50.0, &[key(0.0, 0.0), key(5.0, 50.0), key(10.0, 51.0)]), Err(outside.into()));
    assert_eq!(way(-50.0, &there(1.0)), Err("motor 2, segment 0: 1.0 rev is not in 0 to -50.0".into()));
    let last = "motor 2, segment 0: points: 0.9 is the end of the last segment, not 1";
    assert_eq!(way(50.0, &[key(0.0, 0.0), key(9.0, 50.0)]), Err(last.into()));
    let back = "motor 2, segment 0: points: -0.2 is earlier than the point before";
    assert!(way(50.0, &[key(0.0, 0.0), key(-2.0, 1.0), key(10.0, 1.0)]).unwrap_err().starts_with(&back[..26]));
    for (changed, what) in [
        (Key { time: f64::NAN, ..key(0.0, 0.0) }, "time: 0x7fc00000"),
        (Key { leave: Ease::Flat(f64::INFINITY), ..key(0.0, 0.0) }, "leave: 0x7f800000"),
        (Key { leave: Ease::Handle(bezier::Point::new(0.0, 1e300)), ..key(0.0, 0.0) }, "leave: 0x7f800000"),
    ] {
        let error = format!("motor 2, segment 0: {what} is no finite number");
        assert_eq!(way(50.0, &[changed, key(10.0, 1.0)]), Err(error));
    }
    let nowhere = "motor 2, segment 0: NaN rev is not in 0 to 50.0";
    assert_eq!(way(50.0, &[key(0.0, f64::NAN), key(10.0, 1.0)]), Err(nowhere.into()));
    assert_eq!(way(f32::NAN, &there(1.0)), Err("motor 2: range: 0x7fc00000 is no finite number".into()));
    assert_eq!(way(0.0, &there(1.0)), Err("motor 2: not calibrated".into()));
}

/// Decisions K-J9, K-M1 and K-M2.
#[test]
fn motors_are_known_calibrated_and_listed_once() {
    let straight = [straight()];
    let at = |address| MotorPlan { motor: MotorAddress(address), ..segments(&straight) };
    assert_eq!(built(live(LIVE), &[at(0)]), Err("motor 0: not one of 1 to 10".into()));
    assert_eq!(built(live(LIVE), &[at(11)]), Err("motor 11: not one of 1 to 10".into()));
    assert_eq!(built(live(LIVE), &[at(1), at(2), at(1)]), Err("motor 1: axis is present twice".into()));
    assert_eq!(built(live(LIVE), &[at(0x82)]), built(live(LIVE), &[at(2)]), "the flag is left out");
    assert_eq!(built(live(LIVE), &[at(0x82), at(2)]), Err("motor 2: axis is present twice".into()));
    let error = MoveError::Uncalibrated { motor: uncalibrated().motor_address };
    assert_eq!(MotorPlan::new(&uncalibrated(), &[]), Err(error));

    let body = built(live(LIVE), &[at(1)]).unwrap();
    let sound = blocks(&body);
    let changed = |at: usize, block| {
        let mut blocks = sound.clone();
        blocks[at] = block;
        read(&blocks).unwrap_err()
    };
    let axis =
        |motor, segment_count| Block::Axis(Axis { motor_address: MotorAddress(motor), segment_count, tail: &[] });
    assert_eq!(changed(2, axis(1, 2)), "motor 1: 1 segments, not 2");
    assert_eq!(changed(2, axis(3, 0)), "motor 1, segment 0: segment has no axis");
    let Block::Segment(segment) = sound[3] else { panic!("a segment") };
    let second = Block::Segment(Segment { segment_number: 1, ..segment });
    assert_eq!(changed(3, second), "motor 1, segment 0: segment_number is missing");
    let Points([begin, out, into, mut end]) = segment.points;
    end.position = Normalized(f32::NAN);
    let none = Block::Segment(Segment { points: Points([begin, out, into, end]), ..segment });
    assert_eq!(changed(3, none), "motor 1, segment 0: points: NaN is not in 0 to 1");
    let none = Block::Segment(Segment { points: Points([begin, out, end, into]), ..segment });
    assert!(changed(3, none).starts_with("motor 1, segment 0: points: "));
}

/// Decision K-J10.
#[test]
fn times_are_estimated() {
    for duration in [0.0, -1.0, f32::NAN] {
        let refused = refused(live(LiveMotion { duration: Seconds(duration), ..LIVE }));
        assert_eq!(refused, format!("move: duration: {duration:?} is too short for a move"));
    }
    let infinite = refused(live(LiveMotion { duration: Seconds(f32::INFINITY), ..LIVE }));
    assert_eq!(infinite, "move: duration: 0x7f800000 is no finite number");
    let photos = |photos| Play::TimeLapse(photos);
    let body = played(photos(PHOTOS)).unwrap();
    assert_eq!(playback(&body).duration, Seconds(0.0), "unused");
    let still = TimeLapseMotion { photos: 0, ..PHOTOS };
    assert_eq!(refused(photos(still)), "move: move_photos: 0.0 is less than one photo");
    let at_once = TimeLapseMotion { interval: Seconds(0.0), exposure: Seconds(0.0), ..PHOTOS };
    assert_eq!(refused(photos(at_once)), "move: delay and exposure: 0.0 is too short for a move");
    let negative = TimeLapseMotion { exposure: Seconds(-1.0), ..PHOTOS };
    assert_eq!(refused(photos(negative)), "move: exposure: -1.0 is negative");
    let negative = TimeLapseMotion { interval: Seconds(-1.0), exposure: Seconds(2.0), ..PHOTOS };
    assert_eq!(refused(photos(negative)), "move: delay: -1.0 is negative");

    let times = |play: Play| (play.move_time(), play.playing_time(), play.total_time());
    assert_eq!(times(photos(PHOTOS)), (1650.0, Some(1672.0), Some(1672.0)));
    let delay = Delay::For(Seconds(4.5));
    let three = |repeat| times(live(LiveMotion { repeat, delay, ..LIVE }));
    assert_eq!(three(Loop::Once), (10.0, Some(10.0), Some(14.5)));
    assert_eq!(three(Loop::Reverse(Times::new(3).unwrap())), (10.0, Some(70.0), Some(74.5)));
    let rapid = |times| Loop::RapidReverse { times, duration: Some(Seconds(2.0)) };
    assert_eq!(three(rapid(Times::new(2).unwrap())), (10.0, Some(34.0), Some(38.5)));
    assert_eq!(three(rapid(Times::FOREVER)), (10.0, None, None));
    assert_eq!(times(live(LiveMotion { delay: Delay::Until(7), ..LIVE })), (10.0, Some(10.0), None));
}

/// Decision K-J4 and 7.4: the move goes forward, back and forward, and it ends at its end.
#[test]
#[expect(clippy::float_cmp, reason = "halves and wholes come out exactly")]
fn elapsed_time_rises_and_falls_with_loops() {
    let repeat = Loop::RapidReverse { times: Times::new(2).unwrap(), duration: Some(Seconds(2.0)) };
    let play = live(LiveMotion { repeat, ..LIVE });
    let at = [-1.0, 0.0, 5.0, 10.0, 11.0, 12.0, 17.0, 23.0, 24.0, 34.0, 99.0];
    assert_eq!(at.map(|time| play.elapsed_at(time)), [0.0, 0.0, 0.5, 1.0, 0.5, 0.0, 0.5, 0.5, 0.0, 1.0, 1.0]);
    let play = live(LiveMotion { repeat: Loop::Reverse(Times::FOREVER), ..LIVE });
    assert_eq!([2e6, 2e6 + 15.0].map(|time| play.elapsed_at(time)), [0.0, 0.5]);
    assert_eq!(Play::TimeLapse(PHOTOS).elapsed_at(825.0), 0.5);
}

/// Decision K-J11.
#[test]
fn unsupported_fields_are_sent_as_0_and_ignored_when_read() {
    let body = played(live(LIVE)).unwrap();
    assert!(body[4 + 16..4 + 33].iter().all(|&byte| byte == 0), "all bytes between the delay and the speed");
    let mut changed = body.clone();
    changed[4 + 16..4 + 33].fill(7);
    changed[4 + 37 + 3 + 12] = 9;
    assert_eq!(read(&blocks(&changed)), Ok(live(LIVE)));
    let mut more = blocks(&changed);
    more.insert(1, Block::other(3, b"kept"));
    assert_eq!(read(&more), Ok(live(LIVE)));
}

/// Decision K-J15: without blocks no move is stored. Kinds without a name are refused.
#[test]
fn without_blocks_there_is_no_move() {
    assert_eq!(read(&[]), Err("move: playback is missing".into()));
    let body = played(Play::TimeLapse(PHOTOS)).unwrap();
    let mut blocks = blocks(&body);
    blocks[0] = Block::Playback(Playback { playback_mode: PlaybackMode(3), ..playback(&body) });
    assert_eq!(read(&blocks), Err("move: playback_mode: 3 has no meaning in the specification".into()));
    blocks[0] = Block::Playback(Playback { delay_mode: DelayMode(3), ..playback(&body) });
    assert_eq!(read(&blocks), Err("move: delay_mode: 3 has no meaning in the specification".into()));
}

/// A way of 50 rotations in 10 seconds with a steep part, and a motor that can do 8 rev/s and 4 rev/s².
#[test]
fn moves_are_compared_with_the_limits_of_their_motors() {
    let gentle = |time, position| Key { arrive: Ease::Flat(0.5), leave: Ease::Flat(0.5), ..key(time, position) };
    let (slow, fast) = (gentle(6.0, 20.0), gentle(7.0, 30.0));
    let keys = [gentle(0.0, 0.0), slow, fast, gentle(10.0, 35.0)];
    let known = motor(60.0);
    assert_eq!(known.range(), Some(RANGE));
    let mut out = [0; Plan::MAX_LEN];
    let measured = |play, motors: &[Motor], out: &mut [u8]| {
        let plan = [MotorPlan::new(&known, &keys).unwrap()];
        let data = Plan::new(play, &plan).encode(out).unwrap();
        Trajectory::new(&data)
            .unwrap()
            .excesses(&Context::default().with_motors(motors))
            .map(|excess| excess.to_string())
            .collect::<Vec<_>>()
    };
    let found = measured(live(LIVE), &[known], &mut out);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].starts_with("motor 2, segment 1: ") && found[0].ends_with(" rev/s, at most 8.0"), "{found:?}");
    assert!(found[1].starts_with("motor 2, segment 1: ") && found[1].ends_with(" rev/s², at most 4.0"), "{found:?}");
    assert_eq!(measured(live(LIVE), &[], &mut out), ["motor 2: the device has no such motor"]);
    assert_eq!(measured(live(LIVE), &[uncalibrated()], &mut out), ["motor 2: not calibrated"]);

    // A kind of axis may allow less. Lint agrees with the reader.
    let plan = [MotorPlan::new(&known, &keys).unwrap()];
    let data = Plan::new(live(LIVE), &plan).encode(&mut out).unwrap();
    let lint = |context: &Context<'_>| {
        let lints = HostMessage::from(data).lint(context).into_iter();
        lints.map(|lint| (lint.severity, lint.what)).collect::<Vec<_>>()
    };
    let context = Context::default();
    let (speed, acceleration) = (RotationsPerSecond(1e6), RotationsPerSecondSquared(1e6));
    let strong = Motor { max_max_move_speed: speed, max_max_acceleration: acceleration, ..motor(5010.0) };
    assert_eq!(lint(&context), []);
    assert_eq!(lint(&context.with_motors(&[strong])), []);
    let tilt = context.with_kinds(&[(MOTOR, AxisKind::Tilt)]);
    assert_eq!(lint(&tilt.with_motors(&[strong])), [(Severity::Warning, "points"); 6], "three segments");
    assert_eq!(lint(&context.with_motors(&[known])), [(Severity::Warning, "points"); 2]);
    let other = Motor { motor_address: MotorAddress(9), ..strong };
    assert_eq!(lint(&context.with_motors(&[other])), [(Severity::Error, "motor_address")]);
    assert_eq!(lint(&context.with_motors(&[uncalibrated()])), [(Severity::Error, "motor_address")]);

    // The estimated time of a time lapse counts. If the motors stop for each photo, their speed is not known.
    let style = |style| {
        let second = TimeLapseMotion { interval: Seconds(0.5), exposure: Seconds(0.5), photos: 10, style, ..PHOTOS };
        Play::TimeLapse(second)
    };
    assert_eq!(measured(style(Style::Continuous), &[known], &mut out), found);
    assert_eq!(measured(style(Style::ShootMoveShoot), &[known], &mut out), [""; 0]);
    assert_eq!(measured(style(Style::ShootMoveShoot), &[uncalibrated()], &mut out), ["motor 2: not calibrated"]);
    // A device may store a move that the builder refuses.
    let mut body = played(style(Style::Continuous)).unwrap();
    body[1 + 40 + 3..][..8].fill(0);
    let no_time = Trajectory::new(&TrajectoryData::decode(&body).unwrap()).unwrap();
    assert_eq!(
        (no_time.play().move_time(), no_time.excesses(&Context::default().with_motors(&[known])).count()),
        (0.0, 0)
    );
}

/// 50 rotations in 10 seconds with rising speed: half a rotation times the square of the time.
#[test]
fn positions_and_speeds_are_in_parts_or_in_rotations() {
    let parabola = [curve([(0.0, 0.0), (1.0 / 3.0, 0.0), (2.0 / 3.0, 1.0 / 3.0), (1.0, 1.0)])];
    let body = built(live(LIVE), &[segments(&parabola)]).unwrap();
    let data = TrajectoryData::decode(&body).unwrap();
    let parts = Trajectory::new(&data).unwrap().track(MOTOR).unwrap();
    let rotations = parts.in_rotations(RANGE).unwrap();
    let back = parts.in_rotations(Rotations(-50.0)).unwrap();
    let near = |motion: Option<bezier::Motion>, position: f64, velocity: f64, acceleration: f64| {
        let bezier::Motion { position: p, velocity: v, acceleration: a } = motion.unwrap();
        let apart = [p - position, v.unwrap() - velocity, a.unwrap() - acceleration];
        assert!(apart.iter().all(|apart| apart.abs() < 1e-4), "{motion:?}");
    };
    near(parts.at(0.5), 0.25, 1.0, 2.0);
    near(parts.at_elapsed(0.5), 0.25, 1.0, 2.0);
    near(rotations.at(5.0), 12.5, 5.0, 1.0);
    near(rotations.at_elapsed(0.5), 12.5, 5.0, 1.0);
    near(back.at(5.0), -12.5, -5.0, -1.0);
    near(rotations.at(99.0), 50.0, 0.0, 0.0);
    assert_eq!(parts.in_rotations(Rotations(0.0)), Err(MoveError::Uncalibrated { motor: MOTOR }));
    let none = MoveError::NotFinite { place: Place::Motor(MOTOR), what: "range", bits: f32::NAN.to_bits() };
    assert_eq!(parts.in_rotations(Rotations(f32::NAN)), Err(none));
    assert_eq!((parts.len(), parts.is_empty(), parts.motor()), (1, false, MOTOR));
}

/// A vertical tangent has an unbounded speed, and no limit allows that.
#[test]
fn an_unbounded_speed_exceeds_every_limit() {
    let vertical = [curve([(0.0, 0.0), (0.0, 0.5), (0.5, 1.0), (1.0, 1.0)])];
    let mut out = [0; Plan::MAX_LEN];
    let plan = [segments(&vertical)];
    let data = Plan::new(live(LIVE), &plan).encode(&mut out).unwrap();
    let track = Trajectory::new(&data).unwrap().track(MOTOR).unwrap().in_rotations(RANGE).unwrap();
    assert_eq!(track.peaks().next().map(|peaks| (peaks.speed, peaks.acceleration)), Some((None, None)));
    assert_eq!(track.at(0.0).map(|motion| motion.velocity), Some(None));
    let any = Limits { speed: RotationsPerSecond(f32::MAX), acceleration: RotationsPerSecondSquared(f32::MAX) };
    let place = Place::Segment(MOTOR, 0);
    let speed = Excess::Speed { place, speed: RotationsPerSecond(f32::INFINITY), limit: any.speed };
    assert_eq!(track.excesses(any).next(), Some(speed));
    let tighter = any.and(Limits { speed: RotationsPerSecond(3.0), ..any });
    assert_eq!((tighter.speed, tighter.acceleration), (RotationsPerSecond(3.0), any.acceleration));
    let tilt = Limits::from(&motor(60.0)).and(AxisKind::Tilt.into());
    assert_eq!((tilt.speed, tilt.acceleration), (RotationsPerSecond(8.0), RotationsPerSecondSquared(4.0)));
    let iris = Limits::from(AxisKind::Iris).and(AxisKind::Tilt.into());
    assert_eq!((iris.speed, iris.acceleration), (RotationsPerSecond(65.0), RotationsPerSecondSquared(50.0)));
    let none = Limits { speed: RotationsPerSecond(f32::NAN), acceleration: RotationsPerSecondSquared(f32::NAN) };
    let body = played(live(LIVE)).unwrap();
    let track = Trajectory::new(&TrajectoryData::decode(&body).unwrap()).unwrap().track(MOTOR).unwrap();
    assert_eq!([none.and(any), any.and(none)].map(|limits| track.excesses(limits).count()), [2; 2]);
    assert_eq!(track.excesses(none).count(), 2, "a limit that is NaN allows nothing");
    assert_eq!(track.excesses(any).count(), 0);
}

/// A device plays the reversed move forward, so that each motor goes the other way through the same positions. The ways back
/// of loops are mirrored as well.
#[test]
fn a_reversed_move_goes_through_the_same_positions() {
    for body in stored() {
        let Ok(data) = TrajectoryData::decode(&body) else { continue };
        let Ok(trajectory) = Trajectory::new(&data) else { continue };
        let (mut out, mut again) = (vec![0; data.reversed_len()], vec![0; data.reversed_len()]);
        let reversed = data.reversed(&mut out).unwrap();
        let mirrored = Trajectory::new(&reversed).unwrap();
        assert_eq!(mirrored.play(), trajectory.play());
        for (one, other) in trajectory.tracks().zip(mirrored.tracks()) {
            assert_eq!((one.motor(), one.len()), (other.motor(), other.len()));
            for step in 0..=256 {
                let part = f64::from(step) / 256.0;
                let [there, back] = [one.at_elapsed(part), other.at_elapsed(1.0 - part)];
                assert_eq!(there.is_some(), back.is_some());
                let positions = there.zip(back).map(|(there, back)| (there.position, back.position));
                assert!(positions.is_none_or(|(there, back)| (there - back).abs() < 1e-6), "{part}: {positions:?}");
            }
        }
        // Only the first time is rounded: after it, the mirror of the mirror is the same move.
        let back = reversed.reversed(&mut again).unwrap();
        let mut third = vec![0; data.reversed_len()];
        assert_eq!(back.reversed(&mut third).unwrap(), reversed);
        let small = data.reversed(&mut []).unwrap_err();
        assert!(matches!(small, MoveError::Encode(_)), "{small}");
    }
}

proptest! {
    #[test]
    fn any_sound_plan_is_built_and_read_back(input in vec(any::<u8>(), 0..200)) {
        moves::plan(&input);
    }

    #[test]
    fn any_numbers_make_a_move_or_an_error(input in vec(any::<u8>(), 0..200)) {
        moves::hostile_plan(&input);
    }

    #[test]
    fn any_change_of_a_move_is_read_or_refused(
        vector in prop::sample::select(stored()),
        changes in vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
    ) {
        let mut body = vector;
        for (at, byte) in changes {
            let at = at.index(body.len());
            body[at] = byte;
        }
        moves::read(&body);
    }
}

/// Moves of the vectors.
fn stored() -> Vec<Vec<u8>> {
    let moves = recorded::vectors();
    let moves = moves.iter().filter(|vector| vector["name"].as_str().is_some_and(|name| name.starts_with("traj/")));
    moves.map(|vector| recorded::bytes(vector).split_off(6)).collect()
}
