-- Dissector of hoot for Wireshark.
--
-- `cargo run -p wireshark` makes this file: the tables from those of the Rust crate `hoot-proto`, the code after them
-- from `wireshark/lua`. Change those, not this file. How to install it: `wireshark/README.md`.
-- SPDX-License-Identifier: MIT OR Apache-2.0

local KEY, NAME = "hoot", "hoot"
local LITTLE, PORT, MARKER = false, nil, string.rep("\0", 5) .. "\255"

-- Names of numbers and of bits. A number instead of names says that so many bits have numbers as names, from 1.
local N = {}
N.alt_modes = { [0] = "OFF", [1] = "START", [2] = "STOP", [3] = "TOGGLE", [4] = "EXTERNAL_INTERVALOMETER",
  [5] = "REVERSE_DIRECTION", [6] = "OUT_BEFORE", [7] = "OUT_AFTER", [8] = "STOP_MOTORS", [9] = "SET_HOME", [10] = "SET_END" }
N.common_line = { [0] = "OFF", [1] = "FIRST", [2] = "SECOND" }
N.easing = { [1] = "LINEAR", [2] = "QUADRATIC", [3] = "INVERSE_QUADRATIC" }
N.edge = { [0] = "RISING", [1] = "FALLING", [2] = "CHANGE" }
N.frame_rate = { [0] = "THIRTY", [1] = "TWENTY_FOUR", [2] = "TWENTY_FIVE" }
N.input_edge = { [1] = "CHANGE", [2] = "FALLING", [3] = "RISING" }
N.level = { [0] = "LOW", [1] = "HIGH" }
N.limit_switches = { [0] = "LOW", [1] = "HIGH" }
N.microstep = { [1] = "FULL", [2] = "HALF", [4] = "QUARTER", [8] = "EIGHTH", [16] = "SIXTEENTH" }
N.motor_easing = { [4] = "LINEAR", [5] = "QUADRATIC", [6] = "INVERSE_QUADRATIC" }
N.motor_max_program_speed = { [0] = "sleep no", [1] = "sleep yes" }
N.program_mode = { [0] = "SMS", [1] = "CONTINUOUS", [2] = "VIDEO" }
N.response_code = { [0] = "ERROR", [1] = "OK", [2] = "ERROR_WITH_DATA" }
N.ring = { [0] = "OFF", [1] = "START", [2] = "STOP", [3] = "TOGGLE", [4] = "EXTERNAL_INTERVALOMETER",
  [5] = "REVERSE_DIRECTION", [6] = "OUT_BEFORE", [7] = "OUT_AFTER", [8] = "STOP_MOTORS", [9] = "SET_HOME", [10] = "SET_END" }
N.run_status = { [0] = "STOPPED", [1] = "RUNNING_OR_PAUSED", [2] = "RUNNING", [3] = "DELAY", [4] = "STILL_SHOOTING",
  [5] = "PING_PONG" }
N.value_type = { [0] = "BYTE", [1] = "UINT", [2] = "INT", [3] = "LONG", [4] = "ULONG", [5] = "FLOAT",
  [6] = "STRING" }
N.yes_or_no = { [0] = "no", [1] = "yes" }

-- Messages of the host, by number.
local HOST = {
  { name = "Noop", number = 0x0, last = 0xff },
  { name = "Start", number = 0x200 },
  { name = "Pause", number = 0x300 },
  { name = "Stop", number = 0x400 },
  { name = "ToggleDebugLed", number = 0x500 },
  { name = "SetTimingMaster", number = 0x600,
    { "timing_master", "u8", words = N.yes_or_no },
  },
  { name = "SetName", number = 0x700, tail = true,
    { "name", "text", rest = true },
  },
  { name = "SetAddress", number = 0x800,
    { "new_address", "u8" },
  },
  { name = "SetCommonLine", number = 0x900,
    { "common_line", "u8", names = N.common_line },
  },
  { name = "ReturnHome", number = 0xa00 },
  { name = "SetMaxStepRate", number = 0xb00,
    { "max_step_rate", "u16", unit = "steps/s" },
  },
  { name = "SetInputEdge", number = 0xc00,
    { "edge", "u8", names = N.edge },
  },
  { name = "SetAltModes", number = 0xd00,
    { "ring", "u8", names = N.ring },
    { "tip", "u8", names = N.ring },
  },
  { name = "SetManualMove", number = 0xe00,
    { "manual_move", "u8", words = N.yes_or_no },
  },
  { name = "SetOutBeforeDelay", number = 0xf00,
    { "delay", "u16", unit = "ms" },
  },
  { name = "SetOutAfterDelay", number = 0x1000,
    { "delay", "u16", unit = "ms" },
  },
  { name = "SetOutBeforeTime", number = 0x1100,
    { "time", "u16", unit = "ms" },
  },
  { name = "SetOutAfterTime", number = 0x1200,
    { "time", "u16", unit = "ms" },
  },
  { name = "SetOutLevel", number = 0x1300,
    { "level", "u8", names = N.level },
  },
  { name = "SetMaxRunTime", number = 0x1400,
    { "max_run_time", "u32", unit = "ms" },
  },
  { name = "SetStartDelay", number = 0x1500,
    { "start_delay", "u32" },
  },
  { name = "SetProgramMode", number = 0x1600,
    { "program_mode", "u8", names = N.program_mode },
  },
  { name = "SetJoystickMode", number = 0x1700,
    { "joystick_mode", "u8", words = N.yes_or_no },
  },
  { name = "SetPingPong", number = 0x1800,
    { "ping_pong", "u8", words = N.yes_or_no },
  },
  { name = "FirmwareVersion", number = 0x6400 },
  { name = "RunStatus", number = 0x6500 },
  { name = "RunTime", number = 0x6600 },
  { name = "Exposing", number = 0x6700 },
  { name = "TimingMaster", number = 0x6800 },
  { name = "Name", number = 0x6900 },
  { name = "MaxStepRate", number = 0x6a00 },
  { name = "Voltage", number = 0x6b00 },
  { name = "Current", number = 0x6c00 },
  { name = "InputEdge", number = 0x6d00 },
  { name = "AltModes", number = 0x6e00 },
  { name = "LimitSwitches", number = 0x6f00 },
  { name = "OutBeforeDelay", number = 0x7000 },
  { name = "OutAfterDelay", number = 0x7100 },
  { name = "OutBeforeTime", number = 0x7200 },
  { name = "OutAfterTime", number = 0x7300 },
  { name = "OutLevel", number = 0x7400 },
  { name = "StartDelay", number = 0x7500 },
  { name = "ProgramMode", number = 0x7600 },
  { name = "PowerCycled", number = 0x7700 },
  { name = "JoystickMode", number = 0x7800 },
  { name = "PingPong", number = 0x7900 },
  { name = "MotorSetSleep", number = 0x201, last = 0x203, sub = "motor",
    { "sleep", "u8", words = N.yes_or_no },
  },
  { name = "MotorSetEnable", number = 0x301, last = 0x303, sub = "motor",
    { "enable", "u8", words = N.yes_or_no },
  },
  { name = "MotorStop", number = 0x401, last = 0x403, sub = "motor" },
  { name = "MotorSetBacklash", number = 0x501, last = 0x503, sub = "motor",
    { "backlash", "u16", unit = "steps" },
  },
  { name = "MotorSetMicrostep", number = 0x601, last = 0x603, sub = "motor",
    { "microstep", "u8", names = N.microstep },
  },
  { name = "MotorSetMaxStepSpeed", number = 0x701, last = 0x703, sub = "motor",
    { "max_step_speed", "u16", unit = "steps/s" },
  },
  { name = "MotorSetDirection", number = 0x801, last = 0x803, sub = "motor",
    { "direction", "u8" },
  },
  { name = "MotorSetHomeHere", number = 0x901, last = 0x903, sub = "motor" },
  { name = "MotorSetEndHere", number = 0xa01, last = 0xa03, sub = "motor" },
  { name = "MotorSendHome", number = 0xb01, last = 0xb03, sub = "motor" },
  { name = "MotorSendToEnd", number = 0xc01, last = 0xc03, sub = "motor" },
  { name = "MotorSetContinuousSpeed", number = 0xd01, last = 0xd03, sub = "motor",
    { "speed", "f32", unit = "steps/s" },
  },
  { name = "MotorSetContinuousAcceleration", number = 0xe01, last = 0xe03, sub = "motor",
    { "acceleration", "f32", unit = "steps/s²" },
  },
  { name = "MotorMove", number = 0xf01, last = 0xf03, sub = "motor",
    { "direction", "u8" },
    { "steps", "u32", unit = "steps" },
  },
  { name = "MotorRun", number = 0xf01, last = 0xf03, sub = "motor",
    { "direction", "u8" },
    { "steps", "u32", unit = "steps" },
  },
  { name = "MotorSetProgramStart", number = 0x1001, last = 0x1003, sub = "motor",
    { "position", "i32", unit = "steps" },
  },
  { name = "MotorSetProgramStop", number = 0x1101, last = 0x1103, sub = "motor",
    { "position", "i32", unit = "steps" },
  },
  { name = "MotorSetEasing", number = 0x1201, last = 0x1203, sub = "motor",
    { "easing", "u8", names = N.easing },
  },
  { name = "MotorSetLeadIn", number = 0x1301, last = 0x1303, sub = "motor",
    { "lead_in", "u16" },
  },
  { name = "MotorSetLeadInLong", number = 0x1301, last = 0x1303, sub = "motor",
    { "lead_in", "u32" },
  },
  { name = "MotorSetTravel", number = 0x1401, last = 0x1403, sub = "motor",
    { "travel", "u32" },
  },
  { name = "MotorSetProgramAcceleration", number = 0x1501, last = 0x1503, sub = "motor",
    { "acceleration", "u32" },
  },
  { name = "MotorSetProgramDeceleration", number = 0x1601, last = 0x1603, sub = "motor",
    { "deceleration", "u32" },
  },
  { name = "MotorSendToStart", number = 0x1701, last = 0x1703, sub = "motor" },
  { name = "MotorSendToStop", number = 0x1801, last = 0x1803, sub = "motor" },
  { name = "MotorStepForward", number = 0x1901, last = 0x1903, sub = "motor" },
  { name = "MotorStepBack", number = 0x1a01, last = 0x1a03, sub = "motor" },
  { name = "MotorResetLimits", number = 0x1b01, last = 0x1b03, sub = "motor" },
  { name = "MotorEnable", number = 0x6401, last = 0x6403, sub = "motor" },
  { name = "MotorBacklash", number = 0x6501, last = 0x6503, sub = "motor" },
  { name = "MotorMicrostep", number = 0x6601, last = 0x6603, sub = "motor" },
  { name = "MotorDirection", number = 0x6701, last = 0x6703, sub = "motor" },
  { name = "MotorMaxStepSpeed", number = 0x6801, last = 0x6803, sub = "motor" },
  { name = "MotorEndLimit", number = 0x6901, last = 0x6903, sub = "motor" },
  { name = "MotorPosition", number = 0x6a01, last = 0x6a03, sub = "motor" },
  { name = "MotorRunning", number = 0x6b01, last = 0x6b03, sub = "motor" },
  { name = "MotorContinuousSpeed", number = 0x6c01, last = 0x6c03, sub = "motor" },
  { name = "MotorContinuousAcceleration", number = 0x6d01, last = 0x6d03, sub = "motor" },
  { name = "MotorEasing", number = 0x6e01, last = 0x6e03, sub = "motor" },
  { name = "MotorProgramStart", number = 0x6f01, last = 0x6f03, sub = "motor" },
  { name = "MotorProgramStop", number = 0x7001, last = 0x7003, sub = "motor" },
  { name = "MotorTravel", number = 0x7101, last = 0x7103, sub = "motor" },
  { name = "MotorLeadIn", number = 0x7201, last = 0x7203, sub = "motor" },
  { name = "MotorProgramAcceleration", number = 0x7301, last = 0x7303, sub = "motor" },
  { name = "MotorProgramDeceleration", number = 0x7401, last = 0x7403, sub = "motor" },
  { name = "MotorMaxProgramSpeed", number = 0x7501, last = 0x7503, sub = "motor" },
  { name = "CameraSetEnable", number = 0x204,
    { "enable", "u8", words = N.yes_or_no },
  },
  { name = "CameraExpose", number = 0x304 },
  { name = "CameraSetExposureTime", number = 0x404,
    { "exposure_time", "u32", unit = "ms" },
  },
  { name = "CameraSetFocusTime", number = 0x504,
    { "focus_time", "u16", unit = "ms" },
  },
  { name = "CameraSetMaxShots", number = 0x604,
    { "max_shots", "u16", unit = "shots" },
  },
  { name = "CameraSetExposureDelay", number = 0x704,
    { "exposure_delay", "u16", unit = "ms" },
  },
  { name = "CameraSetFocusWithShutter", number = 0x804,
    { "focus_with_shutter", "u8", words = N.yes_or_no },
  },
  { name = "CameraSetMirrorUp", number = 0x904,
    { "mirror_up", "u8", words = N.yes_or_no },
  },
  { name = "CameraSetInterval", number = 0xa04,
    { "interval", "u32", unit = "ms" },
  },
  { name = "CameraEnable", number = 0x6404 },
  { name = "CameraExposing", number = 0x6504 },
  { name = "CameraExposureTime", number = 0x6604 },
  { name = "CameraFocusTime", number = 0x6704 },
  { name = "CameraMaxShots", number = 0x6804 },
  { name = "CameraExposureDelay", number = 0x6904 },
  { name = "CameraFocusWithShutter", number = 0x6a04 },
  { name = "CameraMirrorUp", number = 0x6b04 },
  { name = "CameraInterval", number = 0x6c04 },
  { name = "BroadcastStart", number = 0x10100, last = 0x101ff },
  { name = "BroadcastStop", number = 0x10200, last = 0x102ff },
  { name = "BroadcastPause", number = 0x10300, last = 0x103ff },
  { name = "BroadcastAssignAddress", number = 0x10400, last = 0x104ff,
    { "new_address", "u8" },
  },
  { name = "CoreProtocolVersion", number = 0x20100, last = 0x201ff },
  { name = "CoreDeviceId", number = 0x20200, last = 0x202ff },
  { name = "CoreDeviceVersion", number = 0x20300, last = 0x203ff },
  { name = "CoreAssignAddress", number = 0x20400, last = 0x204ff,
    { "new_address", "u8" },
  },
  { name = "SendAllToStart", number = 0x1900 },
  { name = "SetStartHere", number = 0x1a00 },
  { name = "SetStopHere", number = 0x1b00 },
  { name = "SetFrameRate", number = 0x1c00,
    { "frame_rate", "u8", names = N.frame_rate },
  },
  { name = "SwapStartAndStop", number = 0x1d00 },
  { name = "SetGraffikMode", number = 0x3200,
    { "graffik_mode", "u8", words = N.yes_or_no },
  },
  { name = "SetAppMode", number = 0x3300,
    { "app_mode", "u8", words = N.yes_or_no },
  },
  { name = "ManualMove", number = 0x7a00 },
  { name = "PercentDone", number = 0x7b00 },
  { name = "MotorsAttached", number = 0x7c00 },
  { name = "TotalTime", number = 0x7d00 },
  { name = "IsComplete", number = 0x7e00 },
  { name = "FrameRateQuery", number = 0x7f00 },
  { name = "AnyRunning", number = 0x8000 },
  { name = "IsValid", number = 0x8100 },
  { name = "MotorsAsleep", number = 0x8200 },
  { name = "ControllerCount", number = 0x8600 },
  { name = "Status", number = 0x8c00 },
  { name = "GraffikMode", number = 0x9600 },
  { name = "FreeMemory", number = 0xc800 },
  { name = "SetDebugOutput", number = 0xfe00,
    { "debug_output", "u8" },
  },
  { name = "TestYourself", number = 0xff00 },
  { name = "MotorSetLeadOut", number = 0x1901, last = 0x1903, sub = "motor",
    { "lead_out", "u32" },
  },
  { name = "MotorFindMicrostep", number = 0x1c01, last = 0x1c03, sub = "motor" },
  { name = "MotorSetStartHere", number = 0x1d01, last = 0x1d03, sub = "motor" },
  { name = "MotorSetStopHere", number = 0x1e01, last = 0x1e03, sub = "motor" },
  { name = "MotorSendTo", number = 0x1f01, last = 0x1f03, sub = "motor",
    { "position", "i32", unit = "steps" },
  },
  { name = "MotorSetPosition", number = 0x2001, last = 0x2003, sub = "motor",
    { "position", "i32", unit = "steps" },
  },
  { name = "MotorSetEnd", number = 0x2101, last = 0x2103, sub = "motor",
    { "position", "i32", unit = "steps" },
  },
  { name = "MotorSetStopMotion", number = 0x3201, last = 0x3203, sub = "motor",
    { "stop_motion", "u8", words = N.yes_or_no },
  },
  { name = "MotorStepForward", number = 0x3301, last = 0x3303, sub = "motor" },
  { name = "MotorStepBack", number = 0x3401, last = 0x3403, sub = "motor" },
  { name = "MotorIsValid", number = 0x7601, last = 0x7603, sub = "motor" },
  { name = "MotorLeadOut", number = 0x7701, last = 0x7703, sub = "motor" },
  { name = "CameraSetTestMode", number = 0xb04,
    { "test_mode", "u8", words = N.yes_or_no },
  },
  { name = "CameraSetKeepAlive", number = 0xc04,
    { "keep_alive", "u8", words = N.yes_or_no },
  },
  { name = "CameraSetIntervalometer", number = 0xd04,
    { "intervalometer", "u8", words = N.yes_or_no },
  },
  { name = "CameraShots", number = 0x6d04 },
  { name = "CameraTestMode", number = 0x6e04 },
  { name = "CameraKeepAlive", number = 0x6f04 },
  { name = "CameraIntervalometer", number = 0x7004 },
  { name = "KeySetAxis", number = 0xa05,
    { "axis", "i16" },
  },
  { name = "KeySetCount", number = 0xb05,
    { "count", "i16" },
  },
  { name = "KeySetTime", number = 0xc05,
    { "time", "f32" },
  },
  { name = "KeySetPosition", number = 0xd05,
    { "position", "f32", unit = "steps" },
  },
  { name = "KeySetVelocity", number = 0xe05,
    { "velocity", "f32" },
  },
  { name = "KeySetUpdateRate", number = 0xf05,
    { "update_rate", "u16", unit = "ms" },
  },
  { name = "KeyEnd", number = 0x1005 },
  { name = "KeySetVideoTime", number = 0x1105,
    { "video_time", "i32", unit = "ms" },
  },
  { name = "KeyStart", number = 0x1405 },
  { name = "KeyPause", number = 0x1505 },
  { name = "KeyStop", number = 0x1605 },
  { name = "KeyTakeUpBacklash", number = 0x1705 },
  { name = "KeyPrint", number = 0x6305 },
  { name = "KeyCount", number = 0x6405 },
  { name = "KeyUpdateRate", number = 0x6505 },
  { name = "KeyPositionAt", number = 0x6605,
    { "time", "f32" },
  },
  { name = "KeyVelocityAt", number = 0x6705,
    { "time", "f32" },
  },
  { name = "KeyAccelerationAt", number = 0x6805,
    { "time", "f32" },
  },
  { name = "KeyVelocityIsValid", number = 0x6905 },
  { name = "KeyAccelerationIsValid", number = 0x6a05 },
  { name = "KeyVideoTime", number = 0x6b05 },
  { name = "KeyRunState", number = 0x7805 },
  { name = "KeyRunTime", number = 0x7905 },
  { name = "KeyMaxTime", number = 0x7a05 },
  { name = "KeyPercentDone", number = 0x7b05 },
  { name = "KeyTimeOf", number = 0x8205,
    { "key_frame", "i16" },
  },
  { name = "KeyPositionOf", number = 0x8305,
    { "key_frame", "i16" },
  },
  { name = "KeyVelocityOf", number = 0x8405,
    { "key_frame", "i16" },
  },
  { name = "BroadcastGraffikUsb", number = 0x10500, last = 0x105ff },
  { name = "BroadcastGraffikBluetooth", number = 0x10600, last = 0x106ff },
  { name = "BroadcastKeyStart", number = 0x10700, last = 0x107ff },
  { name = "BroadcastKeyStop", number = 0x10800, last = 0x108ff },
  { name = "BroadcastKeyPause", number = 0x10900, last = 0x109ff },
  { name = "BroadcastGetAddress", number = 0x10a00, last = 0x10aff },
}

-- Messages of the device, by number.
local DEVICE = {
  { name = "Reply", number = 0x0, last = 0xff, tail = true },
}

-- Values that answer a query, by the name of the query and the type of the value.
local ANSWERS = {
  FirmwareVersion = { [0] = {}, [4] = {} },
  RunStatus = { [0] = { names = N.run_status } },
  RunTime = { [4] = { unit = "ms" } },
  Exposing = { [0] = { words = N.yes_or_no } },
  TimingMaster = { [0] = { words = N.yes_or_no } },
  Name = { [6] = {} },
  MaxStepRate = { [1] = { unit = "steps/s" } },
  Voltage = { [3] = { decimals = 2, unit = "V" }, [4] = { decimals = 2, unit = "V" }, [5] = { decimals = 2, unit = "V" } },
  Current = { [3] = { decimals = 2, unit = "A" }, [4] = { decimals = 2, unit = "A" }, [5] = { decimals = 2, unit = "A" } },
  InputEdge = { [0] = { names = N.input_edge } },
  AltModes = { [2] = { ring_tip = N.alt_modes } },
  LimitSwitches = { [2] = { ring_tip = N.limit_switches } },
  OutBeforeDelay = { [1] = { unit = "ms" } },
  OutAfterDelay = { [1] = { unit = "ms" } },
  OutBeforeTime = { [1] = { unit = "ms" } },
  OutAfterTime = { [1] = { unit = "ms" } },
  OutLevel = { [0] = { names = N.level } },
  StartDelay = { [4] = {} },
  ProgramMode = { [0] = { names = N.program_mode } },
  PowerCycled = { [0] = { words = N.yes_or_no } },
  JoystickMode = { [0] = { words = N.yes_or_no } },
  PingPong = { [0] = { words = N.yes_or_no } },
  MotorEnable = { [0] = { words = N.yes_or_no } },
  MotorBacklash = { [1] = { unit = "steps" } },
  MotorMicrostep = { [0] = { names = N.microstep } },
  MotorDirection = { [0] = {} },
  MotorMaxStepSpeed = { [1] = { unit = "steps/s" }, [2] = { unit = "steps/s" } },
  MotorEndLimit = { [3] = { unit = "steps" }, [4] = { unit = "steps" } },
  MotorPosition = { [3] = { unit = "steps" }, [4] = { unit = "steps" } },
  MotorRunning = { [0] = { words = N.yes_or_no }, [2] = { words = N.yes_or_no } },
  MotorContinuousSpeed = { [3] = { decimals = 2, unit = "steps/s" }, [4] = { decimals = 2, unit = "steps/s" }, [5] = { decimals = 2, unit = "steps/s" } },
  MotorContinuousAcceleration = { [3] = { decimals = 2, unit = "steps/s²" }, [4] = { decimals = 2, unit = "steps/s²" }, [5] = { decimals = 2, unit = "steps/s²" } },
  MotorEasing = { [0] = { names = N.motor_easing } },
  MotorProgramStart = { [3] = { unit = "steps" }, [4] = { unit = "steps" } },
  MotorProgramStop = { [3] = { unit = "steps" }, [4] = { unit = "steps" } },
  MotorTravel = { [4] = {} },
  MotorLeadIn = { [1] = {}, [2] = {}, [4] = {} },
  MotorProgramAcceleration = { [4] = {} },
  MotorProgramDeceleration = { [4] = {} },
  MotorMaxProgramSpeed = { [0] = { words = N.motor_max_program_speed }, [4] = { decimals = 2, unit = "steps/s" }, [5] = { decimals = 2, unit = "steps/s" } },
  CameraEnable = { [0] = { words = N.yes_or_no } },
  CameraExposing = { [0] = { words = N.yes_or_no } },
  CameraExposureTime = { [4] = { unit = "ms" } },
  CameraFocusTime = { [1] = { unit = "ms" } },
  CameraMaxShots = { [1] = { unit = "shots" }, [4] = { unit = "shots" } },
  CameraExposureDelay = { [1] = { unit = "ms" } },
  CameraFocusWithShutter = { [0] = { words = N.yes_or_no } },
  CameraMirrorUp = { [0] = { words = N.yes_or_no }, [2] = { words = N.yes_or_no } },
  CameraInterval = { [4] = { unit = "ms" } },
  CoreProtocolVersion = { [1] = {} },
  CoreDeviceId = { [6] = {} },
  CoreDeviceVersion = { [1] = {} },
}

-- Code that all three dissectors share.

local proto = Proto(KEY, NAME .. ", motion control")
proto.prefs.side = Pref.enum("Sender, if the capture does not tell it", 0,
  "Ports and the direction flags of a pcapng file tell the sender. If both are missing, this does.",
  { { 1, "told by the message", 0 }, { 2, "host", 1 }, { 3, "device", 2 } }, false)

-- What may be wrong with a frame.
local E = {}
local function fault(name, text, group, severity)
  E[name] = ProtoExpert.new(KEY .. ".expert." .. name, text, expert.group[group], expert.severity[severity])
end
fault("short", "The data ends before the fields of the message do", "MALFORMED", "ERROR")
fault("trailing", "Bytes follow the known fields", "PROTOCOL", "NOTE")
fault("unknown", "Unknown message", "UNDECODED", "WARN")
fault("noise", "Bytes that belong to no frame", "PROTOCOL", "WARN")
fault("cut", "The frame is not complete", "REASSEMBLE", "WARN")
fault("checksum", "Wrong checksum", "CHECKSUM", "ERROR")
fault("refused", "The device reports an error", "RESPONSE_CODE", "WARN")
fault("unasked", "The capture has no request for this answer", "SEQUENCE", "NOTE")
fault("again", "Another answer to the same request", "SEQUENCE", "NOTE")

-- Fields, once for all rows that show the same.
local F, all_fields = {}, {}
local SIZE = { u8 = 1, u16 = 2, u32 = 4, i8 = 1, i16 = 2, i32 = 4, f32 = 4, ipv4 = 4, mac = 6 }
local MAKE = {
  u8 = ProtoField.uint8, u16 = ProtoField.uint16, u32 = ProtoField.uint32,
  i8 = ProtoField.int8, i16 = ProtoField.int16, i32 = ProtoField.int32, f32 = ProtoField.float,
  ipv4 = ProtoField.ipv4, mac = ProtoField.ether, bytes = ProtoField.bytes, text = ProtoField.string,
  secret = ProtoField.string,
}

local function keep(field)
  all_fields[#all_fields + 1] = field
  return field
end

-- Name of a field for people.
local function label_of(name)
  return (name:gsub("_", " "):gsub("^%l", string.upper))
end

local function field_of(row)
  local name, kind = row[1], row[2]
  local id = table.concat({ name, kind, tostring(row.names), tostring(row.hex or row.flags ~= nil) }, " ")
  if not F[id] then
    local integer = kind:match("^[ui]%d")
    local style = integer and ((row.hex or row.flags) and base.HEX or base.DEC) or nil
    F[id] = keep(MAKE[kind](KEY .. "." .. name, label_of(name), style, integer and row.names or nil))
  end
  return F[id]
end

-- Prepares rows: finds their fields, and the size of one value or group.
local function rows(list)
  for _, row in ipairs(list) do
    if row.of then
      rows(row.of)
      row.size = 0
      for _, inner in ipairs(row.of) do row.size = row.size + inner.size * (inner.times or 1) end
      if row.count then row.counter = rows({ { row.count, "u8" } })[1] end
    else
      row.size = row.size or SIZE[row[2]]
      row.field = field_of(row)
    end
  end
  return list
end

local function each_rows(messages)
  for _, message in ipairs(messages) do
    rows(message)
    if message.sub then message.sub_row = rows({ { message.sub, "u8" } })[1] end
  end
  return messages
end
each_rows(HOST)
each_rows(DEVICE)

-- Messages with this number; more than one if the data tells them apart.
local found = {}
local function messages_of(side, number)
  local table_of_side = side == "host" and HOST or DEVICE
  local id = side .. number
  if not found[id] then
    found[id] = {}
    for _, message in ipairs(table_of_side) do
      if number == message.also or (number >= message.number and number <= (message.last or message.number)) then
        table.insert(found[id], message)
      end
    end
  end
  return found[id]
end

local function unsigned(range)
  if LITTLE then return range:le_uint() else return range:uint() end
end

-- Number that an integer row shows.
local function number_of(row, range)
  if row[2]:match("^u%d") then return unsigned(range) end
  if not row[2]:match("^i%d") then return nil end
  if LITTLE then return range:le_int() else return range:int() end
end

-- Names of the bits that are set.
local function flags_text(flags, value)
  local names, numbered = {}, type(flags) == "number"
  for index = 1, numbered and flags or #flags do
    local bit = numbered and 2 ^ (index - 1) or flags[index][1]
    if math.floor(value / bit) % 2 == 1 then
      names[#names + 1] = numbered and index or flags[index][2]
      value = value - bit
    end
  end
  if value > 0 then names[#names + 1] = string.format("0x%x", value) end
  if #names == 0 then return "none" end
  return table.concat(names, numbered and "+" or " | ")
end

-- What a person reads beside the number.
local function reading(row, number)
  local unit = row.unit and " " .. row.unit or ""
  if row.flags then return " (" .. flags_text(row.flags, number) .. ")" end
  local word = row.words and (row.words[number] or row.words == N.yes_or_no and "yes")
  if word then return " (" .. word .. ")" end
  if row.ring_tip then
    local bits = number % 65536
    local ring, tip = math.floor(bits / 256), bits % 256
    return string.format(" (ring %s, tip %s)", row.ring_tip[ring] or ring, row.ring_tip[tip] or tip)
  end
  if row.decimals then return string.format(" (%." .. row.decimals .. "f%s)", number / 10 ^ row.decimals, unit) end
  return unit
end

-- Adds one value.
local function add_value(tree, row, range)
  local kind = row[2]
  if kind == "text" or kind == "secret" then
    local text = range:raw()
    -- A text of fixed size ends at its first NUL. Others may have NULs at the end.
    local length = #(row.size and text:match("^[^%z]*") or text:gsub("%z+$", ""))
    if kind == "secret" and not proto.prefs.secrets then
      return tree:add(row.field, string.format("hidden, %d bytes", length))
    end
    if length == 0 then return tree:add(row.field, "") end
    return tree:add_packet_field(row.field, range(0, length), ENC_UTF_8)
  end
  local item
  if LITTLE then item = tree:add_le(row.field, range) else item = tree:add(row.field, range) end
  local number = number_of(row, range)
  if number or row.unit then item:append_text(reading(row, number)) end
  return item
end

-- Adds several values, or several groups of values.
local add_rows
local function add_list(tree, tvb, at, count, row)
  if count == 0 then return at end
  local label = label_of(row[1])
  local list = tree:add(tvb(at, count * row.size), string.format("%s: %d", label, count))
  for index = 1, count do
    local place = tvb(at, row.size)
    if row.of then
      add_rows(list:add(place, string.format("%s %d", label, index)), tvb, at, at + row.size, row.of)
    else
      add_value(list, row, place)
    end
    at = at + row.size
  end
  return at
end

-- Adds the values of a row. Returns the offset after them, or nil if the body ends before.
local function add_row(tree, tvb, at, stop, row)
  local left = stop - at
  if row.rest then
    if left > 0 then add_value(tree, row, tvb(at, left)) end
    return stop
  elseif row.prefixed then
    if left < 2 then return nil end
    local length = unsigned(tvb(at, 2))
    if left < 2 + length then return nil end
    if length > 0 then add_value(tree, row, tvb(at + 2, length)) elseif row[2] ~= "bytes" then tree:add(row.field, "") end
    return at + 2 + length
  elseif row.list then
    return add_list(tree, tvb, at, math.floor(left / row.size), row)
  elseif row.count then
    if left < 1 then return nil end
    local count = tvb(at, 1):uint()
    if left < 1 + count * row.size then return nil end
    add_value(tree, row.counter, tvb(at, 1))
    return add_list(tree, tvb, at + 1, count, row)
  elseif left < row.size * (row.times or 1) then
    return nil
  elseif row.times then
    return add_list(tree, tvb, at, row.times, row)
  end
  add_value(tree, row, tvb(at, row.size))
  return at + row.size
end

-- Adds the values of rows. Returns the offset after them, or nil, the name of the row that is cut off, and its offset.
function add_rows(tree, tvb, at, stop, list)
  local ended = false
  for _, row in ipairs(list) do
    local left = stop - at
    if row.needs and (ended or left < row.needs) then
      ended = true
    elseif not (row.newer and left == 0) then
      local after = add_row(tree, tvb, at, stop, row)
      if not after then return nil, row[1], at end
      at = after
    end
  end
  return at
end

-- Fields that every frame has, and those of the bytes that no row describes.
F.message = keep(ProtoField.string(KEY .. ".message", "Message"))
F.sender = keep(ProtoField.string(KEY .. ".sender", "Sender"))
F.response_in = keep(ProtoField.framenum(KEY .. ".response_in", "Response in", base.NONE, frametype.RESPONSE))
F.request_in = keep(ProtoField.framenum(KEY .. ".request_in", "Request in", base.NONE, frametype.REQUEST))
F.time = keep(ProtoField.relative_time(KEY .. ".time", "Time since the request"))
F.data = keep(ProtoField.bytes(KEY .. ".data", "Data"))
F.tail = keep(ProtoField.bytes(KEY .. ".tail", "Bytes after the known fields"))
F.noise = keep(ProtoField.bytes(KEY .. ".noise", "Noise"))

-- Bodies that are added by a function of their own, by the name of their message. It returns what `add_rows` returns.
local BY_HAND = {}

-- Adds a body, and says what is wrong with it.
local function add_body(tree, tvb, frame)
  local at, stop, message = frame.body, frame.stop, frame.message
  if not message then
    if at < stop then tree:add(F.data, tvb(at, stop - at)) end
    tree:add_proto_expert_info(frame.fault or E.unknown, frame.why or "Unknown message")
    return
  end
  local add = BY_HAND[message.name] or add_rows
  local after, name, from = add(tree, tvb, at, stop, message, frame)
  if not after then
    tree:add_proto_expert_info(E.short, string.format("%s ends before %s does", message.name, name))
    after = from
    if after < stop then tree:add(F.data, tvb(after, stop - after)) end
  elseif after < stop then
    local item = tree:add(F.tail, tvb(after, stop - after))
    item:add_proto_expert_info(E.trailing, string.format("%d bytes follow the known fields", stop - after))
  end
end

-- Frames of the capture, with what was found about them when they were first seen.
local seen, waiting, held, joined

function proto.init()
  seen, waiting, held, joined = {}, {}, {}, {}
end

-- Name of the line between a host and a device, the same for both directions.
local function line_of(pinfo)
  local a = tostring(pinfo.src) .. ":" .. tostring(pinfo.src_port)
  local b = tostring(pinfo.dst) .. ":" .. tostring(pinfo.dst_port)
  return a < b and a .. " " .. b or b .. " " .. a
end

-- What tells a frame from all others of the capture. A packet may end one buffer and begin another, both at offset 0.
local function id_of(pinfo, tvb, at, size)
  return table.concat({ pinfo.number, at, tvb:len(), tvb:raw(at, math.min(size, 16)) }, " ")
end

-- Finds the request of an answer and the answer to a request, which have the same tag, and shows them.
local function pair(tree, pinfo, id, frame)
  local entry = seen[id]
  if not entry then
    entry = { number = pinfo.number, time = pinfo.rel_ts, more = frame.more, frame = frame }
    seen[id] = entry
    local key = line_of(pinfo) .. " " .. frame.tag
    if frame.asks then
      waiting[key] = entry
    elseif frame.answers and waiting[key] then
      local request = waiting[key]
      entry.request = request
      entry.again = request.response and not request.last.more
      request.response = request.response or entry
      request.last = entry
    end
  end
  if entry.response then tree:add(F.response_in, entry.response.number):set_generated() end
  if entry.request then
    tree:add(F.request_in, entry.request.number):set_generated()
    local time = math.max(entry.time - entry.request.time, 0)
    tree:add(F.time, NSTime.new(math.floor(time), math.floor(time % 1 * 1e9))):set_generated()
    if entry.again then tree:add_proto_expert_info(E.again) end
  elseif frame.answers and not frame.unasked then
    tree:add_proto_expert_info(E.unasked)
  end
  return entry.request and entry.request.frame
end

-- Sender, if something besides the message tells it.
local function told_sender(pinfo)
  if PORT and (pinfo.src_port == PORT) ~= (pinfo.dst_port == PORT) then
    return pinfo.src_port == PORT and "device" or "host"
  end
  if pinfo.p2p_dir == 0 then return "host" end
  if pinfo.p2p_dir == 1 then return "device" end
  return ({ "host", "device" })[proto.prefs.side]
end

-- Functions that each dissector has of its own.
-- next_frame(tvb, at): "frame" and its size, "noise" and its size, or "more" and the size that the frame will have.
-- read_frame(tvb, at, size, sender, pinfo): what the header of a frame says.
local next_frame, read_frame

local function show_frame(tvb, pinfo, root, at, size)
  local frame = read_frame(tvb, at, size, told_sender(pinfo), pinfo)
  local name = frame.message and frame.message.name or "Other"
  local tree = root:add(proto, tvb(at, size), string.format("%s, %s: %s", NAME, frame.sender, name))
  tree:add(F.message, name):set_generated()
  tree:add(F.sender, frame.sender):set_generated()
  frame.request = pair(tree, pinfo, id_of(pinfo, tvb, at, size), frame)
  local about = frame.request and frame.request.message
  if about and (name == "Reply" or name == "Ack") then
    name = name .. " to " .. about.name
    tree:set_text(string.format("%s, %s: %s", NAME, frame.sender, name))
  end
  add_rows(tree, tvb, at, frame.body, frame.header)
  if frame.message and frame.message.sub_row then add_value(tree, frame.message.sub_row, frame.sub) end
  add_body(tree, tvb, frame)
  if frame.finish then frame.finish(tree) end
  pinfo.cols.info:append(string.format(" %s %s", frame.sender == "host" and ">" or "<", name))
end

-- Dissects the frames of a piece of a stream. Returns the offset of a frame that is not complete, and its size.
local function show_frames(tvb, pinfo, root)
  local at = 0
  while at < tvb:len() do
    local what, size = next_frame(tvb, at)
    if what == "more" then return at, size end
    if what == "frame" then
      show_frame(tvb, pinfo, root, at, size)
    else
      local tree = root:add(proto, tvb(at, size), string.format("%s: %d bytes of noise", NAME, size))
      tree:add(F.noise, tvb(at, size)):add_proto_expert_info(E.noise)
    end
    at = at + size
  end
end

-- Joins the bytes that a record of a serial line left over with the next record of the same sender. A record that begins
-- with a marker begins a frame.
local function join(tvb, pinfo)
  if not MARKER then return tvb end
  local key = line_of(pinfo) .. " " .. tostring(told_sender(pinfo))
  if not pinfo.visited then
    if held[key] and tvb:raw():sub(1, #MARKER) ~= MARKER then joined[pinfo.number] = held[key] end
    held[key] = nil
  end
  local before = joined[pinfo.number]
  if not before then return tvb, key end
  return ByteArray.new(before .. tvb:raw(), true):tvb(NAME .. " joined"), key
end

local function dissect(tvb, pinfo, root)
  pinfo.cols.protocol = NAME
  pinfo.cols.info = ""
  local length = tvb:len()
  local data, key = join(tvb, pinfo)
  local at, size = show_frames(data, pinfo, root)
  if not at then return length end
  if pinfo.can_desegment > 0 then
    pinfo.desegment_offset = at
    pinfo.desegment_len = size and size - (data:len() - at) or DESEGMENT_ONE_MORE_SEGMENT
    return length
  end
  if key and not pinfo.visited then held[key] = data:raw(at) end
  local tree = root:add(proto, data(at), string.format("%s: a part of a frame", NAME))
  tree:add(F.data, data(at))
  tree:add_proto_expert_info(E.cut)
  return length
end

-- hoot, the MoCoBus protocol: break, address, sub-address, command, length and data. A reply does not say what it answers.
-- Serial lines, as DLT_USER1, or TCP by "Decode As".

local HEAD = { { "break", "bytes", size = 6 }, { "address", "u8" }, { "sub_address", "u8" } }
local function header(...)
  local list = {}
  for index, row in ipairs(HEAD) do list[index] = row end
  for _, row in ipairs({ ... }) do list[#list + 1] = row end
  return rows(list)
end
local LENGTH = { "length", "u8" }
local REQUEST = header({ "command", "u8" }, LENGTH)
local CORE = header({ "command", "u8" }, LENGTH, { "core_command", "u8" })
local REPLY = header({ "response_code", "u8", names = N.response_code }, LENGTH)

function next_frame(tvb, at)
  local bytes = tvb:raw()
  local begin = bytes:find(MARKER, at + 1, true)
  if not begin then
    -- The last bytes may be the begin of a break.
    local zeros = math.min(#bytes:match("%z*$"), 5, #bytes - at)
    if zeros == #bytes - at then return "more" end
    return "noise", #bytes - at - zeros
  end
  if begin > at + 1 then return "noise", begin - 1 - at end
  local length = bytes:byte(at + 10)
  if not length then return "more" end
  local size = 10 + length
  if #bytes - at >= size then return "frame", size end
  -- The rest of this packet is lost if another one begins.
  local other = bytes:find(MARKER, at + 11, true)
  if other then return "noise", other - 1 - at end
  return "more", size
end

-- Message whose data has this length; a command has exactly the data of its table.
local function fitting(candidates, tvb, at, left)
  for _, message in ipairs(candidates) do
    local size = 0
    for _, row in ipairs(message) do size = size + (row.size or 0) end
    local fits = left == size
    if message.name == "SetName" then fits = left >= 1 and left <= 10 end
    if message.name == "MotorMove" then fits = fits and tvb(at + 1, 4):uint() > 0 end
    if fits then return message end
  end
end

function read_frame(tvb, at, size, sender)
  local address, command = tvb(at + 6, 1):uint(), tvb(at + 8, 1):uint()
  local frame = { header = REQUEST, body = at + 10, stop = at + size, sub = tvb(at + 7, 1), tag = "" }
  frame.sender = sender or (address == 0 and "device" or "host")
  if frame.sender == "device" then
    frame.header = REPLY
    frame.answers = address == 0
    frame.message = messages_of("device", address * 65536 + tvb(at + 7, 2):uint())[1]
    if command ~= 1 then
      frame.finish = function(tree) tree:add_proto_expert_info(E.refused, "The node refuses the request") end
    end
    return frame
  end
  local bus = address == 1 and 1 or 0
  if bus == 0 and command == 1 and size > 10 then
    bus, command, frame.header, frame.body = 2, tvb(at + 10, 1):uint(), CORE, at + 11
  end
  local candidates = messages_of("host", bus * 65536 + command * 256 + tvb(at + 7, 1):uint())
  frame.message = fitting(candidates, tvb, frame.body, frame.stop - frame.body)
  if candidates[1] then frame.why = "The data is longer or shorter than that of " .. candidates[1].name end
  frame.asks = address > 1
  return frame
end

-- The byte in front of a value tells its type, and the query its meaning.
local VALUE_TYPE = rows({ { "value_type", "u8", names = N.value_type } })[1]
local VALUE = { [0] = "u8", "u16", "i16", "i32", "u32", "i32", "text" }
-- Fields of all values that answers may have, because none can be added later.
local VALUES = {}
local function value_row(kind, meaning)
  local row = { "value", kind }
  for key, what in pairs(meaning) do row[key] = what end
  local id = table.concat({ kind, tostring(row.names), tostring(row.flags) }, " ")
  VALUES[id] = VALUES[id] or field_of(row)
  row.field = VALUES[id]
  return row
end
for _, kind in pairs(VALUE) do value_row(kind, {}) end
for _, types in pairs(ANSWERS) do
  for value_type, meaning in pairs(types) do value_row(VALUE[value_type], meaning) end
end

function BY_HAND.Reply(tree, tvb, at, stop, _, frame)
  if at == stop then return stop end
  local value_type = tvb(at, 1):uint()
  local kind = VALUE[value_type]
  if not kind or (SIZE[kind] and stop - at - 1 ~= SIZE[kind]) then
    tree:add(F.data, tvb(at, stop - at))
    return stop
  end
  add_value(tree, VALUE_TYPE, tvb(at, 1))
  local query = frame.request and frame.request.message and frame.request.message.name
  local meaning = ANSWERS[query] and ANSWERS[query][value_type]
  if ANSWERS[query] and not meaning then
    tree:add_proto_expert_info(E.unasked, "This type does not answer the query " .. query)
  end
  local row = value_row(kind, meaning or (value_type == 5 and { decimals = 2 } or {}))
  if stop - at > 1 then add_value(tree, row, tvb(at + 1, stop - at - 1)) else tree:add(row.field, "") end
  return stop
end
proto.dissector = dissect
proto.fields, proto.experts = all_fields, E
DissectorTable.get("wtap_encap"):add(wtap_encaps.USER1, proto)
DissectorTable.get("tcp.port"):add_for_decode_as(proto)
