//! Laws of uploads: sections that were cut are assembled again, a lost section is a gap, and hostile input does no
//! harm.

mod uploads;

use dmc_proto::lint::Context;
use dmc_proto::message::{
    AckCode, Capabilities, DmxChannel, FrameNumber, Hi, Motor, MotorStatusRequest, Motors, RtUploadMoveBegin,
    RtUploadMoveEnd, Steps, Triggers,
};
use dmc_proto::upload::{self, Memory, MoveSource, Room, SCRATCH, Section, SectionSize, Track, UploadBuffer};
use dmc_proto::{EncodeError, Frame, HostMessage, MessageId};
use motion_core::wire::Message;
use proptest::collection::{btree_map, vec};
use proptest::prelude::*;
use proptest::sample::{Index, select};
use uploads::{Memories, hostile};

const ROOM: Room = Room { motors: 4, channels: 6, frames: 700 };
fn end() -> HostMessage<'static> {
    RtUploadMoveEnd::default().into()
}

/// A move in memory.
#[derive(Clone, Debug, Default)]
struct Recorded {
    start: i32,
    count: usize,
    axes: std::collections::BTreeMap<u8, Vec<i32>>,
    channels: std::collections::BTreeMap<u16, Vec<u8>>,
    mask: u32,
    triggers: Vec<u32>,
}

impl MoveSource for Recorded {
    fn start_frame(&self) -> FrameNumber {
        FrameNumber(self.start)
    }

    fn frame_count(&self) -> u32 {
        u32::try_from(self.count).unwrap()
    }

    fn motors(&self) -> Motors {
        self.axes.keys().copied().map(Motor).collect()
    }

    fn position(&self, motor: Motor, index: u32) -> Steps {
        Steps(self.axes[&motor.0][index as usize])
    }

    fn has_channel(&self, channel: DmxChannel) -> bool {
        self.channels.contains_key(&channel.0)
    }

    fn level(&self, channel: DmxChannel, index: u32) -> u8 {
        self.channels[&channel.0][index as usize]
    }

    fn mask(&self) -> Triggers {
        Triggers(self.mask)
    }

    fn triggers(&self, index: u32) -> Triggers {
        Triggers(self.triggers[index as usize])
    }
}

/// Values that often stay the same.
fn values<T: Copy + std::fmt::Debug + 'static>(any: impl Strategy<Value = T>) -> impl Strategy<Value = Vec<T>> {
    let run = (any, prop_oneof![3 => 1..3_usize, 1 => 1..400_usize]);
    vec(run, 350..400).prop_map(|runs| runs.into_iter().flat_map(|(value, len)| vec![value; len]).take(700).collect())
}

fn recorded() -> impl Strategy<Value = Recorded> {
    let axes = btree_map(1..=4_u8, prop_oneof![values(any::<i32>()), values(-1..=1)], 0..=4);
    let channels = btree_map(1..=6_u16, values(any::<u8>()), 0..=6);
    let triggers = prop_oneof![values(0..8_u32), values(select(&[0, 0, 0, 1][..]))];
    (any::<i16>(), 1..=700_usize, axes, channels, 0..8_u32, triggers).prop_map(
        |(start, count, mut axes, mut channels, mask, mut triggers)| {
            for axis in axes.values_mut() {
                axis.resize(count, 7);
            }
            for channel in channels.values_mut() {
                channel.resize(count, 7);
            }
            triggers.resize(count, 0);
            Recorded { start: start.into(), count, axes, channels, mask, triggers }
        },
    )
}

/// A device that can take the whole move.
fn device() -> Context<'static> {
    Context::of(Hi {
        motor_count: ROOM.motors,
        dmx_count: ROOM.channels,
        gio_out_count: 3,
        upload_frame_count: ROOM.frames,
        capabilities: Capabilities::REAL_TIME,
        protocol_version: Some(2),
        ..Hi::decode(&[0; 49]).unwrap()
    })
}

/// Sends a message over the wire.
fn deliver(buffer: &mut UploadBuffer<'_>, message: &HostMessage<'_>, max_data: usize) -> Option<AckCode> {
    let mut wire = [0; 1048];
    let len = message.encode_checked(MessageId(1), &device(), &mut wire).unwrap();
    assert!(len <= max_data + 12, "{len} bytes");
    assert_eq!(message.lint(&device()).as_slice(), [], "law 14: {message}");
    buffer.receive(&HostMessage::decode(&Frame::decode(&wire[..len]).unwrap()).unwrap())
}

fn all(sections: impl Iterator<Item = Section>) -> Vec<Section> {
    sections.take(10_000).collect()
}

/// Sends sections of a move in the given order.
fn assemble(buffer: &mut UploadBuffer<'_>, source: &Recorded, sections: &[Section], max_data: usize) {
    let begin = upload::begin(source, &device()).unwrap();
    assert_eq!(deliver(buffer, &HostMessage::RtUploadMoveBegin(begin), max_data), Some(AckCode::OK));
    for section in sections {
        let mut scratch = [0; SCRATCH];
        let message = section.message(source, &mut scratch);
        assert_eq!(deliver(buffer, &message, max_data), Some(AckCode::OK), "{message}");
    }
    assert_eq!(deliver(buffer, &end(), max_data), Some(AckCode::OK));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_move_cut_into_sections_is_assembled_again(
        source in recorded(),
        order in vec(any::<Index>(), 0..40),
        max_data in prop_oneof![13..60_usize, Just(1036)],
    ) {
        let sections = all(upload::sections(&source, SectionSize::of(max_data)));
        // Some sections at any places, then all of them: in another order, and some of them twice.
        let mut shuffled = sections.clone();
        for (at, to) in order.iter().enumerate() {
            if !sections.is_empty() {
                shuffled.swap(at % sections.len(), to.index(sections.len()));
            }
        }
        let again = order.iter().filter(|_| !sections.is_empty()).map(|at| *at.get(&sections));
        let order: Vec<_> = again.chain(shuffled).collect();

        let mut memories = Memories::new(ROOM);
        let mut buffer = memories.buffer();
        assemble(&mut buffer, &source, &order, max_data);
        prop_assert!(buffer.is_loaded() && !buffer.mask_changed());
        for index in 0..source.frame_count() {
            let at = index as usize;
            prop_assert_eq!(buffer.index(FrameNumber(source.start + i32::try_from(at).unwrap())), Some(index));
            for motor in 0..6 {
                let wanted = source.axes.get(&motor).map(|axis| Steps(axis[at]));
                prop_assert_eq!(buffer.position(Motor(motor), index), wanted, "motor {} at {}", motor, index);
            }
            for channel in 0..8 {
                let wanted = source.channels.get(&channel).map(|levels| levels[at]);
                prop_assert_eq!(buffer.level(DmxChannel(channel), index), wanted, "channel {} at {}", channel, index);
            }
            prop_assert_eq!(buffer.triggers(index).0, source.triggers[at] & source.mask);
        }
        prop_assert_eq!(buffer.mask().0, source.mask);
        for track in (1..=4).map(|motor| Track::Axis(Motor(motor))) {
            prop_assert_eq!(buffer.gaps(track).next().is_none(), buffer.contains(track), "{:?}", track);
        }
    }

    #[test]
    fn a_lost_section_is_a_gap(source in recorded(), lost in vec(any::<bool>(), 1..20), max_data in 13..400_usize) {
        let sections = all(upload::sections(&source, SectionSize::of(max_data)));
        let lost = lost.into_iter().cycle();
        let arrived: Vec<_> = sections.into_iter().zip(lost).filter(|(_, lost)| !lost).map(|(it, _)| it).collect();
        let mut memories = Memories::new(ROOM);
        let mut buffer = memories.buffer();
        assemble(&mut buffer, &source, &arrived, max_data);

        let axes = source.axes.keys().map(|&motor| Track::Axis(Motor(motor)));
        let channels = source.channels.keys().map(|&channel| Track::Channel(DmxChannel(channel)));
        for track in axes.chain(channels) {
            let covered = |index| arrived.iter().filter(|it| it.track() == track).any(|it| {
                index >= it.from() && (it.is_last() || index < it.from() + it.count())
            });
            let wanted: Vec<_> = (0..source.frame_count()).filter(|&index| !covered(index)).collect();
            let gaps: Vec<_> = buffer.gaps(track).collect();
            prop_assert!(gaps.iter().all(|gap| !gap.is_empty()));
            prop_assert!(gaps.windows(2).all(|pair| pair[0].end < pair[1].start), "apart: {:?}", gaps);
            prop_assert_eq!(gaps.into_iter().flatten().collect::<Vec<_>>(), wanted);
        }
    }

    #[test]
    fn hostile_sections_do_what_the_model_does(input in vec(any::<u8>(), 0..600)) {
        hostile(&input);
    }
}

/// Ten frames of a device with 2 motors and 1 channel, ready for sections.
fn ten(memories: &mut Memories) -> UploadBuffer<'_> {
    let mut buffer = memories.buffer();
    assert_eq!(buffer.receive(&uploads::begin(100, 109)), Some(AckCode::OK));
    buffer
}

fn small() -> Memories {
    Memories::new(Room { motors: 2, channels: 1, frames: 20 })
}

fn positions(buffer: &UploadBuffer<'_>, motor: u8) -> Vec<i32> {
    (0..buffer.frame_count()).map_while(|index| buffer.position(Motor(motor), index)).map(|steps| steps.0).collect()
}

/// First frame of each gap, and the frame after it.
fn gaps(buffer: &UploadBuffer<'_>, motor: u8) -> Vec<(u32, u32)> {
    buffer.gaps(Track::Axis(Motor(motor))).map(|gap| (gap.start, gap.end)).collect()
}

/// Decision D-32: later sections win, a gap keeps the value before it, the last value is repeated.
#[test]
fn sections_may_overlap_and_leave_gaps() {
    let mut memories = small();
    let mut buffer = ten(&mut memories);
    for (start, values) in [(2, &[1, 2, 3][..]), (3, &[9]), (0x8000_0008, &[5])] {
        assert_eq!(uploads::axis(&mut buffer, 1, start, values), AckCode::OK);
    }
    assert_eq!(buffer.position(Motor(1), 2), None, "nothing is read before the end of the upload");
    assert_eq!(buffer.receive(&end()), Some(AckCode::OK));
    assert_eq!(positions(&buffer, 1), [1, 1, 1, 9, 3, 3, 3, 3, 5, 5]);
    assert_eq!(gaps(&buffer, 1), [(0, 2), (5, 8)]);
    assert_eq!(buffer.position(Motor(1), 10), None);
}

/// Decision D-32: a last section without values repeats the value before it. If there is no such value, nothing
/// happens.
#[test]
fn a_section_may_have_no_values() {
    let mut memories = small();
    let mut buffer = ten(&mut memories);
    for (start, values) in [(0x8000_0000, &[][..]), (10, &[]), (0, &[4, 5]), (0x8000_0004, &[])] {
        assert_eq!(uploads::axis(&mut buffer, 2, start, values), AckCode::OK);
    }
    buffer.receive(&end());
    assert_eq!(positions(&buffer, 2), [4, 5, 5, 5, 5, 5, 5, 5, 5, 5]);
    assert_eq!(gaps(&buffer, 2), [(2, 4)]);
}

/// Safety decision 5.
#[test]
fn an_axis_without_data_is_not_part_of_the_move() {
    let mut memories = small();
    let mut buffer = ten(&mut memories);
    uploads::axis(&mut buffer, 1, 0x8000_0000, &[3]);
    buffer.receive(&end());
    assert!(buffer.contains(Track::Axis(Motor(1))) && !buffer.contains(Track::Axis(Motor(2))));
    assert_eq!((buffer.position(Motor(2), 0), buffer.before_start(Motor(2))), (None, None));
    assert_eq!(gaps(&buffer, 2), [(0, 10)]);
}

/// Decisions D-31 and D-32, and the states of an upload.
#[test]
fn a_message_that_does_not_fit_is_refused_with_its_code() {
    let mut memories = small();
    let mut buffer = memories.buffer();
    assert_eq!(uploads::axis(&mut buffer, 1, 0, &[1]), AckCode::ERR_GENERAL, "no upload was started");
    assert_eq!(buffer.receive(&end()), Some(AckCode::OK), "without an upload, its end has no effect");
    assert!(!buffer.is_loaded());
    for (start, end) in [(5, 4), (0, 20), (i32::MIN, i32::MAX), (i32::MAX, i32::MIN)] {
        assert_eq!(buffer.receive(&uploads::begin(start, end)), Some(AckCode::ERR_RANGE), "{start} to {end}");
    }
    assert_eq!(buffer.receive(&uploads::begin(i32::MAX - 9, i32::MAX)), Some(AckCode::OK));
    for (motor, start, code) in [
        (0, 0, AckCode::ERR_RANGE),
        (3, 0, AckCode::ERR_RANGE),
        (1, 9, AckCode::ERR_RANGE),
        (1, 0x7fff_ffff, AckCode::ERR_RANGE),
        (2, 8, AckCode::OK),
    ] {
        assert_eq!(uploads::axis(&mut buffer, motor, start, &[1, 2]), code, "motor {motor} from {start}");
    }
    assert!(!buffer.contains(Track::Axis(Motor(1))), "refused as a whole");
    assert_eq!(buffer.receive(&MotorStatusRequest::default().into()), None);
    buffer.receive(&end());
    assert_eq!(uploads::axis(&mut buffer, 1, 0, &[1]), AckCode::ERR_GENERAL, "the upload is complete");
    assert_eq!(buffer.receive(&uploads::begin(5, 4)), Some(AckCode::ERR_RANGE));
    assert!(buffer.is_loaded(), "a refused upload does not change the last one");
    buffer.clear();
    assert_eq!((buffer.is_loaded(), buffer.frame_count(), buffer.contains(Track::Axis(Motor(2)))), (false, 0, false));
}

/// Safety decision 6, decision D-33.
#[test]
fn triggers_are_not_kept_from_frame_to_frame() {
    let mut memories = small();
    let mut buffer = ten(&mut memories);
    assert_eq!(uploads::triggers(&mut buffer, 3, &[(2, 1), (10, 1)]), AckCode::ERR_RANGE);
    assert_eq!(uploads::triggers(&mut buffer, 3, &[(2, 1), (4, 7)]), AckCode::OK);
    assert!(!buffer.mask_changed());
    assert_eq!(uploads::triggers(&mut buffer, 2, &[(9, 2)]), AckCode::OK);
    assert!(buffer.mask_changed());
    buffer.receive(&end());
    let on: Vec<_> = (0..11).map(|index| buffer.triggers(index).0).collect();
    assert_eq!(on, [0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0], "the last mask counts");
    assert!(buffer.contains(Track::Triggers) && buffer.gaps(Track::Triggers).next().is_none());

    let (mut positions, mut written) = ([0; 20], [0; 1]);
    let room = Room { motors: 1, channels: 0, frames: 20 };
    let memory = Memory { positions: &mut positions, levels: &mut [], triggers: &mut [], written: &mut written };
    let mut without = UploadBuffer::new(room, memory).unwrap();
    without.receive(&uploads::begin(0, 5));
    assert_eq!(uploads::triggers(&mut without, 1, &[(0, 1)]), AckCode::ERR_UNSUPPORTED);
}

#[test]
fn the_frame_before_the_first_gives_the_speed() {
    let mut memories = small();
    for (first, second, before) in [(10, 13, 7), (5, 5, 5), (i32::MAX, i32::MIN, i32::MAX), (i32::MIN, 5, i32::MIN)] {
        let mut buffer = ten(&mut memories);
        uploads::axis(&mut buffer, 1, 0, &[first, second]);
        buffer.receive(&end());
        assert_eq!(buffer.before_start(Motor(1)), Some(Steps(before)));
    }
    let mut buffer = memories.buffer();
    buffer.receive(&uploads::begin(7, 7));
    uploads::axis(&mut buffer, 1, 0, &[3]);
    buffer.receive(&end());
    assert_eq!(buffer.before_start(Motor(1)), Some(Steps(3)), "one frame has no speed");
}

#[test]
fn memory_that_is_too_small_is_refused() {
    let room = Room { motors: 2, channels: 1, frames: 64 };
    assert_eq!((room.positions(), room.levels(), room.triggers(), room.written()), (128, 64, 64, 9));
    for (what, lens) in [
        ("positions: need 128, have 127", [127, 64, 64, 9]),
        ("levels: need 64, have 63", [128, 63, 64, 9]),
        ("triggers: need 64, have 1", [128, 64, 1, 9]),
        ("written: need 9, have 8", [128, 64, 64, 8]),
    ] {
        let [positions, levels, triggers, written] = lens;
        let (mut positions, mut levels) = (vec![0; positions], vec![0; levels]);
        let (mut triggers, mut written) = (vec![Triggers::NONE; triggers], vec![0; written]);
        let memory =
            Memory { positions: &mut positions, levels: &mut levels, triggers: &mut triggers, written: &mut written };
        assert_eq!(UploadBuffer::new(room, memory).unwrap_err().to_string(), what);
    }
}

/// Decision D-10.
#[test]
fn sections_are_no_longer_than_every_device_takes() {
    let sizes = |size: SectionSize| (size.positions(), size.levels(), size.pairs());
    assert_eq!(sizes(SectionSize::default()), (256, 1024, 128));
    assert_eq!(sizes(SectionSize::of(65_535)), (256, 1024, 128), "no more values, although there is room");
    assert_eq!(sizes(SectionSize::of(100)), (23, 94, 12));
    assert_eq!(sizes(SectionSize::of(0)), (1, 1, 1), "at least one value, so that the upload ends");
}

/// Decision D-32: values that repeat to the end of the move are not sent.
#[test]
fn the_last_section_ends_with_the_last_change() {
    let axis = |values: Vec<i32>| Recorded {
        count: values.len(),
        triggers: vec![0; values.len()],
        axes: [(1, values)].into(),
        ..Recorded::default()
    };
    let cut = |source: &Recorded| -> Vec<_> {
        all(upload::sections(source, SectionSize::default()))
            .iter()
            .map(|it| (it.from(), it.count(), it.is_last()))
            .collect()
    };
    assert_eq!(cut(&axis(vec![5; 600])), [(0, 1, true)]);
    assert_eq!(cut(&axis((0..256).collect())), [(0, 256, true)]);
    assert_eq!(cut(&axis((0..257).collect())), [(0, 256, false), (256, 1, true)]);
    assert_eq!(cut(&axis((0..600).map(|at| at.min(255)).collect())), [(0, 256, true)]);
    assert_eq!(cut(&axis((0..600).map(|at| at.min(256)).collect())), [(0, 256, false), (256, 1, true)]);
    let late = (0..600).map(|at| i32::from(at == 599)).collect();
    assert_eq!(cut(&axis(late)), [(0, 256, false), (256, 256, false), (512, 88, true)]);
    assert_eq!(cut(&Recorded { count: 5, triggers: vec![0; 5], ..Recorded::default() }), [], "no track");
}

/// Safety decision 6.
#[test]
fn only_frames_with_a_trigger_on_are_sent() {
    let source = |mask, triggers: Vec<u32>| Recorded { count: triggers.len(), mask, triggers, ..Recorded::default() };
    let pairs = |source: &Recorded| -> Vec<Vec<(u32, u32)>> {
        let mut scratch = [0; SCRATCH];
        let sections = all(upload::sections(source, SectionSize::of(4 + 2 * 8)));
        sections
            .iter()
            .map(|section| match section.message(source, &mut scratch) {
                HostMessage::RtUploadMoveTriggers(message) => {
                    message.pairs.iter().map(|pair| (pair.frame(), pair.values().0)).collect()
                }
                other => panic!("{other}"),
            })
            .collect()
    };
    assert_eq!(pairs(&source(0, vec![1; 9])), Vec::<Vec<_>>::new(), "the move switches no output");
    assert_eq!(pairs(&source(1, vec![0; 9])), [[]], "all outputs are off, and the device gets the mask");
    assert_eq!(pairs(&source(3, vec![4, 1, 0, 6, 0, 7, 0])), [vec![(1, 1), (3, 2)], vec![(5, 3)]]);
    assert_eq!(pairs(&source(1, vec![1, 0, 0, 1])), [vec![(0, 1), (3, 1)]], "no empty section follows");
}

/// Decision D-31: the host checks a move before the upload.
#[test]
fn a_move_that_the_device_cannot_take_is_not_started() {
    struct Long(i32, u32);
    impl MoveSource for Long {
        fn start_frame(&self) -> FrameNumber {
            FrameNumber(self.0)
        }
        fn frame_count(&self) -> u32 {
            self.1
        }
        fn motors(&self) -> Motors {
            Motors::NONE
        }
        fn position(&self, _: Motor, _: u32) -> Steps {
            unreachable!("no motor")
        }
    }
    let begin = |start, count| upload::begin(&Long(start, count), &Context::default());
    let wrong = |value, max| Err(EncodeError::OutOfRange { what: "frame_count", value, min: 1, max });
    let whole =
        |start, end| Ok(RtUploadMoveBegin { start_frame: FrameNumber(start), end_frame: FrameNumber(end), tail: &[] });
    assert_eq!(begin(1, 0), wrong(0, 0x7fff_ffff));
    assert_eq!(begin(1, 1), whole(1, 1));
    assert_eq!(begin(i32::MAX - 1, 2), whole(i32::MAX - 1, i32::MAX));
    assert_eq!(begin(i32::MAX - 1, 3), wrong(3, 2));
    assert_eq!(begin(i32::MIN, upload::MAX_FRAMES), whole(i32::MIN, -1));
    assert_eq!(begin(i32::MIN, upload::MAX_FRAMES + 1), wrong(0x8000_0001, 0x8000_0000));

    let refused = |source: Recorded| upload::begin(&source, &device()).unwrap_err().to_string();
    let of = |count| Recorded { count, triggers: vec![0; count], ..Recorded::default() };
    assert_eq!(refused(of(701)), "end_frame: 700 is not in 0 to 699");
    assert_eq!(refused(Recorded { axes: [(5, vec![0])].into(), ..of(1) }), "motor: 5 is not in 1 to 4");
    assert_eq!(refused(Recorded { channels: [(7, vec![0])].into(), ..of(1) }), "channel: 7 is not in 1 to 6");
    let old = Context::of(Hi { protocol_version: None, ..device().device.unwrap() });
    let triggers = upload::begin(&Recorded { mask: 1, ..of(1) }, &old).unwrap_err().to_string();
    assert_eq!(triggers, "protocol_version: the device has an older version of the protocol");
}
