//! Tests of sessions on lines that are never silent, or that never end an opening.

#[path = "../../../motion-io/tests/lines/mod.rs"]
mod lines;

use std::time::{Duration, Instant};

use lines::Babble;
use moco::session::Session;
use motion_rigs::dmc_host::DmcHost;
use tokio::sync::mpsc::unbounded_channel;

#[tokio::test]
async fn a_line_that_is_never_silent_does_not_delay_the_end_of_waiting() {
    let (_keep, interrupts) = unbounded_channel();
    let mut session = Session::over(DmcHost::default(), Babble { takes: true }, interrupts);
    let start = Instant::now();
    assert_eq!(session.next_within(Duration::from_millis(10)).await.unwrap(), None);
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
}

#[tokio::test]
async fn only_a_stop_opens_a_lost_line_again() {
    use moco::drive::Trouble;
    use moco::session::Target;
    use tokio::net::TcpListener;
    use tokio::time::timeout;

    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let target = Target::Tcp(listener.local_addr().unwrap());
    let (_keep, interrupts) = unbounded_channel();
    let mut session = Session::connect(DmcHost::default(), target, interrupts).await.unwrap();
    drop(listener.accept().await.unwrap());
    for _ in 0..3 {
        let trouble = loop {
            if let Err(trouble) = session.next_within(Duration::from_millis(200)).await {
                break trouble;
            }
        };
        assert!(matches!(&trouble, Trouble::Lost(line) if line.starts_with("the rig is gone: ")), "{trouble}");
    }
    assert!(timeout(Duration::from_millis(50), listener.accept()).await.is_err(), "the line was opened again");
    tokio::select! {
        line = listener.accept() => assert!(line.is_ok()),
        stopped = session.stop() => panic!("{stopped:?}, but the line was not opened again"),
    }
}

/// On Linux, connecting gets no answer while the queue of the listener is full.
#[cfg(target_os = "linux")]
#[tokio::test]
async fn a_stop_opens_the_line_whose_opening_was_interrupted() {
    use kos_proto::host::{Options, Token};
    use moco::drive::Trouble;
    use moco::session::Target;
    use motion_rigs::kos_host::{Command, KosHost};
    use tokio::io::AsyncReadExt as _;
    use tokio::net::{TcpSocket, TcpStream};
    use tokio::time::timeout;

    let socket = TcpSocket::new_v4().unwrap();
    socket.bind("127.0.0.1:0".parse().unwrap()).unwrap();
    let listener = socket.listen(0).unwrap();
    let address = listener.local_addr().unwrap();
    let mut waiting = Vec::new();
    while let Ok(Ok(line)) = timeout(Duration::from_millis(50), TcpStream::connect(address)).await {
        waiting.push(line);
    }
    let (interrupt, interrupts) = unbounded_channel();
    let host = KosHost::new(Options::default(), None);
    let mut session = Session::connect(host, Target::Tcp(address), interrupts).await.unwrap();
    session.command((Token(1), Command::Connect));
    let soon = async {
        tokio::time::sleep(Duration::from_millis(100)).await;
        interrupt.send(()).unwrap();
    };
    let trouble = async {
        loop {
            if let Err(trouble) = session.next().await {
                return trouble;
            }
        }
    };
    let (trouble, ()) = tokio::join!(trouble, soon);
    assert!(matches!(trouble, Trouble::Interrupted), "{trouble}");
    drop(waiting);
    let rig = async {
        loop {
            let (mut line, _) = listener.accept().await.unwrap();
            let mut bytes = Vec::new();
            let _ = timeout(Duration::from_millis(200), line.read_to_end(&mut bytes)).await;
            if bytes.windows(7).any(|bytes| bytes == b"\x04\0\x07\0\x80\0\x06") {
                return;
            }
        }
    };
    tokio::select! {
        () = rig => {}
        stopped = session.stop() => panic!("{stopped:?}, but the rig received no stop"),
    }
}
