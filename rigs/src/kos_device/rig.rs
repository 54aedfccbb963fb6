//! Lines, clock and mishaps of a device.

use std::net::SocketAddrV4;

use kos_proto::Transport;
use kos_proto::device::playback::State;
use kos_proto::device::{Report, SESSIONS, SessionId};
use kos_proto::message::ErrorCode;
use motion_core::time::Millis;
use tracing::{info, warn};

use super::KosDevice;
use crate::kos_host::{Tap, host_text};
use crate::motor::Motor;
use crate::{LineId, Outgoing, Party, Rig, TICK};

impl Party for KosDevice {
    fn open(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        let runs = self.runs();
        let Some(place) = self.lines.get_mut(usize::from(line.0)).filter(|_| runs) else {
            self.outgoing.push_back(Outgoing::HangUp(line));
            return;
        };
        *place = Some(Tap::new());
        info!("client {} is connected", line.0);
        self.sync();
        if let Err(why) = self.session.link_up(SessionId(line.0), Transport::Tcp) {
            warn!("client {}: {why}", line.0);
        }
        self.work(now);
    }

    fn close(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if self.lines.get_mut(usize::from(line.0)).and_then(Option::take).is_some() {
            info!("client {} is gone", line.0);
            self.sync();
            if let Err(why) = self.session.link_down(SessionId(line.0)) {
                warn!("client {}: {why}", line.0);
            }
            self.work(now);
        }
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        self.advance(now);
        self.sync();
        let index = usize::from(line.0);
        if let Some(Some(tap)) = self.lines.get_mut(index) {
            tap.hear(&format!("client {}:", line.0), bytes, host_text);
        }
        let mut rest = bytes;
        while self.lines.get(index).is_some_and(Option::is_some) && !rest.is_empty() {
            let taken = self.session.receive(now, SessionId(line.0), rest);
            rest = rest.get(taken..).unwrap_or_default();
            self.work(now);
            if taken == 0 {
                break;
            }
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
        self.sync();
        // The session has nothing else to do, so that it takes the datagram.
        let _ = self.session.receive_datagram(now, from.into(), bytes);
        self.work(now);
    }

    fn motors(&self) -> &[Motor] {
        &self.motors
    }

    /// Also `None` while the motors go to where the move begins, or to the place of the next photo.
    fn moment(&self) -> Option<f64> {
        use State::{Exposing, Forward, ForwardC, FrameDelay, Post, Pre, Reverse};
        let played =
            [Pre, Forward, Reverse, ForwardC, FrameDelay, Exposing, Post].contains(&self.session.machine().playback());
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
