//! Main loop of firmware: it blocks for some commands, and hangs when packets wait.
//!
//! Firmware reads a packet, and then waits until its port has no more bytes. If bytes are there already, it waits for ever:
//! the loop flushes what is to be sent, not what has arrived. On an idle node the bytes of the next packet are never there
//! yet. While a command blocks, packets pile up.

use hoot_proto::device::{Input, Port, Quirks};
use hoot_proto::frame::HEADER_LEN;
use hoot_proto::{Frame, HostMessage};
use motion_core::time::Millis;
use tracing::{debug, info, warn};

use super::{HootNode, LINES, PORTS, line};
use crate::Party;

/// Bytes that wait in the buffer of a port, at most. Firmware loses what arrives beyond that.
const BUFFER: usize = 64;

/// Occupation of the main loop.
#[derive(Debug, Default)]
pub(super) enum MainLoop {
    /// The loop reads packets.
    #[default]
    Free,
    /// A command blocks the loop until a moment. Then a packet is carried out, if one waits for that.
    Blocked { until: Millis, then: Option<(Port, Vec<u8>)> },
    /// The loop hangs until the power is interrupted.
    Hung,
}

impl HootNode {
    /// Whether the firmware hangs: it answers nothing, and what moves goes on, until the power is interrupted.
    #[must_use]
    pub const fn is_hung(&self) -> bool {
        matches!(self.main_loop, MainLoop::Hung)
    }

    pub(super) const fn is_free(&self) -> bool {
        matches!(self.main_loop, MainLoop::Free)
    }

    pub(super) const fn blocked_until(&self) -> Option<Millis> {
        if let MainLoop::Blocked { until, .. } = self.main_loop { Some(until) } else { None }
    }

    /// Whether the rig copies the main loop of firmware.
    pub(super) fn copies_main_loop(&self) -> bool {
        self.quirks.contains(Quirks::BLOCKS)
    }

    /// Keeps bytes that arrive while the loop reads nothing.
    pub(super) fn pile_up(&mut self, number: usize, bytes: &[u8]) {
        if !self.is_hung() {
            let waiting = &mut self.wires[number].waiting;
            waiting.extend(bytes.iter().take(BUFFER.saturating_sub(waiting.len())));
        }
    }

    /// Carries out a packet, or blocks first.
    pub(super) fn read(&mut self, port: Port, packet: Vec<u8>) {
        let Ok(frame) = Frame::decode(&packet) else { return };
        let message = HostMessage::decode(&frame);
        debug!("{port:?} > {}: {message}", frame.address().0);
        let blocking = self.machine.blocking(port, frame.address(), &message);
        if blocking.before > 0 {
            info!("{port:?}: {message} blocks the node for {} ms", blocking.before);
            let then = Some((port, packet));
            self.main_loop = MainLoop::Blocked { until: self.now.after(blocking.before), then };
            return;
        }
        self.step(Input::received(port, &frame));
        if blocking.after > 0 {
            info!("{port:?}: {message} blocks the node for {} ms", blocking.after);
            self.main_loop = MainLoop::Blocked { until: self.now.after(blocking.after), then: None };
        }
    }

    /// Goes on when a command has blocked for its time, and reads what waits.
    pub(super) fn unblock(&mut self) {
        let MainLoop::Blocked { then, .. } = std::mem::take(&mut self.main_loop) else { return };
        let packet = then.as_ref().and_then(|(port, packet)| Some((*port, Frame::decode(packet).ok()?)));
        if let Some((port, frame)) = packet {
            self.step(Input::received(port, &frame));
        }
        for port in PORTS {
            let number = line(port);
            if !self.is_free() || self.wires[number].waiting.is_empty() {
                continue;
            }
            let waiting = std::mem::take(&mut self.wires[number].waiting);
            let data = waiting.get(HEADER_LEN - 1).map_or(0, |len| usize::from(*len));
            if waiting.len() > HEADER_LEN + data {
                self.hang("two packets waited");
            } else {
                self.receive(self.now, LINES[number], &waiting);
            }
        }
    }

    pub(super) fn hang(&mut self, why: &str) {
        warn!("the node hangs until its power is interrupted: {why}");
        self.main_loop = MainLoop::Hung;
        for wire in &mut self.wires {
            wire.forget();
        }
    }
}
