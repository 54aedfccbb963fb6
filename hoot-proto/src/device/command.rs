//! Numbers of the commands that a node carries out, under the names of their messages.

use motion_core::wire::Messages;

use crate::frame::{Selector, Table};
use crate::message::HostMessage;
use crate::query::{Form, is_same};

/// Makes a constant of each message: the number of its command.
macro_rules! commands {
    ($($message:ident)*) => {$(
        #[expect(non_upper_case_globals, reason = "a command has the name of its message")]
        pub(super) const $message: u8 = number(stringify!($message)).command;
    )*};
}

commands! {
    Start Pause Stop ToggleDebugLed SetTimingMaster SetName SetAddress SetCommonLine ReturnHome SetMaxStepRate
    SetInputEdge SetAltModes SetManualMove SetOutBeforeDelay SetOutAfterDelay SetOutBeforeTime SetOutAfterTime
    SetOutLevel SetMaxRunTime SetStartDelay SetProgramMode SetJoystickMode SetPingPong
    FirmwareVersion RunStatus RunTime Exposing TimingMaster Name MaxStepRate Voltage Current InputEdge AltModes
    LimitSwitches OutBeforeDelay OutAfterDelay OutBeforeTime OutAfterTime OutLevel StartDelay ProgramMode PowerCycled
    JoystickMode PingPong

    MotorSetSleep MotorSetEnable MotorStop MotorSetBacklash MotorSetMicrostep MotorSetMaxStepSpeed MotorSetDirection
    MotorSetHomeHere MotorSetEndHere MotorSendHome MotorSendToEnd MotorSetContinuousSpeed
    MotorSetContinuousAcceleration MotorMove MotorSetProgramStart MotorSetProgramStop MotorSetEasing MotorSetLeadIn
    MotorSetTravel MotorSetProgramAcceleration MotorSetProgramDeceleration MotorSendToStart MotorSendToStop
    MotorStepForward MotorStepBack MotorResetLimits
    MotorEnable MotorBacklash MotorMicrostep MotorDirection MotorMaxStepSpeed MotorEndLimit MotorPosition MotorRunning
    MotorContinuousSpeed MotorContinuousAcceleration MotorEasing MotorProgramStart MotorProgramStop MotorTravel
    MotorLeadIn MotorProgramAcceleration MotorProgramDeceleration MotorMaxProgramSpeed

    CameraSetEnable CameraExpose CameraSetExposureTime CameraSetFocusTime CameraSetMaxShots CameraSetExposureDelay
    CameraSetFocusWithShutter CameraSetMirrorUp CameraSetInterval
    CameraEnable CameraExposing CameraExposureTime CameraFocusTime CameraMaxShots CameraExposureDelay
    CameraFocusWithShutter CameraMirrorUp CameraInterval

    BroadcastStart BroadcastStop BroadcastPause BroadcastAssignAddress

    CoreProtocolVersion CoreDeviceId CoreDeviceVersion CoreAssignAddress
}

/// Selector of the message with this name, from the table of all messages.
const fn number(name: &str) -> Selector {
    let mut kinds = HostMessage::ALL;
    while let [kind, rest @ ..] = kinds {
        if is_same(kind.name, name) {
            return Selector::from_number(kind.number);
        }
        kinds = rest;
    }
    // The compiler evaluates this.
    assert!(!kinds.is_empty(), "no message has this name");
    Selector::from_number(0)
}

/// Number of the first query of each part of a node. Commands have smaller numbers.
pub(super) const FIRST_QUERY: u8 = 100;

/// Forms of the answers to the queries of the controller, of a motor and of the camera, from [`FIRST_QUERY`] on.
static FORMS: [[Form; 22]; 3] = [forms(0), forms(1), forms(4)];

const fn forms(sub_address: u8) -> [Form; 22] {
    let mut forms = [Form::Byte; 22];
    let mut command = FIRST_QUERY;
    let mut places: &mut [Form] = &mut forms;
    while let Some((place, rest)) = places.split_first_mut() {
        *place = form(Selector { table: Table::Node, command, sub_address }.number());
        command = command.saturating_add(1);
        places = rest;
    }
    forms
}

/// Form of the answer to the query with this number, from the table of all messages and that of all queries.
const fn form(number: u32) -> Form {
    let mut kinds = HostMessage::ALL;
    while let [kind, rest @ ..] = kinds {
        if kind.number == number {
            return Form::named(kind.name);
        }
        kinds = rest;
    }
    Form::Byte
}

/// Form of the answer to a query.
pub(super) fn form_of(Selector { sub_address, command, .. }: Selector) -> Form {
    let row = match sub_address {
        0 => 0,
        4 => 2,
        _ => 1,
    };
    let form = FORMS.get::<usize>(row).and_then(|forms| forms.get(usize::from(command.saturating_sub(FIRST_QUERY))));
    form.copied().unwrap_or(Form::Byte)
}

/// Bit of each command below 128 that may set something in motion: of the controller, a motor, the camera, broadcasts, and the
/// core protocol. Unknown commands may.
static MOVES: [[u8; 16]; 5] = [
    moves(Table::Node, 0),
    moves(Table::Node, 1),
    moves(Table::Node, 4),
    moves(Table::Broadcast, 0),
    moves(Table::Core, 0),
];

const fn moves(table: Table, sub_address: u8) -> [u8; 16] {
    let mut moves = u128::MAX;
    let mut kinds = HostMessage::ALL;
    while let [kind, rest @ ..] = kinds {
        let selector = Selector::from_number(kind.number);
        let is_here =
            selector.table as u8 == table as u8 && (selector.sub_address == sub_address || selector.command == 0);
        // The conduct of a message that has none in the table depends on its data.
        let may_move = match kind.conduct {
            Some(conduct) => conduct.may_move(),
            None => true,
        };
        if is_here && !may_move {
            moves &= !1_u128.wrapping_shl(selector.command as u32);
        }
        kinds = rest;
    }
    moves.to_le_bytes()
}

/// Whether a command may set something in motion.
pub(super) fn may_move(Selector { table, sub_address, command }: Selector) -> bool {
    let row = match (table, sub_address) {
        (Table::Node, 0) => 0,
        (Table::Node, 1..=3) => 1,
        (Table::Node, 4) => 2,
        (Table::Node, _) => return true,
        (Table::Broadcast, _) => 3,
        (Table::Core, _) => 4,
    };
    let bits = MOVES.get::<usize>(row).and_then(|moves| moves.get(usize::from(command / 8)));
    bits.is_none_or(|bits| bits >> (command % 8) & 1 != 0)
}
