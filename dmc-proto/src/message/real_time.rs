//! Real-time moves: to a frame, run, shoot.

use motion_core::fixed::{Deci, Milli};
use motion_core::wire::Bool;
use motion_core::{element, flags, message, open_enum, unit};

use super::{Capabilities, Motor, Steps};

unit! {
    /// Frames a second, in thousandths: 23.976.
    pub struct FramesPerSecond(Milli<u32>) "frames/s";
    /// A frame of the shot, as the host counts.
    pub struct FrameNumber(i32) "";
    /// A time.
    pub struct Milliseconds(u32) "ms";
    /// A short time.
    pub struct ShortMilliseconds(u16) "ms";
    /// A shutter angle, 0 to 360 (decision D-28).
    pub struct Degrees(u16) "°";
    /// A DMX channel, 1 to 512; 0 where there is none.
    pub struct DmxChannel(u16) "";
    /// How much of a frame's motion is blurred, in tenths of a percent (decision D-27).
    pub struct BlurPercent(Deci<u16>) "%";
}

message! {
    /// Send all motors, and the DMX channels, where the uploaded move has them at a frame.
    ///
    /// Source: DMC, MSG_RT_POSITION_FRAME; decision D-31, safety decision 8.
    #[derive(Default)]
    pub struct RtPositionFrame<'a> in LE {
        /// Which frame.
        frame: FrameNumber,
    }

    /// Get ready to run the uploaded move: go to the start, then to the pre-roll point, and wait for the start signal.
    ///
    /// Source: DMC, MSG_RT_RUN_MOVE; safety decision 9, decisions D-23 and D-24.
    #[derive(Default)]
    pub struct RtRunMove<'a> in LE {
        /// How fast.
        fps_x1000: FramesPerSecond,
        /// The first frame.
        start_frame: FrameNumber,
        /// The last frame.
        end_frame: FrameNumber,
        /// Time to get up to speed before the first frame.
        pre_roll_ms: Milliseconds,
        /// Time to come to rest behind the last frame.
        post_roll_ms: Milliseconds,
        /// Whether the uploaded DMX levels and triggers run along.
        sync_dmx: Bool,
        /// The outputs that mark the first frame.
        bloop_location: BloopOutputs,
        /// The DMX channel that marks the first frame, 0 for none.
        bloop_dmx_channel: DmxChannel,
        /// How long the mark is.
        bloop_ms: ShortMilliseconds,
        ;
        /// Loops and camera triggers; for devices that can.
        flags: Option<RunFlags>,
        /// Where the shutter opens, of cameras that are triggered for every frame.
        open_angle: Option<Degrees>,
        /// Where the shutter closes, of cameras that are triggered for every frame.
        close_angle: Option<Degrees>,
    }

    /// Get ready to move through one frame while the shutter is open. Source: DMC, MSG_RT_SHOOT_FRAME; decision D-25.
    #[derive(Default)]
    pub struct RtShootFrame<'a> in LE {
        /// Which frame.
        frame: FrameNumber,
        /// Which way the motors move through it.
        direction: Direction,
        /// How long the shutter is open.
        exposure_ms: Milliseconds,
        /// How much of the frame's motion is blurred; 0 stands for all.
        blur_x10: BlurPercent,
        ;
        /// Motors that do not follow the uploaded move.
        motors: &'a [MotorPair],
    }

    /// Get ready to move through one frame, with a shutter that is described by its angles.
    ///
    /// Source: DMC, MSG_RT_SHOOT_FRAME2; decisions D-1, D-25, D-27 and D-28.
    #[derive(Default)]
    pub struct RtShootFrame2<'a> in LE {
        /// Which frame.
        frame: FrameNumber,
        /// How long the shutter is open.
        exposure_ms: Milliseconds,
        /// Where the shutter opens.
        open_angle: Degrees,
        /// Where the shutter closes.
        close_angle: Degrees,
        ;
        /// Motors that do not follow the uploaded move.
        motors: &'a [MotorPair],
    }

    /// Start of what the device prepared: the signal of the host, or the news that the operator gave it.
    ///
    /// Source: DMC, MSG_RT_GO.
    #[derive(Default)]
    pub struct RtGo<'a> in LE {}

    /// News that the move, or the frame, is done. Source: DMC, MSG_RT_END.
    #[derive(Default)]
    pub struct RtEnd<'a> in LE {}

    /// Request to end a loop at its next end point. Source: DMC, MSG_RT_STOP_LOOP.
    #[derive(Default)]
    pub struct RtStopLoop<'a> in LE {}

    /// Run all motors towards a frame of the uploaded move; they have to be on one.
    ///
    /// Source: DMC, MSG_RT_JOG_ALL; safety decision 8.
    #[derive(Default)]
    pub struct RtJogAll<'a> in LE {
        /// How fast.
        fps_x1000: FramesPerSecond,
        /// The frame where they stop.
        destination: FrameNumber,
    }
}

impl RtRunMove<'_> {
    /// The same run with those of the last fields that a device expects: 29 bytes of data, 31 if it can loop, 35 if it can
    /// trigger a camera (decision D-23).
    ///
    /// A field that it expects and that is not set, is set to 0. One that it does not expect is left out if it is 0; what
    /// asks for something is kept, for [lint](crate::lint) to refuse.
    #[must_use]
    pub fn for_device(mut self, capabilities: Capabilities) -> Self {
        let flags = self.flags.unwrap_or_default();
        let (open, close) = (self.open_angle.unwrap_or_default(), self.close_angle.unwrap_or_default());
        let zero = Degrees(0);
        let angles = capabilities.contains(Capabilities::CAMERA_TRIGGER) || (open, close) != (zero, zero);
        let any = angles || capabilities.contains(Capabilities::LOOP) || !flags.is_empty();
        self.flags = any.then_some(flags);
        (self.open_angle, self.close_angle) = (angles.then_some(open), angles.then_some(close));
        self
    }
}

element! {
    /// The way of one motor while the shutter is open.
    pub struct MotorPair in LE, "motor_count" {
        /// Which motor.
        motor: Motor,
        /// Where it begins.
        pos_a: Steps,
        /// Where it ends.
        pos_b: Steps,
    }
}

flags! {
    /// How a move runs. Unknown bits are kept. Source: DMC, MSG_RT_RUN_MOVE, FLAGS.
    pub struct RunFlags(u16) {
        /// There and back, until told otherwise; stronger than `LOOP`.
        PING_PONG = 0x0001,
        /// Again and again, until told otherwise.
        LOOP = 0x0002,
        /// The camera is triggered at the start and at the end: video.
        CAMERA_START_STOP = 0x0010,
        /// The camera is triggered for every frame: stills.
        CAMERA_EVERY_FRAME = 0x0020,
    }

    /// The outputs that mark the first frame. Unknown bits are kept. The names are those of the vendor's firmware
    /// (decision D-24).
    pub struct BloopOutputs(u32) {
        /// The logic output.
        LOGIC_OUT = 0x0000_0001,
        /// The relay output.
        RELAY_OUT = 0x0000_0002,
        /// The DMX channel.
        DMX = 0x0000_0004,
    }
}

open_enum! {
    /// Which way motors move through a frame.
    pub struct Direction(u8) {
        /// Back.
        BACKWARD = 0,
        /// On.
        FORWARD = 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion_core::wire::{DecodeError, Message};

    /// Decision D-23.
    #[test]
    fn a_run_has_as_many_fields_as_its_length_holds() {
        let body: [u8; 40] = core::array::from_fn(|at| u8::try_from(at).unwrap());
        assert_eq!(
            RtRunMove::decode(&body[..28]),
            Err(DecodeError::Truncated { what: "RtRunMove", needed: 29, have: 28 })
        );
        for len in 29..=40 {
            let run = RtRunMove::decode(&body[..len]).unwrap();
            let known = match len {
                29 | 30 => 29,
                31 | 32 => 31,
                33 | 34 => 33,
                _ => 35,
            };
            assert_eq!(run.flags, (len >= 31).then_some(RunFlags(0x1e1d)), "{len} bytes");
            assert_eq!(run.open_angle, (len >= 33).then_some(Degrees(0x201f)), "{len} bytes");
            assert_eq!(run.close_angle, (len >= 35).then_some(Degrees(0x2221)), "{len} bytes");
            assert_eq!(run.tail, &body[known..len], "{len} bytes");
        }
    }

    /// Decision D-23.
    #[test]
    fn a_run_is_as_long_as_a_device_expects() {
        let asked = |flags, angle| RtRunMove {
            flags: Some(RunFlags::from_bits_retain(flags)),
            open_angle: Some(Degrees(angle)),
            close_angle: Some(Degrees(angle)),
            ..RtRunMove::decode(&[1; 29]).unwrap()
        };
        let len = |run: RtRunMove<'_>, capabilities| run.for_device(capabilities).encoded_len();
        let (none, all) = (Capabilities::REAL_TIME, Capabilities::LOOP | Capabilities::CAMERA_TRIGGER);
        for (run, lens) in [
            (RtRunMove::decode(&[1; 29]).unwrap(), [29, 31, 35, 35]),
            (RtRunMove::decode(&[1; 31]).unwrap(), [31, 31, 35, 35]),
            (asked(0, 0), [29, 31, 35, 35]),
            (asked(1, 0), [31, 31, 35, 35]),
            (asked(0, 180), [35; 4]),
        ] {
            let of = [none, Capabilities::LOOP, Capabilities::CAMERA_TRIGGER, all].map(|can| len(run, can));
            assert_eq!(of, lens, "{run:?}");
            assert_eq!(run.for_device(all).flags, Some(run.flags.unwrap_or_default()), "nothing that is asked is lost");
        }
    }

    /// Decision D-25.
    #[test]
    fn a_motor_that_is_cut_off_stays_in_the_tail() {
        let body = [&[0; 11][..], &[1, 2, 0, 0, 0, 3, 0, 0, 0], &[9; 8]].concat();
        let shoot = RtShootFrame::decode(&body).unwrap();
        assert_eq!(shoot.motors, [MotorPair::new(Motor(1), Steps(2), Steps(3))]);
        assert_eq!(shoot.tail, [9; 8]);
    }
}
