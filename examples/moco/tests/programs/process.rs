//! Processes of the program that tests start, wait for, interrupt and kill. No program lives longer than its test.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Read};
use std::mem;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use examples::program::Status;
use rustix::fs::{Mode, OFlags, open};
use rustix::process::{Pid, Signal, kill_process};

use crate::cable::Cable;
use crate::record::Row;

/// Longest time that a test waits for anything.
pub(crate) const BOUND: Duration = Duration::from_mins(1);

/// Number of scenarios that run at the same time. With more of them, acknowledgements that must come within half a
/// second would be late on a small computer.
const AT_A_TIME: usize = 12;

/// Running program, and its output so far.
pub(crate) struct Program {
    child: Child,
    out: Arc<Mutex<String>>,
    err: Arc<Mutex<String>>,
    readers: Vec<thread::JoinHandle<()>>,
}

/// Result of a program that has ended.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) status: ExitStatus,
    pub(crate) out: String,
    pub(crate) err: String,
}

fn moco() -> Command {
    Command::new(env!("CARGO_BIN_EXE_moco"))
}

impl Program {
    /// Starts a command of the program.
    pub(crate) fn start(command: &str, args: &[impl AsRef<OsStr>]) -> Self {
        Self::spawn(moco().arg(command).args(args), Stdio::piped())
    }

    /// Starts a command of the program, whose standard error is a terminal.
    pub(crate) fn start_at(terminal: &str, command: &str, args: &[impl AsRef<OsStr>]) -> Self {
        let terminal = open(terminal, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty()).unwrap();
        Self::spawn(moco().arg(command).args(args), terminal.into())
    }

    /// Starts an example.
    pub(crate) fn example(name: &str, args: &[impl AsRef<OsStr>]) -> Self {
        let path = Path::new(env!("CARGO_BIN_EXE_moco")).with_file_name("examples").join(name);
        // `cargo test` builds the examples, except if it is told which test to run.
        assert!(path.exists(), "build the examples first: cargo build -p moco --examples");
        Self::spawn(Command::new(path).args(args), Stdio::piped())
    }

    fn spawn(program: &mut Command, err: Stdio) -> Self {
        program.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(err);
        let mut child = program.spawn().unwrap_or_else(|error| panic!("{program:?}: {error}"));
        let (out, out_reader) = listen(child.stdout.take().expect("the stream is piped"));
        let mut readers = vec![out_reader];
        let err = child.stderr.take().map_or_else(Arc::default, |stream| {
            let (err, err_reader) = listen(stream);
            readers.push(err_reader);
            err
        });
        Self { child, out, err, readers }
    }

    /// Waits for a line on standard output that contains `part`. Returns the line.
    pub(crate) fn line(&mut self, part: &str) -> String {
        let found = within(&format!("{part:?}"), || {
            let out = self.out.lock().unwrap();
            let line = out.lines().find(|line| line.contains(part)).map(str::to_owned);
            line.or_else(|| self.child.try_wait().unwrap().map(|_| String::new()))
        });
        assert!(
            found.contains(part),
            "the program ended without {part:?}: {} {}",
            self.out.lock().unwrap(),
            self.said()
        );
        found
    }

    /// Output on standard error so far.
    pub(crate) fn said(&self) -> String {
        self.err.lock().unwrap().clone()
    }

    pub(crate) fn id(&self) -> Pid {
        Pid::from_child(&self.child)
    }

    /// Interrupts the program, as Ctrl-C does.
    pub(crate) fn interrupt(&self) {
        kill_process(self.id(), Signal::INT).unwrap();
    }

    /// Suspends the program, as Ctrl-Z does.
    pub(crate) fn suspend(&self) {
        kill_process(self.id(), Signal::TSTP).unwrap();
    }

    pub(crate) fn kill(mut self) {
        self.child.kill().unwrap();
    }

    /// Waits for the end of the program.
    pub(crate) fn end(mut self) -> Outcome {
        let status = within("the end", || self.child.try_wait().unwrap());
        self.readers.drain(..).for_each(|reader| reader.join().unwrap());
        let (out, err) = (self.out.lock().unwrap().clone(), self.said());
        Outcome { status, out, err }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // The program may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Outcome {
    /// Checks that the program succeeded. Returns its output.
    #[track_caller]
    pub(crate) fn done(self) -> String {
        assert!(self.status.success(), "{self:?}");
        self.out
    }

    /// Checks that the program failed with one line that contains `part`, and that nothing it has set in motion moves.
    /// Returns the line.
    #[track_caller]
    pub(crate) fn failed(self, part: &str) -> String {
        self.ended(Status::NotDone, part)
    }

    /// Checks that the program ended with a status, and with one line that contains `part`. Returns the line.
    #[track_caller]
    pub(crate) fn ended(self, status: Status, part: &str) -> String {
        assert_eq!(self.status.code(), Some(status as i32), "{self:?}");
        assert!(self.err.ends_with('\n') && self.err.lines().count() == 1, "{self:?}");
        assert!(self.err.starts_with("moco: ") && self.err.contains(part), "{part:?}: {self:?}");
        self.err
    }

    /// Checks that the command line was refused with one line of JSON that contains `part`.
    #[track_caller]
    pub(crate) fn usage_in_json(self, part: &str) {
        assert_eq!(self.status.code(), Some(Status::Usage as i32), "{self:?}");
        let failure: serde_json::Value = serde_json::from_str(&self.err).unwrap();
        assert_eq!(failure["status"], Status::Usage as i32);
        assert!(failure["error"].as_str().unwrap().contains(part), "{part:?}: {self:?}");
    }

    /// Checks that the program failed with one line, whether the rig confirmed a stop or not. Returns the line.
    #[track_caller]
    pub(crate) fn failed_somehow(self) -> String {
        let is_unsafe = self.status.code() == Some(Status::MayMove as i32);
        self.ended(if is_unsafe { Status::MayMove } else { Status::NotDone }, "")
    }
}

/// Simulated rig.
pub(crate) struct Rig {
    program: Program,
    pub(crate) protocol: &'static str,
    /// Address that the rig printed.
    pub(crate) address: String,
    record: PathBuf,
}

impl Rig {
    /// Starts a rig for a test of this name.
    pub(crate) fn start(test: &str, protocol: &'static str, args: &[&str]) -> Self {
        let record = folder(test).join("record.csv");
        let mut all = vec![protocol, "--port", "0", "--record", record.to_str().unwrap()];
        all.extend(args);
        let mut program = Program::start("simulate", &all);
        let line = program.line(" rig at ");
        let address = line.split(" rig at ").last().unwrap().to_owned();
        Self { program, protocol, address, record }
    }

    /// Begins a command.
    pub(crate) fn begin(&self, args: &[&str]) -> Program {
        self.begin_over(&self.address, args)
    }

    /// Begins a command at another address, such as that of a cable.
    pub(crate) fn begin_over(&self, address: &str, args: &[&str]) -> Program {
        let mut all = vec![self.protocol, address];
        all.extend(args);
        Program::start("drive", &all)
    }

    /// Does a command.
    pub(crate) fn drive(&self, args: &[&str]) -> Outcome {
        self.begin(args).end()
    }

    /// Log of the rig so far.
    pub(crate) fn log(&self) -> String {
        self.program.said()
    }

    pub(crate) fn id(&self) -> Pid {
        self.program.id()
    }

    /// Kills the rig. Its terminal is held open, because otherwise the next rig would get the same path, and the host, which
    /// looks for its rig again, would lock that rig for itself.
    pub(crate) fn kill(self) {
        let _ = open(&*self.address, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty()).map(mem::forget);
        self.program.kill();
    }

    /// Waits until the rig plays a move.
    pub(crate) fn plays(&self) {
        within("a move", || {
            // The last row may be incomplete.
            let is_moment = |row: &&str| row.split(',').nth(3).is_some_and(|moment| moment.parse::<f64>().is_ok());
            std::fs::read_to_string(&self.record).unwrap().lines().rev().take(20).find(is_moment).map(drop)
        });
    }

    /// Waits until a motor moves that has never moved before.
    pub(crate) fn moves(&self, motor: u8) {
        let is_it = |row: &&str| row.split(',').nth(1).and_then(|number| number.parse().ok()) == Some(motor);
        within("motion", || {
            let rows = std::fs::read_to_string(&self.record).unwrap();
            (rows.lines().filter(is_it).count() > 100).then_some(())
        });
    }

    /// Number of rows that are recorded so far.
    pub(crate) fn rows(&self) -> usize {
        std::fs::read_to_string(&self.record).unwrap().matches('\n').count() - 1
    }

    /// Waits until the motors have not moved for a moment.
    pub(crate) fn rests(&self) {
        let mut last = (0, Instant::now());
        within("rest", || {
            // Rows are in the file after half a second at the latest.
            let len = self.record.metadata().unwrap().len();
            if len != last.0 {
                last = (len, Instant::now());
            }
            (last.1.elapsed() > Duration::from_millis(1200)).then_some(())
        });
    }

    /// Ends the rig, as Ctrl-C does. Returns the record of its motors.
    pub(crate) fn end(self) -> Vec<Row> {
        self.program.interrupt();
        let outcome = self.program.end();
        assert!(outcome.status.success() && outcome.err.contains("the end"), "{outcome:?}");
        Row::read(&self.record)
    }
}

/// Time for which some rigs refuse motion after a stop.
const LOCK: Duration = Duration::from_secs(2);

/// Interrupts a run, and then a jog of motor 1. Each time the rig must confirm the stop and rest. Returns the record of
/// its motors.
#[track_caller]
pub(crate) fn interrupted(rig: Rig, run: &[&str], jog: &[&str], interrupt: fn(&Program)) -> Vec<Row> {
    let confirmed = "moco: interrupted: the rig confirmed the stop";
    let drive = rig.begin(run);
    rig.plays();
    thread::sleep(Duration::from_millis(500));
    drive.interrupt();
    drive.end().ended(Status::Interrupted, confirmed);
    rig.rests();
    thread::sleep(LOCK);
    let drive = rig.begin(jog);
    rig.moves(1);
    interrupt(&drive);
    drive.end().ended(Status::Interrupted, confirmed);
    rig.rests();
    rig.end()
}

/// Kills a rig that plays a move of `drive`. The program must report that the stop is not confirmed.
#[track_caller]
pub(crate) fn missed(rig: Rig, drive: Program) {
    rig.plays();
    rig.kill();
    drive.end().ended(Status::MayMove, "NOT confirmed: press the emergency stop");
}

/// Cuts the cable in a run. The line must be opened again for a stop. Returns the record of the motors.
#[track_caller]
pub(crate) fn cut(rig: Rig, run: &[&str]) -> Vec<Row> {
    let cable = Cable::new(&rig.address);
    let drive = rig.begin_over(&cable.address, run);
    rig.plays();
    cable.cut();
    drive.end().failed("the rig confirmed the stop");
    rig.rests();
    rig.end()
}

/// Returns whether a command succeeded. Otherwise it must have failed with one line. In both cases all motors must be
/// at rest.
#[track_caller]
pub(crate) fn done_or_at_rest(rig: &Rig, outcome: Outcome) -> bool {
    let is_done = outcome.status.success();
    if !is_done {
        outcome.failed_somehow();
    }
    rig.rests();
    is_done
}

/// Scenario with its name, which is also the name of its folder.
pub(crate) type Scenario = (&'static str, fn(&str));

/// Runs scenarios, several at the same time, because each of them mostly waits.
pub(crate) fn together(scenarios: &[Scenario]) {
    let next = AtomicUsize::new(0);
    let failed = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..AT_A_TIME {
            scope.spawn(|| {
                while let Some(&(name, scenario)) = scenarios.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let began = Instant::now();
                    let thread = thread::Builder::new().name(name.to_owned()).spawn(move || scenario(name));
                    if thread.unwrap().join().is_err() {
                        failed.lock().unwrap().push(name);
                    }
                    println!("{name}: {:.1} s", began.elapsed().as_secs_f64());
                }
            });
        }
    });
    let failed = failed.into_inner().unwrap();
    assert!(failed.is_empty(), "failed: {failed:?}");
}

/// Folder for a test of this name.
pub(crate) fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Writes a move file for a test.
pub(crate) fn file(test: &str, json: &str) -> PathBuf {
    let path = folder(test).join("move.json");
    std::fs::write(&path, json).unwrap();
    path
}

/// Waits until `look` finds something.
#[track_caller]
pub(crate) fn within<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < BOUND, "{what} did not come");
        thread::sleep(Duration::from_millis(5));
    }
}

/// Reads the output of a program while it runs.
fn listen(from: impl Read + Send + 'static) -> (Arc<Mutex<String>>, thread::JoinHandle<()>) {
    let said = Arc::new(Mutex::new(String::new()));
    let heard = Arc::clone(&said);
    let reader = thread::spawn(move || {
        let mut from = BufReader::new(from);
        let mut line = Vec::new();
        while from.read_until(b'\n', &mut line).is_ok_and(|len| len > 0) {
            heard.lock().unwrap().push_str(&String::from_utf8_lossy(&line));
            line.clear();
        }
    });
    (said, reader)
}
