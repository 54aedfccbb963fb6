//! What the application wants, and why it may not have it.

use motion_core::time::Millis;

use super::io::{CloseReason, Command, Event, Go, Refusal};
use super::machine::{HostMachine, State};
use super::requests::{Asker, Get};
use super::send::{PasswordOf, Send};
use super::tracker::{self, Tracker};
use super::{Output, motors};
use crate::message::MotorAddress;
use crate::summary::MotorSet;

impl HostMachine {
    pub(super) fn command(&mut self, now: Millis, output: &mut Output, command: Command) {
        self.motors.alive(now, &self.options);
        let followed = match command {
            Command::Stop => {
                self.stop(now, output);
                Ok(())
            }
            Command::StopMotor(motor) => self.stop_motor(now, output, motor),
            // So is what says so by its speed (safety decision 3).
            Command::MoveTo(Go { motor, speed, .. })
            | Command::Bump(Go { motor, speed, .. })
            | Command::Jog { motor, speed, .. }
                if speed.0 == 0.0 =>
            {
                self.stop_motor(now, output, motor)
            }
            Command::Connect(endpoint) => {
                if matches!(self.state, State::Discovering | State::Disconnected) {
                    self.tries = 0;
                    self.open(output, endpoint);
                    Ok(())
                } else {
                    Err(Refusal::Connected)
                }
            }
            Command::Disconnect if self.endpoint.is_none() => Err(Refusal::NotConnected),
            Command::Disconnect => {
                self.close(now, output, CloseReason::Asked);
                self.tracker = Tracker::default();
                Ok(())
            }
            Command::Alive => Ok(()),
            Command::Unlock if self.state == State::Locked => {
                self.unlock(now, output, PasswordOf::User);
                Ok(())
            }
            _ if !self.state.is_connected() => Err(Refusal::NotConnected),
            _ if self.state != State::Ready => Err(Refusal::NotReady),
            command => self.ready(now, output, command),
        };
        if let Err(why) = followed {
            output.event(Event::Refused(why));
        }
    }

    /// Stops everything, first of all.
    fn stop(&mut self, now: Millis, output: &mut Output) {
        if self.state.is_connected() {
            self.stop_move(now, output);
            self.motors.stop_all(now, output, &self.options);
            self.raise_fence(now, output);
        } else {
            self.tracker.stop(None);
            output.event(Event::StopNotConfirmed(None));
        }
    }

    fn stop_motor(&mut self, now: Millis, output: &mut Output, motor: MotorAddress) -> Result<(), Refusal> {
        if MotorSet::of([motor]).is_empty() {
            return Err(Refusal::NoMotor);
        }
        if self.state.is_connected() {
            self.motors.stop(now, output, &self.options, motor);
        } else {
            output.event(Event::StopNotConfirmed(Some(motor)));
        }
        Ok(())
    }

    /// What only a device does that is ready.
    fn ready(&mut self, now: Millis, output: &mut Output, command: Command) -> Result<(), Refusal> {
        match command {
            Command::Get(get, token) => {
                return if self.ask(now, output, get, Asker::Application(token)) { Ok(()) } else { Err(Refusal::Busy) };
            }
            Command::SetLeds { master, slave } => output.send(Send::Leds { master, slave }),
            Command::SetPlatform(platform) => output.send(Send::Platform(platform)),
            Command::ResetDevice => output.send(Send::ResetDevice),
            Command::ChangePassword if self.moves() => return Err(Refusal::Moves),
            Command::ChangePassword => {
                output.send(Send::DevicePassword);
                output.send(Send::UserPassword(PasswordOf::New));
            }
            command => return self.motion(now, output, command),
        }
        Ok(())
    }

    /// What moves something, or says where it moves; not while a move runs.
    fn motion(&mut self, now: Millis, output: &mut Output, command: Command) -> Result<(), Refusal> {
        let armed = self.tracker.state == tracker::State::Armed;
        if self.tracker.state.moves() {
            return Err(Refusal::MoveRuns);
        }
        match command {
            Command::MoveTo(go) => self.motors.move_to(now, output, &self.options, motors::checked(go)?),
            Command::Jog { motor, speed, acceleration } => {
                let jog = motors::checked_jog(motor, speed, acceleration)?;
                self.motors.jog(now, output, &self.options, &jog)
            }
            Command::Bump(Go { position, .. }) if position.0 == 0.0 => Err(Refusal::Number),
            Command::Bump(go) => self.motors.bump(now, output, &self.options, motors::checked(go)?),
            Command::Load { .. }
            | Command::PlayDirect { .. }
            | Command::ResetAxis(_)
            | Command::MarkBegin(_)
            | Command::MarkEnd(_)
                if armed =>
            {
                Err(Refusal::MoveRuns)
            }
            Command::Play | Command::RapidToFirstKeyFrame if !armed => Err(Refusal::NoMove),
            Command::TakePicture(exposure) if !exposure.0.is_finite() || exposure.0 < 0.0 => Err(Refusal::Number),
            Command::TakePicture(exposure) => {
                output.send(Send::TakePicture(exposure));
                Ok(())
            }
            Command::ResetAxis(_) | Command::MarkBegin(_) | Command::MarkEnd(_) => self.mark(now, output, command),
            _ if self.motors.any_moves() || self.tracker.is_homing() => Err(Refusal::Moves),
            command => self.play(now, output, command),
        }
    }

    /// What makes a move ready, or plays it; nothing else moves.
    fn play(&mut self, now: Millis, output: &mut Output, command: Command) -> Result<(), Refusal> {
        match command {
            Command::Load { summary: _, way, delay_return } => {
                self.tracker.begin(now, &self.options, tracker::State::SettingUp, way);
                output.send(Send::Trajectory);
                output.send(Send::Setup { way, delay_return });
                Ok(())
            }
            Command::PlayDirect { summary: _, way } => {
                self.tracker.begin(now, &self.options, tracker::State::Starting, way);
                output.send(Send::Trajectory);
                output.send(Send::Start(way));
                Ok(())
            }
            Command::Play => {
                let way = self.tracker.way();
                self.tracker.begin(now, &self.options, tracker::State::Starting, way);
                output.send(Send::Start(way));
                Ok(())
            }
            Command::RapidToFirstKeyFrame => {
                self.tracker.rapid();
                output.send(Send::RapidToFirstKeyFrame);
                Ok(())
            }
            _ => Err(Refusal::NotReady),
        }
    }

    /// What says where a range begins and ends.
    fn mark(&mut self, now: Millis, output: &mut Output, command: Command) -> Result<(), Refusal> {
        let (Command::ResetAxis(motor) | Command::MarkBegin(motor) | Command::MarkEnd(motor)) = command else {
            return Err(Refusal::NotReady);
        };
        let all = command == Command::ResetAxis(MotorAddress::ALL);
        if !all && self.motors.get(motor).is_none() {
            return Err(Refusal::NoMotor);
        }
        if self.motors.moves(motor) {
            return Err(Refusal::Moves);
        }
        match command {
            Command::MarkBegin(motor) => self.calibration.mark_begin(output, motor),
            Command::MarkEnd(motor) => return self.calibration.mark_end(now, output, &self.options, motor),
            _ => {
                output.send(Send::ResetAxis(MotorAddress(motor.number())));
                if all {
                    // It is not answered, so the motors are asked for.
                    self.ask(now, output, Get::MotorInfo, Asker::Machine);
                }
            }
        }
        Ok(())
    }
}
