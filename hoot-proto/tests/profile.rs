//! Ages of firmware: their names, their order, and what a version tells.

use hoot_proto::device::Options;
use hoot_proto::message::{
    CommonLine, Easing, FirmwareVersion, HostMessage, JoystickMode, Motor, MotorMaxProgramSpeed, MotorRunning,
    MotorSetEasing, Noop, PingPong, Reply, ResponseCode, RunState, SetCommonLine, StartDelay, Stop, Version,
};
use hoot_proto::query::{DelayUnit, Profile, ProfileError, Query};

#[test]
fn an_answer_or_a_refusal_tells_the_age() {
    let motor = Motor::One;
    let (joystick, ping_pong) = (HostMessage::from(JoystickMode {}), HostMessage::from(PingPong {}));
    let sleep = HostMessage::from(MotorMaxProgramSpeed { motor });
    let of = |query: &HostMessage<'_>, answers| Profile::VERSION_6.that_answers(query, answers).to_string();
    assert_eq!(of(&joystick, false), "2014-09-24 to 2014-10-27");
    assert_eq!(of(&ping_pong, false), "2014-09-24 to 2014-11-02");
    assert_eq!(of(&sleep, true), "2014-12-03 to 2015-01-04");
    let between = Profile::VERSION_6.that_answers(&ping_pong, true).that_answers(&sleep, false);
    assert_eq!(between.to_string(), "2014-11-03 to 2014-12-02");
    assert_eq!(Profile::V033.that_answers(&sleep, false), Profile::V033, "it contradicts the version");
    assert_eq!(of(&HostMessage::from(MotorRunning { motor }), true), "version-6");
}

#[test]
fn a_version_tells_the_profile() {
    let of = |data: &[u8]| {
        let reply = Reply { code: ResponseCode::OK, data };
        Profile::of_version(&FirmwareVersion {}.decode_reply(reply).unwrap())
    };
    assert_eq!(of(&[0, 6]), Profile::VERSION_6);
    assert_eq!(of(&[0, 70]), Profile::UNKNOWN, "a byte, so it is not v0.70");
    for version in 20..=70 {
        let profile = of(&[4, 0, 0, 0, version]);
        assert_eq!(
            (profile.to_string(), Options::new().with_profile(profile).version()),
            (format!("v0.{version}"), Version(version.into()))
        );
    }
    assert_eq!([of(&[4, 0, 0, 0, 19]), of(&[4, 0, 0, 0, 71])], [Profile::UNKNOWN, Profile::V070]);
    let trial = [1907_u16, 999, 9006, 9007].map(|version| {
        let [high, low] = version.to_be_bytes();
        of(&[4, 0, 0, high, low]).to_string()
    });
    assert_eq!(trial, ["2015-01-05 to 2015-01-07", "v0.47 to v0.48", "v0.44 to v0.46", "v0.44 to v0.46"]);
    assert_eq!(of(&[4, 1, 0, 0, 0]), Profile::V070);
}

#[test]
fn a_text_names_firmware() {
    let named = ["2014-09-24", "2014-12-03", "2015-01-08", "v0.20", "v0.70", "v0.40 to v0.45", "sheet", "unknown"];
    for text in named.into_iter().chain(["version-6", "january-2015", "2014-09-24 to v0.20"]) {
        assert_eq!(text.parse::<Profile>().unwrap().to_string(), text);
    }
    assert_eq!("2014-10-28".parse(), Ok(Profile::SHEET));
    let wrong = ["", "2014-09-23", "2014-09-31", "2014-13-01", "2015-01-09", "2014-1-2", "v0.19", "v0.71", "v0.4"];
    for text in wrong.into_iter().chain(["v1.20", "+014-10-15", "v0.45 to v0.40", "v0.+5", "6"]) {
        assert_eq!(text.parse::<Profile>(), Err(ProfileError), "{text}");
    }
    assert_eq!((Profile::version(71), Profile::build(2014, 11, 31), Profile::build(9999, 1, 1)), (None, None, None));
    assert_eq!((Profile::version(33), Profile::build(2014, 10, 28)), (Some(Profile::V033), Some(Profile::SHEET)));
}

#[test]
fn older_firmware_is_smaller() {
    let builds = ["2014-09-24", "2014-10-01", "2014-12-31", "2015-01-08", "v0.20", "v0.33", "v0.70"];
    let builds = builds.map(|text| text.parse::<Profile>().unwrap());
    assert!(builds.is_sorted_by(|one, next| one < next));
    assert!(Profile::VERSION_6 < Profile::JANUARY_2015 && Profile::V033 > Profile::JANUARY_2015);
    assert_eq!(Profile::UNKNOWN.partial_cmp(&Profile::SHEET), None, "it may be older, and it may be newer");
}

#[test]
fn a_fact_is_known_if_it_is_the_same_for_all_builds() {
    let of = |question: fn(Profile) -> Option<bool>| {
        ["2014-12-02", "2014-12-03", "version-6", "january-2015", "unknown"].map(|text| question(text.parse().unwrap()))
    };
    assert_eq!(of(Profile::one_is_paused), [Some(false), Some(true), None, Some(true), None]);
    assert_eq!(of(Profile::has_steps), [Some(true), Some(true), Some(true), None, None]);
    let delay = [37, 40, 41].map(|version| Profile::version(version).unwrap().start_delay());
    assert_eq!(delay, [Some(DelayUnit::Seconds), None, Some(DelayUnit::Milliseconds)]);
}

#[test]
fn the_meaning_of_a_number_is_told_if_it_is_known() {
    let running = |state: u8| {
        [Profile::UNKNOWN, Profile::SHEET, Profile::V033].map(|profile| RunState(state).is_running(profile))
    };
    assert_eq!(running(0), [Some(false); 3]);
    assert_eq!(running(1), [None, Some(true), Some(false)]);
    assert_eq!((running(2), running(6)), ([Some(true); 3], [None; 3]));

    let delay = |profile| StartDelay(u32::MAX).milliseconds(profile);
    assert_eq!([Profile::UNKNOWN, "v0.40".parse().unwrap()].map(delay), [None, None]);
    assert_eq!(delay(Profile::V033), Some(4_294_967_295_000));
    assert_eq!(delay(Profile::V070), Some(4_294_967_295));
}

#[test]
fn some_requests_are_answered_twice_and_some_not_at_all() {
    let motor = Motor::One;
    let line = |line| HostMessage::from(SetCommonLine { common_line: CommonLine(line) });
    let easing = |easing| HostMessage::from(MotorSetEasing { motor, easing: Easing(easing) });
    let of = |message: &HostMessage<'_>| Profile::SHEET.packets(message);
    assert_eq!([0, 2, 3, 255].map(|number| of(&line(number))), [1, 1, 2, 2]);
    assert_eq!([0, 1, 3, 4].map(|number| of(&easing(number))), [2, 1, 1, 2]);
    assert_eq!(of(&HostMessage::from(Noop::default())), 0);
    assert_eq!(of(&HostMessage::from(Stop {})), 1);
    let running = HostMessage::from(MotorRunning { motor });
    assert_eq!((of(&running), Profile::V033.packets(&running)), (2, 1));
}

#[test]
fn all_builds_are_listed_in_the_order_of_time() {
    let builds: Vec<_> = Profile::builds().collect();
    assert!(builds.is_sorted_by(|one, other| one < other));
    // 7 days of September, 31, 30, 31, 8 days of January, and 51 versions.
    assert_eq!(builds.len(), 7 + 31 + 30 + 31 + 8 + 51);
    assert!(builds.iter().all(|build| build.is_one_build() && build.to_string().parse() == Ok(*build)));
}
