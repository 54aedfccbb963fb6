//! Flows over loopback TCP, on the clock of tokio that stands still while nothing happens.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use examples::moves::Move;
use kos_proto::device::motor::State;
use kos_proto::message::MotorAddress;
use motion_core::time::Millis;
use rigs::kos_device::{KosDevice, Setup};
use rigs::kos_host::KosHost;
use rigs::{LineId, Outgoing, Party as _, Rig as _};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream, UdpSocket};
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep_until};

use super::{Options, discover, drive};
use crate::drive::command::Shots;
use crate::drive::{Command, Stopped, Trouble};
use crate::session::{Session, Target};

const LINE: LineId = LineId(0);

/// How far a motor may be from its curve, in rotations; why, stands in `rigs/tests/kos/bench.rs`.
const TOLERANCE: f64 = 5e-5;

/// Seconds of the move, and where the motors were.
type Seen = Vec<(f64, Vec<f64>)>;

/// A rig that serves one client at a time.
struct Served {
    rig: Arc<Mutex<KosDevice>>,
    address: SocketAddr,
    /// What was seen at each tick of a move.
    path: Arc<Mutex<Seen>>,
    /// Each message cuts the client off.
    cut: mpsc::UnboundedSender<()>,
    serving: tokio::task::JoinHandle<()>,
}

impl Served {
    async fn new(setup: Setup) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let rig = Arc::new(Mutex::new(KosDevice::new(setup)));
        let path = Arc::new(Mutex::new(Vec::new()));
        let (cut, cuts) = mpsc::unbounded_channel();
        let serving = tokio::spawn(serve(listener, Arc::clone(&rig), Arc::clone(&path), cuts));
        Self { rig, address, path, cut, serving }
    }

    /// Does a command as a program would that is started for it; what it says, and how it ends.
    async fn drive(&self, command: Command) -> (String, Result<(), Trouble>) {
        let (_keep, interrupts) = mpsc::unbounded_channel();
        self.drive_until(command, None, interrupts).await
    }

    async fn drive_until(
        &self,
        command: Command,
        password: Option<&[u8]>,
        interrupts: mpsc::UnboundedReceiver<()>,
    ) -> (String, Result<(), Trouble>) {
        let host = KosHost::new(kos_proto::host::Options::default(), password);
        let mut session = Session::connect(host, Target::Tcp(self.address), interrupts).await.unwrap();
        let mut out = Vec::new();
        let mut done = drive(&mut session, &command, &Options::default(), &mut out).await;
        let mut said = String::from_utf8(out).unwrap();
        if done.is_err() && session.host().may_move() {
            let stopped = session.stop().await;
            said = format!("{said}{stopped:?}\n");
        }
        if let Err(trouble) = &mut done {
            assert!(!trouble.to_string().contains('\n'), "{trouble}");
        }
        (said, done)
    }

    async fn done(&self, command: Command) -> String {
        let (said, done) = self.drive(command).await;
        done.unwrap_or_else(|trouble| panic!("{said}{trouble}"));
        said
    }

    async fn trouble(&self, command: Command) -> String {
        let (said, done) = self.drive(command).await;
        done.expect_err(&said).to_string()
    }

    fn at(&self, motor: usize) -> f64 {
        self.rig.lock().unwrap().motors()[motor].at(Millis(u64::MAX / 2)).position
    }

    fn rests(&self) -> bool {
        self.rig.lock().unwrap().motors().iter().all(rigs::motor::Motor::is_idle)
    }
}

async fn serve(
    listener: TcpListener,
    rig: Arc<Mutex<KosDevice>>,
    path: Arc<Mutex<Seen>>,
    mut cuts: mpsc::UnboundedReceiver<()>,
) {
    let start = Instant::now();
    let now = || Millis(u64::try_from(start.elapsed().as_millis()).unwrap());
    let (mut client, mut buffer) = (None::<TcpStream>, [0; 4096]);
    loop {
        let (outgoing, wake) = {
            let mut rig = rig.lock().unwrap();
            rig.advance(now());
            if let Some(moment) = rig.moment() {
                let places = rig.motors().iter().map(|motor| motor.at(now()).position).collect();
                path.lock().unwrap().push((moment, places));
            }
            (std::iter::from_fn(|| rig.poll()).collect::<Vec<_>>(), rig.wake())
        };
        for outgoing in outgoing {
            match (outgoing, &mut client) {
                (Outgoing::Bytes(LINE, bytes), Some(client)) => drop(client.write_all(&bytes).await),
                (Outgoing::HangUp(LINE), client) => *client = None,
                _ => {}
            }
        }
        // Time goes by in small steps, for nobody tells the clock what is on its way through the system.
        let soon = Instant::now() + Duration::from_millis(2);
        let wake = wake.map_or(soon, |wake| soon.min(start + Duration::from_millis(wake.0)));
        let is_free = client.is_none();
        let read = async {
            match &mut client {
                Some(client) => client.read(&mut buffer).await,
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            read = read => match read {
                Ok(len) if len > 0 => rig.lock().unwrap().receive(now(), LINE, &buffer[..len]),
                _ => {
                    client = None;
                    rig.lock().unwrap().close(now(), LINE);
                }
            },
            accepted = listener.accept(), if is_free => {
                client = accepted.ok().map(|(client, _)| client);
                // The clock would not stand still for the time that a message is held back.
                if let Some(client) = &client {
                    client.set_nodelay(true).unwrap();
                }
                rig.lock().unwrap().open(now(), LINE);
            }
            Some(()) = cuts.recv() => {
                client = None;
                rig.lock().unwrap().close(now(), LINE);
            }
            () = sleep_until(wake) => {}
        }
    }
}

fn slide() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../moves/slide.json")
}

fn run() -> Command {
    Command::Run { file: slide(), reverse: false }
}

const CALIBRATE: Command = Command::Calibrate { motor: 1, begin: 0.0, end: 40.0 };

/// Each place on the path is where the file has it.
fn follows_the_file(served: &Served) {
    let file = Move::read(&slide()).unwrap();
    let path = served.path.lock().unwrap();
    for (moment, places) in path.iter() {
        let should = file.axes[0].kos.unwrap().rotations.at(file.axes[0].curve().position(*moment));
        assert!((places[0] - should).abs() < TOLERANCE, "{} at {moment} s, should be {should}", places[0]);
    }
}

#[tokio::test(start_paused = true)]
async fn a_range_is_marked_and_a_move_is_played() {
    let served = Served::new(Setup::with_motors(2)).await;
    let said = served.done(Command::Info).await;
    assert!(said.contains("motor 2: at 0 rotations, not calibrated"), "{said}");
    let refused = served.trouble(run()).await;
    assert_eq!(refused, "motor 1 is not calibrated: drive kos ADDRESS calibrate 1 0 40");
    let said = served.done(CALIBRATE).await;
    assert!(said.ends_with("motor 1 is calibrated: from 0 to 40 rotations\n"), "{said}");
    assert!(served.done(Command::Info).await.contains("motor 1: at 40 of 40 rotations"));

    let said = served.done(run()).await;
    let lines: Vec<_> = said.lines().collect();
    assert!(lines.len() > 8 && lines.len() < 14 && said.ends_with("the move is over\n"), "{said}");
    let elapsed = |path: &[(f64, Vec<f64>)]| path.iter().map(|(moment, _)| *moment).fold(0.0, f64::max);
    assert!((elapsed(&served.path.lock().unwrap()) - 8.0).abs() < 0.01);
    assert!(served.path.lock().unwrap().len() > 7000, "a place each millisecond");
    assert!((served.at(0) - 30.0).abs() < TOLERANCE);

    let said = served.done(Command::Move { motor: 1, position: 12.5, speed: None }).await;
    assert!(said.ends_with("motor 1 rests at 12.5\n") && served.at(0).to_bits() == 12.5_f64.to_bits(), "{said}");
    served.done(Command::Run { file: slide(), reverse: true }).await;
    assert!(served.at(0).abs() < TOLERANCE);
}

#[tokio::test(start_paused = true)]
async fn the_path_is_that_of_the_file() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    let said = served.done(Command::Upload { file: slide() }).await;
    assert!(said.starts_with("the move is stored and ready") && (served.at(0) - 40.0).abs() < TOLERANCE, "{said}");
    assert!(served.rig.lock().unwrap().stored_move().is_some());
    let (said, done) = served.drive(run()).await;
    assert!(done.is_ok(), "{said}");
    // On the way to the begin it is not on the curve.
    let begin = served.path.lock().unwrap().iter().position(|(moment, _)| *moment > 0.0).unwrap();
    served.path.lock().unwrap().drain(..begin);
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
    // The same curves in 2.5 s are too much for the motor.
    let shots = Shots { shots: 5, interval: 0.5, exposure: 0.1, continuous: true };
    let refused = served.trouble(Command::Program { file: slide(), shots }).await;
    assert!(refused.contains("rev/s², at most 100") && refused.ends_with("make it slower"), "{refused}");
    let shots = Shots { shots: 5, interval: 0.5, exposure: 0.6, continuous: false };
    let refused = served.trouble(Command::Program { file: slide(), shots }).await;
    assert_eq!(refused, "an interval of 0.5 s is too short for the exposure: make it longer");
}

#[tokio::test(start_paused = true)]
async fn a_jog_runs_for_its_time() {
    let served = Served::new(Setup::with_motors(2)).await;
    served.done(Command::Jog { motor: 2, speed: -10.0, seconds: 3.0 }).await;
    // Three seconds, less the way to speed up, and as much to slow down.
    assert!(served.rests() && (-31.0..-28.0).contains(&served.at(1)), "{}", served.at(1));
}

#[tokio::test(start_paused = true)]
async fn what_cannot_be_is_refused_in_one_line() {
    let served = Served::new(Setup::with_motors(2)).await;
    served.done(Command::Calibrate { motor: 1, begin: -5.0, end: 20.0 }).await;
    let crane = Path::new(env!("CARGO_MANIFEST_DIR")).join("../moves/whip.json");
    for (command, expected) in [
        (run(), "motor 1 is calibrated over 25 rotations, but axis \"Slide\" is planned over 40: drive kos"),
        (Command::Move { motor: 7, position: 1.0, speed: None }, "there is no motor 7: the rig has motors 1, 2"),
        (Command::Move { motor: 0, position: 1.0, speed: None }, "there is no motor 0"),
        (Command::Move { motor: 2, position: 1.0, speed: None }, "motor 2 is not calibrated"),
        (Command::Move { motor: 1, position: 26.0, speed: None }, "give a position from 0 to 25 rotations"),
        (Command::Move { motor: 1, position: f64::NAN, speed: None }, "give a position from 0 to 25 rotations"),
        (Command::Move { motor: 1, position: 1.0, speed: Some(500.0) }, "give more than 0, and at most 165"),
        (Command::Jog { motor: 1, speed: 0.0, seconds: 1.0 }, "give more than 0"),
        (Command::Jog { motor: 1, speed: 1.0, seconds: f64::INFINITY }, "give a time from 0.01"),
        (Command::Calibrate { motor: 1, begin: 3.0, end: 3.0 }, "give two positions some way from each other"),
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
async fn passwords_are_needed_but_not_for_stops() {
    let setup = Setup { password: b"gaffer".to_vec(), ..Setup::with_motors(1) };
    let served = Served::new(setup).await;
    let with = async |command, password: &'static [u8]| {
        let (_keep, interrupts) = mpsc::unbounded_channel();
        served.drive_until(command, Some(password), interrupts).await
    };
    let (_, wrong) = with(Command::Info, b"best boy").await;
    assert_eq!(wrong.unwrap_err().to_string(), "wrong password: give the one of the rig with --password");
    let (said, stopped) = with(Command::Stop, b"best boy").await;
    assert!(stopped.is_ok() && said.contains("the rig confirmed the stop"), "{said}{stopped:?}");
    let (said, right) = with(Command::Info, b"gaffer").await;
    assert!(right.is_ok() && said.contains("SECOND_SHOOTER_PRO"), "{said}");
}

#[tokio::test(start_paused = true)]
async fn ctrl_c_stops_the_move_and_says_so() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    let (interrupt, interrupts) = mpsc::unbounded_channel();
    let interrupted = async {
        tokio::time::sleep(Duration::from_secs(8)).await;
        assert!(!served.rests());
        interrupt.send(()).unwrap();
    };
    let ((said, done), ()) = tokio::join!(served.drive_until(run(), None, interrupts), interrupted);
    assert!(matches!(done, Err(Trouble::Interrupted)), "{done:?}");
    assert!(said.ends_with(&format!("{:?}\n", Stopped::Confirmed)), "{said}");
    let there = served.at(0);
    assert!(served.rests() && there < 29.0);
    tokio::time::sleep(Duration::from_secs(20)).await;
    assert_eq!(served.at(0).to_bits(), there.to_bits());
}

#[tokio::test(start_paused = true)]
async fn a_move_is_found_again_or_judged_by_its_end() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    for (after, expected) in [(3000, "the move still runs"), (7500, "where nobody saw them arrive")] {
        let cut = async {
            let begun = || served.path.lock().unwrap().iter().any(|(moment, _)| *moment > 0.0);
            served.path.lock().unwrap().clear();
            while !begun() {
                tokio::time::sleep(Duration::from_millis(1)).await;
            }
            tokio::time::sleep(Duration::from_millis(after)).await;
            served.cut.send(()).unwrap();
        };
        let ((said, done), ()) = tokio::join!(served.drive(run()), cut);
        assert!(done.is_ok() && said.contains(expected), "{said}{done:?}");
        assert!((served.at(0) - 30.0).abs() < TOLERANCE);
    }
}

#[tokio::test(start_paused = true)]
async fn a_rig_that_is_gone_is_told_of_in_one_line() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    let gone = async {
        tokio::time::sleep(Duration::from_secs(8)).await;
        served.serving.abort();
    };
    let ((said, done), ()) = tokio::join!(served.drive(run()), gone);
    let line = done.unwrap_err().to_string();
    assert!(line.contains("nobody listens there") && line.contains("the move goes on without us, perhaps"), "{line}");
    assert!(said.ends_with(&format!("{:?}\n", Stopped::NotConfirmed)), "{said}");
    let line = served.trouble(Command::Info).await;
    assert!(line.starts_with(&format!("{}: nobody listens there", served.address)), "{line}");
}

#[tokio::test(start_paused = true)]
async fn a_fault_in_a_move_is_told() {
    let served = Served::new(Setup::with_motors(1)).await;
    served.done(CALIBRATE).await;
    let stall = async {
        tokio::time::sleep(Duration::from_secs(8)).await;
        let mut rig = served.rig.lock().unwrap();
        let now = rig.wake().unwrap();
        rig.stall(now);
    };
    let ((said, done), ()) = tokio::join!(served.drive(run()), stall);
    let line = done.unwrap_err().to_string();
    assert!(line.starts_with("motor 1 has a fault (RUNAWAY), and its range is forgotten"), "{said}{line}");
    assert!(said.ends_with(&format!("{:?}\n", Stopped::Confirmed)), "{said}");
    let calibration = served.rig.lock().unwrap().machine().calibration(MotorAddress(1));
    assert_eq!((calibration, served.rests()), (Some(State::Uncalibrated), true));
}

#[tokio::test]
async fn a_rig_that_announces_itself_is_found() {
    let mut rig = KosDevice::new(Setup { address: [127, 0, 0, 1].into(), ..Setup::default() });
    rig.advance(Millis(0));
    let Some(Outgoing::Announce(bytes)) = rig.poll() else { panic!("it announces itself") };
    let speaker = UdpSocket::bind("127.0.0.1:0").await.unwrap();
    // It answers who asks, too.
    let asked = speaker.local_addr().unwrap();
    let answer = async {
        let mut question = [0; 64];
        let (len, from) = speaker.recv_from(&mut question).await.unwrap();
        rig.datagram(Millis(1), &question[..len]);
        let Some(Outgoing::Answer(answer)) = rig.poll() else { panic!("it answers") };
        speaker.send_to(b"noise", from).await.unwrap();
        speaker.send_to(&bytes, from).await.unwrap();
        speaker.send_to(&answer, from).await.unwrap();
    };
    let listen = "127.0.0.1:0".parse().unwrap();
    let (found, ()) = tokio::join!(discover(listen, Some(asked), Duration::from_secs(20), false), answer);
    assert_eq!(std::net::Ipv4Addr::from(found.unwrap()[0].address()), std::net::Ipv4Addr::LOCALHOST);
    let none = discover(listen, None, Duration::from_millis(20), true).await.unwrap_err().to_string();
    assert!(none.contains("no kOS rig announced itself in 0.02 s"), "{none}");
    let taken = discover(asked, None, Duration::from_secs(1), false).await.unwrap_err().to_string();
    assert!(taken.contains("a port that nobody else uses"), "{taken}");
}
