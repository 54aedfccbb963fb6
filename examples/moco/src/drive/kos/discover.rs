//! Discovery of devices that announce themselves by datagrams.

use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use kos_proto::discovery::{Announced, Datagram, Devices, Event, Input};
use motion_core::time::Millis;
use tokio::net::UdpSocket;
use tokio::time::{Instant, timeout_at};
use tracing::debug;

use crate::drive::Trouble;

/// Listens at an address until a device announces itself, or with `all` until the time is over. With `ask`, first sends
/// a question to that address.
///
/// # Errors
///
/// [`Trouble::Line`] if the address cannot be used, or if no device announced itself.
pub async fn discover(
    listen: SocketAddr,
    ask: Option<SocketAddr>,
    time: Duration,
    all: bool,
) -> Result<Vec<Announced>, Trouble> {
    let failed = |error: &dyn std::fmt::Display| {
        Trouble::Line(format!("{listen}: {error}: give an address of this computer, and a port that is not in use"))
    };
    let socket = UdpSocket::bind(listen).await.map_err(|error| failed(&error))?;
    if let Some(to) = ask {
        let question = Datagram::question(false);
        let mut bytes = vec![0; question.encoded_len()];
        question.encode_into(&mut bytes).map_err(|error| failed(&error))?;
        socket.set_broadcast(true).map_err(|error| failed(&error))?;
        let sent = socket.send_to(&bytes, to).await;
        sent.map_err(|error| Trouble::Line(format!("{to}: {error}: a question cannot be sent there")))?;
    }
    let (start, mut devices, mut buffer) = (Instant::now(), Devices::<16>::default(), [0; 2048]);
    while let Ok(received) = timeout_at(start + time, socket.recv_from(&mut buffer)).await {
        // An error is about a datagram that was sent to an address without a listener.
        let Ok((len, from)) = received else { continue };
        let IpAddr::V4(source) = from.ip().to_canonical() else { continue };
        let now = Millis(u64::try_from(start.elapsed().as_millis()).unwrap_or(u64::MAX));
        let input = Input::Datagram { source: source.into(), bytes: &buffer[..len] };
        let (next, output) = devices.step(now, input);
        devices = next;
        match output.heard {
            Ok(Some(Event::Found(device))) if !all => return Ok(vec![device]),
            Ok(heard) => debug!("{heard:?}"),
            Err(why) => debug!("{from}: {why}"),
        }
    }
    let found: Vec<Announced> = devices.iter().copied().collect();
    if found.is_empty() {
        let seconds = time.as_secs_f32();
        return Err(Trouble::Line(format!(
            "{listen}: no kOS rig announced itself in {seconds} s: is it on, and is no other client connected to it?"
        )));
    }
    Ok(found)
}
