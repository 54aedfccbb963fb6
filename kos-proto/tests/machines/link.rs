//! Link and lock of the device: kOS 7.1.

use kos_proto::Transport;
use kos_proto::device::clients::State;
use kos_proto::device::{Actions, DisconnectReason, Event, Ignored, Input, Options, Quirks, Report, Sender, SessionId};
use kos_proto::message::*;
use kos_proto::{DecodeError, HostMessage, MessageId, MessageType};
use motion_core::wire::Messages;

use super::bench::*;

const LIMITED: HostMessage<'static> = HostMessage::GetNetworkInfo(GetNetworkInfo { limited_response: None, tail: &[] });
const FROM: Sender = Sender { address: Ipv4(0xc0a8_3207), port: 5520 };
const DEVICE_INFO: HostMessage<'static> = HostMessage::GetDeviceInfo(GetDeviceInfo { tail: &[] });

/// A device with a password, and a client over TCP that has not sent the password yet.
fn locked() -> Bench {
    locked_with(Options::default())
}

fn locked_with(options: Options) -> Bench {
    let mut bench = Bench::off(options);
    bench.password = b"open";
    bench.rig(Report::Started);
    bench.open(ZERO, Transport::Tcp);
    bench.clear();
    bench
}

/// 7.1-1, 7.1-3: the device announces its address until a client connects, and again after the last client is gone.
#[test]
fn a_device_announces_itself_while_no_client_is_connected() {
    let mut bench = Bench::off(Options::default());
    bench.pass(60_000);
    assert_eq!((bench.messages().len(), bench.machine.link().name()), (0, "Rebooting"));
    bench.rig(Report::Started);
    bench.pass(12_000);
    assert_eq!(bench.messages(), ["all: NetworkInfo"; 3], "at once, after 5 s, after 10 s");
    assert_eq!(bench.machine.link().name(), "Advertising");

    bench.open(ZERO, Transport::Tcp);
    assert_eq!(bench.machine.link().name(), "Connected");
    bench.pass_with_client(20_000);
    assert_eq!(bench.messages().len(), 0);
    bench.step(Input::LinkDown(ZERO));
    bench.pass(4999);
    assert_eq!(bench.messages().len(), 0);
    bench.pass(1);
    assert_eq!(bench.messages(), ["all: NetworkInfo"]);
}

/// 7.1-2.
#[test]
fn a_question_by_datagram_is_answered_to_the_receivers_that_it_names() {
    let mut bench = Bench::new(Options::default());
    let datagram = |message| Input::Datagram { from: FROM, message };
    let ask = |limited| datagram(GetNetworkInfo::new(limited).into());
    bench.step(ask(true));
    bench.step(ask(false));
    bench.step(datagram(LIMITED));
    assert_eq!(
        bench.messages(),
        ["all: NetworkInfo", "192.168.50.7:5520: NetworkInfo", "192.168.50.7:5520: NetworkInfo"]
    );
    bench.step(datagram(STOP));
    assert_eq!(bench.events(), [Event::Ignored(Ignored::Datagram)]);
}

/// 7.1-3: without a password there is no lock, unless the device asks for the empty password (decision K-P4).
#[test]
fn a_device_without_a_password_is_not_locked() {
    assert_eq!(Bench::new(Options::default()).machine.session(ZERO), State::Unlocked);
    assert_eq!(locked().machine.session(ZERO), State::Locked);
    let mut strict = Bench::new(Options::default().with_quirks(Quirks::REQUIRE_EMPTY_PASSWORD));
    assert_eq!(strict.machine.session(ZERO), State::Locked);
    strict.receive(user_password(b""));
    assert_eq!(strict.machine.session(ZERO), State::Unlocked);
}

/// 7.1-4: over USB no password is needed, and a wrong one has no effect (decision K-U7).
#[test]
fn a_device_is_not_locked_over_usb() {
    let mut bench = locked();
    bench.open(ONE, Transport::Usb);
    assert_eq!(bench.machine.session(ONE), State::Unlocked);
    bench.from(ONE, user_password(b"wrong"));
    assert_eq!((bench.machine.session(ONE), bench.messages().len()), (State::Unlocked, 0));
    bench.from(ONE, device_password(b"other"));
    assert_eq!(bench.machine.session(ONE), State::Unlocked);
    // A client over USB does not count as a client over TCP.
    bench.step(Input::LinkDown(ZERO));
    assert_eq!(bench.machine.link().name(), "Advertising");
}

/// 7.1-5, 7.1-9: any message keeps the connection, also one that is cut short, or that a locked client may not send.
#[test]
fn any_message_is_a_sign_of_life() {
    let error = DecodeError::Truncated { what: "x", needed: 1, have: 0 };
    let malformed = Input::Malformed {
        session: ZERO,
        id: MessageId::LED_STATUS,
        kind: MessageType::SET,
        error,
        bytes: &[4, 0, 7, 0, 7, 0, 1],
    };
    let mut bench = locked();
    for round in 0..6 {
        bench.pass(29_000);
        match round % 3 {
            0 => bench.receive(KeepAlive::default()),
            1 => bench.receive(GetMotorInfo::default()),
            _ => bench.step(malformed),
        }
        assert_eq!(bench.machine.session(ZERO), State::Locked);
    }
    assert_eq!(bench.messages().len(), 0, "a keep-alive is not answered, nor is the rest");
    bench.pass(30_000);
    assert_eq!(bench.machine.session(ZERO), State::Closed);
}

/// 7.1-6.
#[test]
fn a_locked_device_tells_what_it_is_and_its_address() {
    let mut bench = locked();
    bench.receive(DEVICE_INFO);
    bench.receive(LIMITED);
    assert_eq!(bench.messages(), ["0: DeviceInfo NO_MOVE", "0: NetworkInfo"]);
}

/// 7.1-7, 7.1-8, 7.1-12: NULs that end a password do not count (decision K-T2).
#[test]
fn the_password_opens_and_closes_the_lock() {
    let mut bench = locked();
    bench.receive(user_password(b"opem"));
    assert_eq!(bench.messages(), ["0: error 15 0"]);
    assert_eq!(bench.events(), [Event::Ignored(Ignored::WrongPassword(ZERO))]);
    for right in [&b"open"[..], b"open\0"] {
        bench.receive(user_password(right));
        assert_eq!((bench.machine.session(ZERO), bench.messages().len()), (State::Unlocked, 0));
    }
    bench.receive(user_password(b"ope"));
    assert_eq!((bench.machine.session(ZERO), bench.messages()), (State::Locked, vec!["0: error 15 0".into()]));
}

/// 7.1-10: answers to all clients go to the locked client that sent the stop too, also later ones (safety decision 2).
#[test]
fn a_stop_needs_no_password() {
    let mut bench = locked();
    bench.open(ONE, Transport::Usb);
    bench.from(ONE, set_psa(1, 25_000.0, 10.0));
    bench.from(ONE, set_psa(2, 25_000.0, 10.0));
    bench.clear();
    bench.receive(set_psa(1, 0.0, 0.0));
    let stopped = bench.events();
    assert!(matches!(stopped[..], [Event::StopMotor { motor: MotorAddress(1), .. }]), "{stopped:?}");
    bench.arrive(1, 3.0);
    assert_eq!(bench.messages(), ["01: 1 rests at 3.0"]);

    bench.receive(bump(2, 7.0, 0.0));
    assert!(matches!(bench.events()[..], [Event::StopMotor { motor: MotorAddress(2), .. }]));
    bench.receive(STOP);
    assert_eq!(bench.events(), [Event::StopAll]);
    assert_eq!(bench.messages(), ["01: FULL_STOP", "01: 1 rests at 3.0", "01: 3 rests at 0.0"]);
    bench.arrive(2, 4.0);
    assert_eq!(bench.messages(), ["01: 2 rests at 4.0"]);
    // The locked client does not get the next report of rest, because it did not ask for that motion.
    bench.from(ONE, set_psa(2, 5.0, 10.0));
    bench.arrive(2, 5.0);
    assert_eq!(bench.messages(), ["1: 2 rests at 5.0"]);
}

/// 7.1-10: with the quirk, stops are ignored as well until the password comes (decision K-S23).
#[test]
fn a_locked_device_may_ignore_stops() {
    let mut bench = locked_with(Options::default().with_quirks(Quirks::LOCKED_IGNORES_STOPS));
    for stop in [STOP, set_psa(1, 0.0, 0.0), bump(1, 0.0, 0.0)] {
        let before = bench.machine.clone();
        bench.receive(stop);
        assert_eq!(bench.events(), [Event::Ignored(Ignored::Locked(ZERO))], "{stop}");
        assert_eq!((bench.messages().len(), &bench.machine), (0, &before), "{stop}");
    }
    bench.receive(DEVICE_INFO);
    bench.receive(user_password(b"open"));
    bench.receive(STOP);
    assert_eq!(bench.events(), [Event::StopAll]);
}

/// 7.1-17: an action that the device does not know is sent back, stops included, and so is `SoftwareID` (decision K-S24).
#[test]
fn a_device_may_not_know_an_action() {
    let unsupported = [0x28, 0x06, 200].into_iter().map(ActionId).fold(Actions::NONE, Actions::with);
    assert!(unsupported.contains(ActionId::STOP_PLAYBACK) && !unsupported.contains(ActionId::START_PLAYBACK));
    let quirks = Quirks::NO_SOFTWARE_ID;
    let mut bench = Bench::new(Options::default().with_unsupported(unsupported).with_quirks(quirks));
    let platform = SoftwareID { platform: 4, tail: &[] };
    for message in [bump(1, 5.0, 10.0), bump(1, 5.0, 0.0), STOP, GetSoftwareID::default().into(), platform.into()] {
        bench.receive(message);
        assert_eq!(bench.events(), [Event::Ignored(Ignored::Unsupported(ZERO))], "{message}");
        assert!(bench.messages()[0].starts_with("0: UnsupportedMessage(["), "{message}");
    }
    bench.receive(set_psa(1, 5.0, 10.0));
    assert!(matches!(bench.events()[..], [Event::Move { .. }]), "all else is known");
}

/// 7.1-11: no other message is answered or has an effect.
#[test]
fn a_locked_device_ignores_everything_else() {
    let motions = [set_psa(1, 5.0, 10.0), bump(1, 5.0, 10.0), start(), setup(false), mark_begin(1), reset_axis(0)];
    let gets = [GetMotorInfo::default().into(), GetDeviceGUID::default().into(), device_password(b"")];
    for message in motions.into_iter().chain(gets).chain([ResetDevice::default().into()]) {
        let mut bench = locked();
        let before = bench.machine.clone();
        bench.receive(message);
        assert_eq!(bench.events(), [Event::Ignored(Ignored::Locked(ZERO))], "{message}");
        assert_eq!((bench.messages().len(), &bench.machine), (0, &before), "{message}");
    }
}

/// 7.1-13, 7.1-14: an unlocked client knew the old password, so only the same password keeps the lock open.
#[test]
fn a_new_password_locks_the_clients() {
    let mut bench = locked();
    bench.open(ONE, Transport::Tcp);
    for session in [ZERO, ONE] {
        bench.from(session, user_password(b"open"));
    }
    bench.receive(device_password(b"open"));
    assert_eq!([ZERO, ONE].map(|session| bench.machine.session(session)), [State::Unlocked; 2]);
    bench.receive(device_password(b"new"));
    assert_eq!([ZERO, ONE].map(|session| bench.machine.session(session)), [State::Locked; 2]);
    assert_eq!(bench.events(), [Event::StorePassword(Password(b"open")), Event::StorePassword(Password(b"new"))]);
    bench.password = b"new";
    bench.receive(user_password(b"new"));
    assert_eq!([ZERO, ONE].map(|session| bench.machine.session(session)), [State::Unlocked, State::Locked]);
}

/// 7.1-13: a client that is locked gets no more messages, from the same step on.
#[test]
fn a_locked_client_gets_no_reports() {
    let mut bench = Bench::loaded(Options::default(), live_move(live()));
    bench.receive(start());
    bench.home();
    bench.pass(9_999);
    bench.clear();
    bench.now += 1;
    bench.receive(device_password(b"new"));
    assert_eq!(
        (bench.events(), bench.messages().len()),
        (vec![Event::StorePassword(Password(b"new")), Event::MoveOver], 0)
    );
}

/// 7.1-15: each message has one motor, and all except the last announce more (decision K-M3).
#[test]
fn every_question_is_answered() {
    let mut bench = Bench::new(Options::default().with_platform(7));
    bench.calibrate(2);
    bench.clear();
    bench.receive(GetMotorInfo::default());
    assert_eq!(
        bench.messages(),
        ["0: 1 at 0.0 of 0.0 to 0.0, more", "0: 2 at 8.0 of 0.0 to 8.0, more", "0: 3 at 0.0 of 0.0 to 0.0"]
    );
    for get in [
        GetLEDStatus::default().into(),
        DEVICE_INFO,
        GetTrajectoryData::default().into(),
        GetDeviceGUID::default().into(),
        GetSoftwareID::default().into(),
    ] {
        bench.receive(get);
    }
    let answers = [
        "0: LedStatus { master: LedMode(OFF), slave: LedMode(OFF) }",
        "0: DeviceInfo NO_MOVE",
        "0: TrajectoryData { stored: false }",
        "0: DeviceGuid",
        "0: SoftwareId { platform: 7 }",
    ];
    assert_eq!(bench.messages(), answers);

    let mut bare = Bench::new(Options::default().with_motors(MotorSet::NONE));
    bare.receive(GetMotorInfo::default());
    assert_eq!(bare.messages(), ["0: MotorInfo { motor: None, more: false }"]);
}

/// 7.1-16.
#[test]
fn settings_are_stored_without_an_answer() {
    let mut bench = Bench::new(Options::default());
    let leds = |master| LEDStatus { master_status: LedMode(master), slave_status: LedMode::OFF, tail: &[] };
    bench.receive(HostMessage::from(leds(2)));
    bench.receive(HostMessage::from(leds(9)));
    bench.receive(HostMessage::from(SoftwareID { platform: 4, tail: &[] }));
    bench.receive(HostMessage::from(live_move(live())));
    assert_eq!(bench.messages().len(), 0);
    let (master, slave) = (LedMode::SLOW_BLINK, LedMode::OFF);
    let told = [
        Event::Leds { master, slave },
        Event::Ignored(Ignored::Unsupported(ZERO)),
        Event::StorePlatform(4),
        Event::StoreTrajectory(live_move(live())),
    ];
    assert_eq!(bench.events(), told);
    bench.receive(GetLEDStatus::default());
    bench.receive(GetSoftwareID::default());
    bench.receive(GetTrajectoryData::default());
    let answers = [
        "0: LedStatus { master: LedMode(SLOW_BLINK), slave: LedMode(OFF) }",
        "0: SoftwareId { platform: 4 }",
        "0: TrajectoryData { stored: true }",
    ];
    assert_eq!(bench.messages(), answers);
}

/// Message without a body, in bytes.
fn bytes_of(number: u32) -> Vec<u8> {
    let mut bytes = vec![0; 7];
    let len = HostMessage::other(number, &[]).encode_into(&mut bytes).unwrap();
    bytes.truncate(len);
    bytes
}

/// 7.1-17: an unknown message is sent back, except messages that only devices send (decision K-P10).
#[test]
fn an_unknown_message_is_sent_back() {
    let mut bench = Bench::new(Options::default());
    let of_unknown_type = [0x000F_0300, 0x000F_0700, 0x0080_FF00];
    for number in [0x0025_0100, 0x0002_0000, 0x000B_0000, 0x0080_0008, 0x0077_0000].into_iter().chain(of_unknown_type) {
        bench.receive(HostMessage::other(number, &[]));
        let frame = format!("{:?}", bytes_of(number));
        assert_eq!(bench.messages(), [format!("0: UnsupportedMessage({frame})")]);
        assert_eq!(bench.events(), [Event::Ignored(Ignored::Unsupported(ZERO))]);
    }
    for number in [0x0081_02FF, 0x0081_0000, 0x000F_0200, 0x000B_8200] {
        bench.receive(HostMessage::other(number, &[]));
        assert_eq!(bench.messages().len(), 0, "{number:#x}");
        assert_eq!(bench.events(), [Event::Ignored(Ignored::NotForDevices(ZERO))]);
    }
    // A message that is cut short is sent back too (decision K-S4).
    let error = DecodeError::Truncated { what: "SetLEDStatus", needed: 2, have: 1 };
    bench.step(Input::Malformed {
        session: ZERO,
        id: MessageId::LED_STATUS,
        kind: MessageType::SET,
        error,
        bytes: &[4, 0, 7, 0, 7, 0, 1],
    });
    assert_eq!(bench.messages(), ["0: UnsupportedMessage([4, 0, 7, 0, 7, 0, 1])"]);
    assert_eq!(bench.events()[0], Event::Ignored(Ignored::Malformed(ZERO, error)));
}

/// 7.1-18: everything stops before the device restarts, and no client gets an answer until it has started.
#[test]
fn a_reset_stops_everything_and_closes_the_connections() {
    let mut bench = Bench::loaded(Options::default(), live_move(live()));
    bench.open(ONE, Transport::Usb);
    bench.receive(start());
    bench.clear();
    bench.receive(ResetDevice::default());
    let reason = DisconnectReason::Reset;
    assert_eq!(
        bench.events(),
        [
            Event::StopAll,
            Event::Disconnect { session: ZERO, reason },
            Event::Disconnect { session: ONE, reason },
            Event::Reboot
        ]
    );
    assert_eq!((bench.machine.link().name(), bench.wake), ("Rebooting", None));
    bench.open(ZERO, Transport::Tcp);
    bench.arrive(3, 0.0);
    assert_eq!(bench.events(), [Event::Ignored(Ignored::Off); 2]);
    bench.home();
    bench.rig(Report::Started);
    assert_eq!((bench.machine.link().name(), bench.state()), ("Advertising", "Empty"));
    bench.rig(Report::Started);
    assert_eq!(bench.events(), [Event::Ignored(Ignored::Report)]);
}

/// 7.1-19: the address goes to a locked client too, but only over TCP.
#[test]
fn a_device_tells_its_address_over_tcp_if_the_option_is_set() {
    let mut bench = Bench::off(Options::default().with_push_every(Some(5_000)));
    bench.password = b"open";
    bench.rig(Report::Started);
    bench.open(ZERO, Transport::Tcp);
    bench.open(ONE, Transport::Usb);
    bench.clear();
    bench.pass(9_999);
    assert_eq!(bench.messages(), ["0: NetworkInfo"]);
    bench.pass(1);
    assert_eq!(bench.messages(), ["0: NetworkInfo"]);
}

/// 7.1-20: when a client is gone, only the motors that it moved by hand stop.
#[test]
fn motors_stop_when_the_client_that_moved_them_by_hand_is_gone() {
    let why = [DisconnectReason::Silence, DisconnectReason::Framing];
    for gone in 0..3 {
        let mut bench = Bench::new(Options::default());
        bench.open(ONE, Transport::Usb);
        bench.receive(set_psa(1, 25_000.0, 10.0));
        bench.from(ONE, set_psa(2, 25_000.0, 10.0));
        bench.clear();
        match gone {
            0 => {
                for _ in 0..4 {
                    bench.pass(7_500);
                    bench.from(ONE, KeepAlive::default());
                }
            }
            1 => bench.step(Input::Fatal(ZERO)),
            _ => bench.step(Input::LinkDown(ZERO)),
        }
        let mut told = bench.events();
        if let Some(&reason) = why.get(gone) {
            assert_eq!(told.pop(), Some(Event::Disconnect { session: ZERO, reason }), "after the stop");
        }
        assert_eq!(told, [Event::StopMotor { motor: MotorAddress(1), acceleration: None }]);
        assert_eq!(bench.machine.session(ZERO), State::Closed);
        assert_eq!(bench.machine.session(ONE), State::Unlocked);
        bench.clear();
        bench.arrive(1, 4.0);
        assert_eq!(bench.messages(), ["1: 1 rests at 4.0"], "who is left is told");
    }
    let mut bench = Bench::new(Options::default());
    bench.open(ONE, Transport::Usb);
    bench.pass(9_999);
    assert_eq!(bench.machine.session(ONE), State::Unlocked);
    bench.pass(1);
    assert_eq!(bench.machine.session(ONE), State::Closed);
}

/// 7.1-20: a move goes on without a client, unless the options say otherwise (decision K-S5).
#[test]
fn a_move_goes_on_without_clients_unless_an_option_says_otherwise() {
    for stops in [false, true] {
        let mut bench = Bench::loaded(Options::default().with_stop_when_alone(stops), live_move(live()));
        bench.receive(start());
        bench.home();
        assert_eq!(bench.state(), "Forward");
        bench.clear();
        bench.step(Input::LinkDown(ZERO));
        assert_eq!(bench.events().contains(&Event::StopAll), stops);
        assert_eq!(bench.messages().len(), 0, "nobody is there to be told");
        assert_eq!(bench.state(), if stops { "Empty" } else { "Forward" });
    }
}

/// 7.1-21: a motor that comes back has no range, because its position is unknown.
#[test]
fn motors_come_and_go() {
    let mut bench = locked();
    bench.open(ONE, Transport::Usb);
    bench.from(ONE, KeepAlive::default());
    bench.rig(Report::Online(MotorAddress(2), false));
    bench.rig(Report::Online(MotorAddress(2), false));
    bench.rig(Report::Online(MotorAddress(2), true));
    assert_eq!(bench.messages(), ["1: 2 online false", "1: 2 online true"], "the locked one is not told");
    bench.rig(Report::Online(MotorAddress(11), true));
    assert_eq!(bench.events(), [Event::Ignored(Ignored::Report); 2]);
}

/// 7.3-15: nobody knows whether a stop arrived at a motor that was gone.
#[test]
fn a_motor_that_went_while_it_moved_is_stopped_when_it_comes_back() {
    let mut bench = Bench::new(Options::default());
    bench.receive(set_psa(2, 25_000.0, 9.0));
    bench.clear();
    let (motor, acceleration) = (MotorAddress(2), None);
    for online in [false, true] {
        bench.rig(Report::Online(motor, online));
        assert_eq!(bench.events(), [Event::StopMotor { motor, acceleration }], "{online}");
    }
    let motion = |bench: &Bench| bench.machine.motor(motor).map(|drive| drive.motion().name());
    assert_eq!(motion(&bench), Some("Stopping"));
    bench.arrive(2, 7.0);
    assert_eq!(motion(&bench), Some("Resting"));
    for online in [false, true] {
        bench.rig(Report::Online(motor, online));
        assert_eq!(bench.events(), [], "a motor that rests is only noted");
    }
}

/// 7.1-22.
#[test]
fn changes_of_inputs_are_told() {
    let mut bench = Bench::new(Options::default());
    bench.rig(Report::Inputs(AuxInputs::MASTER_TIP));
    assert_eq!(bench.messages(), ["0: AuxInputStatus(AuxInputs(MASTER_TIP))"]);
}

#[test]
fn a_fifth_client_is_disconnected() {
    let mut bench = Bench::new(Options::default());
    bench.open(SessionId(4), Transport::Tcp);
    assert_eq!(bench.events(), [Event::Disconnect { session: SessionId(4), reason: DisconnectReason::NoRoom }]);
    bench.from(SessionId(3), STOP);
    assert_eq!(bench.events(), [Event::Ignored(Ignored::NoSession(SessionId(3)))]);
}
