//! Planned moves: shoot, move, shoot; time lapse; video; ping-pong.

use hoot_proto::HostMessage;
use hoot_proto::device::ProgramState;
use hoot_proto::message::{self, Easing, Milliseconds, Motor, ProgramMode, Span, Steps};
use hoot_proto::program::Plan;
use motion_rigs::Rig;
use motion_rigs::hoot_node::{HootNode, Setup};

use crate::world::{ONE, PAUSE, START, STATUS, Stage, enable_camera, mode, photos, planned, smooth, stage};

/// Stage with a node that has planned moves for some motors, and these messages for its camera.
fn with(mode_of: ProgramMode, plans: &[(Motor, u16, Plan)], camera: Vec<HostMessage<'static>>) -> Stage<HootNode> {
    let mut stage = stage(Setup::default());
    stage.ok(mode(mode_of));
    for (motor, lead_in, plan) in plans {
        stage.enable(*motor, 1000.0);
        for message in planned(*motor, *lead_in, *plan) {
            stage.ok(message);
        }
        stage.ok(message::MotorSendToStart { motor: *motor });
    }
    for message in camera {
        stage.ok(message);
    }
    stage.until(20_000, |stage| stage.is_at_rest());
    stage
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a program of some seconds")]
fn moment(stage: &Stage<HootNode>) -> Option<u32> {
    stage.scene.rig.moment().map(|moment| moment as u32)
}

/// In video mode, motors follow their plans by whole milliseconds. The plan of motor 1 is the curve 3u² - 2u³ of a move file
/// with two smooth key frames, apart from whole steps and the 20 fractional bits of a plan.
#[test]
fn in_a_video_each_motor_is_exactly_on_its_plan() {
    let other = Plan { start: Steps(500), stop: Steps(-1500), travel: Span(2000), ..smooth() };
    let mut stage = with(ProgramMode::VIDEO, &[(ONE, 0, smooth()), (Motor::Three, 700, other)], photos_off());
    stage.send_to(crate::world::NODE, START);
    stage.until(300, |stage| stage.program() == ProgramState::Running);
    let began = stage.now() - u64::from(moment(&stage).unwrap());
    while stage.program() == ProgramState::Running {
        let gone = u32::try_from(stage.now() - began).unwrap();
        assert_eq!(moment(&stage), Some(gone));
        assert_eq!(stage.place(0).to_bits(), f64::from(smooth().at(gone).0).to_bits(), "after {gone} ms");
        let place = other.at(gone.saturating_sub(700)).0;
        assert_eq!(stage.place(2).to_bits(), f64::from(place).to_bits(), "after {gone} ms");
        let u = f64::from(gone) / 3000.0;
        let curve = 6000.0 * (3.0 - 2.0 * u) * u * u;
        assert!((stage.place(0) - curve).abs() <= 1.01, "{} for {curve}", stage.place(0));
        stage.tick();
    }
    assert_eq!(stage.now() - began, 3000);
    assert_eq!((stage.position(ONE), stage.position(Motor::Three)), (6000, -1500));
    assert!(!stage.is_running(ONE) && !stage.is_running(Motor::Three) && stage.scene.rig.camera().taken() == 0);
}

fn photos_off() -> Vec<HostMessage<'static>> {
    vec![enable_camera(false).into()]
}

/// Between two photos the motor moves in one direction, from the position of the first to the position of the second.
#[test]
fn shoot_move_shoot_takes_each_photo_at_rest_and_on_the_plan() {
    let plan =
        Plan { travel: Span(9), acceleration: Span(3), deceleration: Span(3), easing: Easing::LINEAR, ..smooth() };
    let mut stage = with(ProgramMode::SMS, &[(ONE, 0, plan)], photos(10, 100, 500));
    stage.ok(START);
    let mut before = (0, stage.place(0));
    while stage.program() == ProgramState::Running {
        let taken = u32::try_from(stage.scene.rig.camera().taken()).unwrap();
        let place = stage.place(0);
        if stage.scene.rig.camera().is_open() {
            assert_eq!(place.to_bits(), f64::from(plan.at(taken).0).to_bits(), "photo {}", taken + 1);
        }
        let (from, to) = (plan.at(taken.saturating_sub(1)).0, plan.at(taken).0);
        assert!((f64::from(from)..=f64::from(to)).contains(&place), "{place} after photo {taken}");
        assert!(before.1 <= place);
        before = (taken, place);
        stage.tick();
    }
    assert_eq!((stage.scene.rig.camera().taken(), stage.position(ONE)), (10, 6000));
    let opened: Vec<_> = stage.scene.rig.camera().photos().map(|photo| photo.opened.0).collect();
    // Each photo is due at its interval, and waits for the motor if the motor is later.
    assert!((0_u64..).zip(&opened).all(|(photo, at)| *at >= opened[0] + 500 * photo), "{opened:?}");
    assert_eq!(opened[1] - opened[0], 500);
}

#[test]
fn in_a_time_lapse_the_motor_moves_by_the_clock_while_photos_are_taken() {
    let plan = Plan { travel: Span(3200), acceleration: Span(0), deceleration: Span(0), ..smooth() };
    let mut stage = with(ProgramMode::CONTINUOUS, &[(ONE, 0, plan)], photos(10, 100, 400));
    stage.ok(START);
    let mut first_move = None;
    while stage.program() == ProgramState::Running {
        if stage.scene.rig.camera().taken() == 1 && first_move.is_none() {
            first_move = Some(stage.now());
        }
        if let Some(began) = first_move {
            // The plan has 6000 steps in 3200 ms. The start of the move is known to a tick.
            let gone = f64::from(u32::try_from(stage.now() - began).unwrap());
            let planned = (gone * 750.0 / 400.0).min(6000.0);
            assert!((stage.place(0) - planned).abs() <= 2.0 * 750.0 / 400.0, "{} for {planned}", stage.place(0));
        }
        stage.tick();
    }
    assert_eq!((stage.scene.rig.camera().taken(), stage.position(ONE)), (10, 6000));
}

/// The motor is back at the start after twice the time of the plan.
#[test]
fn a_ping_pong_goes_on_until_it_is_stopped() {
    let plan =
        Plan { travel: Span(1000), acceleration: Span(500), deceleration: Span(500), stop: Steps(900), ..smooth() };
    let mut stage = with(ProgramMode::VIDEO, &[(ONE, 0, plan)], photos_off());
    stage.ok(message::SetPingPong { ping_pong: true.into() });
    stage.send_to(crate::world::NODE, START);
    stage.until(300, |stage| stage.program() == ProgramState::Running);
    let began = stage.now() - u64::from(moment(&stage).unwrap());
    for _ in 0..4500 {
        let gone = u32::try_from(stage.now() - began).unwrap();
        let (turn, phase) = (gone / 1000, gone % 1000);
        let there = plan.at(phase).0;
        let planned = if turn % 2 == 0 { there } else { 900 - there };
        // Positions are rounded towards the start, which is the other end on the way back.
        assert!((stage.place(0) - f64::from(planned)).abs() <= 1.0, "{} for {planned} at {gone}", stage.place(0));
        stage.tick();
    }
    stage.ok(crate::world::STOP);
    assert!(stage.is_at_rest() && stage.program() == ProgramState::Stopped);
}

#[test]
fn a_paused_program_goes_on_along_its_plan() {
    let mut stage = with(ProgramMode::VIDEO, &[(ONE, 0, smooth())], photos_off());
    stage.ok(START);
    stage.pass(1000);
    stage.ok(PAUSE);
    let place = stage.place(0);
    assert!(stage.is_at_rest() && place > 100.0);
    stage.pass(500);
    assert_eq!(stage.place(0).to_bits(), place.to_bits());
    stage.ok(START);
    let mut before = stage.place(0);
    while stage.program() == ProgramState::Running {
        let planned = f64::from(smooth().at(moment(&stage).unwrap()).0);
        assert!((stage.place(0) - planned).abs() <= 5.0, "{} for {planned}", stage.place(0));
        assert!(stage.place(0) >= before);
        before = stage.place(0);
        stage.tick();
    }
    assert_eq!(stage.position(ONE), 6000);
    stage.ok(STATUS);
}

/// A motor that is not at the start of its plan moves at its greatest speed, and no faster, until it has reached the plan.
#[test]
fn a_motor_catches_up_with_its_plan() {
    let plan = Plan { start: Steps(3000), stop: Steps(9000), ..smooth() };
    let mut stage = with(ProgramMode::VIDEO, &[(ONE, 0, plan)], photos_off());
    stage.ok(message::MotorSendHome { motor: ONE });
    stage.until(20_000, |stage| stage.is_at_rest());
    stage.ok(message::SetMaxRunTime { max_run_time: Milliseconds(10_000) });
    stage.ok(START);
    let mut before = stage.place(0);
    let mut caught_up = None;
    while stage.program() == ProgramState::Running {
        let place = stage.place(0);
        assert!((place - before).abs() <= 5.0 + 1e-9, "5000 steps a second");
        let planned = f64::from(plan.at(moment(&stage).unwrap()).0);
        if caught_up.is_none() && (place - planned).abs() < 0.5 {
            caught_up = moment(&stage);
        }
        assert!(caught_up.is_none() || (place - planned).abs() < 0.5, "{place} for {planned}");
        before = place;
        stage.tick();
    }
    assert!(caught_up.is_some_and(|at| at < 1500), "{caught_up:?}");
    assert_eq!(stage.position(ONE), 9000);
}
