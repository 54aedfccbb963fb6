//! Loop of a device: what the session says is done, and what the motors do is reported.

use std::mem;

use dmc_proto::device::{Input, Next, NotTaken, Quirks, Report, State};
use dmc_proto::message::{Ack, AckCode, DeviceMessage, Motors};
use dmc_proto::{Frame, Header};
use motion_core::time::Millis;
use tracing::{Level, debug, enabled, info, warn};

use super::reader::Read;
use super::{DmcDevice, LINE, number};
use crate::Outgoing;
use crate::motor::Happening;

/// First type of the requests that a device refuses while it is locked.
const FIRST_LOCKED: u16 = 0x0031;

impl DmcDevice {
    /// Does what the session says, until it waits.
    pub(super) fn work(&mut self) {
        let mut bytes = [0; 256];
        loop {
            note(match self.core.report.take() {
                Some(Input::Rig(Report::Stored(store, code))) => self.session.stored(store, code),
                Some(Input::Rig(Report::AtFrame(frame))) => self.session.at_frame(frame),
                Some(Input::Rig(Report::PassEnd)) => self.session.pass_end(),
                Some(Input::Rig(Report::Fault(motor))) => self.session.fault(motor),
                _ => Ok(()),
            });
            match self.session.poll(self.core.clock, &self.core, &mut bytes) {
                Ok(Next::Transmit(frame)) if self.is_open => self.out.push_back(sent(frame)),
                // There is no line for these bytes.
                Ok(Next::Transmit(_)) => {}
                Ok(Next::Event(event)) => match event.to_static() {
                    Some(event) => {
                        self.core.state = self.machine().state();
                        self.core.obey(event);
                    }
                    None => self.core.obey(event),
                },
                Ok(Next::Wait(_)) if mem::take(&mut self.core.follows) => self.core.follow(),
                Ok(Next::Wait(until)) => {
                    self.until = until;
                    self.core.look(self.session.machine());
                    return self.core.carry();
                }
                Err(error) => warn!(%error, "an answer that cannot be sent"),
            }
            self.core.look(self.session.machine());
        }
    }

    /// Does what is due at a moment.
    pub(super) fn tick(&mut self, now: Millis) {
        self.core.clock = now;
        self.read(now, &[]);
        self.core.camera.advance(now);
        self.core.follow();
        self.work();
        for index in 0..self.core.motors.len() {
            if let Some(Happening::Tripped { upper }) = self.core.motors[index].advance(now) {
                let motor = number(index);
                warn!(%motor, upper, "ran into its limit switch");
                note(self.session.limit(motor, upper));
                self.work();
            }
        }
        let (machine, facts) = (self.session.machine(), &self.core.setup.facts);
        let (state, told, can_rest) = (machine.state(), machine.moving(), facts.tells_each_motor);
        // The machine knows only the motors of the upload, and others may move with them.
        let moving = if state == State::Idle { told } else { self.core.moving() };
        if self.core.comes_to_rest() {
            info!(after = state.name(), "all motors rest");
            note(self.session.at_rest());
        } else if moving != told && (moving != Motors::NONE || (can_rest && state != State::Ready)) {
            note(self.session.moving(moving));
        } else {
            return self.core.carry();
        }
        self.work();
    }

    /// Takes bytes that arrived, and gives up the incomplete frame if it is overdue.
    pub(super) fn read(&mut self, now: Millis, bytes: &[u8]) {
        let Some(reader) = &mut self.reader else { return self.take(now, bytes) };
        for read in reader.read(now, bytes) {
            match read {
                Read::Frame(bytes) => self.take(now, &bytes),
                Read::Refused(header, code) => self.refuse(header, code),
            }
        }
    }

    /// Gives bytes to the session.
    fn take(&mut self, now: Millis, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            let taken = self.session.receive(now, bytes);
            bytes = &bytes[taken..];
            self.work();
        }
    }

    /// Refuses a message that the session does not see.
    fn refuse(&mut self, header: Header, code: AckCode) {
        let kind = header.kind();
        let is_locked =
            self.machine().state() == State::Locked && kind.0 >= FIRST_LOCKED && code == AckCode::ERR_UNSUPPORTED;
        let code = if is_locked { AckCode::ERR_HARD_LOW } else { code };
        let wide = self.core.setup.options.quirks().contains(Quirks::WIDE_ACK);
        let ack = Ack { tail: if wide { &[0; 2] } else { &[] }, ..Ack::new(kind, code) };
        let mut bytes = [0; 16];
        if let Ok(len) = DeviceMessage::from(ack).encode_into(header.id(), &mut bytes) {
            self.out.push_back(sent(&bytes[..len]));
        }
    }
}

/// Notes that a session did not take a report. It takes each one, because it is polled after each one.
pub(super) fn note(told: Result<(), NotTaken>) {
    if let Err(error) = told {
        warn!(%error, "a report is lost");
    }
}

/// Bytes of a message, which is noted in the log.
fn sent(bytes: &[u8]) -> Outgoing {
    if enabled!(Level::INFO)
        && let Ok(Ok(message)) = Frame::decode(bytes).map(|frame| DeviceMessage::decode(&frame))
    {
        if let DeviceMessage::Ack(ack) = message
            && ack.response_code != Some(AckCode::OK)
        {
            info!(request = %ack.of, why = ?ack.response_code, "refuses");
        }
        debug!("sends {message}");
    }
    Outgoing::Bytes(LINE, bytes.to_vec())
}
