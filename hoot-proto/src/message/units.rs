//! Numbers with a meaning: units, and numbers that have names.

use motion_core::fixed::Centi;
use motion_core::{open_enum, unit};

/// The most that arrives of a number of 32 bits: firmware drops the top byte of what it is sent.
///
/// Of 16,777,216 it sees 0, which mostly means without end. Source: hoot, section 1.2; safety decision 3.
pub const MAX_ARRIVING: u32 = 0x00FF_FFFF;

unit! {
    /// A position, in steps of the present microstep setting.
    pub struct Steps(i32) "steps";
    /// How far to move, in steps of the present microstep setting.
    pub struct StepCount(u32) "steps";
    /// Steps that are added when a motor turns the other way.
    pub struct Backlash(u16) "steps";
    /// A speed; its sign is the direction. An IEEE number, as requests hold it.
    pub struct StepsPerSecond(f32) "steps/s";
    /// An acceleration. An IEEE number, as requests hold it.
    pub struct StepsPerSecondSquared(f32) "steps/s²";
    /// A speed in hundredths, as replies hold it.
    pub struct Speed(Centi<i32>) "steps/s";
    /// An acceleration in hundredths, as replies hold it.
    pub struct Acceleration(Centi<i32>) "steps/s²";
    /// The greatest speed, without sign.
    pub struct StepRate(u16) "steps/s";
    /// A voltage in hundredths of a volt, on the wire as well.
    pub struct Volts(Centi<i32>) "V";
    /// A current in hundredths of an ampere, on the wire as well.
    pub struct Amperes(Centi<i32>) "A";
    /// A time in milliseconds. Of requests no more than [`MAX_ARRIVING`] arrives, which is 4 h 39 min.
    pub struct Milliseconds(u32) "ms";
    /// A time in milliseconds, up to a minute.
    pub struct ShortMilliseconds(u16) "ms";
    /// The delay before the start: in seconds for the sheet's firmware, in milliseconds since 2015-07-20.
    ///
    /// Nothing on the wire says which: [`Facts::start_delay`](crate::query::Facts::start_delay) does, as
    /// far as it can be told.
    pub struct StartDelay(u32) "";
    /// A part of a program: shots, or, in video mode, milliseconds.
    pub struct Span(u32) "";
    /// A part of a program in 16 bits: shots, or, in video mode, milliseconds.
    pub struct ShortSpan(u16) "";
    /// A number of pictures.
    pub struct Shots(u32) "shots";
    /// A number of pictures, in 16 bits.
    pub struct ShortShots(u16) "shots";
    /// Which way a motor turns, 0 or 1. What that is on the rig depends on the wiring and on the motor's own setting.
    pub struct Direction(u8) "";
    /// The version of a node's firmware: 6 is that of the published sheet, 70 is v0.70.
    pub struct Version(u32) "";
    /// A version of the core protocol, or of the device that speaks it.
    pub struct CoreVersion(u16) "";
}

impl StepCount {
    /// The most that arrives, see [`MAX_ARRIVING`].
    pub const MAX: Self = Self(MAX_ARRIVING);
}

open_enum! {
    /// Whether the planned move runs. The firmware of the published sheet says 0 or 1 only, and 0 for paused.
    ///
    /// Source: hoot, sections 2.2 and 4.2. The sheet's firmware calls 1 what later firmware calls 2: see
    /// [`is_running`](Self::is_running).
    pub struct RunState(u8) {
        /// It does not; or, says the sheet's firmware, it is paused.
        STOPPED = 0,
        /// It runs, says the sheet's firmware; it is paused, says firmware since 2014-12-03.
        RUNNING_OR_PAUSED = 1,
        /// It runs.
        RUNNING = 2,
        /// It waits for the delay before the start.
        DELAY = 3,
        /// It still takes a picture.
        STILL_SHOOTING = 4,
        /// It runs to and fro.
        PING_PONG = 5,
    }

    /// What kind of program the planned move is. Source: hoot, sections 2.1 and 4.2.
    ///
    /// Firmware takes any number.
    pub struct ProgramMode(u8) {
        /// Shoot, move, shoot: motors rest while pictures are taken.
        SMS = 0,
        /// Time lapse: motors move while pictures are taken.
        CONTINUOUS = 1,
        /// Motors move by the clock. The sheet leaves it out where it is asked for.
        VIDEO = 2,
    }

    /// The line on which nodes step in common. Source: hoot, section 2.1.
    pub struct CommonLine(u8) {
        /// None.
        OFF = 0,
        /// The first.
        FIRST = 1,
        /// The second.
        SECOND = 2,
    }

    /// The edge of the auxiliary input that counts, as it is set. Source: hoot, section 2.1.
    ///
    /// Read back, it has other numbers: [`EdgeFound`].
    pub struct Edge(u8) {
        /// From low to high.
        RISING = 0,
        /// From high to low.
        FALLING = 1,
        /// Both.
        CHANGE = 2,
    }

    /// The edge of the auxiliary input that counts, as it is read back: by the numbers of the processor, not by those
    /// that set it, whatever the sheet says. Source: hoot, section 2.2.
    pub struct EdgeFound(u8) {
        /// Both.
        CHANGE = 1,
        /// From high to low.
        FALLING = 2,
        /// From low to high.
        RISING = 3,
    }

    /// What one contact of the auxiliary connector is for. Source: hoot, section 2.1.
    pub struct AltMode(u8) {
        /// Nothing.
        OFF = 0,
        /// In: start the program.
        START = 1,
        /// In: stop the program.
        STOP = 2,
        /// In: start or stop the program.
        TOGGLE = 3,
        /// In: take the next picture.
        EXTERNAL_INTERVALOMETER = 4,
        /// In: turn the other way.
        REVERSE_DIRECTION = 5,
        /// Out: before a picture.
        OUT_BEFORE = 6,
        /// Out: after a picture.
        OUT_AFTER = 7,
        /// In: stop the motors.
        STOP_MOTORS = 8,
        /// In: here is home.
        SET_HOME = 9,
        /// In: here is the end.
        SET_END = 10,
    }

    /// A level of a contact. Source: hoot, sections 2.1 and 2.2.
    pub struct Level(u8) {
        /// Low.
        LOW = 0,
        /// High.
        HIGH = 1,
    }

    /// How a planned move gains and loses speed. Source: hoot, section 2.3.
    pub struct Easing(u8) {
        /// At a constant rate.
        LINEAR = 1,
        /// Slowly at first.
        QUADRATIC = 2,
        /// Quickly at first.
        INVERSE_QUADRATIC = 3,
    }

    /// Into how many microsteps a step is divided. Source: hoot, section 2.3.
    ///
    /// A rotation of a motor has 200 steps, of which a gearbox makes some 3800 a rotation of its output. Later firmware
    /// makes use of 4, 8 and 16 only.
    pub struct Microstep(u8) {
        /// None.
        FULL = 1,
        /// 2.
        HALF = 2,
        /// 4.
        QUARTER = 4,
        /// 8.
        EIGHTH = 8,
        /// 16.
        SIXTEENTH = 16,
    }
}

impl EdgeFound {
    /// The edge, by the numbers that set it; `None` if it is no edge.
    #[must_use]
    pub const fn edge(self) -> Option<Edge> {
        match self {
            Self::CHANGE => Some(Edge::CHANGE),
            Self::FALLING => Some(Edge::FALLING),
            Self::RISING => Some(Edge::RISING),
            _ => None,
        }
    }
}
