//! Pseudo-terminal: a serial line without a wire, which a program opens like a real one.
//!
//! A pseudo-terminal without users only gives errors. So while it has no user, its end for users is held open here, and
//! the first byte of the next user can be awaited. When there is a user, this handle is closed. Then the line ends when
//! the last user closes it.
//!
//! Programs lock a serial line for themselves. A pseudo-terminal keeps such a lock until it is removed itself, so the
//! lock is released here. Only the program that set it needs it.

use std::fs::File;
use std::io;
use std::os::fd::OwnedFd;
use std::time::Duration;

use motion_rigs::faults::Carrier;
use rustix::fs::{Mode, OFlags, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, QueueSelector, ioctl_tiocnxcl, tcflush, tcgetattr, tcsetattr};
use tokio::io::join;
use tokio::net::unix::pipe;
use tokio::time::{sleep, timeout};
use tracing::warn;

use super::Door;

/// Time for which a lock may stay after a user opened the terminal, sent nothing, and closed it.
const LOCKED: Duration = Duration::from_millis(250);

/// Pseudo-terminal with one user at a time.
#[derive(Debug)]
pub struct Pty {
    ours: File,
    theirs: OwnedFd,
    path: String,
}

impl Pty {
    /// Opens a new pseudo-terminal, in raw mode.
    ///
    /// # Errors
    ///
    /// Error of the operating system.
    pub fn new() -> io::Result<Self> {
        let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&ours)?;
        unlockpt(&ours)?;
        let path = ptsname(&ours, Vec::new())?.into_string().map_err(io::Error::other)?;
        let theirs = users_end(&path)?;
        let flags = rustix::fs::fcntl_getfl(&ours)?;
        rustix::fs::fcntl_setfl(&ours, flags | OFlags::NONBLOCK)?;
        Ok(Self { ours: File::from(ours), theirs, path })
    }

    /// Path that a user opens.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Accepts one user after the other, until the server has ended.
    pub async fn serve(self, door: Door) {
        let Self { ours, mut theirs, path } = self;
        loop {
            // Both are for this user only, because they never read again after they have seen an end.
            let (from, to) = match ends(&ours) {
                Ok(ends) => ends,
                Err(error) => return warn!("{path}: {error}"),
            };
            unlock(&theirs);
            while timeout(LOCKED, from.readable()).await.is_err() {
                unlock(&theirs);
            }
            unlock(&theirs);
            drop(theirs);
            let Some(end) = door.enter(&path, Carrier::Serial, join(from, to)).await else { return };
            // An error is the awaited end.
            let _ = end.await;
            theirs = loop {
                match users_end(&path) {
                    Ok(theirs) => break theirs,
                    Err(error) => warn!("{path}: {error}: trying again"),
                }
                sleep(LOCKED).await;
            };
            // Unread bytes are not for the next user.
            let _ = tcflush(&theirs, QueueSelector::IOFlush);
        }
    }
}

/// Our end for reading and for writing. Tokio has no other safe way to wait for such a file.
fn ends(ours: &File) -> io::Result<(pipe::Receiver, pipe::Sender)> {
    let from = pipe::Receiver::from_file_unchecked(ours.try_clone()?)?;
    let to = pipe::Sender::from_file_unchecked(ours.try_clone()?)?;
    Ok((from, to))
}

/// End for users, set to raw mode, because the last user may have changed the mode.
fn users_end(path: &str) -> io::Result<OwnedFd> {
    let theirs = open(path, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty())?;
    let mut settings = tcgetattr(&theirs)?;
    settings.make_raw();
    tcsetattr(&theirs, OptionalActions::Now, &settings)?;
    Ok(theirs)
}

fn unlock(theirs: &OwnedFd) {
    // A system without such locks returns an error, which has no effect.
    let _ = ioctl_tiocnxcl(theirs);
}
