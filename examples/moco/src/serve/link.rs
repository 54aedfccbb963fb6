//! Line of the rig with a client: its two directions, and the task that carries its bytes.

use std::io;
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use motion_core::time::Millis;
use motion_rigs::faults::Carrier;
use motion_rigs::line::Line;
use tokio::io::{AsyncReadExt, AsyncWriteExt, ReadHalf, WriteHalf, split};
use tokio::sync::{Semaphore, mpsc, oneshot};
use tokio::task::JoinHandle;
use tokio::time::timeout;

use super::{Came, Event, PATIENCE, ROOM, Stream};

/// Time after which a client that takes no bytes is cut off.
const WRITE: Duration = Duration::from_secs(30);
/// Time that a client may take to notice that the rig closed the line.
const LINGER: Duration = Duration::from_secs(1);

/// Line with a client.
pub(super) struct Link {
    pub(super) client: u64,
    pub(super) name: String,
    pub(super) carrier: Carrier,
    /// Direction to the rig.
    pub(super) up: Line,
    /// Direction from the rig.
    down: Line,
    /// End of the time in which the line is dead after a reset.
    dead: Option<Millis>,
    /// Reason why the client is gone. The bytes that it sent before still arrive.
    gone: Option<String>,
    /// Permits for the task. One permit allows one read.
    reads: Arc<Semaphore>,
    /// Whether the task has a permit.
    may_read: bool,
    pieces: mpsc::UnboundedSender<Vec<u8>>,
    /// Number of bytes in `pieces`.
    waiting: Arc<AtomicUsize>,
    task: JoinHandle<()>,
    /// Sender whose drop shows the end of the line. The task keeps it too.
    _here: Arc<oneshot::Sender<()>>,
}

impl Link {
    pub(super) fn new(client: u64, came: Came, (up, down): (Line, Line), door: mpsc::Sender<Event>) -> Self {
        let Came { name, carrier, stream, here } = came;
        let here = Arc::new(here);
        let reads = Arc::new(Semaphore::new(0));
        let waiting = Arc::new(AtomicUsize::new(0));
        let (pieces, to_write) = mpsc::unbounded_channel();
        let (credit, written) = (Arc::clone(&reads), Arc::clone(&waiting));
        let until = Arc::clone(&here);
        let task = tokio::spawn(async move {
            let _until = until;
            carry(stream, client, &credit, to_write, &written, &door).await;
        });
        let (dead, gone, may_read) = (None, None, false);
        Self { client, name, carrier, up, down, dead, gone, reads, may_read, pieces, waiting, task, _here: here }
    }

    /// Time at which something is due on the line.
    pub(super) fn wake(&self) -> Option<Millis> {
        [self.up.wake(), self.down.wake(), self.dead].into_iter().flatten().min()
    }

    /// Takes received bytes.
    pub(super) fn arrived(&mut self, now: Millis, bytes: &[u8]) {
        self.may_read = false;
        self.up.push(now, bytes);
    }

    /// Takes bytes that the rig sends.
    pub(super) fn send(&mut self, now: Millis, bytes: &[u8]) {
        if self.dead.is_none() {
            self.down.push(now, bytes);
        }
    }

    /// Marks the client as gone.
    pub(super) fn leave(&mut self, why: String) {
        self.gone = Some(why);
    }

    /// Reason why the client is gone, if all bytes that it sent before have arrived.
    pub(super) fn left(&mut self) -> Option<String> {
        self.gone.take_if(|_| self.up.held() == 0)
    }

    /// Whether the client is gone.
    pub(super) const fn is_gone(&self) -> bool {
        self.gone.is_some()
    }

    /// Holds all bytes back until a moment.
    pub(super) fn hold(&mut self, until: Millis) {
        self.up.hold(until);
        self.down.hold(until);
    }

    /// Replaces the line by one that is dead until a moment. All bytes on the line are lost.
    pub(super) fn restart(&mut self, dead: Millis, (up, down): (Line, Line)) {
        (self.up, self.down, self.dead) = (up, down, Some(dead));
    }

    /// Whether the line opens again now.
    pub(super) fn opens(&mut self, now: Millis) -> bool {
        self.dead.take_if(|until| *until <= now).is_some()
    }

    /// Writes the bytes that are due, and lets the task read while there is room.
    ///
    /// An error ends the line, and says why.
    pub(super) fn carry(&mut self, now: Millis) -> Result<(), String> {
        while let Some(bytes) = self.down.pop(now) {
            self.waiting.fetch_add(bytes.len(), Ordering::Relaxed);
            // A task that has ended reports that itself.
            let _ = self.pieces.send(bytes);
        }
        if self.down.held() + self.waiting.load(Ordering::Relaxed) > PATIENCE {
            return Err(format!("cut off: the client does not read, and {} KiB wait for it", PATIENCE / 1024));
        }
        if self.up.is_broken() || self.down.is_broken() {
            return Err("fault: the line breaks".to_owned());
        }
        if !self.may_read && self.up.held() < ROOM {
            self.may_read = true;
            self.reads.add_permits(1);
        }
        Ok(())
    }

    /// Ends the line at once.
    pub(super) fn abort(&self) {
        self.task.abort();
    }

    /// Ends the line when all bytes are written.
    pub(super) fn finish(mut self) {
        while let Some(bytes) = self.down.pop(Millis(u64::MAX)) {
            let _ = self.pieces.send(bytes);
        }
    }
}

/// Carries bytes in both directions until both have ended. Tells the server when the client is gone.
async fn carry(
    stream: Box<dyn Stream>,
    client: u64,
    reads: &Semaphore,
    pieces: mpsc::UnboundedReceiver<Vec<u8>>,
    waiting: &AtomicUsize,
    door: &mpsc::Sender<Event>,
) {
    let (mut from, to) = split(stream);
    let mut write_all = pin!(write(to, pieces, waiting));
    let written = tokio::select! {
        why = read(&mut from, client, reads, door) => {
            let _ = door.send(Event::Gone { client, why }).await;
            // A client that sends no more may still read. The server ends the line when all its answers are there.
            let _ = write_all.await;
            return;
        }
        written = &mut write_all => written,
    };
    let why = match written {
        Ok(()) => {
            // Received bytes that nobody reads would make the system discard the last bytes to the client.
            let drain = async { while from.read(&mut [0; 4096]).await.is_ok_and(|len| len > 0) {} };
            let _ = timeout(LINGER, drain).await;
            "the rig closed the line".to_owned()
        }
        Err(error) => format!("the line failed: {error}"),
    };
    let _ = door.send(Event::Gone { client, why }).await;
}

async fn read(
    from: &mut ReadHalf<Box<dyn Stream>>,
    client: u64,
    reads: &Semaphore,
    door: &mpsc::Sender<Event>,
) -> String {
    let mut buffer = [0; 4096];
    while let Ok(permit) = reads.acquire().await {
        permit.forget();
        match from.read(&mut buffer).await {
            Ok(0) => return "the client closed the line".to_owned(),
            Ok(len) => {
                let bytes = buffer.get(..len).unwrap_or_default().to_vec();
                if door.send(Event::Piece { client, bytes }).await.is_err() {
                    break;
                }
            }
            // A pseudo-terminal reports this error when all users have closed it.
            #[cfg(unix)]
            Err(error) if error.raw_os_error() == Some(rustix::io::Errno::IO.raw_os_error()) => {
                return "the client closed the line".to_owned();
            }
            Err(error) => return format!("the line failed: {error}"),
        }
    }
    "the server has ended".to_owned()
}

async fn write(
    mut to: WriteHalf<Box<dyn Stream>>,
    mut pieces: mpsc::UnboundedReceiver<Vec<u8>>,
    waiting: &AtomicUsize,
) -> io::Result<()> {
    while let Some(bytes) = pieces.recv().await {
        let late = |_| io::Error::other("it no longer takes any bytes");
        timeout(WRITE, to.write_all(&bytes)).await.map_err(late)??;
        waiting.fetch_sub(bytes.len(), Ordering::Relaxed);
    }
    timeout(LINGER, to.shutdown()).await.unwrap_or(Ok(()))
}
