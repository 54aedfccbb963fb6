//! Tests of the commands of `drive hoot`, on a line in memory and a paused clock.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use hoot_proto::Address;
use hoot_proto::device::{self, ProgramState, Quirks};
use hoot_proto::message::{Motor, Steps};
use hoot_proto::query::Profile;
use moco::drive::command::Shots;
use moco::drive::{Command, Stopped, Trouble, hoot};
use moco::session::Session;
use motion_core::time::Millis;
use motion_core::trajectory::Range;
use motion_rigs::device::Named;
use motion_rigs::faults::{Carrier, Faults, Mishap, Mishaps};
use motion_rigs::hoot_master::HootMaster;
use motion_rigs::hoot_node::{HootNode, Setup};
use motion_rigs::line::Line;
use motion_rigs::{LineId, Outgoing, Party, Rig};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep, sleep_until};

const USB: LineId = LineId(0);
const NODE: Address = Address::DEFAULT;

/// Simulated node, and a session with it.
struct Bench {
    rig: Arc<Mutex<HootNode>>,
    /// Moment of the program and position of motor 1, at each millisecond of the program.
    trace: Arc<Mutex<Vec<(f64, f64)>>>,
    /// Greatest speed of motor 1, in microsteps at quarter steps per second.
    fastest: Arc<Mutex<f64>>,
    session: Session<HootMaster>,
    interrupt: UnboundedSender<()>,
    server: JoinHandle<()>,
    said: Vec<u8>,
}

fn bench(setup: Setup) -> Bench {
    troubled(setup, Faults::NONE, 0)
}

/// Bench on a line with faults.
fn troubled(setup: Setup, faults: Faults, seed: u64) -> Bench {
    let rig = Arc::new(Mutex::new(HootNode::new(setup)));
    let (trace, fastest) = (Arc::default(), Arc::default());
    let (near, far) = tokio::io::duplex(256);
    let carried = Carried {
        rig: Arc::clone(&rig),
        trace: Arc::clone(&trace),
        fastest: Arc::clone(&fastest),
        up: Line::new(faults, seed),
        down: Line::new(faults, seed + 1),
        mishaps: Mishaps::new(faults, seed, Millis(0)),
    };
    let server = tokio::spawn(carried.serve(far));
    let (interrupt, interrupts) = unbounded_channel();
    let session = Session::over(hoot::master(NODE).unwrap(), near, interrupts);
    Bench { rig, trace, fastest, session, interrupt, server, said: Vec::new() }
}

/// Rig with a faulty line in each direction.
struct Carried {
    rig: Arc<Mutex<HootNode>>,
    trace: Arc<Mutex<Vec<(f64, f64)>>>,
    fastest: Arc<Mutex<f64>>,
    up: Line,
    down: Line,
    mishaps: Mishaps,
}

impl Carried {
    fn lock(&self) -> MutexGuard<'_, HootNode> {
        self.rig.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does everything that is due. Returns the bytes to write.
    fn work(&mut self, now: Millis) -> Vec<Vec<u8>> {
        self.lock().advance(now);
        let speed = self.lock().motors()[0].at(now).velocity.abs();
        let mut fastest = self.fastest.lock().unwrap();
        *fastest = fastest.max(speed);
        drop(fastest);
        let moment = self.lock().moment();
        if let Some(moment) = moment {
            let place = self.lock().motors()[0].at(now).position;
            self.trace.lock().unwrap().push((moment, place));
        }
        while let Some(mishap) = self.mishaps.next(now) {
            match mishap {
                Mishap::Silence(millis) => {
                    self.up.hold(now.after(millis));
                    self.down.hold(now.after(millis));
                }
                Mishap::Reset => {
                    self.lock().reset(now);
                    self.lock().open(now, USB);
                }
                Mishap::Stall => self.lock().stall(now),
            }
        }
        while let Some(piece) = self.up.pop(now) {
            self.lock().receive(now, USB, &piece);
        }
        loop {
            let Some(out) = self.lock().poll() else { break };
            if let Outgoing::Bytes(USB, bytes) = out {
                self.down.push(now, &bytes);
            }
        }
        std::iter::from_fn(|| self.down.pop(now)).collect()
    }

    /// Carries bytes and time to a rig. After the line is closed, carries only time.
    async fn serve(mut self, mut line: DuplexStream) {
        let start = Instant::now();
        let now = || Millis(start.elapsed().as_millis().try_into().unwrap());
        self.lock().open(now(), USB);
        let mut buffer = [0; 64];
        let mut is_open = true;
        loop {
            for bytes in self.work(now()) {
                is_open &= line.write_all(&bytes).await.is_ok();
            }
            let wakes = [self.lock().wake(), self.mishaps.wake(), self.up.wake(), self.down.wake()];
            let wake = wakes.into_iter().flatten().min();
            let wake = wake.map_or(Duration::from_hours(1), |wake| Duration::from_millis(wake.0));
            tokio::select! {
                read = line.read(&mut buffer), if is_open => match read {
                    Ok(len) if len > 0 => self.up.push(now(), &buffer[..len]),
                    _ => {
                        is_open = false;
                        self.lock().close(now(), USB);
                    }
                },
                () = sleep_until(start + wake) => {}
            }
        }
    }
}

impl Bench {
    async fn drive(&mut self, command: Command) -> Result<(), Trouble> {
        hoot::drive(&mut self.session, &command, NODE, 0.1, &mut self.said).await
    }

    /// Does a command that must succeed and leave all motors at rest.
    async fn done(&mut self, command: Command) -> String {
        self.said.clear();
        let done = self.drive(command).await;
        let said = String::from_utf8(self.said.clone()).unwrap();
        assert!(done.is_ok(), "{done:?}: {said}");
        assert!(!self.session.host().machine().may_move() && self.is_at_rest(), "{said}");
        assert!(!self.rig(|rig| rig.machine().controller().manual_move), "the dead-man switch is off again");
        said
    }

    /// Does a command that must fail. Then stops if a motor may move, as the program does.
    async fn fails(&mut self, command: Command) -> String {
        let line = self.drive(command).await.unwrap_err().to_string();
        assert!(!line.contains('\n'), "{line}");
        if self.session.host().machine().may_move() {
            assert_eq!(self.session.stop().await, Stopped::Confirmed, "{line}");
        }
        assert!(self.is_at_rest(), "{line}");
        line
    }

    fn rig<T>(&self, look: impl FnOnce(&mut HootNode) -> T) -> T {
        look(&mut self.rig.lock().unwrap())
    }

    fn is_at_rest(&self) -> bool {
        self.rig(|rig| rig.motors().iter().all(motion_rigs::motor::Motor::rests))
    }

    fn position(&self, motor: Motor) -> i32 {
        self.rig(|rig| rig.machine().motor(motor).position().0)
    }
}

fn sample(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../moves").join(name)
}

/// The sample with a fifth of its speed, because the greatest speed of a motor of older firmware is 1000 steps/s.
fn slow(test: &str) -> PathBuf {
    let pan = std::fs::read_to_string(sample("pan.json")).unwrap();
    let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{test}.json"));
    let hoot = "\"hoot\": { \"motor\": 1, \"steps_per_unit\": ";
    assert!(pan.contains(hoot));
    std::fs::write(&file, pan.replace(&format!("{hoot}100"), &format!("{hoot}20"))).unwrap();
    file
}

fn shots(shots: u32, continuous: bool) -> Shots {
    let interval = if continuous { 1.0 } else { 2.5 };
    Shots { shots, interval, exposure: 0.1, continuous }
}

#[tokio::test(start_paused = true)]
async fn info_prints_the_node_and_its_motors() {
    for profile in [Profile::SHEET, Profile::V033, Profile::V035, Profile::V070] {
        let mut bench = bench(Setup::default().with_options(device::Options::default().with_profile(profile)));
        let said = bench.done(Command::Info).await;
        assert!(said.contains("node 3: DEFAULT, firmware") && said.lines().count() >= 5, "{said}");
        assert!(said.contains("motor 3: at 0, rests, switched off; 4 microsteps, no end limit"), "{said}");
    }
}

/// Firmware of each version, with all its quirks, executes the commands.
#[tokio::test(start_paused = true)]
async fn each_firmware_version_executes_the_commands() {
    for device in Setup::DEVICES {
        let mut bench = bench(Setup::default().with_device(device.name).unwrap());
        bench.done(Command::Jog { motor: 1, speed: 500.0, seconds: 1.0 }).await;
        bench.done(Command::Calibrate { motor: 1, begin: 100.0, end: 1950.0 }).await;
        let run = Command::Run { file: slow("each"), reverse: false };
        if device.name == "2014-10-15" {
            let line = bench.fails(run).await;
            assert!(line.contains("node 3 has no mode VIDEO, it stays in CONTINUOUS"), "{line}");
        } else {
            bench.done(run).await;
        }
        for (photos, continuous) in [(3, false), (6, true)] {
            bench.done(Command::Program { file: slow("each"), shots: shots(photos, continuous) }).await;
        }
        assert_eq!((bench.position(Motor::One), bench.rig(|rig| rig.camera().taken())), (1800, 9), "{}", device.name);
        bench.done(Command::Stop).await;
    }
}

#[tokio::test(start_paused = true)]
async fn motors_keep_the_speed_that_was_given_with_each_device() {
    for device in Setup::DEVICES {
        let mut bench = bench(Setup::default().with_device(device.name).unwrap());
        bench.done(Command::Move { motor: 1, position: 600.0, speed: Some(200.0) }).await;
        bench.done(Command::Move { motor: 1, position: 100.0, speed: Some(200.0) }).await;
        let fastest = *bench.fastest.lock().unwrap();
        assert!((150.0..=205.0).contains(&fastest), "{}: {fastest}", device.name);
        // A quarter of the greatest speed.
        bench.done(Command::Calibrate { motor: 1, begin: 0.0, end: 900.0 }).await;
        let fastest = *bench.fastest.lock().unwrap();
        assert!(fastest < 1255.0, "{}: {fastest}", device.name);
    }
}

#[tokio::test(start_paused = true)]
async fn a_greatest_speed_counts_if_somebody_has_set_it() {
    for device in ["sheet", "v0.33", "v0.45", "v0.70"] {
        let mut bench = bench(Setup::default().with_device(device).unwrap());
        bench.done(Command::Jog { motor: 1, speed: 2000.0, seconds: 0.5 }).await;
        assert!(*bench.fastest.lock().unwrap() > 1500.0, "{device}");
        // Somebody sets 700 steps/s.
        let now = Millis(60_000);
        bench.rig(|rig| rig.receive(now, USB, &[0, 0, 0, 0, 0, 0xFF, 3, 1, 7, 2, 2, 188]));
        sleep(Duration::from_mins(1)).await;
        let line = bench.fails(Command::Jog { motor: 1, speed: 2000.0, seconds: 0.5 }).await;
        assert!(line.contains("at most 700 steps/s"), "{device}: {line}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_time_lapse_moves_slowly_with_each_device() {
    for device in Setup::DEVICES {
        let mut bench = bench(Setup::default().with_device(device.name).unwrap());
        let file = slow("lapse");
        bench.done(Command::Program { file, shots: shots(11, true) }).await;
        // 1800 steps in eight of ten seconds, with half of the time for each ramp: the peak is 1.5 times the mean.
        let trace = bench.trace.lock().unwrap();
        let places: Vec<f64> = trace.iter().map(|(_, place)| *place).collect();
        // The backlash is no step: the position goes back by it at once.
        let steps = places.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step < 300.0);
        // A start may change the microsteps, in which places are counted.
        let microsteps = places.iter().copied().fold(0.0, f64::max) / 1800.0;
        let fastest = 1000.0 * steps.fold(0.0, f64::max) / microsteps;
        assert!(fastest < 1500.0 && bench.position(Motor::One) == 1800, "{}: {fastest}", device.name);
        assert_eq!(bench.rig(|rig| rig.camera().taken()), 11, "{}", device.name);
    }
}

#[tokio::test(start_paused = true)]
async fn a_limit_is_announced_only_where_it_holds() {
    for device in Setup::DEVICES {
        let profile = Setup::default().with_device(device.name).unwrap().options.profile();
        let mut bench = bench(Setup::default().with_device(device.name).unwrap());
        let said = bench.done(Command::Calibrate { motor: 1, begin: 0.0, end: 400.0 }).await;
        let info = bench.done(Command::Info).await;
        let (limit, nothing) = ("the end limit is 400 steps from home", "nothing stops the motor there");
        let holds = profile.holds_limits().unwrap();
        assert_eq!((said.contains(limit), said.contains(nothing)), (holds, !holds), "{}: {said}", device.name);
        assert_eq!(info.contains("end limit 400"), holds, "{}: {info}", device.name);
        // The motor goes on beyond a limit that does not hold.
        bench.drive(Command::Move { motor: 1, position: 1000.0, speed: None }).await.unwrap_or_default();
        assert_eq!(bench.position(Motor::One) >= 1000, !holds, "{}: {}", device.name, bench.position(Motor::One));
    }
}

#[tokio::test(start_paused = true)]
async fn after_the_way_to_the_start_the_speed_is_set_again() {
    for device in ["mild", "2014-10-29", "v0.33", "v0.70"] {
        let mut bench = bench(Setup::default().with_device(device).unwrap());
        bench.done(Command::Move { motor: 1, position: 300.0, speed: None }).await;
        bench.done(Command::Upload { file: slow("speed") }).await;
        let speed = bench.rig(|rig| rig.machine().motor(Motor::One).settings().speed.0);
        assert!(speed >= 1000.0, "{device}: {speed}");
    }
}

/// A move command switches joystick mode off.
#[tokio::test(start_paused = true)]
async fn joystick_mode_is_switched_off() {
    let mut bench = bench(Setup::default());
    sleep(Duration::from_secs(1)).await;
    bench.rig(|rig| rig.receive(Millis(1000), USB, &[0, 0, 0, 0, 0, 0xFF, 3, 0, 23, 1, 1]));
    sleep(Duration::from_secs(1)).await;
    bench.drive(Command::Info).await.unwrap();
    assert!(bench.said.ends_with(b"it is in joystick mode, so nothing more can be read\n"));
    bench.done(Command::Move { motor: 1, position: 10.0, speed: None }).await;
}

#[tokio::test(start_paused = true)]
async fn jog_move_and_calibrate_end_at_their_positions() {
    let mut bench = bench(Setup::default());
    let said = bench.done(Command::Jog { motor: 2, speed: -1000.0, seconds: 2.0 }).await;
    let at = bench.position(Motor::Two);
    assert!((-2050..-1700).contains(&at) && said.ends_with(&format!("motor 2 went from 0 to {at}\n")), "{said}");
    let said = bench.done(Command::Move { motor: 2, position: 6000.4, speed: Some(2000.0) }).await;
    assert_eq!(bench.position(Motor::Two), 6000);
    // The move takes about four seconds, with at most one line per second.
    assert!((2..=6).contains(&said.lines().count()) && said.ends_with("motor 2 is at 6000\n"), "{said}");
    bench.done(Command::Calibrate { motor: 2, begin: 1000.0, end: 4000.0 }).await;
    assert_eq!(bench.position(Motor::Two), 3000);
    assert_eq!(bench.rig(|rig| rig.machine().motor(Motor::Two).settings().end_limit), Steps(3000));
    assert_eq!(bench.done(Command::Stop).await, "all motors rest: the node confirmed it\n");
}

/// An upload stores the start of the file and moves the motor there. A run follows the file.
#[tokio::test(start_paused = true)]
async fn an_uploaded_file_is_followed() {
    let mut bench = bench(Setup::default());
    bench.done(Command::Move { motor: 1, position: 700.0, speed: None }).await;
    bench.done(Command::Upload { file: sample("pan.json") }).await;
    assert_eq!(bench.position(Motor::One), 0);
    assert_eq!(bench.rig(|rig| rig.machine().motor(Motor::One).settings().plan.stop), Steps(9000));
    for (reverse, at) in [(false, 9000), (true, 0), (true, 0)] {
        bench.trace.lock().unwrap().clear();
        let said = bench.done(Command::Run { file: sample("pan.json"), reverse }).await;
        assert!(said.contains("of 4.5 s: motor 1 at"), "{said}");
        assert_eq!(bench.position(Motor::One), at);
        // The path of the motor is that of the file, within a step and the deviation of the plan.
        let trace = bench.trace.lock().unwrap();
        assert!(trace.len() > 4000, "{}", trace.len());
        for (moment, place) in trace.iter() {
            let u = ((moment / 1000.0 - 0.5) / 4.0).clamp(0.0, 1.0);
            let planned = 9000.0 * (3.0 - 2.0 * u) * u * u;
            let planned = if reverse { 9000.0 - planned } else { planned };
            assert!((place - planned).abs() < 1.05, "{place} for {planned} at {moment}");
        }
    }
}

#[tokio::test(start_paused = true)]
async fn a_program_takes_all_its_photos() {
    for continuous in [false, true] {
        let mut bench = bench(Setup::default());
        let said = bench.done(Command::Program { file: sample("pan.json"), shots: shots(6, continuous) }).await;
        assert!(said.ends_with("6 photos are taken, and all motors rest\n"), "{said}");
        assert_eq!((bench.rig(|rig| rig.camera().taken()), bench.position(Motor::One)), (6, 9000));
    }
}

#[tokio::test(start_paused = true)]
async fn expose_takes_one_photo() {
    let mut bench = bench(Setup::default());
    bench.done(Command::Expose { seconds: 1.5 }).await;
    let photos = bench.rig(|rig| rig.camera().photos().map(|it| it.closed.since(it.opened)).collect::<Vec<_>>());
    assert_eq!(photos, [1500]);
}

/// The first firmware answers OK to a photo on command, and keeps the shutter closed.
#[tokio::test(start_paused = true)]
async fn one_photo_is_taken_with_each_device_or_refused() {
    for device in Setup::DEVICES {
        let mut bench = bench(Setup::default().with_device(device.name).unwrap());
        let is_too_old = device.name == "2014-10-15";
        match bench.drive(Command::Expose { seconds: 0.5 }).await {
            Err(Trouble::Refused(line)) => assert!(is_too_old && line.contains("use program"), "{line}"),
            result => assert!(result.is_ok() && !is_too_old, "{}: {result:?}", device.name),
        }
        assert_eq!(bench.rig(|rig| rig.camera().taken()), u64::from(!is_too_old), "{}", device.name);
    }
}

/// Each error is one line that says what is wrong, before anything moves.
#[tokio::test(start_paused = true)]
async fn a_command_that_cannot_be_done_is_refused() {
    let mut bench = bench(Setup::default());
    let go = |motor, position, speed| Command::Move { motor, position, speed };
    let run = |name| Command::Run { file: sample(name), reverse: false };
    let mut program = shots(6, false);
    program.exposure = 3.0;
    for (command, part) in [
        (go(4, 0.0, None), "hoot has motors 1 to 3"),
        (go(1, f64::NAN, None), "position NaN"),
        (go(1, 1e12, None), "hoot has steps"),
        (go(1, 100.0, Some(6000.0)), "at most 5000 steps/s"),
        (go(1, 100.0, Some(-1.0)), "more than 0"),
        (Command::Jog { motor: 1, speed: 0.0, seconds: 1.0 }, "more than 0"),
        (Command::Jog { motor: 1, speed: 100.0, seconds: -1.0 }, "0 to 3600"),
        (Command::Calibrate { motor: 1, begin: 5.0, end: 5.0 }, "not a range"),
        (run("slide.json"), "4 key frames"),
        (run("none.json"), "none.json: "),
        (Command::Program { file: sample("pan.json"), shots: program }, "does not fit"),
        (Command::Program { file: sample("pan.json"), shots: shots(1, false) }, "give 2 to 65535"),
        (Command::Expose { seconds: 0.0 }, "give 0.001 to"),
    ] {
        let line = bench.fails(command).await;
        assert!(line.contains(part), "{line}");
    }
    assert_eq!(bench.rig(|rig| rig.camera().taken()), 0);
}

#[tokio::test(start_paused = true)]
async fn a_move_that_does_not_reach_its_target_fails() {
    let mut bench = bench(Setup::with_motors(1).with_travel(Range::new(-500.0, 500.0)));
    let line = bench.fails(Command::Move { motor: 1, position: 2000.0, speed: None }).await;
    assert!(line.contains("motor 1 rests at 500 instead of 2000"), "{line}");
    let line = bench.fails(Command::Move { motor: 3, position: 2000.0, speed: None }).await;
    assert!(line.contains("motor 3 rests at 0 instead of 2000: is it unplugged"), "{line}");
    let line = bench.fails(Command::Jog { motor: 3, speed: 2000.0, seconds: 0.5 }).await;
    assert!(line.contains("did not move"), "{line}");
    let line = bench.fails(Command::Run { file: sample("pan.json"), reverse: false }).await;
    assert!(line.contains("node 3 paused"), "{line}");
}

/// The node inverts the direction of the motor, so a move by a number of steps goes away from its target.
#[tokio::test(start_paused = true)]
async fn a_move_that_goes_the_wrong_way_is_stopped() {
    for position in [50_000.0, -50_000.0] {
        let mut bench = bench(Setup::default());
        sleep(Duration::from_secs(1)).await;
        bench.rig(|rig| rig.receive(Millis(1000), USB, &[0, 0, 0, 0, 0, 0xFF, 3, 1, 8, 1, 1]));
        sleep(Duration::from_secs(1)).await;
        let line = bench.fails(Command::Move { motor: 1, position, speed: None }).await;
        assert!(line.contains("does the node invert its direction"), "{line}");
        let at = f64::from(bench.position(Motor::One));
        assert!((1.0..2000.0).contains(&at.abs()) && at * position < 0.0, "{position}: {at}");
    }
}

/// A node that receives a move twice adds the steps again.
#[tokio::test(start_paused = true)]
async fn a_move_that_arrives_twice_is_stopped() {
    let mut bench = bench(Setup::default());
    let (rig, start) = (Arc::clone(&bench.rig), Instant::now());
    tokio::spawn(async move {
        while rig.lock().unwrap().motors().iter().all(motion_rigs::motor::Motor::rests) {
            sleep(Duration::from_millis(10)).await;
        }
        sleep(Duration::from_secs(2)).await;
        let now = Millis(start.elapsed().as_millis().try_into().unwrap());
        let again = [0, 0, 0, 0, 0, 0xFF, 3, 1, 15, 5, 1, 0, 0, 0xEA, 0x60];
        rig.lock().unwrap().receive(now, USB, &again);
    });
    let line = bench.fails(Command::Move { motor: 1, position: 60_000.0, speed: Some(5000.0) }).await;
    assert!(line.contains("did it receive the move twice"), "{line}");
    assert!((60_001..65_000).contains(&bench.position(Motor::One)), "{}", bench.position(Motor::One));
}

/// After Ctrl-C in a move everything stops and the node confirms it, also with all quirks of firmware.
#[tokio::test(start_paused = true)]
async fn an_interrupted_command_stops_all_motors() {
    for quirks in [Quirks::NONE, Quirks::FIRMWARE] {
        for command in [
            Command::Move { motor: 1, position: 50_000.0, speed: None },
            Command::Jog { motor: 1, speed: 1000.0, seconds: 60.0 },
            Command::Run { file: slow("interrupted"), reverse: false },
        ] {
            let mut bench = bench(Setup::default().with_options(device::Options::default().with_quirks(quirks)));
            let interrupt = bench.interrupt.clone();
            let rig = Arc::clone(&bench.rig);
            tokio::spawn(async move {
                while rig.lock().unwrap().motors().iter().all(motion_rigs::motor::Motor::rests) {
                    sleep(Duration::from_millis(10)).await;
                }
                sleep(Duration::from_millis(1500)).await;
                // A second Ctrl-C soon after the first does not cancel the stop.
                interrupt.send(()).unwrap();
                interrupt.send(()).unwrap();
            });
            let trouble = bench.drive(command).await.unwrap_err();
            assert!(matches!(trouble, Trouble::Interrupted), "{trouble}");
            assert!(bench.session.host().machine().may_move() && !bench.is_at_rest());
            assert_eq!(bench.session.stop().await, Stopped::Confirmed);
            assert!(bench.is_at_rest() && !bench.session.host().machine().may_move());
        }
    }
}

/// Firmware sends each enabled motor to the stop of its plan, also if it has no travel.
#[tokio::test(start_paused = true)]
async fn a_planned_move_moves_no_other_motor_with_each_device() {
    for device in Setup::DEVICES {
        let mut bench = bench(Setup::default().with_device(device.name).unwrap());
        bench.done(Command::Move { motor: 2, position: 320.0, speed: Some(300.0) }).await;
        let run = Command::Run { file: slow("others"), reverse: false };
        let program = |continuous| Command::Program { file: slow("others"), shots: shots(3, continuous) };
        for command in [run, program(false), program(true)] {
            let is_refused = device.name == "2014-10-15" && matches!(command, Command::Run { .. });
            let result = bench.drive(command).await;
            assert_eq!(result.is_err(), is_refused, "{}: {result:?}", device.name);
            assert_eq!(bench.position(Motor::Two), 320, "{}", device.name);
        }
    }
}

/// A `run` opens no shutter, although a start and an end of a video do.
#[tokio::test(start_paused = true)]
async fn a_run_takes_no_photos_and_a_program_takes_those_that_were_asked_for() {
    for device in Setup::DEVICES {
        let mut bench = bench(Setup::default().with_device(device.name).unwrap());
        let taken = |bench: &Bench| bench.rig(|rig| rig.camera().taken());
        if device.name != "2014-10-15" {
            let exposure = bench.rig(|rig| rig.machine().camera().settings().exposure_time);
            bench.done(Command::Run { file: slow("photos"), reverse: false }).await;
            assert_eq!(taken(&bench), 0, "{}", device.name);
            let after = bench.rig(|rig| rig.machine().camera().settings().exposure_time);
            assert_eq!(after, exposure, "{}: the exposure is as before", device.name);
        }
        let mut before = 0;
        for (photos, continuous) in [(2, false), (2, true), (5, false), (5, true)] {
            bench.done(Command::Program { file: slow("photos"), shots: shots(photos, continuous) }).await;
            assert_eq!(taken(&bench) - before, u64::from(photos), "{}, continuous: {continuous}", device.name);
            before = taken(&bench);
        }
    }
}

/// The start of a video cuts places to whole steps, which are four microsteps.
#[tokio::test(start_paused = true)]
async fn a_run_ends_within_a_step_of_its_place_where_firmware_cuts_places() {
    for (device, at) in [("v0.33", 1799), ("v0.70", 1796)] {
        let mut bench = bench(Setup::default().with_device(device).unwrap());
        let file = slow("cut");
        let odd =
            std::fs::read_to_string(&file).unwrap().replace("\"steps_per_unit\": 20 ", "\"steps_per_unit\": 19.99 ");
        std::fs::write(&file, odd).unwrap();
        bench.done(Command::Run { file, reverse: false }).await;
        assert_eq!(bench.position(Motor::One), at, "{device}");
    }
}

/// Between two photos the motors need time, and a time lapse ends with its motors.
#[tokio::test(start_paused = true)]
async fn photos_that_would_come_late_or_not_at_all_are_refused() {
    for device in Setup::DEVICES {
        let setup = Setup::default().with_device(device.name).unwrap();
        let profile = setup.options.profile();
        let mut bench = bench(setup);
        let program = |shots| Command::Program { file: slow("late"), shots };
        let fast = Shots { interval: 0.35, ..shots(5, false) };
        let said = format!("{:?}", bench.drive(program(fast)).await);
        assert!(said.contains("give a longer interval") || profile.start_sets_microsteps() == Some(false), "{said}");
        // The axis of this file rests from the middle on.
        let file = slow("half");
        let half = std::fs::read_to_string(&file).unwrap().replace("\"duration\": 5", "\"duration\": 10");
        std::fs::write(&file, half).unwrap();
        let ends = profile.ends_with_motors() == Some(true);
        match bench.drive(Command::Program { file, shots: shots(11, true) }).await {
            Err(Trouble::Refused(line)) => assert!(ends && line.contains("ends a time lapse then"), "{line}"),
            result => assert!(result.is_ok() && !ends, "{}: {result:?}", device.name),
        }
        let photos = if ends { 0 } else { 11 };
        let fast = u64::from(said.contains("Ok")) * 5;
        assert_eq!(bench.rig(|rig| rig.camera().taken()), photos + fast, "{}", device.name);
    }
}

/// A start chooses finer microsteps, and an interrupted program leaves them. They are set back before steps are counted.
#[tokio::test(start_paused = true)]
async fn steps_are_those_of_a_new_node_also_after_an_interrupted_run() {
    for (device, microsteps) in [("2014-10-29", 4), ("2014-12-03", 16), ("v0.33", 16), ("v0.45", 4), ("v0.70", 16)] {
        let mut bench = bench(Setup::default().with_device(device).unwrap());
        let run = Command::Run { file: slow("steps"), reverse: false };
        let cut = tokio::time::timeout(Duration::from_millis(7800), bench.drive(run)).await;
        assert!(cut.is_err() && !bench.is_at_rest(), "{device}");
        assert_eq!(bench.session.stop().await, Stopped::Confirmed, "{device}");
        let found = |bench: &Bench| bench.rig(|rig| rig.machine().motor(Motor::One).settings().microstep.0);
        assert_eq!(found(&bench), microsteps, "{device}");
        let said = bench.done(Command::Move { motor: 1, position: 1000.0, speed: None }).await;
        assert_eq!(said.contains("set to 4, as at a new node"), microsteps != 4, "{device}: {said}");
        assert_eq!((found(&bench), bench.position(Motor::One)), (4, 1000), "{device}");
    }
}

/// Without a given speed, a move has a quarter of the greatest speed. The way to the start of a move has the home
/// speed, which is a tenth of the greatest speed here.
#[tokio::test(start_paused = true)]
async fn without_a_given_speed_motors_move_slowly() {
    for (command, speed) in [
        (Command::Move { motor: 1, position: 50_000.0, speed: None }, 1250.0),
        (Command::Run { file: sample("pan.json"), reverse: true }, 500.0),
    ] {
        let mut bench = bench(Setup::default());
        let died = tokio::time::timeout(Duration::from_secs(8), bench.drive(command)).await;
        assert!(died.is_err());
        let rig = bench.rig.lock().unwrap();
        let velocity = rig.motors()[0].at(rig.wake().unwrap()).velocity;
        assert!((velocity - speed).abs() < 1.0, "{velocity}");
    }
}

/// If the program is killed in a move, the node stops by itself a second later.
#[tokio::test(start_paused = true)]
async fn a_node_stops_by_itself_after_the_program_is_killed() {
    let mut bench = bench(Setup::default());
    let run = Command::Run { file: sample("pan.json"), reverse: false };
    let died = tokio::time::timeout(Duration::from_secs(6), bench.drive(run)).await;
    assert!(died.is_err() && !bench.is_at_rest());
    let Bench { session, rig, .. } = bench;
    drop(session);
    sleep(Duration::from_millis(1200)).await;
    let rig = rig.lock().unwrap();
    assert!(rig.motors().iter().all(motion_rigs::motor::Motor::rests));
    assert_eq!(rig.machine().program().state(), ProgramState::Paused);
}

/// If the node fails in a move, the program prints one line, and the stop is not confirmed.
#[tokio::test(start_paused = true)]
async fn a_lost_line_is_reported() {
    let mut bench = bench(Setup::default());
    let server = bench.server.abort_handle();
    tokio::spawn(async move {
        sleep(Duration::from_secs(3)).await;
        server.abort();
    });
    let trouble = bench.drive(Command::Move { motor: 1, position: 90_000.0, speed: None }).await.unwrap_err();
    assert!(matches!(&trouble, Trouble::Lost(line) if line.contains("check its cable")), "{trouble:?}");
    assert!(bench.session.host().machine().may_move());
    assert_eq!(bench.session.stop().await, Stopped::NotConfirmed);
}

/// All faults together. A command that succeeds is done, and all motors rest. A command that fails says so in one line,
/// and all motors rest as well: because of the confirmed stop, or because of the dead-man switch, a second after the
/// program has given up.
#[tokio::test(start_paused = true)]
async fn with_all_faults_all_motors_rest_at_the_end() {
    let (mut done, mut confirmed) = (0, 0);
    for seed in 0..20 {
        for command in [
            Command::Move { motor: 1, position: 5000.0, speed: None },
            Command::Run { file: sample("pan.json"), reverse: false },
            Command::Program { file: sample("pan.json"), shots: shots(4, seed % 2 == 0) },
        ] {
            let mut bench = troubled(Setup::default(), Faults::all(Carrier::Serial), 10 * seed);
            match bench.drive(command.clone()).await {
                Ok(()) => {
                    done += 1;
                    let end = if matches!(command, Command::Move { .. }) { 5000 } else { 9000 };
                    assert_eq!(bench.position(Motor::One), end, "seed {seed}: {command:?}");
                    assert!(
                        !bench.session.host().machine().may_move() && bench.is_at_rest(),
                        "seed {seed}: {command:?}"
                    );
                    let photos = if matches!(command, Command::Program { .. }) { 4 } else { 0 };
                    assert!(bench.rig(|rig| rig.camera().taken()) >= photos, "seed {seed}: {command:?}");
                }
                Err(trouble) => {
                    let line = trouble.to_string();
                    assert!(!line.contains('\n') && line.len() > 20, "{line}");
                    if bench.session.host().machine().may_move() && bench.session.stop().await == Stopped::Confirmed {
                        confirmed += 1;
                        assert!(bench.is_at_rest(), "seed {seed}: {command:?}: {line}");
                    }
                    let Bench { session, rig, .. } = bench;
                    drop(session);
                    sleep(Duration::from_secs(3)).await;
                    assert!(
                        rig.lock().unwrap().motors().iter().all(motion_rigs::motor::Motor::rests),
                        "seed {seed}: {line}"
                    );
                }
            }
        }
    }
    assert!(done >= 15 && confirmed >= 5, "{done} of 60 done, {confirmed} stops confirmed");
}
