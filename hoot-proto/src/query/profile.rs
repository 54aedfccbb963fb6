//! Differences between firmware of different ages, as data.

use super::Answer;
use crate::frame::{Selector, Table};
use crate::message::{CommonLine, HostMessage, RunState, StartDelay, ValueType, Version};

/// Age of the firmware of a node, as far as commands and replies depend on it.
///
/// Source: hoot, sections 1.2, 2 and 7.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Profile {
    /// The firmware is not known. Values for it are written as by v0.33.
    #[default]
    Unknown,
    /// Firmware with the library of 2014-09-25, which the published sheet describes.
    Library20140925,
    /// Firmware of the sheet's date, 2014-10-28, whose version is 6.
    Sheet,
    /// Firmware of 2015-01-08 or later, before v0.33.
    January2015,
    /// Firmware v0.33 or v0.34, of 2015-04-07 or later.
    V033,
    /// Firmware v0.35 of 2015-04-21, or later, before v0.70.
    V035,
    /// Firmware v0.70 of 2016-08-10, or later.
    V070,
}

/// Behaviour of the firmware of a [`Profile`].
#[expect(clippy::struct_excessive_bools, reason = "each is a fact of its own")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Facts {
    /// Type of hundredths: of voltage, current, speed and acceleration.
    pub hundredths: ValueType,
    /// Whether hundredths under the type `FLOAT` are right; otherwise they are garbage (safety decision 7).
    pub float_is_true: bool,
    /// Type of two answers that are yes or no: whether a motor moves, and whether the mirror goes up first.
    pub promoted: ValueType,
    /// Type of the version of the firmware.
    pub version: ValueType,
    /// Type of the lead-in, in commands and answers.
    pub lead_in: ValueType,
    /// Type of the answer to query 117 of a motor, which firmware before 2014-12-03 refuses.
    pub query_117: ValueType,
    /// Unit of the delay before the start, if it is known.
    pub start_delay: Option<DelayUnit>,
    /// Whether run status 1 means that the program is paused, if it is known; otherwise it means that the program runs.
    pub one_is_paused: Option<bool>,
    /// Whether a second packet may follow the answer to the query whether a motor moves.
    pub answers_running_twice: bool,
    /// Whether the greatest step rate of all motors can be set and asked for.
    pub has_max_step_rate: bool,
    /// Whether the firmware answers the query whether the planned move goes to and fro.
    pub has_ping_pong_query: bool,
    /// Whether commands 25 and 26 of a motor are single steps, if it is known; since 2015-02, 25 sets the lead-out.
    pub has_steps: Option<bool>,
    /// Commands that joystick mode leaves, if they are known.
    pub gate: Option<Gate>,
    /// Whether the firmware does not answer unknown commands, if it is known; otherwise it refuses them.
    pub is_silent: Option<bool>,
}

/// Unit of the delay before the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DelayUnit {
    /// Seconds, until 2015-07-20.
    Seconds,
    /// Milliseconds.
    Milliseconds,
}

/// Commands that a node refuses in joystick mode. Source: hoot, sections 4.1 and 7.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Gate {
    /// All commands except 23 and 120 of the controller, and 3, 4, 6, 13 and 15 of the motors.
    Sheet,
    /// All commands below 100 except 14, 23, 50 and 51 of the controller, and 3, 4, 6 and 13 of the motors.
    Later,
}

impl Gate {
    /// Whether the node refuses a command. Broadcasts, the core protocol and the camera are never refused.
    #[must_use]
    pub const fn refuses(self, Selector { table, command, sub_address }: Selector) -> bool {
        let leaves = match (self, table, sub_address) {
            (Self::Sheet, Table::Node, 0) => matches!(command, 0 | 1 | 23 | 120),
            (Self::Sheet, Table::Node, 1..=3) => matches!(command, 0 | 1 | 3 | 4 | 6 | 13 | 15),
            (Self::Later, Table::Node, 0) => matches!(command, 0 | 1 | 14 | 23 | 50 | 51 | 100..),
            (Self::Later, Table::Node, 1..=3) => matches!(command, 0 | 1 | 3 | 4 | 6 | 13 | 100..),
            _ => true,
        };
        !leaves
    }
}

const SHEET: Facts = Facts {
    hundredths: ValueType::FLOAT,
    float_is_true: false,
    promoted: ValueType::BYTE,
    version: ValueType::BYTE,
    lead_in: ValueType::UINT,
    query_117: ValueType::FLOAT,
    start_delay: Some(DelayUnit::Seconds),
    one_is_paused: Some(false),
    answers_running_twice: true,
    has_max_step_rate: true,
    has_ping_pong_query: false,
    has_steps: Some(true),
    gate: Some(Gate::Sheet),
    is_silent: Some(false),
};

const LIBRARY_2014_09_25: Facts = Facts { float_is_true: true, promoted: ValueType::INT, ..SHEET };

const JANUARY_2015: Facts = Facts {
    version: ValueType::ULONG,
    query_117: ValueType::BYTE,
    one_is_paused: Some(true),
    answers_running_twice: false,
    has_ping_pong_query: true,
    has_steps: None,
    gate: None,
    is_silent: Some(true),
    ..SHEET
};

const V033: Facts = Facts { hundredths: ValueType::ULONG, has_steps: Some(false), ..JANUARY_2015 };

/// The unit of the delay changed between v0.35 and v0.70.
const V035: Facts = Facts { lead_in: ValueType::ULONG, start_delay: None, ..V033 };

const V070: Facts =
    Facts { start_delay: Some(DelayUnit::Milliseconds), has_max_step_rate: false, gate: Some(Gate::Later), ..V035 };

const UNKNOWN: Facts = Facts {
    start_delay: None,
    one_is_paused: None,
    answers_running_twice: true,
    has_steps: None,
    is_silent: None,
    ..V033
};

impl Profile {
    /// Behaviour of this firmware.
    #[must_use]
    pub const fn facts(self) -> &'static Facts {
        match self {
            Self::Unknown => &UNKNOWN,
            Self::Library20140925 => &LIBRARY_2014_09_25,
            Self::Sheet => &SHEET,
            Self::January2015 => &JANUARY_2015,
            Self::V033 => &V033,
            Self::V035 => &V035,
            Self::V070 => &V070,
        }
    }

    /// Profile of firmware that answers this version, as far as the version tells it.
    #[must_use]
    pub fn of_version(version: &Answer<Version>) -> Self {
        match (version.value_type(), version.value.0) {
            (ValueType::BYTE, 6) => Self::Sheet,
            (ValueType::BYTE, _) => Self::Unknown,
            (_, ..=32) => Self::January2015,
            (_, 33 | 34) => Self::V033,
            (_, 35..=69) => Self::V035,
            (_, 70..) => Self::V070,
        }
    }

    /// Greatest number of packets that answer a request.
    ///
    /// No packet answers a broadcast or command 0. Two packets answer requests that firmware refuses and then
    /// acknowledges nevertheless.
    #[must_use]
    pub fn packets(self, request: &HostMessage<'_>) -> u8 {
        match request {
            HostMessage::Noop(_)
            | HostMessage::BroadcastStart(_)
            | HostMessage::BroadcastStop(_)
            | HostMessage::BroadcastPause(_)
            | HostMessage::BroadcastAssignAddress(_) => 0,
            HostMessage::SetCommonLine(message) if message.common_line > CommonLine::SECOND => 2,
            HostMessage::MotorSetEasing(message) if message.easing.name().is_none() => 2,
            HostMessage::MotorRunning(_) if self.facts().answers_running_twice => 2,
            _ => 1,
        }
    }
}

impl RunState {
    /// Whether the program runs, or waits for its start; `None` if it is not known.
    ///
    /// The sheet's firmware answers 0 both for stopped and for paused.
    #[must_use]
    pub fn is_running(self, profile: Profile) -> Option<bool> {
        match self {
            Self::STOPPED => Some(false),
            Self::RUNNING_OR_PAUSED => profile.facts().one_is_paused.map(|paused| !paused),
            Self::RUNNING | Self::DELAY | Self::STILL_SHOOTING | Self::PING_PONG => Some(true),
            _ => None,
        }
    }
}

impl StartDelay {
    /// Delay in milliseconds; `None` if the unit of the firmware is not known.
    #[must_use]
    pub fn milliseconds(self, profile: Profile) -> Option<u64> {
        let delay = u64::from(self.0);
        match profile.facts().start_delay? {
            DelayUnit::Seconds => Some(delay.saturating_mul(1000)),
            DelayUnit::Milliseconds => Some(delay),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::{
        Easing, FirmwareVersion, Motor, MotorRunning, MotorSetEasing, Noop, Reply, ResponseCode, SetCommonLine, Stop,
    };
    use crate::query::Query;

    #[test]
    fn a_version_tells_the_profile() {
        let of = |data: &[u8]| {
            let reply = Reply { code: ResponseCode::OK, data };
            Profile::of_version(&FirmwareVersion {}.decode_reply(reply).unwrap())
        };
        assert_eq!(of(&[0, 6]), Profile::Sheet);
        assert_eq!(of(&[0, 70]), Profile::Unknown, "a byte, so it is not v0.70");
        let long = [6, 32, 33, 34, 35, 69, 70, 71].map(|version| of(&[4, 0, 0, 0, version]));
        assert_eq!(long[..3], [Profile::January2015, Profile::January2015, Profile::V033]);
        assert_eq!(long[3..], [Profile::V033, Profile::V035, Profile::V035, Profile::V070, Profile::V070]);
        assert_eq!(of(&[4, 1, 0, 0, 0]), Profile::V070);
    }

    #[test]
    fn the_meaning_of_a_number_is_told_if_it_is_known() {
        let running = |state: u8| {
            [Profile::Unknown, Profile::Sheet, Profile::V033].map(|profile| RunState(state).is_running(profile))
        };
        assert_eq!(running(0), [Some(false); 3]);
        assert_eq!(running(1), [None, Some(true), Some(false)]);
        assert_eq!((running(2), running(6)), ([Some(true); 3], [None; 3]));

        let delay = |profile| StartDelay(u32::MAX).milliseconds(profile);
        assert_eq!([Profile::Unknown, Profile::V035].map(delay), [None, None]);
        assert_eq!(delay(Profile::V033), Some(4_294_967_295_000));
        assert_eq!(delay(Profile::V070), Some(4_294_967_295));
    }

    #[test]
    fn some_requests_are_answered_twice_and_some_not_at_all() {
        let motor = Motor::One;
        let line = |line| HostMessage::from(SetCommonLine { common_line: CommonLine(line) });
        let easing = |easing| HostMessage::from(MotorSetEasing { motor, easing: Easing(easing) });
        let of = |message: &HostMessage<'_>| Profile::Sheet.packets(message);
        assert_eq!([0, 2, 3, 255].map(|number| of(&line(number))), [1, 1, 2, 2]);
        assert_eq!([0, 1, 3, 4].map(|number| of(&easing(number))), [2, 1, 1, 2]);
        assert_eq!(of(&HostMessage::from(Noop::default())), 0);
        assert_eq!(of(&HostMessage::from(Stop {})), 1);
        let running = HostMessage::from(MotorRunning { motor });
        assert_eq!((of(&running), Profile::V033.packets(&running)), (2, 1));
    }
}
