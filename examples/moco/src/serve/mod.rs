//! Server of a rig on real lines, in real time.
//!
//! One [`Server`] owns the rig, and only the server calls it. A task for each line carries its bytes. Received bytes
//! wait at the [`Door`] until the server has room for them, so that a flood costs no memory. A client that does not
//! read is cut off when [`PATIENCE`] bytes wait for it. A client that is cut off, disconnects or causes an error does
//! not disturb the other clients.

mod datagrams;
mod link;
mod listen;
#[cfg(unix)]
mod pty;
mod record;

use std::net::SocketAddrV4;
use std::time::Duration;

use motion_core::time::Millis;
use motion_rigs::faults::{Carrier, Faults, Mishap, Mishaps};
use motion_rigs::line::Line;
use motion_rigs::{LineId, Outgoing, Rig};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::{mpsc, oneshot};
use tokio::task::yield_now;
use tokio::time::{Instant, sleep_until};
use tracing::{info, warn};

pub use datagrams::Announcer;
pub use listen::listen;
#[cfg(unix)]
pub use pty::Pty;
pub use record::Record;

use datagrams::Datagrams;
use link::Link;

/// Number of bytes that may wait for a client to read them.
pub const PATIENCE: usize = 256 * 1024;
/// Number of bytes on the way to the rig at which reading pauses.
const ROOM: usize = 64 * 1024;
/// Time for which a serial line is dead after a reset, in milliseconds.
const REOPEN: u64 = 5;
/// Number of events that may wait at the door of the server.
const DOOR: usize = 16;

/// Options of a server.
#[derive(Debug, Default)]
pub struct Options {
    /// Faults of the lines and of the rig. The [`Announcer`] has the faults of the datagrams.
    pub faults: Faults,
    /// Seed of everything that is random.
    pub seed: u64,
    /// Record of the motion of the motors.
    pub record: Option<Record>,
    /// Socket for the datagrams.
    pub announcer: Option<Announcer>,
}

/// Entry of the server, through which clients come.
#[derive(Debug, Clone)]
pub struct Door(mpsc::Sender<Event>);

/// Stream that carries the bytes of a client.
pub trait Stream: AsyncRead + AsyncWrite + Send + Unpin {}
impl<T: AsyncRead + AsyncWrite + Send + Unpin> Stream for T {}

impl Door {
    /// Brings a client to the server. The line of the client is free again when the returned receiver ends. `None` if
    /// the server has ended.
    ///
    /// A TCP connection ends when the rig is reset. Other lines stay.
    pub async fn enter(
        &self,
        name: &str,
        carrier: Carrier,
        stream: impl Stream + 'static,
    ) -> Option<oneshot::Receiver<()>> {
        let (here, end) = oneshot::channel();
        let came = Event::Came(Came { name: name.to_owned(), carrier, stream: Box::new(stream), here });
        self.0.send(came).await.ok()?;
        Some(end)
    }
}

/// New client.
struct Came {
    name: String,
    carrier: Carrier,
    stream: Box<dyn Stream>,
    /// Sender that is dropped when the line of the client is free again.
    here: oneshot::Sender<()>,
}

/// Event for the server.
enum Event {
    Came(Came),
    Piece { client: u64, bytes: Vec<u8> },
    Gone { client: u64, why: String },
    Datagram { from: SocketAddrV4, bytes: Vec<u8> },
}

/// Server of a rig, with its lines and the clock of the computer.
pub struct Server<R> {
    rig: R,
    faults: Faults,
    seed: u64,
    start: Instant,
    mishaps: Mishaps,
    /// Client of each line.
    links: Vec<Option<Link>>,
    /// Number of clients so far.
    clients: u64,
    record: Option<Record>,
    datagrams: Option<Datagrams>,
    door: mpsc::Sender<Event>,
    events: mpsc::Receiver<Event>,
}

impl<R: Rig> Server<R> {
    /// Makes a server and its door. The clock of the rig starts now.
    #[must_use]
    pub fn new(rig: R, options: Options) -> (Self, Door) {
        let Options { faults, seed, record, announcer } = options;
        let (door, events) = mpsc::channel(DOOR);
        let datagrams = announcer.map(|announcer| Datagrams::new(announcer, seed, door.clone()));
        let server = Self {
            rig,
            faults,
            seed,
            start: Instant::now(),
            mishaps: Mishaps::new(faults, seed, Millis(0)),
            links: (0..R::LINES).map(|_| None).collect(),
            clients: 0,
            record,
            datagrams,
            door: door.clone(),
            events,
        };
        (server, Door(door))
    }

    /// Serves until `stop` is ready. Returns the rig.
    pub async fn run(mut self, stop: impl Future<Output = ()>) -> R {
        tokio::pin!(stop);
        loop {
            self.work();
            let wake = self.wake().map(|wake| self.start + Duration::from_millis(wake.0));
            tokio::select! {
                biased;
                () = &mut stop => break,
                Some(event) = self.events.recv() => self.event(event),
                () = due(wake.unwrap_or_else(far)) => {}
            }
        }
        if let Some(record) = &mut self.record {
            record.flush();
        }
        self.rig
    }

    fn now(&self) -> Millis {
        Millis(u64::try_from(self.start.elapsed().as_millis()).unwrap_or(u64::MAX))
    }

    fn wake(&self) -> Option<Millis> {
        let own = [self.rig.wake(), self.mishaps.wake(), self.record.as_ref().and_then(Record::wake)];
        let datagrams = self.datagrams.as_ref().and_then(Datagrams::wake);
        own.into_iter().chain([datagrams]).chain(self.links.iter().flatten().map(Link::wake)).flatten().min()
    }

    fn event(&mut self, event: Event) {
        let now = self.now();
        match event {
            Event::Came(came) => self.came(now, came),
            Event::Piece { client, bytes } => {
                if let Some((_, link)) = self.find(client) {
                    link.arrived(now, &bytes);
                }
            }
            Event::Gone { client, why } => {
                if let Some((_, link)) = self.find(client) {
                    link.leave(why);
                }
            }
            Event::Datagram { from, bytes } => {
                if let Some(datagrams) = &mut self.datagrams {
                    datagrams.arrived(now, from, &bytes);
                }
            }
        }
    }

    fn find(&mut self, client: u64) -> Option<(LineId, &mut Link)> {
        let links = (0..).map(LineId).zip(&mut self.links);
        links.filter_map(|(line, link)| Some((line, link.as_mut()?))).find(|(_, link)| link.client == client)
    }

    fn came(&mut self, now: Millis, came: Came) {
        // A client that is gone gives its line to the new client, even if some of its bytes have not arrived.
        let places = [Option::is_none, |link: &Option<Link>| link.as_ref().is_some_and(Link::is_gone)];
        let Some(index) = places.into_iter().find_map(|is_free| self.links.iter().position(is_free)) else {
            warn!("{} is rejected: there are already {} clients", came.name, R::LINES);
            return;
        };
        let Some(line) = (0..).map(LineId).nth(index) else { return };
        if self.links[index].take().is_some() {
            self.rig.close(now, line);
        }
        self.clients += 1;
        let seed = self.seed.wrapping_add(2 * self.clients);
        let lines = (Line::new(self.faults, seed), Line::new(self.faults, seed.wrapping_add(1)));
        info!("{} is connected", came.name);
        self.links[index] = Some(Link::new(self.clients, came, lines, self.door.clone()));
        self.rig.open(now, line);
        self.settle(now);
    }

    /// Does everything that is due.
    fn work(&mut self) {
        let now = self.now();
        self.rig.advance(now);
        while let Some(mishap) = self.mishaps.next(now) {
            self.mishap(now, mishap);
        }
        self.settle(now);
        while let Some((from, bytes)) = self.datagrams.as_mut().and_then(|datagrams| datagrams.pop(now)) {
            self.rig.datagram(now, from, &bytes);
            self.settle(now);
        }
        for index in 0..R::LINES {
            self.carry(now, LineId(index));
        }
        if let Some(datagrams) = &mut self.datagrams {
            datagrams.send(now);
        }
        if let Some(record) = &mut self.record {
            record.look(now, self.rig.motors(), self.rig.moment());
        }
    }

    fn mishap(&mut self, now: Millis, mishap: Mishap) {
        match mishap {
            Mishap::Silence(millis) => {
                info!("fault: the rig receives and sends nothing for {millis} ms");
                self.links.iter_mut().flatten().for_each(|link| link.hold(now.after(millis)));
            }
            Mishap::Reset => {
                warn!("fault: the rig is reset");
                self.rig.reset(now);
                for index in 0..R::LINES {
                    self.cut(now, LineId(index));
                }
            }
            Mishap::Stall => {
                warn!("fault: a motor gets stuck");
                self.rig.stall(now);
            }
        }
    }

    /// Cuts off a line, as a reset does: a connection ends, and a serial line is dead for a moment.
    fn cut(&mut self, now: Millis, at: LineId) {
        let Some(slot) = self.links.get_mut(usize::from(at.0)) else { return };
        let Some(link) = slot else { return };
        if link.carrier == Carrier::Stream {
            info!("{} is cut off", link.name);
            link.abort();
            *slot = None;
        } else {
            self.clients += 1;
            let seed = self.seed.wrapping_add(2 * self.clients);
            let lines = (Line::new(self.faults, seed), Line::new(self.faults, seed.wrapping_add(1)));
            link.restart(now.after(REOPEN), lines);
        }
        self.rig.close(now, at);
    }

    /// Gives received bytes of a line to the rig, and writes the bytes that are due.
    fn carry(&mut self, now: Millis, at: LineId) {
        let index = usize::from(at.0);
        if self.links[index].as_mut().is_some_and(|link| link.opens(now)) {
            self.rig.open(now, at);
            self.settle(now);
        }
        while let Some(bytes) = self.links[index].as_mut().and_then(|link| link.up.pop(now)) {
            self.rig.receive(now, at, &bytes);
            self.settle(now);
        }
        let Some(link) = &mut self.links[index] else { return };
        if let Err(why) = link.carry(now) {
            info!("{}: {why}", link.name);
            link.abort();
            self.links[index] = None;
        } else if let Some(why) = link.left() {
            info!("{}: {why}", link.name);
            // A client of a stream that sends no more may still read. At the end of a serial line nobody is left.
            let link = self.links[index].take();
            let end = |link: Link| if link.carrier == Carrier::Stream { link.finish() } else { link.abort() };
            link.into_iter().for_each(end);
        } else {
            return;
        }
        self.rig.close(now, at);
        self.settle(now);
    }

    /// Executes the output of the rig.
    fn settle(&mut self, now: Millis) {
        while let Some(outgoing) = self.rig.poll() {
            match outgoing {
                Outgoing::Bytes(line, bytes) => {
                    if let Some(Some(link)) = self.links.get_mut(usize::from(line.0)) {
                        link.send(now, &bytes);
                    }
                }
                Outgoing::HangUp(line) => {
                    if let Some(link) = self.links.get_mut(usize::from(line.0)).and_then(Option::take) {
                        info!("{}: the rig closes the line", link.name);
                        link.finish();
                        self.rig.close(now, line);
                    }
                }
                Outgoing::Announce(bytes) => {
                    if let Some(datagrams) = &mut self.datagrams {
                        datagrams.announce(now, &bytes);
                    }
                }
                Outgoing::Datagram(to, bytes) => {
                    if let Some(datagrams) = &mut self.datagrams {
                        datagrams.answer(now, to, &bytes);
                    }
                }
                // A rig opens no lines.
                Outgoing::Open(_) => {}
            }
        }
    }
}

/// Waits until a moment, and until everything that has arrived by then is handled. Otherwise a busy computer could
/// miss bytes that arrived in time.
async fn due(moment: Instant) {
    sleep_until(moment).await;
    yield_now().await;
}

/// Moment of the next look if nothing is due.
fn far() -> Instant {
    Instant::now() + Duration::from_hours(1)
}
