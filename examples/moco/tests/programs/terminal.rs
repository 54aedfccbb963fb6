//! Pseudo-terminal without a rig: the test itself reads and writes.

use std::fs::File;
use std::io::{ErrorKind, Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use rustix::fs::{Mode, OFlags, fcntl_getfl, fcntl_setfl, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// Pseudo-terminal. What its user sends is read at once.
pub(crate) struct Terminal {
    ours: File,
    /// End for users. While it is open, the terminal stays when its user leaves.
    _theirs: OwnedFd,
    pub(crate) path: String,
    /// Bytes that the user sent.
    pub(crate) sent: Arc<Mutex<Vec<u8>>>,
}

impl Terminal {
    pub(crate) fn open() -> Self {
        let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&ours).unwrap();
        unlockpt(&ours).unwrap();
        let path = ptsname(&ours, Vec::new()).unwrap().into_string().unwrap();
        let theirs = open(&*path, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty()).unwrap();
        let mut settings = tcgetattr(&theirs).unwrap();
        settings.make_raw();
        tcsetattr(&theirs, OptionalActions::Now, &settings).unwrap();
        let flags = fcntl_getfl(&ours).unwrap();
        fcntl_setfl(&ours, flags | OFlags::NONBLOCK).unwrap();
        let (ours, sent) = (File::from(ours), Arc::new(Mutex::new(Vec::new())));
        let (mut reader, kept) = (ours.try_clone().unwrap(), Arc::clone(&sent));
        thread::spawn(move || {
            let mut buffer = [0; 1024];
            loop {
                match reader.read(&mut buffer) {
                    Ok(len @ 1..) => kept.lock().unwrap().extend_from_slice(&buffer[..len]),
                    Err(error) if error.kind() == ErrorKind::WouldBlock => thread::sleep(Duration::from_millis(5)),
                    _ => return,
                }
            }
        });
        Self { ours, _theirs: theirs, path, sent }
    }

    /// Writes bytes, as far as the terminal has room for them. Without a user it soon has none.
    pub(crate) fn write(&mut self, bytes: &[u8]) {
        let written = self.ours.write(bytes).map_err(|error| error.kind());
        assert!(matches!(written, Ok(_) | Err(ErrorKind::WouldBlock)), "{written:?}");
    }
}
