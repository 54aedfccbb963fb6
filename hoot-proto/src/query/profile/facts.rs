//! Facts about the firmware, with the time at which each changed.

use super::{Age, Profile};
use crate::frame::{Selector, Table};
use crate::message::{Microstep, Motor, ValueType};

/// Unit of the delay before the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DelayUnit {
    /// Seconds, until 2015-07-20.
    Seconds,
    /// Milliseconds.
    Milliseconds,
}

/// Makes the questions of the table of facts: whether a fact holds for the firmware of a profile. `since` is the first build
/// for which it holds, `until` the first for which it does not hold any more. A second time may follow after `or`.
macro_rules! facts {
    ($($(#[$doc:meta])* $name:ident: $since:expr, $until:expr $(, or $again:expr, $end:expr)?;)*) => {
        /// Facts about the firmware. An answer is `None` if the fact is true for only a part of the builds that the profile
        /// stands for.
        impl Profile {
            $($(#[$doc])*
            #[must_use]
            pub const fn $name(self) -> Option<bool> {
                let holds = self.is_within($since, $until);
                $(let holds = either(holds, self.is_within($again, $end));)?
                holds
            })*
        }
    };
}

/// Whether one of two facts holds for all builds.
const fn either(one: Option<bool>, other: Option<bool>) -> Option<bool> {
    match (one, other) {
        (Some(true), _) | (_, Some(true)) => Some(true),
        (Some(false), Some(false)) => Some(false),
        _ => None,
    }
}

const ALWAYS: Age = Age::FIRST;
const NEVER: Age = Age::version(u8::MAX);

const fn day(month: u8, day: u8) -> Age {
    Age::day(2014, month, day)
}

const fn v(version: u8) -> Age {
    Age::version(version)
}

/// Days since which queries are answered that earlier firmware refuses.
pub(super) const JOYSTICK_QUERY: Age = day(10, 28);
pub(super) const PING_PONG_QUERY: Age = day(11, 3);
pub(super) const SLEEP_QUERY: Age = day(12, 3);

facts! {
    /// Whether hundredths under the type `FLOAT` are right; later they are garbage (safety decision 7).
    float_is_true: ALWAYS, day(10, 7);
    /// Whether the firmware says by a `BYTE` whether a motor moves; earlier it was an `INT`.
    has_true_bytes: day(10, 29), NEVER;
    /// Whether the speed of runs may be negative; earlier firmware ignores such speeds.
    takes_negative_speeds: day(10, 30), NEVER;
    /// Whether the firmware takes its greatest speed for a speed of runs above it; earlier firmware ignores such speeds.
    caps_speeds: v(37), NEVER;
    /// Whether the query for the speed of runs asks for the speed of the moment; earlier it asks for the setting.
    answers_momentary_speed: day(10, 28), NEVER;
    /// Whether a second packet follows the answer to the query whether a motor moves.
    answers_running_twice: ALWAYS, day(10, 29);
    /// Whether a photo on command has the exposure that was set. Earlier firmware takes the exposure from the command, which has
    /// none, and takes no photo.
    exposes_on_command: day(10, 17), NEVER;
    /// Whether the firmware has video mode; earlier, every mode except 0 is mode 1.
    has_video_mode: day(10, 24), NEVER;
    /// Whether the firmware ignores values of ping-pong other than 0 and 1.
    ignores_wrong_ping_pong: v(24), NEVER;
    /// Whether the firmware has joystick mode, ping-pong, and the query for joystick mode.
    has_joystick_mode: JOYSTICK_QUERY, NEVER;
    /// Whether the firmware answers the query whether the planned move goes to and fro.
    has_ping_pong_query: PING_PONG_QUERY, NEVER;
    /// Whether the answer to the query for the lead-in has 32 bits.
    answers_long_lead_in: day(11, 5), NEVER;
    /// Whether run status 1 means that the program is paused; earlier it means that the program runs.
    one_is_paused: day(12, 3), NEVER;
    /// Whether the speed of runs is not answered in joystick mode.
    is_silent_at_speed: day(12, 3), NEVER;
    /// Whether query 117 of a motor asks whether the motor has no current while it rests; earlier firmware refuses it.
    has_sleep_query: SLEEP_QUERY, NEVER;
    /// Whether a program with a camera takes one photo more than the greatest number of photos, so that the last one is taken
    /// at the end of the move.
    takes_one_more: day(12, 12), NEVER;
    /// Whether a start opens the shutter in video mode, with and without a camera.
    shoots_at_start: day(12, 3), NEVER;
    /// Whether the end of a program opens the shutter in video mode, with and without a camera.
    shoots_at_end: Age::day(2015, 1, 5), NEVER;
    /// Whether a time lapse ends with its motors, also if photos are left.
    ends_with_motors: v(25), NEVER;
    /// Whether no motor begins a video before as many photos as motor 1 has milliseconds of lead-in.
    leads_in_videos_by_photos: day(11, 7), v(25);
    /// Whether a time lapse counts the least lead-in of all enabled motors in photos, and the lead-in of each motor in
    /// milliseconds; earlier all are in photos.
    leads_in_lapses_by_time: v(25), NEVER;
    /// Whether a time lapse goes on after the greatest number of photos.
    outlasts_photos: v(41), NEVER;
    /// Whether a start in the modes without stops sends the motors whose planned move has no travel; later such a program never
    /// ends. It was seen to send them with v0.33, and never to end with v0.45.
    sends_without_travel: ALWAYS, v(45);
    /// Whether the firmware does not answer unknown commands; earlier firmware refuses them.
    is_silent: day(12, 22), NEVER;
    /// Whether the version of the firmware is a `ULONG`; earlier it is a `BYTE`, and 6.
    has_long_version: Age::day(2015, 1, 5), NEVER;
    /// Whether commands 12, 23 and 24 of a motor, and 11 where it moves, go at 5,000 steps per second or the motor's greatest
    /// speed, and overwrite the speed of runs.
    sends_at_full_speed: day(11, 3), NEVER;
    /// Whether these commands switch the motor to quarter steps.
    sends_in_quarter_steps: day(11, 17), v(45), or v(60), NEVER;
    /// Whether the microsteps from before such a command are set again when the motor rests.
    restores_microsteps: v(60), NEVER;
    /// Whether the firmware acknowledges command 11 of a motor and does nothing.
    ignores_home: v(20), v(41);
    /// Whether the greatest speed of a motor limits commands 11, 12, 23 and 24; earlier it limits nothing.
    max_speed_limits: v(70), NEVER;
    /// Whether a start chooses the microsteps of all motors.
    start_sets_microsteps: day(12, 3), v(45), or v(47), NEVER;
    /// Whether the start of a video cuts the places of all motors to whole steps. It was seen with v0.70, and not with v0.33.
    cuts_places: v(70), NEVER;
    /// Whether the end limit and the home stop motors; later the end limit is kept and stops nothing.
    holds_limits: ALWAYS, v(49);
    /// Whether joystick mode sets all speeds to 0, and the speed of runs sets motors in motion in it.
    joystick_moves: day(11, 3), NEVER;
    /// Whether the end of joystick mode switches the dead-man off.
    joystick_ends_dead_man: day(12, 3), NEVER;
    /// Whether a program that was stopped or is over still answers its last run time.
    keeps_run_time: day(12, 3), NEVER;
    /// Whether motors go on after a pause in the modes without stops.
    resumes_moves: day(12, 15), NEVER;
    /// Whether a node does nothing else for 1.5 s before it starts a program.
    start_blocks: v(20), NEVER;
    /// Whether commands 25 and 26 of a motor are single steps; later, 25 sets the lead-out.
    has_steps: ALWAYS, v(25);
    /// Whether hundredths are under the type `ULONG`; earlier they are under `FLOAT`.
    has_long_hundredths: v(33), NEVER;
    /// Whether the command that sets the lead-in has 32 bits; earlier it has 16.
    reads_long_lead_in: v(35), NEVER;
    /// Whether a lead-in above 65,535 loses its upper half.
    cuts_lead_in: v(40), NEVER;
    /// Whether the delay before the start is in seconds. Version 0.40 was built both ways.
    delays_seconds: ALWAYS, v(40);
    /// Whether the delay before the start is in milliseconds. Version 0.40 was built both ways.
    delays_milliseconds: v(41), NEVER;
    /// Whether the greatest number of pictures is answered as `UINT`; earlier it is a `ULONG`.
    has_short_max_shots: v(45), NEVER;
    /// Whether the greatest step rate of all motors can be set and asked for.
    has_max_step_rate: ALWAYS, v(70);
}

/// Types of answers. If the profile stands for several builds, the type is that of one of them.
impl Profile {
    const fn later_or(is_later: Option<bool>, later: ValueType, earlier: ValueType) -> ValueType {
        if matches!(is_later, Some(true)) { later } else { earlier }
    }

    /// Type of hundredths: of voltage, current, speed and acceleration.
    #[must_use]
    pub const fn hundredths(self) -> ValueType {
        Self::later_or(self.usual().has_long_hundredths(), ValueType::ULONG, ValueType::FLOAT)
    }

    /// Type of the answer whether a motor moves.
    #[must_use]
    pub const fn motor_running(self) -> ValueType {
        Self::later_or(self.usual().has_true_bytes(), ValueType::BYTE, ValueType::INT)
    }

    /// Type of the version of the firmware.
    #[must_use]
    pub const fn version_type(self) -> ValueType {
        Self::later_or(self.usual().has_long_version(), ValueType::ULONG, ValueType::BYTE)
    }

    /// Type of the answer to the query for the lead-in.
    #[must_use]
    pub const fn lead_in(self) -> ValueType {
        Self::later_or(self.usual().answers_long_lead_in(), ValueType::ULONG, ValueType::UINT)
    }

    /// Type of the answer to the query for the greatest number of pictures.
    #[must_use]
    pub const fn max_shots(self) -> ValueType {
        Self::later_or(self.usual().has_short_max_shots(), ValueType::UINT, ValueType::ULONG)
    }

    /// Type of the answer to query 117 of a motor, which firmware before 2014-12-03 refuses.
    #[must_use]
    pub const fn query_117(self) -> ValueType {
        Self::later_or(self.usual().has_sleep_query(), ValueType::BYTE, ValueType::FLOAT)
    }

    /// Unit of the delay before the start, if it is known.
    #[must_use]
    pub const fn start_delay(self) -> Option<DelayUnit> {
        match (self.delays_seconds(), self.delays_milliseconds()) {
            (Some(true), _) => Some(DelayUnit::Seconds),
            (_, Some(true)) => Some(DelayUnit::Milliseconds),
            _ => None,
        }
    }
}

/// Settings of a new node.
impl Profile {
    const fn choose<T: Copy>(self, until: Age, before: T, after: T) -> T {
        if matches!(self.usual().is_within(ALWAYS, until), Some(true)) { before } else { after }
    }

    /// Speed of runs of a new node, in steps per second.
    pub(crate) const fn first_speed(self) -> f32 {
        self.choose(day(10, 27), 1500.0, self.choose(day(11, 17), 1000.0, 5000.0))
    }

    /// Acceleration of runs of a new node, in steps per second squared.
    pub(crate) const fn first_acceleration(self) -> f32 {
        self.choose(day(10, 20), 1000.0, 15_000.0)
    }

    /// Backlash of a new node, in microsteps.
    pub(crate) const fn first_backlash(self) -> u16 {
        self.choose(day(12, 16), 384, 0)
    }

    /// Greatest speed of a motor of a new node, in steps per second.
    pub(crate) const fn first_max_speed(self) -> u16 {
        self.choose(v(70), 1000, 5000)
    }

    /// Whether the motors of a new node have no current while they rest.
    pub(crate) const fn first_sleep(self) -> bool {
        self.choose(v(23), true, false)
    }

    /// Number of microsteps in a step of a motor of a new node.
    #[must_use]
    pub const fn first_microstep(self, motor: Motor) -> Microstep {
        match motor {
            Motor::One => Microstep::QUARTER,
            Motor::Two | Motor::Three => self.choose(v(23), Microstep::QUARTER, Microstep::SIXTEENTH),
        }
    }

    /// Whether the motors of a new node are enabled.
    pub(crate) const fn first_enable(self) -> bool {
        self.choose(v(45), false, true)
    }

    /// Whether a new node holds the focus together with the shutter.
    pub(crate) const fn first_focus_with_shutter(self) -> bool {
        self.choose(day(11, 3), false, true)
    }
}

/// Commands that joystick mode leaves. Source: hoot, sections 4.1 and 7.
impl Profile {
    /// Whether a node refuses a command in joystick mode; `None` if it is not known. Broadcasts, the core protocol and the
    /// camera are never refused.
    #[must_use]
    pub const fn refuses_in_joystick_mode(self, Selector { table, command, sub_address }: Selector) -> Option<bool> {
        let leaves = match (table, sub_address, command) {
            (Table::Node, 0, 0 | 1 | 23 | 120) | (Table::Node, 1..=3, 0 | 1 | 3 | 4 | 6 | 13) => Some(true),
            (Table::Node, 0, 14 | 122) => self.is_within(day(12, 3), NEVER),
            (Table::Node, 0, 50 | 51) => self.is_within(v(37), NEVER),
            (Table::Node, 0, 200) | (Table::Node, 1..=3, 107) => self.is_within(v(41), NEVER),
            (Table::Node, 1..=3, 15) => self.is_within(ALWAYS, v(33)),
            (Table::Node, 1..=3, 106) => self.is_within(v(40), NEVER),
            (Table::Node, 0..=3, 100..) => self.is_within(v(54), NEVER),
            (Table::Node, 0..=3, _) => Some(false),
            _ => Some(true),
        };
        match leaves {
            Some(leaves) => Some(!leaves),
            None => None,
        }
    }
}
