//! Law 14, and what lint finds: each rule of the decisions, and nothing in what is legal.

use kos_proto::lint::Context;
use kos_proto::message::{
    AuxInputStatus, AuxInputs, BumpPositionSpeedAcceleration, DeviceGUID, DeviceInfo, DeviceType, Empty, ErrorCode, ErrorStatus,
    FirmwareVersion, GetNetworkInfo, Ipv4, LEDStatus, LedMode, MacAddress, MarkBeginPosition, MarkEndPosition, Motor, MotorAddress,
    MotorCalibrated, MotorEntry, MotorInfo, MotorInfos, MotorPlace, MotorPosition, MotorPresence, MotorStatus, MotorType,
    NetworkInfo, Normalized, OldMotorEntry, Photos, PlaybackDirection, PlaybackMode, PlaybackState, PlaybackStatus, ResetAxis,
    Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds, SetPassword, SetPositionSpeedAcceleration, SetupPlayback,
    SoftwareID, StartPlayback, TakePicture, UnsupportedMessage,
};
use kos_proto::trajectory::{
    Axis, Block, Blocks, DelayInterval, DelayMode, LoopCount, Playback, Point, Points, Segment, TimeLapse, TrajectoryData,
};
use kos_proto::{DeviceMessage, EncodeError, HostMessage};
use motion_core::lint::Severity::{Error, Warning};
use motion_core::lint::{Lints, Severity};
use motion_core::wire::{Block16, Bool, Counted, Messages, Newer, Password, Rest};

const NOTHING: Empty<'_> = Empty { tail: &[] };
const MOTOR: MotorAddress = MotorAddress(2);
const ACCELERATION: RotationsPerSecondSquared = RotationsPerSecondSquared(50.0);
const SPEED: RotationsPerSecond = RotationsPerSecond(20.0);

fn found(lints: Lints) -> Vec<(Severity, &'static str)> {
    lints.into_iter().map(|lint| (lint.severity, lint.what)).collect()
}

fn host(message: HostMessage<'_>) -> Vec<(Severity, &'static str)> {
    found(message.lint(&Context::default()))
}

fn device(message: DeviceMessage<'_>) -> Vec<(Severity, &'static str)> {
    found(message.lint(&Context::default()))
}

/// A motor that goes from 2 to 12, and stands at 5.
fn motor() -> Motor {
    Motor::from(&entry(MOTOR.0))
}

fn entry(address: u8) -> MotorEntry {
    let (position, begin, end) = (Rotations(5.0), Rotations(2.0), Rotations(12.0));
    let (setup, play) = (RotationsPerSecond(166.7), RotationsPerSecond(100.0));
    MotorEntry::new(MotorAddress(address), position, begin, end, setup, play, ACCELERATION)
}

fn go(position: f32, speed: f32, acceleration: f32) -> HostMessage<'static> {
    let (speed, acceleration) = (RotationsPerSecond(speed), RotationsPerSecondSquared(acceleration));
    let message = SetPositionSpeedAcceleration::move_to(MOTOR, Rotations(position), speed, acceleration);
    HostMessage::SetPositionSpeedAcceleration(message)
}

fn bump(delta: f32, speed: f32, acceleration: f32) -> HostMessage<'static> {
    HostMessage::BumpPositionSpeedAcceleration(BumpPositionSpeedAcceleration {
        motor_address: MOTOR,
        delta: Rotations(delta),
        speed: RotationsPerSecond(speed),
        acceleration: RotationsPerSecondSquared(acceleration),
        tail: &[],
    })
}

fn password(text: &[u8]) -> SetPassword<'_> {
    SetPassword { password: Password(text), tail: &[] }
}

fn playback() -> Playback<'static> {
    Playback {
        playback_mode: PlaybackMode::LIVE_MOTION,
        duration: Seconds(10.0),
        rapid_reverse_duration: Seconds(10.0),
        loop_after_rapid_reverse: LoopCount::NONE,
        loop_after_reverse: LoopCount::FOREVER,
        delay_mode: DelayMode::UNTIL,
        delay_interval_bits: DelayInterval::from_unix_time(1_700_000_000),
        camera_roll_enabled: Bool::FALSE,
        camera_roll_pre_delay: Seconds(0.0),
        camera_roll_post_delay: Seconds(0.0),
        flash_mark_enabled: 0,
        flash_mark_type: 0,
        flash_mark_post_delay: Seconds(0.0),
        use_external_trigger: 0,
        using_lanc: 0,
        return_to_home_percent: Normalized(1.0),
        tail: &[],
    }
}

fn time_lapse() -> TimeLapse<'static> {
    TimeLapse {
        delay: Seconds(0.0),
        exposure: Seconds(0.0),
        move_photos: 0,
        not_used: 0,
        pre_move_photos: 0,
        post_move_photos: 0,
        tail: &[],
    }
}

fn axis(segment_count: u8) -> Block<'static> {
    Block::Axis(Axis { motor_address: MOTOR, segment_count, tail: &[] })
}

fn segment(segment_number: u8, points: [(f32, f32); 4]) -> Block<'static> {
    let points = Points(points.map(|(time, position)| Point::new(time, position)));
    Block::Segment(Segment { motor_address: MOTOR, segment_number, points, tail: &[] })
}

const FIRST: [(f32, f32); 4] = [(0.0, 0.0), (0.1, 0.0), (0.4, 0.5), (0.5, 0.5)];
const SECOND: [(f32, f32); 4] = [(0.5, 0.5), (0.6, 0.5), (0.9, 1.0), (1.0, 1.0)];

/// What lint says of a move of these blocks.
fn blocks(blocks: &[Block<'_>]) -> Vec<(Severity, &'static str)> {
    let mut out = [0; 1024];
    let blocks = Blocks::encode(blocks, &mut out).unwrap();
    host(HostMessage::SetTrajectoryData(TrajectoryData { blocks, tail: &[] }))
}

/// What lint says of a sound move, played in this way.
fn played(playback: Playback<'_>) -> Vec<(Severity, &'static str)> {
    let (playback, time_lapse) = (Block::Playback(playback), Block::TimeLapse(time_lapse()));
    blocks(&[playback, time_lapse, axis(2), segment(0, FIRST), segment(1, SECOND)])
}

/// What lint says of a sound move but for these segments.
fn segments(count: u8, segments: &[Block<'_>]) -> Vec<(Severity, &'static str)> {
    let first = [Block::Playback(playback()), Block::TimeLapse(time_lapse()), axis(count)];
    blocks(&[&first, segments].concat())
}

#[test]
fn nothing_is_found_in_what_a_client_may_send() {
    let reset = ResetAxis { motor_address: MotorAddress::ALL, tail: &[] };
    let start = StartPlayback { direction: PlaybackDirection::FORWARD, start_time: Seconds(0.0), tail: &[] };
    let StartPlayback { direction, start_time, tail } = start;
    let setup = SetupPlayback { direction, start_time, delay_return: Bool::TRUE, tail };
    let lamps = LEDStatus { master_status: LedMode::ON, slave_status: LedMode::FAST_BLINK, tail: &[] };
    let mut out = [0; 256];
    let sound = [
        Block::Playback(playback()),
        Block::TimeLapse(time_lapse()),
        axis(2),
        segment(0, FIRST),
        segment(1, SECOND),
    ];
    let move_data = TrajectoryData { blocks: Blocks::encode(&sound, &mut out).unwrap(), tail: &[] };
    let messages = [
        HostMessage::KeepAlive(NOTHING),
        HostMessage::GetNetworkInfo(GetNetworkInfo::new(true)),
        HostMessage::GetLEDStatus(NOTHING),
        HostMessage::SetLEDStatus(lamps),
        HostMessage::GetMotorInfo(NOTHING),
        HostMessage::GetDeviceInfo(NOTHING),
        HostMessage::SetUserPassword(password(b"")),
        HostMessage::SetDevicePassword(password(b"thirty-two bytes are not too long")[..].into_password()),
        HostMessage::GetTrajectoryData(NOTHING),
        HostMessage::SetTrajectoryData(move_data),
        HostMessage::GetDeviceGUID(NOTHING),
        HostMessage::GetSoftwareID(NOTHING),
        HostMessage::SetSoftwareID(SoftwareID { platform: 200, tail: &[] }),
        HostMessage::ResetDevice(NOTHING),
        HostMessage::ResetAxis(reset),
        HostMessage::MarkBeginPosition(MarkBeginPosition { motor_address: MotorAddress(1), tail: &[] }),
        HostMessage::MarkEndPosition(MarkEndPosition { motor_address: MotorAddress(10), tail: &[] }),
        HostMessage::StartPlayback(start),
        HostMessage::StopPlayback(NOTHING),
        HostMessage::RapidToFirstKeyFrame(NOTHING),
        HostMessage::TakePicture(TakePicture { motor_address: MotorAddress::ALL, exposure: Seconds(0.5), tail: &[] }),
        HostMessage::SetupPlayback(setup),
        go(10.0, 20.0, 50.0),
        bump(-3.0, 20.0, 50.0),
    ];
    for message in messages {
        assert_eq!(host(message), [], "{message}");
        assert_eq!(found(message.lint(&Context::default().with_motors(&[motor()]))).iter().filter(|(severity, what)| (*severity, *what) != (Error, "motor_address")).count(), 0, "{message}");
    }
    let mut names: Vec<_> = messages.iter().map(Messages::name).collect();
    names.dedup();
    assert_eq!(names.len(), HostMessage::ALL.len(), "all of them");
}
