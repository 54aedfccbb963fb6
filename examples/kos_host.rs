//! Whole host of kOS on tokio: it turns motor 1 by two rotations. Ctrl-C stops everything.
//!
//! ```console
//! cargo run -p moco -- simulate kos
//! cargo run -p moco --example kos_host -- 127.0.0.1:5520
//! ```

use kos_proto::host::{Endpoint, Event, Failure, Go, Options, Outcome, Session, Source, StopTarget, Token};
use kos_proto::message::{Ipv4, MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared};
use motion_io::Reconnect;
use motion_io::tokio::{Driver, tcp};

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Box<dyn std::error::Error>> {
    let address: std::net::SocketAddrV4 = std::env::args().nth(1).ok_or("usage: kos_host ADDRESS:PORT")?.parse()?;
    let mut driver = Driver::new(<Session>::new(Options::default()), tcp(address).await?)
        .reconnecting(Reconnect::default(), move || tcp(address));
    driver.session_mut().connect(Token(1), Endpoint::Tcp(Ipv4::from(*address.ip())))?;

    let (motor, position) = (MotorAddress(1), Rotations(2.0));
    let go = Go { motor, position, speed: RotationsPerSecond(1.0), acceleration: RotationsPerSecondSquared(1.0) };
    let (source, mut ctrl_c) = (Source::default(), std::pin::pin!(tokio::signal::ctrl_c()));
    // How the program ends after a stop.
    let mut end: Option<Result<(), Box<dyn std::error::Error>>> = None;
    loop {
        tokio::select! {
            _ = &mut ctrl_c, if end.is_none() => {
                end = Some(Ok(()));
                driver.session_mut().stop(Token(3))?;
            }
            event = driver.next(&source) => match event? {
                Event::Ready { reconnected: false, .. } => driver.session_mut().bump(Token(2), go)?,
                Event::Ended { token: Token(2), outcome: Outcome::Done(_) } if end.is_none() => {
                    println!("motor 1 rests at {position}");
                    return Ok(());
                }
                // Nobody knows whether the motor moves. If the line is lost, the driver opens it again, and stops first.
                Event::Ended { token: Token(2), outcome } if end.is_none() => {
                    end = Some(Err(outcome.to_string().into()));
                    if outcome != Outcome::Failed(Failure::LinkDown) {
                        driver.session_mut().stop(Token(3))?;
                    }
                }
                Event::Stopped(StopTarget::All) => {
                    println!("the stop is confirmed");
                    return end.unwrap_or(Ok(()));
                }
                Event::StopNotConfirmed(_) => return Err("the stop is not confirmed: use the emergency stop".into()),
                event => println!("{event}"),
            },
        }
    }
}
