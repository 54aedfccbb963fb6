//! Sockets of kOS: discovery of devices, the broadcasts of a client, and the [`Server`] of a device.
//!
//! A program that prints the devices of the network as they are found:
//!
//! ```no_run
//! use motion_io::kos::Discovery;
//!
//! # #[tokio::main(flavor = "current_thread")]
//! # async fn main() -> Result<(), motion_io::Error> {
//! let mut discovery = Discovery::listen("0.0.0.0:5520").await?;
//! discovery.ask("255.255.255.255:5520").await?;
//! loop {
//!     println!("{}", discovery.next().await);
//! }
//! # }
//! ```
//!
//! A client asks by itself which devices are there if its options say so. Its datagrams go out with [`broadcasts`]:
//!
//! ```no_run
//! use kos_proto::host::{Options, Session};
//! use motion_io::tokio::{Driver, tcp};
//!
//! # #[tokio::main(flavor = "current_thread")]
//! # async fn main() -> Result<(), motion_io::Error> {
//! let session: Session = Session::new(Options::default().with_ask_every(Some(5_000)));
//! let socket = motion_io::kos::socket("0.0.0.0:0").await?;
//! let driver = Driver::new(session, tcp("192.168.50.1:5520").await?).with_others(motion_io::kos::broadcasts(socket));
//! # drop(driver);
//! # Ok(())
//! # }
//! ```
//!
//! Anyone on the network can send anything. A person should confirm a device that was found.

mod server;

use core::net::{IpAddr, Ipv4Addr};
use std::fmt;
use std::string::ToString;

use ::tokio::net::{ToSocketAddrs, UdpSocket};
use ::tokio::time::Instant;
use kos_proto::discovery::{Announced, DEFAULT_PORT, Datagram, DatagramError, Devices, Event, Input};
use kos_proto::host::Destination;

use crate::error::Error;
use crate::line::millis;
pub use server::Server;

/// Number of bytes of the longest datagram that is read whole. Announcements are much shorter, and longer datagrams are dropped.
const LONGEST: usize = 512;

/// Opens a socket for datagrams at this address of the computer, such as `0.0.0.0:5520`. It may broadcast.
///
/// # Errors
///
/// [`Error::NotOpened`].
pub async fn socket(here: impl ToSocketAddrs + fmt::Display) -> Result<UdpSocket, Error> {
    let name = here.to_string();
    let failed = |error: std::io::Error| Error::socket(&name, &error);
    let socket = UdpSocket::bind(here).await.map_err(failed)?;
    socket.set_broadcast(true).map_err(failed)?;
    Ok(socket)
}

/// Function for [`Driver::with_others`](crate::tokio::Driver::with_others) that broadcasts the datagrams of a client over this
/// socket. A datagram that cannot be sent at once is dropped, as the network may drop it.
pub fn broadcasts(socket: UdpSocket) -> impl FnMut(Destination, &[u8]) + Send + 'static {
    move |to, bytes| {
        if to == Destination::Broadcast {
            let _ = socket.try_send_to(bytes, (Ipv4Addr::BROADCAST, DEFAULT_PORT).into());
        }
    }
}

/// Devices that announce themselves in the network.
#[derive(Debug)]
pub struct Discovery {
    socket: UdpSocket,
    devices: Devices,
    start: Instant,
}

impl Discovery {
    /// Listens at this address of the computer, such as `0.0.0.0:5520`.
    ///
    /// # Errors
    ///
    /// [`Error::NotOpened`].
    pub async fn listen(here: impl ToSocketAddrs + fmt::Display) -> Result<Self, Error> {
        Ok(Self { socket: socket(here).await?, devices: Devices::default(), start: Instant::now() })
    }

    /// Asks the devices at this address, such as `255.255.255.255:5520`, to announce themselves to this program.
    ///
    /// # Errors
    ///
    /// [`Error::NotOpened`].
    pub async fn ask(&self, there: impl ToSocketAddrs + fmt::Display) -> Result<(), Error> {
        let (name, question, mut bytes) = (there.to_string(), Datagram::question(false), [0; 7]);
        let len = question.encode_into(&mut bytes).map_err(Error::Message)?;
        let sent = self.socket.send_to(bytes.get(..len).unwrap_or_default(), there).await;
        sent.map(|_| ()).map_err(|error| Error::socket(&name, &error))
    }

    /// Next news. Bad datagrams are dropped. The future can be dropped at any time.
    pub async fn next(&mut self) -> Event {
        let mut bytes = [0; LONGEST];
        loop {
            // An error is about a datagram that was sent to an address where nothing listens.
            let Ok((len, source)) = self.socket.recv_from(&mut bytes).await else { continue };
            let IpAddr::V4(source) = source.ip().to_canonical() else { continue };
            let bytes = bytes.get(..len).unwrap_or_default();
            if let Ok(Some(event)) = self.step(Input::Datagram { source: source.into(), bytes }) {
                return event;
            }
        }
    }

    /// Devices that were heard in the last 15 s, in the order in which they were found.
    pub fn devices(&mut self) -> impl Iterator<Item = &Announced> {
        let _ = self.step(Input::Wake);
        self.devices.iter()
    }

    fn step(&mut self, input: Input<'_>) -> Result<Option<Event>, DatagramError> {
        let (devices, output) = core::mem::take(&mut self.devices).step(millis(self.start.elapsed()), input);
        self.devices = devices;
        output.heard
    }
}
