//! Uploads and runs: each motor is where the move has it, at every moment.

use dmc_proto::device::{Quirks, State};
use dmc_proto::host::{self, Failure, Outcome, Progress, Refusal};
use dmc_proto::message::{
    AckCode, Bool, DmxChannel, FrameNumber, FramesPerSecond, HostMessage, Motor, MotorConfigure, MotorFlags, RtJogAll,
    RtPositionFrame, RtRunMove, RtStopLoop, RunFlags, Scaled, Triggers,
};
use motion_move::Move;
use motion_rigs::Rig as _;
use motion_rigs::dmc_device::Setup;
use motion_rigs::dmc_host::{Answer, Command, Event, Shot, Table};

use super::motors::limits;
use super::stage::{Stage, devices, end_frame, jog, move_to, run, sample};

/// Compares the motors with the curves. Returns the moment of the move, in frames.
///
/// At a frame a motor is on the curve, with half a step for rounding. Between two frames it moves at a constant speed. The
/// greatest difference is then an eighth of the acceleration times the square of the time between frames.
pub(crate) fn hold(stage: &Stage, sample: &Move) -> Option<f64> {
    let moment = stage.scene.rig.moment()?;
    let between = 1.0 / sample.frames().rate.to_f64();
    let time = (moment - 1.0) * between;
    for axis in sample.axes() {
        let Some(dmc) = axis.dmc() else { continue };
        let curve = axis.curve();
        let zero = dmc.scale.position(0);
        let steps_per_unit = (dmc.scale.position(1) - zero).recip();
        let (here, planned) = (stage.at(dmc.motor), (curve.position(time) - zero) * steps_per_unit);
        let tolerance =
            curve.peak_acceleration().value.unwrap() * steps_per_unit.abs() * between * between / 8.0 + 0.51;
        assert!((here - planned).abs() <= tolerance, "motor {} at {moment}: {here}, planned {planned}", dmc.motor);
        if (moment - moment.round()).abs() < 1e-6 {
            assert!((here - planned).abs() <= 0.51, "motor {} at frame {moment}: {here}, {planned}", dmc.motor);
        }
    }
    Some(moment)
}

#[test]
fn a_move_is_uploaded_and_run() {
    for (name, fps, motors) in [("slide", 24_000, 1), ("crane", 23_976, 4)] {
        let (sample, table) = sample(name);
        let last = table.last_frame().0;
        let mut stage = Stage::up(Setup::default());
        assert_eq!(stage.upload(table.clone()), Ok(Answer::Done));
        assert_eq!(stage.scene.host.machine().is_loaded(), Some(true));
        for motor in (1..=motors).map(Motor) {
            for frame in (1..=last).map(FrameNumber) {
                assert_eq!(stage.rig().uploaded(motor, frame).map(|steps| steps.0), table.steps(motor, frame));
            }
        }

        let token = stage.begin(run(fps, 1, last, 500, RunFlags::empty()));
        stage.start(token);
        let mut moments = Vec::new();
        while stage.rig().machine().state() != State::Idle {
            stage.tick();
            moments.extend(hold(&stage, &sample));
        }
        assert_eq!(stage.end(token, 5000), Ok(Answer::Done));
        assert!(!stage.scene.host.may_move());
        assert_eq!(stage.rig().machine().on_frame(), Some(FrameNumber(last)));
        // The move takes its own time.
        for pair in moments.windows(2) {
            let gone = pair[1] - pair[0];
            assert!((gone - f64::from(fps) / 1e6).abs() < 1e-6, "{pair:?}");
        }
        assert!(moments[0] < 1.1 && *moments.last().unwrap() > f64::from(last) - 0.1, "{moments:?}");
        for motor in 1..=motors {
            assert_eq!(stage.steps(motor), table.steps(Motor(motor), FrameNumber(last)));
        }
        // The positions of each frame were told, with its number.
        let told: Vec<i32> = stage
            .told
            .iter()
            .filter_map(|(_, event)| match event {
                Event::Positions(positions) => Some(positions.moment.0.0 / 1000),
                _ => None,
            })
            .collect();
        assert!((1..=last).all(|frame| told.contains(&frame)));
    }
}

/// Stage whose device has a move, and stands on its first frame.
fn loaded(name: &str, setup: Setup) -> (Stage, Move) {
    let (sample, table) = sample(name);
    let mut stage = Stage::up(setup);
    stage.upload(table).unwrap();
    let to_frame = RtPositionFrame { frame: FrameNumber(1), tail: &[] };
    let token = stage.begin(to_frame);
    assert_eq!(stage.end(token, 60_000), Ok(Answer::Done));
    assert_eq!(stage.rig().machine().on_frame(), Some(FrameNumber(1)));
    (stage, sample)
}

/// Some devices give each motor that is not in the move a path of zeros, and move it there if it is enabled.
#[test]
fn a_motor_outside_the_move_stays_where_it_is() {
    for (setup, _) in devices() {
        let (_, table) = sample("slide");
        let mut stage = Stage::up(setup);
        for motor in [2, 3] {
            stage.ask(move_to(motor, 5000)).unwrap();
        }
        stage.pass(3000);
        stage.upload(table).unwrap();
        let to_frame = RtPositionFrame { frame: FrameNumber(9), tail: &[] };
        let token = stage.begin(to_frame);
        assert_eq!(stage.end(token, 60_000), Ok(Answer::Done));
        assert_eq!((stage.steps(2), stage.steps(3)), (Some(5000), Some(5000)));
        let shot = stage.token();
        stage.scene.command(Command::Shoot(shot, Shot::of(FrameNumber(1), 100)));
        stage.start(shot);
        assert_eq!(stage.end(shot, 20_000), Ok(Answer::Done));
        let token = stage.begin(run(24_000, 1, 25, 200, RunFlags::empty()));
        stage.start(token);
        assert_eq!(stage.end(token, 20_000), Ok(Answer::Done));
        assert_eq!((stage.steps(2), stage.steps(3)), (Some(5000), Some(5000)));
        // The next motion of the motor enables it again.
        stage.ask(move_to(2, 6000)).unwrap();
        stage.pass(3000);
        assert_eq!(stage.steps(2), Some(6000));
    }
}

/// A motor that is enabled while other motors follow a move would take part in the move on some devices.
#[test]
fn a_motor_outside_the_move_is_not_moved_during_a_run() {
    for (setup, _) in devices() {
        let (_, table) = sample("slide");
        let mut stage = Stage::up(setup);
        stage.ask(move_to(2, 5000)).unwrap();
        stage.pass(3000);
        stage.upload(table).unwrap();
        let token = stage.begin(run(24_000, 97, 121, 200, RunFlags::empty()));
        let travels = |stage: &Stage| stage.scene.host.machine().progress() == Some(Progress::Travels);
        while !travels(&stage) {
            stage.tick();
        }
        let busy = Err(Outcome::Refused(Refusal::Busy));
        assert_eq!(stage.ask(move_to(2, 6000)), busy);
        assert_eq!(stage.ask(jog(2, 100, 6000)), busy);
        let flags = MotorFlags::ENABLED;
        assert_eq!(stage.ask(MotorConfigure { motor: Motor(2), flags, tail: &[] }), busy);
        assert!(travels(&stage), "this is the scene");
        stage.start(token);
        assert_eq!(stage.end(token, 20_000), Ok(Answer::Done));
        assert_eq!(stage.steps(2), Some(5000), "{}", stage.rig().name());
        stage.ask(move_to(2, 6000)).unwrap();
        stage.pass(3000);
        assert_eq!(stage.steps(2), Some(6000));
    }
}

/// A device that refuses the begin of an upload keeps the move before, and the host has the data of another one.
#[test]
fn after_an_upload_that_was_refused_no_motor_follows_a_move() {
    for (setup, _) in devices() {
        let mut stage = Stage::up(setup);
        stage.upload(sample("slide").1).unwrap();
        let (_, other) = sample("crane");
        let token = stage.token();
        stage.scene.command(Command::Ask(token, jog(3, 50, 60_000).into()));
        assert_eq!(stage.end(token, 100), Ok(Answer::Done));
        let moves = Err(Outcome::Refused(Refusal::Device(AckCode::ERR_MOVING)));
        assert_eq!(stage.upload(other.clone()), moves, "{}", stage.rig().name());
        assert!(stage.stop() && stage.rests());
        stage.pass(3000);
        let unknown = Err(Outcome::Refused(Refusal::MoveUnknown));
        let to_frame = RtPositionFrame { frame: FrameNumber(9), tail: &[] };
        let run = run(24_000, 9, 20, 200, RunFlags::empty());
        for message in [HostMessage::from(to_frame), run.into()] {
            let token = stage.begin(message);
            assert_eq!(stage.end(token, 60_000), unknown, "{}", stage.rig().name());
        }
        let shot = stage.token();
        stage.scene.command(Command::Shoot(shot, Shot::of(FrameNumber(9), 100)));
        assert_eq!(stage.end(shot, 60_000), unknown);
        stage.upload(other).unwrap();
        let token = stage.begin(to_frame);
        assert_eq!(stage.end(token, 60_000), Ok(Answer::Done));
    }
}

/// Some devices give each motor a path of zeros, also if the upload has no motors at all.
#[test]
fn a_move_without_motors_moves_none() {
    for (setup, _) in devices() {
        let mut stage = Stage::up(setup);
        stage.ask(move_to(2, 5000)).unwrap();
        stage.pass(3000);
        stage.upload(Table::new(FrameNumber(1), 10)).unwrap();
        let token = stage.begin(RtPositionFrame { frame: FrameNumber(9), tail: &[] });
        stage.end(token, 60_000).unwrap();
        assert_eq!(stage.steps(2), Some(5000), "{}", stage.rig().name());
    }
}

#[test]
fn a_part_of_a_move_is_run_backwards_with_rolls() {
    for (setup, quirks) in devices() {
        let (mut stage, sample) = loaded("crane", setup);
        let token = stage.begin(run(48_000, 300, 200, 700, RunFlags::empty()));
        stage.start(token);
        let mut moments = Vec::new();
        while stage.rig().machine().state() != State::Idle {
            stage.tick();
            moments.extend(hold(&stage, &sample));
        }
        assert_eq!(stage.end(token, 5000), Ok(Answer::Done));
        assert!(moments.is_sorted_by(|one, other| one > other), "backwards");
        let end = end_frame(quirks, 200);
        assert!(moments[0] > 299.9 && *moments.last().unwrap() < f64::from(end.0) + 0.1);
        assert_eq!(stage.rig().machine().on_frame(), Some(end));
    }
}

#[test]
fn a_run_reaches_its_speed_with_a_constant_acceleration() {
    let (mut stage, _) = loaded("crane", Setup::default());
    let token = stage.begin(run(24_000, 200, 260, 500, RunFlags::empty()));
    stage.start(token);
    let mut before: Option<Vec<f64>> = None;
    let mut sharpest = 0.0_f64;
    while stage.rig().machine().state() != State::Idle {
        stage.tick();
        let now = stage.now();
        let speeds: Vec<f64> = stage.rig().motors().iter().map(|motor| motor.at(now).velocity).collect();
        if let Some(before) = &before {
            let jumps = speeds.iter().zip(before).map(|(now, before)| (now - before).abs());
            sharpest = jumps.fold(sharpest, f64::max);
        }
        before = Some(speeds);
    }
    // The fastest motor runs at 13,000 steps per second. With half a second for that, its speed changes by 26 in each
    // millisecond. At each frame its speed changes at once by as much as the curve changes in a frame: 417.
    assert!((10.0..450.0).contains(&sharpest), "{sharpest}");
    assert_eq!(stage.end(token, 5000), Ok(Answer::Done));
}

#[test]
fn a_loop_goes_on_until_it_is_ended() {
    let both = [RunFlags::LOOP, RunFlags::PING_PONG];
    for (flags, (setup, quirks)) in devices().flat_map(|device| both.map(|flags| (flags, device.clone()))) {
        let (mut stage, sample) = loaded("slide", setup);
        let token = stage.begin(run(24_000, 90, 120, 200, flags));
        stage.start(token);
        let (mut passes, mut before, mut ways) = (0, None, Vec::new());
        for millis in 0..30_000 {
            stage.tick();
            let moment = hold(&stage, &sample);
            if let (None, Some(moment)) = (before, moment) {
                passes += 1;
                ways.push(moment < 100.0);
                if passes == 3 {
                    let ends = stage.token();
                    stage.scene.command(Command::Ask(ends, RtStopLoop::default().into()));
                }
            }
            before = moment;
            if stage.rig().machine().state() == State::Idle {
                assert!(millis > 3000);
                break;
            }
        }
        assert_eq!(stage.end(token, 10_000), Ok(Answer::Done));
        let there_and_back = flags == RunFlags::PING_PONG;
        assert_eq!(ways, [true, !there_and_back, true]);
        assert_eq!(stage.rig().machine().on_frame(), Some(end_frame(quirks, 120)));
        let told =
            stage.told.iter().filter(|(_, event)| *event == Event::Machine(host::Event::PassEnded(token))).count();
        assert_eq!(told, if quirks.contains(Quirks::END_PER_PASS) { 2 } else { 0 });
    }
}

#[test]
fn all_motors_jog_along_the_move() {
    let (mut stage, sample) = loaded("crane", Setup::default());
    let jog_all = |fps: u32, frame| {
        let (fps_x1000, destination) = (FramesPerSecond(Scaled(fps * 1000)), FrameNumber(frame));
        RtJogAll { fps_x1000, destination, tail: &[] }
    };
    let token = stage.begin(jog_all(40, 400));
    let mut most = 0.0_f64;
    for _ in 0..3000 {
        stage.tick();
        most = hold(&stage, &sample).map_or(most, |moment| moment.max(most));
    }
    assert!((100.0..200.0).contains(&most), "three seconds at 40 frames a second: {most}");
    assert!(stage.stop());
    assert!(stage.end(token, 5000) == Err(Outcome::Failed(Failure::Stopped)));
    stage.pass(2000);
    let again = stage.begin(jog_all(40, 10));
    assert_eq!(stage.end(again, 5000), Err(Outcome::Refused(Refusal::Device(AckCode::ERR_NOT_IN_POSITION))));

    let to_frame = RtPositionFrame { frame: FrameNumber(100), tail: &[] };
    let token = stage.begin(to_frame);
    stage.end(token, 60_000).unwrap();
    let token = stage.begin(jog_all(40, 10));
    while stage.rig().machine().state() != State::Idle || stage.rig().machine().on_frame() == Some(FrameNumber(100)) {
        stage.tick();
        hold(&stage, &sample);
    }
    assert_eq!(stage.end(token, 5000), Ok(Answer::Done));
    assert_eq!(stage.rig().machine().on_frame(), Some(FrameNumber(10)));
}

#[test]
fn a_run_that_would_pass_a_limit_is_refused() {
    // The slide moves from 0 to 48,000 steps, and is fast in the middle.
    let (mut stage, _) = loaded("slide", Setup::default());
    let place = f64::from(sample("slide").1.steps(Motor(1), FrameNumber(60)).unwrap());
    #[expect(clippy::cast_possible_truncation, reason = "whole steps")]
    let place = place as i32;
    for (low, high, start, end, code) in [
        (-10, 20_000, 1, 193, AckCode::ERR_SOFT_UP),
        (10, 50_000, 1, 193, AckCode::ERR_SOFT_LOW),
        (place - 10, 50_000, 60, 100, AckCode::ERR_PREROLL),
        (-10, place + 10, 1, 60, AckCode::ERR_POSTROLL),
    ] {
        // First the motor goes to the first frame of the run, with wide limits.
        let (wide, begin) = (limits(1, -100_000, 100_000), RtPositionFrame { frame: FrameNumber(start), tail: &[] });
        stage.ask(wide).unwrap();
        let token = stage.begin(begin);
        stage.end(token, 60_000).unwrap();
        stage.ask(limits(1, low, high)).unwrap();
        let token = stage.begin(run(24_000, start, end, 500, RunFlags::empty()));
        let ended = stage.end(token, 60_000);
        assert_eq!(ended, Err(Outcome::Refused(Refusal::Device(code))));
        assert!(stage.all_rest());
        assert!(stage.stop() && stage.rests());
    }
}

#[test]
fn the_operator_may_start_a_run() {
    let (mut stage, sample) = loaded("slide", Setup::default());
    let token = stage.begin(run(24_000, 1, 25, 100, RunFlags::empty()));
    stage.wait(60_000, |event| (*event == Event::Machine(host::Event::Armed(token))).then_some(())).unwrap();
    let now = stage.now();
    stage.rig().operator_go(now);
    let mut followed = 0;
    while stage.rig().machine().state() != State::Idle {
        stage.tick();
        followed += u32::from(hold(&stage, &sample).is_some());
    }
    assert!((999..=1000).contains(&followed), "24 frames: {followed} ms");
    assert_eq!(stage.end(token, 5000), Ok(Answer::Done));
    assert!(stage.told.iter().any(|(_, event)| *event == Event::Machine(host::Event::Started(token))));
}

#[test]
fn lights_and_outputs_run_along_and_outputs_go_off_at_the_end() {
    let (_, table) = sample("slide");
    let on = |frame: u32| if frame.is_multiple_of(3) { Triggers(0b100) } else { Triggers::NONE };
    let level = |frame: u32| u8::try_from(frame).unwrap();
    let table = table
        .with_light(DmxChannel(2), (1..=193).map(level).collect())
        .with_outputs(Triggers(0b110), (1..=193).map(on).collect());
    for (sync, stopped) in [(true, false), (true, true), (false, false)] {
        let mut stage = Stage::up(Setup::default());
        stage.upload(table.clone()).unwrap();
        let run = run(24_000, 1, 60, 0, RunFlags::empty());
        let token = stage.begin(RtRunMove { sync_dmx: Bool::from(sync), ..run });
        stage.start(token);
        let mut seen = 0;
        while stage.rig().machine().state() != State::Idle {
            stage.tick();
            let Some(moment) = stage.rig().moment() else { continue };
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 1 to 60")]
            let frame = moment.floor() as u32;
            let (outputs, light) = (stage.rig().outputs(), stage.rig().levels()[1]);
            if sync {
                assert_eq!((outputs, light), (on(frame), level(frame)), "frame {frame}");
                seen += outputs.0;
            } else {
                assert_eq!((outputs, light), (Triggers::NONE, 0));
            }
            // In the middle of frame 30, whose output is on.
            if stopped && moment > 30.5 {
                assert!(stage.stop());
                assert_eq!(stage.rig().outputs(), Triggers::NONE);
            }
        }
        assert_eq!(stage.rig().outputs(), Triggers::NONE);
        assert_eq!(stage.end(token, 5000).is_ok(), !stopped);
        assert_eq!(seen > 0, sync);
    }
}
