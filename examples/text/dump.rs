//! Offsets of dumps: the order of lines, and the meaning of `*`.

use std::mem;

use super::error::At;
use super::grammar::{After, Label};
use super::{MAX_REPEAT, Side, TextError, TextProblem};

/// Dump that has not ended.
#[derive(Debug)]
struct Dump {
    /// Offset of the next line.
    next: u64,
    /// Whether the offsets have no colon. Then an offset alone ends the dump.
    columns: bool,
    /// Bytes of the last line.
    last: Vec<u8>,
    /// A `*` that no offset has ended yet.
    star: Option<At>,
}

/// Dumps that have not ended: one of the host, one of the device, one without a side.
#[derive(Debug, Default)]
pub(super) struct Dumps {
    host: Option<Dump>,
    device: Option<Dump>,
    unmarked: Option<Dump>,
}

impl Dumps {
    fn of(&mut self, side: Option<Side>) -> &mut Option<Dump> {
        match side {
            Some(Side::Host) => &mut self.host,
            Some(Side::Device) => &mut self.device,
            None => &mut self.unmarked,
        }
    }

    /// Whether a dump without colons has not ended.
    pub(super) fn has_columns(&mut self, side: Option<Side>) -> bool {
        self.of(side).as_ref().is_some_and(|dump| dump.columns)
    }

    /// Adds a line to its dump, or begins a dump. Returns whether a dump begins. `bytes` are the
    /// bytes of the line before the call, and after it they also contain the repeated lines before it.
    pub(super) fn line(
        &mut self,
        side: Option<Side>,
        here: At,
        label: Label,
        bytes: &mut Vec<u8>,
    ) -> Result<bool, TextError> {
        let slot = self.of(side);
        let begins = match slot {
            Some(dump) => label.offset == 0 && dump.star.is_none(),
            None => true,
        };
        let dump = slot.get_or_insert_with(|| Dump { next: 0, columns: false, last: Vec::new(), star: None });
        let repeated = if begins { Vec::new() } else { dump.repeated(here, label.offset)? };
        dump.columns = label.after != After::Colon;
        dump.next = label.offset.saturating_add(bytes.len() as u64);
        let line = mem::replace(bytes, repeated);
        bytes.extend_from_slice(&line);
        dump.last = line;
        Ok(begins)
    }

    /// Marks the last line as repeated up to the next offset.
    pub(super) fn star(&mut self, side: Option<Side>, here: At) -> Result<(), TextError> {
        match self.of(side) {
            Some(dump) if !dump.last.is_empty() => {
                dump.star = Some(here);
                Ok(())
            }
            _ => Err(here.error(TextProblem::NothingToRepeat)),
        }
    }

    /// Ends the dump of a side.
    pub(super) fn end_of(&mut self, side: Option<Side>) -> Result<(), TextError> {
        match self.of(side).take().and_then(|dump| dump.star) {
            Some(star) => Err(star.error(TextProblem::OpenRepeat)),
            None => Ok(()),
        }
    }

    /// Ends all dumps.
    pub(super) fn end(&mut self) -> Result<(), TextError> {
        self.end_of(Some(Side::Host))?;
        self.end_of(Some(Side::Device))?;
        self.end_of(None)
    }
}

impl Dump {
    /// Repeated bytes between the last line and the line at `offset`.
    fn repeated(&mut self, here: At, offset: u64) -> Result<Vec<u8>, TextError> {
        let jump = here.error(TextProblem::Jump { expected: self.next, found: offset });
        let star = self.star.take();
        let bytes = match offset.checked_sub(self.next) {
            Some(0) => return Ok(Vec::new()),
            Some(bytes) if star.is_some() => bytes,
            _ => return Err(jump),
        };
        if bytes > MAX_REPEAT {
            return Err(here.error(TextProblem::LongRepeat { bytes }));
        }
        let length = self.last.len() as u64;
        if bytes % length != 0 {
            return Err(here.error(TextProblem::UnevenRepeat { bytes }));
        }
        let count = usize::try_from(bytes / length).unwrap_or_default();
        Ok(self.last.repeat(count))
    }
}
