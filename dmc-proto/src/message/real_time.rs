//! Real-time moves: ways to a frame, runs and shots.

use motion_core::fixed::{Deci, Milli};
use motion_core::wire::Bool;
use motion_core::{element, flags, message, open_enum, unit};

use super::{Capabilities, Motor, Steps};

unit! {
    /// Frames per second, in thousandths: 23.976 is 23 976.
    pub struct FramesPerSecond(Milli<u32>) "frames/s";
    /// Number of a frame of the shot, as the host counts.
    pub struct FrameNumber(i32) "";
    /// Time, in milliseconds.
    pub struct Milliseconds(u32) "ms";
    /// Short time, in milliseconds.
    pub struct ShortMilliseconds(u16) "ms";
    /// Angle of a shutter, 0 to 360 degrees (decision D-28).
    pub struct Degrees(u16) "°";
    /// Number of a DMX channel, 1 to 512; 0 for none.
    pub struct DmxChannel(u16) "";
    /// Part of the motion of a frame that is blurred, in tenths of a percent (decision D-27).
    pub struct BlurPercent(Deci<u16>) "%";
}

message! {
    /// Request to send all motors and DMX channels to their places at a frame of the uploaded move.
    ///
    /// Source: DMC, MSG_RT_POSITION_FRAME; decision D-31, safety decision 8.
    #[derive(Default)]
    pub struct RtPositionFrame<'a> in LE {
        /// Number of the frame.
        frame: FrameNumber,
    }

    /// Request to prepare a run of the uploaded move. The motors go to the start, then to the start of the pre-roll, and wait
    /// for the signal to start.
    ///
    /// Send all motors to the first frame before, with [`RtPositionFrame`]: on some devices, a stop on the way to this frame does
    /// not end the run (decision D-96).
    ///
    /// Source: DMC, MSG_RT_RUN_MOVE; safety decision 9, decisions D-23 and D-24.
    #[derive(Default)]
    pub struct RtRunMove<'a> in LE {
        /// Speed of the run.
        fps_x1000: FramesPerSecond,
        /// First frame.
        start_frame: FrameNumber,
        /// Last frame.
        end_frame: FrameNumber,
        /// Time to reach the speed before the first frame. Send no 0: dmc-lite divides by it.
        pre_roll_ms: Milliseconds,
        /// Time to come to rest after the last frame.
        post_roll_ms: Milliseconds,
        /// Whether the uploaded DMX levels and triggers are played too.
        sync_dmx: Bool,
        /// Outputs that mark the first frame.
        bloop_location: BloopOutputs,
        /// DMX channel that marks the first frame; 0 for none.
        bloop_dmx_channel: DmxChannel,
        /// Duration of the mark.
        bloop_ms: ShortMilliseconds,
        ;
        /// Loops and triggers of the camera, for devices with these capabilities.
        flags: Option<RunFlags>,
        /// Angle at which the shutter opens, for cameras that are triggered at every frame.
        open_angle: Option<Degrees>,
        /// Angle at which the shutter closes, for cameras that are triggered at every frame.
        close_angle: Option<Degrees>,
    }

    /// Request to prepare a motion through one frame while the shutter is open.
    ///
    /// Source: DMC, MSG_RT_SHOOT_FRAME; decision D-25.
    #[derive(Default)]
    pub struct RtShootFrame<'a> in LE {
        /// Number of the frame.
        frame: FrameNumber,
        /// Direction in which the motors move through the frame.
        direction: Direction,
        /// Time for which the shutter is open.
        exposure_ms: Milliseconds,
        /// Part of the motion of the frame that is blurred; 0 stands for all of it.
        blur_x10: BlurPercent,
        ;
        /// Motors that do not follow the uploaded move, with their ways.
        motors: &'a [MotorPair],
    }

    /// Request to prepare a motion through one frame, with a shutter that is described by its angles.
    ///
    /// Source: DMC, MSG_RT_SHOOT_FRAME2; decisions D-1, D-25, D-27 and D-28.
    #[derive(Default)]
    pub struct RtShootFrame2<'a> in LE {
        /// Number of the frame.
        frame: FrameNumber,
        /// Time for which the shutter is open.
        exposure_ms: Milliseconds,
        /// Angle at which the shutter opens.
        open_angle: Degrees,
        /// Angle at which the shutter closes.
        close_angle: Degrees,
        ;
        /// Motors that do not follow the uploaded move, with their ways.
        motors: &'a [MotorPair],
    }

    /// Start of the run or shot that the device prepared: the signal of a host, or the news that the operator gave the signal.
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

    /// Request to run all motors towards a frame of the uploaded move. Before it, they have to stand on a frame.
    ///
    /// Source: DMC, MSG_RT_JOG_ALL; safety decision 8.
    #[derive(Default)]
    pub struct RtJogAll<'a> in LE {
        /// Speed of the run.
        fps_x1000: FramesPerSecond,
        /// Frame at which the motors stop.
        destination: FrameNumber,
    }
}

impl RtRunMove<'_> {
    /// Returns the run with those of the last fields that a device expects: 29 bytes of data, 31 for loops, 35 for triggers
    /// of a camera (decision D-23).
    ///
    /// If the device expects a field that is missing, it becomes 0. If the device does not expect a field, it is left out if
    /// it is 0. Other values are kept, and [lint](crate::lint) refuses them.
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
    /// Way of one motor around a frame, for a shutter of 360 degrees: from half a frame before it to half a frame after it.
    ///
    /// A shutter that opens or closes at other angles takes a part of this way. So the positions are not those where the
    /// shutter opens and closes: with 180 degrees it takes half of the way (decision D-88).
    pub struct MotorPair in LE, "motor_count" {
        /// Number of the motor.
        motor: Motor,
        /// Position at 0 degrees of the shutter: half a frame before the frame.
        pos_a: Steps,
        /// Position at 360 degrees of the shutter: half a frame after the frame.
        pos_b: Steps,
    }
}

flags! {
    /// Options of a run. Unknown bits are kept. Source: DMC, MSG_RT_RUN_MOVE, FLAGS.
    pub struct RunFlags(u16) {
        /// The run goes back and forth until it is ended. This option is stronger than `LOOP`.
        PING_PONG = 0x0001,
        /// The run begins again until it is ended.
        LOOP = 0x0002,
        /// The camera is triggered at the start and at the end, for video.
        CAMERA_START_STOP = 0x0010,
        /// The camera is triggered at every frame, for stills.
        CAMERA_EVERY_FRAME = 0x0020,
    }

    /// Outputs that mark the first frame. Unknown bits are kept. The names are those of the vendor's firmware
    /// (decision D-24).
    pub struct BloopOutputs(u32) {
        /// Logic output.
        LOGIC_OUT = 0x0000_0001,
        /// Relay output.
        RELAY_OUT = 0x0000_0002,
        /// DMX channel.
        DMX = 0x0000_0004,
    }
}

open_enum! {
    /// Direction in which motors move through a frame.
    pub struct Direction(u8) {
        /// Backwards.
        BACKWARD = 0,
        /// Forwards.
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
            assert_eq!(run.for_device(all).flags, Some(run.flags.unwrap_or_default()), "no option is lost");
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
