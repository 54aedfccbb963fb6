//! Lines, clock and mishaps of a device.

use std::net::SocketAddrV4;

use kos_proto::device::playback::State;
use kos_proto::device::{Input, Report, SESSIONS, SessionId};
use kos_proto::message::{ErrorCode, Password};
use kos_proto::{Frame, Frames, HostMessage, Item, Transport};
use motion_core::time::Millis;
use tracing::{debug, info, warn};

use super::KosDevice;
use crate::motor::Motor;
use crate::{LineId, Outgoing, Party, Rig, TICK};

impl Party for KosDevice {
    fn open(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        let place = self.lines.get_mut(usize::from(line.0)).filter(|_| self.starts.is_none());
        let Some(place) = place else {
            self.outgoing.push_back(Outgoing::HangUp(line));
            return;
        };
        place.is_open = true;
        place.frames = Some(Box::new(Frames::new()));
        info!("client {} is connected", line.0);
        let password = self.store.password.clone();
        let session = SessionId(line.0);
        self.input(Input::LinkUp { session, transport: Transport::Tcp, password: Password(&password) });
    }

    fn close(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if let Some(place) = self.lines.get_mut(usize::from(line.0)).filter(|place| place.is_open) {
            *place = super::Line::default();
            info!("client {} is gone", line.0);
            self.input(Input::LinkDown(SessionId(line.0)));
        }
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        self.advance(now);
        let index = usize::from(line.0);
        let Some(mut frames) = self.lines.get_mut(index).and_then(|line| line.frames.take()) else { return };
        let session = SessionId(line.0);
        let mut rest = bytes;
        while self.is_open(index) && !rest.is_empty() {
            let taken = frames.push(rest);
            rest = rest.get(taken..).unwrap_or_default();
            while let Some(item) = frames.next() {
                match item {
                    Item::Frame(frame) => self.message(session, &frame),
                    Item::Fatal(why) => {
                        warn!("client {}: the bytes are no stream of messages: {why}", line.0);
                        self.input(Input::Fatal(session));
                    }
                    Item::Noise { bytes, why } => warn!("client {}: {} bytes are left out: {why}", line.0, bytes.len()),
                    Item::Corrupt { why, .. } => warn!("client {}: {why}", line.0),
                }
                if !self.is_open(index) {
                    return;
                }
            }
            if taken == 0 {
                break;
            }
        }
        if let Some(line) = self.lines.get_mut(index).filter(|line| line.is_open) {
            line.frames = Some(frames);
        }
    }

    fn advance(&mut self, now: Millis) {
        while let Some(due) = self.wake().filter(|due| *due <= now) {
            self.tick(due);
        }
        self.now = self.now.max(now);
    }

    fn wake(&self) -> Option<Millis> {
        let moves = self.motors.iter().any(|motor| !motor.is_idle())
            || self.playing.as_ref().is_some_and(super::playing::Playing::runs);
        let tick = moves.then(|| self.now.after(TICK));
        [tick, self.wake, self.starts].into_iter().flatten().min().map(|wake| wake.max(self.now))
    }

    fn poll(&mut self) -> Option<Outgoing> {
        self.outgoing.pop_front()
    }
}

#[expect(clippy::cast_possible_truncation, reason = "four")]
impl Rig for KosDevice {
    const LINES: u8 = SESSIONS as u8;

    fn datagram(&mut self, now: Millis, from: SocketAddrV4, bytes: &[u8]) {
        self.advance(now);
        let Ok(frame) = Frame::decode(bytes) else { return debug!("a datagram that is no message") };
        match HostMessage::decode(&frame) {
            Ok(message) => self.input(Input::Datagram { from: from.into(), message }),
            Err(error) => debug!("a datagram that is cut off: {error}"),
        }
    }

    fn motors(&self) -> &[Motor] {
        &self.motors
    }

    /// Also `None` while the motors go to where the move begins, or to the place of the next photo.
    fn moment(&self) -> Option<f64> {
        use State::{Exposing, Forward, ForwardC, FrameDelay, Post, Pre, Reverse};
        let played = [Pre, Forward, Reverse, ForwardC, FrameDelay, Exposing, Post].contains(&self.machine.playback());
        self.playing.as_ref().filter(|_| played).map(|playing| playing.moment(self.now))
    }

    fn reset(&mut self, now: Millis) {
        self.advance(now);
        warn!("the power fails");
        self.outgoing.clear();
        self.playing = None;
        self.camera.close(now);
        for motor in &mut self.motors {
            motor.halt(now);
        }
        self.start_anew();
    }

    fn stall(&mut self, now: Millis) {
        self.advance(now);
        let stuck = self.addresses().zip(&mut self.motors).find(|(_, motor)| motor.at(now).velocity != 0.0);
        if let Some((address, motor)) = stuck {
            motor.halt(now);
            warn!("motor {address} is stuck");
            self.report(now, Report::Fault(address, ErrorCode::RUNAWAY));
        }
    }
}

impl KosDevice {
    fn is_open(&self, index: usize) -> bool {
        self.lines.get(index).is_some_and(|line| line.is_open)
    }

    /// Gives an input to the machine, after the positions of the motors.
    fn input(&mut self, input: Input<'_>) {
        self.sync();
        self.step(self.now, input);
    }

    fn message(&mut self, session: SessionId, frame: &Frame<'_>) {
        let password = self.store.password.clone();
        let input = Input::received(session, frame, Password(&password));
        if let Input::Received { message, .. } = input {
            debug!("client {}: {message}", session.0);
        }
        self.input(input);
    }
}
