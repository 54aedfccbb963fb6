//! Tests of the server with a toy rig on real lines, and with clients that misbehave.

use std::net::{SocketAddr, SocketAddrV4};
use std::path::Path;
use std::time::Duration;

use moco::serve::{Announcer, Door, Options, PATIENCE, Record, Server, listen};
use motion_core::profile::Limits;
use motion_core::time::Millis;
use motion_rigs::faults::{Carrier, Faults};
use motion_rigs::motor::Motor;
use motion_rigs::{LineId, Outgoing, Party, Rig, TICK};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, DuplexStream, duplex};
use tokio::net::{TcpListener, TcpStream, UdpSocket};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep, timeout};

/// Longest time that a test waits for anything.
const BOUND: Duration = Duration::from_secs(20);

/// Rig that echoes what it receives, except `!` (it sends more than a client may leave unread), `s` (it sends a thousand
/// pieces), `g` (its motor goes to
/// 10) and `q` (it sends `bye` and closes the line). It announces itself each second.
struct Toy {
    open: [bool; 2],
    motors: [Motor; 1],
    out: Vec<Outgoing>,
    now: Millis,
    announced: u64,
    /// Events of its lines.
    told: Vec<String>,
    resets: usize,
    stalls: usize,
}

impl Toy {
    fn new() -> Self {
        let motors = [Motor::new(Limits { velocity: 100.0, acceleration: 1000.0, jerk: None })];
        let (out, told, now) = (Vec::new(), Vec::new(), Millis(0));
        Self { open: [false; 2], motors, out, now, announced: 0, told, resets: 0, stalls: 0 }
    }
}

impl Party for Toy {
    fn open(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        assert!(!self.open[usize::from(line.0)], "a line is not opened twice");
        self.open[usize::from(line.0)] = true;
        self.told.push(format!("open {}", line.0));
    }

    fn close(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if std::mem::take(&mut self.open[usize::from(line.0)]) {
            self.told.push(format!("close {}", line.0));
        }
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        self.advance(now);
        if !self.open[usize::from(line.0)] {
            return;
        }
        match bytes {
            b"!" => (0..64).for_each(|_| self.out.push(Outgoing::Bytes(line, vec![b'!'; 64 * 1024]))),
            b"g" => self.motors[0].go_to(now, 10.0, 100.0, 1000.0),
            b"s" => (0..1_000).for_each(|_| self.out.push(Outgoing::Bytes(line, vec![b's'; 20]))),
            b"q" => self.out.extend([Outgoing::Bytes(line, b"bye".to_vec()), Outgoing::HangUp(line)]),
            _ => self.out.push(Outgoing::Bytes(line, bytes.to_vec())),
        }
    }

    fn advance(&mut self, now: Millis) {
        assert!(now >= self.now, "time does not go back");
        self.now = now;
        self.motors[0].advance(now);
        if now.0 / 1000 > self.announced {
            self.announced = now.0 / 1000;
            self.out.push(Outgoing::Announce(b"toy".to_vec()));
        }
    }

    fn wake(&self) -> Option<Millis> {
        let announce = Millis((self.announced + 1) * 1000);
        Some(if self.motors[0].is_idle() { announce } else { announce.min(self.now.after(TICK)) })
    }

    fn poll(&mut self) -> Option<Outgoing> {
        (!self.out.is_empty()).then(|| self.out.remove(0))
    }
}

impl Rig for Toy {
    const LINES: u8 = 2;

    fn datagram(&mut self, now: Millis, from: SocketAddrV4, bytes: &[u8]) {
        self.advance(now);
        self.out.push(Outgoing::Datagram(from, bytes.to_ascii_uppercase()));
    }

    fn motors(&self) -> &[Motor] {
        &self.motors
    }

    fn moment(&self) -> Option<f64> {
        (!self.motors[0].is_idle()).then_some(0.5)
    }

    fn reset(&mut self, now: Millis) {
        self.advance(now);
        self.resets += 1;
        self.open = [false; 2];
    }

    fn stall(&mut self, now: Millis) {
        self.advance(now);
        self.stalls += 1;
    }
}

/// Server with a toy.
struct Served {
    door: Door,
    stop: oneshot::Sender<()>,
    server: JoinHandle<Toy>,
}

fn serve(options: Options) -> Served {
    let (server, door) = Server::new(Toy::new(), options);
    let (stop, stopped) = oneshot::channel();
    let server = tokio::spawn(server.run(async {
        let _ = stopped.await;
    }));
    Served { door, stop, server }
}

impl Served {
    async fn listen(&self) -> SocketAddr {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        tokio::spawn(listen(listener, self.door.clone()));
        address
    }

    async fn duplex(&self, carrier: Carrier) -> DuplexStream {
        let (here, there) = duplex(64 * 1024);
        drop(self.door.enter("duplex", carrier, there).await);
        here
    }

    async fn end(self) -> Toy {
        self.stop.send(()).unwrap();
        within(self.server).await.unwrap()
    }
}

async fn within<T>(future: impl Future<Output = T>) -> T {
    timeout(BOUND, future).await.expect("the future is ready in time")
}

/// Sends a text, and checks that it comes back.
async fn echo(line: &mut (impl AsyncRead + AsyncWrite + Unpin), text: &str) {
    within(line.write_all(text.as_bytes())).await.unwrap();
    let mut heard = vec![0; text.len()];
    within(line.read_exact(&mut heard)).await.unwrap();
    assert_eq!(heard, text.as_bytes());
}

/// Whether the line ends without further bytes.
async fn ends(line: &mut (impl AsyncRead + Unpin)) -> bool {
    matches!(within(line.read(&mut [0; 64])).await, Ok(0) | Err(_))
}

#[tokio::test]
async fn clients_come_and_go_and_too_many_are_rejected() {
    let served = serve(Options::default());
    let address = served.listen().await;
    let mut one = TcpStream::connect(address).await.unwrap();
    echo(&mut one, "one").await;
    let mut two = TcpStream::connect(address).await.unwrap();
    echo(&mut two, "two").await;
    let mut three = TcpStream::connect(address).await.unwrap();
    assert!(ends(&mut three).await);
    drop(one);
    // The line of the first client is free when the server knows that the client is gone.
    let connect = async {
        loop {
            let mut four = TcpStream::connect(address).await.unwrap();
            let _ = four.write_all(b"x").await;
            if !ends(&mut four).await {
                break four;
            }
            sleep(Duration::from_millis(5)).await;
        }
    };
    let mut four = within(connect).await;
    echo(&mut four, "four").await;
    echo(&mut two, "two, still").await;
    let toy = served.end().await;
    assert_eq!(toy.told, ["open 0", "open 1", "close 0", "open 0"]);
}

#[tokio::test]
async fn a_client_that_does_not_read_is_cut_off_and_others_are_not() {
    let served = serve(Options::default());
    let address = served.listen().await;
    let mut quick = TcpStream::connect(address).await.unwrap();
    echo(&mut quick, "hello").await;
    let mut slow = TcpStream::connect(address).await.unwrap();
    let cut = async {
        while slow.write_all(b"!").await.is_ok() {
            echo(&mut quick, "still here").await;
            sleep(Duration::from_millis(1)).await;
        }
    };
    within(cut).await;
    echo(&mut quick, "and now").await;
    assert_eq!(served.end().await.told, ["open 0", "open 1", "close 1"]);
}

#[tokio::test(start_paused = true)]
async fn a_line_that_is_read_in_time_loses_nothing() {
    let served = serve(Options::default());
    let mut line = served.duplex(Carrier::Serial).await;
    let text: Vec<u8> = (0..2 * PATIENCE).map(|at| u8::try_from(at % 251).unwrap()).collect();
    let mut heard = vec![0; text.len()];
    {
        let (mut from, mut to) = tokio::io::split(&mut line);
        let both = async { tokio::join!(to.write_all(&text), from.read_exact(&mut heard)) };
        let (written, read) = within(both).await;
        written.unwrap();
        read.unwrap();
    }
    assert!(heard == text);
    drop(line);
    sleep(Duration::from_millis(10)).await;
    assert_eq!(served.end().await.told, ["open 0", "close 0"]);
}

#[tokio::test(start_paused = true)]
async fn a_flood_is_not_read_faster_than_the_rig_takes_it() {
    // The bytes arrive at the rig so late that soon no more may be read.
    let faults = Faults { delay: 60_000, ..Faults::NONE };
    let served = serve(Options { faults, ..Options::default() });
    let mut line = served.duplex(Carrier::Stream).await;
    let mut taken = 0;
    while let Ok(len) = timeout(Duration::from_millis(1), line.write(&[b'x'; 4096])).await {
        taken += len.unwrap();
        assert!(taken < 1024 * 1024, "the server takes everything");
    }
    assert!(taken > 64 * 1024, "{taken}");
    served.end().await;
}

#[tokio::test]
async fn the_last_bytes_of_a_rig_that_closes_its_line_arrive() {
    let served = serve(Options::default());
    let address = served.listen().await;
    let mut line = TcpStream::connect(address).await.unwrap();
    line.write_all(b"q").await.unwrap();
    let mut heard = String::new();
    within(line.read_to_string(&mut heard)).await.unwrap();
    assert_eq!(heard, "bye");
    assert_eq!(served.end().await.told, ["open 0", "close 0"]);
}

#[tokio::test]
async fn a_client_that_sends_no_more_gets_its_answers() {
    let served = serve(Options::default());
    let mut client = TcpStream::connect(served.listen().await).await.unwrap();
    client.write_all(b"s").await.unwrap();
    client.shutdown().await.unwrap();
    let mut answered = Vec::new();
    within(client.read_to_end(&mut answered)).await.unwrap();
    assert_eq!(answered.len(), 20_000);
    assert_eq!(served.end().await.told, ["open 0", "close 0"]);
}

#[tokio::test(start_paused = true)]
async fn a_reset_ends_connections_and_serial_lines_open_again() {
    let faults = Faults { reset: 1.0, stall: 1.0, silence: 2.0, ..Faults::NONE };
    let served = serve(Options { faults, seed: 3, ..Options::default() });
    let mut connection = served.duplex(Carrier::Stream).await;
    let mut serial = served.duplex(Carrier::Serial).await;
    assert!(ends(&mut connection).await);
    for _ in 0..20 {
        // Bytes are lost while the line is dead, so they are sent again.
        let heard = loop {
            serial.write_all(b"hello").await.unwrap();
            let mut heard = [0; 64];
            if let Ok(len) = timeout(Duration::from_millis(100), serial.read(&mut heard)).await {
                break heard[..len.unwrap()].to_vec();
            }
        };
        assert!(heard.starts_with(b"hello"));
        sleep(Duration::from_millis(200)).await;
    }
    let toy = served.end().await;
    assert!(toy.resets >= 3 && toy.stalls >= 3, "{} {}", toy.resets, toy.stalls);
    let opened = |line: &str| toy.told.iter().filter(|told| **told == line).count();
    assert_eq!((opened("open 0"), opened("open 1")), (1, 1 + toy.resets));
}

#[tokio::test(start_paused = true)]
async fn faults_of_a_line_come_from_the_seed() {
    let heard = async |seed| {
        let served = serve(Options { faults: Faults::all(Carrier::Serial), seed, ..Options::default() });
        let mut line = served.duplex(Carrier::Serial).await;
        let mut heard = Vec::new();
        for letter in (b'A'..=b'Z').cycle().take(200) {
            line.write_all(&[letter; 8]).await.unwrap();
            let mut buffer = [0; 64];
            while let Ok(len) = timeout(Duration::from_millis(25), line.read(&mut buffer)).await {
                let len = len.unwrap();
                assert!(len > 0, "the line stays open");
                heard.extend_from_slice(&buffer[..len]);
            }
        }
        served.end().await;
        heard
    };
    let (one, again, other) = (heard(1).await, heard(1).await, heard(2).await);
    assert_eq!(one, again);
    assert_ne!(one, other);
    assert!(one.len() > 1000 && one.len() != 1600);
}

#[tokio::test]
async fn datagrams_are_announced_and_answered() {
    let listener = UdpSocket::bind("127.0.0.1:0").await.unwrap();
    let here = UdpSocket::bind("127.0.0.1:0").await.unwrap().local_addr().unwrap();
    let announcer = Announcer::bind(here, listener.local_addr().unwrap(), Faults::NONE).await.unwrap();
    let served = serve(Options { announcer: Some(announcer), ..Options::default() });
    let mut buffer = [0; 64];
    listener.send_to(b"who?", here).await.unwrap();
    let (len, from) = within(listener.recv_from(&mut buffer)).await.unwrap();
    assert_eq!((&buffer[..len], from), (b"WHO?".as_slice(), here));
    let (len, from) = within(listener.recv_from(&mut buffer)).await.unwrap();
    assert_eq!((&buffer[..len], from), (b"toy".as_slice(), here));
    served.end().await;
}

#[tokio::test(start_paused = true)]
async fn a_record_has_a_row_for_each_change() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("a_record_has_a_row_for_each_change.csv");
    let record = Record::create(&path).unwrap();
    let served = serve(Options { record: Some(record), ..Options::default() });
    let mut line = served.duplex(Carrier::Serial).await;
    sleep(Duration::from_millis(100)).await;
    line.write_all(b"g").await.unwrap();
    sleep(Duration::from_secs(2)).await;
    // The rows are in the file before the end.
    let text = std::fs::read_to_string(&path).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|row| row.split(',').collect()).collect();
    assert_eq!(rows[0], ["millis", "motor", "position", "moment"]);
    assert_eq!(rows[1], ["0", "1", "0", ""]);
    // From rest to rest over 10 units, at 100 units/s and 1000 units/s²: 0.2 s.
    let start: u64 = rows[2][0].parse().unwrap();
    assert_eq!((rows[2][1], rows[2][3]), ("1", "0.5"));
    let end = (start + 199).to_string();
    assert_eq!(rows.last().unwrap()[..3], [end.as_str(), "1", "10"]);
    assert_eq!(rows.len(), 2 + 200);
    let start = Instant::now();
    served.end().await;
    assert_eq!((start.elapsed(), std::fs::read_to_string(&path).unwrap()), (Duration::ZERO, text));
}

#[cfg(unix)]
mod pty {
    use std::fs::{OpenOptions, Permissions, set_permissions};
    use std::os::unix::fs::PermissionsExt;
    use std::os::unix::process::CommandExt;
    use std::process::Command;

    use moco::serve::Pty;
    use tokio_serial::{SerialPortBuilderExt, SerialStream};

    use super::*;

    fn open(path: &str) -> SerialStream {
        tokio_serial::new(path, 115_200).open_native_async().unwrap()
    }

    fn serve_pty() -> (Served, String) {
        let served = serve(Options::default());
        let pty = Pty::new().unwrap();
        let path = pty.path().to_owned();
        tokio::spawn(pty.serve(served.door.clone()));
        (served, path)
    }

    #[tokio::test]
    async fn users_of_a_terminal_come_and_go() {
        let (served, path) = serve_pty();
        for user in 0..5_u8 {
            let mut line = open(&path);
            // All bytes arrive unchanged.
            echo(&mut line, "hello\r\n\x03\x11\x13\x04\x7f").await;
            drop(line);
            // The next user may come at once.
            if user.is_multiple_of(2) {
                sleep(Duration::from_millis(30)).await;
            }
        }
        sleep(Duration::from_millis(30)).await;
        let told = served.end().await.told;
        assert!(told.len() >= 6 && told.chunks(2).all(|pair| pair == ["open 0", "close 0"]), "{told:?}");
    }

    #[tokio::test]
    async fn unread_bytes_are_not_for_the_next_user() {
        let (served, path) = serve_pty();
        let mut line = open(&path);
        line.write_all(b"unread").await.unwrap();
        sleep(Duration::from_millis(50)).await;
        drop(line);
        sleep(Duration::from_millis(50)).await;
        echo(&mut open(&path), "mine").await;
        served.end().await;
    }

    /// Programs lock a serial line for themselves. The superuser may open a locked line, so another user tries.
    #[tokio::test]
    async fn a_lock_does_not_outlive_its_user() {
        let (served, path) = serve_pty();
        set_permissions(&path, Permissions::from_mode(0o666)).unwrap();
        let opens = || {
            let mut shell = Command::new("sh");
            shell.args(["-c", ": <>\"$0\"", &path]);
            if rustix::process::geteuid().is_root() {
                shell.uid(65_534).gid(65_534);
            }
            shell.status().unwrap().success()
        };
        assert!(opens());
        let said_nothing = OpenOptions::new().read(true).write(true).open(&path).unwrap();
        rustix::termios::ioctl_tiocexcl(&said_nothing).unwrap();
        assert!(!opens());
        drop(said_nothing);
        sleep(Duration::from_millis(600)).await;
        assert!(opens());
        // This function locks the line.
        let mut said_something = open(&path);
        echo(&mut said_something, "hello").await;
        drop(said_something);
        sleep(Duration::from_millis(50)).await;
        assert!(opens());
        served.end().await;
    }
}
