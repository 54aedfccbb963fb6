//! Motors that a client knows, and how it moves them by hand.
//!
//! Commands to one motor are not sent faster than the device bears: of those that come too fast, the last one counts. A
//! stop overtakes them all, and is sent again until the motor rests.

use core::mem;

use arrayvec::ArrayVec;
use motion_core::time::Millis;

use super::event::{Event, Failure, Outcome, Refusal, StopTarget};
use super::hand::{Followed, Hand, Motion, Report, checked, go_of, stop_of};
use super::input::Go;
use super::stops::{Stops, transmit_stop};
use super::transmit::Transmit;
use super::{Options, Output, Token};
use crate::frame::MessageId;
use crate::message::{
    ActionId, ErrorCode, MOTORS, Motor, MotorAddress, MotorCalibrated, MotorPlace, MotorSet, Rotations,
    RotationsPerSecond, RotationsPerSecondSquared,
};

/// All motors of the device.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub(super) struct Motors {
    list: ArrayVec<Followed, MOTORS>,
    /// Motors that the series under way reported.
    reported: MotorSet,
    /// Time until which the application has to give a command, while a motor jogs.
    alive_until: Option<Millis>,
}

impl Motors {
    pub(super) fn iter(&self) -> impl Iterator<Item = &Motor> {
        self.list.iter().map(|followed| &followed.motor)
    }

    fn find(&mut self, motor: MotorAddress) -> Option<&mut Followed> {
        self.list.iter_mut().find(|followed| followed.motor.motor_address.number() == motor.number())
    }

    pub(super) fn get(&self, motor: MotorAddress) -> Option<&Motor> {
        self.iter().find(|known| known.motor_address.number() == motor.number())
    }

    /// Motors of the device.
    pub(super) fn all(&self) -> MotorSet {
        MotorSet::of(self.iter().map(|motor| motor.motor_address))
    }

    /// Motors that rest, as far as is known.
    pub(super) fn resting(&self) -> MotorSet {
        self.all().without(self.moving())
    }

    /// Motors that do not rest, as far as is known.
    pub(super) fn moving(&self) -> MotorSet {
        let moving = self.list.iter().filter(|followed| followed.hand.motion != Motion::Resting);
        MotorSet::of(moving.map(|followed| followed.motor.motor_address))
    }

    /// Begins a series of reports.
    pub(super) fn begin_series(&mut self) {
        self.reported = MotorSet::NONE;
    }

    /// Takes a report of the series; `false` if there is no room, or no motor can have the address.
    pub(super) fn learn(&mut self, motor: Motor) -> bool {
        if MotorSet::of([motor.motor_address]).is_empty() {
            return false;
        }
        self.reported.insert(motor.motor_address);
        if let Some(followed) = self.find(motor.motor_address) {
            (followed.motor, followed.hand.is_gone) = (motor, false);
            return true;
        }
        self.list.try_push(Followed { motor, hand: Hand::default() }).is_ok()
    }

    /// Ends the series, and returns the motors that it did not report: they are not there.
    pub(super) fn end_series(&mut self) -> MotorSet {
        let gone = self.all().without(self.reported);
        self.reported = MotorSet::NONE;
        gone
    }

    /// Notes that a motor is not there any more. A motion that waits for it is forgotten. But a motor that is not known to
    /// rest is still followed: it is stopped if it jogs and the application falls silent.
    pub(super) fn forget(&mut self, output: &mut Output<'_>, stops: &mut Stops, motor: MotorAddress) {
        if let Some(followed) = self.find(motor) {
            followed.hand.is_gone = true;
            (followed.hand.wanted, followed.hand.next) = (None, None);
            followed.hand.end(output, Outcome::Failed(Failure::MotorOffline));
        }
        self.drop_gone(stops.astray());
        if self.get(motor).is_none() {
            stops.gone(motor);
        }
    }

    /// Drops the motors that went off line and are known to rest. Those `astray` are not known to rest.
    pub(super) fn drop_gone(&mut self, astray: MotorSet) {
        let rests = |followed: &Followed| {
            followed.hand.motion == Motion::Resting && !astray.contains(followed.motor.motor_address)
        };
        self.list.retain(|followed| !(followed.hand.is_gone && rests(followed)));
    }

    /// Notes that a motor is there. Returns whether its report is needed.
    pub(super) fn comes_back(&mut self, motor: MotorAddress) -> bool {
        self.find(motor).is_none_or(|followed| mem::take(&mut followed.hand.is_gone))
    }

    /// Notes where a motor is.
    pub(super) fn is_at(&mut self, place: MotorPlace) {
        if let Some(followed) = self.find(place.motor_address()) {
            followed.motor.position = place.position();
        }
    }

    /// Takes a report that a motor rests.
    ///
    /// It says nothing while the motor jogs, because then it is about the time before the jog, nor while another motion
    /// of the motor waits to be sent.
    pub(super) fn rests(&mut self, output: &mut Output<'_>, stops: &mut Stops, motor: MotorAddress, at: Rotations) {
        if let Some(followed) = self.find(motor) {
            followed.motor.position = at;
            followed.hand.rests(output, stops, MotorAddress(motor.number()));
        }
        stops.rests(motor);
    }

    /// Ends the stops of motors that rest, because all that was sent before has been answered. If what was reported is not
    /// clear, the next report counts, or the answer to the stop when it is sent again.
    pub(super) fn settle(&mut self, output: &mut Output<'_>, stops: &mut Stops) {
        for followed in &mut self.list {
            let Motion::Stopping(_, report) = &mut followed.hand.motion else { continue };
            followed.hand.unreported = followed.hand.unreported.min(1);
            match report {
                Report::None => {}
                Report::Unclear => *report = Report::None,
                Report::Rests => {
                    followed.hand.reset();
                    let motor = MotorAddress(followed.motor.motor_address.number());
                    stops.at_rest(MotorSet::of([motor]));
                    output.event(Event::Stopped(StopTarget::Motor(motor)));
                }
            }
        }
        self.watch();
    }

    /// Sends the stops again that are not confirmed. Returns whether any is sent.
    pub(super) fn stop_again(&mut self, now: Millis, output: &mut Output<'_>, options: &Options) -> bool {
        let mut is_sent = false;
        for followed in &mut self.list {
            if let Motion::Stopping(..) = followed.hand.motion {
                followed.stop(now, output, options);
                is_sent = true;
            }
        }
        is_sent
    }

    /// Tells that stops are not confirmed.
    pub(super) fn tell_unconfirmed(&self, output: &mut Output<'_>) {
        for followed in &self.list {
            if let Motion::Stopping(..) = followed.hand.motion {
                let motor = MotorAddress(followed.motor.motor_address.number());
                output.event(Event::StopNotConfirmed(StopTarget::Motor(motor)));
            }
        }
    }

    /// Takes the report that the device does not know an action about a motor, so that it has done nothing.
    pub(super) fn unsupported(
        &mut self,
        output: &mut Output<'_>,
        stops: &mut Stops,
        action: ActionId,
        motor: MotorAddress,
    ) {
        let Some(Followed { hand, .. }) = self.find(motor) else { return };
        let is_own = match action {
            ActionId::BUMP_POSITION_SPEED_ACCELERATION => hand.is_bump,
            ActionId::SET_POSITION_SPEED_ACCELERATION => !hand.is_bump,
            _ => false,
        };
        match hand.motion {
            _ if !is_own => {}
            Motion::Resting => {}
            Motion::Stopping(..) => output.event(Event::StopNotConfirmed(StopTarget::Motor(motor))),
            // The motion that waits was not sent yet, so it goes on.
            Motion::Going(_) | Motion::Jogging if hand.wanted.is_some() => {
                (hand.is_bump, hand.unreported) = (false, hand.unreported.saturating_sub(1));
            }
            Motion::Going(_) | Motion::Jogging => {
                let id = MessageId::ACTION;
                hand.end(output, Outcome::Refused(Refusal::Unsupported { id, action: Some(action) }));
                if hand.unreported > 1 {
                    stops.lose(MotorSet::of([motor]));
                }
                hand.reset();
            }
        }
        self.watch();
    }

    /// Notes that a stop of everything is confirmed, so that no report is under way.
    pub(super) fn all_rest(&mut self) {
        for followed in &mut self.list {
            followed.hand.unreported = 0;
        }
    }

    pub(super) fn calibrated(&mut self, message: &MotorCalibrated<'_>) {
        if let Some(Followed { motor, .. }) = self.find(message.motor_address) {
            motor.end_position = message.end_position;
            motor.begin_position = message.begin_position.or(motor.begin_position);
        }
    }

    /// Takes an error about a motor: it does not do what it was told, and may have lost its range.
    pub(super) fn error(&mut self, output: &mut Output<'_>, code: ErrorCode, motor: MotorAddress) {
        if let Some(followed) = self.find(motor) {
            if code.resets_axis() {
                followed.motor.forget_range();
            }
            if code == ErrorCode::BAD_MOTOR_ADDRESS {
                followed.hand.end(output, Outcome::Refused(Refusal::Device(code)));
            } else if code.names_motor() {
                followed.hand.end(output, Outcome::Failed(Failure::Device(code)));
            }
        }
    }

    /// Takes the report that the device cannot do what it was told: it names no motor, so it is clear only if one motion
    /// waits for an answer. A jog is such a motion. If several wait, the next reports confirm nothing.
    pub(super) fn refused(&mut self, output: &mut Output<'_>, code: ErrorCode) {
        let waits = |followed: &Followed| followed.hand.token.is_some() || followed.hand.motion == Motion::Jogging;
        let mut waiting = self.list.iter().filter(|followed| waits(followed));
        let is_clear = waiting.next().is_some() && waiting.next().is_none();
        for followed in self.list.iter_mut().filter(|followed| waits(followed)) {
            if is_clear {
                followed.hand.end(output, Outcome::Refused(Refusal::Device(code)));
            } else {
                followed.hand.unreported = followed.hand.unreported.max(2);
            }
        }
    }

    /// Whether a motor does not rest, as far as is known.
    pub(super) fn moves(&self, motor: MotorAddress) -> bool {
        self.moving().contains(motor)
    }

    pub(super) fn any_moves(&self) -> bool {
        !self.moving().is_empty()
    }

    /// Sends a motor to a position, now or as soon as the device bears it.
    pub(super) fn move_to(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        options: &Options,
        stops: &mut Stops,
        (go, token): (Go, Token),
    ) -> Result<(), Refusal> {
        let Followed { motor, hand, .. } = self.find(go.motor).ok_or(Refusal::NoMotor)?;
        if motor.range().is_some_and(|range| !range.spans(go.position)) {
            return Err(Refusal::Outside);
        }
        hand.allows(|motion| matches!(motion, Motion::Resting | Motion::Going(_)))?;
        hand.end(output, Outcome::Failed(Failure::Superseded));
        hand.send_on(stops, go.motor);
        (hand.motion, hand.token) = (Motion::Going(Some(now.after(options.setup_timeout()))), Some(token));
        hand.command(now, output, options, go);
        Ok(())
    }

    /// Sends a motor a distance, once, within its range: where that leads from a place where it does not rest, nobody knows.
    pub(super) fn bump(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        options: &Options,
        stops: &mut Stops,
        (go, token): (Go, Token),
    ) -> Result<(), Refusal> {
        let Followed { motor, hand, .. } = self.find(go.motor).ok_or(Refusal::NoMotor)?;
        hand.allows(|motion| motion == Motion::Resting)?;
        let target = motor.relative_position().map(|at| Rotations(at.0 + go.position.0));
        if target.zip(motor.range()).is_some_and(|(target, range)| !range.spans(target)) {
            return Err(Refusal::Outside);
        }
        (hand.motion, hand.token) = (Motion::Going(Some(now.after(options.setup_timeout()))), Some(token));
        hand.send_on(stops, go.motor);
        hand.is_bump = true;
        hand.transmit(output, Transmit::Bump(go));
        Ok(())
    }

    /// Runs a motor until it is stopped, or to the end of its range; not if it is already beyond that end.
    pub(super) fn jog(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        options: &Options,
        stops: &mut Stops,
        (motor, speed, acceleration): (MotorAddress, RotationsPerSecond, RotationsPerSecondSquared),
    ) -> Result<(), Refusal> {
        let Followed { motor, hand, .. } = self.find(motor).ok_or(Refusal::NoMotor)?;
        let jog = checked(go_of(&motor.jog(speed, acceleration)))?;
        hand.allows(|motion| matches!(motion, Motion::Resting | Motion::Jogging))?;
        // A motor that is beyond the end of its range would go back to it, which is the other way.
        let way = motor.relative_position().map_or(0.0, |at| jog.position.0 - at.0);
        if way * speed.0 < 0.0 {
            return Err(Refusal::Outside);
        }
        hand.send_on(stops, jog.motor);
        hand.motion = Motion::Jogging;
        hand.command(now, output, options, jog);
        self.alive(now, options);
        Ok(())
    }

    /// Notes that the application is there.
    pub(super) fn alive(&mut self, now: Millis, options: &Options) {
        let jogs = self.list.iter().any(|followed| followed.hand.motion == Motion::Jogging);
        self.alive_until = jogs.then(|| now.after(options.dead_man()));
    }

    /// Ends the watch for the application if nothing jogs.
    fn watch(&mut self) {
        if !self.list.iter().any(|followed| followed.hand.motion == Motion::Jogging) {
            self.alive_until = None;
        }
    }

    /// Stops a motor, at once; a motion that waits is forgotten. `false` if nothing can follow the motor.
    pub(super) fn stop(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        options: &Options,
        motor: MotorAddress,
    ) -> bool {
        let followed = self.find(motor);
        let is_followed = followed.is_some();
        match followed {
            Some(followed) => {
                followed.stop(now, output, options);
                followed.hand.end(output, Outcome::Failed(Failure::Stopped));
            }
            None => transmit_stop(output, Transmit::MoveTo(stop_of(motor, None))),
        }
        self.watch();
        is_followed
    }

    /// Stops all motors, at once. Motors that rested before need not confirm it.
    pub(super) fn stop_all(&mut self, now: Millis, output: &mut Output<'_>, options: &Options) {
        for followed in &mut self.list {
            if followed.hand.motion == Motion::Resting {
                transmit_stop(output, followed.stop_message());
            } else {
                followed.stop(now, output, options);
            }
        }
        for followed in &mut self.list {
            followed.hand.end(output, Outcome::Failed(Failure::Stopped));
        }
        self.alive_until = None;
    }

    /// Notes that the connection went down: nobody knows what moves.
    pub(super) fn lost(&mut self, output: &mut Output<'_>, stops: &mut Stops) {
        for followed in &mut self.list {
            // Nobody can stop a jog without a connection, so the next one begins with its stop.
            if let Motion::Stopping(..) | Motion::Jogging = followed.hand.motion {
                stops.defer(MotorSet::of([followed.motor.motor_address]));
            }
            followed.lose(output, stops, Failure::LinkDown);
        }
        (self.reported, self.alive_until) = (MotorSet::NONE, None);
    }

    /// Deals with the deadlines that have come. Returns whether a stop is sent.
    pub(super) fn wake(&mut self, now: Millis, output: &mut Output<'_>, options: &Options) -> bool {
        let mut is_sent = false;
        if self.alive_until.is_some_and(|until| until <= now) {
            for followed in self.list.iter_mut().filter(|followed| followed.hand.motion == Motion::Jogging) {
                followed.stop(now, output, options);
                is_sent = true;
            }
            output.event(Event::DeadMan);
            self.alive_until = None;
        }
        for followed in &mut self.list {
            let motor = MotorAddress(followed.motor.motor_address.number());
            match followed.hand.motion {
                Motion::Stopping(again, _) if again <= now => {
                    followed.stop(now, output, options);
                    is_sent = true;
                    output.event(Event::StopNotConfirmed(StopTarget::Motor(motor)));
                }
                Motion::Going(Some(late)) if late <= now => {
                    followed.hand.motion = Motion::Going(None);
                    output.event(Event::MotorSlow(motor));
                }
                _ => {}
            }
            if followed.hand.next.is_some_and(|next| next <= now) {
                followed.hand.next = None;
                if let Some(wanted) = followed.hand.wanted.take() {
                    followed.hand.command(now, output, options, wanted);
                }
            }
        }
        is_sent
    }

    pub(super) fn deadline(&self) -> Option<Millis> {
        let hands = self.list.iter().filter_map(|followed| followed.hand.deadline());
        hands.chain(self.alive_until).min()
    }
}
