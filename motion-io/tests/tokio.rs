//! Lines that are lost, stuck or not there, with the driver on tokio.

mod lines;

use std::sync::{Arc, Mutex};
use std::time::Duration;

use dmc_proto::host as dmc_host;
use dmc_proto::upload::NoMove;
use kos_proto::discovery::Datagram;
use kos_proto::host as kos_host;
use lines::{Babble, SECOND, events};
use motion_core::session::{NotTaken, Session, Turn};
use motion_core::time::Millis;
use motion_core::wire::EncodeError;
use motion_io::tokio::{Driver, tcp};
use tokio::io::{DuplexStream, duplex};
use tokio::time::{Instant, sleep};

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
async fn the_end_of_a_time_without_events_is_no_error() {
    let (near, _far) = duplex(64);
    let session = hoot_proto::host::Session::new(hoot_proto::host::Options::default());
    let mut driver = Driver::new(session, near);
    assert!(driver.next_within(SECOND, &()).await.unwrap().is_some(), "the master is ready");
    let start = Instant::now();
    assert_eq!(driver.next_within(SECOND / 4, &()).await.unwrap(), None);
    assert!(start.elapsed() >= SECOND / 4 && start.elapsed() < SECOND / 3, "{:?}", start.elapsed());
}

/// Session that waits for bytes until a time, and takes all bytes.
#[derive(Default)]
struct Listener {
    until: Option<Millis>,
    has_heard: bool,
    was_late: bool,
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
    let (mut driver, start) = (Driver::new(Listener::default(), Babble { takes: true }), Instant::now());
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

#[tokio::test(start_paused = true)]
async fn bytes_for_others_are_given_to_a_function_also_without_a_line() {
    let (datagrams, told) = (Arc::new(Mutex::new(Vec::new())), Arc::default());
    let (sent, tell): (_, Arc<Mutex<Vec<_>>>) = (datagrams.clone(), Arc::clone(&told));
    let session: kos_host::Session = kos_host::Session::new(kos_host::Options::default().with_ask_every(Some(5_000)));
    let mut driver: Driver<_, DuplexStream> = Driver::unopened(session)
        .reconnecting(motion_io::Reconnect::default(), std::future::pending)
        .with_others(move |to, bytes| {
            tell.lock().unwrap().push(to);
            sent.lock().unwrap().push(bytes.to_vec());
        });
    let _ = events(&mut driver, &kos_host::Source::default(), 12 * SECOND, |_| None).await;
    let datagrams = datagrams.lock().unwrap();
    assert!((2..=3).contains(&datagrams.len()), "{datagrams:?}");
    assert!(
        datagrams.iter().all(|bytes| matches!(Datagram::decode(bytes), Ok(Datagram::Question(_)))),
        "{datagrams:?}"
    );
    assert!(told.lock().unwrap().iter().all(|to| *to == kos_host::Destination::Broadcast));
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
