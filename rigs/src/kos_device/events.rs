//! What the machine of a device wants done.

use kos_proto::Frame;
use kos_proto::HostMessage;
use kos_proto::device::{DeviceMachine, Event, Ignored, SessionId};
use kos_proto::message::{LedMode, MotorAddress};
use kos_proto::summary::{Direction, MotorSet};
use motion_core::time::Millis;
use tracing::{debug, info, warn};

use super::camera::Photo;
use super::playing::{Playing, Stage};
use super::{Drive, KosDevice, Line};
use crate::kos_host::StoredMove;
use crate::{LineId, Outgoing, Rig as _};

/// Milliseconds that it needs to start.
const BOOT: u64 = 500;

impl KosDevice {
    /// Does what the machine wants done.
    pub(super) fn happens(&mut self, now: Millis, event: Event, given: Option<&Frame<'_>>) {
        match event {
            Event::Move { motor, to, speed, acceleration } => {
                if let Some((it, drive)) = self.motor(motor) {
                    if it.rests() {
                        info!("motor {motor} is sent to {:.3}, at {} rev/s", to.0, speed.0);
                    } else {
                        debug!("motor {motor} is sent on to {:.3}, at {} rev/s", to.0, speed.0);
                    }
                    drive.goal = None;
                    it.go_to(now, to.0.into(), speed.0.into(), acceleration.0.into());
                }
            }
            Event::StopMotor { motor, acceleration } => {
                info!("motor {motor} stops");
                if let Some((it, drive)) = self.motor(motor) {
                    drive.goal = None;
                    // However gently it is to stop, it stops within a second.
                    let least = it.at(now).velocity.abs();
                    it.stop(now, acceleration.map(|acceleration| f64::from(acceleration.0).max(least)));
                }
            }
            Event::StopAll => {
                info!("everything stops");
                self.stop_all(now);
            }
            Event::Home { way, speed, motors } => {
                info!(
                    "its motors go to where the move {}",
                    if let Stage::At(1.0) = home(way) { "ends" } else { "begins" }
                );
                self.playing = self.store.trajectory.as_ref().and_then(|stored| {
                    let told = |motor: MotorAddress| {
                        self.drives.get(usize::from(motor.number()).wrapping_sub(1)).map(|drive| drive.told)
                    };
                    Playing::new(stored, &self.machine, told)
                });
                self.go_to_part(now, home(way), motors, Some(speed));
            }
            Event::Play { way, millis } => {
                info!("the move is played {way:?}, in {millis} ms");
                if let Some(playing) = &mut self.playing {
                    playing.stage = Stage::Runs { way, start: now, millis };
                }
            }
            Event::MoveToFrame { frame, last } => {
                debug!("its motors go to place {frame} of {last}");
                let part = f64::from(frame) / f64::from(last.max(1));
                self.go_to_part(now, Stage::At(part), MotorSet::of(self.addresses()), None);
            }
            Event::OpenShutter { millis } => {
                let moment = self.moment();
                self.camera.open(Photo { opened: now, closes: now.after(millis), moment });
                info!("photo {}, for {millis} ms", self.camera.count());
            }
            Event::MoveOver => {
                info!("the move is over");
                self.release(now);
                self.playing = None;
            }
            event => self.stores(event, given),
        }
    }

    /// What is stored, connected and ignored.
    fn stores(&mut self, event: Event, given: Option<&Frame<'_>>) {
        let message = given.and_then(|frame| HostMessage::decode(frame).ok());
        match (event, message) {
            (Event::Leds { master, slave }, _) => self.store.leds = (master, slave),
            (Event::StorePassword, Some(HostMessage::SetDevicePassword(given))) => {
                info!("another password is stored");
                self.store.password = given.password.0.into();
            }
            (Event::StoreTrajectory, Some(HostMessage::SetTrajectoryData(data))) => {
                info!("a move is stored");
                self.store.trajectory = StoredMove::new(&data).ok();
            }
            (Event::BadTrajectory(error), _) => {
                info!("a move cannot be played: {error}");
                self.store.trajectory = None;
            }
            (Event::StorePlatform(platform), _) => self.store.platform = platform,
            (Event::Close(session, why), _) => {
                info!("client {} is disconnected: {why:?}", session.0);
                self.hang_up(session);
            }
            (Event::Reboot, _) => {
                info!("it starts anew");
                self.start_anew();
            }
            (Event::Ignored(Ignored::Off), _) => {}
            (Event::Ignored(why), _) => debug!("ignored: {why:?}"),
            (event, _) => warn!("nothing is done about {event:?}"),
        }
    }

    fn hang_up(&mut self, session: SessionId) {
        if let Some(line) = self.lines.get_mut(usize::from(session.0)).filter(|line| line.is_open) {
            *line = Line::default();
            self.outgoing.push_back(Outgoing::HangUp(LineId(session.0)));
        }
    }

    pub(super) fn start_anew(&mut self) {
        for session in SessionId::ALL {
            self.hang_up(session);
        }
        self.machine = DeviceMachine::new(self.setup.options.with_platform(self.store.platform));
        self.store.trajectory = None;
        self.store.leds = (LedMode::OFF, LedMode::OFF);
        self.drives.fill(Drive::default());
        (self.starts, self.wake) = (Some(self.now.after(BOOT)), None);
    }
}

/// Where a move that is played this way begins.
const fn home(way: Direction) -> Stage {
    match way {
        Direction::Forward => Stage::At(0.0),
        Direction::Reverse => Stage::At(1.0),
    }
}
