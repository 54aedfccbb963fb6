//! Server of a kOS device on a computer that cannot open more files for some time. The limit holds for the whole process, so that
//! this test has a program of its own.
#![cfg(unix)]

use std::net::{Ipv4Addr, SocketAddrV4};
use std::time::Duration;

use kos_proto::HostMessage;
use kos_proto::device::{DeviceMachine, Options, Report, Session, Source};
use kos_proto::message::GetDeviceInfo;
use motion_io::kos::Server;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpSocket;
use tokio::time::{Instant, sleep};

#[tokio::test]
async fn a_client_that_could_not_be_accepted_is_accepted_soon_after_files_are_free_again() {
    let mut session = Session::<36_000, { kos_proto::frame::MAX_FRAME }>::new(DeviceMachine::new(Options::default()));
    session.report(Report::Started).unwrap();
    let here = SocketAddrV4::new(Ipv4Addr::LOCALHOST, 0);
    let mut server = Server::bind(session, here).await.unwrap().announcing_to(SocketAddrV4::new(*here.ip(), 9));
    let (address, socket) = (server.address().unwrap(), TcpSocket::new_v4().unwrap());
    let client = async {
        let limit = getrlimit(Resource::Nofile);
        setrlimit(Resource::Nofile, Rlimit { current: Some(1), ..limit }).unwrap();
        let mut stream = socket.connect(address).await.unwrap();
        sleep(Duration::from_millis(300)).await;
        setrlimit(Resource::Nofile, limit).unwrap();
        let start = Instant::now();
        stream.write_all(&HostMessage::from(GetDeviceInfo::default()).to_vec().unwrap()).await.unwrap();
        stream.read_u8().await.unwrap();
        start.elapsed()
    };
    let serve = async {
        loop {
            server.next(&Source::default()).await.unwrap();
        }
    };
    let time = tokio::select! {
        time = client => time,
        () = serve => unreachable!("it serves for ever"),
    };
    // The next thing that the device does by itself is an announcement, 5 s after the first.
    assert!(time < Duration::from_secs(2), "{time:?}");
}
