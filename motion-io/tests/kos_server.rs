//! Server of a kOS device, with hosts of this project and with strangers, over the loopback device.

use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4};
use std::time::Duration;

use kos_proto::HostMessage;
use kos_proto::device::{DeviceMachine, Options, Report, Session, Source};
use kos_proto::discovery::Datagram;
use kos_proto::host;
use kos_proto::message::{
    GetDeviceInfo, Ipv4, LEDStatus, LedMode, MotorAddress, NetworkInfo, RotationsPerSecond, RotationsPerSecondSquared,
};
use motion_io::kos::Server;
use motion_io::tokio::{Driver, tcp};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream, UdpSocket};
use tokio::time::{Instant, timeout};

const N: usize = 36_000;
const CAP: usize = kos_proto::frame::MAX_FRAME;
const LONG: Duration = Duration::from_secs(20);

fn server() -> impl Future<Output = (Server<N, CAP>, SocketAddr)> {
    let mut session = Session::<N, CAP>::new(DeviceMachine::new(Options::default()));
    session.report(Report::Started).unwrap();
    let bound = Server::bind(session, SocketAddrV4::new(Ipv4Addr::LOCALHOST, 0));
    async {
        // Nothing leaves this computer.
        let server = bound.await.unwrap().announcing_to(SocketAddrV4::new(Ipv4Addr::LOCALHOST, 9));
        let address = server.address().unwrap();
        (server, address)
    }
}

/// Serves while the clients do what they do, and returns the events. Futures of the server are dropped again and again.
async fn serve<T>(server: &mut Server<N, CAP>, clients: impl Future<Output = T>) -> (Vec<String>, T) {
    let mut events = Vec::new();
    let serve = async {
        loop {
            if let Ok(event) = timeout(Duration::from_millis(1), server.next(&Source::default())).await {
                events.push(format!("{:?}", event.unwrap()));
            }
        }
    };
    let done = tokio::select! {
        done = timeout(LONG, clients) => done.expect("the clients end in time"),
        () = serve => unreachable!("it serves for ever"),
    };
    (events, done)
}

/// A host that lets a motor run and stops it.
async fn host(address: SocketAddr, motor: MotorAddress) {
    use host::{Endpoint, Event, Source, Token};
    let stream = tcp(address).await.unwrap();
    // Its session is long, and futures move.
    let mut driver = Box::new(Driver::new(<host::Session>::new(host::Options::default()), stream));
    driver.session_mut().connect(Token(1), Endpoint::Tcp(Ipv4(0x7F00_0001))).unwrap();
    loop {
        match driver.next(&Source::default()).await.unwrap() {
            Event::Ready { .. } => {
                let (speed, acceleration) = (RotationsPerSecond(1.0), RotationsPerSecondSquared(1.0));
                driver.session_mut().jog(Token(2), motor, speed, acceleration).unwrap();
                driver.session_mut().get(Token(3), host::Get::DeviceGuid).unwrap();
            }
            Event::Ended { token: Token(3), .. } => return,
            _ => {}
        }
    }
}

/// Reads until the server closes the connection.
async fn end(stream: &mut TcpStream) {
    while !matches!(stream.read(&mut [0; 1_000]).await, Ok(0) | Err(_)) {}
}

#[tokio::test]
async fn two_hosts_move_their_motors_while_a_stranger_sends_garbage() {
    let (mut server, address) = server().await;
    let stranger = async {
        let mut stream = TcpStream::connect(address).await.unwrap();
        stream.write_all(b"GET / HTTP/1.1\r\nHost: rig\r\n\r\n").await.unwrap();
        end(&mut stream).await;
    };
    let hosts = async { tokio::join!(stranger, host(address, MotorAddress(1)), host(address, MotorAddress(2))) };
    let (events, _) = serve(&mut server, hosts).await;
    let tells = |what: &str| events.iter().any(|event| event.contains(what));
    assert!(tells("reason: Framing"), "{events:#?}");
    assert!(tells("Move { motor: MotorAddress(1)") && tells("Move { motor: MotorAddress(2)"), "{events:#?}");
    // Both hosts are gone, so that both motors stop.
    let (events, ()) = serve(&mut server, tokio::time::sleep(Duration::from_millis(300))).await;
    for motor in [1, 2] {
        let stop = format!("StopMotor {{ motor: MotorAddress({motor})");
        assert!(events.iter().any(|event| event.contains(&stop)), "{events:#?}");
    }
}

#[tokio::test]
async fn a_fifth_client_is_refused_until_another_one_leaves() {
    let (mut server, address) = server().await;
    let clients = async {
        let mut clients = Vec::new();
        for _ in 0..4 {
            clients.push(TcpStream::connect(address).await.unwrap());
        }
        end(&mut TcpStream::connect(address).await.unwrap()).await;
        drop(clients.pop());
        // The device does not know at once that the client left.
        tokio::time::sleep(Duration::from_millis(100)).await;
        host(address, MotorAddress(1)).await;
        drop(clients);
    };
    let (events, ()) = serve(&mut server, clients).await;
    assert!(events.iter().any(|event| event.starts_with("Move {")), "{events:#?}");
}

#[tokio::test]
async fn a_client_that_does_not_read_is_cut_off_and_the_others_are_served() {
    let (mut server, address) = server().await;
    let clients = async {
        let socket = TcpSocket::new_v4().unwrap();
        socket.set_recv_buffer_size(4_096).unwrap();
        let mut deaf = socket.connect(address).await.unwrap();
        let questions = HostMessage::from(GetDeviceInfo::default()).to_vec().unwrap().repeat(500);
        let start = Instant::now();
        // The server closes the connection, so that writing fails at last.
        while deaf.write_all(&questions).await.is_ok() {}
        let time = start.elapsed();
        host(address, MotorAddress(1)).await;
        time
    };
    let (events, time) = serve(&mut server, clients).await;
    assert!(events.iter().any(|event| event.starts_with("Move {")), "{events:#?}");
    // Such a client is cut off after 2 s at the latest.
    assert!(time < Duration::from_secs(5), "{time:?}");
}

#[tokio::test]
async fn the_last_message_of_a_client_whose_connection_breaks_is_heard() {
    let (mut server, address) = server().await;
    let question = HostMessage::from(GetDeviceInfo::default()).to_vec().unwrap();
    let client = async {
        let mut stream = TcpStream::connect(address).await.unwrap();
        stream.write_all(&question).await.unwrap();
        stream.readable().await.unwrap();
        stream
    };
    let (_, mut stream) = serve(&mut server, client).await;
    // The server is busy, so that it has much to read, and to answer.
    let mut bytes = question.repeat(2_000);
    let lamps = LEDStatus { master_status: LedMode::ON, ..LEDStatus::default() };
    bytes.extend(HostMessage::SetLEDStatus(lamps).to_vec().unwrap());
    stream.write_all(&bytes).await.unwrap();
    // A connection breaks if it is closed while answers wait.
    drop(stream);
    let (events, ()) = serve(&mut server, tokio::time::sleep(Duration::from_millis(300))).await;
    assert!(events.iter().any(|event| event.starts_with("Leds {")), "{events:#?}");
}

#[tokio::test]
async fn a_question_by_datagram_is_answered_and_the_device_announces_itself() {
    let ear = UdpSocket::bind("127.0.0.1:0").await.unwrap();
    let SocketAddr::V4(to) = ear.local_addr().unwrap() else { panic!("no address of IPv4") };
    let (server, address) = server().await;
    let mut server = server.announcing_to(to);
    let client = async {
        let mut bytes = [0; 100];
        let (len, _) = ear.recv_from(&mut bytes).await.unwrap();
        assert!(matches!(Datagram::decode(&bytes[..len]), Ok(Datagram::Announcement(NetworkInfo { .. }))));

        let asker = UdpSocket::bind("127.0.0.1:0").await.unwrap();
        let mut question = [0; 7];
        Datagram::question(false).encode_into(&mut question).unwrap();
        asker.send_to(b"garbage", address).await.unwrap();
        asker.send_to(&question, address).await.unwrap();
        let (len, from) = asker.recv_from(&mut bytes).await.unwrap();
        assert!(matches!(Datagram::decode(&bytes[..len]), Ok(Datagram::Announcement(_))));
        assert_eq!(from, address);
    };
    let _ = serve(&mut server, client).await;
}

#[tokio::test]
async fn an_address_in_use_is_told_with_advice() {
    let (_server, address) = server().await;
    let SocketAddr::V4(here) = address else { panic!("no address of IPv4") };
    let session = Session::<N, CAP>::new(DeviceMachine::new(Options::default()));
    let error = Server::bind(session, here).await.unwrap_err();
    assert_eq!(error.to_string(), format!("{here}: the port is in use: does another program listen there?"));
}
