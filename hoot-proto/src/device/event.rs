//! Events of a node: what the rig has to do, and what it is told.

use motion_core::{display, states};

use crate::frame::Address;
use crate::message::{Direction, Microstep, Motor, StepCount, Steps, StepsPerSecond};
use crate::program::Plan;

use super::{LazyMessage, Port};

states! {
    /// State of the planned move. Source: hoot, section 4.2.
    #[derive(Default)]
    pub enum ProgramState {
        /// The planned move does not run, and begins anew when it is started.
        #[default]
        Stopped,
        /// The planned move was started, and the delay before the start is not over.
        Delay,
        /// The planned move runs.
        Running,
        /// The planned move does not run, and goes on when it is started.
        Paused,
    }
}

/// Something that the rig has to do, or is told. The order counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Event<'a> {
    /// A motor has to do something.
    Motor {
        /// The motor.
        motor: Motor,
        /// Motion of the motor.
        motion: Motion,
    },
    /// The lines of the camera have to be in this state.
    Camera {
        /// Whether the focus is held.
        focus: bool,
        /// Whether the shutter is held.
        shutter: bool,
    },
    /// The auxiliary output has to be switched. [`Controller::out_level`](super::Controller::out_level) is its level when it
    /// is on.
    AltOut {
        /// Whether the output is on.
        on: bool,
    },
    /// The other nodes have to be told by the common line that the next picture comes.
    CommonLine,
    /// The lamp for debugging has to be switched on, or off if it is on.
    DebugLed,
    /// The planned move has a new state.
    Program(ProgramState),
    /// A setting was written. The machine holds the new settings, which may be worth storing for the next power-up.
    Set(Part),
    /// The node has a new address. Its USB port keeps the old address until power-up (hoot, section 2.5).
    Address(Address),
    /// A packet arrived that is not answered.
    Ignored {
        /// Port on which it arrived.
        port: Port,
        /// Address of the receiver.
        to: Address,
        /// The message.
        message: LazyMessage<'a>,
        /// Why it is not answered.
        why: Ignored,
    },
    /// Bytes arrived that are no packet, and are not answered.
    Noise,
}

impl Event<'_> {
    /// Returns the same event if it can be kept; `None` if it lends a message.
    #[must_use]
    pub const fn to_static(&self) -> Option<Event<'static>> {
        Some(match *self {
            Self::Ignored { .. } => return None,
            Self::Motor { motor, motion } => Event::Motor { motor, motion },
            Self::Camera { focus, shutter } => Event::Camera { focus, shutter },
            Self::AltOut { on } => Event::AltOut { on },
            Self::CommonLine => Event::CommonLine,
            Self::DebugLed => Event::DebugLed,
            Self::Program(state) => Event::Program(state),
            Self::Set(part) => Event::Set(part),
            Self::Address(address) => Event::Address(address),
            Self::Noise => Event::Noise,
        })
    }
}

/// Motion that a motor has to make.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Motion {
    /// Stop at once. From now on the node says that the motor rests.
    Stop,
    /// Move by a number of steps, at the speed of [`MotorSettings::speed`](super::MotorSettings::speed).
    By {
        /// Direction of the move.
        direction: Direction,
        /// Length of the move.
        steps: StepCount,
    },
    /// Move to a position, also while the motor moves to another one.
    To(Steps),
    /// Run until the next motion.
    Run {
        /// Direction, as the command said.
        direction: Direction,
        /// Speed; a negative speed reverses the direction.
        speed: StepsPerSecond,
    },
    /// Go on running at another speed, with the acceleration that was set; another sign reverses the direction.
    Speed(StepsPerSecond),
    /// Follow a plan in milliseconds.
    Along {
        /// The plan; [`Plan::at`] gives the position at each time.
        plan: Plan,
        /// Time of the plan that is over already, in milliseconds.
        elapsed: u32,
    },
    /// Count positions in other microsteps from now on; the motor rests.
    Microstep(Microstep),
    /// Subtract a number of steps from all positions of the motor, so that the target of a move keeps its place on the rig.
    Rebase {
        /// Number of steps.
        by: Steps,
    },
    /// Give the motor current, or take the current away while the motor rests.
    Power(bool),
}

/// Part of a node that has settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
pub enum Part {
    /// The controller: [`DeviceMachine::controller`](super::DeviceMachine::controller) and the name.
    Controller,
    /// A motor: [`MotorUnit::settings`](super::MotorUnit::settings).
    Motor(Motor),
    /// The camera: [`CameraUnit::settings`](super::CameraUnit::settings).
    Camera,
}

/// Why a packet is not answered. Source: hoot, sections 1.1 and 4.1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Ignored {
    /// Command 0, for any receiver. A reply that refuses has the same header, so bridges drop such replies too.
    Noop,
    /// A broadcast that does not exist, or that gives an address that no node can have.
    Broadcast,
    /// A command that the node does not have; later firmware does not answer it.
    Unknown,
    /// A command that firmware carries out without an answer: the speed of runs in joystick mode.
    Silent,
}

display! {
    Event<'_> {
        Motor { motor, motion } => "motor {motor}: {motion}";
        Camera { focus: false, shutter: false } => "release focus and shutter";
        Camera { focus: true, shutter: false } => "hold the focus, release the shutter";
        Camera { focus: false, shutter: true } => "release the focus, hold the shutter";
        Camera { focus: true, shutter: true } => "hold focus and shutter";
        AltOut { on: false } => "switch the auxiliary output off";
        AltOut { on: true } => "switch the auxiliary output on";
        CommonLine => "tell the other nodes that the next picture comes";
        DebugLed => "switch the lamp for debugging";
        Program(state) => "the planned move has the state {state}";
        Set(part) => "a setting of {part} was written";
        Address(address) => "the node has the address {address}";
        Ignored { to, message, why, .. } => "{message} for address {to} is not answered: {why}";
        Noise => "bytes arrived that are no packet";
    }

    Motion {
        Stop => "stop at once";
        By { direction, steps } => "move by {steps} steps in direction {direction}";
        To(position) => "move to {position} steps";
        Run { direction, speed } => "run at {speed} steps/s in direction {direction}";
        Speed(speed) => "go on at {speed} steps/s";
        Along { elapsed, .. } => "follow a plan from {elapsed} ms on";
        Microstep(microstep) => "count in microsteps of {microstep}";
        Rebase { by } => "subtract {by} steps from all positions";
        Power(false) => "take the current away";
        Power(true) => "give the motor current";
    }

    Part {
        Controller => "the controller";
        Motor(motor) => "motor {motor}";
        Camera => "the camera";
    }

    Ignored {
        Noop => "command 0 is never answered";
        Broadcast => "there is no such broadcast";
        Unknown => "the node does not have the command";
        Silent => "the command is carried out without an answer";
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn an_event_prints_what_the_rig_has_to_do() {
        let motion = Motion::By { direction: Direction(1), steps: StepCount(5) };
        assert_eq!(Event::Motor { motor: Motor::Two, motion }.to_string(), "motor 2: move by 5 steps in direction 1");
        assert_eq!(Event::Camera { focus: true, shutter: false }.to_string(), "hold the focus, release the shutter");
        assert_eq!(Event::Set(Part::Motor(Motor::One)).to_string(), "a setting of motor 1 was written");
    }
}
