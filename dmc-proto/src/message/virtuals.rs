//! Virtual motors: a rig that is driven by the place and the direction of its camera.

use core::fmt;

use motion_core::fixed::{Centi, Milli, Scaled};
use motion_core::wire::{Bool, DecodeError, EncodeError, Field, Fields, Message, PartKind, Row, Visitor, place};
use motion_core::{__message_features, message, open_enum, unit};

use super::{JogSpeed, Steps};

unit! {
    /// Virtual position, in 1/100 000 of a unit of the rig; of a direction, in 1/100 000 of a degree.
    pub struct VirtualPosition(Scaled<i32, 100_000>) "";
    /// Place along one axis, in thousandths of a unit of the rig.
    pub struct Coordinate(Milli<i32>) "";
    /// Speed of the camera along a line, up to 100.00 percent forwards or backwards (decision D-40).
    pub struct LineSpeed(Centi<i16>) "%";
}

open_enum! {
    /// Number of a virtual motor, as in Limnmedia's firmware. The specification has no numbers (decision D-38).
    pub struct VirtualMotor(u8) {
        /// Motion along the track.
        TRACK = 1,
        /// Motion to the east and to the west.
        EAST_WEST = 2,
        /// Motion to the north and to the south.
        NORTH_SOUTH = 3,
        /// Pan of the camera.
        PAN = 4,
        /// Tilt of the camera.
        TILT = 5,
        /// Roll of the camera.
        ROLL = 6,
    }

    /// Line along which a camera runs.
    pub struct LineAxis(u8) {
        /// To the left and to the right.
        X = 0,
        /// Up and down.
        Y = 1,
        /// In the direction in which the camera looks.
        Z = 2,
        /// To the left and to the right, with the pan of the camera.
        PAN = 3,
        /// Up and down, with the tilt of the camera.
        TILT = 4,
    }
}

message! {
    /// Question where the virtual motors are. Source: DMC, MSG_VIRT_GET_POSITION.
    #[derive(Default)]
    pub struct VirtGetPosition<'a> in LE {}

    /// Request to send a virtual motor to a position. Source: DMC, MSG_VIRT_MOVE; decision D-38.
    #[derive(Default)]
    pub struct VirtMove<'a> in LE {
        /// Number of the virtual motor.
        virtual_motor: VirtualMotor,
        /// Position to go to.
        position_x1e5: VirtualPosition,
    }

    /// Stop of a virtual motor. Source: DMC, MSG_VIRT_STOP; safety decisions 1 and 7.
    #[derive(Default)]
    pub struct VirtStop<'a> in LE {
        /// Number of the virtual motor.
        virtual_motor: VirtualMotor,
    }

    /// Request to run a virtual motor towards a position, until another request.
    ///
    /// Today hosts send only the slowest and the full speed. The destination is as far away as possible, and tells only the
    /// direction. Source: DMC, MSG_VIRT_JOG; safety decision 10, decision D-39.
    #[derive(Default)]
    pub struct VirtJog<'a> in LE {
        /// Number of the virtual motor.
        virtual_motor: VirtualMotor,
        /// Speed of the jog.
        speed: JogSpeed,
        /// Position that tells the direction.
        destination: Steps,
    }

    /// Request to run the camera along a line, until another request. Source: DMC, MSG_VIRT_JOG_ON_LINE; decision D-40.
    #[derive(Default)]
    pub struct VirtJogOnLine<'a> in LE {
        /// Line of the motion.
        axis: LineAxis,
        /// Speed, whose sign is the direction.
        speed: LineSpeed,
    }

    /// Aim of the camera at a point, or the end of it: a request of a host, or the confirmation of a device, at any time.
    ///
    /// Source: DMC, MSG_VIRT_AIM_POINT; decision D-42.
    #[derive(Default)]
    pub struct VirtAimPoint<'a> in LE {
        /// Whether the camera is aimed.
        enable: Bool,
        /// Place of the point along x.
        aim_x: Coordinate,
        /// Place of the point along y.
        aim_y: Coordinate,
        /// Place of the point along z.
        aim_z: Coordinate,
    }

    /// Fields of [`VirtPositions`] of which the last one may be absent.
    struct Pose<'a> in LE {
        track: VirtualPosition,
        ew: VirtualPosition,
        ns: VirtualPosition,
        pan: VirtualPosition,
        tilt: VirtualPosition,
        roll: VirtualPosition,
        ;
        aim_enabled: Option<Bool>,
    }

    /// Fields of [`VirtPositions`] that are all present or all absent.
    struct Point<'a> in LE {
        aim_x: Coordinate,
        aim_y: Coordinate,
        aim_z: Coordinate,
    }
}

motion_core::__logged! {
    /// Positions of the virtual motors: an answer, which some devices also send unasked.
    ///
    /// Devices that can aim add whether they do, and all three coordinates of the point or none of them. Source: DMC,
    /// `MSG_VIRT_GET_POSITION`; decision D-41.
    #[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
    pub struct VirtPositions<'a> {
        /// Position along the track.
        pub track: VirtualPosition,
        /// Position to the east or west.
        pub ew: VirtualPosition,
        /// Position to the north or south.
        pub ns: VirtualPosition,
        /// Pan of the camera.
        pub pan: VirtualPosition,
        /// Tilt of the camera.
        pub tilt: VirtualPosition,
        /// Roll of the camera.
        pub roll: VirtualPosition,
        /// Whether the camera is aimed at a point.
        pub aim_enabled: Option<Bool>,
        /// Coordinates of the point: x, y and z.
        pub aim: Option<[Coordinate; 3]>,
        /// Bytes after the known fields, as they arrived.
        pub tail: &'a [u8],
    }
}

impl<'a> VirtPositions<'a> {
    fn pose(&self) -> Pose<'a> {
        let Self { track, ew, ns, pan, tilt, roll, aim_enabled, .. } = *self;
        let tail = if self.aim.is_none() { self.tail } else { &[] };
        Pose { track, ew, ns, pan, tilt, roll, aim_enabled, tail }
    }

    fn aim(&self) -> Option<Point<'a>> {
        self.aim.map(|[aim_x, aim_y, aim_z]| Point { aim_x, aim_y, aim_z, tail: self.tail })
    }
}

impl<'a> Message<'a> for VirtPositions<'a> {
    const LAYOUT: &'static [Row] = &place([
        row::<VirtualPosition>("track", PartKind::Fixed),
        row::<VirtualPosition>("ew", PartKind::Fixed),
        row::<VirtualPosition>("ns", PartKind::Fixed),
        row::<VirtualPosition>("pan", PartKind::Fixed),
        row::<VirtualPosition>("tilt", PartKind::Fixed),
        row::<VirtualPosition>("roll", PartKind::Fixed),
        row::<Bool>("aim_enabled", PartKind::Optional),
        row::<Coordinate>("aim_x", PartKind::Optional),
        row::<Coordinate>("aim_y", PartKind::Optional),
        row::<Coordinate>("aim_z", PartKind::Optional),
    ]);

    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        let Pose { track, ew, ns, pan, tilt, roll, aim_enabled, tail } =
            Pose::decode(body).map_err(|error| after(error, "VirtPositions", 0))?;
        let (aim, tail) = match Point::decode(tail) {
            Ok(Point { aim_x, aim_y, aim_z, tail }) => (Some([aim_x, aim_y, aim_z]), tail),
            Err(_) => (None, tail),
        };
        Ok(Self { track, ew, ns, pan, tilt, roll, aim_enabled, aim, tail })
    }

    fn encoded_len(&self) -> usize {
        self.pose().encoded_len().saturating_add(self.aim().map_or(0, |aim| aim.encoded_len()))
    }

    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let what = "VirtPositions.aim";
        if self.aim.is_some() && self.aim_enabled.is_none() {
            return Err(EncodeError::Hole { what });
        }
        if self.aim.is_none() && Point::decode(self.tail).is_ok() {
            return Err(EncodeError::Tail { what, len: self.tail.len() });
        }
        let needed = self.encoded_len();
        let small = EncodeError::BufferTooSmall { needed, have: out.len() };
        let out = out.get_mut(..needed).ok_or(small)?;
        let at = self.pose().encode_into(out)?;
        if let Some(aim) = self.aim() {
            aim.encode_into(out.get_mut(at..).ok_or(small)?)?;
        }
        Ok(needed)
    }
}

impl Fields for VirtPositions<'_> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        self.pose().fields(visitor);
        if let Some(aim) = self.aim() {
            aim.fields(visitor);
        }
    }
}

/// A derived one of six fields or more cannot be proven free of panics.
impl fmt::Debug for VirtPositions<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("VirtPositions")
            .field("track", &self.track)
            .field("ew", &self.ew)
            .field("ns", &self.ns)
            .field("pan", &self.pan)
            .field("tilt", &self.tilt)
            .field("roll", &self.roll)
            .field("aim_enabled", &self.aim_enabled)
            .field("aim", &self.aim)
            .field("tail", &self.tail)
            .finish()
    }
}

__message_features! { 'a [VirtPositions<'a>] VirtPositions }

/// Row of a layout that is written by hand.
pub(super) const fn row<T: Field>(name: &'static str, part: PartKind) -> Row {
    Row { name, wire: T::WIRE, offset: None, size: T::SIZE, part, unit: T::UNIT, element: &[] }
}

/// Error of a part of a message as an error of the whole message. The part begins after `before` bytes.
pub(super) fn after(error: DecodeError, what: &'static str, before: usize) -> DecodeError {
    match error {
        DecodeError::Truncated { needed, have, .. } => {
            DecodeError::Truncated { what, needed: needed.saturating_add(before), have: have.saturating_add(before) }
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Decision D-41.
    #[test]
    fn an_aim_has_all_its_coordinates_or_none() {
        let body: Vec<u8> = (0..40).collect();
        for len in 24..=40 {
            let positions = VirtPositions::decode(&body[..len]).unwrap();
            let known = match len {
                24 => 24,
                25..37 => 25,
                _ => 37,
            };
            assert_eq!((positions.aim_enabled, positions.aim.is_some()), ((len > 24).then_some(Bool(24)), len >= 37));
            assert_eq!(positions.tail, &body[known..len], "{len} bytes");
        }
        let short = DecodeError::Truncated { what: "VirtPositions", needed: 24, have: 23 };
        assert_eq!(VirtPositions::decode(&body[..23]), Err(short));
    }

    #[test]
    fn an_aim_that_would_be_read_otherwise_is_refused() {
        let whole = VirtPositions::decode(&[1; 37]).unwrap();
        let mut out = [0; 64];
        assert_eq!(whole.encode_into(&mut out), Ok(37));
        let hole = VirtPositions { aim_enabled: None, ..whole };
        assert_eq!(hole.encode_into(&mut out), Err(EncodeError::Hole { what: "VirtPositions.aim" }));
        let swallowed = VirtPositions { aim: None, tail: &[0; 12], ..whole };
        assert_eq!(swallowed.encode_into(&mut out), Err(EncodeError::Tail { what: "VirtPositions.aim", len: 12 }));
        let kept = VirtPositions { aim: None, tail: &[0; 11], ..whole };
        assert_eq!(kept.encode_into(&mut out), Ok(36));
    }
}
