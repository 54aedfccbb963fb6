//! List of blocks, each with a number, a length and data. Source: kOS, `TrajectoryData`; decisions K-B2, K-J1 and K-J2.

use core::fmt;

use motion_core::wire::{
    Bool, DecodeError, EncodeError, Field, FieldView, Fields, List, Message, Messages, PartKind, Row, Value, Visitor,
    Writer, place, print, visit_tail,
};
use motion_core::{__message_features, message, messages};

use super::values::{DelayInterval, DelayMode, LoopCount, Points};
use crate::message::{MotorAddress, Normalized, PlaybackMode, Seconds};

message! {
    /// Settings for playing a move, 37 bytes. Fields that devices do not support are part of it and are sent as 0
    /// (decision K-J11).
    pub struct Playback<'a> in BE {
        /// Kind of move.
        playback_mode: PlaybackMode,
        /// Time that the move takes once, in seconds; unused in time lapses (decision K-J10).
        duration: Seconds,
        /// Time that a rapid way back takes, in seconds; normally equal to `duration` (decision K-J5).
        rapid_reverse_duration: Seconds,
        /// Number of rapid ways back, each followed by the move again. Only one of this and the next field may be set
        /// (decision K-J4).
        loop_after_rapid_reverse: LoopCount,
        /// Number of times that the move is played backward and then forward again.
        loop_after_reverse: LoopCount,
        /// Condition for the start: none, a time or a moment.
        delay_mode: DelayMode,
        /// Time or moment to wait for, in its raw bits.
        delay_interval_bits: DelayInterval,
        /// Not supported.
        camera_roll_enabled: Bool,
        /// Not supported.
        camera_roll_pre_delay: Seconds,
        /// Not supported.
        camera_roll_post_delay: Seconds,
        /// Not supported.
        flash_mark_enabled: Bool,
        /// Not supported.
        flash_mark_type: u8,
        /// Not supported.
        flash_mark_post_delay: Seconds,
        /// Not supported.
        use_external_trigger: Bool,
        /// Not supported.
        using_lanc: Bool,
        /// Speed on the way to the start of the move, as a part of the greatest speed of each motor (decision K-J6).
        return_to_home_percent: Normalized,
    }

    /// Photos of a time lapse, 21 bytes; all 0 in a live move.
    pub struct TimeLapse<'a> in BE {
        /// Time between photos, in seconds.
        delay: Seconds,
        /// Time that the shutter is open, in seconds.
        exposure: Seconds,
        /// Number of photos in the move.
        move_photos: u32,
        /// Unused byte; 0.
        not_used: u8,
        /// Number of photos before the move.
        pre_move_photos: u32,
        /// Number of photos after the move.
        post_move_photos: u32,
    }

    /// Motor of the move and the number of its segments. 2 bytes.
    pub struct Axis<'a> in BE {
        /// Motor that takes part.
        motor_address: MotorAddress,
        /// Number of its segments.
        segment_count: u8,
    }

    /// Part of a motor's way: a Bézier curve that starts where the segment before it ends. 34 bytes (decision K-J8).
    pub struct Segment<'a> in BE {
        /// Motor that the segment belongs to.
        motor_address: MotorAddress,
        /// Number of the segment within its motor, from 0.
        segment_number: u8,
        /// Points of the curve: start, two handles, end.
        points: Points,
    }
}

messages! {
    /// Part of a move.
    pub enum Block<'a> {
        /// Settings for playing the move.
        1 => Playback(Playback<'a>),
        /// Photos of a time lapse.
        2 => TimeLapse(TimeLapse<'a>),
        /// Motor of the move and the number of its segments.
        5 => Axis(Axis<'a>),
        /// Part of a motor's way.
        6 => Segment(Segment<'a>),
    }
}

impl Block<'_> {
    /// Bytes before the data: the number and the length.
    pub(super) const HEADER_LEN: usize = 3;

    /// Bytes of the block, including its number and length.
    #[must_use]
    pub fn encoded_len(&self) -> usize {
        self.body_len().saturating_add(Self::HEADER_LEN)
    }

    /// Writes the block with its number and length to the front of `out`, and returns the number of bytes written.
    ///
    /// # Errors
    ///
    /// [`EncodeError`] if the block does not fit or is longer than its length field can say. Then nothing is written.
    pub fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let (number, len, needed) = (self.number(), self.body_len(), self.encoded_len());
        let range = EncodeError::OutOfRange { what: "block_id", value: number.into(), min: 0, max: 255 };
        let long = EncodeError::TooLong { what: "block", len, max: u16::MAX.into() };
        let small = EncodeError::BufferTooSmall { needed, have: out.len() };
        let id = u8::try_from(number).map_err(|_| range)?;
        let [l0, l1] = u16::try_from(len).map_err(|_| long)?.to_be_bytes();
        let (header, data) = out.get_mut(..needed).and_then(|out| out.split_first_chunk_mut()).ok_or(small)?;
        self.encode_body(data)?;
        *header = [id, l0, l1];
        Ok(needed)
    }
}

/// Number of a segment in the table of blocks, and the length of its data. A test compares them with the tables.
const SEGMENT: u8 = 6;
const SEGMENT_LEN: u8 = 34;
const WHOLE_SEGMENT: usize = Block::HEADER_LEN + SEGMENT_LEN as usize;

/// Takes a block off the front of `bytes`, and returns its number, its data and the remaining bytes.
#[inline]
fn split_block(bytes: &[u8]) -> Result<(u32, &[u8], &[u8]), DecodeError> {
    // Most blocks are segments of 34 bytes. If the processor guesses that, it does not wait for the length of each block to
    // find the next one.
    if let Some(([SEGMENT, 0, SEGMENT_LEN, segment @ ..], rest)) = bytes.split_first_chunk::<WHOLE_SEGMENT>() {
        return Ok((SEGMENT.into(), segment, rest));
    }
    let short = |needed| DecodeError::Truncated { what: "TrajectoryData.blocks", needed, have: bytes.len() };
    let (&[id, l0, l1], rest) = bytes.split_first_chunk().ok_or(short(Block::HEADER_LEN))?;
    let len = usize::from(u16::from_be_bytes([l0, l1]));
    let (data, rest) = rest.split_at_checked(len).ok_or(short(len.saturating_add(Block::HEADER_LEN)))?;
    Ok((id.into(), data, rest))
}

motion_core::__logged! {
    /// Blocks of a move: at most 255, each of which can be decoded.
    #[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
    pub struct Blocks<'a> {
        count: u8,
        bytes: &'a [u8],
    }
}

impl<'a> Blocks<'a> {
    /// Greatest number of blocks that can be counted (decision K-J2).
    pub const MAX: usize = u8::MAX as usize;

    /// Writes blocks to the front of `out`, and borrows them from there.
    ///
    /// # Errors
    ///
    /// [`EncodeError`] if there are more than [`MAX`](Self::MAX) blocks, if they do not fit, or if one cannot be
    /// written.
    pub fn encode(blocks: &[Block<'_>], out: &'a mut [u8]) -> Result<Self, EncodeError> {
        let needed = blocks.iter().map(Block::encoded_len).fold(0, usize::saturating_add);
        Self::write(blocks.len(), needed, blocks.iter().map(|&block| Ok(block)), out)
    }

    /// Writes `len` blocks, which take `needed` bytes in total.
    pub(super) fn write<'b, E: From<EncodeError>>(
        len: usize,
        needed: usize,
        blocks: impl Iterator<Item = Result<Block<'b>, E>>,
        out: &'a mut [u8],
    ) -> Result<Self, E> {
        let long = EncodeError::TooLong { what: "TrajectoryData.blocks", len, max: Self::MAX };
        let small = EncodeError::BufferTooSmall { needed, have: out.len() };
        let count = u8::try_from(len).map_err(|_| long)?;
        let bytes = out.get_mut(..needed).ok_or(small)?;
        let mut free = &mut *bytes;
        for block in blocks {
            let written = block?.encode_into(free)?;
            free = free.get_mut(written..).ok_or(small)?;
        }
        Ok(Self { count, bytes })
    }

    /// Takes `count` blocks off the front of `bytes`, and returns them with the remaining bytes.
    fn split(count: u8, bytes: &'a [u8]) -> Result<(Self, &'a [u8]), DecodeError> {
        let mut rest = bytes;
        for _ in 0..count {
            let (number, data, behind) = split_block(rest)?;
            // The block is checked, and none of its fields is read.
            Block::decode_with(number, data, |_| Ok(()), Err)?;
            rest = behind;
        }
        let taken = bytes.get(..bytes.len().saturating_sub(rest.len())).unwrap_or(bytes);
        Ok((Self { count, bytes: taken }, rest))
    }

    /// Number of blocks.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.count as usize
    }

    /// Whether there are no blocks, and so no move.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Iterator over the blocks.
    #[must_use]
    pub const fn iter(&self) -> BlockIter<'a> {
        BlockIter { bytes: self.bytes }
    }

    /// Blocks that say how the move is played. A move has one.
    pub(super) fn playbacks(&self) -> impl Iterator<Item = Playback<'a>> + use<'a> {
        self.iter().filter_map(|block| if let Block::Playback(playback) = block { Some(playback) } else { None })
    }

    /// Blocks that say how photos are taken. A move has one.
    pub(super) fn time_lapses(&self) -> impl Iterator<Item = TimeLapse<'a>> + use<'a> {
        self.iter().filter_map(|block| if let Block::TimeLapse(photos) = block { Some(photos) } else { None })
    }

    /// Motors of the move.
    pub(super) fn axes(&self) -> impl Iterator<Item = Axis<'a>> + use<'a> {
        self.iter().filter_map(|block| if let Block::Axis(axis) = block { Some(axis) } else { None })
    }

    /// Segments of all motors.
    pub(super) fn segments(&self) -> impl Iterator<Item = Segment<'a>> + use<'a> {
        self.iter().filter_map(|block| if let Block::Segment(segment) = block { Some(segment) } else { None })
    }

    /// Segments of one motor, in the order of their blocks.
    pub(super) fn segments_of(&self, motor: MotorAddress) -> impl Iterator<Item = Segment<'a>> + use<'a> {
        self.segments().filter(move |segment| segment.motor_address.number() == motor.number())
    }
}

impl<'a> IntoIterator for &Blocks<'a> {
    type Item = Block<'a>;
    type IntoIter = BlockIter<'a>;

    fn into_iter(self) -> BlockIter<'a> {
        self.iter()
    }
}

/// Iterator over blocks.
#[derive(Clone, Debug)]
pub struct BlockIter<'a> {
    bytes: &'a [u8],
}

impl<'a> Iterator for BlockIter<'a> {
    type Item = Block<'a>;

    // In firmware the code has to be short, because it has to be stored.
    #[cfg_attr(target_os = "none", inline(never))]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    #[allow(clippy::inline_always, reason = "the function that it calls is inlined too")]
    fn next(&mut self) -> Option<Block<'a>> {
        let (number, data, behind) = split_block(self.bytes).ok()?;
        self.bytes = behind;
        Block::decode_body(number, data).ok()
    }
}

impl List for Blocks<'_> {
    fn each(&self, item: &mut dyn FnMut(Value<'_>)) {
        for block in self {
            item(Value::Group(&NumberedBlock(block)));
        }
    }
}

impl fmt::Debug for Blocks<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

/// Block whose number is one of its fields.
struct NumberedBlock<'a>(Block<'a>);

impl Fields for NumberedBlock<'_> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        let id = self.0.number();
        visitor.visit(&FieldView { name: "block_id", unit: "", value: Value::Unsigned(id.into()), text: &id });
        self.0.fields(visitor);
    }
}

motion_core::__logged! {
    /// Move to be stored, or the move that is stored. Without blocks, no move is stored.
    ///
    /// Its size is at most some 9400 bytes. Over USB it would need several reports, which the specification does not
    /// describe (decision K-U4). A device does not answer it. Source: kOS, `TrajectoryData`; decisions K-J1 and K-J2.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    pub struct TrajectoryData<'a> {
        /// Blocks of the move.
        pub blocks: Blocks<'a>,
        /// Bytes after the known fields, kept unchanged.
        pub tail: &'a [u8],
    }
}

const fn fixed(name: &'static str, wire: &'static str, size: usize) -> Row {
    Row { name, wire, offset: None, size, part: PartKind::Fixed, unit: "", element: &[] }
}

impl<'a> Message<'a> for TrajectoryData<'a> {
    const LAYOUT: &'static [Row] = &place([Row {
        part: PartKind::Counted,
        element: &place([
            fixed("block_id", "u8", 1),
            Row { part: PartKind::Block16, ..fixed("data", "u16 + bytes", 2) },
        ]),
        ..fixed("blocks", "Block", Block::HEADER_LEN)
    }]);

    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        let short = DecodeError::Truncated { what: "TrajectoryData", needed: 1, have: 0 };
        let (&count, bytes) = body.split_first().ok_or(short)?;
        let (blocks, tail) = Blocks::split(count, bytes)?;
        Ok(Self { blocks, tail })
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        self.blocks.bytes.len().saturating_add(self.tail.len()).saturating_add(1)
    }

    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let needed = self.encoded_len();
        let small = EncodeError::BufferTooSmall { needed, have: out.len() };
        let mut writer = Writer::<zerocopy::BE>::new(out.get_mut(..needed).ok_or(small)?);
        self.blocks.count.write(&mut writer).ok_or(small)?;
        writer.bytes(self.blocks.bytes).ok_or(small)?;
        writer.bytes(self.tail).ok_or(small)?;
        Ok(needed)
    }
}

impl Fields for TrajectoryData<'_> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        let (count, blocks) = (&self.blocks.count, &self.blocks);
        visitor.visit(&FieldView { name: "block_count", unit: "", value: count.value(), text: count });
        visitor.visit(&FieldView {
            name: "blocks",
            unit: "",
            value: Value::List(blocks),
            text: &print::ListText(blocks),
        });
        visit_tail(self.tail, visitor);
    }
}

__message_features! { 'a [TrajectoryData<'a>] TrajectoryData }

#[cfg(test)]
mod tests {
    use super::*;

    const AXIS: Block<'_> = Block::Axis(Axis { motor_address: MotorAddress(1), segment_count: 0, tail: &[] });

    #[test]
    fn blocks_are_written_one_after_the_other() {
        let mut out = [0xa5; 16];
        let blocks = Blocks::encode(&[AXIS, Block::other(3, b"xy")], &mut out).unwrap();
        assert_eq!((blocks.len(), blocks.is_empty()), (2, false));
        assert!(blocks.iter().eq([AXIS, Block::other(3, b"xy")]));
        let message = TrajectoryData { blocks, tail: &[9] };
        let mut body = [0; 12];
        assert_eq!(message.encode_into(&mut body), Ok(12));
        assert_eq!(body, *b"\x02\x05\0\x02\x01\0\x03\0\x02xy\x09");
        assert_eq!(TrajectoryData::decode(&body), Ok(message));
    }

    #[test]
    fn a_segment_of_the_usual_length_is_that_of_the_tables() {
        let segment = Block::ALL.iter().find(|kind| kind.name == "Segment").unwrap();
        let len: usize = segment.layout.iter().map(|row| row.size).sum();
        assert_eq!((segment.number, len), (SEGMENT.into(), SEGMENT_LEN.into()));
        // One byte more or less, and a cut, take the way of all other blocks.
        for more in [0, 1] {
            let bytes = [&[SEGMENT, 0, SEGMENT_LEN + more][..], &[7; 40]].concat();
            let data = usize::from(SEGMENT_LEN + more);
            assert_eq!(split_block(&bytes), Ok((6, &bytes[3..3 + data], &bytes[3 + data..])));
            let cut = DecodeError::Truncated { what: "TrajectoryData.blocks", needed: 3 + data, have: 2 + data };
            assert_eq!(split_block(&bytes[..2 + data]), Err(cut));
        }
    }

    #[test]
    fn blocks_that_cannot_be_written_are_refused() {
        let mut out = [0; 2048];
        let many = Blocks::encode(&[AXIS; 256], &mut out);
        assert_eq!(many, Err(EncodeError::TooLong { what: "TrajectoryData.blocks", len: 256, max: 255 }));
        let small = Blocks::encode(&[AXIS; 2], &mut out[..9]);
        assert_eq!(small, Err(EncodeError::BufferTooSmall { needed: 10, have: 9 }));
        let number = Blocks::encode(&[Block::other(256, &[])], &mut out);
        assert_eq!(number, Err(EncodeError::OutOfRange { what: "block_id", value: 256, min: 0, max: 255 }));
        let long = Block::other(3, &std::vec![0; 65_536]).encode_into(&mut std::vec![0; 65_539]);
        assert_eq!(long, Err(EncodeError::TooLong { what: "block", len: 65_536, max: 65_535 }));
    }

    #[test]
    fn errors_name_the_block_and_its_missing_bytes() {
        let short = TrajectoryData::decode(&[1, 1, 0, 36, 0]);
        assert_eq!(short, Err(DecodeError::Truncated { what: "TrajectoryData.blocks", needed: 39, have: 4 }));
        let mut body = [0; 40];
        body[..4].copy_from_slice(&[1, 1, 0, 36]);
        let playback = DecodeError::Truncated { what: "Playback", needed: 37, have: 36 };
        assert_eq!(TrajectoryData::decode(&body), Err(playback));
        let none = DecodeError::Truncated { what: "TrajectoryData", needed: 1, have: 0 };
        assert_eq!(TrajectoryData::decode(&[]), Err(none));
    }
}
