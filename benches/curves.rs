//! Bezier segments compared with other crates: the position of an axis at a time.
//!
//! All contenders get the same segments and times. Before the measurement, each contender calculates all
//! positions. They must equal the positions of a search by bisection, within the bound of the contender.
//! The greatest errors are printed. `keyframe` 1.1.1 is checked but not timed: its table of first guesses has
//! steps of 1/20 instead of 1/19, and from some of these guesses it finds another root.

use std::hint::black_box;

use benches::ratios::{Contender, Table, contender};
use criterion::{Criterion, Throughput};
use kurbo::ParamCurve;
use motion_core::bezier::{Cursor, Motion, Point, Segment};

/// Number of times in one batch.
const BATCH: usize = 16;
/// Number of segments, and number of times in each: about a second at 1 kHz.
const SEGMENTS: usize = 32;
const TIMES: usize = 992;

/// Segment from (0, 0) to (1, 1) in the form of each contender.
struct Curve {
    handles: [f64; 4],
    ours: Segment,
    kurbo: kurbo::CubicBez,
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
            kurbo: kurbo::CubicBez::new((0.0, 0.0), (x1, y1), (x2, y2), (1.0, 1.0)),
            lyon: lyon_geom::CubicBezierSegment {
                from: point(0.0, 0.0),
                ctrl1: point(x1, y1),
                ctrl2: point(x2, y2),
                to: point(1.0, 1.0),
            },
        }
    }

    /// Position as a polynomial of the curve parameter.
    fn height(&self) -> impl Fn(f64) -> f64 + use<> {
        let [_, y1, _, y2] = self.handles;
        let (a, b, c, d) = (1.0 - 3.0 * (y2 - y1), 3.0 * (y2 - 2.0 * y1), 3.0 * y1, self.ours.points()[0].position);
        move |u| ((a * u + b) * u + c) * u + d
    }

    /// Position by bisection to full precision and de Casteljau's construction.
    fn reference(&self, time: f64) -> f64 {
        let [x1, y1, x2, y2] = self.handles;
        let at = |a: f64, b: f64, u: f64| {
            let mix = |from: f64, to: f64| from * (1.0 - u) + to * u;
            let (ab, bc, cd) = (mix(0.0, a), mix(a, b), mix(b, 1.0));
            mix(mix(ab, bc), mix(bc, cd))
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if at(x1, x2, middle) < time { low = middle } else { high = middle }
        }
        at(y1, y2, 0.5 * (low + high))
    }

    fn kurbo(&self, time: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..47 {
            let middle = 0.5 * (low + high);
            if self.kurbo.eval(middle).x < time { low = middle } else { high = middle }
        }
        self.kurbo.eval(0.5 * (low + high)).y
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

    /// Position as a function of time, with its own table.
    fn easing(&self) -> impl Fn(f64) -> f64 + use<> {
        let [x1, y1, x2, y2] = self.handles;
        let easing = bezier_easing::bezier_easing(x1, y1, x2, y2).expect("handles within the segment");
        move |time| easing.sample(time)
    }

    /// Position as a function of time, with its own table, in `f32`.
    fn keyframe(&self) -> impl Fn(f64) -> f64 + use<> {
        #[expect(clippy::cast_possible_truncation, reason = "the crate has no wider type")]
        let [x1, y1, x2, y2] = self.handles.map(|handle| handle as f32);
        let curve = keyframe::functions::BezierCurve::from([x1, y1].into(), [x2, y2].into());
        move |time| keyframe::EasingFunction::y(&curve, time)
    }
}

fn main() {
    let typical = curves(0.15..0.85);
    let any = curves(0.0..1.0);
    let sorted: Vec<f64> = (1..=992_u32).map(|i| f64::from(i) / 993.0).collect();
    let mut random = Random(11);
    let scattered: Vec<f64> = (0..TIMES).map(|_| random.next()).collect();

    for (name, curves, times) in [("typical", &typical, &sorted), ("any", &any, &scattered)] {
        agree(name, curves, times);
    }

    let mut table = Table::new("B1 and B3, an axis at 1 kHz in batches of 16, 992 times");
    table.row("typical", batches(&typical, &sorted));
    table.row("any", batches(&any, &sorted));
    let mut table = Table::new("B2, random access, 992 times");
    table.row("typical", scatter(&typical, &scattered));
    table.row("any", scatter(&any, &scattered));

    let mut criterion = Criterion::default().configure_from_args();
    let mut group = criterion.benchmark_group("curves");
    group.throughput(Throughput::Elements(TIMES as u64));
    group.bench_function("batches", |bencher| {
        let mut out = [0.0; BATCH];
        bencher.iter(|| sampled(&typical[0], black_box(&sorted), &mut out));
    });
    group.bench_function("random access", |bencher| {
        bencher.iter(|| sum(black_box(&scattered), |time| typical[0].ours.position(time)));
    });
    group.finish();
    criterion.final_summary();
}

/// Closure that does the work on the next segment at each call, in an endless cycle.
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
        // The last step of any solver, for comparison: as a batch, with two lanes at once...
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
        // ... and one position after the other, added up, as for the peers below.
        contender("y alone, added up", turns(curves, |curve| sum(black_box(times), curve.height()))),
        contender("kurbo, bisection", turns(curves, |curve| sum(black_box(times), |time| curve.kurbo(time)))),
        contender("lyon_geom", turns(curves, |curve| sum(black_box(times), |time| curve.lyon(time)))),
        contender("flo_curves", turns(curves, |curve| sum(black_box(times), |time| curve.flo(time)))),
    ]
}

fn scatter<'a>(curves: &'a [Curve], times: &'a [f64]) -> Vec<Contender<'a>> {
    vec![
        contender("motion-core", turns(curves, |curve| sum(black_box(times), |time| curve.ours.position(time)))),
        contender("kurbo, bisection", turns(curves, |curve| sum(black_box(times), |time| curve.kurbo(time)))),
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

/// Checks that all positions equal those of the reference, within the bound of each contender.
fn agree(name: &str, curves: &[Curve], times: &[f64]) {
    let bounds = [
        ("motion-core, single", 1e-13),
        ("motion-core, batch", 1e-13),
        ("kurbo", 1e-13),
        ("lyon_geom", 1e-9),
        ("flo_curves", 1e-9),
        ("bezier_easing", 1e-9),
        ("keyframe, not timed", f64::INFINITY),
    ];
    let mut worst = bounds.map(|_| 0.0_f64);
    for curve in curves {
        let mut batch = vec![0.0; times.len()];
        Cursor::new(curve.ours).sample(times, &mut batch);
        let (easing, keyframe) = (curve.easing(), curve.keyframe());
        for (&time, batch) in times.iter().zip(batch) {
            let (right, single) = (curve.reference(time), curve.ours.position(time));
            let exact = [single, batch, curve.kurbo(time), curve.lyon(time), curve.flo(time)];
            let found = exact.into_iter().chain([easing(time), keyframe(time)]);
            for (worst, found) in worst.iter_mut().zip(found) {
                *worst = worst.max((found - right).abs());
            }
        }
    }
    println!("{name} handles, greatest errors:");
    for ((peer, bound), worst) in bounds.into_iter().zip(worst) {
        println!("{peer:>22} {worst:.1e}, allowed {bound:.0e}");
        assert!(worst <= bound, "{peer}, {name}: the error is within the bound");
    }
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
