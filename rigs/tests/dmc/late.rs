//! Bytes that arrived in time, and are read late.

use dmc_proto::host::{Options, Outcome};
use dmc_proto::message::{Ack, AckCode, DeviceMessage, Dmx, DmxChannel, Hi, HostMessage};
use dmc_proto::{Frame, MessageId, Token};
use motion_core::time::Millis;
use motion_rigs::dmc_device::{DmcDevice, Setup};
use motion_rigs::dmc_host::{Answer, Command, DmcHost, Event};
use motion_rigs::{Host as _, LineId, Outgoing, Party};

const LINE: LineId = LineId(0);

/// Times in which the rest of a frame is read: at once, after the frame was overdue, and after its answer was.
const LATE: [u64; 3] = [0, 400, 10_000];

fn lights() -> HostMessage<'static> {
    Dmx { ramp: false.into(), start_channel: DmxChannel(1), values: &[1], tail: &[] }.into()
}

/// Messages that a party sends, as their bytes.
fn sent(party: &mut impl Party) -> Vec<Vec<u8>> {
    let bytes = |outgoing| if let Outgoing::Bytes(_, bytes) = outgoing { Some(bytes) } else { None };
    std::iter::from_fn(|| party.poll()).filter_map(bytes).collect()
}

#[test]
fn an_answer_that_is_read_late_ends_its_request() {
    for late in LATE {
        let (mut host, now) = (DmcHost::new(Options::default()), Millis(1000));
        let answer = |host: &mut DmcHost, message: DeviceMessage<'_>| {
            let request = sent(host).pop().expect("a request");
            let mut bytes = vec![0; message.encoded_len()];
            message.encode_into(Frame::decode(&request).unwrap().id(), &mut bytes).unwrap();
            bytes
        };
        host.open(now, LINE);
        let hi = answer(&mut host, Hi { dmx_count: 16, ..Hi::default() }.into());
        host.receive(now, LINE, &hi);
        host.command(now, Command::Ask(Token(1), lights()));
        let ack = answer(&mut host, Ack::new(lights().kind(), AckCode::OK).into());
        let (begin, rest) = ack.split_at(9);
        host.receive(now, LINE, begin);
        host.receive(now.after(late), LINE, rest);
        let mut events = std::iter::from_fn(|| host.next_event());
        let end = events.find_map(|event| if let Event::Ended(Token(1), end) = event { Some(end) } else { None });
        assert_eq!(end, Some(Ok::<_, Outcome<'_>>(Answer::Done)), "{late} ms");
        assert_eq!(host.held(), 0);
    }
}

#[test]
fn a_request_that_is_longer_than_devices_have_to_take_is_sent_whole() {
    static LEVELS: [u8; 1500] = [7; 1500];
    let (mut host, now) = (DmcHost::new(Options::default().with_gates(false)), Millis(1000));
    host.open(now, LINE);
    let request = sent(&mut host).pop().expect("a greeting");
    let (id, hi) = (Frame::decode(&request).unwrap().id(), DeviceMessage::from(Hi::default()));
    let mut bytes = vec![0; hi.encoded_len()];
    hi.encode_into(id, &mut bytes).unwrap();
    host.receive(now, LINE, &bytes);
    let long: HostMessage<'_> =
        Dmx { ramp: false.into(), start_channel: DmxChannel(1), values: &LEVELS, tail: &[] }.into();
    host.command(now, Command::Ask(Token(1), long));
    let frames = sent(&mut host);
    assert_eq!(frames.last().map(Vec::len), Some(long.encoded_len()), "{frames:?}");
}

#[test]
fn a_request_that_is_read_late_is_done() {
    for late in LATE {
        let (mut device, now) = (DmcDevice::new(Setup::default()), Millis(1000));
        device.open(now, LINE);
        sent(&mut device);
        let mut bytes = vec![0; lights().encoded_len()];
        lights().encode_into(MessageId(7), &mut bytes).unwrap();
        let (begin, rest) = bytes.split_at(9);
        device.receive(now, LINE, begin);
        device.receive(now.after(late), LINE, rest);
        let answers = sent(&mut device);
        let answers: Vec<_> = answers.iter().map(|bytes| Frame::decode(bytes).unwrap().id()).collect();
        assert_eq!(answers, [MessageId(7)], "{late} ms");
        assert_eq!(device.levels()[0], 1);
    }
}
