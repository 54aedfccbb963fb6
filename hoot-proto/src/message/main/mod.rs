//! Commands to the controller of a node: sub-address 0.
//!
//! Firmware acknowledges all of them, and ignores many values that it acknowledges. The ranges here are those that it
//! acts on.

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
    /// Starts or resumes the planned move.
    ///
    /// Never repeat it by yourself: a repetition after the stop of an operator would move the rig. From v0.20 on, the node
    /// hears nothing for 1.5 s, and hangs if two packets wait then: send one [`Stop`] at most before the answer, which may
    /// take 3 s. Source: hoot, section 2.1; safety decision 1; decision H-41.
    #[derive(Default)]
    pub struct Start in BE {}

    /// Pauses the planned move. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct Pause in BE {}

    /// Stops everything and resets the planned move: run time and shots count from 0 again.
    ///
    /// Firmware refuses it in joystick mode. In an emergency, first stop each motor with
    /// [`MotorStop`](super::MotorStop). Source: hoot, section 2.1; safety decision 2.
    #[derive(Default)]
    pub struct Stop in BE {}

    /// Switches the lamp for debugging on, or off if it is on. Never repeat it by yourself. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct ToggleDebugLed in BE {}

    /// Makes the node give the time to the others, or wait for the common line.
    ///
    /// The sheet prints it without data. Firmware reads a byte, and reads a missing byte as no. Source: hoot, sections
    /// 2.1 and 3.
    #[derive(Default)]
    pub struct SetTimingMaster in BE {
        /// Whether the node gives the time to the others.
        timing_master: Bool,
    }

    /// Gives the node another address.
    ///
    /// Never repeat it by yourself: ask at the new address instead. Afterwards the node receives nothing for 1 to
    /// 2.5 s, and hangs if two packets wait then; its USB port keeps the old address until the node is restarted. Source:
    /// hoot, sections 2.1 and 2.5; safety decisions 1 and 5.
    #[derive(Default)]
    pub struct SetAddress in BE {
        /// New address, 2 to 255. Nodes refuse 0 and 1.
        new_address: Address,
    }

    /// Sets the line on which nodes step in common. An unknown line is answered twice: an error, then OK.
    ///
    /// Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetCommonLine in BE {
        /// Line.
        common_line: CommonLine,
    }

    /// Sends all motors home. Never repeat it by yourself. Source: hoot, section 2.1; safety decision 1.
    #[derive(Default)]
    pub struct ReturnHome in BE {}

    /// Sets the greatest step rate of all motors. v0.70 does not have it.
    ///
    /// The sheet calls the number an Int, but it has no sign. Source: hoot, sections 2.1 and 3.
    #[derive(Default)]
    pub struct SetMaxStepRate in BE {
        /// 1000, 2000, 4000, 5000 or 10,000. The node acknowledges and ignores others.
        max_step_rate: StepRate,
    }

    /// Sets which edge of the auxiliary input counts. The node acknowledges and ignores unknown edges.
    ///
    /// Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetInputEdge in BE {
        /// Edge. The answer to the query has another number: [`EdgeFound`](super::EdgeFound).
        edge: Edge,
    }

    /// Sets the purposes of the two contacts of the auxiliary connector. The data is two bytes; the sheet says an Int.
    ///
    /// Source: hoot, sections 2.1 and 3.
    #[derive(Default)]
    pub struct SetAltModes in BE {
        /// Purpose of the ring.
        ring: AltMode,
        /// Purpose of the tip.
        tip: AltMode,
    }

    /// Sets whether motors stop after a second without a command: the dead-man of manual moves, which later firmware
    /// calls the joystick watchdog.
    ///
    /// The dead-man applies to moves and runs. Source: hoot, sections 2.1 and 4.3; safety decision 6.
    #[derive(Default)]
    pub struct SetManualMove in BE {
        /// Whether motors stop.
        manual_move: Bool,
    }

    /// Sets the delay of the auxiliary output before a picture. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetOutBeforeDelay in BE {
        /// Time, without sign, although the sheet says Int.
        delay: ShortMilliseconds,
    }

    /// Sets the delay of the auxiliary output after a picture. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetOutAfterDelay in BE {
        /// Time.
        delay: ShortMilliseconds,
    }

    /// Sets how long the auxiliary output is on before a picture. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetOutBeforeTime in BE {
        /// Time.
        time: ShortMilliseconds,
    }

    /// Sets how long the auxiliary output is on after a picture. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetOutAfterTime in BE {
        /// Time.
        time: ShortMilliseconds,
    }

    /// Sets the level at which the auxiliary output is on. The node refuses unknown levels. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetOutLevel in BE {
        /// Level.
        level: Level,
    }

    /// Sets the time after which the planned move is stopped.
    ///
    /// Source: hoot, section 2.1; safety decision 3.
    #[derive(Default)]
    pub struct SetMaxRunTime in BE {
        /// Time; 0 for no limit. At most 16,777,215 ms arrive: 16,777,216 would switch the limit off.
        max_run_time: Milliseconds,
    }

    /// Sets the delay from the command to the start of the planned move.
    ///
    /// Source: hoot, sections 2.1 and 7; safety decision 3.
    #[derive(Default)]
    pub struct SetStartDelay in BE {
        /// Delay in seconds, or in milliseconds since 2015-07-20. Firmware that takes seconds converts them to
        /// milliseconds in 32 bits, so 4,294,968 s becomes less than a second.
        start_delay: StartDelay,
    }

    /// Sets the mode of the planned move. The node accepts any number. Source: hoot, section 2.1.
    #[derive(Default)]
    pub struct SetProgramMode in BE {
        /// Mode.
        program_mode: ProgramMode,
    }

    /// Sets joystick mode, in which a node accepts only the commands that a joystick needs.
    ///
    /// Firmware since 2014-11-03 sets the speeds of all motors to 0 when the mode begins, so what moves stops; in the mode, a
    /// [`MotorSetContinuousSpeed`](super::MotorSetContinuousSpeed) sets its motor in motion. Source: hoot, sections 2.1 and
    /// 4.1; decision H-46.
    #[derive(Default)]
    pub struct SetJoystickMode in BE {
        /// Whether joystick mode is on.
        joystick_mode: Bool,
    }

    /// Sets whether the planned move goes to and fro until it is stopped.
    ///
    /// The sheet prints it without data, as a toggle. Firmware reads a byte, and reads a missing byte as no. Source:
    /// hoot, sections 2.1 and 3.
    #[derive(Default)]
    pub struct SetPingPong in BE {
        /// Whether the move goes to and fro.
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
    /// Makes the message; `None` unless the address is 2 to 255.
    #[must_use]
    pub const fn new(new_address: Address) -> Option<Self> {
        if new_address.is_node() { Some(Self { new_address }) } else { None }
    }
}

bounded! {
    SetMaxRunTime(max_run_time: Milliseconds);
    SetStartDelay(start_delay: StartDelay);
}
