//! A pseudo-terminal: a serial line without a wire, which one program opens as it would open a real one.
//!
//! While nobody uses it, its end for users is held open here, so that the first byte of the next user can be waited for:
//! a pseudo-terminal without users is all errors. Once somebody is there it is let go, and then the last user's leaving is
//! the end of the line. Programs lock a serial line for themselves, and a pseudo-terminal forgets that lock no sooner than
//! it is gone itself: so it is taken away again, as nobody but its user needs it.

use std::fs::File;
use std::io;
use std::os::fd::OwnedFd;
use std::time::Duration;

use rigs::faults::Carrier;
use rustix::fs::{Mode, OFlags, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, QueueSelector, ioctl_tiocnxcl, tcflush, tcgetattr, tcsetattr};
use tokio::io::join;
use tokio::net::unix::pipe;
use tokio::time::{sleep, timeout};
use tracing::warn;

use super::Door;

/// How long a lock of somebody who opened the terminal, said nothing and left, may stay.
const LOCKED: Duration = Duration::from_millis(250);

/// A pseudo-terminal.
#[derive(Debug)]
pub struct Pty {
    ours: File,
    theirs: OwnedFd,
    path: String,
}

impl Pty {
    /// A new one, in raw mode.
    ///
    /// # Errors
    ///
    /// What the operating system says.
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

    /// What a user opens.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Lets one user after the other in, until nobody serves any more.
    pub async fn serve(self, door: Door) {
        let Self { ours, mut theirs, path } = self;
        loop {
            // Both for this user only: an end that was seen once is never forgotten by them.
            let (from, to) = match ends(&ours) {
                Ok(ends) => ends,
                Err(error) => return warn!("{path}: {error}"),
            };
            while timeout(LOCKED, from.readable()).await.is_err() {
                unlock(&theirs);
            }
            unlock(&theirs);
            drop(theirs);
            let Some(end) = door.enter(&path, Carrier::Serial, join(from, to)).await else { return };
            // An error is the end, which is what is waited for.
            let _ = end.await;
            theirs = loop {
                match users_end(&path) {
                    Ok(theirs) => break theirs,
                    Err(error) => warn!("{path}: {error}: it is tried again"),
                }
                sleep(LOCKED).await;
            };
            // What nobody has read.
            let _ = tcflush(&theirs, QueueSelector::IOFlush);
        }
    }
}

/// Our end for reading and for writing. Tokio has no other safe way to wait for any file that can be waited for.
fn ends(ours: &File) -> io::Result<(pipe::Receiver, pipe::Sender)> {
    let from = pipe::Receiver::from_file_unchecked(ours.try_clone()?)?;
    let to = pipe::Sender::from_file_unchecked(ours.try_clone()?)?;
    Ok((from, to))
}

/// The end for users, in raw mode, whatever mode the last one left it in.
fn users_end(path: &str) -> io::Result<OwnedFd> {
    let theirs = open(path, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty())?;
    let mut settings = tcgetattr(&theirs)?;
    settings.make_raw();
    tcsetattr(&theirs, OptionalActions::Now, &settings)?;
    Ok(theirs)
}

fn unlock(theirs: &OwnedFd) {
    // A system without such locks needs nothing.
    let _ = ioctl_tiocnxcl(theirs);
}
