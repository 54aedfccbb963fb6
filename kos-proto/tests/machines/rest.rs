//! What a device knows about whether anything may move, and the stop of a person at it.

use kos_proto::device::{Event, Ignored, Input, Options, Report};
use kos_proto::message::*;
use kos_proto::trajectory::{DelayInterval, DelayMode, Playback};

use super::bench::*;

fn stops(motor: u8) -> Event<'static> {
    Event::StopMotor { motor: MotorAddress(motor), acceleration: None }
}

/// 7.1-23: in every state, also while a motor stops gently.
#[test]
fn a_person_at_the_device_stops_everything() {
    let mut bench = Bench::off(Options::default());
    bench.step(Input::Stop);
    assert_eq!((bench.events(), bench.messages().len()), (vec![Event::StopAll], 0));

    let mut bench = Bench::loaded(Options::default(), live_move(live()));
    bench.receive(set_psa(3, 25_000.0, 10.0));
    bench.step(Input::Stop);
    assert_eq!(bench.events()[1..], [Event::StopAll]);
    assert_eq!(bench.messages(), ["0: FULL_STOP", "0: 1 rests at 8.0", "0: 2 rests at 8.0"]);
    bench.arrive(3, 2.0);
    assert_eq!(bench.messages(), ["0: 3 rests at 2.0"]);
    assert!(!bench.machine.may_move());
    bench.receive(set_psa(3, 25_000.0, 10.0));
    assert!(bench.machine.may_move(), "a client can move motors again");
}

/// 7.1-24.
#[test]
fn a_device_may_move_until_the_rig_reports_that_all_motors_rest() {
    let mut bench = Bench::loaded(Options::default(), live_move(live()));
    assert!(!bench.machine.may_move());
    bench.receive(start());
    assert!(bench.machine.may_move(), "the motors go to where the move begins");
    bench.step(Input::Stop);
    bench.arrive(1, 0.0);
    assert!(bench.machine.may_move(), "motor 2 stops");
    bench.arrive(2, 0.0);
    assert!(!bench.machine.may_move());

    let waits =
        Playback { delay_mode: DelayMode(1), delay_interval_bits: DelayInterval::from_seconds(Seconds(3.0)), ..live() };
    let mut bench = Bench::loaded(Options::default(), live_move(waits));
    bench.receive(start());
    bench.home();
    assert_eq!((bench.state(), bench.machine.may_move()), ("Delay", true));
    bench.pass_with_client(13_000);
    assert_eq!((bench.state(), bench.machine.may_move()), ("Empty", false));
}

/// 7.1-24: the shutter of a photo is open.
#[test]
fn a_device_may_move_until_the_shutter_of_a_photo_is_closed() {
    let mut bench = Bench::new(Options::default());
    let photo = |seconds| TakePicture { motor_address: MotorAddress::ALL, exposure: Seconds(seconds), tail: &[] };
    bench.receive(photo(2.0));
    bench.receive(photo(0.5));
    bench.pass(1_999);
    assert!(bench.machine.may_move(), "the longer exposure counts");
    bench.pass(1);
    assert!(!bench.machine.may_move());
    bench.receive(photo(2.0));
    bench.receive(STOP);
    assert!(!bench.machine.may_move(), "a stop closes the shutter");
}

/// 7.1-24, 7.3-15: a motor that is off line rests if the rig says so.
#[test]
fn a_device_may_move_while_a_motor_is_gone_that_did_not_rest() {
    for reports in [false, true] {
        let mut bench = Bench::new(Options::default());
        bench.receive(set_psa(2, 25_000.0, 9.0));
        bench.rig(Report::Online(MotorAddress(2), false));
        bench.step(Input::Stop);
        bench.rig(Report::Arrived(MotorAddress(2), Rotations(f32::NAN)));
        assert!(bench.machine.may_move(), "nobody knows whether the motor rests");
        if reports {
            bench.arrive(2, 1.0);
            assert!(!bench.machine.may_move());
        }
        bench.clear();
        bench.rig(Report::Online(MotorAddress(2), true));
        assert_eq!((bench.events().len(), bench.machine.may_move()), (usize::from(!reports), !reports));
        bench.arrive(2, 1.0);
        assert!(!bench.machine.may_move());
    }
}

/// 7.1-18, 7.1-24: a reset does not make a device forget that motors may move.
#[test]
fn motors_that_did_not_rest_before_a_reset_are_stopped_after_it() {
    let mut bench = Bench::loaded(Options::default(), live_move(live()));
    bench.receive(start());
    bench.receive(ResetDevice::default());
    bench.clear();
    bench.arrive(1, 3.0);
    bench.arrive(3, 3.0);
    assert_eq!(bench.events(), [Event::Ignored(Ignored::Off)], "motor 3 was at rest");
    assert!(bench.machine.may_move(), "motor 2 slows down");
    bench.rig(Report::Started);
    assert_eq!(bench.events(), [stops(2)]);
    bench.arrive(2, 3.0);
    assert!(!bench.machine.may_move());
}
