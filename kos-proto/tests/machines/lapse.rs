//! Time lapses: kOS 7.5.

use kos_proto::HostMessage;
use kos_proto::device::{Event, Options};
use kos_proto::message::*;
use kos_proto::trajectory::*;

use super::bench::*;

const OPEN: Event<'static> = Event::OpenShutter { millis: 1000 };

/// A time lapse with 2 s before a photo of 1 s.
fn lapse(mode: PlaybackMode, before: u32, moving: u32, after: u32) -> TrajectoryData<'static> {
    trajectory(Playback { playback_mode: mode, ..live() }, photos(2.0, 1.0, before, moving, after))
}

fn played(data: TrajectoryData<'_>) -> Bench {
    let mut bench = Bench::loaded(Options::default(), data);
    bench.receive(start());
    bench.home();
    bench
}

fn sms(before: u32, moving: u32, after: u32) -> Bench {
    played(lapse(PlaybackMode::TIME_LAPSE_SMS, before, moving, after))
}

fn continuous(before: u32, moving: u32, after: u32) -> Bench {
    played(lapse(PlaybackMode::TIME_LAPSE_CONTINUOUS, before, moving, after))
}

/// 7.5-1, 7.5-3: each photo before the move has the delay and exposure of a photo in the move.
#[test]
fn photos_are_taken_before_the_move() {
    for (mut bench, next, messages) in [
        (continuous(2, 1, 0), "ForwardC", vec!["0: START_FORWARD"]),
        (sms(2, 1, 0), "FrameDelay", vec!["0: START_FORWARD", "0: START_FRAME"]),
    ] {
        assert_eq!(bench.messages(), ["0: MOTORS_HOME", "0: PRE_MOVE_PHOTOS_STARTED"]);
        bench.clear();
        bench.pass(5_999);
        assert_eq!((bench.events(), bench.messages().len(), bench.state()), (vec![OPEN; 2], 0, "Pre"));
        bench.pass(1);
        assert_eq!((bench.messages(), bench.state()), (messages.into_iter().map(str::to_owned).collect(), next));
    }
}

/// 7.5-2, 7.5-5.
#[test]
fn a_lapse_without_photos_before_it_begins_at_once() {
    let mut bench = continuous(0, 4, 0);
    assert_eq!(bench.messages(), ["0: MOTORS_HOME", "0: START_FORWARD"]);
    assert_eq!(bench.events().pop(), Some(Event::Play { way: Direction::Forward, millis: 12_000 }));
    let mut bench = sms(0, 4, 0);
    assert_eq!(bench.messages(), ["0: MOTORS_HOME", "0: START_FORWARD", "0: START_FRAME"]);
    assert_eq!((bench.events().len(), bench.state()), (1, "FrameDelay"), "home, and nothing moves");
}

/// 7.5-4, 7.5-9, 7.5-11: while the motors move, a photo is taken every three seconds until the end.
#[test]
fn photos_are_taken_while_the_motors_move() {
    let mut bench = continuous(0, 3, 0);
    bench.clear();
    bench.pass(2_000);
    assert_eq!((bench.events(), bench.messages().len()), (vec![OPEN], 0));
    bench.pass(1_000);
    assert_eq!((bench.events().len(), bench.messages()), (0, vec!["0: START_FORWARD".to_owned()]));
    bench.pass(3_000);
    assert_eq!((bench.events(), bench.messages()), (vec![OPEN], vec!["0: START_FORWARD".to_owned()]));
    bench.pass(3_000);
    assert_eq!(
        (bench.events(), bench.messages()),
        (vec![OPEN, Event::MoveOver], ["0: END_OF_MOVE", "0: FULL_STOP"].map(str::to_owned).to_vec())
    );
    assert_eq!(bench.state(), "Empty");
}

/// 7.5-4: the next photo is on time, also after a late wake.
#[test]
fn a_late_photo_does_not_delay_the_next_one() {
    let mut bench = continuous(0, 3, 0);
    bench.clear();
    bench.now += 2_400;
    bench.step(kos_proto::device::Input::Wake);
    assert_eq!((bench.events(), bench.wake), (vec![OPEN], Some(1000 + 3_400)), "late, and no shorter");
    bench.now += 1_000;
    bench.step(kos_proto::device::Input::Wake);
    assert_eq!(bench.wake, Some(1000 + 5_000), "as planned");
}

/// 7.5-6, 7.5-7, 7.5-8: shoot, move, shoot.
#[test]
fn the_motors_rest_for_each_photo_of_shoot_move_shoot() {
    let mut bench = sms(0, 3, 0);
    for frame in 1..3 {
        bench.clear();
        bench.pass(1_999);
        assert_eq!((bench.events().len(), bench.state()), (0, "FrameDelay"));
        bench.pass(1);
        assert_eq!((bench.events(), bench.state()), (vec![OPEN], "Exposing"));
        bench.pass(999);
        assert_eq!(bench.state(), "Exposing");
        bench.pass(1);
        assert_eq!((bench.events(), bench.state()), (vec![Event::MoveToFrame { frame, last: 2 }], "Moving"));
        bench.arrive(1, 1.0);
        assert_eq!((bench.messages().len(), bench.state()), (0, "Moving"));
        bench.arrive(2, 1.0);
        assert_eq!(
            (bench.messages(), bench.state()),
            (["0: SMS_MOTORS_STOPPED", "0: START_FRAME"].map(str::to_owned).to_vec(), "FrameDelay")
        );
    }
    bench.pass(3_000);
    assert_eq!(bench.messages(), ["0: END_OF_MOVE", "0: FULL_STOP"]);
}

/// 7.5-8: motors that do not arrive at the next place end the time lapse (decision K-S10).
#[test]
fn a_motor_that_does_not_get_to_its_place_ends_the_lapse() {
    let mut bench = sms(0, 2, 0);
    bench.pass(3_000);
    bench.arrive(1, 1.0);
    bench.clear();
    bench.pass_with_client(600_000);
    assert_eq!(bench.messages(), ["0: error 2 0", "0: FULL_STOP"]);
    assert_eq!((bench.events(), bench.state()), (vec![Event::StopAll], "Empty"));
}

/// 7.5-9, 7.5-10, 7.5-11.
#[test]
fn photos_are_taken_after_the_move() {
    for mut bench in [continuous(0, 1, 2), sms(0, 1, 2)] {
        bench.pass(2_999);
        bench.clear();
        bench.pass(1);
        assert_eq!((bench.messages(), bench.state()), (vec!["0: END_OF_MOVE".to_owned()], "Post"));
        bench.pass(5_999);
        assert_eq!((bench.events(), bench.messages().len()), (vec![OPEN; 2], 0));
        bench.pass(1);
        assert_eq!(bench.messages(), ["0: POST_MOVE_PHOTOS_COMPLETED", "0: FULL_STOP"]);
        assert_eq!((bench.events(), bench.state()), (vec![Event::MoveOver], "Empty"));
    }
}

/// 7.5-12: the stop is obeyed in every state, and `PostMovePhotosCompleted` is not sent.
#[test]
fn a_stop_ends_a_time_lapse_in_every_state() {
    let mut seen = Vec::new();
    for (mut bench, times) in [(continuous(1, 2, 1), [0, 3_000, 6_000]), (sms(1, 2, 1), [3_000, 2_000, 1_000])] {
        for time in times {
            bench.pass(time);
            let mut stopped = bench.clone();
            stopped.clear();
            seen.push(stopped.state());
            stopped.receive(STOP);
            assert_eq!((stopped.events(), stopped.state()), (vec![Event::StopAll], "Empty"));
            let messages = stopped.messages();
            assert_eq!(messages[0], "0: FULL_STOP");
            assert!(messages.iter().all(|text| !text.contains("POST")), "{messages:?}");
        }
    }
    assert_eq!(seen, ["Pre", "ForwardC", "Post", "FrameDelay", "Exposing", "Moving"]);
}

/// Time lapses in reverse are refused (decision K-J7), and so are photos that take no time (decision K-S18).
#[test]
fn a_lapse_without_photos_or_times_is_refused() {
    let data = lapse(PlaybackMode::TIME_LAPSE_SMS, 0, 2, 0);
    let mut bench = Bench::loaded(Options::default(), data);
    bench.receive(start_to(PlaybackDirection::REVERSE));
    assert_eq!((bench.messages(), bench.state()), (vec!["0: error 2 0".to_owned()], "Loaded"));
    let mode = PlaybackMode::TIME_LAPSE_CONTINUOUS;
    for photos in [photos(0.0, 0.0, 0, 5, 0), photos(1.0, 1.0, 0, 0, 0)] {
        bench.receive(HostMessage::from(trajectory(Playback { playback_mode: mode, ..live() }, photos)));
        assert_eq!((bench.messages(), bench.state()), (vec!["0: error 17 0".to_owned()], "Empty"));
    }
}

#[test]
fn a_photo_is_taken_only_while_no_move_runs() {
    let mut bench = Bench::new(Options::default());
    let picture = |exposure| {
        HostMessage::from(TakePicture { motor_address: MotorAddress::ALL, exposure: Seconds(exposure), tail: &[] })
    };
    bench.receive(picture(1.0));
    assert_eq!((bench.events(), bench.messages().len()), (vec![OPEN], 0));
    for exposure in [-1.0, f32::NAN, f32::INFINITY] {
        bench.receive(picture(exposure));
        assert_eq!((bench.events().len(), bench.messages()), (0, vec!["0: error 2 0".to_owned()]));
    }
}
