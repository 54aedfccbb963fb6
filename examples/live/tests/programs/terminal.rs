//! Pseudo-terminal without a rig: the test itself reads and writes.

use std::fs::File;
use std::io::{Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::sync::{Arc, Mutex};
use std::thread;

use rustix::fs::{Mode, OFlags, open};
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
        let (ours, sent) = (File::from(ours), Arc::new(Mutex::new(Vec::new())));
        let (mut reader, kept) = (ours.try_clone().unwrap(), Arc::clone(&sent));
        thread::spawn(move || {
            let mut buffer = [0; 1024];
            while let Ok(len @ 1..) = reader.read(&mut buffer) {
                kept.lock().unwrap().extend_from_slice(&buffer[..len]);
            }
        });
        Self { ours, _theirs: theirs, path, sent }
    }

    pub(crate) fn write(&mut self, bytes: &[u8]) {
        self.ours.write_all(bytes).unwrap();
    }
}
