//! Host and device on the driver for firmware, over a line that takes and gives small pieces.

use std::convert::Infallible;
use std::time::Duration;

use dmc_proto::device::{self, DeviceMachine};
use dmc_proto::host;
use dmc_proto::message as dmc;
use dmc_proto::upload::NoMove;
use embedded_io_async::{ErrorType, Read, Write};
use motion_core::time::Millis;
use motion_io::embedded::{Clock, Driver, Error};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream, duplex};
use tokio::time::{Instant, sleep_until, timeout};

/// Line that takes at most 5 bytes and gives at most 3 at once.
struct Line(DuplexStream);

impl ErrorType for Line {
    type Error = Infallible;
}

impl Read for Line {
    async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        let len = bytes.len().min(3);
        Ok(self.0.read(&mut bytes[..len]).await.unwrap())
    }
}

impl Write for Line {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        Ok(self.0.write(&bytes[..bytes.len().min(5)]).await.unwrap_or_default())
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

struct Time(Instant);

impl Clock for Time {
    fn now(&self) -> Millis {
        Millis(u64::try_from(self.0.elapsed().as_millis()).unwrap())
    }

    async fn until(&self, moment: Millis) {
        sleep_until(self.0 + Duration::from_millis(moment.0)).await;
    }
}

struct Still;

impl device::Rig for Still {
    fn verdict(&self, _: &dmc::HostMessage<'_>) -> dmc::AckCode {
        dmc::AckCode::OK
    }

    fn position(&self, _: dmc::Motor) -> dmc::Steps {
        dmc::Steps(0)
    }
}

fn rig(line: DuplexStream) -> Driver<device::Session, Line, Time> {
    let hi = dmc::Hi { motor_count: 4, ..device::Options::default().hi() };
    let session = <device::Session>::new(DeviceMachine::new(device::Options::of(hi)), dmc_proto::Patience::default());
    Driver::new(session, Line(line), Time(Instant::now()))
}

/// Drives a device, with futures that are dropped every 7 ms, until the line is closed.
async fn serve(mut driver: Driver<device::Session, Line, Time>) -> Vec<String> {
    let mut events = Vec::new();
    loop {
        let is_move = match timeout(Duration::from_millis(7), driver.next(&Still)).await {
            Ok(Ok(event)) => {
                events.push(format!("{event:?}"));
                matches!(event, device::Event::Move(..))
            }
            Ok(Err(error)) => {
                assert_eq!(error, Error::Closed);
                return events;
            }
            Err(_) => false,
        };
        if is_move {
            driver.session_mut().moving(dmc::Motors(1)).unwrap();
            driver.session_mut().at_rest().unwrap();
        }
    }
}

async fn control(driver: &mut Driver<host::Session, Line, Time>) -> Result<(), Error<Infallible>> {
    let motor = dmc::Motor(1);
    let is_done = |event: &host::Event<'_>| matches!(event, host::Event::Ended { token: host::Token(3), .. });
    loop {
        match driver.next(&NoMove).await? {
            host::Event::Greeted(_) => driver.session_mut().configured(host::Token(1)).unwrap(),
            host::Event::Ready { .. } => {
                let flags = dmc::MotorFlags::ENABLED;
                let configure = dmc::MotorConfigure { motor, flags, tail: &[] };
                driver.session_mut().request(host::Token(2), configure).unwrap();
            }
            host::Event::Ended { token: host::Token(2), .. } => {
                let position = dmc::Steps(2_000);
                driver.session_mut().request(host::Token(3), dmc::MotorMove { motor, position, tail: &[] }).unwrap();
            }
            event if is_done(&event) => return Ok(()),
            _ => {}
        }
    }
}

#[tokio::test(start_paused = true)]
async fn a_host_and_a_device_move_a_motor_and_the_line_can_be_replaced() {
    let (near, far) = duplex(512);
    let serving = tokio::spawn(serve(rig(far)));
    let session: host::Session = host::Session::new(host::Options::default());
    let mut driver: Driver<_, _, _> = Driver::new(session, Line(near), Time(Instant::now()));
    control(&mut driver).await.unwrap();

    // A line that is not there: its other end is gone.
    let (dead, _) = duplex(512);
    driver.replace(Line(dead));
    let events = serving.await.unwrap();
    assert!(events.iter().any(|event| event.starts_with("Move(")), "{events:#?}");
    let error = loop {
        if let Err(error) = driver.next(&NoMove).await {
            break error;
        }
    };
    assert_eq!(error, Error::Closed);

    let (near, far) = duplex(512);
    let serving = tokio::spawn(serve(rig(far)));
    driver.replace(Line(near));
    control(&mut driver).await.unwrap();
    drop(driver);
    assert!(serving.await.unwrap().iter().any(|event| event.starts_with("Move(")));
}

#[tokio::test(start_paused = true)]
async fn a_message_that_is_longer_than_the_buffer_is_told() {
    let (near, _far) = duplex(512);
    let session: host::Session = host::Session::new(host::Options::default());
    let mut driver: Driver<_, _, _, 4> = Driver::new(session, Line(near), Time(Instant::now()));
    let error = driver.next(&NoMove).await.unwrap_err();
    assert!(error.to_string().contains("need"), "{error}");
}
