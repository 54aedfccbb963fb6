//! Events of the session, and how the rig carries them out.

use kos_proto::device::{DeviceMachine, Event, Ignored, Session, SessionId};
use kos_proto::message::{Direction, LedMode, MotorAddress, MotorSet};
use kos_proto::{DeviceMessage, Frame};
use motion_core::time::Millis;
use tracing::{Level, debug, enabled, info, warn};

use super::camera::Photo;
use super::playing::{Playing, Stage};
use super::{Drive, KosDevice};
use crate::{LineId, Outgoing, Rig as _};

/// Time that the device needs to start, in milliseconds.
const BOOT: u64 = 500;

impl KosDevice {
    /// Carries out an event of the session.
    pub(super) fn event(&mut self, now: Millis, event: &Event<'_>) {
        match *event {
            Event::Move { motor: address, to, speed, acceleration } => {
                if let Some((motor, drive)) = self.motor(address) {
                    if motor.rests() {
                        info!("motor {address} is sent to {:.3}, at {} rev/s", to.0, speed.0);
                    } else {
                        debug!("motor {address} is sent on to {:.3}, at {} rev/s", to.0, speed.0);
                    }
                    drive.goal = None;
                    motor.go_to(now, to.0.into(), speed.0.into(), acceleration.0.into());
                }
            }
            Event::StopMotor { motor: address, acceleration } => {
                info!("motor {address} stops");
                if let Some((motor, drive)) = self.motor(address) {
                    drive.goal = None;
                    // The motor stops within a second, however small the acceleration of the command is.
                    let least = motor.at(now).velocity.abs();
                    motor.stop(now, acceleration.map(|acceleration| f64::from(acceleration.0).max(least)));
                }
            }
            Event::StopAll => {
                info!("everything stops");
                self.stop_all(now);
            }
            Event::Home { way, speed, motors } => {
                info!("the motors go to where the move {}", if way == Direction::Reverse { "ends" } else { "begins" });
                self.playing = self.store.trajectory.as_ref().and_then(|stored| {
                    let told = |motor: MotorAddress| {
                        self.drives.get(usize::from(motor.number()).wrapping_sub(1)).map(|drive| drive.told)
                    };
                    Playing::new(stored, self.session.machine(), told)
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
                debug!("the motors go to place {frame} of {last}");
                let part = f64::from(frame) / f64::from(last.max(1));
                self.go_to_part(now, part, MotorSet::of(self.addresses()), None);
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
            Event::Leds { master, slave } => self.store.leds = (master, slave),
            Event::BadTrajectory(error) => {
                info!("a move cannot be played: {error}");
                self.store.trajectory = None;
            }
            Event::StorePlatform(platform) => self.store.platform = platform,
            Event::Disconnect { session, reason } => {
                info!("client {} is disconnected: {reason}", session.0);
                self.hang_up(session);
            }
            Event::Reboot => {
                info!("the device starts anew");
                self.start_anew();
            }
            Event::Ignored(Ignored::Off) => {}
            Event::Ignored(why) => debug!("ignored: {why}"),
            event => warn!("not carried out: {event:?}"),
        }
    }

    fn hang_up(&mut self, session: SessionId) {
        if self.lines.get_mut(usize::from(session.0)).and_then(Option::take).is_some() {
            self.outgoing.push_back(Outgoing::HangUp(LineId(session.0)));
        }
    }

    pub(super) fn start_anew(&mut self) {
        for session in SessionId::ALL {
            self.hang_up(session);
        }
        *self.session = Session::new(DeviceMachine::new(self.setup.options.with_platform(self.store.platform)));
        self.store.trajectory = None;
        self.store.leds = (LedMode::OFF, LedMode::OFF);
        self.drives.fill(Drive::default());
        (self.starts, self.wake) = (Some(self.now.after(BOOT)), None);
    }
}

/// Notes a message in the log. Errors and ranges count as events.
pub(super) fn said(bytes: &[u8]) {
    if !enabled!(Level::INFO) {
        return;
    }
    match Frame::decode(bytes).map(|frame| DeviceMessage::decode(&frame)) {
        Ok(Ok(message @ (DeviceMessage::ErrorStatus(_) | DeviceMessage::MotorCalibrated(_)))) => info!("> {message}"),
        Ok(Ok(message)) => debug!("> {message}"),
        _ => {}
    }
}

/// Part of the move at which it begins if it is played in this direction.
const fn home(way: Direction) -> f64 {
    match way {
        Direction::Forward => 0.0,
        Direction::Reverse => 1.0,
    }
}
