//! Whole host of kOS on tokio: it turns motor 1 by two rotations. Ctrl-C stops everything.
//!
//! ```console
//! cargo run -p moco -- simulate kos
//! cargo run -p moco --example kos_host -- 127.0.0.1:5520
//! ```

use kos_proto::host::{Endpoint, Event, Go, Options, Outcome, Session, Source, StopTarget, Token};
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
    let mut is_stopping = false;
    loop {
        tokio::select! {
            _ = &mut ctrl_c, if !is_stopping => {
                is_stopping = true;
                driver.session_mut().stop(Token(3))?;
            }
            event = driver.next(&source) => match event? {
                Event::Ready { reconnected: false, .. } => driver.session_mut().bump(Token(2), go)?,
                Event::MotorRests(MotorAddress(1), at) if !is_stopping => break println!("motor 1 rests at {at}"),
                Event::Stopped(StopTarget::All) => break println!("the stop is confirmed"),
                Event::StopNotConfirmed(_) => return Err("the stop is not confirmed: use the emergency stop".into()),
                Event::Ended { token: Token(2), outcome } if outcome != Outcome::Done(None) && !is_stopping => {
                    return Err(outcome.to_string().into());
                }
                event => println!("{event}"),
            },
        }
    }
    Ok(())
}
