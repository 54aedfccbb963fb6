//! Uploads and runs: each motor where the move has it, moment by moment.

use dmc_proto::device::State;
use dmc_proto::host::Failure;
use dmc_proto::message::{AckCode, FrameNumber, HostMessage, Motor, RtPositionFrame, RunFlags};
use examples::moves::Move;
use rigs::Rig as _;
use rigs::dmc_device::Setup;
use rigs::dmc_host::{Answer, Event};

use super::stage::{EMPTY, Stage, run, sample};

/// Holds the motors against the curves, and says which moment of the move it was.
///
/// At a frame a motor is where the curve is, but for half a step of rounding. Between two frames it goes straight, which
/// is off by an eighth of the acceleration and the time between frames squared, at most.
pub(crate) fn hold(stage: &Stage, sample: &Move) -> Option<f64> {
    let moment = stage.scene.rig.moment()?;
    let between = 1.0 / sample.frames.rate.to_f64();
    let time = (moment - 1.0) * between;
    for axis in &sample.axes {
        let Some(dmc) = axis.dmc else { continue };
        let curve = axis.curve();
        let zero = dmc.scale.position(0);
        let steps_per_unit = (dmc.scale.position(1) - zero).recip();
        let (here, planned) = (stage.at(dmc.motor), (curve.position(time) - zero) * steps_per_unit);
        let tolerance =
            curve.peak_acceleration().value.unwrap() * steps_per_unit.abs() * between * between / 8.0 + 0.51;
        assert!((here - planned).abs() <= tolerance, "motor {} at {moment}: {here}, planned {planned}", dmc.motor);
        if (moment - moment.round()).abs() < 1e-6 {
            assert!((here - planned).abs() <= 0.51, "motor {} at frame {moment}: {here}, {planned}", dmc.motor);
        }
    }
    Some(moment)
}

#[test]
fn a_move_is_uploaded_and_run() {
    for (name, fps, motors) in [("slide", 24_000, 1), ("crane", 23_976, 4)] {
        let (sample, table) = sample(name);
        let last = table.last_frame().0;
        let mut stage = Stage::up(Setup::default());
        assert_eq!(stage.upload(table.clone()), Ok(Answer::Done));
        assert_eq!(stage.scene.host.is_loaded(), Some(true));
        for motor in (1..=motors).map(Motor) {
            for frame in (1..=last).map(FrameNumber) {
                assert_eq!(stage.rig().uploaded(motor, frame).map(|steps| steps.0), table.steps(motor, frame));
            }
        }

        let token = stage.begin(run(fps, 1, last, 500, RunFlags::empty()));
        stage.start(token).unwrap();
        let mut moments = Vec::new();
        while stage.rig().state() != State::Idle {
            stage.tick();
            moments.extend(hold(&stage, &sample));
        }
        assert_eq!(stage.end(token, 5000), Ok(Answer::Done));
        assert!(!stage.scene.host.may_move());
        assert_eq!(stage.rig().on_frame(), Some(FrameNumber(last)));
        // In its own time.
        for pair in moments.windows(2) {
            let gone = pair[1] - pair[0];
            assert!((gone - f64::from(fps) / 1e6).abs() < 1e-6, "{pair:?}");
        }
        assert!(moments[0] < 1.1 && *moments.last().unwrap() > f64::from(last) - 0.1, "{moments:?}");
        for motor in 1..=motors {
            let end = f64::from(table.steps(Motor(motor), FrameNumber(last)).unwrap());
            assert_eq!(stage.at(motor).to_bits(), end.to_bits());
        }
        // Each frame was told once, with its number.
        let told: Vec<i32> = stage
            .told
            .iter()
            .filter_map(|(_, event)| match event {
                Event::Positions(positions) => Some(positions.moment.0.0 / 1000),
                _ => None,
            })
            .collect();
        assert!((1..=last).all(|frame| told.contains(&frame)));
    }
}
