//! The conduct of every message, stated a second time, from the safety decisions of the specification and not from the
//! tables: what moves, what stops, what may be repeated.
//!
//! Each name stands in one list. So a row whose conduct is deleted or changed makes a test fail.

use std::collections::BTreeMap;

use hoot_proto::message::*;
use hoot_proto::{Conduct, HostMessage, Messages, Purpose};

/// Names by conduct, from lists of names; `1-3:4` are commands as the safety decisions count them.
fn stated(groups: &[(Conduct, &str)]) -> BTreeMap<&'static str, String> {
    let mut found = BTreeMap::new();
    for (conduct, names) in groups {
        for name in names.split_whitespace() {
            let name: &'static str = name.to_string().leak();
            assert_eq!(found.insert(name, conduct.to_string()), None, "{name} stands in one list");
        }
    }
    found
}

/// Names by conduct, as the rows of a table state it.
fn of_table<'a, M: Messages<'a>>() -> BTreeMap<&'static str, String> {
    M::ALL
        .iter()
        .map(|kind| (kind.name, kind.conduct.map_or("by its values".into(), |conduct| conduct.to_string())))
        .collect()
}

const ASKS: Conduct = Conduct::new(Purpose::Asks);
const SETS_ONCE: Conduct = Conduct::new(Purpose::Sets).once();
const MOVES_ONCE: Conduct = Conduct::new(Purpose::Moves).once();
const STOPS: Conduct = Conduct::new(Purpose::Stops);
const RESETS_ONCE: Conduct = Conduct::new(Purpose::Resets).once().blocks(3000);

/// Safety decision 1: a master repeats by itself only stops and queries, and no query that changes something. Everything
/// that starts or redirects motion is named there.
#[test]
fn every_row_has_the_conduct_of_the_safety_decisions() {
    let mut wanted = stated(&[
        // 0:10, 1-3:11 to 15, 23 to 26.
        (
            MOVES_ONCE,
            "ReturnHome MotorSendHome MotorSendToEnd MotorSetContinuousAcceleration MotorMove MotorRun
             MotorSendToStart MotorSendToStop MotorStepForward MotorStepBack",
        ),
        // 0:2 and broadcast 1, during which a node hears nothing (decision H-41).
        (MOVES_ONCE.blocks(3000), "Start BroadcastStart"),
        // 0:3, 0:4, 1-3:4, broadcasts 2 and 3.
        (STOPS, "Pause Stop MotorStop BroadcastStop BroadcastPause"),
        // 0:8, core 4, broadcast 4: a node with another address hears nothing for a while.
        (RESETS_ONCE, "SetAddress CoreAssignAddress BroadcastAssignAddress"),
        // 0:5, 4:3, 0:119, and every setting.
        (
            SETS_ONCE,
            "ToggleDebugLed CameraExpose PowerCycled
             SetTimingMaster SetName SetCommonLine SetMaxStepRate SetInputEdge SetManualMove SetOutBeforeDelay
             SetOutAfterDelay SetOutBeforeTime SetOutAfterTime SetOutLevel SetMaxRunTime SetStartDelay SetProgramMode
             SetJoystickMode SetPingPong
             MotorSetSleep MotorSetEnable MotorSetBacklash MotorSetMicrostep MotorSetMaxStepSpeed MotorSetDirection
             MotorSetHomeHere MotorSetEndHere MotorSetProgramStart MotorSetProgramStop MotorSetEasing MotorSetLeadIn
             MotorSetLeadInLong MotorSetTravel MotorSetProgramAcceleration MotorSetProgramDeceleration MotorResetLimits
             CameraSetEnable CameraSetExposureTime CameraSetFocusTime CameraSetMaxShots CameraSetExposureDelay
             CameraSetFocusWithShutter CameraSetMirrorUp CameraSetInterval",
        ),
        // Command 0, queries from 100 on, and those of the core protocol.
        (
            ASKS,
            "Noop
             FirmwareVersion RunStatus RunTime Exposing TimingMaster Name MaxStepRate Voltage Current InputEdge AltModes
             LimitSwitches OutBeforeDelay OutAfterDelay OutBeforeTime OutAfterTime OutLevel StartDelay ProgramMode
             JoystickMode PingPong
             MotorEnable MotorBacklash MotorMicrostep MotorDirection MotorMaxStepSpeed MotorEndLimit MotorPosition
             MotorRunning MotorContinuousSpeed MotorContinuousAcceleration MotorEasing MotorProgramStart MotorProgramStop
             MotorTravel MotorLeadIn MotorProgramAcceleration MotorProgramDeceleration MotorMaxProgramSpeed
             CameraEnable CameraExposing CameraExposureTime CameraFocusTime CameraMaxShots CameraExposureDelay
             CameraFocusWithShutter CameraMirrorUp CameraInterval
             CoreProtocolVersion CoreDeviceId CoreDeviceVersion",
        ),
    ]);
    for name in ["SetAltModes", "MotorSetContinuousSpeed"] {
        assert_eq!(wanted.insert(name, "by its values".into()), None);
    }
    assert_eq!(of_table::<HostMessage<'_>>(), wanted);
}

#[test]
fn a_speed_moves_unless_it_is_0() {
    let of = |speed| {
        HostMessage::from(MotorSetContinuousSpeed { motor: Motor::Two, speed: StepsPerSecond(speed) }).conduct()
    };
    assert_eq!([0.0, -0.0].map(of), [SETS_ONCE; 2]);
    let moving = [1.0, -1.0, 1e-40, -1e-40, 1e30, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    assert_eq!(moving.map(of), [MOVES_ONCE; 8]);
}

#[test]
fn a_contact_that_starts_something_arms_the_node() {
    let arms = Conduct::new(Purpose::Arms).once();
    let starting = [AltMode::START, AltMode::TOGGLE, AltMode::EXTERNAL_INTERVALOMETER, AltMode::REVERSE_DIRECTION];
    for mode in (0..=255).map(AltMode) {
        let wanted = if starting.contains(&mode) { arms } else { SETS_ONCE };
        for (ring, tip) in [(mode, AltMode::OFF), (AltMode::STOP, mode)] {
            assert_eq!(HostMessage::from(SetAltModes { ring, tip }).conduct(), wanted, "{mode:?}");
        }
    }
}

#[test]
fn a_message_without_a_type_may_do_anything() {
    for number in [0x32_00, 0x1_09_00, 0x2_09_00, 0x04_00] {
        assert_eq!(HostMessage::other(number, &[1]).conduct(), MOVES_ONCE);
    }
}

/// Later firmware, section 7: the safe reading throughout.
#[cfg(feature = "beyond")]
#[test]
fn every_row_of_later_firmware_has_the_safe_conduct() {
    let wanted = stated(&[
        (
            MOVES_ONCE,
            "SendAllToStart SwapStartAndStop TestYourself MotorSendTo MotorStepForward MotorStepBack KeyStart
             KeyTakeUpBacklash BroadcastGraffikUsb BroadcastKeyStart",
        ),
        (STOPS, "KeyPause KeyStop BroadcastKeyStop BroadcastKeyPause"),
        (
            SETS_ONCE,
            "SetStartHere SetStopHere SetFrameRate SetGraffikMode SetAppMode SetDebugOutput
             MotorSetLeadOut MotorFindMicrostep MotorSetStartHere MotorSetStopHere MotorSetEnd MotorSetStopMotion
             MotorSetPosition
             CameraSetTestMode CameraSetKeepAlive CameraSetIntervalometer
             KeySetUpdateRate KeySetVideoTime BroadcastGraffikBluetooth",
        ),
        (SETS_ONCE.in_sequence(), "KeySetAxis KeySetCount KeySetTime KeySetPosition KeySetVelocity KeyEnd"),
        (
            ASKS,
            "ManualMove PercentDone MotorsAttached TotalTime IsComplete FrameRateQuery AnyRunning IsValid MotorsAsleep
             ControllerCount Status GraffikMode FreeMemory MotorIsValid MotorLeadOut
             CameraShots CameraTestMode CameraKeepAlive CameraIntervalometer
             KeyPrint KeyCount KeyUpdateRate KeyPositionAt KeyVelocityAt KeyAccelerationAt KeyVelocityIsValid
             KeyAccelerationIsValid KeyVideoTime KeyRunState KeyRunTime KeyMaxTime KeyPercentDone KeyTimeOf KeyPositionOf
             KeyVelocityOf BroadcastGetAddress",
        ),
    ]);
    assert_eq!(of_table::<hoot_proto::beyond::HostMessage<'_>>(), wanted);
}
