//! Datagrams of kOS over loopback.

use kos_proto::discovery::{Datagram, Event};
use kos_proto::message::{GetNetworkInfo, Ipv4, NetworkInfo};
use motion_io::kos::{Discovery, socket};

#[tokio::test]
async fn a_device_that_is_asked_is_found() {
    let device = socket("127.0.0.1:0").await.unwrap();
    let there = device.local_addr().unwrap();
    let mut discovery = Discovery::listen("127.0.0.1:0").await.unwrap();
    discovery.ask(there).await.unwrap();

    let mut bytes = [0; 64];
    let (len, client) = device.recv_from(&mut bytes).await.unwrap();
    let question = Datagram::decode(&bytes[..len]).unwrap();
    assert_eq!(question, Datagram::Question(GetNetworkInfo::new(false)));

    // A datagram that is no message is dropped.
    device.send_to(b"noise", client).await.unwrap();
    let answer = Datagram::Announcement(NetworkInfo::default());
    let len = answer.encode_into(&mut bytes).unwrap();
    device.send_to(&bytes[..len], client).await.unwrap();
    let Event::Found(found) = discovery.next().await else { panic!("not found") };
    assert_eq!(found.address(), Ipv4(0x7F00_0001));
    assert_eq!(discovery.devices().collect::<Vec<_>>(), [&found]);
}

#[tokio::test]
async fn a_port_that_is_in_use_is_told_with_advice() {
    let taken = socket("127.0.0.1:0").await.unwrap().into_std().unwrap();
    let address = taken.local_addr().unwrap();
    let error = Discovery::listen(address).await.unwrap_err().to_string();
    assert_eq!(error, format!("{address}: the port is in use: does another program listen there?"));
}
