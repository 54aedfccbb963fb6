//! Notifications: messages by which a device tells what happened.

use motion_core::wire::{Bool, Counted, DecodeError, EncodeError, Fields, Message, Rest, Row, Visitor};
use motion_core::{__message_features, element, message, open_enum, unit};

use super::dialect::{Dialect, InNewer, exact};
use super::{AuxInputs, MotorAddress, Normalized, Rotations, RotationsPerSecond, RotationsPerSecondSquared};

message! {
    /// Motors that were connected or disconnected. Source: kOS, `MotorStatus`.
    #[derive(Default)]
    pub struct MotorStatus<'a> in BE {
        ;
        /// Motors that were connected or disconnected, one entry each.
        motors: Counted<'a, MotorPresence>,
    }

    /// Error that the device reports. Source: kOS, `ErrorStatus`; safety decision 9, decisions K-P3 and K-P12.
    #[derive(Default)]
    pub struct ErrorStatus<'a> in BE {
        /// Code that says what failed.
        error_code: ErrorCode,
        /// Motor that the error is about. If the error is about no motor, the address is 0 or has no meaning.
        motor_address: MotorAddress,
    }

    /// Position of a motor that came to rest, sent once for each command to move. Source: kOS, `MotorPosition`;
    /// decision K-M10.
    #[derive(Default)]
    pub struct MotorPosition<'a> in BE {
        /// Motor that rests.
        motor_address: MotorAddress,
        /// Position of the motor, as devices report it (see `Motor::relative_position`).
        position: Rotations,
    }

    /// Inputs for cameras and triggers, sent when one of them changed. Source: kOS, `AuxInputStatus`.
    #[derive(Default)]
    pub struct AuxInputStatus<'a> in BE {
        /// State of all inputs.
        status: AuxInputs,
    }

    /// Message that the device does not know. Source: kOS, `UnsupportedMessage`; decisions K-P10 and K-P11.
    #[derive(Default)]
    pub struct UnsupportedMessage<'a> in BE {
        ;
        /// Bytes of the message, from its version byte on, as many as fit.
        message: Rest<'a>,
    }
}

element! {
    /// One motor of a [`MotorStatus`].
    pub struct MotorPresence in BE, "motor_count" {
        /// Address of the motor.
        motor_address: MotorAddress,
        /// Whether the motor is connected.
        online_status: Bool,
        /// Type of the motor.
        motor_type: MotorType,
        /// Greatest speed of the motor when it is moved by hand.
        max_max_setup_speed: RotationsPerSecond,
        /// Greatest speed of the motor in a move.
        max_max_move_speed: RotationsPerSecond,
        /// Greatest acceleration of the motor.
        max_max_acceleration: RotationsPerSecondSquared,
    }

    /// One motor of a [`PlaybackStatus`].
    pub struct MotorPlace in BE, "motor_count" {
        /// Address of the motor.
        motor_address: MotorAddress,
        /// Position of the motor.
        position: Rotations,
    }
}

open_enum! {
    /// Type of a motor. Source: kOS, `MotorStatus`.
    pub struct MotorType(u8) {
        /// Axis such as slider, pan or tilt.
        AXIS = 0,
        /// Ring of a lens: focus, iris or zoom.
        FIZ = 1,
    }

    /// State of a device in its move. Source: kOS, `PlaybackStatus`; decisions K-J12 to K-J16.
    pub struct PlaybackState(u8) {
        /// No move is stored, or the move was not begun.
        NO_MOVE = 0,
        /// The motors are at the position where the move begins.
        MOTORS_HOME = 1,
        /// The move runs forward. Devices repeat this while it runs.
        START_FORWARD = 2,
        /// The move runs back. Devices repeat this while it runs.
        START_REVERSE = 3,
        /// The move reached its end. A loop or photos may follow.
        END_OF_MOVE = 4,
        /// The move ended for any reason, and the device no longer stores it.
        FULL_STOP = 5,
        /// A frame of a time lapse begins.
        START_FRAME = 6,
        /// The move is ready to be played.
        SETUP_COMPLETED = 7,
        /// The delay before the move was started.
        DELAY_TIMER_STARTED = 8,
        /// The pre-roll of the camera started. Devices do not support it, and never send this.
        PRE_CAMERA_ROLL_STARTED = 9,
        /// The post-roll of the camera is completed. Devices do not support it, and never send this.
        POST_CAMERA_ROLL_COMPLETED = 10,
        /// The photos before the move are started.
        PRE_MOVE_PHOTOS_STARTED = 11,
        /// The photos after the move are completed.
        POST_MOVE_PHOTOS_COMPLETED = 12,
        /// The motors rest for the next photo.
        SMS_MOTORS_STOPPED = 13,
    }

    /// Code of an error. Source: kOS, `ErrorStatus`; decision K-P12.
    pub struct ErrorCode(u8) {
        /// The motors did not reach the position where the move begins.
        RETURN_TO_FIRST_KEYFRAME = 0,
        /// Writing the memory failed. Obsolete.
        FLASH_WRITE = 1,
        /// The move cannot be played, or a command cannot be obeyed while the move is played.
        CANNOT_EXECUTE_MOVE = 2,
        /// The move is malformed.
        TRAJECTORY = 3,
        /// The device has no motor with this address.
        BAD_MOTOR_ADDRESS = 4,
        /// The device has no motors.
        NO_MOTORS = 6,
        /// Reading the memory failed. Obsolete.
        FLASH_READ = 7,
        /// A motor ran away. It lost its range.
        RUNAWAY = 10,
        /// A motor left the mode in which it follows a move.
        NOT_IN_PVT_MODE = 11,
        /// A motor stopped at once in a move.
        PVT_QUICK_STOP = 12,
        /// A motor lost a part of a move.
        PVT_INTEGRITY = 13,
        /// The range of a motor is impossible. The motor lost it.
        CALIBRATION = 14,
        /// The password is wrong.
        LOCKED_OUT = 15,
        /// A motor has a fault. It lost its range.
        FAULT = 16,
        /// The duration of the move is impossible.
        INVALID_MOVE_TIME = 17,
        /// The setup of an external intervalometer failed.
        INTERVALOMETER_SETUP = 19,
        /// The input of an external intervalometer failed.
        INTERVALOMETER_INPUT = 20,
    }
}

impl ErrorCode {
    /// Whether the error voids the range of the motor (decision K-P12).
    #[must_use]
    pub const fn resets_axis(self) -> bool {
        matches!(self, Self::RUNAWAY | Self::CALIBRATION | Self::FAULT)
    }

    /// Whether the error is about no motor, so that the address in the message is 0.
    #[must_use]
    pub const fn is_about_no_motor(self) -> bool {
        matches!(self.0, 0..=3 | 6 | 7 | 19 | 20)
    }

    /// Whether the error is about a motor of the device, whose address the message then holds.
    #[must_use]
    pub const fn names_motor(self) -> bool {
        matches!(self.0, 10..=14 | 16)
    }
}

unit! {
    /// Number of photos, as an IEEE number, which is exact up to 16 777 216 (decision K-N2).
    pub struct Photos(f32) "";
}

impl Photos {
    /// Number of photos, rounded; `None` if it is negative, infinite or NaN.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the conversion cuts off the fraction, and ends at the greatest number"
    )]
    pub fn count(self) -> Option<u32> {
        (self.0.is_finite() && self.0 >= 0.0).then(|| (f64::from(self.0) + 0.5) as u32)
    }
}

#[expect(clippy::struct_field_names, reason = "the names of the specification")]
mod newer {
    use super::{Counted, InNewer, MotorAddress, MotorPlace, Normalized, Photos, PlaybackState, Rotations, message};

    message! {
        pub(super) struct PlaybackStatus<'a> in BE {
            playback_status: PlaybackState,
            elapsed_time: Normalized,
            ;
            photo_count: InNewer<Photos>,
            motors: Counted<'a, MotorPlace>,
        }

        pub(super) struct MotorCalibrated<'a> in BE {
            motor_address: MotorAddress,
            ;
            begin_position: InNewer<Rotations>,
            end_position: InNewer<Rotations>,
        }
    }
}

#[expect(clippy::struct_field_names, reason = "the names of the specification")]
mod older {
    use super::{Counted, MotorAddress, MotorPlace, Normalized, PlaybackState, Rotations, message};

    message! {
        pub(super) struct PlaybackStatus<'a> in BE {
            playback_status: PlaybackState,
            elapsed_time: Normalized,
            ;
            motors: Counted<'a, MotorPlace>,
        }

        pub(super) struct MotorCalibrated<'a> in BE {
            motor_address: MotorAddress,
            end_position: Rotations,
        }
    }
}

motion_core::__logged! {
    /// Progress of the device in its move, sent unasked at each change of state, and from time to time while the move runs.
    ///
    /// Source: kOS, `PlaybackStatus`; safety decision 7, decisions K-M3, K-N2 and K-P7.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct PlaybackStatus<'a> {
        /// State of the device in its move.
        pub playback_status: PlaybackState,
        /// Elapsed part of the move, 0 to 1.
        pub elapsed_time: Normalized,
        /// Number of photos taken in the move; `None` in the older dialect.
        pub photo_count: Option<Photos>,
        /// Positions of the motors.
        pub motors: &'a [MotorPlace],
        /// Bytes after the known fields, kept as they came.
        pub tail: &'a [u8],
    }
}

impl<'a> PlaybackStatus<'a> {
    /// Bytes before the count of motors in the older dialect.
    const OLD_FIXED: usize = 5;

    fn body(&self) -> Dialect<newer::PlaybackStatus<'a>, older::PlaybackStatus<'a>> {
        let Self { playback_status, elapsed_time, photo_count, motors, tail } = *self;
        let motors = Counted(motors);
        match photo_count.map(InNewer) {
            Some(photo_count) => {
                Dialect::Newer(newer::PlaybackStatus { playback_status, elapsed_time, photo_count, motors, tail })
            }
            None => Dialect::Older(older::PlaybackStatus { playback_status, elapsed_time, motors, tail }),
        }
    }

    /// Whether a body of `len` bytes has exactly the length of the older layout with `count` motors. `count` is the
    /// byte at the place where that layout counts the motors.
    fn is_older(len: usize, count: u8) -> bool {
        let motors = usize::from(count).saturating_mul(size_of::<MotorPlace>());
        len == motors.saturating_add(Self::OLD_FIXED).saturating_add(1)
    }
}

impl<'a> Message<'a> for PlaybackStatus<'a> {
    const LAYOUT: &'static [Row] = newer::PlaybackStatus::LAYOUT;

    #[inline]
    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        if body.get(Self::OLD_FIXED).is_some_and(|&count| Self::is_older(body.len(), count)) {
            let older = older::PlaybackStatus::decode(body)?;
            let older::PlaybackStatus { playback_status, elapsed_time, motors: Counted(motors), tail } = older;
            Ok(Self { playback_status, elapsed_time, photo_count: None, motors, tail })
        } else {
            let newer = newer::PlaybackStatus::decode(body)?;
            let newer::PlaybackStatus { playback_status, elapsed_time, photo_count, motors: Counted(motors), tail } =
                newer;
            Ok(Self { playback_status, elapsed_time, photo_count: Some(photo_count.0), motors, tail })
        }
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        self.body().encoded_len()
    }

    #[inline]
    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let Some(photos) = self.photo_count else {
            exact("PlaybackStatus.photo_count", self.tail)?;
            return self.body().encode_into(out);
        };
        // With a tail of certain lengths, a reader would take the first byte of the photos for the count of motors.
        let [first, ..] = photos.0.to_be_bytes();
        if Self::is_older(self.encoded_len(), first) {
            return Err(EncodeError::Tail { what: "PlaybackStatus.motor_count", len: self.tail.len() });
        }
        self.body().encode_into(out)
    }
}

impl Fields for PlaybackStatus<'_> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        self.body().fields(visitor);
    }
}

__message_features! { 'a [PlaybackStatus<'a>] PlaybackStatus }

motion_core::__logged! {
    /// Range of a motor that was calibrated or reset: the answer to `MarkEndPosition` and `ResetAxis`.
    ///
    /// Earlier reports of the motor are void after it; ask for its `MotorInfo`. Source: kOS, `MotorCalibrated`; safety
    /// decision 7, decision K-M8.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct MotorCalibrated<'a> {
        /// Motor whose range changed.
        pub motor_address: MotorAddress,
        /// Begin of the range; `None` in the older dialect.
        pub begin_position: Option<Rotations>,
        /// End of the range; 0 if the motor has no range.
        pub end_position: Rotations,
        /// Bytes after the known fields, kept as they came.
        pub tail: &'a [u8],
    }
}

impl<'a> MotorCalibrated<'a> {
    /// Bytes of the body in the older dialect.
    const OLD_LEN: usize = 5;

    fn body(&self) -> Dialect<newer::MotorCalibrated<'a>, older::MotorCalibrated<'a>> {
        let Self { motor_address, begin_position, end_position, tail } = *self;
        match begin_position.map(InNewer) {
            Some(begin_position) => {
                let end_position = InNewer(end_position);
                Dialect::Newer(newer::MotorCalibrated { motor_address, begin_position, end_position, tail })
            }
            None => Dialect::Older(older::MotorCalibrated { motor_address, end_position, tail }),
        }
    }
}

impl<'a> Message<'a> for MotorCalibrated<'a> {
    const LAYOUT: &'static [Row] = newer::MotorCalibrated::LAYOUT;

    #[inline]
    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        if body.len() == Self::OLD_LEN {
            let older::MotorCalibrated { motor_address, end_position, tail } = older::MotorCalibrated::decode(body)?;
            Ok(Self { motor_address, begin_position: None, end_position, tail })
        } else {
            let newer = newer::MotorCalibrated::decode(body)?;
            let newer::MotorCalibrated { motor_address, begin_position, end_position, tail } = newer;
            Ok(Self { motor_address, begin_position: Some(begin_position.0), end_position: end_position.0, tail })
        }
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        self.body().encoded_len()
    }

    #[inline]
    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        if self.begin_position.is_none() {
            exact("MotorCalibrated.begin_position", self.tail)?;
        }
        self.body().encode_into(out)
    }
}

impl Fields for MotorCalibrated<'_> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        self.body().fields(visitor);
    }
}

__message_features! { 'a [MotorCalibrated<'a>] MotorCalibrated }

#[cfg(test)]
mod tests {
    use super::*;

    fn status(photo_count: Option<Photos>, tail: &[u8]) -> PlaybackStatus<'_> {
        let (playback_status, elapsed_time) = (PlaybackState::START_FORWARD, Normalized(0.5));
        PlaybackStatus { playback_status, elapsed_time, photo_count, motors: &[], tail }
    }

    #[test]
    fn a_tail_that_would_change_the_dialect_is_refused() {
        let mut out = [0; 32];
        // A reader would take the first byte of these photos for a count of one motor, and the tail for its last byte.
        let photos = Photos(f32::from_bits(0x0100_0000));
        let refused = status(Some(photos), &[0]).encode_into(&mut out);
        assert_eq!(refused, Err(EncodeError::Tail { what: "PlaybackStatus.motor_count", len: 1 }));
        assert_eq!(status(Some(photos), &[0; 2]).encode_into(&mut out), Ok(12));
        let refused = status(None, &[0]).encode_into(&mut out);
        assert_eq!(refused, Err(EncodeError::Tail { what: "PlaybackStatus.photo_count", len: 1 }));
        assert_eq!(out[12..], [0; 20], "nothing is written when a message is refused");

        let mut calibrated = MotorCalibrated {
            motor_address: MotorAddress(1),
            begin_position: None,
            end_position: Rotations(5.0),
            tail: &[1],
        };
        let refused = calibrated.encode_into(&mut out);
        assert_eq!(refused, Err(EncodeError::Tail { what: "MotorCalibrated.begin_position", len: 1 }));
        calibrated.begin_position = Some(Rotations(0.0));
        assert_eq!(calibrated.encode_into(&mut out), Ok(10));
    }

    #[test]
    fn between_the_dialects_a_message_is_cut_short() {
        for len in 6..9 {
            let truncated = MotorCalibrated::decode(&[1; 9][..len]).unwrap_err();
            assert!(matches!(truncated, DecodeError::Truncated { have, .. } if have == len), "{truncated}");
        }
        assert_eq!(MotorCalibrated::decode(&[0; 5]).unwrap().begin_position, None);
        assert_eq!(MotorCalibrated::decode(&[0; 9]).unwrap().begin_position, Some(Rotations(0.0)));
    }

    #[test]
    fn errors_say_whether_a_motor_lost_its_range() {
        let all = 0..=u8::MAX;
        assert!(all.clone().map(ErrorCode).filter(|code| code.resets_axis()).map(|code| code.0).eq([10, 14, 16]));
        assert!(all.map(ErrorCode).filter(|code| code.names_motor()).map(|code| code.0).eq([10, 11, 12, 13, 14, 16]));
    }

    #[test]
    fn photos_are_counted_where_they_can_be() {
        let counts = [0.0, -0.0, 0.49, 0.5, 42.0, 16_777_216.0, 1e20].map(|photos| Photos(photos).count());
        let wanted = [0, 0, 0, 1, 42, 16_777_216, u32::MAX].map(Some);
        assert_eq!(counts, wanted);
        assert_eq!([f32::NAN, f32::INFINITY, -1.0].map(|photos| Photos(photos).count()), [None; 3]);
    }
}
