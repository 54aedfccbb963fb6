//! The machine itself: what arrives, what the rig reports, and the deadlines.

use motion_core::fixed::Scaled;
use motion_core::time::Millis;
use motion_core::{debug, machine};

use super::event::{Event, Store};
use super::input::{Input, Report};
use super::motion::{Motion, State};
use super::options::{Options, Quirks};
use super::transmit::{Contents, Output, Transmit};
use super::upload::Upload;
use crate::frame::{MessageId, MessageType};
use crate::lint::Context;
use crate::message::{AckCode, FrameNumber, HostMessage, Motor, MotorFlags, Motors, MoveTime, Triggers};

/// State machine of a device: it knows what to answer, and what the motors have to do.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct DeviceMachine {
    pub(super) options: Options,
    pub(super) motion: Motion,
    pub(super) on_frame: Option<FrameNumber>,
    pub(super) upload: Upload,
    /// Motors that move.
    pub(super) moving: Motors,
    /// Motors that may be driven by hand during a move.
    pub(super) live: Motors,
    inputs: Triggers,
    /// Whether the shutter of the camera may be open.
    pub(super) is_shutter_open: bool,
    /// Whether there are virtual motors.
    pub(super) has_virtuals: bool,
    /// Time of the next report of positions.
    report: Option<Millis>,
}

machine! { DeviceMachine }
debug! { DeviceMachine { options motion on_frame upload moving live inputs is_shutter_open has_virtuals report } }

/// Request while it is answered.
#[derive(Clone, Copy)]
pub(super) struct Request<'a> {
    pub(super) id: MessageId,
    pub(super) kind: MessageType,
    pub(super) message: HostMessage<'a>,
    /// Answer of the rig.
    pub(super) rig: AckCode,
}

/// End of a request: done, or refused with a code.
pub(super) type Answer = Result<(), AckCode>;

impl DeviceMachine {
    /// Makes a device at rest, without a move.
    #[must_use]
    pub const fn new(options: Options) -> Self {
        Self {
            options,
            motion: Motion::Idle,
            on_frame: None,
            upload: Upload::None,
            moving: Motors::NONE,
            live: Motors::NONE,
            inputs: Triggers::NONE,
            is_shutter_open: false,
            has_virtuals: false,
            report: None,
        }
    }

    /// State of the device.
    #[must_use]
    pub const fn state(&self) -> State {
        self.motion.state()
    }

    /// Options of the machine.
    #[must_use]
    pub const fn options(&self) -> &Options {
        &self.options
    }

    /// Frame of the uploaded move that all motors stand on.
    #[must_use]
    pub const fn on_frame(&self) -> Option<FrameNumber> {
        self.on_frame
    }

    /// Whether there is a move that can be run.
    #[must_use]
    pub fn is_loaded(&self) -> bool {
        self.upload.loaded().is_some()
    }

    /// Motors that move, as far as the rig has told.
    #[must_use]
    pub const fn moving(&self) -> Motors {
        self.moving
    }

    /// Whether anything may move because of what this device was told. A run or a shot that waits for its signal counts, and
    /// so does a shutter that may be open.
    ///
    /// It is false as soon as all motors rest after a stop, as [`Report::AtRest`] tells, also while the device is locked. Until a lock
    /// ends, only a shutter can be opened.
    #[must_use]
    pub const fn may_move(&self) -> bool {
        self.motion.may_move() || self.moving.0 != Motors::NONE.0 || self.is_shutter_open
    }

    /// Whether the machine waits for the report that all motors rest, which is [`Report::AtRest`]. In a run and in a shot it waits
    /// for [`Report::PassEnd`] before.
    #[must_use]
    pub const fn awaits_rest(&self) -> bool {
        self.motion.is_in_motion() && !matches!(self.motion, Motion::Running(_))
    }

    /// Whether virtual motors are configured.
    #[must_use]
    pub const fn has_virtuals(&self) -> bool {
        self.has_virtuals
    }

    pub(super) fn has(&self, quirk: Quirks) -> bool {
        self.options.quirks().contains(quirk)
    }

    /// Every motor of the rig.
    pub(super) fn all_motors(&self) -> Motors {
        (1..=self.options.hi().motor_count).map(Motor).collect()
    }

    pub(super) fn ack(&self, output: &mut Output<'_>, id: MessageId, of: MessageType, code: AckCode) {
        output.transmit(Transmit { id, contents: Contents::Ack { of, code, wide: self.has(Quirks::WIDE_ACK) } });
    }

    /// Sends a message that nobody asked for.
    pub(super) fn tell(output: &mut Output<'_>, contents: Contents) {
        output.transmit(Transmit { id: MessageId::UNSOLICITED, contents });
    }

    /// Positions of the motors, as a message.
    pub(super) fn positions(&self) -> Contents {
        let frame = match self.motion {
            Motion::JogAll(at, _) => Some(at),
            motion => motion.job().map(|job| job.at).or(self.on_frame),
        };
        let time = frame.map_or(0, |frame| frame.0.saturating_mul(1000));
        Contents::Positions(MoveTime(Scaled(time)), self.options.hi().motor_count.min(32))
    }

    /// Reports positions, and puts off the next report.
    pub(super) fn report(&mut self, now: Millis, output: &mut Output<'_>) {
        Self::tell(output, self.positions());
        self.report = Some(self.next_report(now));
    }

    fn next_report(&self, now: Millis) -> Millis {
        now.after(self.options.report_every().into())
    }

    fn received<'a>(&mut self, now: Millis, output: &mut Output<'a>, request: &Request<'a>) {
        let Request { id, kind, message, .. } = *request;
        if kind.is_ack() {
            return output.event(Event::Acknowledgement(id, kind));
        }
        let answer = if message.conduct().is_stop() {
            self.stop(now, output, &message).map(|()| Some(AckCode::OK))
        } else {
            self.refusal(request).and_then(|()| self.serve(now, output, request))
        };
        if let Some(code) = answer.unwrap_or_else(Some) {
            self.ack(output, id, kind, code);
            let tells = matches!(
                message,
                HostMessage::MotorStop(_) | HostMessage::MotorStopAll(_) | HostMessage::RtPositionFrame(_)
            );
            if tells && code == AckCode::OK && self.has(Quirks::POSITIONS_AFTER_ACK) {
                output.transmit(Transmit { id, contents: self.positions() });
            }
        }
    }

    /// Refuses a request that this device cannot take at all, or not while it is locked.
    fn refusal(&self, Request { kind, message, .. }: &Request<'_>) -> Answer {
        let locked = self.lock_code(*kind);
        if locked.is_some() && self.has(Quirks::ONE_LOCK_CODE) {
            return locked.map_or(Ok(()), Err);
        }
        // The stream decides how long a frame may be (decision D-10).
        let code = message.refusal_of_values(&Context::of(self.options.hi())).filter(|&code| {
            !self.has(Quirks::FEW_CHECKS) || code == AckCode::ERR_UNSUPPORTED || self.names_absent_motor(message)
        });
        code.or(locked).map_or(Ok(()), Err)
    }

    /// Code with which a device that is locked answers a request of this type; `None` if it answers the request.
    fn lock_code(&self, kind: MessageType) -> Option<AckCode> {
        match self.motion {
            Motion::Locked(lock) if kind.0 >= 0x0031 && kind.0 != 0x0034 => {
                Some(if self.has(Quirks::ONE_LOCK_CODE) { AckCode::ERR_HARD_LOW } else { lock.code })
            }
            _ => None,
        }
    }

    /// Whether a request is for a motor that is not there.
    fn names_absent_motor(&self, message: &HostMessage<'_>) -> bool {
        let motor = match message {
            HostMessage::MotorMove(it) => it.motor,
            HostMessage::MotorResetPosition(it) => it.motor,
            HostMessage::MotorJog(it) => it.motor,
            HostMessage::MotorConfigure(it) => it.motor,
            HostMessage::MotorSetSpeed(it) => it.motor,
            HostMessage::MotorSetLimits(it) => it.motor,
            HostMessage::RtUploadMoveAxis(it) => it.motor,
            _ => return false,
        };
        !self.all_motors().contains(motor)
    }

    /// Does what a request asks. Returns the code of its acknowledgement, or `None` if the answer was given already or comes
    /// later.
    // In firmware the parts of the machine are functions of their own, because their code is shorter so.
    #[cfg_attr(target_os = "none", inline(never))]
    fn serve<'a>(
        &mut self,
        now: Millis,
        output: &mut Output<'a>,
        request: &Request<'a>,
    ) -> Result<Option<AckCode>, AckCode> {
        let contents = match request.message {
            HostMessage::Hi(_) => self.greeting(),
            HostMessage::GioIn(_) => Contents::Inputs(self.inputs),
            HostMessage::MotorStatus(_) => Contents::Status(self.moving),
            HostMessage::MotorGetPosition(_) if self.has(Quirks::POSITIONS_APART) => {
                Self::tell(output, self.positions());
                return Ok(Some(AckCode::OK));
            }
            HostMessage::MotorGetPosition(_) => self.positions(),
            HostMessage::VirtGetPosition(_) => Contents::VirtualPositions,
            HostMessage::MotorMove(_) => {
                self.move_motor(output, request)?;
                if self.has(Quirks::ACK_FOR_MOVE) {
                    return Ok(Some(AckCode::OK));
                }
                Contents::Moving
            }
            HostMessage::VirtAimPoint(_) => {
                self.move_virtuals(output, request)?;
                Contents::Aim
            }
            HostMessage::MotorResetPosition(_) => {
                self.reset(now, output, request)?;
                return Ok(None);
            }
            HostMessage::RtUploadMoveBegin(_)
            | HostMessage::RtUploadMoveAxis(_)
            | HostMessage::RtUploadMoveDmx(_)
            | HostMessage::RtUploadMoveTriggers(_)
            | HostMessage::RtUploadMoveEnd(_) => {
                self.store(output, request)?;
                return Ok(None);
            }
            _ => {
                self.act(output, request)?;
                return Ok(Some(AckCode::OK));
            }
        };
        output.transmit(Transmit { id: request.id, contents });
        Ok(None)
    }

    /// Does what a request asks that is answered by an acknowledgement.
    #[cfg_attr(target_os = "none", inline(never))]
    fn act<'a>(&mut self, output: &mut Output<'a>, request: &Request<'a>) -> Answer {
        let Request { message, rig, .. } = *request;
        match message {
            HostMessage::MotorJog(_) => self.move_motor(output, request),
            HostMessage::RtPositionFrame(body) => self.go_to_frame(output, rig, body.frame),
            HostMessage::RtJogAll(body) => self.jog_all(output, rig, &body),
            HostMessage::RtRunMove(body) => self.run_move(output, rig, body),
            HostMessage::RtShootFrame(body) => self.shoot(output, rig, message, body.frame, body.motors),
            HostMessage::RtShootFrame2(body) => self.shoot(output, rig, message, body.frame, body.motors),
            HostMessage::RtGo(_) => self.go(output),
            HostMessage::RtStopLoop(_) => {
                self.stop_loop(output);
                Ok(())
            }
            HostMessage::VirtConfig(config) => self.configure_virtuals(output, rig, config),
            HostMessage::VirtMove(_) | HostMessage::VirtJog(_) | HostMessage::VirtJogOnLine(_) => {
                self.move_virtuals(output, request)
            }
            HostMessage::MotorConfigure(body) => {
                allowed(rig)?;
                let motor = Motors::from_iter([body.motor]).0;
                let live = body.flags.contains(MotorFlags::LIVE);
                self.live.0 = if live { self.live.0 | motor } else { self.live.0 & !motor };
                output.event(Event::Apply(message));
                Ok(())
            }
            HostMessage::Dmx(_)
            | HostMessage::GioOut(_)
            | HostMessage::GioCam(_)
            | HostMessage::MotorSetSpeed(_)
            | HostMessage::MotorSetLimits(_) => {
                allowed(rig)?;
                if let HostMessage::GioCam(_) = message {
                    self.is_shutter_open = message.opens_shutter();
                }
                output.event(Event::Apply(message));
                Ok(())
            }
            // The other messages were dealt with before; unknown ones were refused.
            _ => Err(AckCode::ERR_UNSUPPORTED),
        }
    }

    fn greeting(&self) -> Contents {
        let mut hi = self.options.hi();
        if self.has(Quirks::SHORT_GREETING) {
            hi.protocol_version = None;
        }
        Contents::Greeting(hi)
    }

    fn store<'a>(&mut self, output: &mut Output<'a>, request: &Request<'a>) -> Answer {
        if matches!(request.message, HostMessage::RtUploadMoveBegin(_)) {
            self.at_rest()?;
            self.on_frame = None;
        }
        let store = self.upload.receive(request.id, request.kind, &request.message)?;
        output.event(Event::Store { store, message: request.message });
        Ok(())
    }

    fn stored(&mut self, output: &mut Output<'_>, store: Store, code: AckCode) {
        if code == AckCode::OK {
            self.upload.stored(store);
        }
        self.ack(output, store.id, store.kind, code);
    }

    /// Refuses what may only begin at rest (safety decision 7).
    pub(super) fn at_rest(&self) -> Answer {
        if self.motion == Motion::Idle { Ok(()) } else { Err(AckCode::ERR_MOVING) }
    }

    /// Deals with the deadlines that have come, and finds the next one.
    #[cfg_attr(target_os = "none", inline(never))]
    fn watch(&mut self, now: Millis, output: &mut Output<'_>) {
        match &mut self.motion {
            Motion::Stopping(until) => *until = until.filter(|&until| until > now),
            Motion::Locked(lock) => lock.until = lock.until.filter(|&until| until > now),
            _ => {}
        }
        self.unlock(output);
        if !self.motion.is_in_motion() {
            self.report = None;
        } else if self.report.is_none() {
            self.report = Some(self.next_report(now));
        } else if self.report.is_some_and(|report| report <= now) {
            self.report(now, output);
        }
        let until = match self.motion {
            Motion::Stopping(until) => until,
            Motion::Locked(lock) => lock.until,
            _ => None,
        };
        output.wake = [self.report, until].into_iter().flatten().min();
    }

    fn run<'a>(&mut self, now: Millis, output: &mut Output<'a>, input: Input<'a>) {
        match input {
            Input::LinkUp => Self::tell(output, self.greeting()),
            Input::LinkDown => self.link_down(now, output),
            Input::Received { id, message, rig } => {
                self.received(now, output, &Request { id, kind: message.kind(), message, rig });
            }
            Input::Malformed(id, kind) | Input::Corrupt(id, kind) if kind.is_ack() => {
                output.event(Event::Acknowledgement(id, kind));
            }
            Input::Malformed(id, kind) => {
                let locked = self.lock_code(kind).filter(|_| self.has(Quirks::ONE_LOCK_CODE));
                self.ack(output, id, kind, locked.unwrap_or(AckCode::ERR_GENERAL));
            }
            Input::Corrupt(id, kind) => self.ack(output, id, kind, AckCode::ERR_CHECKSUM),
            Input::Rig(report) => self.reported(now, output, report),
            Input::Wake => {}
        }
        self.watch(now, output);
    }

    /// Does what follows from a report of the rig.
    // Inlined into `run`, it would take 90 to 290 bytes more in firmware.
    #[inline(never)]
    fn reported(&mut self, now: Millis, output: &mut Output<'_>, report: Report) {
        match report {
            Report::Stored(store, code) => self.stored(output, store, code),
            Report::Moving(motors) if self.motion != Motion::Idle => self.moving = motors,
            Report::AtRest => self.arrived(now, output),
            Report::AtFrame(frame) => self.at_frame(now, output, frame),
            Report::PassEnd => self.pass_end(output),
            Report::OperatorGo => match self.go(output) {
                Ok(()) => Self::tell(output, Contents::Go),
                Err(_) => output.event(Event::UnexpectedReport),
            },
            Report::Limit { motor, upper } => self.limit(output, motor, upper),
            Report::EmergencyStop(pressed) => self.emergency_stop(output, pressed),
            Report::Fault(motor) => self.fault(output, motor),
            Report::Inputs(triggers) => {
                self.inputs = triggers;
                Self::tell(output, Contents::Inputs(triggers));
            }
            Report::Aimed => Self::tell(output, Contents::Aim),
            Report::Moving(Motors::NONE) => {}
            Report::Moving(_) => output.event(Event::UnexpectedReport),
        }
    }
}

/// Refuses what the rig refuses.
pub(super) fn allowed(rig: AckCode) -> Answer {
    if rig == AckCode::OK { Ok(()) } else { Err(rig) }
}
