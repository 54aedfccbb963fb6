//! Datagrams of a rig: announcements, questions and answers.

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use motion_core::time::Millis;
use rigs::faults::Faults;
use rigs::line::Line;
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
    up: Vec<Flight>,
    down: Vec<Flight>,
}

/// Datagram on the way from or to a peer.
struct Flight {
    peer: SocketAddr,
    line: Line,
}

impl Datagrams {
    pub(super) fn new(announcer: Announcer, seed: u64, door: mpsc::Sender<Event>) -> Self {
        let Announcer { socket, to, faults } = announcer;
        let socket = Arc::new(socket);
        tokio::spawn(hear(Arc::clone(&socket), door));
        // The seed differs from the seeds of the lines.
        Self { socket, to, faults, seed: seed ^ 1 << 63, up: Vec::new(), down: Vec::new() }
    }

    pub(super) fn wake(&self) -> Option<Millis> {
        self.up.iter().chain(&self.down).filter_map(|flight| flight.line.wake()).min()
    }

    /// Takes a datagram that a peer sent.
    pub(super) fn arrived(&mut self, now: Millis, from: SocketAddr, bytes: &[u8]) {
        let flight = self.flight(now, from, bytes);
        put(&mut self.up, flight);
    }

    /// Takes an announcement of the rig.
    pub(super) fn announce(&mut self, now: Millis, bytes: &[u8]) {
        self.answer(now, self.to, bytes);
    }

    /// Takes an answer of the rig for a peer.
    pub(super) fn answer(&mut self, now: Millis, to: SocketAddr, bytes: &[u8]) {
        let flight = self.flight(now, to, bytes);
        put(&mut self.down, flight);
    }

    /// Next datagram for the rig.
    pub(super) fn pop(&mut self, now: Millis) -> Option<(SocketAddr, Vec<u8>)> {
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

    fn flight(&mut self, now: Millis, peer: SocketAddr, bytes: &[u8]) -> Flight {
        self.seed = self.seed.wrapping_add(1);
        let mut line = Line::new(self.faults, self.seed);
        line.push(now, bytes);
        Flight { peer, line }
    }
}

fn put(flights: &mut Vec<Flight>, flight: Flight) {
    if flight.line.held() > 0 && flights.len() < ON_THE_WAY {
        flights.push(flight);
    }
}

fn pop(flights: &mut Vec<Flight>, now: Millis) -> Option<(SocketAddr, Vec<u8>)> {
    flights.retain(|flight| flight.line.held() > 0);
    flights.iter_mut().find_map(|flight| Some((flight.peer, flight.line.pop(now)?)))
}

/// Receives datagrams until the server has ended.
async fn hear(socket: Arc<UdpSocket>, door: mpsc::Sender<Event>) {
    let mut buffer = [0; 2048];
    loop {
        match socket.recv_from(&mut buffer).await {
            Ok((len, from)) => {
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
