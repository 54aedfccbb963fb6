//! Commands of the application, and why they are refused.

use motion_core::time::Millis;

use super::event::{Event, LinkDownReason, MoveState, Outcome, Refusal, StopTarget};
use super::hand::checked;
use super::input::{Command, Get, Go};
use super::machine::{HostMachine, State};
use super::playback::Playback;
use super::requests::Asker;
use super::stops::transmit_stop;
use super::transmit::{PasswordOf, Transmit};
use super::{Output, Token};
use crate::message::{MotorAddress, MotorSet};

/// End of a command that is followed: now, or later.
type Followed = Result<Option<Outcome<'static>>, Refusal>;

const DONE: Followed = Ok(Some(Outcome::Done(None)));
const SENT: Followed = Ok(Some(Outcome::Sent));
const LATER: Followed = Ok(None);

impl HostMachine {
    pub(super) fn command(&mut self, now: Millis, output: &mut Output<'_>, token: Token, command: Command) {
        self.motors.alive(now, &self.options);
        let outcome = match self.follow(now, output, token, command) {
            Ok(outcome) => outcome,
            Err(refusal) => Some(Outcome::Refused(refusal)),
        };
        if let Some(outcome) = outcome {
            output.event(Event::ended(token, outcome));
        }
    }

    fn follow(&mut self, now: Millis, output: &mut Output<'_>, token: Token, command: Command) -> Followed {
        match command {
            Command::Stop => self.stop(now, output),
            Command::StopMotor(motor) => self.stop_motor(now, output, motor),
            // Speed 0 is a stop (safety decision 3).
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
                    self.connect(output, endpoint);
                    DONE
                } else {
                    Err(Refusal::Connected)
                }
            }
            Command::Disconnect if self.endpoint.is_none() => Err(Refusal::NotConnected),
            Command::Disconnect => {
                self.close(now, output, LinkDownReason::Asked);
                self.playback = Playback::default();
                self.stops.resume(self.stops.deferred());
                DONE
            }
            Command::Alive => DONE,
            Command::Unlock if self.state == State::Locked => {
                self.unlock(now, output, PasswordOf::User);
                SENT
            }
            _ if !self.state.is_connected() => Err(Refusal::NotConnected),
            _ if self.state != State::Ready => Err(Refusal::NotReady),
            command => self.ready(now, output, token, command),
        }
    }

    /// Stops everything, first of all; without a connection as soon as there is one.
    fn stop(&mut self, now: Millis, output: &mut Output<'_>) -> Followed {
        if self.state.is_connected() {
            self.stop_all(now, output);
            SENT
        } else {
            self.await_rest();
            self.playback.stop(output, None);
            output.event(Event::StopNotConfirmed(StopTarget::All));
            Err(Refusal::NotConnected)
        }
    }

    /// Stops the move and every motor.
    pub(super) fn stop_all(&mut self, now: Millis, output: &mut Output<'_>) {
        self.await_rest();
        self.stop_playback(now, output);
        self.motors.stop_all(now, output, &self.options);
        self.raise_fence(now, output);
    }

    /// Notes a stop of everything. If motors were moved by hand and nothing else, these have to say that they rest;
    /// otherwise all.
    pub(super) fn await_rest(&mut self) {
        let moving = self.motors.moving();
        let by_hand = self.playback.state == MoveState::NoMove && !self.stops.may_move() && !moving.is_empty();
        let known = if by_hand { MotorSet::NONE } else { self.motors.all() };
        self.stops.begin(moving.with(known).with(self.stops.astray()).with(self.playback.moving()));
    }

    /// Stops the move: whatever it is, and whoever began it.
    pub(super) fn stop_playback(&mut self, now: Millis, output: &mut Output<'_>) {
        transmit_stop(output, Transmit::StopPlayback);
        self.playback.stop(output, Some(now.after(self.options.stop_timeout())));
    }

    /// Sends stops that are wanted of motors that nothing follows. The stop of a motor that is not known yet stays wanted.
    /// Returns whether any is sent.
    pub(super) fn stop_deferred(&mut self, now: Millis, output: &mut Output<'_>, motors: MotorSet) -> bool {
        for motor in motors.iter() {
            if self.motors.stop(now, output, &self.options, motor) {
                self.stops.resume(MotorSet::of([motor]));
            }
        }
        !motors.is_empty()
    }

    fn stop_motor(&mut self, now: Millis, output: &mut Output<'_>, motor: MotorAddress) -> Followed {
        let motor = MotorAddress(motor.number());
        let target = MotorSet::of([motor]);
        if target.is_empty() {
            return Err(Refusal::NoMotor);
        }
        let is_connected = self.state.is_connected();
        if is_connected && self.motors.stop(now, output, &self.options, motor) {
            self.raise_fence(now, output);
        } else {
            self.stops.defer(target);
            self.stops.lose(target);
            output.event(Event::StopNotConfirmed(StopTarget::Motor(motor)));
        }
        if is_connected { SENT } else { Err(Refusal::NotConnected) }
    }

    /// Follows what only a device does that is ready.
    fn ready(&mut self, now: Millis, output: &mut Output<'_>, token: Token, command: Command) -> Followed {
        match command {
            Command::Get(get) => {
                return if self.ask(now, output, get, Asker::Application(token)) { LATER } else { Err(Refusal::Busy) };
            }
            Command::SetLeds { master, slave } => output.transmit(Transmit::Leds { master, slave }),
            Command::SetPlatform(platform) => output.transmit(Transmit::Platform(platform)),
            Command::ResetDevice => output.transmit(Transmit::ResetDevice),
            Command::ChangePassword if !self.is_tcp() => return Err(Refusal::NoPassword),
            Command::ChangePassword if self.moves() || self.may_move() => return Err(Refusal::Moves),
            Command::ChangePassword => {
                output.transmit(Transmit::DevicePassword);
                output.transmit(Transmit::UserPassword(PasswordOf::New));
            }
            command => return self.motion(now, output, token, command),
        }
        SENT
    }

    /// Follows what moves something, or marks where it moves; not while a move runs.
    fn motion(&mut self, now: Millis, output: &mut Output<'_>, token: Token, command: Command) -> Followed {
        let armed = self.playback.state == MoveState::Armed;
        if self.playback.state == MoveState::Stopping || self.stops.is_waiting() {
            return Err(Refusal::Stopping);
        }
        if self.playback.state.moves() {
            return Err(Refusal::MoveRuns);
        }
        match command {
            Command::MoveTo(go) => {
                self.motors.move_to(now, output, &self.options, &mut self.stops, (checked(go)?, token))?;
                LATER
            }
            Command::Jog { motor, speed, acceleration } => {
                self.motors.jog(now, output, &self.options, &mut self.stops, (motor, speed, acceleration))?;
                SENT
            }
            Command::Bump(Go { position, .. }) if position.0 == 0.0 => Err(Refusal::Number),
            Command::Bump(go) => {
                self.motors.bump(now, output, &self.options, &mut self.stops, (checked(go)?, token))?;
                LATER
            }
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
                output.transmit(Transmit::TakePicture(exposure));
                SENT
            }
            Command::ResetAxis(motor) | Command::MarkBegin(motor) | Command::MarkEnd(motor) => {
                self.mark(now, output, token, (command, motor))
            }
            _ if self.motors.any_moves() || self.playback.is_homing() => Err(Refusal::Moves),
            command => self.play(now, output, token, command),
        }
    }

    /// Makes a move ready, or plays it; nothing else moves.
    fn play(&mut self, now: Millis, output: &mut Output<'_>, token: Token, command: Command) -> Followed {
        let state = match command {
            Command::Load { summary, .. } => {
                self.playback.store(&summary);
                MoveState::SettingUp
            }
            Command::PlayDirect { summary } => {
                self.playback.store(&summary);
                MoveState::Starting
            }
            Command::Play => MoveState::Starting,
            Command::RapidToFirstKeyFrame => {
                self.stops.sent_on(self.playback.motors());
                self.playback.rapid();
                output.transmit(Transmit::RapidToFirstKeyFrame);
                return SENT;
            }
            _ => return Err(Refusal::NotReady),
        };
        self.stops.sent_on(self.playback.motors());
        self.playback.begin(now, &self.options, state, token);
        if command != Command::Play {
            output.transmit(Transmit::Trajectory);
        }
        output.transmit(match command {
            Command::Load { delay_return, .. } => Transmit::Setup { delay_return },
            _ => Transmit::Start,
        });
        LATER
    }

    /// Marks where a range begins and ends, or forgets it.
    fn mark(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        token: Token,
        (command, motor): (Command, MotorAddress),
    ) -> Followed {
        let all = command == Command::ResetAxis(MotorAddress::ALL);
        if !all && self.motors.get(motor).is_none() {
            return Err(Refusal::NoMotor);
        }
        if self.motors.moves(motor) {
            return Err(Refusal::Moves);
        }
        match command {
            Command::MarkBegin(_) => self.calibration.mark_begin(output, motor),
            Command::MarkEnd(_) => {
                self.calibration.mark_end(now, output, &self.options, motor, token)?;
                return LATER;
            }
            _ => {
                output.transmit(Transmit::ResetAxis(MotorAddress(motor.number())));
                if all {
                    // It is not answered, so the motors are asked for.
                    self.ask(now, output, Get::MotorInfo, Asker::Machine);
                }
            }
        }
        SENT
    }
}
