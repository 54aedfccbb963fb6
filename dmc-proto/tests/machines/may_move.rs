//! Knowledge of a host and of a device whether anything may still move because of them, and order of stops. DMC D2, D5.

use dmc_proto::device::{self, State};
use dmc_proto::host::{Command, Contents, Event, Input, Options, Progress, StopTarget};
use dmc_proto::message::{
    AckCode, CameraFlags, GioCam, HardStop, HostMessage, Motor, MotorConfigure, MotorFlags, MotorStatusRequest, RtGo,
    RunFlags, VirtualMotor,
};
use dmc_proto::{MessageId, MessageType};

use super::bench::{Bench, Desk, hi, jog, move_to, position_frame, run, shot, status, stop, stop_all};

fn ask_status() -> HostMessage<'static> {
    MotorStatusRequest::default().into()
}

/// D5-23
#[test]
fn something_may_move_until_a_later_status_tells_rest() {
    for message in [move_to(1, 5), jog(1)] {
        let mut desk = Desk::up();
        assert!(!desk.machine.may_move());
        desk.request(1, ask_status());
        assert!(!desk.machine.may_move(), "a question moves nothing");
        desk.status(2, 0);
        desk.request(2, message);
        assert!(desk.machine.may_move(), "the request is under way");
        desk.acked(3, message.kind().0, AckCode::OK);
        assert!(desk.machine.may_move(), "the motor moves");
        desk.request(3, ask_status());
        desk.status(4, 1);
        assert!(desk.machine.may_move());
        desk.receives(99, status(0));
        assert!(desk.machine.may_move(), "the status answers no question");
        desk.request(4, ask_status());
        desk.status(5, 0);
        assert!(!desk.machine.may_move(), "the motor rests");
    }
}

/// D5-23
#[test]
fn an_earlier_status_proves_nothing() {
    let mut desk = Desk::up_with(Options::new().with_window(4), hi());
    desk.request(1, ask_status());
    desk.request(2, jog(1));
    desk.acked(3, 0x0036, AckCode::OK);
    desk.status(2, 0);
    assert!(desk.machine.may_move(), "the question was asked before the jog");

    let mut desk = Desk::up_with(Options::new().with_window(4), hi());
    desk.request(1, move_to(1, 5));
    desk.pass(100);
    desk.request(2, ask_status());
    desk.pass(400);
    assert_eq!(desk.machine.pending().next(), Some((MessageId(4), MessageType(0x0031))), "the move is sent again");
    desk.acked(4, 0x0031, AckCode::OK);
    desk.status(3, 0);
    assert!(desk.machine.may_move(), "that move may be later than the status");
}

/// D5-23
#[test]
fn only_a_refusal_of_the_only_try_tells_that_nothing_moves() {
    let after = |codes: &[AckCode]| {
        let mut desk = Desk::up();
        desk.request(1, move_to(1, 5));
        let mut id = 2;
        for &code in codes {
            if code == AckCode::OK {
                desk.pass(500);
                id += 1;
            } else {
                desk.acked(id, 0x0031, code);
            }
        }
        assert_eq!(desk.machine.pending().count(), 0);
        desk.machine.may_move()
    };
    assert!(!after(&[AckCode::ERR_SOFT_UP]));
    assert!(after(&[AckCode::ERR_MOVING]), "something moves");
    assert!(after(&[AckCode::OK, AckCode::ERR_HARD_UP]), "the first try may have been done");
}

/// D5-23
#[test]
fn after_a_stop_something_may_move_until_rest_is_known() {
    let mut desk = Desk::up();
    desk.stop(StopTarget::Motor(Motor(1)));
    assert!(desk.machine.may_move(), "the stop is not confirmed");
    desk.acked(2, 0x0032, AckCode::OK);
    assert!(!desk.machine.may_move(), "nothing moved before");

    desk.request(1, jog(1));
    desk.stop(StopTarget::All);
    desk.acked(4, 0x0033, AckCode::OK);
    assert!(desk.machine.may_move(), "the motor takes time to come to rest");
    desk.request(2, ask_status());
    desk.status(5, 0);
    assert!(!desk.machine.may_move());

    desk.request(3, jog(1));
    desk.stop(StopTarget::All);
    desk.pass(250);
    desk.status(8, 0);
    assert!(!desk.machine.may_move(), "the status that confirms the stop tells rest too");
}

/// D5-23
#[test]
fn a_run_may_move_from_its_first_request_to_its_end() {
    let mut desk = Desk::up();
    desk.sequence(1, run(1, 10, RunFlags(0)));
    while desk.machine.progress().is_some() {
        assert!(desk.machine.may_move(), "{:?}", desk.machine.progress());
        let pending = desk.machine.pending().next();
        match pending {
            Some((id, MessageType(0x0030))) => desk.status(id.0, 0),
            Some((id, kind)) => desk.acked(id.0, kind.0, AckCode::OK),
            None if desk.machine.progress() == Some(Progress::Armed) => desk.command(Command::Go),
            None => desk.pass(100),
        };
    }
    assert!(!desk.machine.may_move(), "the run has come to rest");

    let mut desk = Desk::up();
    desk.sequence(1, shot(1));
    desk.acked(2, 0x0115, AckCode::OK);
    desk.receives(0, RtGo::default().into());
    desk.stop(StopTarget::All);
    desk.acked(3, 0x0033, AckCode::OK);
    assert!(!desk.machine.is_armed() && desk.machine.may_move(), "the shot comes to rest");
}

/// D5-23
#[test]
fn without_news_something_may_still_move() {
    let moved = || {
        let mut desk = Desk::up();
        desk.request(1, jog(1));
        desk
    };
    let mut desk = moved();
    desk.pass(500);
    assert!(desk.machine.may_move(), "no answer came");
    desk.status(3, 0);
    assert!(!desk.machine.may_move(), "the machine asked by itself");
    let mut desk = moved();
    desk.step(Input::LinkDown);
    assert!(desk.machine.may_move(), "no question can be asked");
    desk.becomes_ready(3, hi());
    assert!(desk.machine.may_move());
    let mut desk = moved();
    desk.receives(0, hi().into());
    assert!(desk.machine.may_move(), "the news of a reset may be older than the motion");
    let mut desk = moved();
    desk.receives(0, HardStop::default().into());
    assert!(desk.machine.may_move(), "the news of a hard stop may be older than the motion");
    let mut desk = Desk::up();
    desk.step(Input::LinkDown);
    assert!(!desk.machine.may_move(), "nothing had moved");
}

/// D5-24, S-1
#[test]
fn a_stop_goes_out_before_anybody_is_told_of_it() {
    let stop = |id, target| (id, Contents::Stop(target));
    let targets = [StopTarget::Motor(Motor(1)), StopTarget::Virtual(VirtualMotor::PAN)];
    let mut desk = Desk::up();
    for target in targets {
        desk.stop(target);
    }
    desk.pass(1500);
    desk.request(1, position_frame(1));
    // Every step of a desk checks that stops are the first effects.
    let (sent, events) = desk.step(Input::LinkUp);
    assert_eq!(sent[..2], [stop(sent[0].0, targets[0]), stop(sent[1].0, targets[1])]);
    assert_eq!(sent[2].1, Contents::Greeting);
    assert_eq!(events, [Event::LinkDown, Event::StopNotConfirmed(targets[0]), Event::StopNotConfirmed(targets[1])]);

    let mut desk = Desk::up();
    desk.request(1, ask_status());
    desk.stop(StopTarget::All);
    desk.pass(499);
    desk.now = desk.now.after(1);
    let (sent, events) = desk.status(2, 0);
    assert_eq!((sent, events.len()), (vec![stop(5, StopTarget::All)], 1), "a stop that is due goes before the answer");
}

/// D2-24
#[test]
fn a_device_may_move_from_what_it_is_told_until_rest() {
    for mut bench in Bench::everywhere() {
        let state = bench.state();
        assert_eq!(bench.machine.may_move(), state != State::Idle, "{state:?}");
        bench.step(device::Input::Rig(device::Report::EmergencyStop(true)));
        assert!(bench.machine.may_move(), "after {state:?}, motors take time to come to rest");
        bench.rests();
        assert!(!bench.machine.may_move(), "after {state:?}, all motors rest");
        assert_eq!(bench.state(), State::Locked);
    }

    let shutter = |flags| GioCam { flags, tail: &[] }.into();
    let open = || {
        let mut bench = Bench::on_frame();
        bench.takes_as(shutter(CameraFlags::SHUTTER), device::Event::Apply);
        assert!(bench.machine.may_move(), "the shutter is open");
        bench.asked(stop(1));
        bench.rests();
        assert!(bench.machine.may_move(), "a stop of a motor closes no shutter");
        bench
    };
    let mut bench = open();
    bench.takes_as(shutter(CameraFlags::empty()), device::Event::Apply);
    assert!(!bench.machine.may_move());
    let mut bench = open();
    bench.asked(stop_all());
    assert!(!bench.machine.may_move(), "a stop of everything closes the shutter");
    let mut bench = open();
    let (_, events) = bench.step(device::Input::LinkDown);
    let stop = device::Event::Stop(device::StopKind::All { silent: false });
    assert!(events.contains(&stop), "nobody else can close the shutter: {events:?}");
    assert!(!bench.machine.may_move());
}

/// D2-24, D-98
#[test]
fn a_shutter_may_be_open_until_the_end_of_its_run_is_told() {
    let photos = run(1, 10, RunFlags::CAMERA_EVERY_FRAME);
    for (message, opens) in [(shot(1), true), (photos, true), (run(1, 10, RunFlags(0)), false)] {
        let begun = || {
            let mut bench = Bench::quirky(device::Quirks::MOVE_ENDS_RUN);
            let flags = MotorFlags::ENABLED | MotorFlags::LIVE;
            bench.asked(MotorConfigure { motor: Motor(3), flags, tail: &[] }.into());
            bench.asked(message);
            bench.rests();
            bench.asked(RtGo::default().into());
            assert!(bench.machine.may_move());
            bench
        };
        let mut bench = begun();
        bench.step(device::Input::Rig(device::Report::PassEnd));
        assert!(bench.machine.may_move(), "the motors come to rest");
        bench.rests();
        assert!(!bench.machine.may_move());

        let mut bench = begun();
        bench.asked(move_to(3, 5));
        assert_eq!(bench.state(), State::Moving, "the move ends the run");
        bench.rests();
        assert_eq!(bench.machine.may_move(), opens, "{message}");
    }
}
