//! Cable between two programs, which can be cut.

use std::io::copy;
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::thread;

/// Cable that carries TCP connections to a rig. A cut ends its connections, and later ones are carried again. The cable
/// ends with its test.
pub(crate) struct Cable {
    /// Address at which the cable begins.
    pub(crate) address: String,
    carried: Arc<Mutex<Vec<TcpStream>>>,
}

impl Cable {
    pub(crate) fn new(to: &str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let carried = Arc::new(Mutex::new(Vec::new()));
        let (all, to) = (Arc::clone(&carried), to.to_owned());
        thread::spawn(move || {
            while let Ok((near, _)) = listener.accept() {
                let Ok(far) = TcpStream::connect(&to) else { continue };
                for (from, to) in [(&near, &far), (&far, &near)] {
                    let (mut from, mut to) = (from.try_clone().unwrap(), to.try_clone().unwrap());
                    thread::spawn(move || {
                        // However one direction ends, the other end of the cable must see it.
                        let _ = copy(&mut from, &mut to);
                        let _ = to.shutdown(Shutdown::Both);
                    });
                }
                all.lock().unwrap().extend([near, far]);
            }
        });
        Self { address, carried }
    }

    /// Cuts all connections.
    pub(crate) fn cut(&self) {
        for stream in self.carried.lock().unwrap().drain(..) {
            // The connection may have ended by itself.
            let _ = stream.shutdown(Shutdown::Both);
        }
    }
}
