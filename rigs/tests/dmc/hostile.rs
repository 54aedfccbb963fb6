//! Requests with any numbers, one after another: nothing panics, and a stop stops.

use dmc_proto::device::State;
use dmc_proto::message::{
    Acceleration, BlurPercent, Bool, CameraFlags, Degrees, Direction, FrameNumber, FramesPerSecond, GioCam,
    HardwareLimitSet, I32, JogSpeed, Milliseconds, Motor, MotorConfigure, MotorFlags, MotorJog, MotorMove, MotorPair,
    MotorResetPosition, MotorSetLimits, MotorSetSpeed, MotorStop, MotorStopAll, RtGo, RtJogAll, RtPositionFrame,
    RtRunMove, RtShootFrame, RtShootFrame2, RtUploadMoveAxis, RtUploadMoveBegin, RtUploadMoveEnd, RunFlags, Scaled,
    Speed, StartIndex, Steps,
};
use dmc_proto::{HostMessage, MessageId};
use motion_core::time::Millis;
use motion_rigs::device::Named as _;
use motion_rigs::dmc_device::{DmcDevice, Setup};
use motion_rigs::{LineId, Party as _, Rig as _};
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::stage::run;

const LINE: LineId = LineId(0);

struct Any(ChaCha8Rng);

impl Any {
    /// Number: mostly a small one, sometimes the least or the greatest.
    fn number(&mut self) -> i32 {
        match self.0.random_range(0..20) {
            0 => i32::MIN,
            1 => i32::MAX,
            2 => self.0.random(),
            3..=8 => self.0.random_range(-50_000..50_000),
            _ => self.0.random_range(0..60),
        }
    }

    fn count(&mut self) -> u32 {
        if self.0.random_bool(0.1) { u32::MAX } else { self.0.random_range(0..2000) }
    }

    fn motor(&mut self) -> Motor {
        Motor(self.0.random_range(0..=5))
    }

    fn steps(&mut self) -> Steps {
        Steps(self.number())
    }

    fn frame(&mut self) -> FrameNumber {
        FrameNumber(self.number())
    }

    /// Frame of a request.
    fn request(&mut self) -> Vec<u8> {
        let (motor, position, frame) = (self.motor(), self.steps(), self.frame());
        let pairs: Vec<_> = (0..self.0.random_range(0..4))
            .map(|_| MotorPair::new(Motor(self.0.random_range(1..=4)), self.steps(), self.steps()))
            .collect();
        let positions: Vec<_> = (0..self.0.random_range(0..60)).map(|_| I32::new(self.number())).collect();
        let (motors, tail) = (&pairs[..], &[][..]);
        let fps_x1000 = FramesPerSecond(Scaled(self.count()));
        let exposure_ms = Milliseconds(self.count());
        let message: HostMessage<'_> = match self.0.random_range(0..20) {
            0 => MotorMove { motor, position, tail }.into(),
            1 => {
                let speed = JogSpeed(Scaled(self.0.random_range(0..=10_001)));
                MotorJog { motor, speed, destination: position, tail }.into()
            }
            2 => MotorStop { motor, tail }.into(),
            3 => MotorStopAll { flags: None, tail }.into(),
            4 => MotorResetPosition { motor, position, tail }.into(),
            5 => {
                let flags = MotorFlags::from_bits_retain(self.0.random());
                MotorConfigure { motor, flags, tail }.into()
            }
            6 => {
                let (max_velocity, max_accel) = (Speed(self.count()), Acceleration(self.count()));
                MotorSetSpeed { motor, max_velocity, max_accel, tail }.into()
            }
            7 => MotorSetLimits {
                motor,
                lower_enable: Bool::from(self.0.random_bool(0.2)),
                lower: self.steps(),
                upper_enable: Bool::from(self.0.random_bool(0.2)),
                upper: self.steps(),
                hw_set: HardwareLimitSet(0),
                tail,
            }
            .into(),
            8 | 9 => {
                let start_index = StartIndex::new(self.0.random_range(0..60), self.0.random()).unwrap();
                RtUploadMoveAxis { motor, start_index, positions: &positions, tail }.into()
            }
            10 => RtUploadMoveBegin { start_frame: FrameNumber(0), end_frame: frame, tail }.into(),
            11 => RtUploadMoveEnd::default().into(),
            12 => RtPositionFrame { frame, tail }.into(),
            13 => {
                let flags = RunFlags::from_bits_retain(self.0.random::<u16>() & 0x33);
                let run = run(1, frame.0, self.number(), self.count(), flags);
                RtRunMove { fps_x1000, post_roll_ms: Milliseconds(self.count()), ..run }.into()
            }
            14 => {
                let direction = Direction(self.0.random_range(0..2));
                let blur_x10 = BlurPercent(Scaled(self.0.random_range(0..1100)));
                RtShootFrame { frame, direction, exposure_ms, blur_x10, motors, tail }.into()
            }
            15 => {
                let mut angle = || Degrees(self.0.random_range(0..=360));
                let (open_angle, close_angle) = (angle(), angle());
                RtShootFrame2 { frame, exposure_ms, open_angle, close_angle, motors, tail }.into()
            }
            16 | 17 => RtGo::default().into(),
            18 => RtJogAll { fps_x1000, destination: frame, tail }.into(),
            _ => GioCam { flags: CameraFlags::from_bits_retain(self.0.random_range(0..4)), tail }.into(),
        };
        bytes(&message)
    }
}

fn bytes(message: &HostMessage<'_>) -> Vec<u8> {
    let mut bytes = vec![0; message.encoded_len()];
    message.encode_into(MessageId(1), &mut bytes).unwrap();
    bytes
}

#[test]
fn a_stop_stops_after_any_requests() {
    let mut states = std::collections::BTreeSet::new();
    for seed in 0..40 {
        let mut any = Any(ChaCha8Rng::seed_from_u64(seed));
        let device = &Setup::DEVICES[usize::try_from(seed).unwrap() % Setup::DEVICES.len()];
        let setup = Setup::default().with_device(device.name).unwrap();
        let mut rig = DmcDevice::new(setup.with_frames(60));
        let mut now = Millis(0);
        rig.open(now, LINE);
        for _ in 0..60 {
            for _ in 0..any.0.random_range(1..12) {
                now = now.after(any.0.random_range(0..60));
                rig.receive(now, LINE, &any.request());
                states.insert(rig.machine().state().name());
                while rig.poll().is_some() {}
                let finite = |motor: &motion_rigs::motor::Motor| motor.at(now).position.is_finite();
                assert!(rig.motors().iter().all(finite), "seed {seed}");
            }
            if any.0.random_bool(0.2) {
                now = now.after(any.0.random_range(0..5000));
                rig.advance(now);
            }
            if any.0.random_bool(0.5) {
                rig.receive(now, LINE, &bytes(&MotorStopAll::default().into()));
                now = now.after(1500);
                rig.advance(now);
                let rests = |motor: &motion_rigs::motor::Motor| motor.rests();
                assert!(rig.motors().iter().all(rests), "seed {seed}: {:?}", rig.motors());
                assert!(
                    matches!(rig.machine().state(), State::Idle | State::Locked),
                    "seed {seed}: {:?}",
                    rig.machine().state()
                );
            }
        }
    }
    // The device took some of the requests.
    assert!(states.len() >= State::ALL.len() - 1, "{states:?}");
}
