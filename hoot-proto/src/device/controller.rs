//! What is set of the controller itself. Source: hoot, section 2.1.

use crate::message::{
    AltMode, CommonLine, Edge, EdgeFound, Level, Milliseconds, ProgramMode, RingTip, ShortMilliseconds, StartDelay,
    StepRate,
};
use crate::state::debug;

/// When and for how long the auxiliary output is on, beside a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct AltOut {
    /// How long to wait.
    pub delay: ShortMilliseconds,
    /// How long it is on.
    pub time: ShortMilliseconds,
}

/// What a master sets of the controller, and can ask for. Source: hoot, sections 2.1 and 2.2.
#[expect(clippy::struct_excessive_bools, reason = "each is a setting of its own")]
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Controller {
    /// Whether it gives the time to other nodes, or waits for the common line.
    pub timing_master: bool,
    /// On which line nodes step in common.
    pub common_line: CommonLine,
    /// The greatest step rate of all motors.
    pub max_step_rate: StepRate,
    /// Which edge of the auxiliary input counts.
    pub edge: Edge,
    /// What the contacts of the auxiliary connector are for.
    pub alt_modes: RingTip<AltMode>,
    /// Whether motors stop when no command comes.
    pub manual_move: bool,
    /// The auxiliary output before a picture.
    pub out_before: AltOut,
    /// The auxiliary output after a picture.
    pub out_after: AltOut,
    /// The level at which the auxiliary output is on.
    pub out_level: Level,
    /// After how long the planned move is stopped; 0 for no limit.
    pub max_run_time: Milliseconds,
    /// How long the planned move waits, in the unit of the profile.
    pub start_delay: StartDelay,
    /// What kind of program the planned move is.
    pub program_mode: ProgramMode,
    /// Whether it does only what a joystick needs.
    pub joystick_mode: bool,
    /// Whether the planned move goes to and fro.
    pub ping_pong: bool,
}

debug! { Controller { timing_master common_line max_step_rate edge alt_modes manual_move out_before out_after out_level max_run_time start_delay program_mode joystick_mode ping_pong } }

impl Default for Controller {
    /// Of a new node, which is its own timing master.
    fn default() -> Self {
        Self {
            timing_master: true,
            common_line: CommonLine::OFF,
            max_step_rate: StepRate(5000),
            edge: Edge::FALLING,
            alt_modes: RingTip::default(),
            manual_move: false,
            out_before: AltOut::default(),
            out_after: AltOut::default(),
            out_level: Level::LOW,
            max_run_time: Milliseconds(0),
            start_delay: StartDelay(0),
            program_mode: ProgramMode::SMS,
            joystick_mode: false,
            ping_pong: false,
        }
    }
}

impl Controller {
    /// The edge by the numbers under which it is read back (hoot, section 2.2).
    pub(super) const fn edge_found(&self) -> EdgeFound {
        match self.edge {
            Edge::RISING => EdgeFound::RISING,
            Edge::CHANGE => EdgeFound::CHANGE,
            _ => EdgeFound::FALLING,
        }
    }
}
