//! Clients that come over TCP.

use std::time::Duration;

use rigs::faults::Carrier;
use tokio::net::TcpListener;
use tokio::time::sleep;
use tracing::warn;

use super::Door;

/// How long nobody is let in after one could not be: who has no more file handles has none a moment later.
const PAUSE: Duration = Duration::from_millis(200);

/// Lets clients in until nobody serves any more.
pub async fn listen(listener: TcpListener, door: Door) {
    let mut could = true;
    loop {
        let came = listener.accept().await;
        match came {
            Ok((stream, address)) => {
                could = true;
                if let Err(error) = stream.set_nodelay(true) {
                    warn!("{address}: {error}");
                    continue;
                }
                if door.enter(&address.to_string(), Carrier::Stream, stream).await.is_none() {
                    return;
                }
            }
            Err(error) => {
                if could {
                    warn!("nobody can be let in: {error}");
                }
                could = false;
                sleep(PAUSE).await;
            }
        }
    }
}
