//! Datagrams of a rig: announcements, questions and answers.

use std::io;
use std::net::{IpAddr, SocketAddr, SocketAddrV4};
use std::sync::Arc;
use std::time::Duration;

use motion_core::time::Millis;
use motion_rigs::faults::Faults;
use motion_rigs::line::Line;
use tokio::net::UdpSocket;
use tokio::sync::mpsc;
use tokio::time::sleep;
use tracing::warn;

use super::Event;

/// Greatest number of datagrams on the way. Further ones are dropped.
const ON_THE_WAY: usize = 64;
/// Pause of reading after an error.
const PAUSE: Duration = Duration::from_millis(200);

/// Socket for datagrams, with the address for announcements.
#[derive(Debug)]
pub struct Announcer {
    socket: UdpSocket,
    to: SocketAddr,
    faults: Faults,
}

impl Announcer {
    /// Opens a socket that receives questions at `here` and sends announcements to `to`.
    ///
    /// # Errors
    ///
    /// Error of the operating system.
    pub async fn bind(here: SocketAddr, to: SocketAddr, faults: Faults) -> io::Result<Self> {
        let socket = UdpSocket::bind(here).await?;
        // Without this option the system refuses broadcast addresses. Other addresses do not need it.
        socket.set_broadcast(true)?;
        Ok(Self { socket, to, faults })
    }
}

/// Datagrams in both directions.
pub(super) struct Datagrams {
    socket: Arc<UdpSocket>,
    to: SocketAddr,
    faults: Faults,
    seed: u64,
    up: Vec<Flight<SocketAddrV4>>,
    down: Vec<Flight<SocketAddr>>,
}

/// Datagram on the way from or to a peer.
struct Flight<Peer> {
    peer: Peer,
    line: Line,
}

impl Datagrams {
    pub(super) fn new(announcer: Announcer, seed: u64, door: mpsc::Sender<Event>) -> Self {
        let Announcer { socket, to, faults } = announcer;
        let socket = Arc::new(socket);
        tokio::spawn(receive(Arc::clone(&socket), door));
        // The seed differs from the seeds of the lines.
        Self { socket, to, faults, seed: seed ^ 1 << 63, up: Vec::new(), down: Vec::new() }
    }

    pub(super) fn wake(&self) -> Option<Millis> {
        let (up, down) = (self.up.iter().map(|flight| &flight.line), self.down.iter().map(|flight| &flight.line));
        up.chain(down).filter_map(Line::wake).min()
    }

    /// Takes a datagram that a peer sent.
    pub(super) fn arrived(&mut self, now: Millis, from: SocketAddrV4, bytes: &[u8]) {
        let line = self.line(now, bytes);
        put(&mut self.up, Flight { peer: from, line });
    }

    /// Takes an announcement of the rig.
    pub(super) fn announce(&mut self, now: Millis, bytes: &[u8]) {
        self.put_down(now, self.to, bytes);
    }

    /// Takes a datagram of the rig for a peer.
    pub(super) fn answer(&mut self, now: Millis, to: SocketAddrV4, bytes: &[u8]) {
        let is_v6 = self.socket.local_addr().is_ok_and(|here| here.is_ipv6());
        let ip = if is_v6 { to.ip().to_ipv6_mapped().into() } else { IpAddr::from(*to.ip()) };
        self.put_down(now, SocketAddr::new(ip, to.port()), bytes);
    }

    fn put_down(&mut self, now: Millis, to: SocketAddr, bytes: &[u8]) {
        let line = self.line(now, bytes);
        put(&mut self.down, Flight { peer: to, line });
    }

    /// Next datagram for the rig.
    pub(super) fn pop(&mut self, now: Millis) -> Option<(SocketAddrV4, Vec<u8>)> {
        pop(&mut self.up, now)
    }

    /// Sends the datagrams that are due. A datagram that the system does not take at once is lost.
    pub(super) fn send(&mut self, now: Millis) {
        while let Some((to, bytes)) = pop(&mut self.down, now) {
            match self.socket.try_send_to(&bytes, to) {
                Err(error) if error.kind() != io::ErrorKind::WouldBlock => warn!("datagram to {to}: {error}"),
                _ => {}
            }
        }
    }

    /// Line of a new datagram, which has faults of its own.
    fn line(&mut self, now: Millis, bytes: &[u8]) -> Line {
        self.seed = self.seed.wrapping_add(1);
        let mut line = Line::new(self.faults, self.seed);
        line.push(now, bytes);
        line
    }
}

fn put<Peer>(flights: &mut Vec<Flight<Peer>>, flight: Flight<Peer>) {
    if flight.line.held() > 0 && flights.len() < ON_THE_WAY {
        flights.push(flight);
    }
}

fn pop<Peer: Copy>(flights: &mut Vec<Flight<Peer>>, now: Millis) -> Option<(Peer, Vec<u8>)> {
    flights.retain(|flight| flight.line.held() > 0);
    flights.iter_mut().find_map(|flight| Some((flight.peer, flight.line.pop(now)?)))
}

/// Receives datagrams until the server has ended. Peers have addresses of IPv4, as the protocol has no others.
async fn receive(socket: Arc<UdpSocket>, door: mpsc::Sender<Event>) {
    let mut buffer = [0; 2048];
    loop {
        match socket.recv_from(&mut buffer).await {
            Ok((len, from)) => {
                let IpAddr::V4(ip) = from.ip().to_canonical() else { continue };
                let from = SocketAddrV4::new(ip, from.port());
                let bytes = buffer.get(..len).unwrap_or_default().to_vec();
                if door.send(Event::Datagram { from, bytes }).await.is_err() {
                    return;
                }
            }
            // For example, a datagram was sent to an address without a listener.
            Err(_) => sleep(PAUSE).await,
        }
    }
}
