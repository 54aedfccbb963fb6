//! Moves of a capture: trajectories that a host sends to kOS motors, and uploads to DMC controllers.

use dmc_proto::message::{AckCode, Motor, RtUploadMoveBegin};
use dmc_proto::upload::{Memory, Room, Track as Uploaded, UploadBuffer};
use examples::cli::{Args, Protocol, Stop};
use examples::program::Failure;
use examples::record::{Find, Record};
use examples::tap::tap;
use examples::text::Side;
use kos_proto::trajectory::Trajectory;
use plot::{Recording, Track};

/// Greatest number of frames of an upload that is read: more than eleven hours at 24 frames per second. A damaged
/// capture could name any number.
const MOST_FRAMES: i64 = 1_000_000;
/// Number of motors of a DMC controller.
const MOTORS: u8 = 32;
/// Number of points of a curve from one key frame to the next.
const POINTS: u16 = 200;
/// Number of gaps that a line names.
const NAMED: usize = 4;

/// Reads the moves of a capture, and a line for each move that cannot be drawn.
pub(super) fn read(args: &Args, protocol: Protocol) -> Result<(Recording, Vec<String>), Failure> {
    let name = args.file.display().to_string();
    let mut moves: Box<dyn Moves> = match protocol {
        Protocol::Kos => Box::<Trajectories>::default(),
        Protocol::Dmc => Box::<Uploads>::default(),
        Protocol::Hoot => {
            return Err(Failure::usage("a capture of hoot has no curves to draw: use kos or dmc"));
        }
    };
    let mut tap = tap(protocol, args.transport)?;
    let mut source = args.open()?.source;
    let mut see = |record: &Record<'_>| -> Result<(), Stop> {
        if let (Side::Host, Find::Frame(shown)) = (record.from, &record.find) {
            moves.take(record.offset, shown.frame);
        }
        Ok(())
    };
    while let Some(piece) = source.next_piece().map_err(|error| args.stop(error))? {
        tap.push(piece, &mut see)?;
    }
    tap.end(&mut see)?;
    let Found { about, tracks, faults } = moves.end();
    if tracks.is_empty() {
        let why = faults.into_iter().next().unwrap_or_else(|| format!("no {about} from the host: is --from right?"));
        return Err(Failure::not_done(format!("{name}: {why}")));
    }
    let title = args.file.file_name().map_or(name, |name| name.to_string_lossy().into_owned());
    Ok((Recording { title, about: about.to_owned(), tracks }, faults))
}

/// Moves that were found.
#[derive(Default)]
struct Found {
    /// Kind of the moves, for a title.
    about: &'static str,
    tracks: Vec<Track>,
    /// Lines about moves that cannot be drawn.
    faults: Vec<String>,
}

/// Reader of the frames of a host.
trait Moves {
    /// Takes a frame, which begins at an offset of the bytes of the host.
    fn take(&mut self, offset: u64, frame: &[u8]);

    /// Returns the moves, after the last frame.
    fn end(&mut self) -> Found;
}

/// Trajectories of kOS.
#[derive(Default)]
struct Trajectories {
    found: Found,
    /// The last trajectory: a host sends it again if its answer is lost.
    last: Vec<u8>,
    count: u32,
}

impl Moves for Trajectories {
    fn take(&mut self, offset: u64, frame: &[u8]) {
        let Ok(frame) = kos_proto::Frame::decode(frame) else { return };
        let Ok(kos_proto::HostMessage::SetTrajectoryData(data)) = kos_proto::HostMessage::decode(&frame) else {
            return;
        };
        if self.last == frame.payload() {
            return;
        }
        self.last = frame.payload().to_vec();
        self.count += 1;
        let count = self.count;
        let trajectory = match Trajectory::new(&data) {
            Ok(trajectory) => trajectory,
            Err(error) => return self.found.faults.push(format!("move {count} at byte {offset} of the host: {error}")),
        };
        let time = trajectory.play().move_time();
        let (scale, time_unit) = if time.is_finite() && time > 0.0 { (time, " s") } else { (1.0, " of the move") };
        for track in trajectory.tracks() {
            let name = format!("Move {count}, motor {}", track.motor());
            let lines = track.segments().map(|segment| {
                let length = segment.end() - segment.start();
                let times = (0..=POINTS).map(|point| segment.start() + length * f64::from(point) / f64::from(POINTS));
                times.map(|time| (time * scale, segment.at(time).position)).collect()
            });
            let lines: Vec<_> = lines.collect();
            if lines.is_empty() {
                self.found.faults.push(format!("move {count}, motor {}: it has no segments", track.motor()));
                continue;
            }
            let keys = track.keys().map(|key| (key.time * scale, key.position)).collect();
            self.found.tracks.push(Track { name, unit: "of the range", span: 0.0..scale, time_unit, lines, keys });
        }
    }

    fn end(&mut self) -> Found {
        self.found.about = "kOS trajectory data";
        std::mem::take(&mut self.found)
    }
}

/// Uploads of DMC.
#[derive(Default)]
struct Uploads {
    found: Found,
    open: Option<Upload>,
    count: u32,
    /// Whether sections came without a begin.
    is_headless: bool,
}

/// Upload that has begun: its own messages, which are assembled at its end.
struct Upload {
    offset: u64,
    first: f64,
    frames: u32,
    messages: Vec<Vec<u8>>,
}

impl Moves for Uploads {
    fn take(&mut self, offset: u64, bytes: &[u8]) {
        use dmc_proto::HostMessage as Message;

        let Ok(frame) = dmc_proto::Frame::decode(bytes) else { return };
        match Message::decode(&frame) {
            Ok(Message::RtUploadMoveBegin(begin)) => {
                self.give_up("the next upload begins before its end");
                self.begin(offset, &begin, bytes);
            }
            Ok(Message::RtUploadMoveAxis(_)) => match &mut self.open {
                Some(upload) => upload.messages.push(bytes.to_vec()),
                None if self.count == 0 => self.is_headless = true,
                None => {}
            },
            Ok(Message::RtUploadMoveEnd(_)) => {
                if let Some(mut upload) = self.open.take() {
                    upload.messages.push(bytes.to_vec());
                    self.assemble(&upload);
                }
            }
            _ => {}
        }
    }

    fn end(&mut self) -> Found {
        self.give_up("the end of the upload is missing");
        if self.is_headless {
            let line = "the capture begins within an upload: the message RtUploadMoveBegin is missing";
            self.found.faults.insert(0, line.to_owned());
        }
        self.found.about = "DMC uploads";
        std::mem::take(&mut self.found)
    }
}

impl Uploads {
    fn begin(&mut self, offset: u64, begin: &RtUploadMoveBegin<'_>, bytes: &[u8]) {
        self.count += 1;
        let frames = i64::from(begin.end_frame.0) - i64::from(begin.start_frame.0) + 1;
        match u32::try_from(frames) {
            Ok(frames) if (1..=MOST_FRAMES).contains(&i64::from(frames)) => {
                let (first, messages) = (f64::from(begin.start_frame.0), vec![bytes.to_vec()]);
                self.open = Some(Upload { offset, first, frames, messages });
            }
            _ => self.fault(offset, &format!("it has {frames} frames, and 1 to {MOST_FRAMES} can be drawn")),
        }
    }

    fn give_up(&mut self, why: &str) {
        if let Some(upload) = self.open.take() {
            self.fault(upload.offset, why);
        }
    }

    fn fault(&mut self, offset: u64, why: &str) {
        self.found.faults.push(format!("upload {} at byte {offset} of the host: {why}", self.count));
    }

    fn assemble(&mut self, upload: &Upload) {
        let room = Room { motors: MOTORS, channels: 0, frames: upload.frames };
        let (mut positions, mut written) = (vec![0; room.positions()], vec![0; room.written()]);
        let memory = Memory { positions: &mut positions, levels: &mut [], triggers: &mut [], written: &mut written };
        let mut buffer = match UploadBuffer::new(room, memory) {
            Ok(buffer) => buffer,
            Err(error) => return self.fault(upload.offset, &error.to_string()),
        };
        for bytes in &upload.messages {
            let Ok(frame) = dmc_proto::Frame::decode(bytes) else { continue };
            let Ok(message) = dmc_proto::HostMessage::decode(&frame) else { continue };
            if buffer.receive(&message).is_some_and(|code| code != AckCode::OK) {
                return self.fault(upload.offset, "a section is outside the move or names no motor from 1 to 32");
            }
        }
        let motors = (1..=MOTORS).map(Motor).filter(|&motor| buffer.contains(Uploaded::Axis(motor)));
        let (mut missing, mut tracks) = (Vec::new(), Vec::new());
        for motor in motors {
            let gaps: Vec<_> = buffer.gaps(Uploaded::Axis(motor)).collect();
            missing.extend(gaps.iter().map(|gap| {
                let (from, to) = (upload.first + f64::from(gap.start), upload.first + f64::from(gap.end) - 1.0);
                format!("motor {motor}, frames {from} to {to}")
            }));
            let line = (0..upload.frames).filter_map(|index| {
                let position = buffer.position(motor, index)?;
                Some((upload.first + f64::from(index), f64::from(position.0)))
            });
            let last = upload.first + f64::from(upload.frames.max(2)) - 1.0;
            tracks.push(Track {
                name: format!("Upload {}, motor {motor}", self.count),
                unit: "steps",
                span: upload.first..last,
                time_unit: "",
                lines: vec![line.collect()],
                keys: Vec::new(),
            });
        }
        if missing.is_empty() {
            if tracks.is_empty() {
                return self.fault(upload.offset, "it has no positions");
            }
            return self.found.tracks.append(&mut tracks);
        }
        let more = missing.len().saturating_sub(NAMED);
        missing.truncate(NAMED);
        let more = if more > 0 { format!("; and {more} more") } else { String::new() };
        self.fault(upload.offset, &format!("sections are missing: {}{more}", missing.join("; ")));
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::{Path, PathBuf};

    use clap::Parser;
    use dmc_proto::lint::Context;
    use dmc_proto::message::{FrameNumber, Motors, RtUploadMoveEnd, Steps};
    use dmc_proto::upload::{self, MoveSource, SCRATCH, SectionSize};
    use dmc_proto::{HostMessage, MessageId};
    use examples::program::Status;
    use examples::record::hex;
    use kos_proto::message::{MotorAddress, Normalized, Rotations, Seconds};
    use kos_proto::trajectory::bezier::{Ease, Key};
    use kos_proto::trajectory::{Delay, LiveMotion, Loop, MotorPlan, Plan, Play, Way};

    use super::super::plot;
    use super::*;

    /// Motors 1 and 3 move evenly, for 1000 frames.
    struct Ramp;

    impl MoveSource for Ramp {
        fn start_frame(&self) -> FrameNumber {
            FrameNumber(1)
        }
        fn frame_count(&self) -> u32 {
            1000
        }
        fn motors(&self) -> Motors {
            Motors::from_iter([Motor(1), Motor(3)])
        }
        fn position(&self, motor: Motor, index: u32) -> Steps {
            Steps(i32::from(motor.0) * i32::try_from(index).unwrap())
        }
    }

    /// Lines of hex digits, one for each message of an upload.
    fn upload() -> Vec<String> {
        let mut lines = Vec::new();
        let mut add = |message: &HostMessage<'_>| {
            let mut out = [0; 2048];
            let length = message.encode_into(MessageId(7), &mut out).unwrap();
            lines.push(format!("> {}", hex(&out[..length])));
        };
        let mut scratch = [0; SCRATCH];
        add(&upload::begin(&Ramp, &Context::default()).unwrap().into());
        for section in upload::sections(&Ramp, SectionSize::default()) {
            add(&section.message(&Ramp, &mut scratch));
        }
        add(&RtUploadMoveEnd::default().into());
        lines
    }

    fn trajectory() -> String {
        let play = Play::Live(LiveMotion {
            duration: Seconds(10.0),
            repeat: Loop::Once,
            delay: Delay::None,
            home_speed: Normalized(0.2),
        });
        let key = |time, position| Key { time, position, arrive: Ease::Flat(0.4), leave: Ease::Flat(0.4) };
        let keys = [key(0.0, 5.0), key(4.0, 40.0), key(10.0, 10.0)];
        let way = Way::Keys { range: Rotations(50.0), keys: &keys };
        let motors = [1, 2].map(|motor| MotorPlan { motor: MotorAddress(motor), way });
        let mut blocks = [0; Plan::MAX_LEN];
        let data = Plan::new(play, &motors).encode(&mut blocks).unwrap();
        let mut out = [0; 4096];
        let length = kos_proto::HostMessage::SetTrajectoryData(data).encode_into(&mut out).unwrap();
        format!("> {}", hex(&out[..length]))
    }

    fn folder(test: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("moco-plot-{}-{test}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    /// Draws a capture as SVG. Returns the drawing and the output.
    fn drawn(folder: &Path, protocol: &str, text: &str) -> Result<(String, String), Failure> {
        let (capture, svg) = (folder.join("capture.txt"), folder.join("capture.svg"));
        let _ = fs::remove_file(&svg);
        fs::write(&capture, text).unwrap();
        let words = ["plot", capture.to_str().unwrap(), "--protocol", protocol, "--svg", svg.to_str().unwrap()];
        let mut output = Vec::new();
        let result = plot(&super::super::Args::try_parse_from(words).unwrap(), &mut output);
        // A picture is there if and only if the command is done.
        assert_eq!(svg.exists(), result.is_ok());
        result.map(|()| (fs::read_to_string(svg).unwrap(), String::from_utf8(output).unwrap()))
    }

    #[track_caller]
    fn fails(folder: &Path, protocol: &str, lines: &[String], part: &str) {
        let failure = drawn(folder, protocol, &lines.join("\n")).unwrap_err();
        assert_eq!(failure.status, Status::NotDone);
        assert!(failure.line.contains(part) && failure.line.lines().count() == 1, "{failure:?}");
    }

    #[test]
    fn an_upload_has_a_panel_for_each_motor() {
        let folder = folder("upload");
        let (svg, said) = drawn(&folder, "dmc", &upload().join("\n")).unwrap();
        for text in ["Upload 1, motor 1", "Upload 1, motor 3", "steps", "DMC uploads", "capture.txt"] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(!svg.contains("motor 2") && said.lines().count() == 1, "{said}");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn missing_sections_are_named() {
        let folder = folder("missing");
        let (whole, mut lines) = (upload(), upload());
        lines.remove(1);
        let file = folder.join("capture.txt").display().to_string();
        fails(
            &folder,
            "dmc",
            &lines,
            &format!("{file}: upload 1 at byte 0 of the host: sections are missing: motor 1"),
        );
        let (end, begin) = (&whole[..whole.len() - 1], &whole[1..]);
        fails(&folder, "dmc", end, "the end of the upload is missing");
        fails(&folder, "dmc", begin, "the message RtUploadMoveBegin is missing");
        fails(&folder, "dmc", &["< 00".to_owned()], "no DMC uploads from the host");
        // A complete upload is drawn, and a line tells of the other one.
        let both: Vec<_> = lines.into_iter().chain(whole).collect();
        let (svg, said) = drawn(&folder, "dmc", &both.join("\n")).unwrap();
        assert!(svg.contains("Upload 2, motor 1") && said.starts_with("upload 1 at byte 0"), "{said}");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn trajectories_of_kos_are_drawn_once() {
        let folder = folder("kos");
        // The host repeats the message, because its answer was lost.
        let (svg, said) = drawn(&folder, "kos", &[trajectory(), trajectory()].join("\n")).unwrap();
        for text in ["Move 1, motor 1", "Move 1, motor 2", "of the range", "10 s"] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(!svg.contains("Move 2") && said.lines().count() == 1, "{said}");
        let line = trajectory();
        fails(&folder, "kos", &[line[..line.len() - 20].to_owned()], "no kOS trajectory data from the host");
        let mut damaged = line;
        // The kind of the first block is damaged.
        damaged.replace_range(damaged.len() - 60.., &"f".repeat(60));
        fails(&folder, "kos", &[damaged], "move 1 at byte 0 of the host: ");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn hoot_has_no_curves() {
        let folder = folder("hoot");
        assert_eq!(drawn(&folder, "hoot", "").unwrap_err().status, Status::Usage);
        fs::remove_dir_all(folder).unwrap();
    }
}
