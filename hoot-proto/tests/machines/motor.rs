//! Motors of a node: hoot, section 4.3.

use super::world::*;
use hoot_proto::device::{Contact, Event, Input, Motion, MotorState, Options};
use hoot_proto::message::{
    self, AltMode, Backlash, Direction, HostMessage, Microstep, Motor, Span, StepCount, Steps, StepsPerSecond,
};
use motion_core::wire::Bool;

const ONE: Motor = Motor::One;

fn enable(motor: Motor, enable: Bool) -> HostMessage<'static> {
    HostMessage::from(message::MotorSetEnable { motor, enable })
}

fn at(node: &mut Node, motor: Motor, steps: i32) -> Vec<Event<'static>> {
    node.tell(Input::Position { motor, position: Steps(steps) })
}

fn end_here(motor: Motor) -> HostMessage<'static> {
    HostMessage::from(message::MotorSetEndHere { motor })
}

fn plan(node: &mut Node, motor: Motor, start: i32, stop: i32, travel: u32) {
    let position = Steps(start);
    node.ok(HostMessage::from(message::MotorSetProgramStart { motor, position }));
    let position = Steps(stop);
    node.ok(HostMessage::from(message::MotorSetProgramStop { motor, position }));
    node.ok(HostMessage::from(message::MotorSetTravel { motor, travel: Span(travel) }));
}

fn moves(motor: Motor) -> Vec<HostMessage<'static>> {
    vec![
        move_by(motor, 10),
        run(motor),
        HostMessage::from(message::MotorSendHome { motor }),
        HostMessage::from(message::MotorSendToEnd { motor }),
        HostMessage::from(message::MotorSendToStart { motor }),
        HostMessage::from(message::MotorSendToStop { motor }),
        HostMessage::from(message::ReturnHome {}),
    ]
}

// 4.3-1 4.3-2
#[test]
fn a_motor_that_is_not_enabled_answers_ok_and_does_nothing() {
    let mut node = Node::new(Options::default());
    node.ok(speed(ONE, 100.0));
    for message in moves(ONE) {
        assert_eq!(node.ok(message), [], "{message:?}");
    }
    assert_eq!(node.machine.motor(ONE).state(), MotorState::Disabled);
    assert_eq!(node.ok(enable(ONE, YES)), []);
    assert_eq!(node.machine.motor(ONE).state(), MotorState::Idle);
    assert_eq!(node.ask(HostMessage::from(message::MotorEnable { motor: ONE })), [0, 1]);
    // A motor that is disabled while it moves stops.
    node.ok(run(ONE));
    assert_eq!(node.ok(enable(ONE, NO))[0], motion(ONE, Motion::Stop));
    assert_eq!(node.machine.motor(ONE).state(), MotorState::Disabled);
}

// 4.3-3
#[test]
fn a_move_needs_a_speed_and_wakes_the_driver() {
    let mut node = Node::new(Options::default());
    node.ok(enable(ONE, YES));
    for message in moves(ONE).into_iter().filter(|message| !matches!(message, HostMessage::MotorRun(_))) {
        assert_eq!(node.ok(message), [], "no speed: {message:?}");
    }
    node.ok(speed(ONE, -20.0));
    let by = Motion::By { direction: Direction(1), steps: StepCount(10) };
    assert_eq!(node.ok(move_by(ONE, 10)), [motion(ONE, Motion::Power(true)), motion(ONE, by)]);
    assert_eq!(node.machine.motor(ONE).state(), MotorState::Moving);
    assert!(node.running(ONE));
    assert_eq!(node.ok(move_by(ONE, 10)), [motion(ONE, by)], "the driver is awake");
    node.tell(Input::Arrived(ONE));
    let sleep = |sleep| HostMessage::from(message::MotorSetSleep { motor: ONE, sleep });
    assert_eq!(node.ok(sleep(NO)), [motion(ONE, Motion::Power(true))]);
    assert_eq!(node.ok(move_by(ONE, 10)), [motion(ONE, by)]);
}

// 4.3-4 4.3-5
#[test]
fn a_run_goes_on_and_takes_new_speeds() {
    let mut node = Node::ready();
    assert_eq!(node.ok(speed(ONE, 300.0)), [], "it rests");
    let start = Motion::Run { direction: Direction(0), speed: StepsPerSecond(300.0) };
    assert_eq!(node.ok(run(ONE)), [motion(ONE, start)]);
    assert_eq!(node.machine.motor(ONE).state(), MotorState::Continuous);
    assert_eq!(node.ok(speed(ONE, -5000.0)), [motion(ONE, Motion::Speed(StepsPerSecond(-5000.0)))]);
    for ignored in [5000.1, -9000.0, f32::NAN, f32::INFINITY] {
        assert_eq!(node.ok(speed(ONE, ignored)), [], "{ignored}");
    }
    assert_eq!(node.machine.motor(ONE).settings().speed, StepsPerSecond(-5000.0));
    assert!(node.running(ONE));
}

// 4.3-6
#[test]
fn every_stop_stops_at_once() {
    let stopped = [motion(ONE, Motion::Stop)];
    let sub_address = message::AnySubAddress(0);
    for begin in [run(ONE), move_by(ONE, 5)] {
        for stop in [motor_stop(ONE), STOP, PAUSE] {
            let mut node = Node::ready();
            node.ok(begin);
            assert_eq!(node.ok(stop), stopped, "{stop:?}");
            assert!(!node.running(ONE));
            assert_eq!(node.ok(stop), [], "the motor rests already");
        }
        let mut node = Node::ready();
        node.ok(begin);
        let stop = HostMessage::from(message::BroadcastStop { sub_address });
        assert_eq!(node.send(message_address(), stop).event_list()[..], stopped);
        node.ok(begin);
        let button = Input::Command(hoot_proto::device::Command::EmergencyStop);
        assert_eq!(node.tell(button), stopped);
    }
    // The stop of a motor does not stop other motors.
    let mut node = Node::ready();
    node.ok(run(ONE));
    assert_eq!(node.ok(motor_stop(Motor::Two)), []);
    assert!(node.running(ONE));
}

fn message_address() -> hoot_proto::Address {
    hoot_proto::Address::BROADCAST
}

// 4.3-7 4.3-10
#[test]
fn a_motor_rests_at_its_target_or_at_its_end() {
    let mut node = Node::ready();
    node.ok(HostMessage::from(message::MotorSetSleep { motor: ONE, sleep: YES }));
    node.ok(move_by(ONE, 10));
    assert_eq!(node.tell(Input::Arrived(ONE)), [motion(ONE, Motion::Power(false))]);
    assert_eq!(node.tell(Input::Arrived(ONE)), [], "once");
    assert!(!node.running(ONE));

    for end in [1000, -1000] {
        let mut node = Node::ready();
        at(&mut node, ONE, end);
        node.ok(end_here(ONE));
        at(&mut node, ONE, 0);
        node.ok(run(ONE));
        assert_eq!(at(&mut node, ONE, end / 2), []);
        assert_eq!(at(&mut node, ONE, end), [motion(ONE, Motion::Stop)]);
        // The motor may go back from the limit, and is stopped again only when it reaches the limit again.
        node.ok(run(ONE));
        assert_eq!(at(&mut node, ONE, end / 2), []);
        assert_eq!(at(&mut node, ONE, end + end / 10), [motion(ONE, Motion::Stop)]);
    }
    // A motor beyond the limit may come back.
    for end in [1000, -1000] {
        let mut node = Node::ready();
        at(&mut node, ONE, end);
        node.ok(end_here(ONE));
        at(&mut node, ONE, 2 * end);
        node.ok(run(ONE));
        assert_eq!(at(&mut node, ONE, end + end / 2), []);
    }
    // Without a limit the motor goes on.
    let mut node = Node::ready();
    node.ok(run(ONE));
    for steps in [2_000_000_000, -2_000_000_000] {
        assert_eq!(at(&mut node, ONE, steps), []);
    }
}

// 4.3-8
#[test]
fn home_here_shifts_stored_positions_and_moves_nothing() {
    let mut node = Node::ready();
    at(&mut node, ONE, 400);
    node.ok(end_here(ONE));
    plan(&mut node, ONE, 100, 300, 5);
    at(&mut node, ONE, 150);
    let home = HostMessage::from(message::MotorSetHomeHere { motor: ONE });
    assert_eq!(node.ok(home), [motion(ONE, Motion::Rebase { by: Steps(150) })]);
    let unit = node.machine.motor(ONE);
    let set = unit.settings();
    assert_eq!((unit.position().0, set.plan.start.0, set.plan.stop.0, set.end_limit.0), (0, -50, 150, 250));

    // If there was no limit before, there is none afterwards.
    at(&mut node, Motor::Two, 70);
    node.ok(HostMessage::from(message::MotorSetHomeHere { motor: Motor::Two }));
    assert_eq!(node.machine.motor(Motor::Two).settings().end_limit, Steps(0));

    at(&mut node, ONE, 30);
    let reset = HostMessage::from(message::MotorResetLimits { motor: ONE });
    assert_eq!(node.ok(reset), [motion(ONE, Motion::Rebase { by: Steps(30) })]);
    let unit = node.machine.motor(ONE);
    let set = unit.settings();
    assert_eq!((unit.position().0, set.plan.start.0, set.plan.stop.0, set.end_limit.0), (0, 0, 0, 0));
}

// 4.3-9
#[test]
fn the_dead_man_stops_moves_and_runs_after_a_second() {
    let manual = |manual_move| HostMessage::from(message::SetManualMove { manual_move });
    for begin in [run(ONE), move_by(ONE, 5)] {
        let mut node = Node::ready();
        node.ok(manual(YES));
        node.ok(begin);
        assert_eq!(node.pass(1000), [], "for more than a second");
        assert_eq!(node.pass(1), [(1, motion(ONE, Motion::Stop))]);

        let mut node = Node::ready();
        node.ok(manual(YES));
        node.ok(begin);
        node.ok(manual(NO));
        assert_eq!(node.pass(10_000), []);
    }
    // A motion that starts while the master is silent is stopped, and a program pauses (decision H-4).
    let mut node = Node::ready();
    node.ok(manual(YES));
    plan(&mut node, ONE, 0, 1000, 10);
    node.pass(2000);
    let events = node.tell(Input::Command(hoot_proto::device::Command::Start));
    assert_eq!(events.iter().filter(|event| **event == motion(ONE, Motion::Stop)).count(), 1, "{events:?}");
    assert_eq!(node.machine.program().state().name(), "Paused");
    // If a late wake and a command come together, the stop is first.
    let mut node = Node::ready();
    node.ok(manual(YES));
    node.ok(run(ONE));
    node.now += 5000;
    let by = Motion::By { direction: Direction(1), steps: StepCount(7) };
    assert_eq!(node.ok(move_by(ONE, 7)), [motion(ONE, Motion::Stop), motion(ONE, by)]);
}

// 4.3-11
#[test]
fn another_microstep_setting_scales_stored_positions() {
    let mut node = Node::ready();
    at(&mut node, ONE, 400);
    node.ok(end_here(ONE));
    plan(&mut node, ONE, -100, 300, 5);
    node.ok(HostMessage::from(message::MotorSetBacklash { motor: ONE, backlash: Backlash(8) }));
    node.ok(run(ONE));
    let micro = |microstep| HostMessage::from(message::MotorSetMicrostep { motor: ONE, microstep });
    let told = [motion(ONE, Motion::Stop), motion(ONE, Motion::Microstep(Microstep::SIXTEENTH))];
    assert_eq!(
        node.ok(micro(Microstep::SIXTEENTH)),
        told,
        "the target counts in the old steps, so the motor stops (decision H-13)"
    );
    let unit = node.machine.motor(ONE);
    let set = unit.settings();
    assert_eq!((unit.position().0, set.plan.start.0, set.plan.stop.0), (1600, -400, 1200));
    assert_eq!((set.end_limit.0, set.backlash.0), (1600, 32));
    for ignored in [Microstep(3), Microstep(0), Microstep(32), Microstep::SIXTEENTH] {
        assert_eq!(node.ok(micro(ignored)), []);
    }
    assert_eq!(node.machine.motor(ONE).settings().microstep, Microstep::SIXTEENTH);
}

// 4.3-12
#[test]
fn a_fault_stops_its_motor_and_pauses_the_program() {
    let mut node = Node::ready();
    node.ok(run(ONE));
    node.ok(run(Motor::Two));
    assert_eq!(node.tell(Input::Fault(ONE)), [motion(ONE, Motion::Stop)]);
    assert!(node.running(Motor::Two));

    let mut node = Node::ready();
    plan(&mut node, ONE, 0, 1000, 10);
    node.ok(START);
    assert!(node.running(ONE));
    node.tell(Input::Fault(ONE));
    assert_eq!(node.machine.program().state().name(), "Paused");
}

// 4.3-13
#[test]
fn single_steps_need_a_plan() {
    let forward = HostMessage::from(message::MotorStepForward { motor: ONE });
    let back = HostMessage::from(message::MotorStepBack { motor: ONE });
    let mut node = Node::ready();
    node.refused(forward);
    node.refused(back);
    plan(&mut node, ONE, 0, 1000, 10);
    assert_eq!(node.ok(forward), [to(ONE, 100)]);
    node.tell(Input::Arrived(ONE));
    assert_eq!(node.ok(forward), [to(ONE, 200)]);
    assert_eq!(node.ok(back), [to(ONE, 100)]);
    let mut later = Node::ready_with(Options::default().with_profile(hoot_proto::query::Profile::V033));
    plan(&mut later, ONE, 0, 1000, 10);
    assert_eq!(later.ok(forward), [], "the lead-out, which later firmware sets by the same number");
    assert!(later.request(back).0.is_empty(), "later firmware does not have it");
}

// 4.3-14
#[test]
fn motors_are_sent_to_stored_positions() {
    let mut node = Node::ready();
    plan(&mut node, ONE, -50, 700, 10);
    let [_, _, home, end, start, stop, all] = moves(ONE).try_into().unwrap();
    assert_eq!(node.ok(end), [], "there is no end limit");
    at(&mut node, ONE, 900);
    node.ok(end_here(ONE));
    for (message, place) in [(end, 900), (home, 0), (start, -50), (stop, 700)] {
        assert_eq!(node.ok(message), [to(ONE, place)]);
    }
    assert_eq!(node.ok(all), [motion(ONE, Motion::Stop), to(ONE, 0), to(Motor::Two, 0), to(Motor::Three, 0)]);
}

// 4.3-15
#[test]
fn contacts_set_limits_and_stop_motors() {
    let contact = |node: &mut Node, ring: AltMode| {
        node.ok(HostMessage::from(message::SetAltModes { ring, tip: AltMode::OFF }));
        assert_eq!(node.tell(Input::Alt(Contact::Tip)), [], "the other contact");
        node.tell(Input::Alt(Contact::Ring))
    };
    let mut node = Node::ready();
    at(&mut node, ONE, 60);
    assert_eq!(contact(&mut node, AltMode::SET_END), []);
    assert_eq!(node.machine.motor(ONE).settings().end_limit, Steps(60));
    assert_eq!(contact(&mut node, AltMode::SET_HOME)[0], motion(ONE, Motion::Rebase { by: Steps(60) }));
    node.ok(run(ONE));
    assert_eq!(contact(&mut node, AltMode::STOP_MOTORS), [motion(ONE, Motion::Stop)]);
    node.ok(run(ONE));
    assert_eq!(contact(&mut node, AltMode::REVERSE_DIRECTION), [motion(ONE, Motion::Stop)]);
    assert_eq!(node.machine.motor(ONE).settings().direction, Direction(1));
    assert_eq!(contact(&mut node, AltMode(99)), []);
}
