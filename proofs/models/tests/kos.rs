//! Client and device of kOS, explored together.

use kos_proto::message::{MotorAddress, Normalized, PlaybackMode, Seconds};
use kos_proto::summary::Transport;
use kos_proto::trajectory::*;
use models::kos::{Kos, Wish, Wrong};
use motion_core::wire::Bool;
use stateright::{Checker, DiscoveryClassification, HasDiscoveries, Model};

fn playback() -> Playback<'static> {
    Playback {
        playback_mode: PlaybackMode::LIVE_MOTION,
        duration: Seconds(4.0),
        rapid_reverse_duration: Seconds(4.0),
        loop_after_rapid_reverse: LoopCount::NONE,
        loop_after_reverse: LoopCount::NONE,
        delay_mode: DelayMode::NONE,
        delay_interval_bits: DelayInterval(0),
        camera_roll_enabled: Bool::FALSE,
        camera_roll_pre_delay: Seconds(0.0),
        camera_roll_post_delay: Seconds(0.0),
        flash_mark_enabled: 0,
        flash_mark_type: 0,
        flash_mark_post_delay: Seconds(0.0),
        use_external_trigger: 0,
        using_lanc: 0,
        return_to_home_percent: Normalized(1.0),
        tail: &[],
    }
}

/// A move of the motor, from one end of its range to the other.
fn data(playback: Playback<'_>, photos: (u32, u32, u32)) -> TrajectoryData<'static> {
    let (pre_move_photos, move_photos, post_move_photos) = photos;
    let (motor_address, tail) = (MotorAddress(1), &[][..]);
    let third = 1.0 / 3.0;
    let points = [0.0, third, 2.0 * third, 1.0].map(|part| Point::new(part, part));
    let (delay, exposure) = (Seconds(0.5), Seconds(0.5));
    let photos = TimeLapse { delay, exposure, move_photos, not_used: 0, pre_move_photos, post_move_photos, tail };
    let blocks = [
        Block::Playback(playback),
        Block::TimeLapse(photos),
        Block::Axis(Axis { motor_address, segment_count: 1, tail }),
        Block::Segment(Segment { motor_address, segment_number: 0, points: Points(points), tail }),
    ];
    TrajectoryData { blocks: Blocks::encode(&blocks, vec![0; 256].leak()).expect("there is room"), tail }
}

fn live() -> TrajectoryData<'static> {
    data(playback(), (0, 0, 0))
}

fn tcp(script: &'static [(Wish, u8)]) -> Kos {
    Kos {
        transport: Transport::Tcp,
        password: b"",
        known: b"",
        data: live(),
        script,
        jumps: 3,
        prompt: false,
        cuts: 0,
        lost: 0,
        failures: 0,
        wrong: Wrong::Nothing,
    }
}

/// Explores, and wants all to hold; how many states there were.
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
                let machines = (state.host.move_state(), state.device.playback(), state.link, state.rig);
                println!("  {machines:?} {:?} {:?} {:?} {action:?}", state.to_device, state.to_host, state.ledger);
            }
        }
    }
    checker.assert_properties();
    assert!(states >= at_least, "{states}");
}

/// Everything may be late by seconds.
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
    let delay_interval_bits = DelayInterval::from_seconds(Seconds(2.0));
    let loops = Playback { loop_after_reverse: LoopCount(1), delay_mode: DelayMode::INTERVAL, ..playback() };
    let data = data(Playback { delay_interval_bits, ..loops }, (0, 0, 0));
    let script = &[(Wish::LoadHere, 1), (Wish::Play, 1), (Wish::Stop, 2), (Wish::Ask, 1)];
    holds("loops over TCP", Kos { data, jumps: 7, prompt: true, ..tcp(script) }, 10_000);
}

#[test]
fn by_hand_over_tcp() {
    let script = &[(Wish::MoveTo, 2), (Wish::Bump, 1), (Wish::Jog, 1), (Wish::StopMotor, 1), (Wish::Stop, 1)];
    holds("by hand over TCP, late", Kos { jumps: 2, ..tcp(script) }, 500_000);
}

#[test]
fn by_hand_over_tcp_that_is_cut() {
    let script = &[(Wish::MoveTo, 1), (Wish::Jog, 1), (Wish::Stop, 1)];
    holds("by hand over TCP, cut", Kos { cuts: 1, prompt: true, ..tcp(script) }, 10_000);
}

#[test]
fn a_move_and_by_hand_over_tcp() {
    let script = &[(Wish::Load, 1), (Wish::MoveTo, 1), (Wish::Bump, 1), (Wish::Play, 1), (Wish::Stop, 1)];
    holds("a move and by hand over TCP", Kos { prompt: true, ..tcp(script) }, 10_000);
}

#[test]
fn a_fault_over_tcp() {
    let script = &[(Wish::Load, 1), (Wish::Rapid, 1), (Wish::Play, 1), (Wish::Stop, 1)];
    holds("a fault over TCP, late", Kos { failures: 1, jumps: 2, ..tcp(script) }, 70_000);
}

#[test]
fn time_lapses_over_tcp() {
    let script = &[(Wish::PlayDirect, 1), (Wish::Stop, 1), (Wish::MoveTo, 1)];
    for (name, playback_mode) in
        [("SMS over TCP", PlaybackMode::TIME_LAPSE_SMS), ("continuous over TCP", PlaybackMode::TIME_LAPSE_CONTINUOUS)]
    {
        let data = data(Playback { playback_mode, ..playback() }, (1, 2, 1));
        holds(name, Kos { data, jumps: 12, prompt: true, failures: 1, ..tcp(script) }, 5_000);
    }
}

#[test]
fn a_move_over_usb() {
    let script = &[(Wish::PlayDirect, 1), (Wish::Stop, 1), (Wish::Ask, 1)];
    let usb = Kos { transport: Transport::Usb, lost: 2, prompt: true, ..tcp(script) };
    holds("a move over USB, lossy", usb, 50_000);
}

#[test]
fn by_hand_over_usb() {
    let script = &[(Wish::MoveTo, 1), (Wish::Jog, 1), (Wish::StopMotor, 1), (Wish::Stop, 1)];
    let usb = Kos { transport: Transport::Usb, lost: 1, prompt: true, ..tcp(script) };
    holds("by hand over USB, lossy", usb, 10_000);
}

#[test]
fn a_lock_over_tcp() {
    let script = &[(Wish::PlayDirect, 1), (Wish::Stop, 1), (Wish::Unlock, 1)];
    holds("a lock over TCP, late", Kos { password: b"sesame", known: b"sesame", ..tcp(script) }, 100_000);
}

#[test]
fn a_wrong_password_over_tcp() {
    let script = &[(Wish::Stop, 2), (Wish::Unlock, 1)];
    holds("a wrong password over TCP, late", Kos { password: b"sesame", ..tcp(script) }, 1_000);
}

/// All of it later, and more of it: minutes.
#[test]
#[ignore = "takes minutes, and gigabytes"]
fn deeper() {
    let script = &[(Wish::Load, 1), (Wish::Play, 1), (Wish::Stop, 2), (Wish::Ask, 1)];
    holds("deeper: a move over TCP, late", Kos { jumps: 4, ..tcp(script) }, 5_000_000);
    let script = &[(Wish::PlayDirect, 1), (Wish::Stop, 1)];
    holds("deeper: a move over TCP, cut and late", Kos { cuts: 1, jumps: 4, ..tcp(script) }, 2_500_000);
}

/// Explores with a mistake, and wants it to be found.
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
}
