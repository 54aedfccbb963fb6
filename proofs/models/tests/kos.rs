//! Exploration of client and device of kOS together.

use kos_proto::Transport;
use kos_proto::message::{ActionId, MotorAddress, Normalized, Seconds};
use kos_proto::trajectory::{
    Delay, LiveMotion, Loop, MotorPlan, Plan, Play, Style, TimeLapseMotion, Times, TrajectoryData, Way, bezier,
};
use laws::world::Faults;
use models::kos::{Conduct, Kos, Wish, Wrong};
use stateright::{Checker, DiscoveryClassification, HasDiscoveries, Model};

/// Speed of the motors on the way to the start of a move.
const HOME_SPEED: Normalized = Normalized(1.0);

/// Move of the motor from one end of its range to the other.
fn data(play: Play) -> TrajectoryData<'static> {
    let third = 1.0 / 3.0;
    let line = [0.0, third, 2.0 * third, 1.0].map(|part| bezier::Point::new(part, part));
    let line = [bezier::Segment::new(line).expect("finite")];
    let motor = MotorPlan { motor: MotorAddress(1), way: Way::Segments(&line) };
    Plan::new(play, &[motor]).encode(vec![0; Plan::MAX_LEN].leak()).expect("a move")
}

fn live(repeat: Loop, delay: Delay) -> TrajectoryData<'static> {
    data(Play::Live(LiveMotion { duration: Seconds(4.0), repeat, delay, home_speed: HOME_SPEED }))
}

/// In each direction one message is lost and one damaged; one reply is doubled.
const ALL: Faults = Faults { lost: 1, corrupt: 1, doubled: 1 };

fn tcp(script: &'static [(Wish, u8)]) -> Kos {
    Kos {
        transport: Transport::Tcp,
        password: b"",
        known: b"",
        data: live(Loop::Once, Delay::None),
        script,
        jumps: 3,
        prompt: false,
        cuts: 0,
        faults: Faults::default(),
        failures: 0,
        conduct: Conduct::Mild,
        wrong: Wrong::Nothing,
    }
}

/// Explores a setup, checks that all properties hold, and prints the number of states.
fn holds(name: &str, kos: Kos, at_least: usize) {
    let begin = std::time::Instant::now();
    let checker = kos.checker().threads(2).spawn_bfs().join();
    let states = checker.unique_state_count();
    println!("{name}: {states} states, depth {}, {:.1} s", checker.max_depth(), begin.elapsed().as_secs_f32());
    for (property, path) in checker.discoveries() {
        if let DiscoveryClassification::Counterexample = checker.discovery_classification(property) {
            println!("{property}, last steps:");
            let steps = path.into_vec();
            for (state, action) in steps.iter().skip(steps.len().saturating_sub(12)) {
                let line = format!("  {action:?}: {state}");
                println!("{line:.600}");
            }
        }
    }
    checker.assert_properties();
    assert!(states >= at_least, "{states}");
}

/// Every message may be seconds late.
#[test]
fn a_move_over_tcp() {
    let script = &[(Wish::Load, 1), (Wish::Play, 1), (Wish::Stop, 2)];
    holds("a move over TCP, late", tcp(script), 150_000);
}

#[test]
fn a_move_over_tcp_that_is_cut() {
    let script = &[(Wish::PlayDirect, 1), (Wish::Stop, 1), (Wish::Ask, 1)];
    holds("a move over TCP, cut", Kos { cuts: 1, prompt: true, ..tcp(script) }, 150_000);
}

#[test]
fn loops_over_tcp() {
    let data = live(Loop::Reverse(Times::new(1).expect("one")), Delay::For(Seconds(2.0)));
    let script = &[(Wish::LoadHere, 1), (Wish::Play, 1), (Wish::Stop, 2), (Wish::Ask, 1)];
    holds("loops over TCP", Kos { data, jumps: 7, prompt: true, ..tcp(script) }, 80_000);
}

#[test]
fn by_hand_over_tcp() {
    let script = &[(Wish::MoveTo, 2), (Wish::Bump, 1), (Wish::Jog, 1), (Wish::StopMotor, 1), (Wish::Stop, 1)];
    holds("by hand over TCP, late", Kos { jumps: 2, ..tcp(script) }, 500_000);
}

#[test]
fn by_hand_over_tcp_that_is_cut() {
    let script = &[(Wish::MoveTo, 1), (Wish::Jog, 1), (Wish::Stop, 1)];
    holds("by hand over TCP, cut", Kos { cuts: 1, prompt: true, ..tcp(script) }, 80_000);
}

#[test]
fn a_move_and_by_hand_over_tcp() {
    let script = &[(Wish::Load, 1), (Wish::MoveTo, 1), (Wish::Bump, 1), (Wish::Play, 1), (Wish::Stop, 1)];
    holds("a move and by hand over TCP", Kos { prompt: true, ..tcp(script) }, 40_000);
}

#[test]
fn a_fault_over_tcp() {
    let script = &[(Wish::Load, 1), (Wish::Rapid, 1), (Wish::Play, 1), (Wish::Stop, 1)];
    holds("a fault over TCP, late", Kos { failures: 1, jumps: 2, ..tcp(script) }, 70_000);
}

#[test]
fn time_lapses_over_tcp() {
    let script = &[(Wish::PlayDirect, 1), (Wish::Stop, 1), (Wish::MoveTo, 1)];
    for (name, style) in [("SMS over TCP", Style::ShootMoveShoot), ("continuous over TCP", Style::Continuous)] {
        let data = data(Play::TimeLapse(TimeLapseMotion {
            style,
            interval: Seconds(0.5),
            exposure: Seconds(0.5),
            photos: 2,
            photos_before: 1,
            photos_after: 1,
            delay: Delay::None,
            home_speed: HOME_SPEED,
        }));
        holds(name, Kos { data, jumps: 12, prompt: true, failures: 1, ..tcp(script) }, 300_000);
    }
}

#[test]
fn a_move_over_usb() {
    let script = &[(Wish::PlayDirect, 1), (Wish::Stop, 1), (Wish::Ask, 1)];
    let usb =
        Kos { transport: Transport::Usb, faults: Faults { lost: 2, ..Faults::default() }, prompt: true, ..tcp(script) };
    holds("a move over USB, lossy", usb, 150_000);
}

#[test]
fn a_move_over_usb_with_all_faults() {
    let script = &[(Wish::PlayDirect, 1), (Wish::Stop, 1)];
    let usb = Kos { transport: Transport::Usb, faults: ALL, prompt: true, ..tcp(script) };
    holds("a move over USB, all faults", usb, 150_000);
}

#[test]
fn by_hand_over_usb() {
    let script = &[(Wish::MoveTo, 1), (Wish::Jog, 1), (Wish::StopMotor, 1), (Wish::Stop, 1)];
    let usb = Kos { transport: Transport::Usb, faults: ALL, prompt: true, jumps: 2, ..tcp(script) };
    holds("by hand over USB, all faults", usb, 1_000_000);
}

#[test]
fn a_lock_over_tcp() {
    let script = &[(Wish::PlayDirect, 1), (Wish::Stop, 1), (Wish::Unlock, 1)];
    holds("a lock over TCP, late", Kos { password: b"sesame", known: b"sesame", ..tcp(script) }, 100_000);
}

#[test]
fn a_wrong_password_over_tcp() {
    let script = &[(Wish::Stop, 2), (Wish::Unlock, 1)];
    holds("a wrong password over TCP, late", Kos { password: b"sesame", ..tcp(script) }, 200_000);
}

/// The device ignores stops while it is locked, and the connection is cut while a move runs.
const DEAF: Conduct = Conduct::DeafWhileLocked;

#[test]
fn a_deaf_lock_over_tcp_that_is_cut() {
    let script = &[(Wish::PlayDirect, 1), (Wish::Stop, 1)];
    let password = b"sesame";
    let kos = Kos { password, known: password, conduct: DEAF, cuts: 1, prompt: true, ..tcp(script) };
    holds("a deaf lock over TCP, cut", kos, 50_000);
}

#[test]
fn a_device_that_plays_the_other_way() {
    let script = &[(Wish::Load, 1), (Wish::Play, 1), (Wish::PlayDirect, 1), (Wish::Stop, 1)];
    holds("the other way over TCP", Kos { conduct: Conduct::OtherWay, prompt: true, ..tcp(script) }, 5_000);
}

#[test]
fn a_device_that_lacks_an_action() {
    for (name, script, action) in [
        ("no bump", &[(Wish::Bump, 1), (Wish::Stop, 1)][..], ActionId::BUMP_POSITION_SPEED_ACCELERATION),
        ("no setup", &[(Wish::Load, 1), (Wish::Stop, 1)], ActionId::SETUP_PLAYBACK),
        ("no start", &[(Wish::PlayDirect, 1), (Wish::Stop, 1)], ActionId::START_PLAYBACK),
    ] {
        holds(name, Kos { conduct: Conduct::Lacks(action), ..tcp(script) }, 500);
    }
}

/// Deeper explorations with more delays, which take minutes.
#[test]
#[ignore = "takes minutes, and gigabytes"]
fn deeper() {
    let script = &[(Wish::Load, 1), (Wish::Play, 1), (Wish::Stop, 2), (Wish::Ask, 1)];
    holds("deeper: a move over TCP, late", Kos { jumps: 4, ..tcp(script) }, 5_000_000);
    let script = &[(Wish::PlayDirect, 1), (Wish::Stop, 1)];
    holds("deeper: a move over TCP, cut and late", Kos { cuts: 1, jumps: 4, ..tcp(script) }, 2_500_000);
}

/// Explores a setup with a mistake, and checks that the property finds it.
fn finds(property: &'static str, kos: Kos) {
    let checker = kos.checker().threads(2).finish_when(HasDiscoveries::AnyFailures).spawn_bfs().join();
    assert!(checker.discovery(property).is_some(), "{property}");
}

#[test]
fn mistakes_are_found() {
    let script = &[(Wish::PlayDirect, 1), (Wish::Stop, 1)];
    let with = |wrong| Kos { wrong, prompt: true, ..tcp(script) };
    finds("a stop that comes is obeyed in its step", with(Wrong::DeafToStops));
    finds("nothing of the never-retry list is repeated", with(Wrong::StartsAgain));
    finds("no stop is given up silently", Kos { cuts: 1, ..with(Wrong::ForgetsStops) });
    let password = b"sesame";
    let locked = Kos { password, known: password, ..with(Wrong::StopsBeforeThePassword) };
    finds("a stop is sent first, in its step", locked);
    let other_way = Kos { conduct: Conduct::OtherWay, ..with(Wrong::BlindToWays) };
    finds("no move is played the other way once messages settle", other_way);
    let conduct = Conduct::Lacks(ActionId::START_PLAYBACK);
    finds("what the device does not know ends once messages settle", Kos { conduct, ..with(Wrong::DeafToRefusals) });
}
