//! A driver whose futures are dropped at any time does the same as one that is left alone.

use std::future::pending;
use std::time::Duration;

use dmc_proto::message as dmc;
use hoot_proto::Address;
use hoot_proto::message as hoot;
use kos_proto::message as kos;
use motion_io::tokio::Driver;
use proptest::collection::vec;
use proptest::prelude::*;
use tokio::io::duplex;
use tokio::task::yield_now;
use tokio::time::sleep;

/// Times at which futures are dropped: 0 after the first poll, 1 after the second, more after some milliseconds.
struct Whims<'a>(std::iter::Cycle<std::iter::Skip<std::slice::Iter<'a, u64>>>);

impl<'a> Whims<'a> {
    fn new(drops: &'a [u64], first: usize) -> Self {
        Self(drops.iter().skip(first).cycle())
    }

    async fn next(&mut self) {
        match self.0.next() {
            None => pending().await,
            Some(0) => {}
            Some(1) => yield_now().await,
            Some(millis) => sleep(Duration::from_millis(*millis)).await,
        }
    }
}

/// Next event of a driver whose futures are dropped.
macro_rules! next {
    ($driver:expr, $source:expr, $whims:expr) => {
        loop {
            tokio::select! {
                biased;
                event = $driver.next($source) => break event.unwrap(),
                () = $whims.next() => yield_now().await,
            }
        }
    };
}

/// Events of host and device.
type Events = [Vec<String>; 2];

async fn kos(drops: &[u64], pipe: usize) -> Events {
    use kos_proto::device::{self, DeviceMachine, Report, SessionId};
    use kos_proto::host::{self, Endpoint, Get, Go, Token};

    let mut events = Events::default();
    let [host_events, device_events] = &mut events;
    let (near, far) = duplex(pipe);
    let host = async {
        let mut whims = Whims::new(drops, 0);
        let session: host::Session = host::Session::new(host::Options::default());
        let mut driver = Driver::new(session, near);
        driver.session_mut().connect(Token(1), Endpoint::Tcp(kos::Ipv4(0x7F00_0001))).unwrap();
        let (motor, position) = (kos::MotorAddress(1), kos::Rotations(2.0));
        let (speed, acceleration) = (kos::RotationsPerSecond(1.0), kos::RotationsPerSecondSquared(1.0));
        let (source, mut missing) = (host::Source::default(), 4);
        while missing > 0 {
            let event = next!(driver, &source, whims);
            host_events.push(format!("{event:?}"));
            match event {
                host::Event::Ready { .. } => {
                    let session = driver.session_mut();
                    session.bump(Token(2), Go { motor, position, speed, acceleration }).unwrap();
                    session.get(Token(3), Get::DeviceGuid).unwrap();
                    session.get(Token(4), Get::LedStatus).unwrap();
                }
                host::Event::Ended { token: Token(2..), .. } | host::Event::MotorRests(..) => missing -= 1,
                _ => {}
            }
        }
        assert!(!driver.session().may_move());
    };
    let device = async {
        let mut whims = Whims::new(drops, drops.len() / 2);
        let guid = vec![7; 9_000];
        let source = device::Source { guid: &guid, ..device::Source::default() };
        let machine = DeviceMachine::new(device::Options::default());
        let mut session: device::Session = device::Session::new(machine);
        session.report(Report::Started).unwrap();
        let mut driver = Driver::on_line(session, (SessionId(0), kos_proto::Transport::Tcp), far);
        loop {
            let event = next!(driver, &source, whims);
            device_events.push(format!("{event:?}"));
            if let device::Event::Move { motor, to, .. } = event {
                driver.session_mut().report(Report::Arrived(motor, to)).unwrap();
            }
        }
    };
    tokio::select! { biased; () = host => {}, () = device => {} }
    events
}

/// Rig at rest, and a move of two motors.
struct Tens;

impl dmc_proto::device::Rig for Tens {
    fn verdict(&self, _: &dmc::HostMessage<'_>) -> dmc::AckCode {
        dmc::AckCode::OK
    }

    fn position(&self, motor: dmc::Motor) -> dmc::Steps {
        dmc::Steps(10 * i32::from(motor.0))
    }
}

impl dmc_proto::upload::MoveSource for Tens {
    fn start_frame(&self) -> dmc::FrameNumber {
        dmc::FrameNumber(1)
    }

    fn frame_count(&self) -> u32 {
        600
    }

    fn motors(&self) -> dmc::Motors {
        dmc::Motors(3)
    }

    fn position(&self, motor: dmc::Motor, index: u32) -> dmc::Steps {
        dmc::Steps(i32::from(motor.0) * i32::try_from(index).unwrap())
    }
}

async fn dmc(drops: &[u64], pipe: usize) -> Events {
    use dmc_proto::device::{self, DeviceMachine};
    use dmc_proto::host::{self, Token};

    let mut events = Events::default();
    let [host_events, device_events] = &mut events;
    let (near, far) = duplex(pipe);
    let host = async {
        let mut whims = Whims::new(drops, 0);
        let session: host::Session = host::Session::new(host::Options::default());
        let mut driver = Driver::new(session, near);
        let motor = dmc::Motor(1);
        let mut missing = 3;
        while missing > 0 {
            let event = next!(driver, &Tens, whims);
            host_events.push(format!("{event:?}"));
            match event {
                host::Event::Greeted(_) => driver.session_mut().configured(Token(1)).unwrap(),
                host::Event::Ready { .. } => {
                    let flags = dmc::MotorFlags::ENABLED;
                    driver.session_mut().request(Token(2), dmc::MotorConfigure { motor, flags, tail: &[] }).unwrap();
                }
                host::Event::Ended { token: Token(2), .. } => {
                    missing -= 1;
                    let (start_frame, end_frame) = (dmc::FrameNumber(1), dmc::FrameNumber(600));
                    let begin = dmc::RtUploadMoveBegin { start_frame, end_frame, tail: &[] };
                    driver.session_mut().sequence(Token(3), begin).unwrap();
                }
                host::Event::Ended { token: Token(3), .. } => {
                    missing -= 1;
                    let position = dmc::Steps(2_000);
                    driver.session_mut().request(Token(4), dmc::MotorMove { motor, position, tail: &[] }).unwrap();
                }
                host::Event::Ended { token: Token(4), .. } => missing -= 1,
                _ => {}
            }
        }
    };
    let device = async {
        let mut whims = Whims::new(drops, drops.len() / 2);
        let hi = device::Options::default().hi();
        let capabilities = dmc::Capabilities(0x07FF);
        let hi = dmc::Hi { motor_count: 4, upload_frame_count: 1_000, capabilities, ..hi };
        let machine = DeviceMachine::new(device::Options::of(hi));
        let mut driver = Driver::new(<device::Session>::new(machine, dmc_proto::Patience::default()), far);
        loop {
            let event = next!(driver, &Tens, whims);
            device_events.push(format!("{event:?}"));
            match event {
                device::Event::Store { store, .. } => driver.session_mut().stored(store, dmc::AckCode::OK).unwrap(),
                device::Event::Move(..) => {
                    driver.session_mut().moving(dmc::Motors(1)).unwrap();
                    driver.session_mut().at_rest().unwrap();
                }
                _ => {}
            }
        }
    };
    tokio::select! { biased; () = host => {}, () = device => {} }
    events
}

async fn hoot(drops: &[u64], pipe: usize) -> Events {
    use hoot_proto::device::{self, DeviceMachine, Port};
    use hoot_proto::host::{self, Token};

    let mut events = Events::default();
    let [host_events, device_events] = &mut events;
    let (near, far) = duplex(pipe);
    let host = async {
        let mut whims = Whims::new(drops, 0);
        let mut driver = Driver::new(host::Session::new(host::Options::default()), near);
        let motor = hoot::Motor::One;
        let mut missing = 7;
        while missing > 0 {
            let event = next!(driver, &(), whims);
            host_events.push(format!("{event:?}"));
            match event {
                host::Event::Ready { .. } => {
                    for token in 0..7 {
                        driver
                            .session_mut()
                            .request(Token(token), Address::DEFAULT, hoot::MotorPosition { motor }.into())
                            .unwrap();
                    }
                }
                host::Event::Ended { .. } => missing -= 1,
                _ => {}
            }
        }
    };
    let device = async {
        let mut whims = Whims::new(drops, drops.len() / 2);
        let mut session = <device::Session>::new(DeviceMachine::new(device::Options::new()));
        session.position(hoot::Motor::One, hoot::Steps(-5)).unwrap();
        let mut driver = Driver::on_line(session, Port::Usb, far);
        loop {
            let event = next!(driver, &(), whims);
            device_events.push(format!("{event:?}"));
        }
    };
    tokio::select! { biased; () = host => {}, () = device => {} }
    events
}

/// Events of a run on a virtual clock, on a thread with room for the sessions of kOS.
fn run(events: impl AsyncFnOnce() -> Events + Send) -> Events {
    let run = || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().start_paused(true).build();
        let limited = async { tokio::time::timeout(Duration::from_secs(600), events()).await };
        runtime.unwrap().block_on(limited).expect("an end in ten minutes of virtual time")
    };
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(32 << 20).spawn_scoped(scope, run);
        thread.unwrap().join().unwrap()
    })
}

/// Drops, and the size of the pipe between the drivers.
fn schedules() -> impl Strategy<Value = (Vec<u64>, usize)> {
    let drop = prop_oneof![4 => Just(0), 4 => Just(1), 1 => 2..5_u64, 1 => Just(3_000)];
    // Time passes only while all wait.
    let drops = vec(drop, 1..30).prop_map(|drops| [&drops[..], &[3]].concat());
    (drops, prop_oneof![3 => 1..20_usize, 1 => Just(4_096)])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn drops_change_nothing_in_kos((drops, pipe) in schedules()) {
        prop_assert_eq!(run(async || Box::pin(kos(&drops, pipe)).await), run(async || Box::pin(kos(&[], 4_096)).await));
    }

    #[test]
    fn drops_change_nothing_in_dmc((drops, pipe) in schedules()) {
        prop_assert_eq!(run(async || Box::pin(dmc(&drops, pipe)).await), run(async || Box::pin(dmc(&[], 4_096)).await));
    }

    #[test]
    fn drops_change_nothing_in_hoot((drops, pipe) in schedules()) {
        prop_assert_eq!(run(async || Box::pin(hoot(&drops, pipe)).await), run(async || Box::pin(hoot(&[], 4_096)).await));
    }
}

#[test]
fn the_undisturbed_runs_are_what_they_should_be() {
    let [host, device] = run(async || Box::pin(kos(&[], 4_096)).await);
    assert!(host.iter().any(|event| event.contains("DeviceGUID")), "{host:#?}");
    assert!(device.iter().any(|event| event.starts_with("Move")), "{device:#?}");
    let [host, device] = run(async || Box::pin(dmc(&[], 4_096)).await);
    assert!(host.iter().any(|event| event.contains("Greeted")), "{host:#?}");
    assert!(device.iter().filter(|event| event.starts_with("Store")).count() > 4, "{host:#?} {device:#?}");
    let [host, _] = run(async || Box::pin(hoot(&[], 4_096)).await);
    assert!(host.iter().filter(|event| event.contains("255, 255, 255, 251")).count() == 7, "{host:#?}");
}
