//! Lines that are lost and opened again, with the driver on tokio.

mod lines;

use std::sync::{Arc, Mutex};

use dmc_proto::host as dmc_host;
use dmc_proto::message as dmc;
use dmc_proto::upload::NoMove;
use hoot_proto::message as hoot;
use kos_proto::device as kos_device;
use kos_proto::host as kos_host;
use kos_proto::message as kos;
use lines::{Lines, SECOND, Still, events, new_dmc_device, place};
use motion_core::machine::Token;
use motion_core::session::NotTaken;
use motion_io::tokio::{Driver, tcp};
use motion_io::{Error, Reconnect};
use tokio::io::{AsyncReadExt, DuplexStream, duplex};
use tokio::net::TcpListener;
use tokio::time::{Instant, sleep};

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
            session.speed(Token(1), to, hoot::Motor::One, speed)
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

/// Moves a motor of a DMC device, and connects to another one after the line is lost. Returns the events of the host and those of
/// the second device since then.
async fn lost_while_a_motor_moved(rules: Reconnect) -> [Vec<String>; 2] {
    use dmc_host::{Event, Options, Session, Token};
    let lines = Lines::default();
    let (mut pipe, first) = (lines.add(), lines.clone());
    let session: Session = Session::new(Options::default());
    let mut driver =
        Driver::new(session, lines.open().unwrap()).reconnecting(rules, move || std::future::ready(first.open()));
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
    place(&told, "Greeted");
    let seen = seen.lock().unwrap().clone();
    [told, seen]
}

#[tokio::test(start_paused = true)]
async fn a_dmc_device_is_stopped_first_after_a_line_was_lost_while_a_motor_moved() {
    let token = Token(7);
    for (rules, token) in [(Reconnect::new(), Reconnect::STOP), (Reconnect::new().with_stop_token(token), token)] {
        let [told, seen] = lost_while_a_motor_moved(rules).await;
        assert_eq!(place(&seen, "Stop(All"), 0);
        place(&told, &format!("token: {token:?}"));
    }
}

#[tokio::test(start_paused = true)]
async fn nothing_is_stopped_after_a_line_was_lost_if_the_rules_leave_the_stop_out() {
    let [told, seen] = lost_while_a_motor_moved(Reconnect::new().without_stop()).await;
    assert!(!seen.iter().any(|event| event.contains("Stop")), "{seen:#?}");
    let token = format!("token: {:?}", Reconnect::STOP);
    assert!(!told.iter().any(|event| event.contains(&token)), "{told:#?}");
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
                .map_err(|error| Error::NotOpened { what: "the listener".into(), why: error.to_string() })
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
