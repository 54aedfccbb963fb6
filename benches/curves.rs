//! Bezier segments compared with other crates: the position of an axis at a time.
//!
//! All contenders get the same segments and times, and each is asked in its best way: `kurbo` by its solver of cubic
//! polynomials, not by bisection. First, the positions of each are compared with those of a search by bisection: they
//! must agree within the bound next to the name. The greatest errors are printed, and with them the greatest backward
//! errors: how far the time at the found curve parameter is from the time that was asked for. `keyframe` 1.1.1 is
//! compared but not timed: its table of first guesses has steps of 20 instead of 1/19, so it finds another root from
//! some of them.

use std::hint::black_box;

use benches::ratios::{Contender, contender};
use benches::report::Report;
use motion_core::bezier::{self, Cursor, Motion, Point, Segment};

/// Number of times in a batch.
const BATCH: usize = 16;
/// Number of segments.
const SEGMENTS: usize = 32;
/// Number of times on each segment: one second at 1 kHz.
const TIMES: usize = 992;

/// A segment from (0, 0) to (1, 1), in the form of each contender.
struct Curve {
    handles: [f64; 4],
    ours: Segment,
    lyon: lyon_geom::CubicBezierSegment<f64>,
}

impl Curve {
    fn new(handles: [f64; 4]) -> Self {
        let [x1, y1, x2, y2] = handles;
        let points = [Point::ZERO, Point::new(x1, y1), Point::new(x2, y2), Point::new(1.0, 1.0)];
        let point = lyon_geom::point;
        Self {
            handles,
            ours: Segment::new(points).expect("finite"),
            lyon: lyon_geom::CubicBezierSegment {
                from: point(0.0, 0.0),
                ctrl1: point(x1, y1),
                ctrl2: point(x2, y2),
                to: point(1.0, 1.0),
            },
        }
    }

    /// The segment with the same times whose position is the curve parameter.
    fn parameters(&self) -> Self {
        let [x1, _, x2, _] = self.handles;
        Self::new([x1, 1.0 / 3.0, x2, 2.0 / 3.0])
    }

    /// The position as a polynomial of the curve parameter.
    fn height(&self) -> impl Fn(f64) -> f64 + use<> {
        let [_, y1, _, y2] = self.handles;
        let ([a, b, c], d) = (polynomial(y1, y2), self.ours.points()[0].position);
        move |u| ((a * u + b) * u + c) * u + d
    }

    /// The position by bisection down to the last digit, and de Casteljau's algorithm.
    fn reference(&self, time: f64) -> f64 {
        let [x1, y1, x2, y2] = self.handles;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if de_casteljau(x1, x2, middle) < time { low = middle } else { high = middle }
        }
        de_casteljau(y1, y2, 0.5 * (low + high))
    }

    /// The position as a function of time, by a table.
    fn table(&self) -> impl Fn(f64) -> f64 + use<> {
        let table = bezier::Table::new(self.ours);
        move |time| table.position(time)
    }

    /// The position as a function of time, by the root of the time polynomial between 0 and 1.
    fn kurbo(&self) -> impl Fn(f64) -> f64 + use<> {
        let [x1, _, x2, _] = self.handles;
        let ([a, b, c], height) = (polynomial(x1, x2), self.height());
        move |time| {
            let roots = kurbo::common::solve_cubic(-time, c, b, a);
            height(roots.iter().copied().find(|root| (0.0..=1.0).contains(root)).unwrap_or(1.0))
        }
    }

    fn lyon(&self, time: f64) -> f64 {
        let found = self.lyon.solve_t_for_x(time);
        self.lyon.y(found.last().copied().unwrap_or(1.0))
    }

    fn flo(&self, time: f64) -> f64 {
        let [x1, y1, x2, y2] = self.handles;
        let found = flo_curves::bezier::solve_basis_for_t(0.0, x1, x2, 1.0, time);
        flo_curves::bezier::basis(found.last().copied().unwrap_or(1.0), 0.0, y1, y2, 1.0)
    }

    /// The position as a function of time, with its own table.
    fn easing(&self) -> impl Fn(f64) -> f64 + use<> {
        let [x1, y1, x2, y2] = self.handles;
        let easing = bezier_easing::bezier_easing(x1, y1, x2, y2).expect("handles within the segment");
        move |time| easing.sample(time)
    }

    /// The position as a function of time in `f32`, with its own table.
    fn keyframe(&self) -> impl Fn(f64) -> f64 + use<> {
        #[expect(clippy::cast_possible_truncation, reason = "it has nothing wider")]
        let [x1, y1, x2, y2] = self.handles.map(|handle| handle as f32);
        let curve = keyframe::functions::BezierCurve::from([x1, y1].into(), [x2, y2].into());
        move |time| keyframe::EasingFunction::y(&curve, time)
    }
}

pub(crate) fn chapter(report: &mut Report) {
    let typical = curves(0.15..0.85);
    let any = curves(0.0..1.0);
    let sorted: Vec<f64> = (1..=992_u32).map(|i| f64::from(i) / 993.0).collect();
    let mut random = Random(11);
    let scattered: Vec<f64> = (0..TIMES).map(|_| random.next()).collect();

    for (name, curves) in [("typical", &typical), ("any", &any)] {
        agree(name, curves, &[&sorted[..], &scattered].concat());
    }

    let mut table = report.table("B1 and B3, an axis at 1 kHz in batches of 16, 992 times");
    table.row("typical", batches(&typical, &sorted));
    table.row("any", batches(&any, &sorted));
    let mut table = report.table("B2, random access, 992 times, with the making of tables");
    table.row("typical", scatter(&typical, &scattered));
    table.row("any", scatter(&any, &scattered));
}

/// Work on the next segment in each call, in an endless cycle.
fn turns<'a, T>(curves: &'a [Curve], mut work: impl FnMut(&'a Curve) -> T + 'a) -> impl FnMut() -> T + 'a {
    let mut next = curves.iter().cycle();
    move || work(black_box(next.next().expect("an endless cycle")))
}

fn batches<'a>(curves: &'a [Curve], times: &'a [f64]) -> Vec<Contender<'a>> {
    let (mut out, mut motions) = ([0.0; BATCH], [Motion::default(); BATCH]);
    vec![
        contender("positions", turns(curves, move |curve| sampled(curve, black_box(times), &mut out))),
        contender(
            "with rates",
            turns(curves, move |curve| {
                let mut cursor = Cursor::new(curve.ours);
                for batch in black_box(times).chunks(BATCH) {
                    cursor.sample_motion(batch, &mut motions);
                    black_box(&motions);
                }
            }),
        ),
        // Three yardsticks, the last part of every solver. The first is in the form of a batch, two lanes at once.
        contender(
            "y alone",
            turns(curves, move |curve| {
                let y = curve.height();
                for batch in black_box(times).chunks_exact(BATCH) {
                    for (slot, &u) in out.iter_mut().zip(batch) {
                        *slot = y(u);
                    }
                    black_box(&out);
                }
            }),
        ),
        // The second adds up single positions, as for the peers below.
        contender("y alone, added up", turns(curves, |curve| sum(black_box(times), curve.height()))),
        // The third is what a caller without any preparation does: single positions from the control points.
        contender(
            "y by de Casteljau",
            turns(curves, move |curve| {
                let [_, y1, _, y2] = curve.handles;
                for &u in times {
                    black_box(de_casteljau(y1, y2, black_box(u)));
                }
            }),
        ),
        contender("kurbo", turns(curves, |curve| sum(black_box(times), curve.kurbo()))),
        contender("lyon_geom", turns(curves, |curve| sum(black_box(times), |time| curve.lyon(time)))),
        contender("flo_curves", turns(curves, |curve| sum(black_box(times), |time| curve.flo(time)))),
    ]
}

fn scatter<'a>(curves: &'a [Curve], times: &'a [f64]) -> Vec<Contender<'a>> {
    vec![
        contender("Table", turns(curves, |curve| sum(black_box(times), curve.table()))),
        contender("Segment", turns(curves, |curve| sum(black_box(times), |time| curve.ours.position(time)))),
        contender("kurbo", turns(curves, |curve| sum(black_box(times), curve.kurbo()))),
        contender("lyon_geom", turns(curves, |curve| sum(black_box(times), |time| curve.lyon(time)))),
        contender("flo_curves", turns(curves, |curve| sum(black_box(times), |time| curve.flo(time)))),
        contender("bezier_easing", turns(curves, |curve| sum(black_box(times), curve.easing()))),
    ]
}

fn sampled(curve: &Curve, times: &[f64], out: &mut [f64; BATCH]) {
    let mut cursor = Cursor::new(curve.ours);
    for batch in times.chunks(BATCH) {
        cursor.sample(batch, out);
        black_box(&out);
    }
}

fn sum(times: &[f64], position: impl Fn(f64) -> f64) -> f64 {
    times.iter().map(|&time| position(time)).sum()
}

/// Positions of a segment at some times.
type Positions = fn(&Curve, &[f64]) -> Vec<f64>;

/// Checks that all positions are those of the reference, within the bound of each contender.
fn agree(name: &str, curves: &[Curve], times: &[f64]) {
    fn each(times: &[f64], position: impl Fn(f64) -> f64) -> Vec<f64> {
        times.iter().map(|&time| position(time)).collect()
    }
    let batch = |curve: &Curve, times: &[f64]| {
        let (mut cursor, mut out) = (Cursor::new(curve.ours), vec![0.0; times.len()]);
        times.chunks(BATCH).zip(out.chunks_mut(BATCH)).for_each(|(times, out)| cursor.sample(times, out));
        out
    };
    // The bounds of the position and of the backward error.
    let contenders: [(&str, [f64; 2], Positions); 8] = [
        ("Segment", [1e-13, 1e-15], |curve, times| each(times, |time| curve.ours.position(time))),
        ("Table", [1e-13, 1e-15], |curve, times| each(times, curve.table())),
        ("Cursor, batch", [1e-13; 2], batch),
        ("kurbo", [1e-9; 2], |curve, times| each(times, curve.kurbo())),
        ("lyon_geom", [1e-9; 2], |curve, times| each(times, |time| curve.lyon(time))),
        ("flo_curves", [1e-9; 2], |curve, times| each(times, |time| curve.flo(time))),
        ("bezier_easing", [1e-9; 2], |curve, times| each(times, curve.easing())),
        ("keyframe, not timed", [f64::INFINITY; 2], |curve, times| each(times, curve.keyframe())),
    ];
    let references: Vec<Vec<f64>> = curves.iter().map(|curve| each(times, |time| curve.reference(time))).collect();
    println!("{name} handles, greatest errors:");
    for (peer, bounds, positions) in contenders {
        let mut worst = [0.0_f64; 2];
        for (curve, right) in curves.iter().zip(&references) {
            let [x1, _, x2, _] = curve.handles;
            let found = positions(curve, times).into_iter().zip(positions(&curve.parameters(), times));
            for ((&time, right), (position, parameter)) in times.iter().zip(right).zip(found) {
                let off = [position - right, de_casteljau(x1, x2, parameter) - time];
                worst = [0, 1].map(|i| worst[i].max(off[i].abs()));
            }
        }
        let ([position, backward], [most, farthest]) = (worst, bounds);
        println!("{peer:>22} position {position:.1e} of {most:.0e}, backward {backward:.1e} of {farthest:.0e}");
        assert!(position <= most && backward <= farthest, "{peer}, {name}: the same positions");
    }
}

/// A coordinate from 0 to 1 at a curve parameter, by its inner control points.
fn de_casteljau(first: f64, second: f64, u: f64) -> f64 {
    let mix = |from: f64, to: f64| from * (1.0 - u) + to * u;
    let (before, between, after) = (mix(0.0, first), mix(first, second), mix(second, 1.0));
    mix(mix(before, between), mix(between, after))
}

/// The coefficients of a coordinate from 0 to 1, without the constant, from its inner control points.
fn polynomial(first: f64, second: f64) -> [f64; 3] {
    [1.0 - 3.0 * (second - first), 3.0 * (second - 2.0 * first), 3.0 * first]
}

fn curves(handles: std::ops::Range<f64>) -> Vec<Curve> {
    let mut random = Random(5);
    let mut handle = || handles.start + random.next() * (handles.end - handles.start);
    (0..SEGMENTS).map(|_| Curve::new([(); 4].map(|()| handle()))).collect()
}

/// Random numbers from 0 to 1, from a fixed seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from_bits(1.0_f64.to_bits() | (self.0 >> 12)) - 1.0
    }
}
