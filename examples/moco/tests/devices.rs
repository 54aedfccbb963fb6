//! Each command of `moco drive` with each device that `moco simulate` knows by name, and the page `docs/devices.md`, which tells it.
//!
//! `UPDATE=1 cargo test -p moco --test devices` writes the page again.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use std::{env, fs};

use hoot_proto::Address;
use hoot_proto::message::{Microstep, Motor};
use moco::drive::command::Shots;
use moco::drive::{Command, Driven, Stopped, Trouble, dmc, hoot, kos};
use moco::session::Session;
use motion_core::time::Millis;
use motion_rigs::device::Named;
use motion_rigs::dmc_device::{self, DmcDevice};
use motion_rigs::dmc_host::DmcHost;
use motion_rigs::hoot_node::{self, HootNode};
use motion_rigs::kos_device::{self, KosDevice};
use motion_rigs::kos_host::KosHost;
use motion_rigs::{LineId, Outgoing, Rig};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::sync::mpsc::unbounded_channel;
use tokio::time::{Instant, sleep, sleep_until};

const HEAD: &str = "\
# Devices, and what `moco drive` can do with them

This page is made by a test, which does each command with each simulated device and looks at its motors and its camera.
`moco simulate PROTOCOL --device NAME` runs the device, and `moco simulate PROTOCOL --list` prints the names. A number in the
table stands for the line with which `moco drive` refuses the command or ends with status 1; after it, everything rests.
\"done, but\" and a number means that the simulated device did the command. A real device was seen to do what the line with that
number tells; no test repeats that.
";

/// What a user has to know of hoot nodes, and no node can tell.
const OF_HOOT: &str = "
A hoot node that hears nothing for longer than the time to wait hangs when a second packet waits at it, and then obeys no stop:
switch its power off. The master sends nothing twice while it knows that a command blocks the node; it cannot know of other
reasons, such as a computer that holds bytes back.
";

/// What real hoot nodes did besides, in a simulator of their processor with its step and shutter pins counted, and the
/// simulated nodes do not: device, command, and line.
const BUT_HOOT: &[(&str, &str, &str)] = &[
    ("2014-10-15", "program", EIGHTHS),
    ("2014-10-15", "program --continuous", EIGHTHS),
    ("2014-10-29", "run", EIGHTHS),
    ("2014-10-29", "program", EIGHTHS),
    ("2014-10-29", "program --continuous", EIGHTHS),
    ("2014-11-03", "run", EIGHTHS),
    ("2014-11-03", "program", EIGHTHS),
    ("2014-11-03", "program --continuous", EIGHTHS),
    ("v0.20", "run", RESTS),
    ("v0.20", "run --reverse", RESTS),
];

const RESTS: &str = "real firmware of this version begins no video while the dead-man is on: `drive` says after three times \
                     its time that it is not done, and stops it";
const EIGHTHS: &str = "real firmware changed the pins of motor 1 to eighth steps and went on counting quarter steps, also in \
                       later commands: the motor goes half of the way that its positions tell";

const LINE: LineId = LineId(0);
/// Range of positions of motor 1 in `pan.json`, in degrees.
const PAN: f64 = 90.0;

const FILE: &str = "devices.json";

/// Writes the move file: `pan.json`, on hoot with a fifth of its steps, because a start chooses finer microsteps then.
fn write_file() {
    let pan = Path::new(env!("CARGO_MANIFEST_DIR")).join("../moves/pan.json");
    let pan = fs::read_to_string(pan).expect("the move file exists");
    let hoot = |steps| format!("\"hoot\": {{ \"motor\": 1, \"steps_per_unit\": {steps} }}");
    assert!(pan.contains(&hoot(100)));
    let slow = pan.replace(&hoot(100), &hoot(20));
    fs::write(Path::new(env!("CARGO_TARGET_TMPDIR")).join(FILE), slow).expect("the move file can be written");
}

/// Rig of a protocol, and the commands that fit it.
trait Bench: Rig + Send + Sized + 'static {
    type Setup: Named + Default;
    type Host: Driven;

    /// Units of a motor for each degree of the move file.
    const UNITS: f64;
    /// Speed of a jog.
    const JOG: f64;
    /// What real devices did besides in a command that is done: device, command, and line.
    const BUT: &[(&str, &str, &str)] = &[];

    fn new(setup: Self::Setup) -> Self;
    fn host() -> Self::Host;
    fn photos(&self) -> u64;

    /// Way that motor 1 turns back and forth without moving anything, in the units of a new rig.
    fn backlash(&self) -> f64 {
        0.0
    }

    /// Position of a motor, in the units of a new rig.
    fn place(&self, motor: usize, now: Millis) -> f64 {
        self.motors()[motor].at(now).position
    }

    async fn drive(session: &mut Session<Self::Host>, command: &Command, said: &mut Vec<u8>) -> Result<(), Trouble>;
}

impl Bench for KosDevice {
    type Setup = kos_device::Setup;
    type Host = KosHost;
    const UNITS: f64 = 0.05;
    const JOG: f64 = 1.0;

    fn new(setup: Self::Setup) -> Self {
        Self::new(setup)
    }

    fn host() -> KosHost {
        KosHost::new(kos_proto::host::Options::default(), None)
    }

    fn photos(&self) -> u64 {
        self.photos().count() as u64
    }

    async fn drive(session: &mut Session<KosHost>, command: &Command, said: &mut Vec<u8>) -> Result<(), Trouble> {
        kos::drive(session, command, &kos::Options::default(), said).await
    }
}

impl Bench for DmcDevice {
    type Setup = dmc_device::Setup;
    type Host = DmcHost;
    const UNITS: f64 = 100.0;
    const JOG: f64 = 1.0;

    fn new(setup: Self::Setup) -> Self {
        Self::new(setup)
    }

    fn host() -> DmcHost {
        DmcHost::new(dmc_proto::host::Options::default())
    }

    fn photos(&self) -> u64 {
        self.photo_count()
    }

    async fn drive(session: &mut Session<DmcHost>, command: &Command, said: &mut Vec<u8>) -> Result<(), Trouble> {
        dmc::drive(session, command, said).await
    }
}

impl Bench for HootNode {
    type Setup = hoot_node::Setup;
    type Host = motion_rigs::hoot_master::HootMaster;
    const UNITS: f64 = 20.0;
    const JOG: f64 = 500.0;
    const BUT: &[(&str, &str, &str)] = BUT_HOOT;

    fn new(setup: Self::Setup) -> Self {
        Self::new(setup)
    }

    fn host() -> Self::Host {
        hoot::master(Address::DEFAULT).expect("a node can have this address")
    }

    fn photos(&self) -> u64 {
        self.camera().taken()
    }

    fn backlash(&self) -> f64 {
        let settings = self.machine().motor(Motor::One).settings();
        f64::from(settings.backlash.0) * f64::from(Microstep::QUARTER.0) / f64::from(settings.microstep.0)
    }

    fn place(&self, motor: usize, now: Millis) -> f64 {
        let microstep = |of| self.machine().motor(of).settings().microstep.0;
        let part = f64::from(microstep(Motor::ALL[motor])) / f64::from(Microstep::QUARTER.0);
        self.motors()[motor].at(now).position / part
    }

    async fn drive(session: &mut Session<Self::Host>, command: &Command, said: &mut Vec<u8>) -> Result<(), Trouble> {
        hoot::drive(session, command, Address::DEFAULT, 0.1, said).await
    }
}

/// Rig that is served, and the positions of its first motor.
struct Served<R> {
    rig: R,
    /// Least and greatest position of each motor since the command began.
    ways: Vec<(f64, f64)>,
}

impl<R: Bench> Served<R> {
    /// Begins to watch the motors from where they are.
    fn watch(&mut self, now: Millis) {
        self.rig.advance(now);
        let places = (0..self.rig.motors().len()).map(|motor| self.rig.place(motor, now));
        self.ways = places.map(|place| (place, place)).collect();
    }

    fn rests(&self) -> bool {
        self.rig.motors().iter().all(motion_rigs::motor::Motor::rests)
    }

    fn work(&mut self, now: Millis) -> VecDeque<Vec<u8>> {
        self.rig.advance(now);
        for (motor, way) in self.ways.iter_mut().enumerate() {
            let place = self.rig.place(motor, now);
            *way = (way.0.min(place), way.1.max(place));
        }
        let mut all = VecDeque::new();
        while let Some(outgoing) = self.rig.poll() {
            if let Outgoing::Bytes(LINE, bytes) = outgoing {
                all.push_back(bytes);
            }
        }
        all
    }
}

type Shared<R> = Arc<Mutex<Served<R>>>;

fn lock<R>(shared: &Shared<R>) -> MutexGuard<'_, Served<R>> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Carries bytes between a line and a rig until the line is closed.
async fn serve<R: Bench>(shared: Shared<R>, start: Instant, mut line: DuplexStream) {
    let now = || Millis(start.elapsed().as_millis().try_into().unwrap_or(u64::MAX));
    lock(&shared).rig.open(now(), LINE);
    let mut buffer = [0; 4096];
    loop {
        let out = lock(&shared).work(now());
        for bytes in out {
            if line.write_all(&bytes).await.is_err() {
                break;
            }
        }
        let wake = lock(&shared).rig.wake().map_or(Duration::from_hours(1), |wake| Duration::from_millis(wake.0));
        tokio::select! {
            read = line.read(&mut buffer) => match read {
                Ok(len) if len > 0 => lock(&shared).rig.receive(now(), LINE, &buffer[..len]),
                _ => break,
            },
            () = sleep_until(start + wake) => {}
        }
    }
    lock(&shared).rig.close(now(), LINE);
}

/// Stops the rig, and looks whether it rests at the moment at which the stop is said to be confirmed.
async fn stops<R: Bench>(shared: &Shared<R>, start: Instant, session: &mut Session<R::Host>, command: &Command) {
    assert_eq!(session.stop().await, Stopped::Confirmed, "{command:?}");
    let mut served = lock(shared);
    served.work(Millis(start.elapsed().as_millis().try_into().unwrap_or(u64::MAX)));
    assert!(served.rests(), "{command:?}: the stop is confirmed, and a motor moves");
    assert!(!session.host().may_move(), "{command:?}: the stop is confirmed, and the host does not know that all rest");
}

/// Does a command in a session of its own, as the program does. Returns the line of the trouble. An interrupted command
/// is done if the rig confirms the stop.
async fn done<R: Bench>(
    shared: &Shared<R>,
    start: Instant,
    command: &Command,
    is_interrupted: bool,
) -> Result<(), String> {
    let (near, far) = tokio::io::duplex(4096);
    let server = tokio::spawn(serve(Arc::clone(shared), start, far));
    let (interrupt, interrupts) = unbounded_channel();
    let played = Arc::clone(shared);
    let watch = tokio::spawn(async move {
        while !is_interrupted || lock(&played).rig.moment().is_none() {
            sleep(Duration::from_millis(50)).await;
        }
        sleep(Duration::from_secs(1)).await;
        let _ = interrupt.send(());
    });
    let mut session = Session::over(R::host(), near, interrupts);
    let mut said = Vec::new();
    let mut result = R::drive(&mut session, command, &mut said).await;
    watch.abort();
    assert!(!is_interrupted || result.is_err(), "{command:?} ended before it was interrupted");
    if matches!(result, Err(Trouble::Interrupted)) {
        assert!(is_interrupted, "{command:?}");
        stops(shared, start, &mut session, command).await;
        result = Ok(());
    } else if session.host().may_move() {
        assert!(result.is_err(), "{command:?} is done, and something may move: {}", String::from_utf8_lossy(&said));
        stops(shared, start, &mut session, command).await;
    }
    drop(session);
    server.await.expect("the rig does not panic");
    result.map_err(|trouble| trouble.to_string())
}

/// Commands of the page: a short name, and the command.
fn commands<R: Bench>() -> Vec<(&'static str, Command)> {
    let file = || PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(FILE);
    let shots = |continuous| Shots { shots: 3, interval: 3.0, exposure: 0.1, continuous };
    vec![
        ("info", Command::Info),
        ("calibrate", Command::Calibrate { motor: 1, begin: 0.0, end: 100.0 * R::UNITS }),
        ("upload", Command::Upload { file: file() }),
        ("run", Command::Run { file: file(), reverse: false }),
        ("run, Ctrl-C", Command::Run { file: file(), reverse: false }),
        ("jog", Command::Jog { motor: 1, speed: -R::JOG, seconds: 2.0 }),
        ("move", Command::Move { motor: 1, position: 10.0 * R::UNITS, speed: Some(4.0 * R::UNITS) }),
        ("run --reverse", Command::Run { file: file(), reverse: true }),
        ("program", Command::Program { file: file(), shots: shots(false) }),
        ("program --continuous", Command::Program { file: file(), shots: shots(true) }),
        ("expose", Command::Expose { seconds: 0.1 }),
        ("stop", Command::Stop),
    ]
}

/// Checks that the rig really did what is said to be done, and that no other motor moved. The ways are in degrees.
fn check<R: Bench>(name: &str, ways: &[(f64, f64)], last: f64, photos: u64, backlash: f64) {
    let width = |(least, greatest): (f64, f64)| (greatest - least) / R::UNITS;
    let (one, others) = ways.split_first().expect("there is a motor");
    for way in others {
        assert!(width(*way).abs() < f64::EPSILON, "{name}: another motor moved by {}", width(*way));
    }
    let (width, at, backlash) = (width(*one), last / R::UNITS, backlash / R::UNITS);
    match name {
        "jog" => assert!(width > 0.5 && width < 100.0, "{name}: {width}"),
        "move" => assert!((at - 10.0).abs() < 0.1, "{name}: at {at}"),
        "calibrate" => assert!((99.9..100.1 + backlash).contains(&width), "{name}: {width}"),
        // The motor is at the end of its range at first, and goes from there to the start of the move.
        "run" => assert!((at - PAN).abs() < 1.0 && width > PAN - 1.0, "{name}: {width}, at {at}"),
        "run --reverse" => assert!(at.abs() < 1.0 && width > PAN - 1.0, "{name}: {width}, at {at}"),
        "run, Ctrl-C" => assert!(at > -5.0 - backlash && at < PAN - 1.0, "{name}: {width}, at {at}"),
        "program" | "program --continuous" => {
            assert!(width > PAN - 1.0, "{name}: {width}, at {at}");
            assert_eq!(photos, 3, "{name}");
        }
        "info" | "expose" | "stop" => {
            assert!(width.abs() < f64::EPSILON, "{name}: {width}");
            assert_eq!(photos, u64::from(name == "expose"), "{name}");
        }
        // On hoot the motor goes to the start of the move.
        "upload" => {
            assert!(width.abs() < f64::EPSILON || R::Setup::PROTOCOL == "hoot" && at.abs() < 0.1, "{name}: {width}");
        }
        other => panic!("{other} is not checked"),
    }
}

/// Does all commands with a device, one after the other. The rig lives on from one command to the next, as a real one does.
async fn row<R: Bench>(device: &'static str) -> Vec<Result<(), String>> {
    let setup = R::Setup::default().with_device(device).expect("the name is of the list");
    let shared = Arc::new(Mutex::new(Served { rig: R::new(setup), ways: Vec::new() }));
    let start = Instant::now();
    let now = || Millis(start.elapsed().as_millis().try_into().unwrap_or(u64::MAX));
    let mut results = Vec::new();
    for (name, command) in &commands::<R>() {
        lock(&shared).watch(now());
        let photos = lock(&shared).rig.photos();
        let result = done(&shared, start, command, name.contains("Ctrl-C")).await;
        // Anything that still moves after the end of the program would be seen here.
        sleep(Duration::from_secs(3)).await;
        let mut served = lock(&shared);
        served.work(now());
        assert!(served.rests(), "{device} {name} leaves a motor moving: {result:?}");
        let last = served.rig.place(0, now());
        let photos = served.rig.photos() - photos;
        println!("{device} {name}: {result:?}, {:?}, at {last}, {photos} photos", served.ways);
        match &result {
            Ok(()) => check::<R>(name, &served.ways, last, photos, served.rig.backlash()),
            Err(line) => {
                assert!(!line.contains('\n'), "{device} {name}: {line}");
                assert!(photos == 0, "{device} {name} is not done, and took {photos} photos: {line}");
            }
        }
        results.push(result);
    }
    results
}

/// Runs a device on a clock of its own.
fn in_its_time<R: Bench>(device: &'static str) -> Vec<Result<(), String>> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().start_paused(true).build();
    runtime.expect("a runtime can be built").block_on(row::<R>(device))
}

fn chapter<R: Bench>(page: &mut String) {
    let all = commands::<R>();
    let _ = write!(page, "\n## {}\n\n| device |", R::Setup::PROTOCOL);
    for (name, _) in &all {
        let _ = write!(page, " {name} |");
    }
    let _ = write!(page, "\n|{}\n", "---|".repeat(all.len() + 1));
    let rows = std::thread::scope(|scope| {
        let threads = R::Setup::DEVICES.iter().map(|device| scope.spawn(|| in_its_time::<R>(device.name)));
        let threads: Vec<_> = threads.collect();
        threads.into_iter().map(|thread| thread.join().expect("see the device above")).collect::<Vec<_>>()
    });
    let mut lines: Vec<String> = Vec::new();
    let mut number = |line: String| {
        let known = lines.iter().position(|known| *known == line);
        known.map_or_else(
            || {
                lines.push(line);
                lines.len()
            },
            |known| known + 1,
        )
    };
    let mut buts = R::BUT.to_vec();
    for (device, results) in R::Setup::DEVICES.iter().zip(rows) {
        let _ = write!(page, "| `{}` |", device.name);
        for ((name, _), result) in all.iter().zip(results) {
            let but = buts.iter().position(|(of, command, _)| of == &device.name && command == name);
            let but = but.map(|at| buts.swap_remove(at).2);
            let cell = match (result, but) {
                (Ok(()), None) => "done".to_owned(),
                (Ok(()), Some(but)) => format!("done, but {}", number(format!("Done, but {but}."))),
                (Err(line), None) => number(format!("`{line}`")).to_string(),
                (Err(line), Some(_)) => panic!("{} {name} is not done, and has a \"but\": {line}", device.name),
            };
            let _ = write!(page, " {cell} |");
        }
        page.push('\n');
    }
    assert!(buts.is_empty(), "no device and command: {buts:?}");
    page.push('\n');
    for (number, line) in lines.iter().enumerate() {
        let _ = writeln!(page, "{}. {line}", number + 1);
    }
    let _ = write!(page, "\n| device | what it stands for |\n|---|---|\n");
    for device in R::Setup::DEVICES {
        let _ = writeln!(page, "| `{}` | {} |", device.name, device.about);
    }
}

#[test]
fn each_command_with_each_device_is_done_or_refused_as_the_page_says() {
    write_file();
    let mut page = HEAD.to_owned();
    chapter::<KosDevice>(&mut page);
    chapter::<DmcDevice>(&mut page);
    chapter::<HootNode>(&mut page);
    page.push_str(OF_HOOT);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/devices.md");
    if env::var_os("UPDATE").is_some() {
        fs::write(&file, &page).expect("docs can be written");
    }
    let written = fs::read_to_string(&file).expect("docs/devices.md exists");
    assert!(written == page, "docs/devices.md is not what the devices do: set UPDATE=1 and run this test again");
}
