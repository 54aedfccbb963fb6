//! Host: uploads, runs and shots. DMC D5, real-time sequence.

use dmc_proto::host::{Command, Contents, Event, Failure, Input, Progress, Refusal, Source, StopTarget};
use dmc_proto::message::{
    AckCode, FrameNumber, HardStop, Motor, MotorPositions, Motors, RtEnd, RtGo, RtStopLoop, RunFlags, Steps, StopReason,
};
use dmc_proto::upload::{MoveSource, Section, SectionSize, sections};
use dmc_proto::{MessageId, Token};

use super::bench::{
    COMMAND, Desk, ack, begin, done, failed, frame, hi, jog_all, named, not_confirmed, position_frame, refused, run,
    shot,
};

const OK: AckCode = AckCode::OK;
const ONE: Token = Token(1);
const RUN_MOVE: u16 = 0x0111;
const GO: u16 = 0x0113;
const SILENT: Contents = Contents::Stop(StopTarget::AllSilent);

/// Move of motors 1 and 2 with 600 different frames, which takes six sections.
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

const FINISHED: Event<'static> = done(1);
/// End of the signal to start.
const GONE: Event<'static> = done(COMMAND.0);

/// End of a sequence that the device refused.
const fn refused_by_device(code: AckCode) -> Event<'static> {
    refused(1, Refusal::Device(code))
}

/// Host whose device waits for the signal. The next id is 7.
fn ready(flags: RunFlags) -> Desk {
    let mut desk = Desk::up();
    assert_eq!(desk.sequence(1, run(1, 10, flags)).0, [(2, Contents::ToFrame(frame(1)))]);
    desk.acked(2, 0x0110, OK);
    assert_eq!(desk.pass(100).0, [(3, Contents::Status)]);
    assert_eq!(desk.status(3, 0).0, [(4, named(1))]);
    desk.acked(4, RUN_MOVE, OK);
    assert_eq!(desk.pass(100).0, [(5, Contents::Status)]);
    assert_eq!(desk.status(5, 0), (vec![], vec![]));
    assert_eq!(desk.machine.progress(), Some(Progress::PreRoll));
    assert_eq!(desk.pass(100).0, [(6, Contents::Status)]);
    assert_eq!(desk.status(6, 0), (vec![], vec![Event::Armed(ONE)]));
    assert_eq!((desk.machine.progress(), desk.wake), (Some(Progress::Armed), None));
    desk
}

/// Host whose device runs. The next id is 8.
fn running(flags: RunFlags) -> Desk {
    let mut desk = ready(flags);
    assert_eq!(desk.command(Command::Go), (vec![(7, Contents::Go)], vec![]));
    assert_eq!(desk.machine.progress(), Some(Progress::Goes));
    assert_eq!(desk.acked(7, GO, OK), (vec![], vec![Event::Started(ONE), GONE]));
    assert_eq!(desk.machine.progress(), Some(Progress::Runs));
    desk
}

/// Checks what a host does after the end of a run: it asks until all motors rest.
fn ends(mut desk: Desk, first: u32) {
    assert_eq!(desk.machine.progress(), Some(Progress::Ends));
    assert_eq!(desk.pass(100).0, [(first, Contents::Status)]);
    assert_eq!(desk.status(first, 1), (vec![], vec![]));
    assert_eq!(desk.pass(100).0, [(first + 1, Contents::Status)]);
    assert_eq!(desk.status(first + 1, 0), (vec![], vec![]), "one answer may come between two ways");
    assert_eq!(desk.pass(100).0, [(first + 2, Contents::Status)]);
    assert_eq!(desk.status(first + 2, 0), (vec![], vec![FINISHED]));
    assert_eq!((desk.machine.progress(), desk.machine.is_armed(), desk.wake), (None, false, None));
}

/// D5-15
#[test]
fn an_upload_is_sent_section_by_section() {
    let mut desk = Desk::up();
    assert_eq!(desk.sequence(1, begin(1, 600)), (vec![(2, named(1))], vec![]));
    assert_eq!((desk.machine.progress(), desk.machine.is_loaded()), (Some(Progress::Uploads), None));
    let (mut id, mut section) = (2, None);
    let mut names: Vec<Section> = vec![];
    let mut of = 0x0100;
    loop {
        assert_eq!(desk.acked(id, of, OK), (vec![], vec![Event::NextSection { token: ONE, after: section }]));
        section = match section {
            None => Section::first(&Ramp, SectionSize::default()),
            Some(section) => Section::next(section, &Ramp, SectionSize::default()),
        };
        id += 1;
        let (sent, _) = desk.step(Input::Section(section));
        let Some(section) = section else {
            assert_eq!(sent, [(id, Contents::UploadEnd)]);
            break;
        };
        assert_eq!(sent, [(id, Contents::Application(Source::Section(section)))]);
        assert_eq!(desk.step(Input::Section(None)).1, [Event::SectionNotWanted], "one section at a time is asked for");
        if names.is_empty() {
            id += 1;
            assert_eq!(
                desk.pass(500).0,
                [(id, Contents::Application(Source::Section(section)))],
                "lost, and sent again"
            );
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
fn after_an_upload_that_fails_it_is_unknown_whether_a_move_is_loaded() {
    let mut desk = Desk::up();
    desk.sequence(1, begin(1, 600));
    desk.acked(2, 0x0100, OK);
    desk.step(Input::Section(Section::first(&Ramp, SectionSize::default())));
    let told = vec![refused_by_device(AckCode::ERR_RANGE)];
    assert_eq!(desk.acked(3, 0x0101, AckCode::ERR_RANGE), (vec![], told));
    assert_eq!((desk.machine.progress(), desk.machine.is_loaded()), (None, None));
    desk.sequence(1, begin(1, 600));
    assert_eq!(desk.stop(StopTarget::All).1, [], "an upload moves nothing, so it goes on");
    assert_eq!(desk.machine.progress(), Some(Progress::Uploads));
    let (_, events) = desk.pass(1500);
    assert!(events.contains(&not_confirmed(1)));
}

/// D5-16, D-65
#[test]
fn a_run_is_followed_from_its_first_frame_to_rest() {
    let mut desk = running(RunFlags(0));
    let (sent, events) = desk.receives(0, RtEnd::default().into());
    assert_eq!((sent, events), (vec![], vec![]));
    ends(desk, 8);
}

/// D5-16
#[test]
fn a_run_waits_until_two_answers_tell_rest() {
    let mut desk = Desk::up();
    desk.sequence(1, run(1, 10, RunFlags(0)));
    desk.acked(2, 0x0110, OK);
    assert_eq!(desk.machine.progress(), Some(Progress::Travels));
    for id in 3..6 {
        assert_eq!(desk.pass(100).0, [(id, Contents::Status)]);
        assert_eq!(desk.status(id, 2), (vec![], vec![]));
    }
    desk.pass(100);
    assert_eq!(desk.status(6, 0).0, [(7, named(1))]);
    assert_eq!(desk.machine.progress(), Some(Progress::Begins));
    desk.acked(7, RUN_MOVE, OK);
    for (id, motors) in [(8, 0), (9, 2), (10, 0)] {
        assert_eq!(desk.pass(100).0, [(id, Contents::Status)]);
        assert_eq!(desk.status(id, motors), (vec![], vec![]));
    }
    desk.pass(100);
    assert_eq!(desk.status(11, 0).1, [Event::Armed(ONE)]);
}

/// D5-16
#[test]
fn a_run_that_is_refused_or_lost_ends() {
    let mut desk = Desk::up();
    desk.sequence(1, run(1, 10, RunFlags(0)));
    let busy = desk.sequence(2, position_frame(1)).1;
    assert_eq!(busy, [refused(2, Refusal::Busy)], "one sequence at a time");
    let told = vec![refused_by_device(AckCode::ERR_GENERAL)];
    assert_eq!(desk.acked(2, 0x0110, AckCode::ERR_GENERAL), (vec![], told));

    let start = |code| {
        let mut desk = Desk::up();
        desk.sequence(1, run(1, 10, RunFlags(0)));
        desk.acked(2, 0x0110, OK);
        desk.pass(100);
        desk.status(3, 0);
        assert_eq!(desk.acked(4, RUN_MOVE, code), (vec![(5, SILENT)], vec![refused_by_device(code)]));
        assert!(desk.machine.is_armed(), "the device may keep the run, or an earlier one may still move");
    };
    // The damaged request may be any request.
    for code in [AckCode::ERR_PREROLL, AckCode::ERR_MOVING, AckCode::ERR_CHECKSUM] {
        start(code);
    }

    let mut desk = Desk::up();
    desk.sequence(1, run(1, 10, RunFlags(0)));
    desk.acked(2, 0x0110, OK);
    desk.pass(100);
    desk.status(3, 0);
    let (sent, events) = desk.pass(500);
    let then = vec![(5, SILENT), (6, Contents::Status)];
    assert_eq!((sent, events), (then, vec![not_confirmed(1)]), "the request is sent once");
    assert!(desk.machine.is_armed(), "the request may have arrived");

    let mut desk = ready(RunFlags(0));
    desk.command(Command::Go);
    let unclear = vec![not_confirmed(1), not_confirmed(COMMAND.0)];
    let then = vec![(8, SILENT), (9, Contents::Status)];
    assert_eq!(desk.pass(500), (then, unclear), "the signal is sent once too");
    assert!(desk.machine.is_armed());

    let mut desk = running(RunFlags(0));
    let stop = HardStop { reason: StopReason::EMERGENCY_STOP, motor: None, tail: &[] };
    let (_, events) = desk.receives(0, stop.into());
    assert_eq!(events, [Event::HardStop(StopReason::EMERGENCY_STOP, None), failed(1, Failure::HardStop)]);
    assert!(desk.machine.is_armed(), "the host is armed until everything is stopped");
}

/// D5-16
#[test]
fn a_run_that_never_comes_to_rest_is_not_confirmed() {
    let mut desk = Desk::up();
    desk.sequence(1, position_frame(3));
    desk.acked(2, 0x0110, OK);
    let end = desk.now.after(600_000);
    loop {
        let (sent, events) = desk.pass(1);
        if let [(id, Contents::Status)] = sent[..] {
            desk.status(id, 1);
        }
        if !events.is_empty() {
            assert_eq!((events, desk.now), (vec![not_confirmed(1)], end));
            break;
        }
    }
    assert_eq!(desk.pass(10_000), (vec![], vec![]));
}

/// D5-17, S-2
#[test]
fn a_signal_that_comes_too_early_is_sent_three_times_more() {
    let mut desk = ready(RunFlags(0));
    desk.command(Command::Go);
    for id in 7..10 {
        assert_eq!(desk.acked(id, GO, AckCode::ERR_NOT_IN_POSITION), (vec![], vec![]));
        assert_eq!(desk.pass(100).0, [(id + 1, Contents::Go)]);
    }
    let mut other = desk.clone();
    assert_eq!(desk.acked(10, GO, OK).1, [Event::Started(ONE), GONE]);
    let code = AckCode::ERR_NOT_IN_POSITION;
    let told = vec![refused_by_device(code), refused(COMMAND.0, Refusal::Device(code))];
    assert_eq!(other.acked(10, GO, code), (vec![(11, SILENT)], told), "the signal and the run end");

    let mut desk = ready(RunFlags(0));
    desk.command(Command::Go);
    desk.acked(7, GO, AckCode::ERR_NOT_IN_POSITION);
    desk.stop(StopTarget::All);
    desk.acked(8, 0x0033, OK);
    assert_eq!(desk.pass(60_000), (vec![], vec![]), "the signal is not sent after a stop");
}

/// D5-18
#[test]
fn the_operator_may_start() {
    let go = RtGo::default().into();
    let mut desk = ready(RunFlags(0));
    assert_eq!(desk.receives(0, go), (vec![], vec![Event::Started(ONE)]));
    assert_eq!(desk.command(Command::Go).1, [refused(COMMAND.0, Refusal::Unexpected)], "the run has started already");
    let mut desk = ready(RunFlags(0));
    desk.command(Command::Go);
    assert_eq!(
        desk.receives(0, go),
        (vec![], vec![Event::Started(ONE), GONE]),
        "the operator started it before the signal arrived"
    );
    let late = ack(GO, AckCode::ERR_NOT_IN_POSITION);
    assert_eq!(desk.receives(7, late).1, [Event::Unsolicited(MessageId(7), late)]);
    assert_eq!(desk.receives(0, RtEnd::default().into()), (vec![], vec![]));
    ends(desk, 8);
}

/// D5-19
#[test]
fn a_loop_goes_on_until_it_is_ended() {
    let mut desk = running(RunFlags::LOOP);
    for _ in 0..10 {
        desk.pass(6000);
        let positions = MotorPositions::default().into();
        let told = desk.receives(0, positions);
        assert_eq!(told, (vec![], vec![Event::Unsolicited(MessageId(0), positions)]));
        desk.pass(6000);
        assert_eq!(desk.receives(0, RtEnd::default().into()), (vec![], vec![Event::PassEnded(ONE)]));
    }
    let mut silent = desk.clone();
    assert_eq!(desk.request(2, RtStopLoop::default().into()).0, [(8, named(2))]);
    desk.acked(8, 0x0116, OK);
    let mut other = desk.clone();
    desk.receives(0, RtEnd::default().into());
    ends(desk, 9);
    // A pass has ten frames at ten per second, with 200 ms before and 100 ms after them. The host waits five seconds longer.
    assert_eq!(other.pass(6299), (vec![], vec![]), "the end was lost");
    other.pass(1);
    ends(other, 9);
    assert_eq!(silent.pass(6299), (vec![], vec![]), "the device reports nothing of the loop");
    silent.pass(1);
    ends(silent, 8);
}

/// D5-19
#[test]
fn a_pass_that_ends_has_begun() {
    let mut desk = ready(RunFlags::LOOP);
    desk.command(Command::Go);
    assert_eq!(
        desk.receives(0, RtEnd::default().into()),
        (vec![], vec![Event::Started(ONE), GONE]),
        "the answer was lost"
    );
    assert_eq!(desk.machine.progress(), Some(Progress::Runs));
    let mut desk = ready(RunFlags(0));
    desk.command(Command::Go);
    assert_eq!(desk.receives(0, RtEnd::default().into()), (vec![], vec![GONE]));
    ends(desk, 8);
}

/// D5-19
#[test]
fn a_loop_does_not_end_before_the_device_accepted_it() {
    let mut desk = Desk::up();
    desk.sequence(1, run(1, 10, RunFlags::LOOP));
    desk.acked(2, 0x0110, OK);
    desk.request(2, RtStopLoop::default().into());
    desk.acked(3, 0x0116, OK);
    desk.pass(100);
    desk.status(4, 0);
    desk.acked(5, RUN_MOVE, OK);
    desk.receives(0, RtGo::default().into());
    assert_eq!(desk.receives(0, RtEnd::default().into()), (vec![], vec![Event::PassEnded(ONE)]));

    let mut desk = ready(RunFlags::LOOP);
    desk.request(2, RtStopLoop::default().into());
    desk.acked(7, 0x0116, OK);
    desk.receives(0, RtGo::default().into());
    assert_eq!(desk.receives(0, RtEnd::default().into()), (vec![], vec![]), "one more pass follows");
    ends(desk, 8);
}

/// D5-20, D-68
#[test]
fn a_shot_whose_end_is_not_reported_ends_by_time() {
    let shoot = || {
        let mut desk = Desk::up();
        assert_eq!(desk.sequence(1, shot(3)).0, [(2, named(1))]);
        assert!(desk.machine.is_armed());
        desk.acked(2, 0x0115, OK);
        desk.pass(100);
        desk.status(3, 0);
        desk.pass(100);
        assert_eq!(desk.status(4, 0).1, [Event::Armed(ONE)]);
        desk.command(Command::Go);
        desk.acked(5, GO, OK);
        desk
    };
    let mut desk = shoot();
    assert_eq!(desk.pass(2799), (vec![], vec![]));
    desk.pass(1);
    ends(desk, 6);
    let mut desk = shoot();
    desk.receives(0, RtEnd::default().into());
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
    assert_eq!(desk.pass(500), (vec![(3, Contents::Status)], vec![not_confirmed(1)]), "a jog is not repeated");
}

/// D-77
#[test]
fn a_shot_of_a_loaded_move_goes_to_its_frame_first() {
    let mut desk = Desk::up();
    desk.sequence(1, begin(1, 10));
    desk.acked(2, 0x0100, AckCode::OK);
    desk.step(Input::Section(None));
    assert_eq!(desk.acked(3, 0x0103, AckCode::OK).1, [done(1)]);
    assert_eq!(desk.sequence(2, shot(5)).0, [(4, Contents::ToFrame(FrameNumber(5)))]);
    desk.acked(4, 0x0110, AckCode::OK);
    assert_eq!(desk.machine.progress(), Some(Progress::Travels));
    assert_eq!(desk.pass(100).0, [(5, Contents::Status)]);
    assert_eq!(desk.status(5, 0b1).0, []);
    assert_eq!(desk.pass(100).0, [(6, Contents::Status)]);
    assert_eq!(desk.status(6, 0).0, [(7, named(2))], "the motors rest on the frame");
    // The device cannot go there.
    desk.stop(StopTarget::All);
    desk.acked(8, 0x0033, AckCode::OK);
    assert_eq!(desk.sequence(3, shot(11)).0, [(9, Contents::ToFrame(FrameNumber(11)))]);
    let refusal = refused(3, Refusal::Device(AckCode::ERR_RANGE));
    assert_eq!(desk.acked(9, 0x0110, AckCode::ERR_RANGE), (vec![], vec![refusal]));
    // The device was reset, and has no move.
    desk.receives(0, hi().into());
    desk.receives(10, hi().into());
    desk.command(Command::Configured);
    assert_eq!(desk.sequence(4, shot(5)).0, [(11, named(4))]);
}
