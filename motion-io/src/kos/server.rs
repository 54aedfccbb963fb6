//! Server of a device.

use std::boxed::Box;
use std::collections::VecDeque;
use std::future::poll_fn;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, SocketAddrV4};
use std::pin::{Pin, pin};
use std::string::ToString;
use std::task::{Context, Poll};
use std::time::Duration;
use std::vec::Vec;
use std::{fmt, io, vec};

use ::tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use ::tokio::net::{TcpListener, TcpStream, UdpSocket};
use ::tokio::time::{Instant, sleep};
use kos_proto::Transport;
use kos_proto::device::{Destination, Event, SESSIONS, Sender, Session, SessionId, Source};
use kos_proto::discovery::DEFAULT_PORT;
use motion_core::session::{Session as _, Turn};
use motion_core::time::Millis;
use motion_core::wire::EncodeError;

use crate::error::Error;
use crate::flow::Buffer as _;
use crate::line::millis;
use crate::tokio::moment;
use crate::{LAST, STALLED};

/// Greatest number of bytes that wait for one client. A client that is further behind is cut off.
const MOST_UNSENT: usize = 0x2_0000;
/// Greatest number of datagrams that wait. Further ones are dropped.
const MOST_DATAGRAMS: usize = 16;
/// Time after which a socket with an error is tried again.
const AGAIN: Duration = Duration::from_millis(100);
/// Greatest number of bytes that are read at once.
const PIECE: usize = 4_096;

/// Session of a kOS device with its sockets: up to four clients over TCP, and discovery by UDP.
///
/// [`next`](Self::next) does everything. It can be dropped at any time, and called again: no byte is lost in either
/// direction.
///
/// A client that takes no byte for 2 s, or lets more than 128 kB wait, is cut off, as if it had closed its connection. A fifth
/// client is refused.
///
/// A device that does nothing and tells what it should do:
///
/// ```no_run
/// use std::net::{Ipv4Addr, SocketAddrV4};
///
/// use kos_proto::device::{DeviceMachine, Options, Report, Session, Source};
/// use kos_proto::discovery::DEFAULT_PORT;
/// use motion_io::kos::Server;
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let session: Session = Session::new(DeviceMachine::new(Options::default()));
/// let mut server = Server::bind(session, SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, DEFAULT_PORT)).await?;
/// server.session_mut().report(Report::Started)?;
/// loop {
///     println!("{:?}", server.next(&Source::default()).await?);
/// }
/// # }
/// ```
pub struct Server<const N: usize, const CAP: usize> {
    session: Box<Session<N, CAP>>,
    listener: TcpListener,
    socket: UdpSocket,
    announce_to: SocketAddr,
    clients: [Option<Client>; SESSIONS],
    /// Datagram that arrived.
    question: Option<(Sender, Vec<u8>)>,
    /// Datagrams to send.
    datagrams: VecDeque<(SocketAddr, Vec<u8>)>,
    out: Vec<u8>,
    piece: Vec<u8>,
    start: Instant,
}

impl<const N: usize, const CAP: usize> Server<N, CAP> {
    /// Listens at this address, by TCP and by UDP. The questions of clients are broadcasts, which arrive at the address
    /// [`UNSPECIFIED`](Ipv4Addr::UNSPECIFIED).
    ///
    /// Announcements are broadcasts to the port 5520.
    ///
    /// # Errors
    ///
    /// [`Error::NotOpened`].
    pub fn bind(session: Session<N, CAP>, here: SocketAddrV4) -> impl Future<Output = Result<Self, Error>> {
        // Sessions are long, and futures move.
        Self::listen(Box::new(session), here)
    }

    async fn listen(session: Box<Session<N, CAP>>, here: SocketAddrV4) -> Result<Self, Error> {
        let failed = |error: io::Error| Error::socket(&here.to_string(), &error);
        let listener = TcpListener::bind(here).await.map_err(failed)?;
        let socket = super::socket(listener.local_addr().map_err(failed)?).await?;
        Ok(Self {
            session,
            listener,
            socket,
            announce_to: SocketAddrV4::new(Ipv4Addr::BROADCAST, DEFAULT_PORT).into(),
            clients: [const { None }; SESSIONS],
            question: None,
            datagrams: VecDeque::new(),
            out: Vec::new(),
            piece: vec![0; PIECE],
            start: Instant::now(),
        })
    }

    /// Sends announcements to this address, such as the broadcast address of one network.
    #[must_use]
    pub fn announcing_to(mut self, to: SocketAddrV4) -> Self {
        self.announce_to = to.into();
        self
    }

    /// Address at which the server listens.
    ///
    /// # Errors
    ///
    /// The errors of the operating system.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Session, for reading its state.
    #[must_use]
    pub fn session(&self) -> &Session<N, CAP> {
        &self.session
    }

    /// Session, for reports and stops. They are obeyed in [`next`](Self::next).
    ///
    /// Only the server tells the session about its clients and their bytes.
    pub fn session_mut(&mut self) -> &mut Session<N, CAP> {
        &mut self.session
    }

    /// Time since the server was made, as the session is told.
    #[must_use]
    pub fn now(&self) -> Millis {
        millis(self.start.elapsed())
    }

    /// Next event of the session, with what `source` has for its messages. Reads, writes and waits until there is one.
    ///
    /// The future can be dropped at any time. Nothing is lost, and the next call goes on where it ended.
    ///
    /// # Errors
    ///
    /// [`Error::Message`] if a message cannot be written. Clients that are lost are no error.
    pub async fn next(&mut self, source: &Source<'_>) -> Result<Event<'_>, Error> {
        let held = loop {
            let now = self.now();
            match self.session.turn(now, source, &mut self.out) {
                Err(EncodeError::BufferTooSmall { needed, .. }) if self.out.grow(needed) => {}
                Err(error) => return Err(Error::Message(error)),
                Ok(Turn::Transmit(to, len)) => self.send(now, to, len),
                Ok(Turn::Event(held)) => break held,
                // News are told while no event waits. So each event is about the clients that there are.
                Ok(Turn::Wait(until)) => {
                    if !self.tell(now) {
                        self.wait(until).await;
                    }
                }
            }
        };
        for (id, slot) in SessionId::ALL.into_iter().zip(&mut self.clients) {
            if Session::<N, CAP>::request(&held, (id, Transport::Tcp)).is_some() {
                if let Some(Client { stream: Some(stream), unsent, .. }) = slot.take() {
                    // The last answer goes out if there is room for it.
                    let _ = stream.try_write(&unsent);
                }
            }
        }
        Ok(self.session.event(held))
    }

    /// Sends bytes from the front of the buffer, as soon as the sockets take them.
    fn send(&mut self, now: Millis, to: Destination, len: usize) {
        let bytes = self.out.get(..len).unwrap_or_default();
        let to = match to {
            Destination::Sessions(clients) => {
                for (id, client) in SessionId::ALL.into_iter().zip(&mut self.clients) {
                    if let Some(client) = client.as_mut().filter(|_| clients.contains(id)) {
                        client.send(now, bytes);
                    }
                }
                return;
            }
            Destination::Broadcast => self.announce_to,
            Destination::Datagram(sender) => SocketAddrV4::from(sender).into(),
        };
        if self.datagrams.len() < MOST_DATAGRAMS {
            self.datagrams.push_back((to, bytes.into()));
        }
    }

    /// Tells the session what happened. Returns false if nothing did.
    fn tell(&mut self, now: Millis) -> bool {
        if let Some((from, bytes)) = &self.question {
            if self.session.receive_datagram(now, *from, bytes) {
                self.question = None;
                return true;
            }
        }
        let mut is_told = false;
        for (id, slot) in SessionId::ALL.into_iter().zip(&mut self.clients) {
            let Some(client) = slot else { continue };
            if !client.is_known {
                client.is_known = self.session.link_up(id, Transport::Tcp).is_ok();
                is_told |= client.is_known;
            } else if !client.arrived.is_empty() {
                let taken = self.session.receive(now, id, &client.arrived);
                client.arrived.drain(..taken);
                is_told |= taken > 0;
            } else if client.stream.is_none() && self.session.link_down(id).is_ok() {
                *slot = None;
                is_told = true;
            }
        }
        is_told
    }

    /// Waits until something happens, at most until this time.
    async fn wait(&mut self, until: Option<Millis>) {
        let cuts = self.clients.iter().flatten().filter_map(|client| client.cut_off);
        let until = until.into_iter().chain(cuts).min();
        let end = until.and_then(|until| self.start.checked_add(Duration::from_millis(until.0)));
        let (mut end, mut again) = (pin!(moment(end)), pin!(sleep(AGAIN)));
        poll_fn(|cx| match self.poll(cx) {
            Ok(true) => Poll::Ready(()),
            Err(_) if again.as_mut().poll(cx).is_ready() => Poll::Ready(()),
            Ok(false) | Err(_) => end.as_mut().poll(cx),
        })
        .await;
        let now = self.now();
        for client in self.clients.iter_mut().flatten().filter(|client| client.cut_off.is_some_and(|at| at <= now)) {
            client.lose(now);
        }
    }

    /// Accepts, reads and writes what can be at once. Returns whether something can.
    ///
    /// # Errors
    ///
    /// The error of a socket for new clients or datagrams, if nothing else can be done. That socket wakes nobody, so that it has
    /// to be tried again, but not at once, because an error that stays must not keep the server busy.
    fn poll(&mut self, cx: &mut Context<'_>) -> io::Result<bool> {
        let (now, mut happened, mut failed) = (self.now(), false, None);
        match self.listener.poll_accept(cx) {
            Poll::Pending => {}
            Poll::Ready(Ok((stream, _))) => {
                happened = true;
                if let Some(slot) = self.clients.iter_mut().find(|slot| slot.is_none()) {
                    // Without it, answers come late.
                    let _ = stream.set_nodelay(true);
                    *slot = Some(Client::new(stream));
                }
            }
            Poll::Ready(Err(error)) => failed = Some(error),
        }
        if self.question.is_none() {
            let mut piece = ReadBuf::new(&mut self.piece);
            match self.socket.poll_recv_from(cx, &mut piece) {
                Poll::Pending => {}
                Poll::Ready(Ok(from)) => {
                    happened = true;
                    if let IpAddr::V4(ip) = from.ip() {
                        self.question = Some((SocketAddrV4::new(ip, from.port()).into(), piece.filled().into()));
                    }
                }
                Poll::Ready(Err(error)) => failed = Some(error),
            }
        }
        if let Some((to, bytes)) = self.datagrams.front() {
            // A datagram that cannot be sent is lost, as others on their way are.
            if self.socket.poll_send_to(cx, bytes, *to).is_ready() {
                happened = true;
                self.datagrams.pop_front();
            }
        }
        for client in self.clients.iter_mut().flatten() {
            happened |= client.poll(cx, now, &mut self.piece);
        }
        failed.filter(|_| !happened).map_or(Ok(happened), Err)
    }
}

impl<const N: usize, const CAP: usize> fmt::Debug for Server<N, CAP> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (session, clients) = (&self.session, self.clients.iter().flatten().count());
        f.debug_struct("Server").field("session", session).field("clients", &clients).finish_non_exhaustive()
    }
}

/// Connection of a client.
struct Client {
    /// Stream; `None` if it is lost.
    stream: Option<TcpStream>,
    /// Whether the session knows of the client.
    is_known: bool,
    arrived: Vec<u8>,
    unsent: Vec<u8>,
    /// Time at which the client is cut off, because it takes no bytes.
    cut_off: Option<Millis>,
    /// Whether nothing is written any more. What has arrived is read until the client is cut off.
    is_deaf: bool,
}

impl Client {
    fn new(stream: TcpStream) -> Self {
        let (arrived, unsent) = (Vec::new(), Vec::new());
        Self { stream: Some(stream), is_known: false, arrived, unsent, cut_off: None, is_deaf: false }
    }

    /// Handles a client that takes no bytes. Its last message, for example a stop, is heard before it is cut off.
    fn lose(&mut self, now: Millis) {
        self.stream.take_if(|_| self.is_deaf);
        (self.is_deaf, self.cut_off) = (true, Some(now.after(LAST)));
        self.unsent.clear();
    }

    fn send(&mut self, now: Millis, bytes: &[u8]) {
        if self.is_deaf {
            return;
        }
        if self.unsent.len().saturating_add(bytes.len()) > MOST_UNSENT {
            self.lose(now);
        } else {
            self.unsent.extend_from_slice(bytes);
            self.cut_off.get_or_insert(now.after(STALLED));
        }
    }

    /// Writes and reads what can be at once. Returns false if nothing can.
    fn poll(&mut self, cx: &mut Context<'_>, now: Millis, piece: &mut [u8]) -> bool {
        let Some(stream) = &mut self.stream else { return false };
        let mut stream = Pin::new(stream);
        let mut happened = false;
        if !self.unsent.is_empty() {
            match stream.as_mut().poll_write(cx, &self.unsent) {
                Poll::Pending => {}
                Poll::Ready(Ok(len @ 1..)) => {
                    happened = true;
                    self.unsent.drain(..len);
                    self.cut_off = (!self.unsent.is_empty()).then(|| now.after(STALLED));
                }
                Poll::Ready(_) => {
                    self.lose(now);
                    return true;
                }
            }
        }
        if self.arrived.is_empty() {
            let mut piece = ReadBuf::new(piece);
            match stream.poll_read(cx, &mut piece) {
                Poll::Pending => return happened,
                Poll::Ready(Ok(())) if !piece.filled().is_empty() => self.arrived.extend_from_slice(piece.filled()),
                Poll::Ready(_) => (self.stream, self.cut_off) = (None, None),
            }
            return true;
        }
        happened
    }
}
