//! Host and device on threads, with blocking streams.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use dmc_proto::device::{self, DeviceMachine};
use dmc_proto::host;
use dmc_proto::message as dmc;
use dmc_proto::upload::NoMove;
use kos_proto::discovery::Datagram;
use motion_io::blocking::{Driver, Stream, tcp};
use motion_io::{Error, Reconnect};

struct Still;

impl device::Rig for Still {
    fn verdict(&self, _: &dmc::HostMessage<'_>) -> dmc::AckCode {
        dmc::AckCode::OK
    }

    fn position(&self, _: dmc::Motor) -> dmc::Steps {
        dmc::Steps(0)
    }
}

fn new_device() -> device::Session {
    let hi = dmc::Hi { motor_count: 4, ..device::Options::default().hi() };
    device::Session::new(DeviceMachine::new(device::Options::of(hi)), dmc_proto::Patience::default())
}

/// Drives a device until the line is closed, or a motor is moved. Returns its events.
fn serve(line: TcpStream, ends_with_move: bool) -> Vec<String> {
    let mut driver = Driver::new(new_device(), line);
    let mut events = Vec::new();
    while let Ok(event) = driver.next(&Still) {
        events.push(format!("{event:?}"));
        if matches!(event, device::Event::Move(..)) && ends_with_move {
            // The acknowledgement of the move goes out.
            let _ = driver.next_within(Duration::from_millis(300), &Still);
            break;
        }
    }
    events
}

#[test]
fn a_host_moves_a_motor_and_stops_first_after_the_line_was_lost() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let (tell, told) = mpsc::channel();
    thread::spawn(move || {
        for ends_with_move in [true, false] {
            let (line, _) = listener.accept().unwrap();
            tell.send(serve(line, ends_with_move)).unwrap();
        }
    });
    let session: host::Session = host::Session::new(host::Options::default());
    let mut driver =
        Driver::new(session, tcp(address).unwrap()).reconnecting(Reconnect::default(), move || tcp(address));
    let motor = dmc::Motor(1);
    let (mut events, start) = (Vec::new(), Instant::now());
    while start.elapsed() < Duration::from_secs(20) {
        let Some(event) = driver.next_within(Duration::from_millis(100), &NoMove).unwrap() else { continue };
        events.push(format!("{event:?}"));
        match event {
            host::Event::Greeted(_) => driver.session_mut().configured(host::Token(1)).unwrap(),
            host::Event::Ready { reconnected: false } => {
                let flags = dmc::MotorFlags::ENABLED;
                let configure = dmc::MotorConfigure { motor, flags, tail: &[] };
                driver.session_mut().request(host::Token(2), configure).unwrap();
            }
            host::Event::Ended { token: host::Token(2), .. } => {
                let position = dmc::Steps(2_000);
                driver.session_mut().request(host::Token(3), dmc::MotorMove { motor, position, tail: &[] }).unwrap();
            }
            host::Event::Ready { reconnected: true } => break,
            _ => {}
        }
    }
    assert!(events.iter().any(|event| event.starts_with("LinkDown")), "{events:#?}");
    assert!(events.iter().any(|event| event.contains(&format!("{:?}", Reconnect::STOP))), "{events:#?}");
    drop(driver);
    assert!(told.recv().unwrap().iter().any(|event| event.starts_with("Move(")));
    assert!(told.recv().unwrap()[0].starts_with("Stop(All"));
}

/// Host that moves a motor, or that only greets, and then closes its line.
fn visit(address: SocketAddr, moves: bool) {
    let session: host::Session = host::Session::new(host::Options::default());
    let mut driver = Driver::new(session, tcp(address).unwrap());
    loop {
        match driver.next(&NoMove).unwrap() {
            host::Event::Greeted(_) => driver.session_mut().configured(host::Token(1)).unwrap(),
            host::Event::Ready { .. } if moves => {
                let configure =
                    dmc::MotorConfigure { motor: dmc::Motor(1), flags: dmc::MotorFlags::ENABLED, tail: &[] };
                driver.session_mut().request(host::Token(2), configure).unwrap();
            }
            host::Event::Ended { token: host::Token(2), .. } => {
                let go = dmc::MotorMove { motor: dmc::Motor(1), position: dmc::Steps(2_000), tail: &[] };
                driver.session_mut().request(host::Token(3), go).unwrap();
            }
            host::Event::Ready { .. } | host::Event::Ended { token: host::Token(3), .. } => return,
            _ => {}
        }
    }
}

#[test]
fn a_device_without_a_line_serves_one_host_after_the_other_and_stops_when_a_line_is_lost() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.set_nonblocking(true).unwrap();
    let address = listener.local_addr().unwrap();
    let accept = move || {
        let line = listener.accept().and_then(|(line, _)| line.set_nonblocking(false).map(|()| line));
        line.map_err(|error| Error::NotOpened { what: "the listener".into(), why: error.to_string() })
    };
    let (tell, told) = mpsc::channel();
    thread::spawn(move || {
        let time = Duration::from_millis(10);
        let rules = Reconnect::new().with_times(time, time);
        let mut driver = Driver::unopened(new_device()).reopening(rules, accept);
        assert!(!driver.is_open());
        while tell.send(format!("{:?}", driver.next(&Still).unwrap())).is_ok() {}
    });
    for moves in [true, false] {
        visit(address, moves);
    }
    let mut motion = Vec::new();
    while let Ok(event) = told.recv_timeout(Duration::from_millis(300)) {
        if event.starts_with("Move(") || event.starts_with("Stop(") {
            motion.push(event);
        }
    }
    // The second host moves nothing, so that its end stops nothing.
    let [first, second] = &motion[..] else { panic!("{motion:#?}") };
    assert!(first.starts_with("Move(Motor(1)") && second.starts_with("Stop(All"), "{motion:#?}");
}

#[test]
fn bytes_for_others_are_given_to_a_function_also_without_a_line() {
    use kos_proto::host::{Destination, Options, Session, Source};
    let (tell, told) = mpsc::channel();
    let session: Session = Session::new(Options::default().with_ask_every(Some(5_000)));
    let never = || Err(Error::NotOpened { what: "the test".into(), why: "no line".into() });
    let mut driver: Driver<_, TcpStream> = Driver::unopened(session)
        .reconnecting(Reconnect::new(), never)
        .with_others(move |to, bytes| tell.send((to, bytes.to_vec())).unwrap());
    while driver.next_within(Duration::from_millis(50), &Source::default()).unwrap().is_some() {}
    let (to, bytes) = told.try_recv().unwrap();
    assert_eq!(to, Destination::Broadcast);
    assert!(matches!(Datagram::decode(&bytes), Ok(Datagram::Question(_))), "{bytes:?}");
}

#[test]
fn the_end_of_a_time_without_events_is_no_error() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let session = hoot_proto::host::Session::new(hoot_proto::host::Options::default());
    let mut driver = Driver::new(session, tcp(listener.local_addr().unwrap()).unwrap());
    assert!(driver.next(&()).is_ok(), "the master is ready");
    let start = Instant::now();
    assert_eq!(driver.next_within(Duration::from_millis(50), &()).unwrap(), None);
    let time = start.elapsed();
    assert!(time >= Duration::from_millis(49) && time < Duration::from_secs(5), "{time:?}");
}

/// Stream that takes some bytes and then no more.
struct Stuck(usize);

impl Read for Stuck {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        Err(io::ErrorKind::WouldBlock.into())
    }
}

impl Write for Stuck {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = self.0.min(bytes.len());
        self.0 -= taken;
        if taken == 0 { Err(io::ErrorKind::TimedOut.into()) } else { Ok(taken) }
    }

    fn flush(&mut self) -> io::Result<()> {
        unreachable!("the driver does not flush")
    }
}

impl Stream for Stuck {
    fn set_read_timeout(&mut self, time: Duration) -> io::Result<()> {
        assert!(!time.is_zero());
        Ok(())
    }
}

#[test]
fn a_line_that_takes_no_more_bytes_is_lost() {
    let session: host::Session = host::Session::new(host::Options::default());
    let mut driver = Driver::new(session, Stuck(3));
    let error = loop {
        if let Err(error) = driver.next(&NoMove) {
            break error;
        }
    };
    assert_eq!(
        error.to_string(),
        "the line is gone: it takes no bytes before it answered: check its protocol, its cable and its power"
    );
}

#[test]
fn an_address_where_nothing_listens_is_told_with_advice() {
    let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let error = tcp(free).unwrap_err();
    assert_eq!(error.to_string(), format!("{free}: nothing listens there: is the rig on, and is this its port?"));
}
