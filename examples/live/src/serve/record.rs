//! Where the motors of a rig go, written down.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use motion_core::time::Millis;
use rigs::motor::Motor;
use tracing::warn;

/// Milliseconds after which a row is in the file at the latest.
const FLUSH: u64 = 500;

/// A file of comma-separated values: `millis,motor,position,moment`.
///
/// A row is a motor at a moment of the rig's clock, whenever it is elsewhere than in its last row. The last column is how
/// far the move is that is played, as [`Rig::moment`](rigs::Rig::moment) has it; it is empty while none is.
#[derive(Debug)]
pub struct Record {
    /// Nothing, once it could not be written.
    out: Option<BufWriter<File>>,
    last: Vec<f64>,
    /// When the rows that are not in the file must be.
    due: Option<Millis>,
}

impl Record {
    /// A new file, in the place of one of this name.
    ///
    /// # Errors
    ///
    /// What the operating system says.
    pub fn create(path: &Path) -> io::Result<Self> {
        let mut out = BufWriter::new(File::create(path)?);
        writeln!(out, "millis,motor,position,moment")?;
        out.flush()?;
        Ok(Self { out: Some(out), last: Vec::new(), due: None })
    }

    /// When it wants to be looked at, if nothing happens before.
    pub(super) const fn wake(&self) -> Option<Millis> {
        self.due
    }

    /// Writes down what has changed.
    pub(super) fn look(&mut self, now: Millis, motors: &[Motor], moment: Option<f64>) {
        self.last.resize(motors.len(), f64::NAN);
        let moment = moment.map(|moment| moment.to_string()).unwrap_or_default();
        for (number, (motor, last)) in (1..).zip(motors.iter().zip(&mut self.last)) {
            let position = motor.at(now).position;
            if position.to_bits() == last.to_bits() {
                continue;
            }
            *last = position;
            self.due.get_or_insert(now.after(FLUSH));
            let row = |out: &mut BufWriter<File>| writeln!(out, "{},{number},{position},{moment}", now.0);
            if let Some(Err(error)) = self.out.as_mut().map(row) {
                fail(&mut self.out, &error);
            }
        }
        if self.due.is_some_and(|due| due <= now) {
            self.flush();
        }
    }

    /// Brings all rows into the file.
    pub(super) fn flush(&mut self) {
        self.due = None;
        if let Some(Err(error)) = self.out.as_mut().map(Write::flush) {
            fail(&mut self.out, &error);
        }
    }
}

fn fail(out: &mut Option<BufWriter<File>>, error: &io::Error) {
    warn!("the record ends here: {error}");
    *out = None;
}
