//! Lines that are lost, stuck or not there, with the driver on tokio.

use std::collections::VecDeque;
use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll};
use std::time::Duration;

use dmc_proto::device as dmc_device;
use dmc_proto::host as dmc_host;
use dmc_proto::message as dmc;
use dmc_proto::upload::NoMove;
use hoot_proto::message as hoot;
use kos_proto::device as kos_device;
use kos_proto::host as kos_host;
use kos_proto::message as kos;
use motion_core::session::{NotTaken, Session, Turn};
use motion_core::time::Millis;
use motion_core::wire::EncodeError;
use motion_io::tokio::{Driver, tcp};
use motion_io::{Error, Reconnect};
use tokio::io::{AsyncReadExt, DuplexStream, ReadBuf, duplex};
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
    let text =
        "the line is gone: the other end closed it before it answered: check its protocol, its cable and its power";
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
async fn a_line_that_is_lost_before_a_byte_arrived_counts_as_an_attempt_that_failed() {
    let session: dmc_host::Session = dmc_host::Session::new(dmc_host::Options::default());
    let rules = Reconnect::new().with_attempts(4).with_times(SECOND, 3 * SECOND);
    // Each line is closed at once, as a server with too many clients does.
    let mut driver =
        Driver::new(session, duplex(64).0).reconnecting(rules, || std::future::ready(Ok::<_, Error>(duplex(64).0)));
    let start = Instant::now();
    let error = tokio::time::timeout(60 * SECOND, async {
        loop {
            if let Err(error) = driver.next(&NoMove).await {
                break error;
            }
        }
    })
    .await
    .expect("the attempts end");
    assert!(error.to_string().contains("the other end closed it before it answered"), "{error}");
    let time = start.elapsed();
    assert!(time >= 9 * SECOND && time < 9 * SECOND + SECOND / 10, "{time:?}");
}

#[tokio::test(start_paused = true)]
async fn an_attempt_to_open_ends_when_the_session_does_not_want_its_line_any_more() {
    use kos_proto::host::{Endpoint, Options, Session, Source, Token};
    let lines = Lines::default();
    let mut far = lines.add();
    let mut driver =
        Driver::unopened(Session::<140_000>::new(Options::default())).reconnecting(Reconnect::default(), move || {
            let line = lines.open();
            async move {
                sleep(3 * SECOND).await;
                line
            }
        });
    driver.session_mut().connect(Token(1), Endpoint::Tcp(kos::Ipv4::default())).unwrap();
    let _ = events(&mut driver, &Source::default(), SECOND, |_| None).await;
    driver.session_mut().disconnect(Token(2)).unwrap();
    let _ = events(&mut driver, &Source::default(), 5 * SECOND, |_| None).await;
    assert!(!driver.is_open(), "nobody wants the line");
    assert!(far.read_u8().await.is_err(), "the line is closed");
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

#[tokio::test(start_paused = true)]
async fn a_driver_without_a_stream_opens_its_line_at_once() {
    let lines = Lines::default();
    let seen = dmc_device(lines.add());
    let session: dmc_host::Session = dmc_host::Session::new(dmc_host::Options::default());
    let mut driver =
        Driver::unopened(session).reconnecting(Reconnect::default(), move || std::future::ready(lines.open()));
    assert!(!driver.is_open());
    let told = events(&mut driver, &NoMove, SECOND, |_| None).await;
    assert!(driver.is_open() && place(&told, "Greeted") < told.len());
    assert_eq!(*seen.lock().unwrap(), [""; 0], "nothing is stopped");
}

#[tokio::test(start_paused = true)]
async fn an_attempt_to_open_the_line_that_is_given_up_begins_afresh() {
    use kos_host::{Endpoint, Event, Options, Session, Source, Token};
    let attempts = Arc::new(Mutex::new(0));
    let count = attempts.clone();
    let mut session: Session = Session::new(Options::default());
    session.connect(Token(1), Endpoint::Tcp(kos::Ipv4(0x7F00_0001))).unwrap();
    let mut driver: Driver<Session, DuplexStream> =
        Driver::unopened(session).reconnecting(Reconnect::default(), move || {
            *count.lock().unwrap() += 1;
            std::future::pending()
        });
    let source = Source::default();
    let told = events(&mut driver, &source, SECOND, |_| None).await;
    assert_eq!((*attempts.lock().unwrap(), told.iter().filter(|event| event.contains("LinkDown")).count()), (1, 0));
    driver.give_up_opening();
    assert!(matches!(driver.next(&source).await.unwrap(), Event::LinkDown(_)));
    events(&mut driver, &source, 10 * SECOND, |_| None).await;
    assert_eq!(*attempts.lock().unwrap(), 2);
    // Nothing is given up while no attempt is in progress.
    let (near, _far) = duplex(64);
    let session: dmc_host::Session = dmc_host::Session::new(dmc_host::Options::default());
    let mut driver = Driver::new(session, near);
    driver.give_up_opening();
    assert!(driver.is_open());
}

#[tokio::test(start_paused = true)]
async fn the_end_of_a_time_without_events_is_no_error() {
    let (near, _far) = duplex(64);
    let session = hoot_proto::host::Session::new(hoot_proto::host::Options::default());
    let mut driver = Driver::new(session, near);
    assert!(driver.next_within(SECOND, &()).await.unwrap().is_some(), "the master is ready");
    let start = Instant::now();
    assert_eq!(driver.next_within(SECOND / 4, &()).await.unwrap(), None);
    assert!(start.elapsed() >= SECOND / 4 && start.elapsed() < SECOND / 3, "{:?}", start.elapsed());
}

/// Stream that is never silent, and that never lets other tasks run.
struct Babble;

/// Session that waits for bytes until a time, and takes all bytes.
#[derive(Default)]
struct Listener {
    until: Option<Millis>,
    has_heard: bool,
    was_late: bool,
}

impl tokio::io::AsyncRead for Babble {
    fn poll_read(self: Pin<&mut Self>, _: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        buf.put_slice(&[0xFF; 16]);
        Poll::Ready(Ok(()))
    }
}

impl tokio::io::AsyncWrite for Babble {
    fn poll_write(self: Pin<&mut Self>, _: &mut Context<'_>, buf: &[u8]) -> Poll<io::Result<usize>> {
        Poll::Ready(Ok(buf.len()))
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        unreachable!("the driver does not flush")
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}

impl Session for Listener {
    type Source<'s> = ();
    type Line = ();
    type Destination = ();
    type Event<'e> = ();
    type Held = ();

    const PIECE: usize = 64;

    fn reaches((): (), (): ()) -> bool {
        true
    }

    fn link_up(&mut self, (): ()) -> Result<(), NotTaken> {
        Ok(())
    }

    fn link_down(&mut self, (): ()) -> Result<(), NotTaken> {
        Ok(())
    }

    fn receive(&mut self, _: Millis, (): (), bytes: &[u8]) -> usize {
        self.has_heard |= !bytes.is_empty();
        bytes.len()
    }

    fn turn(&mut self, now: Millis, (): &(), _: &mut [u8]) -> Result<Turn<(), ()>, EncodeError> {
        self.was_late |= !self.has_heard && self.until.is_some_and(|until| until <= now);
        Ok(Turn::Wait(self.until.filter(|until| *until > now)))
    }

    fn event(&self, (): ()) {}
}

#[tokio::test]
async fn a_line_that_is_never_silent_delays_neither_the_end_of_a_time_nor_other_tasks() {
    let (mut driver, start) = (Driver::new(Listener::default(), Babble), Instant::now());
    assert_eq!(driver.next_within(SECOND / 20, &()).await, Ok(None));
    assert!(tokio::time::timeout(SECOND / 20, driver.next(&())).await.is_err());
    assert!(start.elapsed() < 4 * SECOND, "{:?}", start.elapsed());
}

#[tokio::test(start_paused = true)]
async fn bytes_that_arrived_in_time_go_before_what_is_due_also_if_the_computer_is_late() {
    for is_heard in [true, false] {
        let (near, mut far) = duplex(64);
        let listener = Listener { until: Some(Millis(1_000)), ..Listener::default() };
        let mut driver = Driver::new(listener, near);
        let late = async {
            tokio::task::yield_now().await;
            if is_heard {
                tokio::io::AsyncWriteExt::write_all(&mut far, b"answer").await.unwrap();
            }
            tokio::time::advance(2 * SECOND).await;
        };
        let (next, ()) = tokio::join!(driver.next_within(SECOND * 3, &()), late);
        assert_eq!(next, Ok(None));
        assert_eq!(driver.session().was_late, !is_heard);
    }
}

#[tokio::test(start_paused = true)]
async fn the_loss_of_a_line_has_the_name_of_the_line_and_says_what_to_check() {
    for (bytes, advice) in [(&b""[..], " before it answered: check its protocol,"), (b"\xFF", ": check")] {
        let (near, mut far) = duplex(64);
        let session: dmc_host::Session = dmc_host::Session::new(dmc_host::Options::default());
        let mut driver = Driver::new(session, near).named("the crane");
        tokio::io::AsyncWriteExt::write_all(&mut far, bytes).await.unwrap();
        while driver.next_within(SECOND / 10, &NoMove).await.unwrap().is_some() {}
        drop(far);
        let error = loop {
            if let Err(error) = driver.next(&NoMove).await {
                break error.to_string();
            }
        };
        assert_eq!(error, format!("the crane is gone: the other end closed it{advice} its cable and its power"));
    }
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
