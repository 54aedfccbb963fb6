//! A host: uploads, runs, shots. DMC D5, real-time sequence.

use dmc_proto::host::{Command, Event, Failure, Input, Name, Outcome, Progress, Stop, Token, What};
use dmc_proto::message::{
    AckCode, FrameNumber, HardStop, HostMessage, Motor, MotorPositions, Motors, MoveTime, RunFlags, Steps, StopReason,
};
use dmc_proto::upload::{MoveSource, Section, SectionSize, sections};
use dmc_proto::{DeviceMessage, MessageType};

use super::bench::{Desk, EMPTY, begin, frame, jog_all, named, position_frame, run, shot};

const OK: AckCode = AckCode::OK;
const ONE: Token = Token(1);
const RUN_MOVE: u16 = 0x0111;
const GO: u16 = 0x0113;

/// Motors 1 and 2, 600 frames that all differ: six sections.
struct Ramp;

impl MoveSource for Ramp {
    fn start_frame(&self) -> FrameNumber {
        frame(1)
    }
    fn frame_count(&self) -> u32 {
        600
    }
    fn motors(&self) -> Motors {
        Motors(3)
    }
    fn position(&self, _: Motor, index: u32) -> Steps {
        Steps(index.try_into().unwrap())
    }
}

fn failed(failure: Failure) -> Event {
    Event::Failed(ONE, failure)
}

const FINISHED: Event = Event::Done(ONE, Outcome::Finished);

/// A host whose device waits for the signal; the next id is 7.
fn ready(flags: RunFlags) -> Desk {
    let mut desk = Desk::up();
    assert_eq!(desk.sequence(1, run(1, 10, flags)).0, [(2, What::ToFrame(frame(1)))]);
    desk.acked(2, 0x0110, OK);
    assert_eq!(desk.pass(100).0, [(3, What::Status)]);
    assert_eq!(desk.status(3, 0).0, [(4, named(1))]);
    desk.acked(4, RUN_MOVE, OK);
    assert_eq!(desk.pass(100).0, [(5, What::Status)]);
    assert_eq!(desk.status(5, 0), (vec![], vec![]));
    assert_eq!(desk.machine.progress(), Some(Progress::PreRoll));
    assert_eq!(desk.pass(100).0, [(6, What::Status)]);
    assert_eq!(desk.status(6, 0), (vec![], vec![Event::Ready(ONE)]));
    assert_eq!((desk.machine.progress(), desk.wake), (Some(Progress::Ready), None));
    desk
}

/// A host whose device runs; the next id is 8.
fn running(flags: RunFlags) -> Desk {
    let mut desk = ready(flags);
    assert_eq!(desk.command(Command::Go), (vec![(7, What::Go)], vec![]));
    assert_eq!(desk.machine.progress(), Some(Progress::Goes));
    assert_eq!(desk.acked(7, GO, OK), (vec![], vec![Event::Started(ONE)]));
    assert_eq!(desk.machine.progress(), Some(Progress::Runs));
    desk
}

/// What a host does from the end of a run on: it asks until all stand.
fn ends(mut desk: Desk, first: u32) {
    assert_eq!(desk.machine.progress(), Some(Progress::Ends));
    assert_eq!(desk.pass(100).0, [(first, What::Status)]);
    assert_eq!(desk.status(first, 1), (vec![], vec![]));
    assert_eq!(desk.pass(100).0, [(first + 1, What::Status)]);
    assert_eq!(desk.status(first + 1, 0), (vec![], vec![]), "once may be a moment between two moves");
    assert_eq!(desk.pass(100).0, [(first + 2, What::Status)]);
    assert_eq!(desk.status(first + 2, 0), (vec![], vec![FINISHED]));
    assert_eq!((desk.machine.progress(), desk.machine.is_armed(), desk.wake), (None, false, None));
}

/// D5-15
#[test]
fn an_upload_goes_section_by_section() {
    let mut desk = Desk::up();
    assert_eq!(desk.sequence(1, begin(1, 600)), (vec![(2, named(1))], vec![]));
    assert_eq!((desk.machine.progress(), desk.machine.is_loaded()), (Some(Progress::Uploads), None));
    let (mut id, mut section) = (2, None);
    let mut names: Vec<Section> = vec![];
    let mut of = 0x0100;
    loop {
        assert_eq!(desk.acked(id, of, OK), (vec![], vec![Event::NextSection(section)]));
        section = match section {
            None => Section::first(&Ramp, SectionSize::default()),
            Some(section) => Section::next(section, &Ramp, SectionSize::default()),
        };
        id += 1;
        let (sent, _) = desk.step(Input::Section(section));
        let Some(section) = section else {
            assert_eq!(sent, [(id, What::UploadEnd)]);
            break;
        };
        assert_eq!(sent, [(id, What::Named(Name::Section(section)))]);
        assert_eq!(desk.step(Input::Section(None)).1, [Event::Ignored], "one at a time");
        if names.is_empty() {
            id += 1;
            assert_eq!(desk.pass(500).0, [(id, What::Named(Name::Section(section)))], "lost, and sent again");
        }
        names.push(section);
        of = 0x0101;
    }
    assert_eq!(desk.acked(id, 0x0103, OK), (vec![], vec![FINISHED]));
    assert_eq!(desk.machine.is_loaded(), Some(true));
    assert!(names.iter().copied().eq(sections(&Ramp, SectionSize::default())) && names.len() == 6);
}

/// D5-15
#[test]
fn an_upload_that_fails_leaves_nobody_knowing() {
    let mut desk = Desk::up();
    desk.sequence(1, begin(1, 600));
    desk.acked(2, 0x0100, OK);
    desk.step(Input::Section(Section::first(&Ramp, SectionSize::default())));
    let refused = failed(Failure::Refused(AckCode::ERR_RANGE));
    assert_eq!(desk.acked(3, 0x0101, AckCode::ERR_RANGE), (vec![], vec![refused]));
    assert_eq!((desk.machine.progress(), desk.machine.is_loaded()), (None, None));
    desk.sequence(1, begin(1, 600));
    assert_eq!(desk.stop(Stop::All).1, [], "an upload moves nothing: it goes on");
    assert_eq!(desk.machine.progress(), Some(Progress::Uploads));
    let (_, events) = desk.pass(1500);
    assert!(events.contains(&failed(Failure::Timeout)));
}

/// D5-16, D-65
#[test]
fn a_run_is_followed_from_its_first_frame_to_rest() {
    let mut desk = running(RunFlags(0));
    let (sent, events) = desk.hears(0, DeviceMessage::RtEnd(EMPTY));
    assert_eq!((sent, events), (vec![], vec![]));
    ends(desk, 8);
}

/// D5-16
#[test]
fn a_run_waits_until_all_stand_twice() {
    let mut desk = Desk::up();
    desk.sequence(1, run(1, 10, RunFlags(0)));
    desk.acked(2, 0x0110, OK);
    assert_eq!(desk.machine.progress(), Some(Progress::Travels));
    for id in 3..6 {
        assert_eq!(desk.pass(100).0, [(id, What::Status)]);
        assert_eq!(desk.status(id, 2), (vec![], vec![]));
    }
    desk.pass(100);
    assert_eq!(desk.status(6, 0).0, [(7, named(1))]);
    assert_eq!(desk.machine.progress(), Some(Progress::Begins));
    desk.acked(7, RUN_MOVE, OK);
    for (id, motors) in [(8, 0), (9, 2), (10, 0)] {
        assert_eq!(desk.pass(100).0, [(id, What::Status)]);
        assert_eq!(desk.status(id, motors), (vec![], vec![]));
    }
    desk.pass(100);
    assert_eq!(desk.status(11, 0).1, [Event::Ready(ONE)]);
}

/// D5-16
#[test]
fn a_run_that_is_refused_or_lost_has_failed() {
    let mut desk = Desk::up();
    desk.sequence(1, run(1, 10, RunFlags(0)));
    let busy = desk.sequence(2, position_frame(1)).1;
    assert_eq!(busy, [Event::Failed(Token(2), Failure::Busy)], "one sequence at a time");
    let refused = failed(Failure::Refused(AckCode::ERR_GENERAL));
    assert_eq!(desk.acked(2, 0x0110, AckCode::ERR_GENERAL), (vec![], vec![refused]));

    let start = |code| {
        let mut desk = Desk::up();
        desk.sequence(1, run(1, 10, RunFlags(0)));
        desk.acked(2, 0x0110, OK);
        desk.pass(100);
        desk.status(3, 0);
        let (_, events) = desk.acked(4, RUN_MOVE, code);
        assert_eq!(events, [failed(Failure::Refused(code))]);
        desk.machine.is_armed()
    };
    assert!(!start(AckCode::ERR_PREROLL));
    assert!(start(AckCode::ERR_MOVING), "what moves may be a run from before");
    assert!(start(AckCode::ERR_CHECKSUM), "who knows what arrived wrong");

    let mut desk = Desk::up();
    desk.sequence(1, run(1, 10, RunFlags(0)));
    desk.acked(2, 0x0110, OK);
    desk.pass(100);
    desk.status(3, 0);
    let (sent, events) = desk.pass(500);
    assert_eq!((sent, events), (vec![(5, What::Status)], vec![failed(Failure::Timeout)]), "never sent twice");
    assert!(desk.machine.is_armed(), "it may have arrived");

    let mut desk = ready(RunFlags(0));
    desk.command(Command::Go);
    assert_eq!(desk.pass(500), (vec![(8, What::Status)], vec![failed(Failure::Timeout)]), "nor is this");
    assert!(desk.machine.is_armed());

    let mut desk = running(RunFlags(0));
    let stop = HardStop { reason: StopReason::EMERGENCY_STOP, motor: None, tail: &[] };
    let (_, events) = desk.hears(0, DeviceMessage::MotorHardStop(stop));
    assert_eq!(events, [Event::HardStop(StopReason::EMERGENCY_STOP, None), failed(Failure::HardStop)]);
    assert!(desk.machine.is_armed(), "until everything is stopped");
}

/// D5-16
#[test]
fn what_never_comes_to_rest_has_failed_in_the_end() {
    let mut desk = Desk::up();
    desk.sequence(1, position_frame(3));
    desk.acked(2, 0x0110, OK);
    let end = desk.now.after(600_000);
    loop {
        let (sent, events) = desk.pass(1);
        if let [(id, What::Status)] = sent[..] {
            desk.status(id, 1);
        }
        if !events.is_empty() {
            assert_eq!((events, desk.now), (vec![failed(Failure::Timeout)], end));
            break;
        }
    }
    assert_eq!(desk.pass(10_000), (vec![], vec![]));
}

/// D5-17, S-2
#[test]
fn a_signal_that_comes_too_early_is_given_three_times_more() {
    let mut desk = ready(RunFlags(0));
    desk.command(Command::Go);
    for id in 7..10 {
        assert_eq!(desk.acked(id, GO, AckCode::ERR_NOT_IN_POSITION), (vec![], vec![]));
        assert_eq!(desk.pass(100).0, [(id + 1, What::Go)]);
    }
    let mut other = desk.clone();
    assert_eq!(desk.acked(10, GO, OK).1, [Event::Started(ONE)]);
    let refused = failed(Failure::Refused(AckCode::ERR_NOT_IN_POSITION));
    assert_eq!(other.acked(10, GO, AckCode::ERR_NOT_IN_POSITION), (vec![], vec![refused]));

    let mut desk = ready(RunFlags(0));
    desk.command(Command::Go);
    desk.acked(7, GO, AckCode::ERR_NOT_IN_POSITION);
    desk.stop(Stop::All);
    desk.acked(8, 0x0033, OK);
    assert_eq!(desk.pass(60_000), (vec![], vec![]), "not after a stop");
}

/// D5-18
#[test]
fn the_operator_may_start() {
    let go = DeviceMessage::RtGo(EMPTY);
    let mut desk = ready(RunFlags(0));
    assert_eq!(desk.hears(0, go), (vec![], vec![Event::Started(ONE)]));
    assert_eq!(desk.command(Command::Go).1, [Event::Ignored], "too late");
    let mut desk = ready(RunFlags(0));
    desk.command(Command::Go);
    assert_eq!(desk.hears(0, go), (vec![], vec![Event::Started(ONE)]), "before our signal arrived");
    let late = desk.acked(7, GO, AckCode::ERR_NOT_IN_POSITION).1;
    assert!(matches!(late[..], [Event::Stray(..)]), "{late:?}");
    assert_eq!(desk.hears(0, DeviceMessage::RtEnd(EMPTY)), (vec![], vec![]));
    ends(desk, 8);
}

/// D5-19
#[test]
fn a_loop_goes_on_until_it_is_told_to_stop() {
    let mut desk = running(RunFlags::LOOP);
    for _ in 0..10 {
        desk.pass(6000);
        let positions = MotorPositions { move_time: MoveTime::default(), positions: &[], tail: &[] };
        let told = desk.hears(0, DeviceMessage::MotorGetPosition(positions));
        assert_eq!(told, (vec![], vec![Event::Unasked(MessageType(0x0034))]));
        desk.pass(6000);
        assert_eq!(desk.hears(0, DeviceMessage::RtEnd(EMPTY)), (vec![], vec![Event::PassEnded(ONE)]));
    }
    let mut silent = desk.clone();
    assert_eq!(desk.request(2, HostMessage::RtStopLoop(EMPTY)).0, [(8, named(2))]);
    desk.acked(8, 0x0116, OK);
    let mut other = desk.clone();
    desk.hears(0, DeviceMessage::RtEnd(EMPTY));
    ends(desk, 9);
    // Ten frames at ten a second, 200 ms before and 100 ms behind them, and five seconds of patience.
    assert_eq!(other.pass(6299), (vec![], vec![]), "an end that is lost");
    other.pass(1);
    ends(other, 9);
    assert_eq!(silent.pass(6299), (vec![], vec![]), "a loop that nothing is heard of");
    silent.pass(1);
    ends(silent, 8);
}

/// D5-19
#[test]
fn a_pass_that_ends_has_begun() {
    let mut desk = ready(RunFlags::LOOP);
    desk.command(Command::Go);
    assert_eq!(desk.hears(0, DeviceMessage::RtEnd(EMPTY)), (vec![], vec![Event::Started(ONE)]), "the answer was lost");
    assert_eq!(desk.machine.progress(), Some(Progress::Runs));
    let mut desk = ready(RunFlags(0));
    desk.command(Command::Go);
    assert_eq!(desk.hears(0, DeviceMessage::RtEnd(EMPTY)), (vec![], vec![]));
    ends(desk, 8);
}

/// D5-19
#[test]
fn a_loop_does_not_end_before_the_device_knows_of_it() {
    let mut desk = Desk::up();
    desk.sequence(1, run(1, 10, RunFlags::LOOP));
    desk.acked(2, 0x0110, OK);
    desk.request(2, HostMessage::RtStopLoop(EMPTY));
    desk.acked(3, 0x0116, OK);
    desk.pass(100);
    desk.status(4, 0);
    desk.acked(5, RUN_MOVE, OK);
    desk.hears(0, DeviceMessage::RtGo(EMPTY));
    assert_eq!(desk.hears(0, DeviceMessage::RtEnd(EMPTY)), (vec![], vec![Event::PassEnded(ONE)]));

    let mut desk = ready(RunFlags::LOOP);
    desk.request(2, HostMessage::RtStopLoop(EMPTY));
    desk.acked(7, 0x0116, OK);
    desk.hears(0, DeviceMessage::RtGo(EMPTY));
    assert_eq!(desk.hears(0, DeviceMessage::RtEnd(EMPTY)), (vec![], vec![]), "one pass is left");
    ends(desk, 8);
}

/// D5-20, D-68
#[test]
fn a_shot_ends_by_time_if_its_end_is_not_told() {
    let shoot = || {
        let mut desk = Desk::up();
        assert_eq!(desk.sequence(1, shot(3)).0, [(2, named(1))]);
        assert!(desk.machine.is_armed());
        desk.acked(2, 0x0115, OK);
        desk.pass(100);
        desk.status(3, 0);
        desk.pass(100);
        assert_eq!(desk.status(4, 0).1, [Event::Ready(ONE)]);
        desk.command(Command::Go);
        desk.acked(5, GO, OK);
        desk
    };
    let mut desk = shoot();
    assert_eq!(desk.pass(5499), (vec![], vec![]));
    desk.pass(1);
    ends(desk, 6);
    let mut desk = shoot();
    desk.hears(0, DeviceMessage::RtEnd(EMPTY));
    ends(desk, 6);
}

/// D5-22
#[test]
fn a_way_to_a_frame_is_followed_to_rest() {
    for (message, of) in [(position_frame(3), 0x0110), (jog_all(3), 0x0120)] {
        let mut desk = Desk::up();
        assert_eq!(desk.sequence(1, message).0, [(2, named(1))]);
        assert_eq!(desk.acked(2, of, OK), (vec![], vec![]));
        ends(desk, 3);
    }
    let mut desk = Desk::up();
    desk.sequence(1, jog_all(3));
    assert_eq!(desk.pass(500), (vec![(3, What::Status)], vec![failed(Failure::Timeout)]), "a jog is not repeated");
}
