//! Numbers with units, and numbers with names.

use motion_core::fixed::Centi;
use motion_core::{open_enum, unit};

/// Greatest number of 32 bits that arrives, because firmware drops the top byte of the numbers that it receives.
///
/// Firmware reads 16,777,216 as 0, which mostly means without end. Source: hoot, section 1.2; safety decision 3.
pub const MAX_ARRIVING: u32 = 0x00FF_FFFF;

unit! {
    /// Position, in steps of the present microstep setting.
    pub struct Steps(i32) "steps";
    /// Length of a move, in steps of the present microstep setting.
    pub struct StepCount(u32) "steps";
    /// Number of steps that are added when a motor reverses.
    pub struct Backlash(u16) "steps";
    /// Speed in steps per second, as requests contain it: an IEEE number, whose sign is the direction.
    pub struct StepsPerSecond(f32) "steps/s";
    /// Acceleration in steps per second squared, as requests contain it: an IEEE number.
    pub struct StepsPerSecondSquared(f32) "steps/s²";
    /// Speed in hundredths of a step per second, as replies contain it.
    pub struct Speed(Centi<i32>) "steps/s";
    /// Acceleration in hundredths of a step per second squared, as replies contain it.
    pub struct Acceleration(Centi<i32>) "steps/s²";
    /// Greatest speed in steps per second, without sign.
    pub struct StepRate(u16) "steps/s";
    /// Voltage in hundredths of a volt, as on the wire.
    pub struct Volts(Centi<i32>) "V";
    /// Current in hundredths of an ampere, as on the wire.
    pub struct Amperes(Centi<i32>) "A";
    /// Time in milliseconds. In requests at most [`MAX_ARRIVING`] arrives, which is 4 h 39 min.
    pub struct Milliseconds(u32) "ms";
    /// Time in milliseconds, up to a minute.
    pub struct ShortMilliseconds(u16) "ms";
    /// Delay before the start: in seconds for the sheet's firmware, in milliseconds since 2015-07-20.
    ///
    /// Nothing on the wire tells the unit. [`Profile::start_delay`](crate::query::Profile::start_delay) tells it, if it is
    /// known.
    pub struct StartDelay(u32) "";
    /// Part of a program: shots, or milliseconds in the modes without stops. A lead-in is in milliseconds in video mode only.
    pub struct Span(u32) "";
    /// Part of a program in 16 bits: shots, or milliseconds in video mode.
    pub struct ShortSpan(u16) "";
    /// Number of pictures.
    pub struct Shots(u32) "shots";
    /// Number of pictures, in 16 bits.
    pub struct ShortShots(u16) "shots";
    /// Direction in which a motor turns, 0 or 1. Its meaning on the rig depends on the wiring and on the setting of the
    /// motor.
    pub struct Direction(u8) "";
    /// Version of the firmware of a node: 6 is the firmware of the published sheet, 70 is v0.70.
    pub struct Version(u32) "";
    /// Version of the core protocol, or of the device.
    pub struct CoreVersion(u16) "";
}

impl StepCount {
    /// Greatest number that arrives; see [`MAX_ARRIVING`].
    pub const MAX: Self = Self(MAX_ARRIVING);
}

open_enum! {
    /// State of the planned move. Firmware of the published sheet answers only 0 or 1, and answers 0 if the move is
    /// paused.
    ///
    /// Source: hoot, sections 2.2 and 4.2. A running move is 1 in the sheet's firmware, and 2 in later firmware: see
    /// [`is_running`](Self::is_running).
    pub struct RunState(u8) {
        /// The move does not run, or, in the sheet's firmware, it is paused.
        STOPPED = 0,
        /// The move runs, in the sheet's firmware. It is paused, in firmware since 2014-12-03.
        RUNNING_OR_PAUSED = 1,
        /// The move runs.
        RUNNING = 2,
        /// The move waits for the delay before the start.
        DELAY = 3,
        /// The node still takes a picture.
        STILL_SHOOTING = 4,
        /// The move runs to and fro.
        PING_PONG = 5,
    }

    /// Mode of the planned move. Source: hoot, sections 2.1 and 4.2.
    ///
    /// Firmware accepts any number.
    pub struct ProgramMode(u8) {
        /// Shoot, move, shoot: motors rest while pictures are taken.
        SMS = 0,
        /// Time lapse: motors move by the clock while pictures are taken.
        CONTINUOUS = 1,
        /// Video: motors move by the clock. The sheet does not mention it at the query for the mode.
        VIDEO = 2,
    }

    /// Line on which nodes step in common. Source: hoot, section 2.1.
    pub struct CommonLine(u8) {
        /// No line.
        OFF = 0,
        /// The first line.
        FIRST = 1,
        /// The second line.
        SECOND = 2,
    }

    /// Edge of the auxiliary input that counts, as it is set. Source: hoot, section 2.1.
    ///
    /// Answers have other numbers: [`EdgeFound`].
    pub struct Edge(u8) {
        /// From low to high.
        RISING = 0,
        /// From high to low.
        FALLING = 1,
        /// Both edges.
        CHANGE = 2,
    }

    /// Edge of the auxiliary input that counts, as it is answered: with the numbers of the processor, not with those
    /// that set it, although the sheet says otherwise. Source: hoot, section 2.2.
    pub struct EdgeFound(u8) {
        /// Both edges.
        CHANGE = 1,
        /// From high to low.
        FALLING = 2,
        /// From low to high.
        RISING = 3,
    }

    /// Purpose of a contact of the auxiliary connector, 0 to 255 in the sheet, which names eleven. Source: hoot, section 2.1.
    pub struct AltMode(u8) {
        /// No purpose.
        OFF = 0,
        /// Input: starts the program.
        START = 1,
        /// Input: stops the program.
        STOP = 2,
        /// Input: starts or stops the program.
        TOGGLE = 3,
        /// Input: takes the next picture.
        EXTERNAL_INTERVALOMETER = 4,
        /// Input: reverses the direction.
        REVERSE_DIRECTION = 5,
        /// Output: on before a picture.
        OUT_BEFORE = 6,
        /// Output: on after a picture.
        OUT_AFTER = 7,
        /// Input: stops the motors.
        STOP_MOTORS = 8,
        /// Input: makes the present position the home.
        SET_HOME = 9,
        /// Input: makes the present position the end limit.
        SET_END = 10,
    }

    /// Level of a contact. Source: hoot, sections 2.1 and 2.2.
    pub struct Level(u8) {
        /// Low level.
        LOW = 0,
        /// High level.
        HIGH = 1,
    }

    /// Easing: how a planned move gains and loses speed. Source: hoot, section 2.3.
    pub struct Easing(u8) {
        /// Speed changes at a constant rate.
        LINEAR = 1,
        /// Speed changes slowly at first.
        QUADRATIC = 2,
        /// Speed changes quickly at first.
        INVERSE_QUADRATIC = 3,
    }

    /// Easing, as it is read back: the numbers are those inside the firmware, which differ from those that set it.
    ///
    /// Source: hoot, section 2.3; decision H-61.
    pub struct EasingFound(u8) {
        /// Speed changes at a constant rate.
        LINEAR = 4,
        /// Speed changes slowly at first.
        QUADRATIC = 5,
        /// Speed changes quickly at first.
        INVERSE_QUADRATIC = 6,
    }

    /// Number of microsteps into which a step is divided. Source: hoot, section 2.3.
    ///
    /// A rotation of a motor has 200 steps. With the usual gearbox, a rotation of the output has about 3800 steps.
    /// Later firmware uses only 4, 8 and 16.
    pub struct Microstep(u8) {
        /// Whole steps.
        FULL = 1,
        /// 2 microsteps.
        HALF = 2,
        /// 4 microsteps.
        QUARTER = 4,
        /// 8 microsteps.
        EIGHTH = 8,
        /// 16 microsteps.
        SIXTEENTH = 16,
    }
}

impl EasingFound {
    /// Easing with the number that sets it; `None` if it is not an easing.
    #[must_use]
    pub const fn easing(self) -> Option<Easing> {
        match self {
            Self::LINEAR => Some(Easing::LINEAR),
            Self::QUADRATIC => Some(Easing::QUADRATIC),
            Self::INVERSE_QUADRATIC => Some(Easing::INVERSE_QUADRATIC),
            _ => None,
        }
    }
}

impl From<Easing> for EasingFound {
    /// Number under which an easing is read back.
    fn from(easing: Easing) -> Self {
        Self(easing.0.saturating_add(3))
    }
}

impl EdgeFound {
    /// Edge with the number that sets it; `None` if it is not an edge.
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
