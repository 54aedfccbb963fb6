//! Uploaded move, in memory that the device owns.

use std::fmt;

use dmc_proto::message::{AckCode, DmxChannel, FrameNumber, HostMessage, Motor, Triggers};
use dmc_proto::upload::{Memory, Room, Track, UploadBuffer};
use self_cell::{MutBorrow, self_cell};

/// Memory for a move.
struct Tables {
    positions: Vec<i32>,
    levels: Vec<u8>,
    triggers: Vec<Triggers>,
    written: Vec<u32>,
}

self_cell!(
    struct Cell {
        owner: MutBorrow<Tables>,
        #[covariant]
        dependent: UploadBuffer,
    }
);

/// Uploaded move.
pub(super) struct Store {
    cell: Cell,
    /// Whether a motor without uploaded positions has a path of zeros.
    fills_with_zeros: bool,
}

impl Store {
    pub(super) fn new(room: Room, fills_with_zeros: bool) -> Self {
        let tables = Tables {
            positions: vec![0; room.positions()],
            levels: vec![0; room.levels()],
            triggers: vec![Triggers::NONE; room.triggers()],
            written: vec![0; room.written()],
        };
        let cell = Cell::new(MutBorrow::new(tables), |tables| {
            let Tables { positions, levels, triggers, written } = tables.borrow_mut();
            let memory = Memory { positions, levels, triggers, written };
            UploadBuffer::new(room, memory).expect("the memory has the lengths of this room")
        });
        Self { cell, fills_with_zeros }
    }

    fn buffer(&self) -> &UploadBuffer<'_> {
        self.cell.borrow_dependent()
    }

    /// Takes a message of an upload, and returns the code of the answer.
    pub(super) fn receive(&mut self, message: &HostMessage<'_>) -> AckCode {
        let code = self.cell.with_dependent_mut(|_, buffer| buffer.receive(message));
        code.unwrap_or(AckCode::ERR_GENERAL)
    }

    /// Forgets the move.
    pub(super) fn clear(&mut self) {
        self.cell.with_dependent_mut(|_, buffer| buffer.clear());
    }

    /// Whether a frame is part of the move.
    pub(super) fn has_frame(&self, frame: FrameNumber) -> bool {
        self.buffer().index(frame).is_some()
    }

    /// Whether a motor is part of the move.
    pub(super) fn has(&self, motor: Motor) -> bool {
        self.buffer().is_loaded() && (self.fills_with_zeros || self.buffer().contains(Track::Axis(motor)))
    }

    /// Position of a motor at a frame; `None` outside the move.
    pub(super) fn position(&self, motor: Motor, frame: FrameNumber) -> Option<i32> {
        let index = self.buffer().index(frame)?;
        let zero = self.fills_with_zeros.then_some(0);
        self.buffer().position(motor, index).map(|steps| steps.0).or(zero)
    }

    /// Position of a motor at a moment between two frames, at a constant speed between them. Outside the move it is the
    /// first or the last position.
    pub(super) fn between(&self, motor: Motor, moment: f64) -> Option<f64> {
        let frame = |moment: f64| super::steps(moment);
        let (before, part) = (frame(moment.floor()), moment - moment.floor());
        let at = |number: i32| self.position(motor, FrameNumber(number)).map(f64::from);
        let (from, to) = (at(before), at(before.saturating_add(1)));
        let (from, to) = (from.or(to)?, to.or(from)?);
        Some(from + (to - from) * part)
    }

    /// Outputs that are on at a frame, of those that the move switches.
    pub(super) fn triggers(&self, frame: FrameNumber) -> Triggers {
        self.buffer().index(frame).map_or(Triggers::NONE, |index| self.buffer().triggers(index))
    }

    /// Outputs that the move switches.
    pub(super) fn mask(&self) -> Triggers {
        self.buffer().mask()
    }

    /// Level of a light at a frame.
    pub(super) fn level(&self, channel: DmxChannel, frame: FrameNumber) -> Option<u8> {
        self.buffer().level(channel, self.buffer().index(frame)?)
    }
}

impl fmt::Debug for Store {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Store").field(self.buffer()).finish()
    }
}
