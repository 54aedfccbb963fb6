//! Time lapses: photos are counted, and the motors are where the plan has them when the shutter opens.

use kos_proto::device::playback::State;
use kos_proto::host::{self, Move};
use kos_proto::message::Seconds;
use kos_proto::summary::Direction;
use kos_proto::trajectory::Style;
use rigs::Rig as _;
use rigs::kos_host::Command;

use crate::bench::{Bench, M1, M2, TOLERANCE, lapse, number, planned};

/// Plays a time lapse to its end; where both motors were at each photo, and whether they rested.
fn photos(bench: &mut Bench, style: Style, photos: u32, around: u32) -> Vec<([f64; 2], bool)> {
    bench.scene.command(Command::Load {
        stored: lapse(style, photos, around),
        way: Direction::Forward,
        delay_return: false,
    });
    bench.told_move(Move::Ready);
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
    bench.told_move(Move::Finished { requested: false });
    taken
}

#[test]
fn shoot_move_shoot_rests_for_each_photo() {
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
    // No photo begins before the one before it is over, and the pause.
    let all: Vec<_> = bench.scene.rig.photos().copied().collect();
    assert!(all.windows(2).all(|pair| pair[1].opened.since(pair[0].closes) >= 400), "{all:?}");
}

#[test]
fn a_continuous_lapse_keeps_its_rhythm_and_its_curves() {
    let mut bench = Bench::calibrated();
    let taken = photos(&mut bench, Style::Continuous, 10, 1);
    assert_eq!((taken.len(), bench.scene.rig.photo_count()), (12, 12));
    let all: Vec<_> = bench.scene.rig.photos().copied().collect();
    for (index, pair) in all.windows(2).enumerate() {
        assert_eq!(pair[1].opened.since(pair[0].opened), 500, "photo {index}");
    }
    // 5 s of move in all, of the same curves; the first photo after its pause.
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
fn a_lapse_is_stopped_with_its_shutter_open() {
    let mut bench = Bench::calibrated();
    bench.scene.command(Command::PlayDirect { stored: lapse(Style::ShootMoveShoot, 20, 0), way: Direction::Forward });
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
fn one_photo_is_taken_by_itself() {
    let mut bench = Bench::ready(rigs::kos_device::Setup::with_motors(1));
    bench.send(host::Command::TakePicture(Seconds(2.0)));
    bench.pass(20);
    let photo = *bench.scene.rig.photos().last().unwrap();
    assert_eq!((bench.scene.rig.photo_count(), photo.closes.since(photo.opened), photo.moment), (1, 2000, None));
    assert_eq!(bench.scene.rig.motors().len(), 1);
}
