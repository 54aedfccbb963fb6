//! The machine itself: what arrives, what the rig reports, what time it is.

use core::fmt;

use motion_core::fixed::Scaled;
use motion_core::machine::Machine;
use motion_core::time::Millis;

use super::io::{Event, Input, Output, Send, What};
use super::motion::Motion;
use super::options::{Options, Quirks};
use super::upload::Upload;
use super::{State, Store};
use crate::frame::{MessageId, MessageType};
use crate::lint::Context;
use crate::message::{AckCode, FrameNumber, HostMessage, Motor, MotorFlags, Motors, MoveTime, Triggers};

/// A device: what it answers, and what its motors shall do.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct DeviceMachine {
    pub(super) options: Options,
    pub(super) motion: Motion,
    pub(super) on_frame: Option<FrameNumber>,
    pub(super) upload: Upload,
    /// The motors that move.
    pub(super) moving: Motors,
    /// The motors that may be moved by hand during a move.
    pub(super) live: Motors,
    inputs: Triggers,
    /// Whether there are virtual motors.
    pub(super) has_virtuals: bool,
    /// When to tell positions next.
    report: Option<Millis>,
}

/// A request while it is answered.
#[derive(Clone, Copy)]
pub(super) struct Request<'a> {
    pub(super) id: MessageId,
    pub(super) message: HostMessage<'a>,
    /// What the rig has to say to it.
    pub(super) rig: AckCode,
}

/// How a request ends: done, or refused.
pub(super) type Answer = Result<(), AckCode>;

impl DeviceMachine {
    /// A device at rest, that knows of no move.
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
            has_virtuals: false,
            report: None,
        }
    }

    /// What it is doing.
    #[must_use]
    pub const fn state(&self) -> State {
        self.motion.state()
    }

    /// What it was made with.
    #[must_use]
    pub const fn options(&self) -> &Options {
        &self.options
    }

    /// The frame of the uploaded move that all its motors stand on.
    #[must_use]
    pub const fn on_frame(&self) -> Option<FrameNumber> {
        self.on_frame
    }

    /// Whether there is a move that can be run.
    #[must_use]
    pub fn is_loaded(&self) -> bool {
        self.upload.loaded().is_some()
    }

    /// The motors that move, as far as the rig has told.
    #[must_use]
    pub const fn moving(&self) -> Motors {
        self.moving
    }

    /// Whether virtual motors are configured.
    #[must_use]
    pub const fn has_virtuals(&self) -> bool {
        self.has_virtuals
    }

    pub(super) fn has(&self, quirk: Quirks) -> bool {
        self.options.quirks.contains(quirk)
    }

    /// All motors of the rig.
    pub(super) fn all_motors(&self) -> Motors {
        (1..=self.options.hi.motor_count).map(Motor).collect()
    }

    pub(super) fn ack(&self, id: MessageId, of: MessageType, code: AckCode, output: &mut Output) {
        output.send(Send { id, what: What::Ack { of, code, wide: self.has(Quirks::WIDE_ACK) } });
    }

    /// Tells what nobody asked for.
    pub(super) fn tell(what: What, output: &mut Output) {
        output.send(Send { id: MessageId::UNSOLICITED, what });
    }

    /// Where the motors are, as a message.
    pub(super) fn positions(&self) -> What {
        let frame = match self.motion {
            Motion::JogAll(at, _) => Some(at),
            motion => motion.job().map(|job| job.at).or(self.on_frame),
        };
        let time = frame.map_or(0, |frame| frame.0.saturating_mul(1000));
        What::Positions(MoveTime(Scaled(time)), self.options.hi.motor_count.min(32))
    }

    /// Tells positions, and puts off the next report.
    pub(super) fn report(&mut self, now: Millis, output: &mut Output) {
        Self::tell(self.positions(), output);
        self.report = Some(self.next_report(now));
    }

    fn next_report(&self, now: Millis) -> Millis {
        now.after(self.options.report_every.into())
    }

    fn received(&mut self, now: Millis, request: Request<'_>, output: &mut Output) {
        let Request { id, message, .. } = request;
        if message.kind().is_ack() {
            return output.event(Event::Acknowledgement(id, message.kind()));
        }
        let answer = match message {
            HostMessage::MotorStop(_) | HostMessage::MotorStopAll(_) | HostMessage::VirtStop(_) => {
                self.stop(now, &message, output).map(|()| Some(AckCode::OK))
            }
            _ => self.refusal(&message).and_then(|()| self.serve(now, request, output)),
        };
        if let Some(code) = answer.unwrap_or_else(Some) {
            self.ack(id, message.kind(), code, output);
        }
    }

    /// What speaks against a request before anything else: the request itself, and a lock.
    fn refusal(&self, message: &HostMessage<'_>) -> Answer {
        // How long a frame may be is for the stream to say (decision D-10).
        let mut context = Context::of(self.options.hi);
        context.max_data = usize::MAX;
        if let Some(code) = message.refusal(&context) {
            return Err(code);
        }
        match self.motion {
            Motion::Locked(lock)
                if message.kind().0 >= 0x0031 && !matches!(message, HostMessage::MotorGetPosition(_)) =>
            {
                Err(if self.has(Quirks::ONE_LOCK_CODE) { AckCode::ERR_HARD_LOW } else { lock.code })
            }
            _ => Ok(()),
        }
    }

    /// Does what is asked. The answer is an acknowledgement, or `None` if it was given already or comes later.
    fn serve(&mut self, now: Millis, request: Request<'_>, output: &mut Output) -> Result<Option<AckCode>, AckCode> {
        let Request { id, message, rig } = request;
        let what = match message {
            HostMessage::Hi(_) => self.greeting(),
            HostMessage::GioIn(_) => What::Inputs(self.inputs),
            HostMessage::MotorStatus(_) => What::Status(self.moving),
            HostMessage::MotorGetPosition(_) if self.has(Quirks::POSITIONS_APART) => {
                Self::tell(self.positions(), output);
                return Ok(Some(AckCode::OK));
            }
            HostMessage::MotorGetPosition(_) => self.positions(),
            HostMessage::VirtGetPosition(_) => What::VirtualPositions,
            HostMessage::MotorMove(_) => {
                self.move_motor(&request, output)?;
                if self.has(Quirks::ACK_FOR_MOVE) {
                    return Ok(Some(AckCode::OK));
                }
                What::Moving
            }
            HostMessage::VirtAimPoint(_) => {
                self.aim(rig, output)?;
                What::Aim
            }
            HostMessage::MotorResetPosition(_) => {
                self.reset(now, &request, output)?;
                return Ok(None);
            }
            HostMessage::RtUploadMoveBegin(_)
            | HostMessage::RtUploadMoveAxis(_)
            | HostMessage::RtUploadMoveDmx(_)
            | HostMessage::RtUploadMoveTriggers(_)
            | HostMessage::RtUploadMoveEnd(_) => {
                self.store(&request, output)?;
                return Ok(None);
            }
            _ => {
                self.act(&request, output)?;
                return Ok(Some(AckCode::OK));
            }
        };
        output.send(Send { id, what });
        Ok(None)
    }

    /// Does what is answered by nothing but an acknowledgement.
    fn act(&mut self, request: &Request<'_>, output: &mut Output) -> Answer {
        match request.message {
            HostMessage::MotorJog(_) => self.move_motor(request, output),
            HostMessage::RtPositionFrame(message) => self.go_to_frame(message.frame, request.rig, output),
            HostMessage::RtJogAll(message) => self.jog_all(&message, request.rig, output),
            HostMessage::RtRunMove(message) => self.run(&message, request.rig, output),
            HostMessage::RtShootFrame(message) => self.shoot(message.frame, message.motors, request.rig, output),
            HostMessage::RtShootFrame2(message) => self.shoot(message.frame, message.motors, request.rig, output),
            HostMessage::RtGo(_) => self.go(output),
            HostMessage::RtStopLoop(_) => {
                self.stop_loop(output);
                Ok(())
            }
            HostMessage::VirtConfig(config) => self.configure_virtuals(&config, request.rig, output),
            HostMessage::VirtMove(_) | HostMessage::VirtJog(_) | HostMessage::VirtJogOnLine(_) => {
                self.move_virtuals(request.rig, output)
            }
            HostMessage::MotorConfigure(message) => {
                allowed(request.rig)?;
                let motor = Motors::from_iter([message.motor]).0;
                let live = message.flags.contains(MotorFlags::LIVE);
                self.live.0 = if live { self.live.0 | motor } else { self.live.0 & !motor };
                output.event(Event::Apply);
                Ok(())
            }
            HostMessage::Dmx(_)
            | HostMessage::GioOut(_)
            | HostMessage::GioCam(_)
            | HostMessage::MotorSetSpeed(_)
            | HostMessage::MotorSetLimits(_) => {
                allowed(request.rig)?;
                output.event(Event::Apply);
                Ok(())
            }
            // Every message has been looked at before; what is unknown was refused there.
            _ => Err(AckCode::ERR_UNSUPPORTED),
        }
    }

    fn greeting(&self) -> What {
        let mut hi = self.options.hi;
        if self.has(Quirks::SHORT_GREETING) {
            hi.protocol_version = None;
        }
        What::Greeting(hi)
    }

    fn store(&mut self, request: &Request<'_>, output: &mut Output) -> Answer {
        if matches!(request.message, HostMessage::RtUploadMoveBegin(_)) {
            self.at_rest()?;
            self.on_frame = None;
        }
        let store = self.upload.receive(request.id, &request.message)?;
        output.event(Event::Store(store));
        Ok(())
    }

    fn stored(&mut self, store: Store, code: AckCode, output: &mut Output) {
        if code == AckCode::OK {
            self.upload.stored(store);
        }
        self.ack(store.id, store.kind, code, output);
    }

    /// What may only begin at rest (safety decision 7).
    pub(super) fn at_rest(&self) -> Answer {
        if self.motion == Motion::Idle { Ok(()) } else { Err(AckCode::ERR_MOVING) }
    }

    /// Deals with the deadlines that have come, and says which is next.
    fn watch(&mut self, now: Millis, output: &mut Output) {
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
        // At the end of time nothing is later than now.
        output.wake = [self.report, until].into_iter().flatten().filter(|&wake| wake > now).min();
    }
}

/// Whether the rig has nothing to say against a request.
pub(super) fn allowed(rig: AckCode) -> Answer {
    if rig == AckCode::OK { Ok(()) } else { Err(rig) }
}

impl Machine for DeviceMachine {
    type Input<'a> = Input<'a>;
    type Output = Output;

    fn step(mut self, now: Millis, input: Input<'_>) -> (Self, Output) {
        let mut output = Output::default();
        match input {
            Input::LinkUp => Self::tell(self.greeting(), &mut output),
            Input::LinkDown => self.link_down(now, &mut output),
            Input::Received { id, message, rig } => self.received(now, Request { id, message, rig }, &mut output),
            Input::Malformed(id, kind) | Input::Corrupt(id, kind) if kind.is_ack() => {
                output.event(Event::Acknowledgement(id, kind));
            }
            Input::Malformed(id, kind) => self.ack(id, kind, AckCode::ERR_GENERAL, &mut output),
            Input::Corrupt(id, kind) => self.ack(id, kind, AckCode::ERR_CHECKSUM, &mut output),
            Input::Stored(store, code) => self.stored(store, code, &mut output),
            Input::Moving(motors) if self.motion != Motion::Idle => self.moving = motors,
            Input::AtRest => self.arrived(now, &mut output),
            Input::Frame(frame) => self.passed(now, frame, &mut output),
            Input::PassEnd => self.pass_end(&mut output),
            Input::OperatorGo => match self.go(&mut output) {
                Ok(()) => Self::tell(What::Go, &mut output),
                Err(_) => output.event(Event::Stray),
            },
            Input::Limit { motor, upper } => self.limit(motor, upper, &mut output),
            Input::EmergencyStop(pressed) => self.emergency_stop(pressed, &mut output),
            Input::Fault(motor) => self.fault(motor, &mut output),
            Input::Inputs(triggers) => {
                self.inputs = triggers;
                Self::tell(What::Inputs(triggers), &mut output);
            }
            Input::Aimed => Self::tell(What::Aim, &mut output),
            Input::Wake | Input::Moving(Motors::NONE) => {}
            Input::Moving(_) => output.event(Event::Stray),
        }
        self.watch(now, &mut output);
        (self, output)
    }
}

// What is derived for so many fields cannot be proven free of panics.
impl fmt::Debug for DeviceMachine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DeviceMachine")
            .field("motion", &self.motion)
            .field("on_frame", &self.on_frame)
            .field("upload", &self.upload)
            .field("moving", &self.moving)
            .field("live", &self.live)
            .field("inputs", &self.inputs)
            .field("has_virtuals", &self.has_virtuals)
            .field("report", &self.report)
            .finish_non_exhaustive()
    }
}
