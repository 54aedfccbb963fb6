//! Everything that the libraries do with unchecked bytes.

use core::fmt::{self, Write};

use motion_core::fletcher::{self, Sum};
use motion_core::lint::Lints;
use motion_core::stream::{Frames, Framing, Item, Patience, TimedFrames};
use motion_core::time::Millis;
use motion_core::wire::{DecodeError, EncodeError, Messages};

/// Bytes for an encoded message. They are too few for some messages, and that must not panic either.
const ROOM: usize = 512;

/// Calls everything, and prints the results, because unused code would not be in the program.
pub fn everything(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    checksums(input, out)?;
    numbers(input, out)?;
    curves(input, out)?;
    axes(input, out)?;
    kos(input, out)?;
    reports(input, out)?;
    datagrams(input, out)?;
    moves(input, out)?;
    dmc(input, out)?;
    hoot(input, out)?;
    crate::machines::everything(input, out)?;
    crate::sessions::everything(input, out)
}

fn checksums(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    let (front, back) = input.split_at_checked(input.len() / 3).unwrap_or_default();
    let (first, whole) = (Sum::of(front), Sum::of(input));
    let joined = first.update(back) == first.then(Sum::of(back), back.len());
    let apart = whole.after(first, back.len());
    writeln!(out, "{whole:?} {apart:?} {joined} {} {:?}", fletcher::verify(input), whole.check_bytes())
}

fn numbers(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use motion_core::fixed::{Centi, Milli, TenMicro};

    let text = core::str::from_utf8(input).unwrap_or_default();
    outcome(text.parse::<Milli<i32>>(), out)?;
    outcome(text.parse::<TenMicro<u32>>(), out)?;
    outcome(text.parse::<kos_proto::message::Rotations>(), out)?;
    outcome(text.parse::<kos_proto::message::MotorAddress>(), out)?;
    outcome(text.parse::<kos_proto::message::Ipv4>(), out)?;
    outcome(text.parse::<kos_proto::message::MacAddress>(), out)?;
    outcome(text.parse::<kos_proto::message::FirmwareVersion>(), out)?;
    outcome(text.parse::<dmc_proto::message::Steps>(), out)?;
    outcome(text.parse::<hoot_proto::message::Motor>(), out)?;
    let float = f64::from_le_bytes(first(input));
    outcome(Centi::<i16>::from_f64(float), out)?;
    #[expect(clippy::cast_possible_truncation, reason = "any number is fine")]
    outcome(Centi::<i32>::from_f32_truncated(float as f32), out)
}

/// The first bytes, and zeros if there are too few.
pub fn first<const N: usize>(input: &[u8]) -> [u8; N] {
    let mut bytes = [0; N];
    for (to, from) in bytes.iter_mut().zip(input) {
        *to = *from;
    }
    bytes
}

fn curves(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use motion_core::bezier::{Cursor, Motion, Segment, Table};
    use motion_core::profile::{Limits, MotionProfile, MotionState};

    let mut numbers = input.chunks(8).map(|bytes| f64::from_le_bytes(first(bytes)));
    let mut number = || numbers.next().unwrap_or_default();
    #[expect(clippy::cast_possible_truncation, reason = "any number is fine")]
    let points = [
        [number() as f32, number() as f32],
        [number() as f32, number() as f32],
        [number() as f32, number() as f32],
        [number() as f32, number() as f32],
    ];
    if let Ok(segment) = Segment::from_f32(points) {
        let times: [f64; 20] = core::array::from_fn(|_| number());
        let mut motions = [Motion::default(); 20];
        Cursor::new(segment).sample_motion(&times, &mut motions);
        let known = motions.iter().filter(|motion| motion.velocity.is_some()).fold(0_usize, |n, _| n.wrapping_add(1));
        let halves = segment.split(number()).is_some();
        let peaks = segment.peak_velocity().is_some() & segment.peak_acceleration().is_some();
        writeln!(out, "{known} {halves} {peaks} {}", segment.reversed().folds())?;
        writeln!(out, "{:?} {:#?} {:?}", Cursor::new(segment), motions.first(), segment.keys())?;
        let table = Table::new(segment);
        writeln!(out, "{table:?} {} {:?}", table.parameter(number()) < table.position(number()), table.at(number()))?;
    }
    let limits = Limits { velocity: number(), acceleration: number(), jerk: Some(number()) };
    let start = MotionState { position: number(), velocity: number(), acceleration: number() };
    let profiles = [
        MotionProfile::new(number(), number(), limits),
        MotionProfile::stop(start, limits),
        MotionProfile::passing(start, number(), number(), limits),
    ];
    for profile in profiles {
        match profile {
            Ok(profile) => writeln!(out, "{profile:?} {:?}", profile.at(number()))?,
            Err(_) => writeln!(out, "no profile")?,
        }
    }
    Ok(())
}

/// Reads bytes as the segments of two axes, and as the numbers to sample them with.
fn axes(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use motion_core::bezier::{Point, Segment};
    use motion_core::trajectory::{Axis, FrameRate, FrameTimes, Map, Range, StepScale, Tolerance};

    let mut numbers = input.chunks(2).map(|bytes| f64::from(i16::from_le_bytes(first(bytes))));
    let mut number = || numbers.next().unwrap_or_default();
    let mut segment = || Segment::new(core::array::from_fn(|_| Point::new(number(), number()))).ok();
    let (Some(one), Some(two), Some(three)) = (segment(), segment(), segment()) else { return Ok(()) };
    let (ones, others) = ([one, two], [three]);
    let axis = match Axis::overlapping(&ones, "mm", number()) {
        Ok(axis) => axis,
        Err(error) => return writeln!(out, "{error} {error:?}"),
    };
    writeln!(out, "{axis:?} {:?} {:?} {:?}", axis.range(), axis.peak_velocity(), axis.peak_acceleration())?;
    let mut cursor = axis.cursor();
    writeln!(out, "{:?} {:?} {cursor:?}", cursor.at(number()), axis.at(number()))?;
    for joint in axis.joints(Tolerance::all(number())) {
        writeln!(out, "{joint:?}")?;
    }
    if let Ok(other) = Axis::new(&others, "mm") {
        writeln!(out, "{:?}", axis.distance(&other, number()))?;
    }
    let text = core::str::from_utf8(input).unwrap_or_default();
    writeln!(out, "{}", text.parse::<FrameRate>().is_ok())?;
    let Ok(rate) = FrameRate::new(24_000, 1001) else { return Ok(()) };
    let Some(frames) = FrameTimes::covering(axis.start(), axis.end(), rate) else { return Ok(()) };
    if let Ok(scale) = StepScale::new(number(), number()) {
        let mut steps = [0; 8];
        match axis.sample_steps(frames, 3, scale, &mut steps) {
            Ok(count) => writeln!(out, "{frames:?} {scale:?} {count} {steps:?}")?,
            Err(error) => writeln!(out, "{error} {error:?}")?,
        }
    }
    match Map::new(Range::new(number(), number()), Range::UNIT) {
        Ok(map) => writeln!(out, "{map:?} {:?}", one.mapped(&map, &map)),
        Err(error) => writeln!(out, "{error} {error:?}"),
    }
}

fn kos(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use kos_proto::lint::Context;
    use kos_proto::{DeviceMessage, Frame, HostMessage, Kos, frame};

    stream::<Kos<2048>, 4096>(input, out, |found, out| {
        let context = Context::default();
        let host = HostMessage::decode(&found);
        message(host, out, |message| message.lint(&context), |message, room| message.encode_checked(&context, room))?;
        let device = DeviceMessage::decode(&found);
        message(device, out, |message| message.lint(&context), |message, room| message.encode_checked(&context, room))?;
        let raw = frame::encode(found.id(), found.kind(), found.payload(), &mut [0; ROOM]);
        outcome(raw, out)?;
        writeln!(out, "{found:?}")
    })?;
    outcome(Frame::decode(input), out)
}

/// Reads bytes as USB reports, alone and joined.
fn reports(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use kos_proto::usb::{self, Fragments, Reassembly, Report};
    use motion_core::time::Millis;

    let mut reassembly = Reassembly::<2048>::assume();
    let mut now = Millis(0);
    for report in input.chunks(64) {
        now = now.after(u64::from(report.len() as u8));
        match usb::decode(report) {
            Ok(frame) => {
                outcome(Report::new(frame).map(|report| report.as_ref().len()), out)?;
                if let Ok(mut fragments) = Fragments::assume(frame) {
                    writeln!(out, "{}", fragments.next().is_some())?;
                }
            }
            Err(error) => writeln!(out, "{error} {error:?}")?,
        }
        let received = reassembly.push(now, report);
        writeln!(out, "{:?} {:?}", received.dropped, received.message)?;
    }
    writeln!(out, "{:?}", reassembly.expire(now.after(1000)))
}

/// Reads bytes as datagrams of a network.
fn datagrams(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use kos_proto::discovery::{Devices, Input};
    use kos_proto::message::Ipv4;
    use motion_core::time::Millis;

    let mut devices = Devices::<4>::default();
    let mut now = Millis(0);
    for bytes in input.chunks(27) {
        now = now.after(1000);
        let (next, output) = devices.step(now, Input::Datagram { source: Ipv4(1), bytes });
        devices = next;
        outcome(output.heard.map(|event| event.is_some()), out)?;
        writeln!(out, "{:?} {}", output.wake, output.gone.len())?;
    }
    Ok(())
}

fn dmc(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use dmc_proto::lint::Context;
    use dmc_proto::{DeviceMessage, Dmc, Frame, HostMessage, frame};

    stream::<Dmc, 4096>(input, out, |found, out| {
        let (id, context) = (found.id(), Context::default());
        let host = HostMessage::decode(&found);
        message(
            host,
            out,
            |message| message.lint(&context),
            |message, room| message.encode_checked(id, &context, room),
        )?;
        let device = DeviceMessage::decode(&found);
        message(
            device,
            out,
            |message| message.lint(&context),
            |message, room| message.encode_checked(id, &context, room),
        )?;
        let raw = frame::encode(id, found.kind(), found.payload(), &mut [0; ROOM]);
        outcome(raw, out)?;
        writeln!(out, "{found:?}")
    })?;
    outcome(Frame::decode(input), out)
}

fn hoot(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use hoot_proto::lint::Context;
    use hoot_proto::message::{Reply, ResponseCode};
    use hoot_proto::{DeviceMessage, Frame, Hoot, HostMessage, Query, Requests, Strict, frame};

    let with_frame = |found: Frame<'_>, out: &mut dyn Write| {
        let (to, context) = (found.address(), Context::default());
        let host = HostMessage::decode(&found);
        message(
            Ok(host),
            out,
            |message| message.lint(&context),
            |message, room| message.encode_checked(to, &context, room),
        )?;
        let device = Ok(DeviceMessage::decode(&found));
        message(device, out, |message| message.lint(&context), |message, room| message.encode_checked(&context, room))?;
        if let Some(query) = host.query() {
            // Any bytes are read as the answer to the query, and written again.
            match query.decode_reply(Reply { code: ResponseCode::OK, data: input }) {
                Ok(answer) => {
                    writeln!(out, "{answer}")?;
                    outcome(query.reply(answer, &mut [0; ROOM]).map(|reply| reply.data.len()), out)?;
                }
                Err(error) => writeln!(out, "{error}")?,
            }
        }
        let raw = frame::encode(to, found.sub_address(), found.command(), found.payload(), &mut [0; ROOM]);
        outcome(raw, out)?;
        writeln!(out, "{found:?}")
    };
    stream::<Hoot, 84>(input, out, with_frame)?;
    stream::<Requests, 84>(input, out, with_frame)?;
    stream::<Strict, 84>(input, out, with_frame)?;
    outcome(Frame::decode(input), out)
}

/// Feeds `input` in pieces of uneven lengths, with gaps and resets between some of them.
fn stream<F: Framing, const N: usize>(
    input: &[u8],
    out: &mut dyn Write,
    with_frame: impl Fn(F::Frame<'_>, &mut dyn Write) -> fmt::Result,
) -> fmt::Result {
    let mut frames = Frames::<F, N>::new();
    let mut rest = input;
    let mut turn = 0_usize;
    while !rest.is_empty() {
        turn = turn.wrapping_add(1);
        let piece = rest.get(..turn.wrapping_mul(37) % 300).unwrap_or(rest);
        let taken = frames.push(piece);
        rest = rest.get(taken..).unwrap_or_default();
        if turn % 5 == 0 || rest.is_empty() {
            frames.gap();
        }
        items(&mut frames, out, &with_frame)?;
        if turn % 7 == 0 {
            frames.give_up();
            items(&mut frames, out, &with_frame)?;
        }
        if turn % 50 == 0 {
            frames.reset();
        }
    }
    writeln!(out, "{frames:?} {}", frames.work())?;
    timed::<F, N>(input, out)
}

/// Feeds `input` as [`stream`] does, at times that its bytes give, and gives up frames that are not whole in time.
fn timed<F: Framing, const N: usize>(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    let mut numbers = input.iter().copied();
    let mut number = || u32::from(numbers.next().unwrap_or_default());
    let mut frames = TimedFrames::<F, N>::new(Patience::new().with_line_speed(number()).with_margin(number()));
    let (mut rest, mut now) = (input, Millis(0));
    while !rest.is_empty() {
        let taken = frames.push(now, rest.get(..31).unwrap_or(rest));
        rest = rest.get(taken..).unwrap_or_default();
        while let Some(item) = frames.next() {
            if matches!(item, Item::Fatal(_)) {
                frames.reset();
            }
        }
        now = now.after(number().into());
        frames.give_up(now);
        while let Some(Item::Frame(_) | Item::Corrupt { .. } | Item::Noise { .. }) = frames.next() {}
        writeln!(out, "{frames:?} {:?}", frames.deadline())?;
    }
    Ok(())
}

fn items<F: Framing, const N: usize>(
    frames: &mut Frames<F, N>,
    out: &mut dyn Write,
    with_frame: &impl Fn(F::Frame<'_>, &mut dyn Write) -> fmt::Result,
) -> fmt::Result {
    while let Some(item) = frames.next() {
        match item {
            Item::Frame(frame) => with_frame(frame, out)?,
            Item::Corrupt { header, why, bytes } => writeln!(out, "{header:?} {why} {why:?} {bytes:?}")?,
            Item::Noise { bytes, why } => writeln!(out, "{why} {why:?} {bytes:?}")?,
            Item::Fatal(why) => {
                writeln!(out, "{why} {why:?}")?;
                frames.resync();
            }
        }
    }
    Ok(())
}

/// Prints a message in both ways, lints it, and encodes it in both ways.
fn message<'a, M: Messages<'a>>(
    decoded: Result<M, DecodeError>,
    out: &mut dyn Write,
    lint: impl Fn(&M) -> Lints,
    encode_checked: impl Fn(&M, &mut [u8]) -> Result<usize, EncodeError>,
) -> fmt::Result {
    let message = match decoded {
        Ok(message) => message,
        Err(error) => return writeln!(out, "{error} {error:?}"),
    };
    writeln!(out, "{} {} {message} {message:?}", message.number(), message.name())?;
    for finding in lint(&message) {
        writeln!(out, "{}: {finding}", finding.severity)?;
    }
    let mut room = [0; ROOM];
    outcome(message.encode_body(&mut room), out)?;
    outcome(encode_checked(&message, &mut room), out)
}

/// Prints a result.
fn outcome<T: fmt::Debug, E: fmt::Display + fmt::Debug>(outcome: Result<T, E>, out: &mut dyn Write) -> fmt::Result {
    match outcome {
        Ok(value) => writeln!(out, "{value:?}"),
        Err(error) => writeln!(out, "{error} {error:?}"),
    }
}

/// Reads bytes as a move, and as the numbers of a plan.
fn moves(input: &[u8], out: &mut dyn Write) -> fmt::Result {
    use kos_proto::lint::Context;
    use kos_proto::message::{
        Motor, MotorAddress, Normalized, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds,
    };
    use kos_proto::trajectory::bezier::{self, Ease, Key};
    use kos_proto::trajectory::{
        Delay, LiveMotion, Loop, MotorPlan, Plan, Play, Times, Trajectory, TrajectoryData, Way,
    };
    use motion_core::wire::Message;

    let mut numbers = input.chunks(8).map(|bytes| f64::from_le_bytes(first(bytes)));
    let mut number = || numbers.next().unwrap_or_default();
    #[expect(clippy::cast_possible_truncation, reason = "any number is fine")]
    let mut small = || number() as f32;
    let motor = Motor {
        motor_address: MotorAddress(1),
        position: Rotations(small()),
        begin_position: None,
        end_position: Rotations(small()),
        max_max_setup_speed: RotationsPerSecond(small()),
        max_max_move_speed: RotationsPerSecond(small()),
        max_max_acceleration: RotationsPerSecondSquared(small()),
    };
    if let Ok(data) = TrajectoryData::decode(input) {
        let trajectory = match Trajectory::new(&data) {
            Ok(trajectory) => trajectory,
            Err(error) => return writeln!(out, "{error} {error:?}"),
        };
        let play = trajectory.play();
        let time = play.elapsed_at(small().into());
        writeln!(out, "{} {}", play.total_time().is_some(), trajectory.tracks().count())?;
        writeln!(
            out,
            "{trajectory:?} {:?} {:?}",
            trajectory.tracks().next(),
            trajectory.tracks().next().and_then(|track| track.peaks().next())
        )?;
        for excess in trajectory.excesses(&Context::default().with_motors(&[motor])) {
            writeln!(out, "{excess} {excess:?}")?;
        }
        for track in trajectory.tracks() {
            let Ok(track) = track.in_rotations(Rotations(small())) else { continue };
            let keys = track.keys().fold(0_usize, |n, _| n.wrapping_add(1));
            let limits = kos_proto::trajectory::Limits::from(&motor);
            writeln!(out, "{} {keys} {}", track.at(time).is_some(), track.excesses(limits).count())?;
            let segment = track.segments().next();
            let way = MotorPlan { motor: track.motor(), way: Way::Segments(segment.as_slice()) };
            match Plan::new(play, &[way]).encode(&mut [0; ROOM]) {
                Ok(data) => writeln!(out, "{data:?}")?,
                Err(error) => writeln!(out, "{error:?}")?,
            }
        }
    }
    let ease = |kind: u8, a: f64, b: f64| match kind % 3 {
        0 => Ease::Linear,
        1 => Ease::Flat(a),
        _ => Ease::Handle(bezier::Point::new(a, b)),
    };
    let kind = input.first().copied().unwrap_or_default();
    let keys: [Key; 3] = core::array::from_fn(|_| Key {
        time: small().into(),
        position: small().into(),
        arrive: ease(kind, small().into(), small().into()),
        leave: ease(kind, small().into(), small().into()),
    });
    let repeat = Times::new(kind).map_or(Loop::Once, Loop::Reverse);
    let delay = if kind % 2 == 0 { Delay::UntilFloat(small().to_bits()) } else { Delay::For(Seconds(small())) };
    let live = LiveMotion { duration: Seconds(small()), repeat, delay, home_speed: Normalized(small()) };
    let Ok(motor) = MotorPlan::new(&motor, &keys) else { return Ok(()) };
    let motors = [motor];
    let plan = Plan::new(Play::Live(live), &motors);
    writeln!(out, "{plan:?}")?;
    match plan.encode(&mut [0; ROOM]) {
        Ok(data) => writeln!(out, "{data:?}"),
        Err(error) => writeln!(out, "{error} {error:?}"),
    }
}
