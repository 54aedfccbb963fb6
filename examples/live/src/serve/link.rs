//! A line of the rig that somebody is at: its two directions, and the task that carries its bytes.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use motion_core::time::Millis;
use rigs::faults::Carrier;
use rigs::line::Line;
use tokio::io::{AsyncReadExt, AsyncWriteExt, ReadHalf, WriteHalf, split};
use tokio::sync::{Semaphore, mpsc, oneshot};
use tokio::task::JoinHandle;
use tokio::time::timeout;

use super::{Came, Event, PATIENCE, ROOM, Stream};

/// How long a client may take nothing of what is written to it.
const WRITE: Duration = Duration::from_secs(30);
/// How long a client that was hung up on may take to notice.
const LINGER: Duration = Duration::from_secs(1);

/// A line that somebody is at.
pub(super) struct Link {
    pub(super) client: u64,
    pub(super) name: String,
    pub(super) carrier: Carrier,
    /// To the rig.
    pub(super) up: Line,
    /// From the rig.
    down: Line,
    /// Until when the line is dead after a reset.
    dead: Option<Millis>,
    /// Why the client is gone; what it has sent before arrives yet.
    gone: Option<String>,
    /// A permit lets the task read once.
    reads: Arc<Semaphore>,
    /// Whether it has one.
    may_read: bool,
    pieces: mpsc::UnboundedSender<Vec<u8>>,
    /// Bytes in `pieces`.
    waiting: Arc<AtomicUsize>,
    task: JoinHandle<()>,
    /// Kept for its end; the task keeps it too.
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
            let why = carry(stream, client, &credit, to_write, &written, &door).await;
            let _ = door.send(Event::Gone { client, why }).await;
        });
        let (dead, gone, may_read) = (None, None, false);
        Self { client, name, carrier, up, down, dead, gone, reads, may_read, pieces, waiting, task, _here: here }
    }

    /// When something is due on it.
    pub(super) fn wake(&self) -> Option<Millis> {
        [self.up.wake(), self.down.wake(), self.dead].into_iter().flatten().min()
    }

    /// Bytes arrived.
    pub(super) fn arrived(&mut self, now: Millis, bytes: &[u8]) {
        self.may_read = false;
        self.up.push(now, bytes);
    }

    /// The rig says something.
    pub(super) fn send(&mut self, now: Millis, bytes: &[u8]) {
        if self.dead.is_none() && self.gone.is_none() {
            self.down.push(now, bytes);
        }
    }

    /// The client is gone.
    pub(super) fn leave(&mut self, why: String) {
        self.gone = Some(why);
    }

    /// Whether the client is gone.
    pub(super) const fn is_gone(&self) -> bool {
        self.gone.is_some()
    }

    /// Nothing comes through before this moment.
    pub(super) fn hold(&mut self, until: Millis) {
        self.up.hold(until);
        self.down.hold(until);
    }

    /// The line is dead until a moment, and all that was on it is lost.
    pub(super) fn restart(&mut self, dead: Millis, (up, down): (Line, Line)) {
        (self.up, self.down, self.dead) = (up, down, Some(dead));
    }

    /// Whether it comes alive again just now.
    pub(super) fn opens(&mut self, now: Millis) -> bool {
        self.dead.take_if(|until| *until <= now).is_some()
    }

    /// Writes what is due, and lets the task read as long as there is room.
    ///
    /// An error is the end of the line, and says why.
    pub(super) fn carry(&mut self, now: Millis) -> Result<(), String> {
        while let Some(bytes) = self.down.pop(now) {
            self.waiting.fetch_add(bytes.len(), Ordering::Relaxed);
            // A task that has ended says so itself.
            let _ = self.pieces.send(bytes);
        }
        if self.down.held() + self.waiting.load(Ordering::Relaxed) > PATIENCE {
            return Err(format!("cut off: it does not read, and {} KiB wait for it", PATIENCE / 1024));
        }
        if self.up.is_broken() || self.down.is_broken() {
            return Err("fault: the line breaks".to_owned());
        }
        if self.up.held() == 0
            && let Some(why) = self.gone.take()
        {
            return Err(why);
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

    /// Ends the line once all is written.
    pub(super) fn finish(mut self) {
        while let Some(bytes) = self.down.pop(Millis(u64::MAX)) {
            let _ = self.pieces.send(bytes);
        }
    }
}

/// Carries bytes both ways until one of them ends, and says why it did.
async fn carry(
    stream: Box<dyn Stream>,
    client: u64,
    reads: &Semaphore,
    pieces: mpsc::UnboundedReceiver<Vec<u8>>,
    waiting: &AtomicUsize,
    door: &mpsc::Sender<Event>,
) -> String {
    let (mut from, to) = split(stream);
    tokio::select! {
        why = read(&mut from, client, reads, door) => return why,
        result = write(to, pieces, waiting) => {
            if let Err(error) = result {
                return format!("gone: {error}");
            }
        }
    }
    // What it still says would make the system throw away what it has yet to read.
    let drain = async { while from.read(&mut [0; 4096]).await.is_ok_and(|len| len > 0) {} };
    let _ = timeout(LINGER, drain).await;
    "hung up on".to_owned()
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
            Ok(0) => return "has hung up".to_owned(),
            Ok(len) => {
                let bytes = buffer.get(..len).unwrap_or_default().to_vec();
                if door.send(Event::Piece { client, bytes }).await.is_err() {
                    break;
                }
            }
            // So says a pseudo-terminal that all users have closed.
            #[cfg(unix)]
            Err(error) if error.raw_os_error() == Some(rustix::io::Errno::IO.raw_os_error()) => {
                return "has hung up".to_owned();
            }
            Err(error) => return format!("gone: {error}"),
        }
    }
    "is served no more".to_owned()
}

async fn write(
    mut to: WriteHalf<Box<dyn Stream>>,
    mut pieces: mpsc::UnboundedReceiver<Vec<u8>>,
    waiting: &AtomicUsize,
) -> io::Result<()> {
    while let Some(bytes) = pieces.recv().await {
        let late = |_| io::Error::other("it takes nothing any more");
        timeout(WRITE, to.write_all(&bytes)).await.map_err(late)??;
        waiting.fetch_sub(bytes.len(), Ordering::Relaxed);
    }
    timeout(LINGER, to.shutdown()).await.unwrap_or(Ok(()))
}
