//! Rig that serves over loopback TCP, and the commands that drive it.

use std::net::SocketAddr;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use motion_core::time::Millis;
use motion_rigs::kos_device::{KosDevice, Setup};
use motion_rigs::kos_host::KosHost;
use motion_rigs::{LineId, Outgoing, Party as _, Rig as _};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep_until};

use crate::drive::kos::{Options, drive};
use crate::drive::output::{About, Output};
use crate::drive::{Command, Driven as _, Trouble};
use crate::session::{Session, Target};

pub(super) const LINE: LineId = LineId(0);

/// Time of the move in seconds, with the positions of the motors.
pub(super) type Seen = Vec<(f64, Vec<f64>)>;

/// Rig that serves one client at a time.
pub(super) struct Served {
    pub(super) rig: Arc<Mutex<KosDevice>>,
    pub(super) address: SocketAddr,
    start: Instant,
    /// Positions at each tick of a move.
    pub(super) path: Arc<Mutex<Seen>>,
    /// Sender whose messages each cut off the client.
    pub(super) cut: mpsc::UnboundedSender<()>,
    pub(super) serving: tokio::task::JoinHandle<()>,
}

impl Served {
    pub(super) async fn new(setup: Setup) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let rig = Arc::new(Mutex::new(KosDevice::new(setup)));
        let path = Arc::new(Mutex::new(Vec::new()));
        let (cut, cuts) = mpsc::unbounded_channel();
        let start = Instant::now();
        let serving = tokio::spawn(serve(listener, start, Arc::clone(&rig), Arc::clone(&path), cuts));
        Self { rig, address, start, path, cut, serving }
    }

    /// Serves again at the same address, after serving was ended.
    pub(super) async fn again(&self) {
        let listener = TcpListener::bind(self.address).await.unwrap();
        self.rig.lock().unwrap().close(since(self.start), LINE);
        let (keep, cuts) = mpsc::unbounded_channel();
        let serving = serve(listener, self.start, Arc::clone(&self.rig), Arc::clone(&self.path), cuts);
        tokio::spawn(async move {
            let _keep = keep;
            serving.await;
        });
    }

    /// Does a command as the program does. Returns its output and its result.
    pub(super) async fn drive(&self, command: Command) -> (String, Result<(), Trouble>) {
        let (_keep, interrupts) = mpsc::unbounded_channel();
        self.drive_until(command, None, interrupts).await
    }

    pub(super) async fn drive_until(
        &self,
        command: Command,
        password: Option<&[u8]>,
        interrupts: mpsc::UnboundedReceiver<()>,
    ) -> (String, Result<(), Trouble>) {
        let mut out = Vec::new();
        let done = self.drive_into(command, password, interrupts, &mut out).await;
        (String::from_utf8(out).unwrap(), done)
    }

    pub(super) async fn drive_into(
        &self,
        command: Command,
        password: Option<&[u8]>,
        interrupts: mpsc::UnboundedReceiver<()>,
        out: &mut (dyn Output + Send),
    ) -> Result<(), Trouble> {
        let host = KosHost::new(kos_proto::host::Options::default(), password);
        let mut session = Session::connect(host, Target::Tcp(self.address), interrupts).await.unwrap();
        let mut done = drive(&mut session, &command, &Options::default(), out).await;
        let is_stopped = matches!(done, Ok(()) | Err(Trouble::MayMove(_)));
        if !is_stopped && session.host().may_move() {
            let stopped = session.stop().await;
            out.line(About::Note, format_args!("stop: {stopped:?}")).unwrap();
        }
        if let Err(trouble) = &mut done {
            assert!(!trouble.to_string().contains('\n'), "{trouble}");
        }
        done
    }

    pub(super) async fn done(&self, command: Command) -> String {
        let (said, done) = self.drive(command).await;
        done.unwrap_or_else(|trouble| panic!("{said}{trouble}"));
        said
    }

    pub(super) async fn trouble(&self, command: Command) -> String {
        let (said, done) = self.drive(command).await;
        done.expect_err(&said).to_string()
    }

    pub(super) fn now(&self) -> Millis {
        since(self.start)
    }

    pub(super) fn at(&self, motor: usize) -> f64 {
        self.rig.lock().unwrap().motors()[motor].at(since(self.start)).position
    }

    pub(super) fn rests(&self) -> bool {
        let now = since(self.start);
        self.rig.lock().unwrap().motors().iter().all(|motor| motor.at(now).velocity == 0.0)
    }
}

fn since(start: Instant) -> Millis {
    Millis(u64::try_from(start.elapsed().as_millis()).unwrap())
}

async fn serve(
    listener: TcpListener,
    start: Instant,
    rig: Arc<Mutex<KosDevice>>,
    path: Arc<Mutex<Seen>>,
    mut cuts: mpsc::UnboundedReceiver<()>,
) {
    let now = || since(start);
    let (mut client, mut buffer) = (None::<TcpStream>, [0; 4096]);
    loop {
        let (outgoing, wake) = {
            let mut rig = rig.lock().unwrap();
            rig.advance(now());
            if let Some(moment) = rig.moment() {
                let places = rig.motors().iter().map(|motor| motor.at(now()).position).collect();
                path.lock().unwrap().push((moment, places));
            }
            (std::iter::from_fn(|| rig.poll()).collect::<Vec<_>>(), rig.wake())
        };
        for outgoing in outgoing {
            match (outgoing, &mut client) {
                (Outgoing::Bytes(LINE, bytes), Some(client)) => drop(client.write_all(&bytes).await),
                (Outgoing::HangUp(LINE), client) => *client = None,
                _ => {}
            }
        }
        // Time passes in small steps, because the clock does not know about bytes inside the operating system.
        let soon = Instant::now() + Duration::from_millis(2);
        let wake = wake.map_or(soon, |wake| soon.min(start + Duration::from_millis(wake.0)));
        let is_free = client.is_none();
        let read = async {
            match &mut client {
                Some(client) => client.read(&mut buffer).await,
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            read = read => match read {
                Ok(len) if len > 0 => rig.lock().unwrap().receive(now(), LINE, &buffer[..len]),
                _ => {
                    client = None;
                    rig.lock().unwrap().close(now(), LINE);
                }
            },
            accepted = listener.accept(), if is_free => {
                client = accepted.ok().map(|(client, _)| client);
                // The clock would go on while a message is held back.
                if let Some(client) = &client {
                    client.set_nodelay(true).unwrap();
                }
                rig.lock().unwrap().open(now(), LINE);
            }
            Some(()) = cuts.recv() => {
                client = None;
                rig.lock().unwrap().close(now(), LINE);
            }
            () = sleep_until(wake) => {}
        }
    }
}
