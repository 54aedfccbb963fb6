//! Connection of a client: kOS 7.2. The client connects, asks for the facts of the device, and keeps the line alive.

use core::net::Ipv4Addr;

use kos_proto::discovery::{self, Datagram, Devices};
use kos_proto::host::*;
use kos_proto::message::*;
use kos_proto::{DecodeError, DeviceMessage, MessageId, MessageType, Millis};
use motion_core::wire::Messages;

use super::client::*;

const ASKS: Transmit<'static> = Transmit::Get(Get::DeviceInfo);
/// Report that the password is wrong.
const LOCKED: Event<'static> = Event::Locked { wrong_password: true };
const PING: Transmit<'static> = Transmit::Get(Get::NetworkInfo);

fn network_info() -> NetworkInfo<'static> {
    NetworkInfo {
        dhcp: Bool::TRUE,
        mac_address: [0, 1, 2, 3, 4, 5].into(),
        ip_address: Ipv4(0xc0a8_3201),
        subnet_mask: Ipv4(0xffff_ff00),
        gateway: Ipv4(0),
        device_type: DeviceType::SECOND_SHOOTER_PRO,
        device_addr: 0,
        tail: &[],
    }
}

/// 7.2-1: `discovery::Devices` lists the devices; the client only connects.
#[test]
fn an_announcement_gives_the_address_of_a_device() {
    let mut bytes = [0; 27];
    Datagram::Announcement(network_info()).encode_into(&mut bytes).unwrap();
    let source = Ipv4Addr::new(192, 168, 50, 1).into();
    let devices: Devices = Devices::default();
    let (_, output) = devices.step(Millis(0), discovery::Input::Datagram { source, bytes: &bytes });
    let Ok(Some(discovery::Event::Found(device))) = output.heard else { panic!("{output:?}") };
    let mut client = Client::new(Options::default());
    client.command(Command::Connect(Endpoint::Tcp(device.address())));
    assert_eq!(client.events(), [Event::Connect(AT)]);
    // A message without a connection is ignored.
    let mut client = Client::new(Options::default());
    client.receive(DeviceMessage::from(network_info()));
    assert_eq!((client.events(), client.state()), (vec![Event::Ignored], "Discovering"));
}

/// 7.2-2.
#[test]
fn a_client_asks_for_devices_if_the_option_is_set() {
    let mut client = Client::new(Options::default().with_ask_every(Some(Options::ASK_EVERY)));
    client.step(Input::Wake);
    client.pass(9_999);
    assert_eq!(client.sent(), [Transmit::Discover; 2]);
    client.pass(1);
    assert_eq!(client.sent(), [Transmit::Discover]);
    client.command(Command::Connect(AT));
    client.pass(60_000);
    assert_eq!(client.sent(), []);
    let mut quiet = Client::new(Options::default());
    quiet.pass(60_000);
    assert_eq!((quiet.sent(), quiet.wake), (vec![], None));
}

/// 7.2-3: the client connects once, and sends nothing before.
#[test]
fn a_client_connects_to_the_endpoint_of_the_command() {
    let mut client = Client::new(Options::default());
    for command in [Command::Disconnect, Command::Get(Get::LedStatus), load(), Command::ChangePassword] {
        assert_eq!(client.refused(command), Some(Refusal::NotConnected), "{command:?}");
    }
    client.step(Input::LinkUp);
    assert_eq!(client.events(), [Event::Ignored]);
    client.command(Command::Connect(AT));
    assert_eq!((client.events(), client.state()), (vec![Event::Connect(AT)], "Connecting"));
    assert_eq!(client.refused(Command::Connect(Endpoint::Usb)), Some(Refusal::Connected));
}

/// 7.2-4.
#[test]
fn the_first_question_asks_what_the_device_is() {
    let mut client = Client::connected(Options::default(), AT);
    assert_eq!((client.sent(), client.state()), (vec![ASKS], "AwaitDeviceInfo"));
    assert_eq!(client.refused(load()), Some(Refusal::NotReady));
}

/// 7.2-5.
#[test]
fn the_password_and_a_question_for_the_motors_follow() {
    for (echo, password) in [(true, PasswordOf::Device(Password(b"open"))), (false, PasswordOf::User)] {
        let mut client = Client::connected(Options::default().with_echo_password(echo), AT);
        client.clear();
        client.receive(device_info(PlaybackState::NO_MOVE));
        assert_eq!(client.sent(), [Transmit::UserPassword(password), Transmit::Get(Get::MotorInfo)]);
        assert_eq!(client.state(), "AwaitMotorInfo");
    }
    // Over USB a password is neither required nor supported (decision K-U7).
    let mut client = Client::connected(Options::default(), Endpoint::Usb);
    client.clear();
    client.receive(device_info(PlaybackState::NO_MOVE));
    assert_eq!((client.sent(), client.state()), (vec![Transmit::Get(Get::MotorInfo)], "AwaitMotorInfo"));
}

/// 7.2-6, 7.2-7: each message of the series has the full time. A message may contain several motors (K-F10).
#[test]
fn the_motors_are_reported_one_by_one() {
    let mut client = Client::connected(Options::default(), AT);
    client.receive(device_info(PlaybackState::NO_MOVE));
    client.clear();
    for motor in 1..=10 {
        client.pass(2_999);
        client.motor(motor, 0.0, 0.0, true);
        assert_eq!((client.events(), client.state()), (vec![], "AwaitMotorInfo"));
    }
    // An eleventh motor and a motor with an invalid address are ignored.
    client.motor(11, 0.0, 0.0, true);
    client.motor(0, 0.0, 0.0, true);
    assert_eq!(client.events(), [Event::Ignored; 2]);
    client.motor(0x8A, 5.0, 0.0, false);
    assert_eq!((client.events(), client.state()), (vec![Event::Motors], "AwaitGuid"));
    assert_eq!(client.machine.motors().count(), 10);
    assert_eq!(client.machine.motors().last().map(|motor| motor.position), Some(Rotations(5.0)));
    assert_eq!(client.sent().pop(), Some(Transmit::Get(Get::DeviceGuid)));
}

/// 7.2-7: a motor that is not in a new series is removed.
#[test]
fn a_new_series_tells_which_motors_are_there() {
    let mut client = Client::ready();
    client.command(Command::Get(Get::MotorInfo));
    client.motor(2, 1.0, 0.0, true);
    client.motor(3, 1.0, 0.0, false);
    assert_eq!(client.events(), [Event::Motors]);
    assert!(matches!(client.ended()[..], [Outcome::Done(Some(DeviceMessage::MotorInfo(_)))]));
    let motors: Vec<_> = client.machine.motors().map(|motor| motor.motor_address.0).collect();
    assert_eq!(motors, [2, 3]);
}

/// 7.2-8.
#[test]
fn a_device_is_locked_without_the_right_password() {
    for silent in [false, true] {
        let mut client = Client::connected(Options::default(), AT);
        client.receive(device_info(PlaybackState::NO_MOVE));
        client.clear();
        if silent {
            client.pass(2_999);
            assert_eq!(client.events(), []);
            client.pass(1);
            assert_eq!(client.events(), [Event::Locked { wrong_password: false }]);
        } else {
            client.error(15, 0);
            assert_eq!(client.events(), [Event::Error(ErrorCode::LOCKED_OUT, MotorAddress::ALL), LOCKED]);
        }
        assert_eq!(client.state(), "Locked");
        assert_eq!(client.refused(load()), Some(Refusal::NotReady));
    }
}

/// 7.2-9, 7.2-10: a device without a number is asked for its platform as well (safety decision 9).
#[test]
fn questions_for_the_number_and_the_platform_follow() {
    let late = |client: &mut Client| client.pass(3_000);
    let no: fn(&mut Client) = |client| client.receive(unsupported(&[4, 0, 6, 0, 0x26, 1]));
    let no_guid: fn(&mut Client) = |client| client.receive(unsupported(&[4, 0, 6, 0, 0x1f, 1]));
    let yes: fn(&mut Client) = |client| client.receive(software(4));
    let yes_guid: fn(&mut Client) = |client| client.receive(guid(&GUID));
    let short: fn(&mut Client) = |client| client.receive(guid(&GUID[..15]));
    for (says_guid, guid) in [(yes_guid, Some(GUID)), (no_guid, None), (late, None), (short, None)] {
        for (says_platform, platform) in [(yes, Some(4)), (no, None), (late, None)] {
            let mut client = Client::connected(Options::default(), AT);
            client.receive(device_info(PlaybackState::NO_MOVE));
            client.motors();
            client.clear();
            says_guid(&mut client);
            assert_eq!((client.sent(), client.state()), (vec![Transmit::Get(Get::SoftwareId)], "AwaitSoftware"));
            client.clear();
            says_platform(&mut client);
            assert_eq!(client.events().pop(), Some(Event::Ready { reconnected: false, ranges_void: true }));
            assert_eq!((client.machine.guid(), client.machine.platform()), (guid, platform));
        }
    }
}

/// 7.2-10: ranges hold for one device and one platform, as expected or as before the connection was lost.
#[test]
fn another_device_or_platform_voids_ranges() {
    let expected = Identity { guid: GUID, platform: 4 };
    for (platform, ranges_void) in [(4, false), (5, true)] {
        let options = Options::default().with_expected(Some(Identity { platform, ..expected }));
        let mut client = Client::connected(options, AT);
        client.introduce(PlaybackState::NO_MOVE);
        assert_eq!(client.events().pop(), Some(Event::Ready { reconnected: false, ranges_void }));
    }
    let mut client = Client::ready();
    client.step(Input::LinkDown);
    client.pass(1_000);
    client.step(Input::LinkUp);
    client.introduce(PlaybackState::NO_MOVE);
    assert_eq!(client.events().pop(), Some(Event::Ready { reconnected: true, ranges_void: false }));
}

/// 7.2-11.
#[test]
fn a_locked_device_gets_the_password_of_the_application() {
    let mut client = Client::ready();
    assert_eq!(client.refused(Command::Unlock), Some(Refusal::NotReady));
    client.error(15, 0);
    client.clear();
    client.command(Command::Unlock);
    assert_eq!(client.sent(), [Transmit::UserPassword(PasswordOf::User), Transmit::Get(Get::MotorInfo)]);
    assert_eq!(client.state(), "AwaitMotorInfo");
}

/// 7.2-11: a query that the locked device ignored does not hold the next one back.
#[test]
fn a_question_fails_if_the_device_is_locked_meanwhile() {
    let mut client = Client::ready();
    client.command(Command::Get(Get::MotorInfo));
    client.error(15, 0);
    assert!(client.ended().contains(&Outcome::Failed(Failure::NoAnswer)));
    client.clear();
    client.command(Command::Unlock);
    assert_eq!(client.sent(), [Transmit::UserPassword(PasswordOf::User), Transmit::Get(Get::MotorInfo)]);
}

/// 7.2-12.
#[test]
fn a_device_that_is_ready_may_lock() {
    let mut client = Client::ready();
    client.error(15, 3);
    let locked_out = ErrorCode::LOCKED_OUT;
    assert_eq!(client.events(), [Event::Error(locked_out, MotorAddress(3)), LOCKED]);
    assert_eq!(client.state(), "Locked");
}

/// 7.2-13: while anything moves or may move, a stop must not depend on a password (safety decision 2).
#[test]
fn the_password_is_changed_only_while_nothing_moves() {
    let mut client = Client::ready();
    client.command(Command::ChangePassword);
    assert_eq!(client.sent(), [Transmit::DevicePassword, Transmit::UserPassword(PasswordOf::New)]);
    assert_eq!(client.state(), "Ready");
    for mut client in [Client::setting_up(), Client::starting(), Client::running()] {
        assert_eq!(client.refused(Command::ChangePassword), Some(Refusal::Moves));
    }
    for command in [
        Command::MoveTo(go(ONE, 5.0)),
        Command::Bump(go(TWO, 5.0)),
        jog(TWO, -5.0),
        Command::StopMotor(ONE),
        Command::Stop,
    ] {
        let mut client = Client::ready();
        client.command(command);
        assert_eq!(client.refused(Command::ChangePassword), Some(Refusal::Moves), "{command:?}");
    }
    let mut usb = Client::ready_at(Options::default(), Endpoint::Usb);
    assert_eq!(usb.refused(Command::ChangePassword), Some(Refusal::NoPassword));
    // The same is true if another client began the motion.
    let mut client = Client::ready();
    client.status(PlaybackState::START_FORWARD);
    assert_eq!(client.refused(Command::ChangePassword), Some(Refusal::Moves));
    client.status(PlaybackState::FULL_STOP);
    assert_eq!(client.refused(Command::ChangePassword), None);
}

/// 7.2-14: messages in both directions keep the line. If messages are only sent, the client asks as well (K-S15).
#[test]
fn a_question_keeps_the_connection_over_tcp() {
    let mut client = Client::ready();
    client.pass(9_999);
    assert_eq!(client.sent(), []);
    client.pass(1);
    assert_eq!(client.sent(), [PING]);
    client.receive(DeviceMessage::from(network_info()));
    assert_eq!(client.events(), []);
    client.pass(9_000);
    client.command(Command::SetPlatform(1));
    client.receive(software(1));
    client.clear();
    client.pass(9_999);
    assert_eq!(client.sent(), []);

    let mut busy = Client::ready();
    for _ in 0..24 {
        busy.pass(900);
        busy.command(Command::SetPlatform(1));
    }
    let pings = busy.sent().into_iter().filter(|&send| send == PING).count();
    assert_eq!((pings, busy.state()), (2, "Ready"));
}

/// 7.2-15: keep-alives do not depend on other messages, and are not answered (decision K-U6).
#[test]
fn keep_alives_are_sent_over_usb() {
    let mut client = Client::ready_at(Options::default(), Endpoint::Usb);
    for _ in 0..10 {
        client.command(Command::SetPlatform(1));
        client.clear();
        client.pass(3_999);
        assert_eq!(client.sent(), []);
        client.pass(1);
        assert_eq!(client.sent(), [Transmit::KeepAlive]);
    }
    client.pass(600_000);
    assert_eq!(client.state(), "Ready");
}

/// 7.2-16.
#[test]
fn a_silent_device_is_given_up() {
    let mut client = Client::ready();
    client.pass(24_999);
    assert_eq!((client.sent(), client.state()), (vec![PING; 2], "Ready"));
    client.clear();
    client.pass(1);
    assert_eq!((client.events(), client.state()), (vec![Event::LinkDown(LinkDownReason::Silence)], "Disconnected"));
    // Any message is a sign of life, also one that is cut short.
    let mut client = Client::ready();
    let error = DecodeError::Truncated { what: "LEDStatus", needed: 2, have: 0 };
    for round in 0..4 {
        client.pass(20_000);
        match round % 2 {
            0 => client.step(Input::Malformed { id: MessageId::LED_STATUS, kind: MessageType::RESPONSE, error }),
            _ => client.receive(DeviceMessage::other(0x0077_0200, &[])),
        }
    }
    assert_eq!(client.state(), "Ready");
}

/// 7.2-17: unsolicited messages are reported, and update the stored values.
#[test]
fn a_message_without_a_question_is_told() {
    let mut client = Client::ready();
    client.receive(DeviceMessage::from(network_info()));
    client.receive(DeviceMessage::other(0x0025_0200, &[]));
    client.receive(DeviceMessage::from(AuxInputStatus { status: AuxInputs::SLAVE_TIP, tail: &[] }));
    client.rests(1, 5.0);
    client.error(4, 9);
    let told = [
        Event::Unsolicited(network_info().into()),
        Event::Unsolicited(DeviceMessage::other(0x0025_0200, &[])),
        Event::Inputs(AuxInputs::SLAVE_TIP),
        Event::MotorRests(ONE, Rotations(5.0)),
        Event::Error(ErrorCode::BAD_MOTOR_ADDRESS, MotorAddress(9)),
    ];
    assert_eq!(client.events(), told);
    let position = |client: &Client| client.machine.motors().next().map(|motor| motor.position.0);
    assert_eq!(position(&client), Some(5.0));

    // A fault voids the range.
    client.error(10, 1);
    assert_eq!(client.events(), [Event::Error(ErrorCode::RUNAWAY, ONE), Event::MotorChanged(ONE)]);
    assert!(client.machine.motors().all(|motor| !motor.is_calibrated()));

    let motors = [MotorPlace::new(TWO, Rotations(9.0)), MotorPlace::new(MotorAddress(9), Rotations(9.0))];
    let status = PlaybackStatus {
        playback_status: PlaybackState::NO_MOVE,
        elapsed_time: Normalized(0.0),
        photo_count: None,
        motors: &motors,
        tail: &[],
    };
    client.receive(DeviceMessage::from(status));
    assert_eq!(client.machine.motors().last().map(|motor| motor.position.0), Some(9.0));

    // Each motor that comes or goes is reported once, even if the message names it more often.
    let presence = |motor, online: bool| {
        let (speed, acceleration) = (RotationsPerSecond(1.0), RotationsPerSecondSquared(1.0));
        MotorPresence::new(MotorAddress(motor), online.into(), MotorType::AXIS, speed, speed, acceleration)
    };
    client.clear();
    client.receive(presences(&[[presence(1, false); 100], [presence(0x83, true); 100]].concat()));
    assert_eq!(client.events(), [Event::MotorOnline(ONE, false), Event::MotorOnline(MotorAddress(3), true)]);
    assert_eq!((client.machine.motors().count(), client.sent()), (1, vec![Transmit::Get(Get::MotorInfo)]));
}

/// 7.2-18: one query of each kind is open at a time, and each is answered or fails.
#[test]
fn every_question_ends() {
    for get in Get::ALL {
        let mut client = Client::ready();
        client.command(Command::Get(get));
        assert_eq!(client.sent(), [Transmit::Get(get)]);
        assert_eq!(client.refused(Command::Get(get)), Some(Refusal::Busy));
        let mut ends = [client.clone(), client.clone(), client.clone(), client];
        let [late, no, cut, closed] = &mut ends;
        late.pass(3_000);
        assert_eq!((late.events(), late.ended()), (vec![], vec![Outcome::Failed(Failure::NoAnswer)]));
        let [i0, i1] = get.id().0.to_be_bytes();
        no.receive(unsupported(&[4, 0, 6, i0, i1, 0]));
        no.receive(unsupported(&[4, 0, 6, i0, i1]));
        let (id, kind, action) = (Some(get.id()), Some(MessageType::SET), None);
        let unknown = Event::Unsupported { id: None, kind: None, action };
        assert_eq!(no.events(), [Event::Unsupported { id, kind, action }, unknown], "not the question");
        assert_eq!(no.ended(), []);
        no.receive(unsupported(&[4, 0, 6, i0, i1, 1]));
        assert_eq!(no.ended(), [Outcome::Failed(Failure::Unsupported)]);
        let error = DecodeError::Truncated { what: "x", needed: 1, have: 0 };
        cut.step(Input::Malformed { id: get.id(), kind: MessageType::RESPONSE, error });
        assert_eq!(cut.events(), [Event::Malformed(get.id(), error)]);
        assert_eq!(cut.ended(), [Outcome::Failed(Failure::Malformed)]);
        closed.step(Input::LinkDown);
        assert_eq!(closed.ended(), [Outcome::Failed(Failure::LinkDown)]);
        for end in &mut ends[..3] {
            assert_eq!(end.refused(Command::Get(get)), None, "it can be asked again");
        }
    }
    let mut client = Client::ready();
    client.command(Command::Get(Get::DeviceInfo));
    client.receive(device_info(PlaybackState::NO_MOVE));
    let (token, outcome) = client.ended.pop().unwrap();
    assert_eq!(token, Token(client.token));
    assert_eq!((client.events(), outcome), (vec![], Outcome::Done(Some(device_info(PlaybackState::NO_MOVE)))));
}

/// 7.2-19.
#[test]
fn a_device_that_does_not_answer_what_it_is_is_given_up() {
    let mut client = Client::connected(Options::default(), AT);
    client.pass(8_999);
    assert_eq!((client.sent(), client.events()), (vec![ASKS; 3], vec![]));
    client.pass(1);
    assert_eq!((client.events(), client.state()), (vec![Event::LinkDown(LinkDownReason::NoAnswer)], "Disconnected"));
}

/// 7.2-20: the client tries again at growing intervals, until it is told to disconnect.
#[test]
fn a_lost_connection_is_made_again() {
    for (end, why) in [(Input::LinkDown, LinkDownReason::Ended), (Input::Fatal, LinkDownReason::Framing)] {
        let mut client = Client::armed();
        client.step(end);
        assert_eq!(client.events(), [Event::Move(Move::Lost), Event::LinkDown(why)]);
        assert_eq!((client.state(), client.move_state()), ("Disconnected", "NoMove"));
        for wait in [1_000, 2_000, 4_000, 8_000, 16_000, 32_000, 32_000] {
            client.pass(wait - 1);
            assert_eq!(client.events(), []);
            client.pass(1);
            assert_eq!((client.events(), client.state()), (vec![Event::Connect(AT)], "Connecting"));
            client.step(Input::LinkDown);
            assert_eq!(client.events(), [Event::LinkDown(LinkDownReason::Ended)]);
        }
        client.command(Command::Disconnect);
        assert_eq!((client.events(), client.state()), (vec![Event::LinkDown(LinkDownReason::Asked)], "Discovering"));
        client.pass(600_000);
        assert_eq!(client.events(), []);
    }
    let mut client = Client::ready_at(Options::default().with_reconnect(false), AT);
    client.step(Input::LinkDown);
    client.clear();
    client.pass(600_000);
    assert_eq!((client.events(), client.state()), (vec![], "Discovering"));
}

#[test]
fn settings_are_sent_once() {
    let mut client = Client::ready();
    let (master, slave) = (LedMode::ON, LedMode::OFF);
    client.command(Command::SetLeds { master, slave });
    client.command(Command::SetPlatform(3));
    client.command(Command::TakePicture(Seconds(0.5)));
    client.command(Command::ResetDevice);
    let sent = [
        Transmit::Leds { master, slave },
        Transmit::Platform(3),
        Transmit::TakePicture(Seconds(0.5)),
        Transmit::ResetDevice,
    ];
    assert_eq!((client.sent(), client.events()), (sent.to_vec(), vec![]));
    assert_eq!(client.refused(Command::TakePicture(Seconds(f32::NAN))), Some(Refusal::Number));
}
