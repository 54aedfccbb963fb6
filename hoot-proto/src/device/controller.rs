//! Settings of the controller itself. Source: hoot, section 2.1.

use crate::message::{
    AltMode, CommonLine, Edge, EdgeFound, Level, Milliseconds, ProgramMode, RingTip, ShortMilliseconds, StartDelay,
    StepRate,
};

/// Times of the auxiliary output before or after a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct AltOut {
    /// Time to wait before the output is on.
    pub delay: ShortMilliseconds,
    /// Time for which the output is on.
    pub time: ShortMilliseconds,
}

/// Settings of the controller, which a master can write and ask for. Source: hoot, sections 2.1 and 2.2.
#[expect(clippy::struct_excessive_bools, reason = "each is a setting of its own")]
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Controller {
    /// Whether the node gives the time to other nodes; otherwise it waits for the common line.
    pub timing_master: bool,
    /// Line on which nodes step in common.
    pub common_line: CommonLine,
    /// Greatest step rate of all motors.
    pub max_step_rate: StepRate,
    /// Edge of the auxiliary input that counts.
    pub edge: Edge,
    /// Purposes of the contacts of the auxiliary connector.
    pub alt_modes: RingTip<AltMode>,
    /// Whether the dead-man stops motors when no command comes.
    pub manual_move: bool,
    /// Times of the auxiliary output before a picture.
    pub out_before: AltOut,
    /// Times of the auxiliary output after a picture.
    pub out_after: AltOut,
    /// Level at which the auxiliary output is on.
    pub out_level: Level,
    /// Run time after which the planned move is stopped; 0 for no limit.
    pub max_run_time: Milliseconds,
    /// Delay before the planned move begins, in the unit of the profile.
    pub start_delay: StartDelay,
    /// Kind of program of the planned move.
    pub program_mode: ProgramMode,
    /// Whether the node does only what a joystick needs.
    pub joystick_mode: bool,
    /// Whether the planned move is repeated backwards and forwards.
    pub ping_pong: bool,
}

motion_core::debug! { Controller { timing_master common_line max_step_rate edge alt_modes manual_move out_before out_after out_level max_run_time start_delay program_mode joystick_mode ping_pong } }

impl Default for Controller {
    /// Settings of a new node, which is its own timing master.
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
    /// Edge that counts, by the numbers under which it is read back (hoot, section 2.2).
    pub(super) const fn edge_found(&self) -> EdgeFound {
        match self.edge {
            Edge::RISING => EdgeFound::RISING,
            Edge::CHANGE => EdgeFound::CHANGE,
            _ => EdgeFound::FALLING,
        }
    }
}
