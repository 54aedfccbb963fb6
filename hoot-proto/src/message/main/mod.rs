//! Commands to the controller itself: sub-address 0.
//!
//! The firmware acknowledges all of them, and does nothing with much that it acknowledges; what is said here of a range
//! is what it acts on.

mod queries;

pub use queries::{
    AltModes, Current, Exposing, FirmwareVersion, InputEdge, JoystickMode, LimitSwitches, MaxStepRate, NameQuery,
    OutAfterDelay, OutAfterTime, OutBeforeDelay, OutBeforeTime, OutLevel, PingPong, PowerCycled, ProgramModeQuery,
    RunStatus, RunTime, StartDelayQuery, TimingMaster, Voltage,
};

use motion_core::message;
use motion_core::wire::{Bool, Conduct, Purpose};

use super::bounded::bounded;
use super::units::{
    AltMode, CommonLine, Edge, Level, Milliseconds, ProgramMode, ShortMilliseconds, StartDelay, StepRate,
};
use crate::frame::Address;

message! {
    /// Start or resume the planned move.
    ///
    /// Never send it again by itself: a retry after an operator's stop would move the rig. The answer may take 3 s.
    /// Source: hoot, section 2.1; safety decision 1.
    #[derive(Default)]
    pub struct Start in BE {}

    /// Pause the planned move. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct Pause in BE {}

    /// Stop everything and forget how far the planned move was: run time and shots count from 0 again.
    ///
    /// The firmware refuses it in joystick mode: for an emergency, stop each motor first with
    /// [`MotorStop`](super::MotorStop). Source: hoot, section 2.1; safety decision 2.
    #[derive(Default)]
    pub struct Stop in BE {}

    /// Switch the lamp for debugging on, or off if it is on. Not to be sent again by itself. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct ToggleDebugLed in BE {}

    /// Be the node that gives the time to the others, or one that waits for the common line.
    ///
    /// The sheet prints it without data; firmware reads a byte, and takes a missing one for a no. Source: hoot,
    /// sections 2.1 and 3.
    #[derive(Default)]
    pub struct SetTimingMaster in BE {
        /// Whether to be it.
        timing_master: Bool,
    }

    /// Take this address.
    ///
    /// Not to be sent again by itself: ask at the new address instead. A node is deaf for some 2.5 s afterwards; its USB
    /// port keeps the old address until it is restarted. Source: hoot, sections 2.1 and 2.5; safety decisions 1 and 5.
    #[derive(Default)]
    pub struct SetAddress in BE {
        /// The new address, 2 to 255. Nodes refuse 0 and 1.
        new_address: Address,
    }

    /// Step in common with other nodes. Of a line that there is not, the node says an error and then OK, in two packets.
    ///
    /// Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetCommonLine in BE {
        /// On which line.
        common_line: CommonLine,
    }

    /// Send all motors to their home. Not to be sent again by itself. Source: hoot, section 2.1; safety decision 1.
    #[derive(Default)]
    pub struct ReturnHome in BE {}

    /// Set the greatest step rate of all motors. Gone in v0.70.
    ///
    /// The sheet calls the number an Int; it has no sign. Source: hoot, sections 2.1 and 3.
    #[derive(Default)]
    pub struct SetMaxStepRate in BE {
        /// 1000, 2000, 4000, 5000 or 10,000. The node acknowledges and ignores others.
        max_step_rate: StepRate,
    }

    /// Set which edge of the auxiliary input counts. The node acknowledges and ignores what is none.
    ///
    /// Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetInputEdge in BE {
        /// The edge. Read back, it has another number: [`EdgeFound`](super::EdgeFound).
        edge: Edge,
    }

    /// Set what the two contacts of the auxiliary connector are for. Two bytes, where the sheet says an Int.
    ///
    /// Source: hoot, sections 2.1 and 3.
    #[derive(Default)]
    pub struct SetAltModes in BE {
        /// What the ring is for.
        ring: AltMode,
        /// What the tip is for.
        tip: AltMode,
    }

    /// Set whether motors stop when no command has come for a second: the dead-man of manual moves, which later
    /// firmware calls the joystick watchdog.
    ///
    /// It covers moves and runs alike. Source: hoot, sections 2.1 and 4.3; safety decision 6.
    #[derive(Default)]
    pub struct SetManualMove in BE {
        /// Whether they do.
        manual_move: Bool,
    }

    /// Set the delay of the auxiliary output before a picture. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetOutBeforeDelay in BE {
        /// How long; no sign, though the sheet says Int.
        delay: ShortMilliseconds,
    }

    /// Set the delay of the auxiliary output after a picture. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetOutAfterDelay in BE {
        /// How long.
        delay: ShortMilliseconds,
    }

    /// Set how long the auxiliary output is on before a picture. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetOutBeforeTime in BE {
        /// How long.
        time: ShortMilliseconds,
    }

    /// Set how long the auxiliary output is on after a picture. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetOutAfterTime in BE {
        /// How long.
        time: ShortMilliseconds,
    }

    /// Set the level at which the auxiliary output is on. The node refuses what is no level. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetOutLevel in BE {
        /// The level.
        level: Level,
    }

    /// Set after how long the planned move is stopped.
    ///
    /// Source: hoot, section 2.1; safety decision 3.
    #[derive(Default)]
    pub struct SetMaxRunTime in BE {
        /// How long, 0 for no limit. No more than 16,777,215 arrives: 16,777,216 would switch the limit off.
        max_run_time: Milliseconds,
    }

    /// Set how long the planned move waits after it is started.
    ///
    /// Source: hoot, sections 2.1 and 7; safety decision 3.
    #[derive(Default)]
    pub struct SetStartDelay in BE {
        /// How long: seconds, or milliseconds since 2015-07-20. Firmware that takes seconds makes milliseconds of 32 bits
        /// of them, so that 4,294,968 s is next to nothing.
        start_delay: StartDelay,
    }

    /// Set what kind of program the planned move is. The node takes any number. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetProgramMode in BE {
        /// Which kind.
        program_mode: ProgramMode,
    }

    /// Set joystick mode, in which a node does only what a joystick needs and refuses all else.
    ///
    /// Source: hoot, sections 2.1 and 4.1.
    #[derive(Default)]
    pub struct SetJoystickMode in BE {
        /// Whether it is on.
        joystick_mode: Bool,
    }

    /// Set whether the planned move goes to and fro until it is stopped.
    ///
    /// The sheet prints it without data, as a toggle; firmware reads a byte, and takes a missing one for a no. Source:
    /// hoot, sections 2.1 and 3.
    #[derive(Default)]
    pub struct SetPingPong in BE {
        /// Whether it does.
        ping_pong: Bool,
    }
}

/// Conduct by the purpose of the contacts: a contact that starts something arms the node.
///
/// An operator, or a machine at the contact, may start the program from then on.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "tables call it with a reference")]
pub(super) const fn alt_modes(set: &SetAltModes) -> Conduct {
    const fn starts(mode: AltMode) -> bool {
        matches!(mode, AltMode::START | AltMode::TOGGLE | AltMode::EXTERNAL_INTERVALOMETER | AltMode::REVERSE_DIRECTION)
    }
    Conduct::new(if starts(set.ring) || starts(set.tip) { Purpose::Arms } else { Purpose::Sets }).once()
}

impl SetAddress {
    /// Take this address; `None` unless it is 2 to 255.
    #[must_use]
    pub const fn new(new_address: Address) -> Option<Self> {
        if new_address.is_node() { Some(Self { new_address }) } else { None }
    }
}

bounded! {
    SetMaxRunTime(max_run_time: Milliseconds);
    SetStartDelay(start_delay: StartDelay);
}
