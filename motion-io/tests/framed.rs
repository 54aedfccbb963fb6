//! Typed messages through a `Framed` of `tokio_util`, in pieces of any size, between bytes that are no message.

use bytes::BytesMut;
use futures_util::future::join;
use futures_util::{SinkExt, StreamExt};
use motion_core::codec::{Codec, Item, Outgoing};
use motion_core::stream::Framing;
use motion_core::wire::{Framed as FramedSide, Messages};
use tokio::io::{AsyncWriteExt, DuplexStream, duplex};
use tokio_util::codec::Framed;

/// Header of the frames that carry messages of a side.
type HeaderOf<S> = <<S as FramedSide>::Framing as Framing>::Header;

/// End of a line with the codec of a side.
type End<O, P, F, const N: usize> = Framed<DuplexStream, Codec<O, P, F, N>>;

/// Sends messages of one side, and dirt after each, and returns what the other side reads, without noise.
///
/// Every byte that was sent is part of what is read, in order.
async fn one_way<O, P, F, G, M, const N: usize, const K: usize>(
    from: &mut End<O, P, F, N>,
    to: &mut End<P, O, G, K>,
    messages: &[M],
    dirt: &[&[u8]],
) -> Vec<Item<O, G::Header>>
where
    O: FramedSide,
    P: FramedSide,
    F: Framing<Header = HeaderOf<P>>,
    G: Framing<Header = HeaderOf<O>>,
    M: Outgoing<O> + Copy,
{
    let mut stream = BytesMut::new();
    let send = async {
        for (message, dirt) in messages.iter().zip(dirt.iter().cycle()) {
            message.put(&mut stream).unwrap();
            stream.extend_from_slice(dirt);
            from.send(*message).await.unwrap();
            from.get_mut().write_all(dirt).await.unwrap();
        }
        from.get_mut().shutdown().await.unwrap();
    };
    let receive = async {
        let (mut read, mut items) = (Vec::new(), Vec::new());
        while let Some(item) = to.next().await {
            let item = item.unwrap();
            read.extend_from_slice(item.bytes());
            match item {
                Item::Noise { .. } => {}
                // A version of kOS that is not known. The program decides that the stream goes on.
                Item::Fatal(_) => to.codec_mut().resync(),
                item => items.push(item),
            }
        }
        (read, items)
    };
    let ((), (read, items)) = join(send, receive).await;
    assert_eq!(read, stream, "every byte is part of an item");
    items
}

/// Lengths of pieces: every short one, and some longer than a frame.
fn pieces() -> impl Iterator<Item = usize> {
    (1..40).chain([64, 200, 5_000])
}

/// Number of the message with this name.
fn number<'a, M: Messages<'a>>(name: &str) -> u32 {
    M::ALL.iter().find(|kind| kind.name == name).unwrap().number
}

#[tokio::test]
async fn messages_of_kos_and_all_other_bytes_come_out_of_a_framed() {
    use kos_proto::message::{DeviceInfo, GetDeviceInfo, KeepAlive, Password, StopPlayback};
    use kos_proto::{DeviceMessage, HostMessage, device, host};
    let asks: [HostMessage<'_>; 3] =
        [KeepAlive::default().into(), GetDeviceInfo::default().into(), StopPlayback::default().into()];
    let answers: [DeviceMessage<'_>; 1] =
        [DeviceInfo { device_password: Password(b"secret"), ..DeviceInfo::default() }.into()];
    // SetLEDStatus without its fields, an unknown version, and nothing.
    let dirt: [&[u8]; 3] = [&[4, 0, 6, 0, 7, 0], &[9, 9, 9], &[]];
    for size in pieces() {
        let (here, there) = duplex(size);
        let (mut host, mut device) =
            (Framed::new(here, <host::Codec>::default()), Framed::new(there, <device::Codec>::default()));
        let read = one_way(&mut host, &mut device, &asks, &dirt).await;
        let [
            Item::Message { message: first, .. },
            Item::Undecodable { label: (), .. },
            Item::Message { message: second, .. },
            Item::Message { message: third, .. },
        ] = &read[..]
        else {
            panic!("{read:?}")
        };
        assert_eq!([first.message(), second.message(), third.message()], asks);
        let read = one_way(&mut device, &mut host, &answers, &[&[4, 0, 6, 0, 15, 2]]).await;
        let [Item::Message { message, .. }, Item::Undecodable { .. }] = &read[..] else { panic!("{read:?}") };
        assert_eq!(message.message(), answers[0]);
    }
}

#[tokio::test]
async fn messages_of_dmc_and_all_other_bytes_come_out_of_a_framed() {
    use dmc_proto::message::{Hi, HiRequest, Motor, MotorMove, Steps};
    use dmc_proto::{DeviceMessage, HostMessage, MessageId, MessageType, device, frame, host};
    let go = MotorMove { motor: Motor(1), position: Steps(-5), tail: &[] };
    let asks: [(_, HostMessage<'_>); 3] =
        [(MessageId(1), HiRequest::default().into()), (MessageId(2), go.into()), (MessageId(3), go.into())];
    let answers: [(_, DeviceMessage<'_>); 1] = [(MessageId(1), Hi::default().into())];
    let short = |name: u32| {
        let mut bytes = [0; 12];
        let kind = MessageType(u16::try_from(name).unwrap());
        assert_eq!(frame::encode(MessageId(9), kind, &[], &mut bytes), Ok(12));
        bytes
    };
    let (undecodable, mut corrupt) = (short(number::<HostMessage<'_>>("MotorMove")), short(1));
    corrupt[3] ^= 1;
    for size in pieces() {
        let (here, there) = duplex(size);
        let (mut host, mut device) =
            (Framed::new(here, <host::Codec>::default()), Framed::new(there, <device::Codec>::default()));
        let read = one_way(&mut host, &mut device, &asks, &[&undecodable, &corrupt, b"..D"]).await;
        let [
            Item::Message { label: MessageId(1), message: first, .. },
            Item::Undecodable { label: MessageId(9), .. },
            Item::Message { label: MessageId(2), message: second, .. },
            Item::Corrupt { .. },
            Item::Message { label: MessageId(3), message: third, .. },
        ] = &read[..]
        else {
            panic!("{read:?}")
        };
        assert_eq!([first.message(), second.message(), third.message()], asks.map(|(_, message)| message));
        let undecodable = short(number::<DeviceMessage<'_>>("Hi"));
        let read = one_way(&mut device, &mut host, &answers, &[&undecodable]).await;
        let [Item::Message { label: MessageId(1), message, .. }, Item::Undecodable { .. }] = &read[..] else {
            panic!("{read:?}")
        };
        assert_eq!(message.message(), answers[0].1);
    }
}

#[tokio::test]
async fn messages_of_hoot_and_all_other_bytes_come_out_of_a_framed() {
    use hoot_proto::message::{Motor, MotorPosition, Reply, Stop};
    use hoot_proto::{Address, DeviceMessage, HostMessage, device, host};
    let asks: [(_, HostMessage<'_>); 2] =
        [(Address(3), MotorPosition { motor: Motor::Two }.into()), (Address(4), Stop {}.into())];
    let answers: [DeviceMessage<'_>; 2] = [Reply::OK.into(), Reply::ERROR.into()];
    for size in pieces() {
        let (here, there) = duplex(size);
        let (mut host, mut device) =
            (Framed::new(here, <host::Codec>::default()), Framed::new(there, <device::Codec>::default()));
        let read = one_way(&mut host, &mut device, &asks, &[b"junk", &[0, 0, 0]]).await;
        let [
            Item::Message { label: Address(3), message: first, .. },
            Item::Message { label: Address(4), message: second, .. },
        ] = &read[..]
        else {
            panic!("{read:?}")
        };
        assert_eq!([first.message(), second.message()], asks.map(|(_, message)| message));
        let read = one_way(&mut device, &mut host, &answers, &[b"junk"]).await;
        let [Item::Message { message: first, .. }, Item::Message { message: second, .. }] = &read[..] else {
            panic!("{read:?}")
        };
        assert_eq!([first.message(), second.message()], answers);
    }
}
