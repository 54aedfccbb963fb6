//! Program of a node: hoot, section 4.2.

use super::world::*;
use hoot_proto::device::{Command, Contact, Effect, Event, Input, Motion, Options, Phase, ProgramState};
use hoot_proto::message::{
    self, AltMode, HostMessage, Milliseconds, Motor, ProgramMode, ShortMilliseconds, ShortShots, ShortSpan, Span,
    StartDelay, Steps,
};
use hoot_proto::query::Profile;
use motion_core::time::Millis;

const ONE: Motor = Motor::One;
const RUNNING: Event = Event::Program(ProgramState::Running);
const STOPPED: Event = Event::Program(ProgramState::Stopped);
const PAUSED: Event = Event::Program(ProgramState::Paused);

/// Shoot, move, shoot: exposures of 100 ms, a second from one to the next; motor 1 goes 100 steps a shot, three times.
fn sms() -> Node {
    let mut node = moving(ProgramMode::SMS);
    node.ok(HostMessage::from(message::CameraSetEnable { enable: YES }));
    let exposure_time = Milliseconds(100);
    node.ok(HostMessage::from(message::CameraSetExposureTime { exposure_time }));
    interval(&mut node, 1000);
    node
}

fn moving(program_mode: ProgramMode) -> Node {
    moving_with(Options::default(), program_mode)
}

fn moving_with(options: Options, program_mode: ProgramMode) -> Node {
    let mut node = Node::ready_with(options);
    node.ok(HostMessage::from(message::SetProgramMode { program_mode }));
    let motor = ONE;
    node.ok(HostMessage::from(message::MotorSetProgramStop { motor, position: Steps(300) }));
    travel(&mut node, 3);
    node
}

fn travel(node: &mut Node, travel: u32) {
    node.ok(HostMessage::from(message::MotorSetTravel { motor: ONE, travel: Span(travel) }));
}

fn interval(node: &mut Node, interval: u32) {
    let interval = Milliseconds(interval);
    node.ok(HostMessage::from(message::CameraSetInterval { interval }));
}

fn max_shots(node: &mut Node, shots: u16) {
    let max_shots = ShortShots(shots);
    node.ok(HostMessage::from(message::CameraSetMaxShots { max_shots }));
}

fn lead_in(node: &mut Node, lead_in: u16) {
    let lead_in = ShortSpan(lead_in);
    node.ok(HostMessage::from(message::MotorSetLeadIn { motor: ONE, lead_in }));
}

fn ping_pong(node: &mut Node) {
    node.ok(HostMessage::from(message::SetPingPong { ping_pong: YES }));
}

fn start_delay(node: &mut Node, delay: u32) {
    node.ok(HostMessage::from(message::SetStartDelay { start_delay: StartDelay(delay) }));
}

fn alt(node: &mut Node, ring: AltMode) {
    node.ok(HostMessage::from(message::SetAltModes { ring, tip: AltMode::OFF }));
}

fn run_time(node: &Node) -> u64 {
    node.machine.program().run_time(Millis(node.now))
}

/// Lets the motor arrive at the target of the last event.
fn arrive(node: &mut Node, steps: i32) -> Vec<Event<'static>> {
    node.tell(Input::Position { motor: ONE, position: Steps(steps) });
    node.tell(Input::Arrived(ONE))
}

// 4.2-1
#[test]
fn a_start_begins_with_the_first_picture() {
    let sub_address = message::AnySubAddress(0);
    let broadcast = HostMessage::from(message::BroadcastStart { sub_address });
    let begun = [RUNNING, camera(false, true)];
    assert_eq!(sms().ok(START), begun);
    assert_eq!(sms().send(hoot_proto::Address::BROADCAST, broadcast).event_list()[..], begun);
    assert_eq!(sms().tell(Input::Command(Command::Start)), begun);
    let mut node = sms();
    alt(&mut node, AltMode::START);
    assert_eq!(node.tell(Input::Alt(Contact::Ring)), begun);
    // Other motion is stopped first (decision H-3).
    let mut node = sms();
    node.ok(run(Motor::Two));
    assert_eq!(node.ok(START), [motion(Motor::Two, Motion::Stop), RUNNING, camera(false, true)]);
}

// 4.2-2
#[test]
fn a_delay_comes_before_the_start() {
    let mut node = sms();
    start_delay(&mut node, 2);
    assert_eq!(node.ok(START), [Event::Program(ProgramState::Delay)]);
    assert_eq!(node.pass(1999), []);
    assert_eq!(node.pass(1), [(1, RUNNING), (1, camera(false, true))]);
    // The delay is in milliseconds for later firmware, and if the firmware is not known.
    for profile in [Profile::V070, "v0.40".parse().unwrap()] {
        let mut node = Node::ready_with(Options::default().with_profile(profile));
        start_delay(&mut node, 2);
        node.ok(START);
        assert_eq!(node.pass(2)[0], (2, RUNNING));
    }
}

// 4.2-3
#[test]
fn a_pause_stops_all_and_keeps_the_counters() {
    let sub_address = message::AnySubAddress(0);
    let mut node = sms();
    node.ok(START);
    node.pass(100);
    node.pass(1);
    assert!(node.running(ONE));
    assert_eq!(node.ok(PAUSE), [motion(ONE, Motion::Stop), PAUSED]);
    assert_eq!((run_time(&node), node.machine.program().shots()), (101, 1));
    node.pass(5000);
    assert_eq!((run_time(&node), node.wake), (101, None), "the run time does not grow");

    let mut node = sms();
    node.ok(START);
    let pause = HostMessage::from(message::BroadcastPause { sub_address });
    let events = node.send(hoot_proto::Address::BROADCAST, pause).event_list();
    assert_eq!(events[..], [camera(false, false), PAUSED]);
}

// 4.2-4
#[test]
fn after_a_pause_a_program_goes_on() {
    let mut node = sms();
    node.ok(START);
    node.pass(100);
    node.pass(50);
    node.ok(PAUSE);
    node.pass(700);
    assert_eq!(node.ok(START), [RUNNING, to(ONE, 100)], "the move that was cut short (decision H-11)");
    assert_eq!((run_time(&node), node.machine.program().shots()), (150, 1));
    assert_eq!(arrive(&mut node, 100), [camera(false, true)], "then the next picture is taken");
    // A picture that the pause cut short is taken again.
    node.ok(STOP);
    node.ok(START);
    node.pass(20);
    node.ok(PAUSE);
    assert_eq!(node.ok(START), [RUNNING, camera(false, true)]);
    assert_eq!(node.machine.program().shots(), 0);
    // A delay goes on too.
    let mut node = sms();
    start_delay(&mut node, 2);
    node.ok(START);
    node.pass(1500);
    node.ok(PAUSE);
    node.pass(1000);
    assert_eq!(node.ok(START), [Event::Program(ProgramState::Delay)]);
    assert_eq!(node.pass(500)[0], (500, RUNNING));
}

// 4.2-5
#[test]
fn a_stop_resets_the_counters() {
    let mut node = sms();
    alt(&mut node, AltMode::STOP);
    let sub_address = message::AnySubAddress(0);
    let broadcast = HostMessage::from(message::BroadcastStop { sub_address });
    for stop in 0..4 {
        node.ok(START);
        node.pass(101);
        let events = match stop {
            0 => node.ok(STOP),
            1 => node.tell(Input::Command(Command::Stop)),
            2 => node.tell(Input::Alt(Contact::Ring)),
            _ => node.send(hoot_proto::Address::BROADCAST, broadcast).event_list(),
        };
        assert_eq!(events, [motion(ONE, Motion::Stop), STOPPED]);
        assert_eq!((run_time(&node), node.machine.program().shots(), node.wake), (0, 0, None));
    }
    node.ok(START);
    node.ok(PAUSE);
    assert_eq!(node.ok(STOP), [STOPPED]);
    node.ok(START);
    assert_eq!(node.pass(101).last(), Some(&(101, to(ONE, 100))), "the plan begins anew");
}

// 4.2-6
#[test]
fn the_timing_master_stops_after_the_greatest_run_time() {
    let mut node = sms();
    node.ok(HostMessage::from(message::SetMaxRunTime { max_run_time: Milliseconds(50) }));
    node.ok(START);
    assert_eq!(node.pass(50), [], "the time must be exceeded");
    assert_eq!(node.pass(1), [(1, camera(false, false)), (1, STOPPED)]);

    node.ok(HostMessage::from(message::SetTimingMaster { timing_master: NO }));
    node.ok(START);
    assert_eq!((node.pass(5000), node.machine.program().state()), (vec![], ProgramState::Running));
}

// 4.2-7
#[test]
fn a_program_ends_with_the_last_picture_or_the_last_move() {
    let mut node = sms();
    max_shots(&mut node, 2);
    node.ok(START);
    assert_eq!(node.pass(101).last(), Some(&(101, to(ONE, 100))));
    assert_eq!(arrive(&mut node, 100), []);
    assert_eq!(node.pass(1000), [(899, camera(false, true)), (999, camera(false, false)), (1000, to(ONE, 200))]);
    assert_eq!(arrive(&mut node, 200), [STOPPED]);
    assert_eq!((node.machine.program().shots(), node.wake), (0, None));

    let mut node = moving(ProgramMode::SMS);
    assert_eq!(node.ok(START), [RUNNING, to(ONE, 100)]);
    assert_eq!(arrive(&mut node, 100), []);
    assert_eq!(node.pass(1), [(1, to(ONE, 200))]);
    arrive(&mut node, 200);
    assert_eq!(node.pass(1), [(1, to(ONE, 300))]);
    assert_eq!(arrive(&mut node, 300), [STOPPED]);
    // Without pictures and moves, the program is over at once.
    let mut node = Node::ready();
    assert_eq!(node.ok(START), [RUNNING, STOPPED]);
}

// 4.2-8
#[test]
fn ping_pong_swaps_start_and_stop() {
    let mut node = moving(ProgramMode::SMS);
    ping_pong(&mut node);
    node.ok(START);
    for (place, next) in [(100, 200), (200, 300)] {
        assert_eq!(arrive(&mut node, place), []);
        assert_eq!(node.pass(1), [(1, to(ONE, next))]);
    }
    assert_eq!(arrive(&mut node, 300), [STOPPED, RUNNING]);
    let plan = node.machine.motor(ONE).settings().plan;
    assert_eq!((plan.start.0, plan.stop.0), (300, 0));
    assert_eq!(node.pass(1), [(1, to(ONE, 200))]);
    assert_eq!(node.ok(STOP), [motion(ONE, Motion::Stop), STOPPED]);
    assert_eq!(node.pass(5000), [], "after a stop nothing goes on");
    // Without a motor that moves there is no way back (decision H-12).
    let mut node = Node::ready();
    ping_pong(&mut node);
    assert_eq!(node.ok(START), [RUNNING, STOPPED]);
    assert_eq!(node.wake, None);
}

// 4.2-9
#[test]
fn the_emergency_button_pauses_a_program() {
    let button = Input::Command(Command::EmergencyStop);
    let mut node = sms();
    node.ok(START);
    assert_eq!(node.tell(button), [camera(false, false), PAUSED]);
    // The button stops all motors, with or without a program (decision H-6).
    let mut node = sms();
    node.ok(run(Motor::Three));
    assert_eq!(node.tell(button), [motion(Motor::Three, Motion::Stop)]);
}

// 4.2-27
#[test]
fn a_node_may_move_while_its_program_its_camera_or_a_motor_is_at_work() {
    let button = Input::Command(Command::EmergencyStop);
    let mut node = sms();
    start_delay(&mut node, 2);
    assert!(!node.machine.may_move());
    node.ok(START);
    assert!(node.machine.may_move(), "the program waits for its delay");
    node.pass(2);
    assert!(node.machine.may_move(), "the program runs");
    node.tell(button);
    assert!(!node.machine.may_move(), "a paused program moves nothing");
    node.ok(HostMessage::from(message::CameraExpose {}));
    assert!(node.machine.may_move(), "the shutter is open");
    node.pass(200);
    assert!(!node.machine.may_move(), "the picture is stored");
    for motor in Motor::ALL {
        node.ok(run(motor));
        assert!(node.machine.may_move(), "motor {motor} runs");
        node.tell(button);
        assert!(!node.machine.may_move());
    }
    node.ok(move_by(ONE, 10));
    assert!(node.machine.may_move(), "the motor moves");
    arrive(&mut node, 10);
    assert!(!node.machine.may_move());
}

// 4.2-10
#[test]
fn a_start_while_the_program_runs_changes_nothing() {
    for delay in [0, 5] {
        let mut node = sms();
        start_delay(&mut node, delay);
        node.ok(START);
        node.pass(60);
        let before = node.machine.clone();
        assert_eq!(node.ok(START), []);
        assert_eq!(node.machine.program(), before.program());
        assert_eq!(run_time(&node), 60);
    }
}

// 4.2-11
#[test]
fn run_status_has_the_numbers_of_the_profile() {
    let status = |node: &mut Node| node.ask(HostMessage::from(message::RunStatus {}))[1];
    for (profile, words) in [(Profile::SHEET, [0, 1, 1, 0]), (Profile::V070, [0, 3, 2, 1])] {
        let mut node = moving_with(Options::default().with_profile(profile), ProgramMode::SMS);
        start_delay(&mut node, 1);
        let mut found = vec![status(&mut node)];
        node.ok(START);
        found.push(status(&mut node));
        node.pass(1000);
        found.push(status(&mut node));
        node.ok(PAUSE);
        found.push(status(&mut node));
        assert_eq!(found, words, "{profile:?}: stopped, delay, running, paused");
    }
    let mut node = sms();
    node.ok(START);
    node.pass(700);
    assert_eq!(node.ask(HostMessage::from(message::RunTime {})), [4, 0, 0, 2, 188]);
}

// 4.2-12
#[test]
fn shoot_move_shoot_waits_for_the_motors() {
    let mut node = sms();
    lead_in(&mut node, 1);
    let phase = |node: &Node| node.machine.program().phase();
    node.ok(START);
    assert_eq!(phase(&node), Phase::Shoot);
    assert_eq!(node.pass(1000), [(100, camera(false, false)), (1000, camera(false, true))], "the lead-in: one shot");
    assert_eq!(node.pass(101), [(100, camera(false, false)), (101, to(ONE, 100))]);
    assert_eq!(phase(&node), Phase::Move);
    assert_eq!(node.pass(5000), [], "however long the motor takes");
    assert_eq!(arrive(&mut node, 100), [camera(false, true)], "then at once, because the interval is over");
    // This is the third and last move. From then on only pictures are taken.
    for place in [200, 300] {
        assert_eq!(node.pass(101).last(), Some(&(101, to(ONE, place))));
        arrive(&mut node, place);
        assert_eq!(node.pass(899).last(), Some(&(899, camera(false, true))));
    }
    assert_eq!(node.pass(1000), [(100, camera(false, false)), (1000, camera(false, true))]);
}

// 4.2-13
#[test]
fn the_mirror_goes_up_by_a_first_release() {
    let mut node = sms();
    node.ok(HostMessage::from(message::CameraSetMirrorUp { mirror_up: YES }));
    let exposure_delay = ShortMilliseconds(40);
    node.ok(HostMessage::from(message::CameraSetExposureDelay { exposure_delay }));
    node.ok(START);
    assert_eq!(node.pass(140), [(100, camera(false, false)), (140, camera(false, true))]);
    assert_eq!(node.machine.program().shots(), 1, "the first release counts as the picture (decision H-8)");
    assert_eq!(node.pass(140), [(100, camera(false, false)), (140, to(ONE, 100))]);
    assert_eq!(node.machine.program().shots(), 1);
}

// 4.2-14
#[test]
fn the_auxiliary_output_comes_before_and_after_pictures() {
    let mut node = sms();
    let (ring, tip) = (AltMode::OUT_BEFORE, AltMode::OUT_AFTER);
    node.ok(HostMessage::from(message::SetAltModes { ring, tip }));
    let millis = ShortMilliseconds;
    node.ok(HostMessage::from(message::SetOutBeforeDelay { delay: millis(10) }));
    node.ok(HostMessage::from(message::SetOutBeforeTime { time: millis(20) }));
    node.ok(HostMessage::from(message::SetOutAfterDelay { delay: millis(30) }));
    node.ok(HostMessage::from(message::SetOutAfterTime { time: millis(40) }));
    assert_eq!(node.ok(START), [RUNNING]);
    let out = |on| Event::AltOut { on };
    let cycle = [
        (10, out(true)),
        (30, out(false)),
        (30, camera(false, true)),
        (130, camera(false, false)),
        (161, out(true)),
        (201, out(false)),
        (201, to(ONE, 100)),
    ];
    assert_eq!(node.pass(201), cycle);
    arrive(&mut node, 100);
    assert_eq!(node.pass(815), [(809, out(true))]);
    assert_eq!(node.ok(STOP), [out(false), STOPPED], "a stop switches it off");
}

// 4.2-15
#[test]
fn time_lapse_does_not_wait_for_the_motors() {
    let mut node = sms();
    node.ok(HostMessage::from(message::SetProgramMode { program_mode: ProgramMode::CONTINUOUS }));
    travel(&mut node, 3000);
    node.ok(START);
    let plan = node.machine.motor(ONE).settings().plan;
    let along = |elapsed| motion(ONE, Motion::Along { plan, elapsed });
    // The travel is in milliseconds (decision H-66).
    assert_eq!(node.pass(1000)[1..], [(101, along(0)), (1000, camera(false, true))], "the motor still moves");
    assert_eq!(node.pass(900).len(), 1, "the end of the picture");
    node.ok(PAUSE);
    node.pass(777);
    node.ok(START);
    assert_eq!(node.pass(0), []);
    assert!(node.machine.motor(ONE).is_moving(), "it goes on after the pause");
    // The lead-in counts pictures. Without a camera it counts intervals (decision H-9).
    let mut node = moving(ProgramMode::CONTINUOUS);
    interval(&mut node, 500);
    travel(&mut node, 3000);
    lead_in(&mut node, 2);
    assert_eq!(node.ok(START), [RUNNING]);
    let plan = node.machine.motor(ONE).settings().plan;
    assert_eq!(node.pass(2500), [(1000, motion(ONE, Motion::Along { plan, elapsed: 0 }))]);
    assert_eq!(arrive(&mut node, 300), [STOPPED]);
}

// 4.2-16
#[test]
fn a_video_follows_the_clock() {
    let mut node = moving(ProgramMode::VIDEO);
    travel(&mut node, 3000);
    lead_in(&mut node, 500);
    start_delay(&mut node, 1);
    node.ok(START);
    let plan = node.machine.motor(ONE).settings().plan;
    let along = |elapsed| motion(ONE, Motion::Along { plan, elapsed });
    assert_eq!(node.pass(1500), [(1000, RUNNING), (1500, along(0))], "after the delay (decision H-10)");
    assert_eq!((plan.at(1500), node.wake), (Steps(150), None));
    node.pass(1000);
    assert_eq!(node.ok(PAUSE), [motion(ONE, Motion::Stop), PAUSED]);
    node.pass(9000);
    assert_eq!(node.ok(START), [RUNNING, along(1000)], "from the position of that time");
    assert_eq!(arrive(&mut node, 300), [STOPPED]);

    ping_pong(&mut node);
    node.ok(START);
    node.pass(1500);
    assert_eq!(arrive(&mut node, 300), [STOPPED, Event::Program(ProgramState::Delay)]);
}

// 4.2-17
#[test]
fn pictures_of_a_video_come_at_their_interval() {
    let mut node = sms();
    node.ok(HostMessage::from(message::SetProgramMode { program_mode: ProgramMode::VIDEO }));
    travel(&mut node, 60_000);
    max_shots(&mut node, 2);
    let plan = node.machine.motor(ONE).settings().plan;
    assert_eq!(node.ok(START), [RUNNING, motion(ONE, Motion::Along { plan, elapsed: 0 }), camera(false, true)]);
    let end = [(1100, camera(false, false)), (1101, motion(ONE, Motion::Stop)), (1101, STOPPED)];
    assert_eq!(node.pass(2000)[2..], end);
}

// 4.2-18
#[test]
fn an_external_intervalometer_takes_the_pictures() {
    let mut node = sms();
    alt(&mut node, AltMode::EXTERNAL_INTERVALOMETER);
    assert_eq!(node.ok(START), [RUNNING]);
    assert_eq!((node.pass(9000), node.wake), (vec![], None));
    assert_eq!(node.tell(Input::Alt(Contact::Ring)), [camera(false, true)]);
    assert_eq!(node.tell(Input::Alt(Contact::Ring)), [], "one picture at a time");
    assert_eq!(node.pass(101)[1..], [(101, to(ONE, 100))]);
}

// 4.2-19
#[test]
fn a_node_that_is_not_the_timing_master_waits_for_the_common_line() {
    let mut node = sms();
    node.ok(HostMessage::from(message::SetTimingMaster { timing_master: NO }));
    assert_eq!(node.ok(START), [RUNNING]);
    assert_eq!(node.pass(9000), []);
    assert_eq!(node.tell(Input::CommonLine), [camera(false, true)]);
    assert_eq!(sms().tell(Input::CommonLine), [], "no program runs");

    let mut master = sms();
    let common_line = message::CommonLine::FIRST;
    master.ok(HostMessage::from(message::SetCommonLine { common_line }));
    assert_eq!(master.ok(START), [RUNNING, Event::CommonLine, camera(false, true)]);
    assert_eq!(master.tell(Input::CommonLine), []);
}

// 4.2-20
#[test]
fn a_contact_starts_and_stops_in_turn() {
    let mut node = sms();
    alt(&mut node, AltMode::TOGGLE);
    assert_eq!(node.tell(Input::Alt(Contact::Ring))[0], RUNNING);
    assert_eq!(node.tell(Input::Alt(Contact::Ring)), [camera(false, false), STOPPED]);
    assert_eq!(node.tell(Input::Alt(Contact::Ring))[0], RUNNING);
}

// 4.2-21
#[test]
fn going_home_pauses_the_program() {
    let mut node = sms();
    node.ok(START);
    let home = HostMessage::from(message::ReturnHome {});
    assert_eq!(node.ok(home)[..2], [camera(false, false), PAUSED]);
    assert!(Motor::ALL.iter().all(|motor| node.running(*motor)));
}

// 4.2-22
#[test]
fn after_power_up_no_program_runs() {
    let cycled = |node: &mut Node| node.ask(HostMessage::from(message::PowerCycled {}))[1];
    let mut node = sms();
    assert_eq!([cycled(&mut node), cycled(&mut node)], [1, 0], "said once");
    node.ok(START);
    node.ok(HostMessage::from(message::SetManualMove { manual_move: YES }));
    node.ok(joystick(YES));
    assert_eq!(node.tell(Input::Command(Command::PowerUp)), [camera(false, false), STOPPED]);
    assert_eq!(cycled(&mut node), 1);
    assert!(!node.machine.controller().joystick_mode && !node.machine.controller().manual_move);
}

// 4.2-23
#[test]
fn switching_the_camera_off_does_not_hold_up_the_program() {
    let mut node = sms();
    node.ok(START);
    let events = node.ok(HostMessage::from(message::CameraSetEnable { enable: NO }));
    assert_eq!(events, [camera(false, false), to(ONE, 100)]);
}

// 4.2-24
#[test]
fn a_stop_of_one_motor_pauses_the_program() {
    let mut node = sms();
    node.ok(START);
    node.pass(101);
    assert_eq!(node.ok(motor_stop(ONE)), [motion(ONE, Motion::Stop), PAUSED]);
    assert_eq!((node.pass(9000), node.wake), (vec![], None), "nothing moves it again");
    assert_eq!(node.ok(motor_stop(ONE)), []);
    assert_eq!(node.ok(START), [RUNNING, to(ONE, 100)]);
}

// 4.2-26
#[test]
fn the_motors_stop_before_everything_else() {
    for (stop, after) in [(STOP, STOPPED), (PAUSE, PAUSED)] {
        let mut node = sms();
        node.ok(HostMessage::from(message::SetProgramMode { program_mode: ProgramMode::CONTINUOUS }));
        node.ok(START);
        node.pass(1001);
        let output = node.send(NODE, stop);
        assert_eq!(output.event_list(), [motion(ONE, Motion::Stop), camera(false, false), after], "{stop:?}");
        assert!(matches!(output.effects.last(), Some(Effect::Transmit(_))), "{output:?}");
    }
}

// 4.2-25
#[test]
fn a_video_with_ping_pong_turns_round_at_once() {
    let mut node = moving(ProgramMode::VIDEO);
    ping_pong(&mut node);
    node.ok(START);
    let forth = node.machine.motor(ONE).settings().plan;
    let events = arrive(&mut node, 300);
    let back = node.machine.motor(ONE).settings().plan;
    assert_eq!((back.start, back.stop), (forth.stop, forth.start));
    assert_eq!(events, [STOPPED, RUNNING, motion(ONE, Motion::Along { plan: back, elapsed: 0 })]);
}
