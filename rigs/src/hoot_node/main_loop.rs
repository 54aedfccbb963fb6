//! Main loop of firmware: it reads packets from the ports, blocks for some commands, and hangs when packets wait. It stands
//! between the lines and the session, because a session reads all that arrives.
//!
//! Firmware reads a packet, and then waits until its port has no more bytes. If bytes are there already, it waits for ever:
//! the loop flushes what is to be sent, not what has arrived. On an idle node the bytes of the next packet are never there
//! yet. While a command blocks, packets pile up.

use hoot_proto::device::{Port, Quirks};
use hoot_proto::frame::{HEADER_LEN, MAX_FRAME};
use hoot_proto::{Frame, HostMessage, Item, Strict};
use motion_core::stream::{Frames, Noise};
use motion_core::time::Millis;
use tracing::{debug, info, warn};

use super::{HootNode, LINES, PORTS, line};
use crate::Party;

/// Time of silence inside a packet after which it is dropped, in milliseconds: more than 100 (hoot, section 1.1).
const GAP: u64 = 101;

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

/// Port, with the bytes that arrive at it.
#[derive(Debug)]
pub(super) struct Wire {
    pub(super) is_open: bool,
    frames: Frames<Strict, { 2 * MAX_FRAME }>,
    /// Time after which the rest of a packet, or of what is lost with a wrong one, is not awaited any more.
    until: Option<Millis>,
    /// Bytes that arrived while the main loop did not read.
    waiting: Vec<u8>,
}

impl Wire {
    pub(super) const fn new() -> Self {
        Self { is_open: false, frames: Frames::new(), until: None, waiting: Vec::new() }
    }

    /// Number of bytes of an incomplete packet.
    pub(super) const fn held(&self) -> usize {
        self.frames.held()
    }

    /// Time after which the main loop has to look at the port.
    pub(super) const fn until(&self) -> Option<Millis> {
        self.until
    }

    /// Drops the bytes of an incomplete packet.
    pub(super) fn forget(&mut self) {
        self.frames.reset();
        self.until = None;
        self.waiting.clear();
    }
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

    /// Reads bytes, and carries out their packets.
    pub(super) fn listen(&mut self, number: usize, bytes: &[u8]) {
        let (port, is_firmware) = (PORTS[number], self.copies(Quirks::BLOCKS));
        if self.is_free() {
            self.wires[number].until = Some(self.now.after(GAP));
        }
        for (at, byte) in bytes.iter().enumerate() {
            if !self.is_free() {
                return self.pile_up(number, &bytes[at..]);
            }
            let _ = self.wires[number].frames.push(&[*byte]);
            while let Some(item) = self.wires[number].frames.next() {
                let packet = match item {
                    Item::Frame(frame) => frame.bytes().to_vec(),
                    Item::Noise { why: Noise::TooLong { .. }, .. } if is_firmware => {
                        self.hang("a packet was too long");
                        continue;
                    }
                    noise => {
                        warn!("{port:?}: {} bytes that are no packet", noise.bytes().len());
                        continue;
                    }
                };
                self.wires[number].forget();
                self.read(port, packet);
                // A mild node drops bytes that came together with a packet.
                if !is_firmware {
                    return;
                }
            }
        }
    }

    /// Drops the beginnings of packets whose rest does not come.
    pub(super) fn drop_cut_off(&mut self) {
        for (wire, port) in self.wires.iter_mut().zip(PORTS) {
            if wire.until.is_some_and(|until| self.now >= until) {
                warn!("{port:?}: the rest of a packet did not come");
                wire.forget();
            }
        }
    }

    /// Keeps bytes that arrive while the loop reads nothing.
    fn pile_up(&mut self, number: usize, bytes: &[u8]) {
        if !self.is_hung() {
            let waiting = &mut self.wires[number].waiting;
            waiting.extend(bytes.iter().take(BUFFER.saturating_sub(waiting.len())));
        }
    }

    /// Carries out a packet, or blocks first.
    fn read(&mut self, port: Port, packet: Vec<u8>) {
        let Ok(frame) = Frame::decode(&packet) else { return };
        let message = HostMessage::decode(&frame);
        debug!("{port:?} > {}: {message}", frame.address().0);
        let blocking = self.machine().blocking(port, frame.address(), &message);
        if blocking.before > 0 {
            info!("{port:?}: {message} blocks the node for {} ms", blocking.before);
            let then = Some((port, packet));
            self.main_loop = MainLoop::Blocked { until: self.now.after(blocking.before), then };
            return;
        }
        self.carry_out(port, &packet);
        if blocking.after > 0 {
            info!("{port:?}: {message} blocks the node for {} ms", blocking.after);
            self.main_loop = MainLoop::Blocked { until: self.now.after(blocking.after), then: None };
        }
    }

    /// Gives a packet to the session.
    fn carry_out(&mut self, port: Port, packet: &[u8]) {
        let now = self.now;
        self.tell(|session| {
            let taken = session.receive(now, port, packet);
            debug_assert_eq!(taken, packet.len(), "the session waits");
            Ok(())
        });
    }

    /// Goes on when a command has blocked for its time, and reads what waits.
    pub(super) fn unblock(&mut self) {
        let MainLoop::Blocked { then, .. } = std::mem::take(&mut self.main_loop) else { return };
        if let Some((port, packet)) = then {
            self.carry_out(port, &packet);
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
