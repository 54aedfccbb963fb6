//! Configuration of the virtual motors: the only message whose layout depends on its first byte.

use motion_core::fixed::{Milli, Scaled};
use motion_core::wire::{
    DecodeError, Empty, EncodeError, Fields, Message, Part, PartKind, Rest, Row, Visitor, Writer, place,
};
use motion_core::{__message_features, message, open_enum, unit};
use zerocopy::little_endian::I32;
use zerocopy::{FromBytes, IntoBytes, LE};

use super::virtuals::{Coordinate, VirtualPosition, after, row};

unit! {
    /// Number of a motor of the rig, from 1; 0 if the rig has no such axis (decision D-34).
    pub struct RigMotor(u32) "";
    /// Number of steps of a motor for one unit of its axis. [`observed`](Self::observed) tells the scale.
    pub struct StepsPerUnit(u32) "";
    /// Length, in thousandths of a unit of the rig.
    pub struct Length(Milli<u32>) "";
}

impl StepsPerUnit {
    /// Number of steps as thousandths. The specification gives no scale; Dragonframe itself was seen to send thousandths
    /// (decision D-35).
    #[must_use]
    pub const fn observed(self) -> Milli<u32> {
        Scaled(self.0)
    }
}

open_enum! {
    /// Kind of a rig. Source: DMC, MSG_VIRT_CONFIG, TYPE; decision D-34.
    pub struct RigKind(u8) {
        /// Rig without virtual motors.
        NONE = 0,
        /// Boom on a swing on a track.
        BOOM_SWING_TRACK = 1,
        /// Swing and pan.
        SWING_PAN = 2,
        /// Y axis on a swing on a track. Its layout is not published.
        Y_SWING_TRACK = 3,
        /// Three straight axes. Their layout is not published.
        X_Y_Z = 4,
    }
}

message! {
    /// Motors and measures of a boom on a swing on a track.
    #[derive(Default)]
    pub struct BoomRig in LE {
        /// Motor of the boom.
        boom_motor: RigMotor,
        /// Scale of the boom.
        boom_spu: StepsPerUnit,
        /// Present position of the boom.
        boom_pos_x1e5: VirtualPosition,
        /// Motor of the swing.
        swing_motor: RigMotor,
        /// Scale of the swing.
        swing_spu: StepsPerUnit,
        /// Present position of the swing.
        swing_pos_x1e5: VirtualPosition,
        /// Motor of the track.
        track_motor: RigMotor,
        /// Scale of the track.
        track_spu: StepsPerUnit,
        /// Present position of the track.
        track_pos_x1e5: VirtualPosition,
        /// Motor of the pan.
        pan_motor: RigMotor,
        /// Scale of the pan.
        pan_spu: StepsPerUnit,
        /// Present position of the pan.
        pan_pos_x1e5: VirtualPosition,
        /// Motor of the tilt.
        tilt_motor: RigMotor,
        /// Scale of the tilt.
        tilt_spu: StepsPerUnit,
        /// Present position of the tilt.
        tilt_pos_x1e5: VirtualPosition,
        /// Motor of the roll.
        roll_motor: RigMotor,
        /// Scale of the roll.
        roll_spu: StepsPerUnit,
        /// Present position of the roll.
        roll_pos_x1e5: VirtualPosition,
        /// Length of the boom.
        boom_length_x1000: Length,
        /// Length of the extension of the boom.
        boom_ext_x1000: Length,
        /// Position of the nodal point of the lens, along x.
        nodal_x_x1000: Coordinate,
        /// Position of the nodal point of the lens, along y.
        nodal_y_x1000: Coordinate,
        /// Position of the nodal point of the lens, along z.
        nodal_z_x1000: Coordinate,
    }

    /// Field after the table.
    struct Distance<'a> in LE {
        ;
        /// Least distance between the camera and its aim.
        safe_distance_x1000: Option<Length>,
    }

    /// Motors of a swing and a pan.
    #[derive(Default)]
    pub struct SwingPan<'a> in LE {
        /// Motor of the swing.
        swing_motor: RigMotor,
        /// Scale of the swing.
        swing_spu: StepsPerUnit,
        /// Motor of the pan.
        pan_motor: RigMotor,
        /// Scale of the pan.
        pan_spu: StepsPerUnit,
    }
}

/// Positions of a boom at -60, -59, .. 60 degrees. Their unit is not published (decisions D-36 and D-37).
pub type BoomTable = [I32; 121];

/// Boom on a swing on a track, with its optional fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct BoomSwingTrack<'a> {
    /// Motors and measures of the rig.
    pub rig: BoomRig,
    /// Real position of the boom at each angle.
    pub boom_table: Option<&'a BoomTable>,
    /// Least distance between the camera and its aim.
    pub safe_distance_x1000: Option<Length>,
    /// Bytes after the known fields, as they arrived. Dragonframe itself was seen to send some.
    pub tail: &'a [u8],
}

motion_core::__logged! {
    /// Rig of a kind without a published layout, as it arrived.
    ///
    /// The fields are private, so that a layout that becomes known later breaks no program.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct OpaqueRig<'a> {
        kind: RigKind,
        payload: &'a [u8],
    }
}

impl<'a> OpaqueRig<'a> {
    /// Makes a rig of a kind; `None` for the kinds whose layout is known.
    #[must_use]
    pub const fn new(kind: RigKind, payload: &'a [u8]) -> Option<Self> {
        match kind {
            RigKind::NONE | RigKind::BOOM_SWING_TRACK | RigKind::SWING_PAN => None,
            _ => Some(Self { kind, payload }),
        }
    }

    /// Kind of the rig.
    #[must_use]
    pub const fn kind(&self) -> RigKind {
        self.kind
    }

    /// Data of the rig.
    #[must_use]
    pub const fn payload(&self) -> &'a [u8] {
        self.payload
    }
}

motion_core::__logged! {
    /// Configuration of the virtual motors. Source: DMC, `MSG_VIRT_CONFIG`; safety decisions 7 and 10, decision D-34.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    #[non_exhaustive]
    pub enum VirtConfig<'a> {
        /// There are no virtual motors from now on.
        None(Empty<'a>),
        /// The rig is a boom on a swing on a track.
        BoomSwingTrack(BoomSwingTrack<'a>),
        /// The rig is a swing and a pan.
        SwingPan(SwingPan<'a>),
        /// The layout of the rig is not published.
        Opaque(OpaqueRig<'a>),
    }
}

impl VirtConfig<'_> {
    /// Kind of the rig.
    #[must_use]
    pub const fn kind(&self) -> RigKind {
        match self {
            Self::None(_) => RigKind::NONE,
            Self::BoomSwingTrack(_) => RigKind::BOOM_SWING_TRACK,
            Self::SwingPan(_) => RigKind::SWING_PAN,
            Self::Opaque(rig) => rig.kind(),
        }
    }
}

impl<'a> Message<'a> for VirtConfig<'a> {
    /// Layout of the first byte. The rest has the layout of the kind of rig: [`BoomRig`], [`SwingPan`].
    const LAYOUT: &'static [Row] = &place([
        row::<RigKind>("type", PartKind::Fixed),
        Row {
            name: "rig",
            wire: <Rest<'a> as Part<'a>>::WIRE,
            offset: None,
            size: <Rest<'a> as Part<'a>>::SIZE,
            part: PartKind::Rest,
            unit: "",
            element: &[],
        },
    ]);

    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        let short = DecodeError::Truncated { what: "VirtConfig", needed: 1, have: 0 };
        let (&kind, rig) = body.split_first().ok_or(short)?;
        let kind = RigKind(kind);
        let known = match kind {
            RigKind::NONE => Empty::decode(rig).map(Self::None),
            RigKind::BOOM_SWING_TRACK => BoomSwingTrack::decode(rig).map(Self::BoomSwingTrack),
            RigKind::SWING_PAN => SwingPan::decode(rig).map(Self::SwingPan),
            _ => Ok(Self::Opaque(OpaqueRig { kind, payload: rig })),
        };
        known.map_err(|error| after(error, "VirtConfig", 1))
    }

    fn encoded_len(&self) -> usize {
        let rig = match self {
            Self::None(empty) => empty.encoded_len(),
            Self::BoomSwingTrack(rig) => rig.encoded_len(),
            Self::SwingPan(rig) => rig.encoded_len(),
            Self::Opaque(rig) => rig.payload.len(),
        };
        rig.saturating_add(1)
    }

    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let needed = self.encoded_len();
        let small = EncodeError::BufferTooSmall { needed, have: out.len() };
        let (kind, place) = out.get_mut(..needed).and_then(<[u8]>::split_first_mut).ok_or(small)?;
        match self {
            Self::None(empty) => empty.encode_into(place)?,
            Self::BoomSwingTrack(rig) => rig.encode_into(place)?,
            Self::SwingPan(rig) => rig.encode_into(place)?,
            Self::Opaque(rig) => {
                Writer::<LE>::new(place).bytes(rig.payload).ok_or(small)?;
                needed
            }
        };
        *kind = self.kind().0;
        Ok(needed)
    }
}

impl Fields for VirtConfig<'_> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        Part::visit(&self.kind(), "type", "", visitor);
        match self {
            Self::None(empty) => empty.fields(visitor),
            Self::BoomSwingTrack(rig) => rig.fields(visitor),
            Self::SwingPan(rig) => rig.fields(visitor),
            Self::Opaque(rig) => Part::visit(&Rest(rig.payload), "opaque", "", visitor),
        }
    }
}

__message_features! { 'a [VirtConfig<'a>] VirtConfig }

/// Rule of the length (DMC A2): first the table if it fits, then the distance if it fits, then a tail.
impl<'a> BoomSwingTrack<'a> {
    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        let split = body.split_at_checked(fixed_len(BoomRig::LAYOUT));
        // If the body is too short, the rig refuses it.
        let (rig, rest) = split.unwrap_or((body, &[]));
        let rig = BoomRig::decode(rig)?;
        let (boom_table, rest) = match BoomTable::ref_from_prefix(rest) {
            Ok((table, rest)) => (Some(table), rest),
            Err(_) => (None, rest),
        };
        let Distance { safe_distance_x1000, tail } = Distance::decode(rest)?;
        Ok(Self { rig, boom_table, safe_distance_x1000, tail })
    }

    fn distance(&self) -> Distance<'a> {
        Distance { safe_distance_x1000: self.safe_distance_x1000, tail: self.tail }
    }

    fn table(&self) -> &'a [I32] {
        self.boom_table.map_or(&[], |table| table.as_slice())
    }

    fn encoded_len(&self) -> usize {
        let fixed = self.rig.encoded_len().saturating_add(size_of_val(self.table()));
        fixed.saturating_add(self.distance().encoded_len())
    }

    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let table = self.table().as_bytes();
        let distance = self.distance();
        if self.boom_table.is_none() && distance.encoded_len() >= size_of::<BoomTable>() {
            return Err(EncodeError::Tail { what: "BoomSwingTrack.boom_table", len: distance.encoded_len() });
        }
        let needed = self.encoded_len();
        let small = EncodeError::BufferTooSmall { needed, have: out.len() };
        let (rig, rest) = out.split_at_mut_checked(self.rig.encoded_len()).ok_or(small)?;
        let (place, rest) = rest.split_at_mut_checked(table.len()).ok_or(small)?;
        // The distance comes first, because only it can be refused.
        distance.encode_into(rest)?;
        self.rig.encode_into(rig)?;
        place.copy_from_slice(table);
        Ok(needed)
    }
}

motion_core::__defmt! {
    as this: BoomSwingTrack<'_> => BoomSwingTrack<'x> {
        rig: &'x BoomRig = &this.rig,
        has_table: bool = this.boom_table.is_some(),
        safe_distance_x1000: Option<Length> = this.safe_distance_x1000,
        tail: &'x [u8] = this.tail,
    }
}

impl Fields for BoomSwingTrack<'_> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        self.rig.fields(visitor);
        if self.boom_table.is_some() {
            Part::visit(&self.table(), "boom_table", "", visitor);
        }
        self.distance().fields(visitor);
    }
}

/// Length of a layout that has only fixed fields, in bytes.
const fn fixed_len(mut rows: &[Row]) -> usize {
    let mut len = 0_usize;
    while let Some((row, rest)) = rows.split_first() {
        len = len.saturating_add(row.size);
        rows = rest;
    }
    len
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn body(kind: u8, len: usize) -> Vec<u8> {
        let mut body: Vec<u8> = (0..len).map(|at| u8::try_from(at % 251).unwrap()).collect();
        body[0] = kind;
        body
    }

    /// Rule of the length of type 1.
    #[test]
    fn the_length_says_whether_there_is_a_table_and_a_distance() {
        for (len, has_table, has_distance, tail) in [
            (93, false, false, 0),
            (96, false, false, 3),
            (97, false, true, 0),
            (576, false, true, 479),
            (577, true, false, 0),
            (580, true, false, 3),
            (581, true, true, 0),
            (700, true, true, 119),
        ] {
            let body = body(1, len);
            let VirtConfig::BoomSwingTrack(rig) = VirtConfig::decode(&body).unwrap() else { panic!("{len} bytes") };
            let seen = (rig.boom_table.is_some(), rig.safe_distance_x1000.is_some(), rig.tail.len());
            assert_eq!(seen, (has_table, has_distance, tail), "{len} bytes");
            let mut out = std::vec![0; len];
            assert_eq!(VirtConfig::BoomSwingTrack(rig).encode_into(&mut out), Ok(len));
            assert_eq!(out, body);
        }
        let short = DecodeError::Truncated { what: "VirtConfig", needed: 93, have: 92 };
        assert_eq!(VirtConfig::decode(&body(1, 92)), Err(short));
        let short = DecodeError::Truncated { what: "VirtConfig", needed: 17, have: 16 };
        assert_eq!(VirtConfig::decode(&body(2, 16)), Err(short));
        assert_eq!(VirtConfig::decode(&[]), Err(DecodeError::Truncated { what: "VirtConfig", needed: 1, have: 0 }));
    }

    #[test]
    fn a_tail_that_would_be_read_as_a_field_is_refused() {
        let long = [0; 700];
        let body = body(1, 93);
        let VirtConfig::BoomSwingTrack(whole) = VirtConfig::decode(&body).unwrap() else { panic!("type 1") };
        let mut out = [0xa5; 800];
        let mut encode = |rig| VirtConfig::BoomSwingTrack(rig).encode_into(&mut out);
        let distance = Some(Length(Scaled(5)));
        let table = BoomSwingTrack { safe_distance_x1000: distance, tail: &long[..480], ..whole };
        assert_eq!(encode(table), Err(EncodeError::Tail { what: "BoomSwingTrack.boom_table", len: 484 }));
        let kept = BoomSwingTrack { tail: &long[..479], ..table };
        assert_eq!(encode(kept), Ok(576));
        out.fill(0xa5);
        let no_distance = BoomSwingTrack { tail: &long[..4], ..whole };
        let refused = VirtConfig::BoomSwingTrack(no_distance).encode_into(&mut out);
        assert_eq!(refused, Err(EncodeError::Tail { what: "Distance.safe_distance_x1000", len: 4 }));
        assert_eq!(out, [0xa5; 800], "nothing is written");
    }

    #[test]
    fn a_kind_without_a_layout_is_kept() {
        let rig = VirtConfig::decode(&[3, 1, 2]).unwrap();
        let opaque = OpaqueRig::new(RigKind::Y_SWING_TRACK, &[1, 2]).unwrap();
        assert_eq!(rig, VirtConfig::Opaque(opaque));
        assert_eq!((opaque.kind(), opaque.payload(), rig.kind()), (RigKind::Y_SWING_TRACK, &[1, 2][..], RigKind(3)));
        assert_eq!(OpaqueRig::new(RigKind::SWING_PAN, &[]), None, "its layout is known");
        assert_eq!(StepsPerUnit(1500).observed(), Scaled(1500));
    }
}
