//! Lines that are lost, stuck or not there, with the driver on tokio.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use dmc_proto::device as dmc_device;
use dmc_proto::host as dmc_host;
use dmc_proto::message as dmc;
use dmc_proto::upload::NoMove;
use hoot_proto::message as hoot;
use kos_proto::device as kos_device;
use kos_proto::host as kos_host;
use kos_proto::message as kos;
use motion_core::session::{NotTaken, Session};
use motion_io::tokio::{Driver, tcp};
use motion_io::{Error, Reconnect};
use tokio::io::{AsyncReadExt, DuplexStream, duplex};
use tokio::net::TcpListener;
use tokio::time::{Instant, sleep};

/// Lines that can be opened one after the other. Without one, opening fails.
#[derive(Clone, Default)]
struct Lines(Arc<Mutex<VecDeque<DuplexStream>>>);

impl Lines {
    /// Adds a line, and returns its other end.
    fn add(&self) -> DuplexStream {
        let (near, far) = duplex(4_096);
        self.0.lock().unwrap().push_back(near);
        far
    }

    fn open(&self) -> Result<DuplexStream, Error> {
        let none = || Error::Line { what: "the test".into(), why: "no line".into() };
        self.0.lock().unwrap().pop_front().ok_or_else(none)
    }
}

/// Drives a session for some time, and returns its events.
async fn events<S: Session>(
    driver: &mut Driver<S, DuplexStream>,
    source: &S::Source<'_>,
    time: Duration,
    mut follow: impl FnMut(&S::Event<'_>) -> Option<fn(&mut S) -> Result<(), NotTaken>>,
) -> Vec<String>
where
    for<'e> S::Event<'e>: std::fmt::Debug,
{
    let (mut events, end) = (Vec::new(), Instant::now() + time);
    loop {
        let act = match tokio::time::timeout_at(end, driver.next(source)).await {
            Ok(event) => {
                let event = event.expect("no end");
                events.push(format!("{event:?}"));
                follow(&event)
            }
            Err(_) => return events,
        };
        if let Some(act) = act {
            act(driver.session_mut()).unwrap();
        }
    }
}

fn place(events: &[String], what: &str) -> usize {
    events.iter().position(|event| event.contains(what)).unwrap_or_else(|| panic!("no {what} in {events:#?}"))
}

const SECOND: Duration = Duration::from_secs(1);

#[tokio::test(start_paused = true)]
async fn a_hoot_node_is_stopped_first_after_a_line_was_lost_while_a_motor_moved() {
    use hoot_proto::host::{Event, Options, Session};
    let lines = Lines::default();
    let mut node = lines.add();
    let reopen = lines.clone();
    let mut driver = Driver::new(Session::new(Options::default()), lines.open().unwrap())
        .reconnecting(Reconnect::default(), move || std::future::ready(reopen.open()));
    let _ = events(&mut driver, &(), 10 * SECOND, |event| match event {
        Event::Ready { .. } => Some(|session| {
            let to = hoot_proto::Address::DEFAULT;
            let speed = hoot::StepsPerSecond(100.0);
            session.speed(hoot_proto::host::Token(1), to, hoot::Motor::One, speed)
        }),
        _ => None,
    })
    .await;
    assert!(node.read_u8().await.is_ok(), "the speed was sent");
    assert!(driver.session().may_move());

    drop(node);
    let told = events(&mut driver, &(), 7 * SECOND, |_| None).await;
    place(&told, "LinkDown");
    assert_eq!(driver.trouble().unwrap().to_string(), "the test: no line");

    let mut node = lines.add();
    let told = events(&mut driver, &(), 6 * SECOND, |_| None).await;
    assert!(place(&told, "Ready") < place(&told, "Stopping"), "{told:#?}");
    let mut packet = [0; 10];
    node.read_exact(&mut packet).await.unwrap();
    let frame = hoot_proto::Frame::decode(&packet).unwrap();
    let message = hoot::HostMessage::decode(&frame);
    assert!(matches!(message, hoot::HostMessage::Stop(_)), "{message:?}");
}

/// Rig whose motors do not move.
struct Still;

impl dmc_device::Rig for Still {
    fn verdict(&self, _: &dmc::HostMessage<'_>) -> dmc::AckCode {
        dmc::AckCode::OK
    }
    fn position(&self, _: dmc::Motor) -> dmc::Steps {
        dmc::Steps(0)
    }
}

fn new_dmc_device() -> dmc_device::Session {
    let hi = dmc::Hi { motor_count: 4, ..dmc_device::Options::default().hi() };
    let machine = dmc_device::DeviceMachine::new(dmc_device::Options::of(hi));
    dmc_device::Session::new(machine, dmc_proto::Patience::default())
}

/// Device of DMC at the end of a line, for ever. Returns the list of its events.
fn dmc_device(line: DuplexStream) -> Arc<Mutex<Vec<String>>> {
    let events = Arc::new(Mutex::new(Vec::new()));
    let told = events.clone();
    let mut driver = Driver::new(new_dmc_device(), line);
    tokio::spawn(async move {
        while let Ok(event) = driver.next(&Still).await {
            events.lock().unwrap().push(format!("{event:?}"));
        }
    });
    told
}

#[tokio::test(start_paused = true)]
async fn a_dmc_device_is_stopped_first_after_a_line_was_lost_while_a_motor_moved() {
    use dmc_host::{Event, Options, Session, Token};
    let lines = Lines::default();
    let (mut pipe, first) = (lines.add(), lines.clone());
    let session: Session = Session::new(Options::default());
    let mut driver = Driver::new(session, lines.open().unwrap())
        .reconnecting(Reconnect::default(), move || std::future::ready(first.open()));
    // The first device is at the end of a second pipe, so that the test can cut the line.
    let (near, far) = duplex(4_096);
    let seen = dmc_device(far);
    let cable = tokio::spawn(async move {
        let mut near = near;
        let _ = tokio::io::copy_bidirectional(&mut pipe, &mut near).await;
    });
    let motor = dmc::Motor(1);
    let _ = events(&mut driver, &NoMove, 3 * SECOND, |event| match event {
        Event::Greeted(_) => Some(|session| session.configured(Token(1))),
        Event::Ready { .. } => Some(|session| {
            let flags = dmc::MotorFlags::ENABLED;
            session.request(Token(2), dmc::MotorConfigure { motor: dmc::Motor(1), flags, tail: &[] })
        }),
        Event::Ended { token: Token(2), .. } => Some(|session| {
            let position = dmc::Steps(2_000);
            session.request(Token(3), dmc::MotorMove { motor: dmc::Motor(1), position, tail: &[] })
        }),
        _ => None,
    })
    .await;
    place(&seen.lock().unwrap(), &format!("Move({motor:?}"));
    assert!(driver.session().may_move());

    cable.abort();
    let told = events(&mut driver, &NoMove, 7 * SECOND, |_| None).await;
    place(&told, "LinkDown");
    let seen = dmc_device(lines.add());
    let told = events(&mut driver, &NoMove, 7 * SECOND, |_| None).await;
    assert!(place(&told, "Greeted") < told.len());
    assert_eq!(place(&seen.lock().unwrap(), "Stop(All"), 0);
    place(&told, &format!("token: {:?}", Reconnect::STOP));
}

/// Device of kOS at the end of a line, for ever. Returns the list of its events.
fn kos_device(line: DuplexStream) -> Arc<Mutex<Vec<String>>> {
    let events = Arc::new(Mutex::new(Vec::new()));
    let told = events.clone();
    let mut session: Box<kos_device::Session<33_000>> =
        Box::new(kos_device::Session::new(kos_device::DeviceMachine::new(kos_device::Options::default())));
    session.report(kos_device::Report::Started).unwrap();
    let client = (kos_device::SessionId(0), kos_proto::Transport::Tcp);
    let mut driver = Box::new(Driver::on_line(*session, client, line));
    tokio::spawn(async move {
        while let Ok(event) = driver.next(&kos_device::Source::default()).await {
            events.lock().unwrap().push(format!("{event:?}"));
        }
    });
    told
}

#[tokio::test(start_paused = true)]
async fn a_kos_device_is_stopped_first_after_a_line_was_lost_while_a_motor_moved() {
    use kos_host::{Endpoint, Event, Options, Session, Source, Token};
    let lines = Lines::default();
    let (mut pipe, first) = (lines.add(), lines.clone());
    let mut session: Session = Session::new(Options::default());
    session.connect(Token(1), Endpoint::Tcp(kos::Ipv4(0x7F00_0001))).unwrap();
    let mut driver = Driver::new(session, lines.open().unwrap())
        .reconnecting(Reconnect::default(), move || std::future::ready(first.open()));
    let (mut near, far) = duplex(4_096);
    let seen = kos_device(far);
    let cable = tokio::spawn(async move { tokio::io::copy_bidirectional(&mut pipe, &mut near).await });
    let _ = events(&mut driver, &Source::default(), 3 * SECOND, |event| match event {
        Event::Ready { reconnected: false, .. } => Some(|session| {
            let (speed, acceleration) = (kos::RotationsPerSecond(1.0), kos::RotationsPerSecondSquared(1.0));
            session.jog(Token(2), kos::MotorAddress(1), speed, acceleration)
        }),
        _ => None,
    })
    .await;
    place(&seen.lock().unwrap(), "Move { motor");
    assert!(driver.session().may_move());

    cable.abort();
    let told = events(&mut driver, &Source::default(), 7 * SECOND, |_| None).await;
    assert!(place(&told, "LinkDown") < place(&told, "Connect("), "{told:#?}");
    assert_eq!(driver.trouble().unwrap().to_string(), "the test: no line");
    let seen = kos_device(lines.add());
    let told = events(&mut driver, &Source::default(), 30 * SECOND, |_| None).await;
    place(&told, "Ready { reconnected: true");
    assert_eq!(place(&seen.lock().unwrap(), "StopAll"), 0);
    place(&told, &format!("token: {:?}", Reconnect::STOP));
}

#[tokio::test]
async fn a_dmc_device_stops_everything_when_its_line_is_lost_and_serves_the_next_host() {
    use dmc_host::{Event, Options, Session, Token};
    let listener = Arc::new(TcpListener::bind("127.0.0.1:0").await.unwrap());
    let address = listener.local_addr().unwrap();
    let accept = move || {
        let listener = listener.clone();
        async move {
            let accepted = listener.accept().await;
            accepted
                .map(|(stream, _)| stream)
                .map_err(|error| Error::Line { what: "the listener".into(), why: error.to_string() })
        }
    };
    // A host that moves the motor, or that only greets.
    let host = async |moves: bool| {
        let session: Session = Session::new(Options::default());
        let mut driver = Driver::new(session, tcp(address).await.unwrap());
        loop {
            let act: fn(&mut Session) -> Result<(), NotTaken> = match driver.next(&NoMove).await.unwrap() {
                Event::Greeted(_) => |session| session.configured(Token(1)),
                Event::Ready { .. } if !moves => return,
                Event::Ready { .. } => |session| {
                    let flags = dmc::MotorFlags::ENABLED;
                    session.request(Token(2), dmc::MotorConfigure { motor: dmc::Motor(1), flags, tail: &[] })
                },
                Event::Ended { token: Token(2), .. } => |session| {
                    let position = dmc::Steps(2_000);
                    session.request(Token(3), dmc::MotorMove { motor: dmc::Motor(1), position, tail: &[] })
                },
                Event::Ended { token: Token(3), .. } => return,
                _ => continue,
            };
            act(driver.session_mut()).unwrap();
        }
    };
    let device = async {
        let first = accept().await.unwrap();
        let mut driver = Driver::new(new_dmc_device(), first).reopening(Reconnect::default(), accept);
        let mut events = Vec::new();
        loop {
            events.push(format!("{:?}", driver.next(&Still).await.unwrap()));
            let is_stopped = events.last().is_some_and(|event| event.contains("Stop(All"));
            if is_stopped {
                break;
            }
        }
        assert!(place(&events, "Move(Motor(1)") < place(&events, "Stop(All"), "{events:#?}");
        assert!(driver.trouble().unwrap().to_string().contains("the other end closed it"));
        // The driver goes on, without another stop.
        loop {
            let event = driver.next(&Still).await.unwrap();
            assert!(!format!("{event:?}").contains("Stop"), "{event:?}");
        }
    };
    let hosts = async {
        host(true).await;
        host(false).await;
    };
    tokio::select! {
        () = hosts => {}
        () = device => unreachable!("it serves for ever"),
    }
}

#[tokio::test(start_paused = true)]
async fn nothing_is_stopped_after_a_line_was_lost_while_all_was_at_rest() {
    use dmc_host::{Event, Options, Session, Token};
    let lines = Lines::default();
    let (pipe, first) = (lines.add(), lines.clone());
    let session: Session = Session::new(Options::default());
    let mut driver = Driver::new(session, lines.open().unwrap())
        .reconnecting(Reconnect::default(), move || std::future::ready(first.open()));
    drop(pipe);
    let seen = dmc_device(lines.add());
    let told = events(&mut driver, &NoMove, 7 * SECOND, |event| match event {
        Event::Greeted(_) => Some(|session| session.configured(Token(1))),
        _ => None,
    })
    .await;
    assert!(place(&told, "LinkDown") < place(&told, "Ready"));
    assert_eq!(*seen.lock().unwrap(), [""; 0]);
}

#[tokio::test(start_paused = true)]
async fn a_line_that_is_not_opened_again_ends_with_an_error_after_all_events() {
    let (near, far) = duplex(64);
    let session: dmc_host::Session = dmc_host::Session::new(dmc_host::Options::default());
    let mut driver = Driver::new(session, near);
    drop(far);
    let mut events = Vec::new();
    let error = loop {
        match driver.next(&NoMove).await {
            Ok(event) => events.push(format!("{event:?}")),
            Err(error) => break error,
        }
    };
    assert_eq!(events, ["LinkDown"]);
    let text = "the line: the other end closed it: check the cable and the power of the rig";
    assert_eq!(error.to_string(), text);
    assert_eq!(driver.next(&NoMove).await.unwrap_err().to_string(), text);
}

#[tokio::test(start_paused = true)]
async fn attempts_end_after_the_number_that_the_rules_say() {
    let (near, far) = duplex(64);
    let session: dmc_host::Session = dmc_host::Session::new(dmc_host::Options::default());
    let lines = Lines::default();
    let rules = Reconnect::new().with_attempts(4).with_times(SECOND, 3 * SECOND);
    let mut driver = Driver::new(session, near).reconnecting(rules, move || std::future::ready(lines.open()));
    drop(far);
    let start = Instant::now();
    let error = loop {
        if let Err(error) = driver.next(&NoMove).await {
            break error;
        }
    };
    assert_eq!(error.to_string(), "the test: no line");
    // The attempts come after 1 s, 2 s, 3 s and 3 s.
    let time = start.elapsed();
    assert!(time >= 9 * SECOND && time < 9 * SECOND + SECOND / 10, "{time:?}");
}

#[tokio::test(start_paused = true)]
async fn a_line_that_takes_no_byte_for_two_seconds_is_lost() {
    // The greeting of a host is longer than the pipe, and nobody reads it.
    let (near, _far) = duplex(4);
    let session: dmc_host::Session = dmc_host::Session::new(dmc_host::Options::default());
    let mut driver = Driver::new(session, near);
    let start = Instant::now();
    let error = loop {
        // Futures that are dropped in between change nothing.
        if let Ok(Err(error)) = tokio::time::timeout(SECOND / 3, driver.next(&NoMove)).await {
            break error;
        }
    };
    assert!(error.to_string().contains("it takes no bytes"), "{error}");
    let time = start.elapsed();
    assert!(time >= 2 * SECOND && time < 2 * SECOND + SECOND / 10, "{time:?}");
}

#[tokio::test(start_paused = true)]
async fn time_goes_on_while_bytes_flood_the_line() {
    let (near, far) = duplex(64);
    let (mut read, mut write) = tokio::io::split(far);
    tokio::spawn(async move { tokio::io::copy(&mut read, &mut tokio::io::sink()).await });
    let session: dmc_host::Session = dmc_host::Session::new(dmc_host::Options::default());
    let mut driver = Driver::new(session, near);
    let flood = async {
        loop {
            tokio::io::AsyncWriteExt::write_all(&mut write, &[0x55; 64]).await.unwrap();
            sleep(Duration::from_millis(1)).await;
        }
    };
    let told = tokio::select! {
        told = events(&mut driver, &NoMove, 30 * SECOND, |_| None) => told,
        () = flood => unreachable!(),
    };
    assert!(!told.is_empty(), "the host tells that the device does not answer");
}

#[tokio::test]
async fn an_address_where_nothing_listens_is_told_with_advice() {
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let error = tcp(free).await.unwrap_err();
    assert_eq!(error.to_string(), format!("{free}: nothing listens there: is the rig on, and is this its port?"));
}

#[cfg(feature = "tokio-serial")]
#[tokio::test]
async fn a_serial_port_that_is_not_there_is_told_with_advice() {
    let error = motion_io::tokio::serial("/dev/no-such-port", 9_600).unwrap_err().to_string();
    assert!(error.starts_with("/dev/no-such-port: "), "{error}");
    assert!(error.ends_with(": is the rig plugged in, and the port not in use?"), "{error}");
}
