//! Laws of the conduct of every message, in every state of the master: after a stop, no message is sent that may move a
//! motor, and a message that is not repeatable is sent at most once.

use super::world::*;
use hoot_proto::host::{Command, Input, Options, Output, State, StopState};
use hoot_proto::message::{self, HostMessage, Motor, Reply, ResponseCode};
use hoot_proto::{Address, Messages, Millis, Table};

const STATUS: HostMessage<'static> = HostMessage::RunStatus(message::RunStatus {});

/// Messages of every row, one of each conduct, from bodies of every length and a few patterns; and messages without a
/// type.
fn messages() -> Vec<HostMessage<'static>> {
    let mut found: Vec<HostMessage<'static>> = Vec::new();
    for kind in HostMessage::ALL {
        let mut conducts = Vec::new();
        for len in 0..12_u8 {
            for body in [vec![0; len.into()], vec![0x3f; len.into()], (0..len).collect(), (1..=len).collect()] {
                let Ok(message) = HostMessage::decode_body(kind.number, body.leak()) else { continue };
                if message.name() == kind.name && !conducts.contains(&message.conduct()) {
                    conducts.push(message.conduct());
                    found.push(message);
                }
            }
        }
        let wanted = if kind.conduct.is_some() { 1 } else { 2 };
        assert_eq!(conducts.len(), wanted, "{}", kind.name);
    }
    found.extend([0x32_00, 0x32_01, 0x2_09_00, 0x1_09_00].map(|number| HostMessage::other(number, &[])));
    found
}

fn address_of(message: &HostMessage<'_>) -> Address {
    if message.selector().table == Table::Broadcast { Address::BROADCAST } else { NODE }
}

/// Masters in each state, with descriptions.
fn masters(options: Options) -> Vec<(&'static str, Master)> {
    let new = || Master::new(options);
    let speed = |speed| Command::Speed { to: NODE, motor: Motor::Two, speed: message::StepsPerSecond(speed) };
    let with = |act: &dyn Fn(&mut Master)| {
        let mut master = new();
        act(&mut master);
        master
    };
    let mut asking = new();
    let _ = asking.order(Command::EmergencyStop);
    while asking.machine.stopping() != StopState::Asking {
        let _ = asking.wait(300);
    }
    let masters = vec![
        ("offline", Master::offline(options, &[NODE])),
        ("idle", new()),
        (
            "inside the gap",
            with(&|master| {
                let _ = master.request(90, STATUS);
                master.now += 10;
                let _ = master.reply(1, &[0, 0]);
                master.now += 40;
                let _ = master.step(Input::Wake);
            }),
        ),
        ("waiting for a query", with(&|master| drop(master.request(90, STATUS)))),
        ("waiting for a start", with(&|master| drop(master.request(90, START)))),
        ("waiting for a stop", with(&|master| drop(master.request(90, STOP)))),
        ("waiting for a speed", with(&|master| drop(master.order(speed(5.0))))),
        ("waiting for a speed of 0", with(&|master| drop(master.order(speed(0.0))))),
        ("waiting for a keep-alive", with(&|master| drop(master.order(Command::KeepAlive { to: NODE, on: true })))),
        (
            "settling",
            with(&|master| {
                let _ = master.request(90, STATUS);
                master.now += 70;
                let _ = master.reply(1, &[0, 0]);
            }),
        ),
        (
            "quiet",
            with(&|master| {
                let assign = message::BroadcastAssignAddress::new(Address(9)).unwrap();
                drop(master.request_to(90, Address::BROADCAST, assign.into()));
            }),
        ),
        ("with a full queue", with(&|master| (80..90).for_each(|token| drop(master.request(token, STATUS))))),
        ("stopping", with(&|master| drop(master.order(Command::EmergencyStop)))),
        ("asking", asking),
    ];
    for state in State::ALL {
        assert!(masters.iter().any(|(_, master)| master.machine.state() == state), "{state}");
    }
    for state in StopState::ALL {
        assert!(masters.iter().any(|(_, master)| master.machine.stopping() == state), "{state}");
    }
    masters
}

/// Lets time pass, with an OK to every packet or with silence. Returns every packet that is sent.
fn leaving(master: &Master, first: &Output<'static>, answers: bool) -> Vec<HostMessage<'static>> {
    let (mut machine, mut now, mut wake) = (master.machine.clone(), master.now, master.wake);
    let mut packet = first.packets().first().copied();
    let mut found = Vec::new();
    while now < master.now + 20_000 {
        found.extend(packet.map(|packet| packet.message));
        let data: &[u8] = if packet.is_some_and(|packet| packet.message.query().is_some()) { &[0, 0] } else { &[] };
        let input = match (packet, wake) {
            (Some(_), _) if answers => Input::Received(Reply { code: ResponseCode::OK, data }.into()),
            (_, Some(wake)) => {
                now = wake.0;
                Input::Wake
            }
            (_, None) => break,
        };
        let output = machine.advance(Millis(now), input);
        packet = output.packets().first().copied();
        wake = output.wake;
    }
    found
}

#[test]
fn after_a_stop_nothing_leaves_that_may_move() {
    let mut stopped = 0;
    for options in [Options::new(), Options::new().with_bridge(false)] {
        for (state, master) in masters(options) {
            for message in messages() {
                let mut asked = master.clone();
                let to = address_of(&message);
                let submitted = asked.request_to(1, to, message);
                let its_motor = Motor::new(message.selector().sub_address).unwrap_or_default();
                let all_stop = (Address::BROADCAST, message::BroadcastStop::default().into());
                let stops = [(NODE, STOP), (NODE, PAUSE), (NODE, motor_stop(its_motor)), all_stop];
                let requests = stops.map(|(to, stop)| Some((to, stop)));
                for stop in requests.into_iter().chain([None]) {
                    for answers in [false, true] {
                        let mut master = asked.clone();
                        let output = match stop {
                            Some((to, stop)) => master.request_to(2, to, stop),
                            None => master.order(Command::EmergencyStop),
                        };
                        let left = leaving(&master, &output, answers);
                        assert!(
                            !left.iter().any(|left| left.conduct().may_move()),
                            "{state}: {message} left after {stop:?}: {left:?}"
                        );
                        stopped += usize::from(submitted.packets().is_empty() && message.conduct().may_move());
                    }
                }
            }
        }
    }
    assert!(stopped > 500, "{stopped}");
}

#[test]
fn in_silence_a_message_that_is_not_repeatable_is_sent_once() {
    let mut repeated = 0;
    for options in [Options::new(), Options::new().with_bridge(false)] {
        for (state, master) in masters(options) {
            for message in messages() {
                let mut master = master.clone();
                let output = master.request_to(1, address_of(&message), message);
                let times = leaving(&master, &output, false).iter().filter(|left| **left == message).count();
                let most = if message.conduct().repeatable { usize::MAX } else { 1 };
                // The query of a keep-alive, and the end of joystick mode, are sent by the master itself.
                let is_own = message == joystick(NO);
                assert!(times <= most || is_own, "{state}: {message} was sent {times} times");
                repeated += usize::from(times > 1);
            }
        }
    }
    assert!(repeated > 100, "{repeated}");
}
