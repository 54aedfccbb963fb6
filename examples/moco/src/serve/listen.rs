//! Listener for clients over TCP.

use std::time::Duration;

use motion_rigs::faults::Carrier;
use tokio::net::TcpListener;
use tokio::time::sleep;
use tracing::warn;

use super::Door;

/// Pause after a client that could not be accepted, for example because there are no more file handles.
const PAUSE: Duration = Duration::from_millis(200);

/// Accepts clients until the server has ended.
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
                    warn!("no client can be accepted: {error}");
                }
                could = false;
                sleep(PAUSE).await;
            }
        }
    }
}
