//! Record of the motion of the motors of a rig.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use motion_core::time::Millis;
use motion_rigs::motor::Motor;
use tracing::warn;

/// Time within which a row is written to the file, in milliseconds.
const FLUSH: u64 = 500;

/// File of comma-separated values: `millis,motor,position,moment`.
///
/// There is a row for each change of the position of a motor, with the time of the clock of the rig. The last column is
/// the progress of the move, as [`Rig::moment`](motion_rigs::Rig::moment) gives it. It is empty while no move is played.
#[derive(Debug)]
pub struct Record {
    /// Output, or `None` after a failure of writing.
    out: Option<BufWriter<File>>,
    last: Vec<f64>,
    /// Time at which all rows must be in the file.
    due: Option<Millis>,
}

impl Record {
    /// Creates a new file. An existing file of this name is replaced.
    ///
    /// # Errors
    ///
    /// Error of the operating system.
    pub fn create(path: &Path) -> io::Result<Self> {
        let mut out = BufWriter::new(File::create(path)?);
        writeln!(out, "millis,motor,position,moment")?;
        out.flush()?;
        Ok(Self { out: Some(out), last: Vec::new(), due: None })
    }

    /// Time of the next call of [`look`](Self::look), if there is none before.
    pub(super) const fn wake(&self) -> Option<Millis> {
        self.due
    }

    /// Writes a row for each motor whose position has changed.
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

    /// Writes all rows to the file.
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
