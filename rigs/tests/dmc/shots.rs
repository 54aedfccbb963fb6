//! Shots: photos along a move, with motors that rest or move.

use dmc_proto::device::{Quirks, State};
use dmc_proto::host::{self, Outcome, Refusal};
use dmc_proto::message::{
    AckCode, CameraFlags, Degrees, FrameNumber, GioCam, Motor, MotorPair, RtPositionFrame, RunFlags, Steps,
};
use motion_rigs::dmc_device::Setup;
use motion_rigs::dmc_host::{Answer, Command, Event, Shot};

use super::stage::{Stage, devices, run, sample};

#[test]
fn a_move_is_shot_frame_by_frame() {
    for (setup, quirks) in devices() {
        let (_, table) = sample("slide");
        let mut stage = Stage::up(setup);
        stage.upload(table.clone()).unwrap();
        for (number, frame) in (1..=193).step_by(64).enumerate() {
            let token = stage.token();
            stage.scene.command(Command::Shoot(token, Shot::of(FrameNumber(frame), 200)));
            stage.start(token);
            assert_eq!(stage.end(token, 20_000), Ok(Answer::Done));
            let photo = *stage.rig().photos().last().unwrap();
            assert_eq!((photo.frame, photo.until.unwrap().since(photo.at)), (Some(frame), 200));
            assert_eq!(stage.rig().photo_count(), u64::try_from(number).unwrap() + 1);
            assert_eq!(stage.steps(1), table.steps(Motor(1), FrameNumber(frame)));
            let is_on = !quirks.contains(Quirks::STAYS_AFTER_SHOT);
            assert_eq!(stage.rig().machine().on_frame(), is_on.then_some(FrameNumber(frame)));
        }
    }
}

/// Blur of an earlier shot is taken back, and a motor without blur rests.
#[test]
fn only_the_motors_of_a_shot_blur() {
    for (setup, _) in devices() {
        let (_, table) = sample("slide");
        let (mut stage, frame) = (Stage::up(setup), FrameNumber(90));
        stage.upload(table.clone()).unwrap();
        let (here, next) = (table.steps(Motor(1), frame).unwrap(), table.steps(Motor(1), FrameNumber(91)).unwrap());
        for motors in [vec![MotorPair::new(Motor(1), Steps(here), Steps(next))], vec![]] {
            let blurs = !motors.is_empty();
            let token = stage.token();
            stage.scene.command(Command::Shoot(token, Shot { motors, ..Shot::of(frame, 200) }));
            stage.start(token);
            let mut places = vec![];
            while stage.rig().machine().state() != State::Idle {
                stage.tick();
                if stage.rig().photos().last().is_some_and(|photo| photo.until.is_none()) {
                    places.push(stage.at(1));
                }
            }
            assert_eq!(stage.end(token, 5000), Ok(Answer::Done));
            let way = places.last().unwrap() - places[0];
            let wanted = if blurs { f64::from(next - here) } else { 0.0 };
            assert!((way - wanted).abs() < 4.0, "{way}, not {wanted}");
        }
    }
}

#[test]
fn a_blurred_motor_moves_while_the_shutter_is_open() {
    for is_second_form in [false, true] {
        let (_, table) = sample("slide");
        let mut stage = Stage::up(Setup::default());
        // A motor with a way of its own belongs to the move as well: some devices move it to 0 otherwise.
        let shot_without = stage.token();
        stage.upload(table.clone()).unwrap();
        let motors = vec![MotorPair::new(Motor(4), Steps(0), Steps(-400))];
        stage.scene.command(Command::Shoot(shot_without, Shot { motors, ..Shot::of(FrameNumber(5), 1000) }));
        let refused = Err(Outcome::Refused(Refusal::NotInMove(Motor(4))));
        assert_eq!(stage.end(shot_without, 1000), refused);
        stage.upload(table.clone().with(Motor(4), vec![0])).unwrap();
        let pair = MotorPair::new(Motor(1), Steps(1000), Steps(3000));
        let (open_angle, close_angle) = (Degrees(0), Degrees(180));
        let motors = vec![pair, MotorPair::new(Motor(4), Steps(0), Steps(-400))];
        let mut shot = Shot { motors, is_second_form, open_angle, close_angle, ..Shot::of(FrameNumber(5), 1000) };
        shot.blur_x10.0.0 = 500;
        let token = stage.token();
        stage.scene.command(Command::Shoot(token, shot));
        stage.start(token);
        let mut open = 0;
        while stage.rig().machine().state() != State::Idle {
            stage.tick();
            let now = stage.now();
            let Some(photo) = stage.rig().photos().last().copied() else { continue };
            if photo.until.is_none() {
                open += 1;
                let part = f64::from(u32::try_from(now.since(photo.at)).unwrap()) / 1000.0;
                // A shutter of 180 degrees is half of the way, at a constant speed, to within a millisecond.
                assert!((stage.at(1) - (1000.0 + 1000.0 * part)).abs() <= 1.01, "{} at {part}", stage.at(1));
                assert!((stage.at(4) + 200.0 * part).abs() <= 0.21, "{} at {part}", stage.at(4));
            }
        }
        assert!((999..=1001).contains(&open), "{open} ms");
        assert_eq!(stage.end(token, 5000), Ok(Answer::Done));
        assert_eq!(stage.steps(1), table.steps(Motor(1), FrameNumber(5)), "the motor is back on the frame");
    }
}

#[test]
fn without_a_move_a_shot_needs_motors_of_its_own() {
    let mut stage = Stage::up(Setup::default());
    let token = stage.token();
    stage.scene.command(Command::Shoot(token, Shot::of(FrameNumber(1), 100)));
    assert_eq!(stage.end(token, 1000), Err(Outcome::Refused(Refusal::Device(AckCode::ERR_GENERAL))));
    assert!(!stage.scene.host.may_move());
    let motors = vec![MotorPair::new(Motor(2), Steps(0), Steps(100))];
    let token = stage.token();
    stage.scene.command(Command::Shoot(token, Shot { motors, ..Shot::of(FrameNumber(1), 100) }));
    stage.start(token);
    assert_eq!(stage.end(token, 20_000), Ok(Answer::Done));
    assert_eq!(stage.rig().photo_count(), 1);
}

#[test]
fn the_camera_is_triggered_by_hand_and_by_runs() {
    let mut stage = Stage::up(Setup::default());
    for flags in [CameraFlags::SHUTTER, CameraFlags::empty()] {
        stage.ask(GioCam { flags, tail: &[] }).unwrap();
        assert_eq!(stage.scene.host.may_move(), !flags.is_empty());
        stage.pass(300);
    }
    let photo = *stage.rig().photos().last().unwrap();
    assert!((300..320).contains(&photo.until.unwrap().since(photo.at)));

    let (_, table) = sample("slide");
    stage.upload(table).unwrap();
    let token = stage.begin(run(24_000, 1, 49, 0, RunFlags::CAMERA_EVERY_FRAME));
    stage.start(token);
    assert_eq!(stage.end(token, 20_000), Ok(Answer::Done));
    let frames: Vec<_> = stage.rig().photos().filter_map(|photo| photo.frame).collect();
    assert_eq!(frames, (1..=49).collect::<Vec<_>>());
}

#[test]
fn a_stop_closes_the_shutter() {
    for (setup, _) in devices() {
        for is_hard in [false, true] {
            stop_in_a_shot(setup.clone(), is_hard);
        }
    }
}

fn stop_in_a_shot(setup: Setup, is_hard: bool) {
    let (_, table) = sample("slide");
    let mut stage = Stage::up(setup);
    stage.upload(table).unwrap();
    let token = stage.token();
    stage.scene.command(Command::Shoot(token, Shot::of(FrameNumber(1), 60_000)));
    stage.start(token);
    stage.wait(5000, |event| matches!(event, Event::Machine(host::Event::Started(_))).then_some(())).unwrap();
    stage.pass(1000);
    assert!(stage.rig().photos().last().unwrap().until.is_none());
    if is_hard {
        let now = stage.now();
        stage.rig().emergency_stop(now, true);
        stage.pass(300);
        let now = stage.now();
        stage.rig().emergency_stop(now, false);
    } else {
        assert!(stage.stop());
    }
    stage.pass(100);
    assert!(stage.rig().photos().last().unwrap().until.is_some(), "{}, hard: {is_hard}", stage.rig().name());
    stage.pass(3000);
    // After a hard stop, only a stop makes sure that the shot does not begin any more.
    assert!(!is_hard || stage.stop());
    assert!(stage.rests(), "{}, hard: {is_hard}", stage.rig().name());
    // A way to a frame begins only when all motors rest, and the rig is no longer locked.
    let to_frame = RtPositionFrame { frame: FrameNumber(193), tail: &[] };
    let token = stage.begin(to_frame);
    assert_eq!(stage.end(token, 60_000), Ok(Answer::Done));
    assert_eq!(stage.rig().machine().on_frame(), Some(FrameNumber(193)));
}
