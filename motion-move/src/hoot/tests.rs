//! Tests of programs and key frames of an NMX.

use hoot_proto::beyond;
use hoot_proto::message::Steps;
use proptest::prelude::*;

use super::*;
use crate::tests::{PAN, SLIDE};
use crate::write::tests::any_move;

fn pan(part: &str, other: &str) -> Move {
    assert!(PAN.contains(part));
    Move::parse("pan.json", &PAN.replacen(part, other, 1)).unwrap()
}

fn planned(subject: &Move, count: Count, reverse: bool) -> Planned {
    convert(subject, Options { count, reverse, node: Some(Address::DEFAULT) }).unwrap().planned[0]
}

/// Compares the move file and the planned move at each millisecond.
#[test]
fn the_planned_move_of_the_sample_is_off_by_about_a_step() {
    let file = pan("Pan", "Pan");
    let this = planned(&file, Count::Video, false);
    assert_eq!((this.plan.start, this.plan.stop, this.lead_in), (Steps(0), Steps(9000), 500));
    assert_eq!((this.plan.travel, this.plan.easing), (Span(4000), Easing::INVERSE_QUADRATIC));
    let curve = file.axes()[0].curve();
    let off = |at: u32| {
        let place = f64::from(this.plan.at(at.saturating_sub(this.lead_in)).0);
        (place - 100.0 * curve.position(f64::from(at) / 1000.0)).abs()
    };
    let worst = (0..=5000).map(off).fold(0.0, f64::max);
    assert!((0.5..1.02).contains(&worst), "{worst}");
    let loss = &convert(&file, Options::default()).unwrap().losses[0];
    assert!((loss.amount * 100.0 - worst).abs() < 1e-6, "{loss}");
    assert!((this.peak() - 3.375).abs() < 0.05, "{}", this.peak());
    assert!((this.speed().2 - 3.375).abs() < 0.01, "{:?}", this.speed());
}

#[test]
fn a_reversed_move_follows_the_same_path_back() {
    let file = pan("\"duration\": 5", "\"duration\": 6");
    let (there, back) = (planned(&file, Count::Video, false), planned(&file, Count::Video, true));
    assert_eq!((back.plan.start, back.plan.stop, back.lead_in), (Steps(9000), Steps(0), 1500));
    for at in 0..=4000 {
        let off = back.plan.at(at).0 - there.plan.at(4000 - at).0;
        // Both are cut to whole steps, each towards its own start.
        assert!(off.abs() <= 2, "{off} at {at}: {there:?}");
    }
}

#[test]
fn photos_are_near_the_curve() {
    let file = pan("Pan", "Pan");
    for shots in [2, 3, 10, 37, 500] {
        let this = planned(&file, Count::Shots(shots), false);
        assert!(this.deviation <= (this.peak() / 2.0).max(90.0), "{this:?}");
        assert!(this.lead_in + this.plan.travel.0 < shots.max(3), "{shots}: {this:?}");
    }
}

#[test]
fn the_travel_of_a_time_lapse_is_in_milliseconds_and_its_lead_in_in_photos() {
    let file = pan("Pan", "Pan");
    let (shots, interval) = (11, 2000);
    let lapse = planned(&file, Count::Lapse { shots, interval }, false);
    // Ten intervals of 2 s for a move of 5 s, of which the axis uses the time from 0.5 to 4.5 s.
    assert_eq!((lapse.lead_in, lapse.plan.travel), (1, Span(16_000)));
    let video = planned(&file, Count::Video, false);
    assert!((lapse.peak() * 4.0 - video.peak()).abs() < 0.05, "a quarter of the speed: {}", lapse.peak());
}

#[test]
fn a_curve_that_no_planned_move_follows_is_a_loss_at_its_place() {
    let wild = pan("\"position\": 90 }", "\"position\": 90, \"arrive\": [-4, 20] }");
    let loss = &convert(&wild, Options::default()).unwrap().losses[0];
    assert!(loss.amount > 5.0 && (0.5..4.5).contains(&loss.time) && loss.unit == "°", "{loss}");
    let slide = Move::parse("", SLIDE).unwrap();
    let loss = &convert(&slide, Options::default()).unwrap().losses[0];
    assert!((30.0..200.0).contains(&loss.amount), "four key frames: {loss}");
}

#[test]
fn the_excess_of_a_planned_move_is_its_own() {
    let fast = pan("\"velocity\": 40", "\"velocity\": 20");
    let lines: Vec<_> = convert(&fast, Options::default()).unwrap().excesses.iter().map(ToString::to_string).collect();
    assert!(lines.len() == 1 && lines[0].contains("the limit is 20 °/s"), "{lines:?}");
    let straight = pan("\"position\": 0 }", "\"position\": 0, \"ease\": \"linear\" }");
    let straight = straight.to_json().replace("\"position\": 90 }", "\"position\": 90, \"ease\": \"linear\" }");
    let straight = Move::parse("", &straight).unwrap();
    let found = convert(&straight, Options::default()).unwrap().excesses;
    assert!(matches!(found[..], [Excess { kind: ExcessKind::Start(_), .. }, Excess { kind: ExcessKind::End(_), .. }]));
}

#[test]
fn what_does_not_fit_is_an_error() {
    let long = pan("\"duration\": 5,", "");
    let long =
        long.to_json().replace("\"duration\": 4.5", "\"duration\": 20000").replace("\"time\": 4.5", "\"time\": 20000");
    let error = convert(&Move::parse("", &long).unwrap(), Options::default()).unwrap_err();
    assert!(error.to_string().contains("too long"), "{error}");
    let other = Options { node: Some(Address(4)), ..Options::default() };
    let error = convert(&pan("Pan", "Pan"), other).unwrap_err();
    assert_eq!(error.to_string(), "no axis has a motor of node 4");
    let late = Planned { lead_in: 70_000, ..planned(&pan("Pan", "Pan"), Count::Video, false) };
    assert!(late.messages(true).is_ok() && late.messages(false).unwrap_err().to_string().contains("70000"));
}

#[test]
fn smooth_key_frames_are_exact_and_their_messages_are_in_order() {
    let slide = Move::parse("", &SLIDE.replace("\"ease\": 0.6", "\"ease\": \"smooth\"")).unwrap();
    let keys = key_frames(&slide, KeyOptions::default()).unwrap();
    // Four key frames, and the rests before and after them. A step is 1/80 mm.
    assert_eq!(keys.axes[0].keys.len(), 6);
    assert!(keys.losses[0].amount < 1e-3, "{}", keys.losses[0]);
    let messages: Vec<_> = keys.axes[0].messages().collect();
    assert_eq!(messages.len(), 2 + 3 * 6 + 1);
    assert!(matches!(messages[1], beyond::HostMessage::KeySetCount(beyond::KeySetCount { count: 6 })));
    let flat = Move::parse("", SLIDE).unwrap();
    let few = key_frames(&flat, KeyOptions { most: 6, ..KeyOptions::default() }).unwrap();
    let many = key_frames(&flat, KeyOptions { most: 40, ..KeyOptions::default() }).unwrap();
    assert!(few.losses[0].amount > 1.0 && many.losses[0].amount < 0.05, "{} {}", few.losses[0], many.losses[0]);
}

fn any_hoot() -> impl Strategy<Value = Move> {
    any_move().prop_filter("hoot", |subject| subject.axes()[0].hoot().is_some())
}

proptest! {
    // The nearest planned move takes a while to find.
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn planned_moves_are_within_the_loss(
        subject in any_hoot(),
        count in prop_oneof![
            Just(Count::Video),
            (2_u32..2000).prop_map(Count::Shots),
            (2_u32..500, 1_u32..5000).prop_map(|(shots, interval)| Count::Lapse { shots, interval }),
        ],
        reverse in any::<bool>(),
        at in prop::collection::vec(0.0..1.0, 32),
    ) {
        let converted = convert(&subject, Options { count, reverse, node: None }).unwrap();
        let (planned, loss, clock) = (converted.planned[0], &converted.losses[0], Clock::new(&subject, count));
        let scale = subject.axes()[0].hoot().unwrap().scale;
        for part in at {
            let part: f64 = part;
            let count = counts((part * subject.duration() / clock.tick()).floor()).unwrap();
            let elapsed = count.saturating_sub(planned.lead_in * clock.counts_of_travel);
            let steps = if clock.by_shots { planned.plan.at_shot(elapsed) } else { planned.plan.at(elapsed) };
            let time = f64::from(count) * clock.tick();
            let time = if reverse { subject.duration() - time } else { time };
            let off = (scale.position(steps.0) - subject.axes()[0].curve().position(time)).abs();
            prop_assert!(off <= loss.amount * (1.0 + 1e-9) + 1e-9, "{} at {}: {}", off, time, loss);
        }
    }

    #[test]
    fn key_frames_are_within_the_loss(
        subject in any_hoot(),
        most in 2_u16..40,
        at in prop::collection::vec(0.0..=1.0, 64),
    ) {
        let converted = key_frames(&subject, KeyOptions { most, ..KeyOptions::default() }).unwrap();
        let (keys, loss) = (&converted.axes[0], &converted.losses[0]);
        let scale = subject.axes()[0].hoot().unwrap().scale;
        for part in at {
            let time = part * subject.duration();
            let played = (keys.position(time * 1000.0) - scale.offset()) / scale.per_unit();
            let off = (played - subject.axes()[0].curve().position(time)).abs();
            prop_assert!(off <= loss.amount * (1.0 + 1e-9) + 1e-9, "{} at {}: {}", off, time, loss);
        }
    }
}
