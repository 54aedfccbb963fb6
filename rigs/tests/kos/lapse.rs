//! Time lapses: photos are counted, and each motor is at its planned position when the shutter opens.

use kos_proto::device::playback::State;
use kos_proto::host::{self, Move};
use kos_proto::message::Seconds;
use kos_proto::trajectory::Style;
use motion_rigs::Rig as _;
use motion_rigs::kos_host::Command;

use crate::bench::{Bench, M1, M2, TOLERANCE, lapse, number, planned};

/// Plays a time lapse to its end. Returns the positions of both motors at each photo, and whether they rested.
fn photos(bench: &mut Bench, style: Style, photos: u32, around: u32) -> Vec<([f64; 2], bool)> {
    bench.load(lapse(style, photos, around));
    let mut taken = Vec::new();
    bench.send(host::Command::Play);
    for _ in 0..120_000 {
        let count = bench.scene.rig.photo_count();
        bench.tick();
        if bench.scene.rig.photo_count() > count {
            taken.push(([M1, M2].map(|motor| bench.at(motor)), bench.rests()));
        }
        if bench.scene.rig.machine().playback() == State::Empty {
            break;
        }
    }
    bench.expect_move(Move::Finished { requested: false });
    taken
}

#[test]
fn the_motors_rest_for_each_photo_of_shoot_move_shoot() {
    let mut bench = Bench::calibrated();
    let begins = [0.0, 0.0];
    let taken = photos(&mut bench, Style::ShootMoveShoot, 6, 2);
    assert_eq!((taken.len(), bench.scene.rig.photo_count()), (10, 10));
    for (index, (places, rested)) in taken.iter().enumerate() {
        assert!(rested, "photo {index}");
        let part = number(index.clamp(2, 7) - 2) / 5.0;
        for ((motor, place), begin) in [M1, M2].into_iter().zip(places).zip(begins) {
            let should = planned(motor, begin, 5.0 * part);
            assert!((place - should).abs() < TOLERANCE, "photo {index}: motor {motor} at {place}, should be {should}");
        }
    }
    // A photo begins after the end of the photo before it, and after the interval.
    let all: Vec<_> = bench.scene.rig.photos().copied().collect();
    assert!(all.windows(2).all(|pair| pair[1].opened.since(pair[0].closes) >= 400), "{all:?}");
}

#[test]
fn a_continuous_lapse_keeps_its_interval_and_its_curves() {
    let mut bench = Bench::calibrated();
    let taken = photos(&mut bench, Style::Continuous, 10, 1);
    assert_eq!((taken.len(), bench.scene.rig.photo_count()), (12, 12));
    let all: Vec<_> = bench.scene.rig.photos().copied().collect();
    for (index, pair) in all.windows(2).enumerate() {
        assert_eq!(pair[1].opened.since(pair[0].opened), 500, "photo {index}");
    }
    // The move takes 5 s with the same curves, and the first photo comes after an interval.
    for (index, (photo, (places, _))) in all.iter().zip(&taken).enumerate().skip(1).take(10) {
        let seconds = 0.4 + 0.5 * number(index - 1);
        assert!((photo.moment.unwrap() - seconds).abs() < 2e-3, "{photo:?}");
        for (motor, place) in [M1, M2].into_iter().zip(places) {
            let should = planned(motor, 0.0, photo.moment.unwrap());
            assert!((place - should).abs() < TOLERANCE, "photo {index}: motor {motor} at {place}, should be {should}");
        }
    }
}

#[test]
fn a_stop_of_a_lapse_closes_the_shutter() {
    let mut bench = Bench::calibrated();
    bench.command(Command::PlayDirect { stored: lapse(Style::ShootMoveShoot, 20, 0) });
    while bench.scene.rig.photo_count() < 3 {
        bench.tick();
    }
    bench.stop();
    let last = *bench.scene.rig.photos().last().unwrap();
    assert!(last.closes.since(last.opened) < 100, "{last:?}");
    bench.pass(30_000);
    assert_eq!(bench.scene.rig.photo_count(), 3);
}

#[test]
fn a_photo_can_be_taken_without_a_move() {
    let mut bench = Bench::ready(motion_rigs::kos_device::Setup::with_motors(1));
    bench.send(host::Command::TakePicture(Seconds(2.0)));
    bench.pass(20);
    let photo = *bench.scene.rig.photos().last().unwrap();
    assert_eq!((bench.scene.rig.photo_count(), photo.closes.since(photo.opened), photo.moment), (1, 2000, None));
    assert_eq!(bench.scene.rig.motors().len(), 1);
}
