//! Discovery of devices that announce themselves by datagrams.

use std::net::SocketAddr;
use std::time::Duration;

use kos_proto::discovery::{Announced, Event};
use motion_io::kos::Discovery;
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
    let mut discovery = Discovery::listen(listen).await?;
    if let Some(to) = ask {
        discovery.ask(to).await?;
    }
    let end = Instant::now() + time;
    while let Ok(event) = timeout_at(end, discovery.next()).await {
        match event {
            Event::Found(device) if !all => return Ok(vec![device]),
            event => debug!("{event:?}"),
        }
    }
    let found: Vec<Announced> = discovery.devices().copied().collect();
    if found.is_empty() {
        let seconds = time.as_secs_f32();
        return Err(Trouble::Line(format!(
            "{listen}: no kOS rig announced itself in {seconds} s: is it on, and is no other client connected to it?"
        )));
    }
    Ok(found)
}
