//! Tests of the commands over loopback TCP, with the paused clock of tokio.

mod served;

use std::io::{self, Write};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::time::Duration;

use kos_proto::HostMessage;
use kos_proto::device::motor::{Drive, State};
use kos_proto::message::{
    MotorAddress, Password, RotationsPerSecond, RotationsPerSecondSquared, SetPositionSpeedAcceleration, UserPassword,
};
use motion_core::time::Millis;
use motion_move::Move;
use motion_rigs::device::Named as _;
use motion_rigs::kos_device::{KosDevice, Setup};
use motion_rigs::kos_host::KosHost;
use motion_rigs::{LineId, Outgoing, Party as _, Rig as _};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _, DuplexStream, duplex};
use tokio::net::UdpSocket;
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep, timeout};

use self::served::{LINE, Served};
use super::{Options, discover, drive};
use crate::drive::command::Shots;
use crate::drive::{Command, OBEYED, Stopped, Trouble};
use crate::session::Session;

/// Greatest distance of a motor from its curve, in rotations. `rigs/tests/kos/bench.rs` explains the value.
const TOLERANCE: f64 = 5e-5;

fn slide() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../moves/slide.json")
}

fn run() -> Command {
    Command::Run { file: slide(), reverse: false }
}

const CALIBRATE: Command = Command::Calibrate { motor: 1, begin: 0.0, end: 40.0 };

/// Checks that each position on the path is that of the file.
fn follows_the_file(served: &Served) {
    let file = Move::read(&slide()).unwrap();
    let path = served.path.lock().unwrap();
    for (moment, places) in path.iter() {
        let should = file.axes()[0].kos().unwrap().rotations.at(file.axes()[0].curve().position(*moment));
        assert!((places[0] - should).abs() < TOLERANCE, "{} at {moment} s, should be {should}", places[0]);
    }
}

#[tokio::test(start_paused = true)]
async fn a_range_is_set_and_a_move_is_played() {
    let served = Served::new(Setup::with_motors(2)).await;
    let said = served.done(Command::Info).await;
    assert!(said.contains("motor 2: at 0 rotations, not calibrated"), "{said}");
    let refused = served.trouble(run()).await;
    assert_eq!(refused, "motor 1 is not calibrated: moco drive kos ADDRESS calibrate 1 0 40");
    let said = served.done(CALIBRATE).await;
    assert!(said.ends_with("motor 1 is calibrated: from 0 to 40 rotations\n"), "{said}");
    assert!(served.done(Command::Info).await.contains("motor 1: at 40 of 40 rotations"));

    let said = served.done(run()).await;
    let lines: Vec<_> = said.lines().collect();
    assert!(lines.len() > 8 && lines.len() < 14 && said.ends_with("the move is over\n"), "{said}");
    let elapsed = |path: &[(f64, Vec<f64>)]| path.iter().map(|(moment, _)| *moment).fold(0.0, f64::max);
    assert!((elapsed(&served.path.lock().unwrap()) - 8.0).abs() < 0.01);
    assert!(served.path.lock().unwrap().len() > 7000, "one position for each millisecond");
    assert!((served.at(0) - 30.0).abs() < TOLERANCE);

    let said = served.done(Command::Move { motor: 1, position: 12.5, speed: None }).await;
    assert!(said.ends_with("motor 1 rests at 12.5\n") && served.at(0).to_bits() == 12.5_f64.to_bits(), "{said}");
    served.done(Command::Run { file: slide(), reverse: true }).await;
    assert!(served.at(0).abs() < TOLERANCE);
}

#[tokio::test(start_paused = true)]
async fn the_path_of_a_move_is_that_of_the_file() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    let said = served.done(Command::Upload { file: slide() }).await;
    assert!(said.starts_with("the move is stored and ready") && (served.at(0) - 40.0).abs() < TOLERANCE, "{said}");
    assert!(served.rig.lock().unwrap().stored_move().is_some());
    let (said, done) = served.drive(run()).await;
    assert!(done.is_ok(), "{said}");
    follows_the_file(&served);
}

#[tokio::test(start_paused = true)]
async fn photos_are_taken_along_a_move() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    for (continuous, interval) in [(false, 0.5), (true, 1.6)] {
        let shots = Shots { shots: 5, interval, exposure: 0.1, continuous };
        let said = served.done(Command::Program { file: slide(), shots }).await;
        assert!(said.ends_with("5 photos are taken\n"), "{said}");
    }
    assert!(served.done(Command::Expose { seconds: 0.2 }).await.contains("open for 0.2 s"));
    assert_eq!(served.rig.lock().unwrap().photo_count(), 11);
    // The same curves in 2.5 s exceed the limits of the motor.
    let shots = Shots { shots: 5, interval: 0.5, exposure: 0.1, continuous: true };
    let refused = served.trouble(Command::Program { file: slide(), shots }).await;
    assert!(refused.contains("rev/s², at most 100") && refused.ends_with("make it slower"), "{refused}");
    let shots = Shots { shots: 5, interval: 0.5, exposure: 0.6, continuous: false };
    let refused = served.trouble(Command::Program { file: slide(), shots }).await;
    assert_eq!(refused, "an interval of 0.5 s is too short for the exposure: give a longer one");
}

#[tokio::test(start_paused = true)]
async fn a_jog_runs_for_its_time() {
    let served = Served::new(Setup::with_motors(2)).await;
    served.done(Command::Jog { motor: 2, speed: -10.0, seconds: 3.0 }).await;
    // Three seconds at full speed, except for the acceleration and the deceleration.
    assert!(served.rests() && (-31.0..-28.0).contains(&served.at(1)), "{}", served.at(1));
}

#[tokio::test(start_paused = true)]
async fn an_impossible_command_is_refused_in_one_line() {
    let served = Served::new(Setup::with_motors(2)).await;
    served.done(Command::Calibrate { motor: 1, begin: -5.0, end: 20.0 }).await;
    let crane = Path::new(env!("CARGO_MANIFEST_DIR")).join("../moves/whip.json");
    for (command, expected) in [
        (run(), "motor 1 is calibrated over 25 rotations, but axis \"Slide\" is planned over 40: moco drive kos"),
        (Command::Move { motor: 7, position: 1.0, speed: None }, "there is no motor 7: the rig has motors 1, 2"),
        (Command::Move { motor: 0, position: 1.0, speed: None }, "there is no motor 0"),
        (Command::Move { motor: 2, position: 1.0, speed: None }, "motor 2 is not calibrated"),
        (Command::Move { motor: 1, position: 26.0, speed: None }, "give a position from 0 to 25 rotations"),
        (Command::Move { motor: 1, position: f64::NAN, speed: None }, "give a position from 0 to 25 rotations"),
        (Command::Move { motor: 1, position: 1.0, speed: Some(500.0) }, "give more than 0, and at most 165"),
        (Command::Jog { motor: 1, speed: 0.0, seconds: 1.0 }, "give more than 0"),
        (Command::Jog { motor: 1, speed: 1.0, seconds: f64::INFINITY }, "give a time from 0.01"),
        (Command::Calibrate { motor: 1, begin: 3.0, end: 3.0 }, "give two different positions"),
        (Command::Run { file: crane, reverse: false }, "has no axis for kOS"),
        (Command::Run { file: "no.json".into(), reverse: false }, "no.json: No such file"),
        (Command::Expose { seconds: -1.0 }, "give a time from 0"),
    ] {
        let line = served.trouble(command).await;
        assert!(line.contains(expected), "{line}");
    }
    assert!(served.rests());
}

#[tokio::test(start_paused = true)]
async fn a_very_slow_move_can_be_interrupted() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    for speed in [1e-30, 1e-12] {
        let (interrupt, interrupts) = mpsc::unbounded_channel();
        let later = async {
            sleep(Duration::from_secs(5)).await;
            interrupt.send(()).unwrap();
        };
        let command = Command::Move { motor: 1, position: 2.0, speed: Some(speed) };
        let ((said, done), ()) = tokio::join!(served.drive_until(command, None, interrupts), later);
        assert!(matches!(done, Err(Trouble::Interrupted)), "{said}{done:?}");
        assert!(said.contains("motor 1 moves, at"), "{said}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_move_beyond_the_limits_of_its_file_is_refused() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    let text = std::fs::read_to_string(slide()).unwrap().replace("\"velocity\": 250", "\"velocity\": 100");
    let file = std::env::temp_dir().join(format!("kos-fast-{}.json", std::process::id()));
    std::fs::write(&file, text).unwrap();
    let line = served.trouble(Command::Run { file: file.clone(), reverse: false }).await;
    std::fs::remove_file(file).unwrap();
    assert!(line.contains("the limit is 100 mm/s: make it slower"), "{line}");
    assert!((served.at(0) - 40.0).abs() < TOLERANCE);
}

#[tokio::test(start_paused = true)]
async fn a_stop_by_another_client_is_reported() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    for (command, expected) in [
        (Command::Move { motor: 1, position: 2.0, speed: None }, "not at 2: check what blocks it"),
        (Command::Calibrate { motor: 1, begin: 0.0, end: 30.0 }, "check what blocks it"),
        (run(), "the move was stopped by something else: check the rig"),
    ] {
        let stop = async {
            sleep(Duration::from_millis(if command == run() { 6000 } else { 700 })).await;
            let motor = MotorAddress(1);
            let message = SetPositionSpeedAcceleration::stop(motor, None, RotationsPerSecondSquared(100.0));
            let mut bytes = [0; 64];
            let len = HostMessage::from(message).encode_into(&mut bytes).unwrap();
            assert!(!served.rests());
            let mut rig = served.rig.lock().unwrap();
            let now = rig.wake().unwrap();
            rig.receive(now, LINE, &bytes[..len]);
        };
        let ((said, done), ()) = tokio::join!(served.drive(command.clone()), stop);
        let line = done.expect_err(&said).to_string();
        assert!(line.contains(expected), "{said}{line}");
        assert!(served.rests());
        served.done(CALIBRATE).await;
    }
}

#[tokio::test(start_paused = true)]
async fn a_move_that_ended_early_without_a_connection_is_reported() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    let breaks = async {
        sleep(Duration::from_secs(8)).await;
        served.cut.send(()).unwrap();
        sleep(Duration::from_millis(100)).await;
        let mut rig = served.rig.lock().unwrap();
        let now = rig.wake().unwrap();
        rig.stall(now);
    };
    let ((said, done), ()) = tokio::join!(served.drive(run()), breaks);
    let line = done.expect_err(&said).to_string();
    assert_eq!(line, "the move did not reach its end while the connection was lost: check the rig");
    assert!(served.rests(), "{said}");
}

#[tokio::test(start_paused = true)]
async fn a_password_is_needed_except_for_stops() {
    let setup = Setup { password: b"gaffer".to_vec(), ..Setup::with_motors(1) };
    let served = Served::new(setup).await;
    let with = async |command, password: &'static [u8]| {
        let (_keep, interrupts) = mpsc::unbounded_channel();
        served.drive_until(command, Some(password), interrupts).await
    };
    let (_, wrong) = with(Command::Info, b"best boy").await;
    assert_eq!(wrong.unwrap_err().to_string(), "wrong password: give the password of the rig with --password");
    // A stop needs none, but without one the rig does not tell when its motors rest.
    let (said, stopped) = with(Command::Stop, b"best boy").await;
    assert_eq!((said.as_str(), stopped.unwrap_err().to_string().as_str()), ("", OBEYED));
    let (said, right) = with(Command::Info, b"gaffer").await;
    assert!(right.is_ok() && said.contains("SECOND_SHOOTER_PRO"), "{said}");
}

/// The rig ignores everything while it is locked, as the document says. The stop is effective directly after the password.
#[tokio::test(start_paused = true)]
async fn a_stop_of_a_locked_rig_is_effective_at_once() {
    let setup = Setup { password: b"gaffer".to_vec(), ..Setup::with_motors(1) };
    let served = Served::new(setup.with_quirks("locked-ignores-all").unwrap()).await;
    let by_another = |message: HostMessage<'_>| {
        let mut bytes = [0; 64];
        let len = message.encode_into(&mut bytes).unwrap();
        let mut rig = served.rig.lock().unwrap();
        let now = served.now();
        rig.receive(now, LineId(1), &bytes[..len]);
    };
    served.rig.lock().unwrap().open(served.now(), LineId(1));
    by_another(UserPassword { password: Password(b"gaffer"), tail: &[] }.into());
    let (speed, acceleration) = (RotationsPerSecond(20.0), RotationsPerSecondSquared(100.0));
    let jog = SetPositionSpeedAcceleration::jog(MotorAddress(1), speed, acceleration);
    for (password, stops) in [(&b"best boy"[..], false), (b"gaffer", true)] {
        by_another(jog.into());
        sleep(Duration::from_millis(500)).await;
        let (before, from) = (Instant::now(), served.at(0));
        let (_keep, interrupts) = mpsc::unbounded_channel();
        let (said, done) = served.drive_until(Command::Stop, Some(password), interrupts).await;
        if stops {
            assert!(done.is_ok() && said.contains("all motors rest"), "{said}{done:?}");
            // The way of a fifth of a second at 20 rev/s, and the way of the deceleration.
            assert!(served.rests() && served.at(0) - from < 20.0 * 0.2 + 2.0, "{}", served.at(0) - from);
        } else {
            let line = done.unwrap_err().to_string();
            assert!(line.starts_with("wrong password: the rig may ignore the stop"), "{line}");
            assert!(before.elapsed() < Duration::from_secs(3), "{:?}", before.elapsed());
            assert!(!served.rests());
        }
    }
}

/// A rig that ignores the direction plays the mirrored move, and a rig that does not know some messages is driven by others
/// or refuses in one line.
#[tokio::test(start_paused = true)]
async fn a_rig_that_lacks_something_is_driven_without_it_or_refuses_at_once() {
    let served = Served::new(Setup::with_motors(1).with_quirks("ignores-direction").unwrap()).await;
    served.done(CALIBRATE).await;
    served.done(Command::Run { file: slide(), reverse: true }).await;
    assert!(served.at(0).abs() < TOLERANCE, "{}", served.at(0));

    let without = "no-bump,unsupported=0x0f,begin-nonzero";
    let served = Served::new(Setup::with_motors(1).with_quirks(without).unwrap()).await;
    served.done(CALIBRATE).await;
    served.done(run()).await;
    assert!((served.at(0) - 30.0).abs() < 0.01, "{}", served.at(0));
    served.done(Command::Move { motor: 1, position: 7.0, speed: None }).await;
    // The range begins elsewhere now, as the rig counts. That is no reason to refuse the move.
    served.done(CALIBRATE).await;
    served.done(run()).await;

    for (action, command, expected) in [
        (0x02, CALIBRATE, "the rig does not know ResetAxis (0x02)"),
        (0x03, CALIBRATE, "the rig does not know MarkBeginPosition (0x03)"),
        (0x04, CALIBRATE, "the rig does not know MarkEndPosition (0x04)"),
        (0x05, run(), "the rig does not know StartPlayback (0x05)"),
        (0x09, Command::Expose { seconds: 0.2 }, "the rig does not know TakePicture (0x09)"),
        (0x0f, Command::Upload { file: slide() }, "the rig does not know SetupPlayback (0x0f)"),
        (
            0x1c,
            Command::Jog { motor: 1, speed: 2.0, seconds: 1.0 },
            "the rig does not know SetPositionSpeedAcceleration",
        ),
    ] {
        let quirk = format!("unsupported={action}");
        let served = Served::new(Setup::with_motors(1).with_quirks(&quirk).unwrap()).await;
        if command != CALIBRATE {
            served.done(CALIBRATE).await;
        }
        let begun = Instant::now();
        let line = served.trouble(command).await;
        assert!(line.starts_with(expected), "{line}");
        assert!(begun.elapsed() < Duration::from_secs(9), "{expected}: {:?}", begun.elapsed());
    }
}

/// Output that interrupts the command as soon as it prints a line.
struct Interrupting(&'static str, mpsc::UnboundedSender<()>);

impl Write for Interrupting {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        if String::from_utf8_lossy(line).contains(self.0) {
            self.1.send(()).unwrap();
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A rig that does not know bumps is jogged instead. But nothing is moved after Ctrl-C.
#[tokio::test(start_paused = true)]
async fn nothing_is_tried_instead_after_an_interrupt() {
    let served = Served::new(Setup::with_motors(1).with_quirks("no-bump").unwrap()).await;
    let (interrupt, interrupts) = mpsc::unbounded_channel();
    let mut out = Interrupting("is where its range begins", interrupt);
    let calibrate = Command::Calibrate { motor: 1, begin: 5.0, end: 40.0 };
    let done = served.drive_into(calibrate, None, interrupts, &mut out).await;
    assert!(matches!(done, Err(Trouble::Interrupted)), "{done:?}");
    assert!((served.at(0) - 5.0).abs() < 0.01, "{}", served.at(0));
}

#[tokio::test(start_paused = true)]
async fn an_interrupted_move_is_stopped_and_the_stop_is_reported() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    let (interrupt, interrupts) = mpsc::unbounded_channel();
    let interrupted = async {
        sleep(Duration::from_secs(8)).await;
        assert!(!served.rests());
        interrupt.send(()).unwrap();
    };
    let ((said, done), ()) = tokio::join!(served.drive_until(run(), None, interrupts), interrupted);
    assert!(matches!(done, Err(Trouble::Interrupted)), "{done:?}");
    assert!(said.ends_with(&format!("stop: {:?}\n", Stopped::Confirmed)), "{said}");
    let there = served.at(0);
    assert!(served.rests() && there < 29.0);
    sleep(Duration::from_secs(20)).await;
    assert_eq!(served.at(0).to_bits(), there.to_bits());
}

#[tokio::test(start_paused = true)]
async fn after_a_lost_connection_a_move_is_followed_or_its_end_is_checked() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    for (after, expected) in [(3000, "the move still runs"), (7500, "were not observed on the way")] {
        let cut = async {
            let begun = || served.path.lock().unwrap().iter().any(|(moment, _)| *moment > 0.0);
            served.path.lock().unwrap().clear();
            while !begun() {
                sleep(Duration::from_millis(1)).await;
            }
            sleep(Duration::from_millis(after)).await;
            served.cut.send(()).unwrap();
        };
        let ((said, done), ()) = tokio::join!(served.drive(run()), cut);
        assert!(done.is_ok() && said.contains(expected), "{said}{done:?}");
        assert!((served.at(0) - 30.0).abs() < TOLERANCE);
    }
}

/// At the stop, the client has tried to connect for three seconds, and the next attempt is four seconds away.
#[tokio::test(start_paused = true)]
async fn a_stop_does_not_wait_for_the_next_attempt_to_connect() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    let (interrupt, interrupts) = mpsc::unbounded_channel();
    let back = async {
        sleep(Duration::from_secs(8)).await;
        served.serving.abort();
        sleep(Duration::from_millis(3500)).await;
        served.again().await;
        interrupt.send(()).unwrap();
    };
    let ((said, done), ()) = tokio::join!(served.drive_until(run(), None, interrupts), back);
    assert!(matches!(done, Err(Trouble::Interrupted)), "{done:?}");
    assert!(said.ends_with(&format!("stop: {:?}\n", Stopped::Confirmed)), "{said}");
}

#[tokio::test(start_paused = true)]
async fn a_rig_that_is_gone_is_reported_in_one_line() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    let gone = async {
        sleep(Duration::from_secs(8)).await;
        served.serving.abort();
    };
    let ((said, done), ()) = tokio::join!(served.drive(run()), gone);
    let line = done.unwrap_err().to_string();
    assert!(line.contains("nothing listens there") && line.contains("the move may still run"), "{line}");
    assert!(said.ends_with(&format!("stop: {:?}\n", Stopped::NotConfirmed)), "{said}");
    let line = served.trouble(Command::Info).await;
    assert!(line.starts_with(&format!("{}: nothing listens there", served.address)), "{line}");
}

#[tokio::test(start_paused = true)]
async fn a_fault_in_a_move_is_reported() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    let stall = async {
        sleep(Duration::from_secs(8)).await;
        let mut rig = served.rig.lock().unwrap();
        let now = rig.wake().unwrap();
        rig.stall(now);
    };
    let ((said, done), ()) = tokio::join!(served.drive(run()), stall);
    let line = done.unwrap_err().to_string();
    assert!(line.starts_with("motor 1 has a fault (RUNAWAY) and has lost its range"), "{said}{line}");
    assert!(said.ends_with(&format!("stop: {:?}\n", Stopped::Confirmed)), "{said}");
    let calibration = served.rig.lock().unwrap().machine().motor(MotorAddress(1)).map(Drive::state);
    assert_eq!((calibration, served.rests()), (Some(State::Uncalibrated), true));
}

#[tokio::test]
async fn a_rig_that_announces_itself_is_found() {
    let mut rig = KosDevice::new(Setup { address: [127, 0, 0, 1].into(), ..Setup::default() });
    rig.advance(Millis(0));
    let Some(Outgoing::Announce(bytes)) = rig.poll() else { panic!("the rig announces itself") };
    let speaker = UdpSocket::bind("127.0.0.1:0").await.unwrap();
    // The rig also answers questions.
    let asked = speaker.local_addr().unwrap();
    let answer = async {
        let mut question = [0; 64];
        let (len, from) = speaker.recv_from(&mut question).await.unwrap();
        let SocketAddr::V4(sender) = from else { panic!("{from}") };
        rig.datagram(Millis(1), sender, &question[..len]);
        let Some(Outgoing::Datagram(to, answer)) = rig.poll() else { panic!("the rig answers") };
        assert_eq!(to, sender);
        speaker.send_to(b"noise", from).await.unwrap();
        speaker.send_to(&bytes, from).await.unwrap();
        speaker.send_to(&answer, from).await.unwrap();
    };
    let listen = "127.0.0.1:0".parse().unwrap();
    let (found, ()) = tokio::join!(discover(listen, Some(asked), Duration::from_secs(20), false), answer);
    assert_eq!(Ipv4Addr::from(found.unwrap()[0].address()), Ipv4Addr::LOCALHOST);
    let none = discover(listen, None, Duration::from_millis(20), true).await.unwrap_err().to_string();
    assert!(none.contains("no kOS rig announced itself in 0.02 s"), "{none}");
    let taken = discover(asked, None, Duration::from_secs(1), false).await.unwrap_err().to_string();
    assert!(taken.contains("the port is in use"), "{taken}");
}

/// Serves on a line in memory that takes 64 bytes a second, except that shorter messages are taken at once.
async fn slow(rig: &mut KosDevice, start: Instant, mut line: DuplexStream) {
    let mut buffer = [0; 64];
    let now = || Millis(start.elapsed().as_millis().try_into().unwrap());
    rig.open(now(), LINE);
    loop {
        rig.advance(now());
        while let Some(outgoing) = rig.poll() {
            if let Outgoing::Bytes(LINE, bytes) = outgoing {
                line.write_all(&bytes).await.unwrap();
            }
        }
        let wake = rig.wake().map_or(Duration::from_secs(1), |wake| Duration::from_millis(wake.since(now())));
        if let Ok(Ok(len @ 1..)) = timeout(wake, line.read(&mut buffer)).await {
            rig.receive(now(), LINE, &buffer[..len]);
            if len == buffer.len() {
                sleep(Duration::from_secs(1)).await;
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn the_progress_of_an_upload_over_a_slow_line_is_printed() {
    let (mut rig, start) = (KosDevice::new(Setup::with_motors(1)), Instant::now());
    let (options, mut said) = (Options::default(), Vec::new());
    for command in [CALIBRATE, Command::Upload { file: slide() }] {
        let (near, far) = duplex(64);
        let (_interrupt, interrupts) = mpsc::unbounded_channel();
        let host = KosHost::new(kos_proto::host::Options::default(), None);
        let mut session = Session::over(host, near, interrupts);
        tokio::select! {
            done = drive(&mut session, &command, &options, &mut said) => done.unwrap(),
            () = slow(&mut rig, start, far) => unreachable!("it serves for ever"),
        }
        rig.close(Millis(start.elapsed().as_millis().try_into().unwrap()), LINE);
    }
    let said = String::from_utf8(said).unwrap();
    let parts: Vec<u8> = said
        .lines()
        .filter_map(|line| line.strip_prefix("the move is uploaded: ")?.strip_suffix(" %")?.parse().ok())
        .collect();
    assert!(parts.len() > 1 && parts.is_sorted() && parts.iter().all(|part| *part < 100), "{said}");
    assert!(said.ends_with("the motors do not move until it is played\n"), "{said}");
}
