//! Playback of the uploaded move, frame by frame: runs, and jogs of all motors. DMC D3.

use super::event::{Event, StopKind};
use super::session::Session;
use crate::message::{FrameNumber, FramesPerSecond, HostMessage, Motors};

/// Parts of a frame: a thousand for each thousandth of a frame per second and each millisecond.
const PARTS: u32 = 1_000_000;

/// Playback of the uploaded move in the firmware of a device, frame by frame: runs, and jogs of all motors.
///
/// Firmware gives it each event, and calls [`advance`](Self::advance) and [`report`](Self::report) regularly, for example every
/// millisecond. Playback says to which frame of the move all motors have to go, and reports to the session what the rig owes it:
/// frames, ends of passes, motors that move, and that all motors rest.
///
/// A pass and a jog have their full speed from their first frame on. A rig that uses the time of the pre-roll to accelerate,
/// and a rig that shoots frames, do so themselves.
///
/// ```
/// use dmc_proto::device::{Event, Playback};
/// use dmc_proto::message::{FrameNumber, FramesPerSecond, Scaled};
/// # use dmc_proto::device::{DeviceMachine, Options, Session};
/// # let mut session: Session = Session::new(DeviceMachine::new(Options::default()), dmc_proto::Patience::default());
///
/// let mut playback = Playback::default();
/// assert_eq!(playback.obey(&Event::ToFrame(FrameNumber(10))), Some(FrameNumber(10)));
///
/// // 50 frames per second are a frame in 20 milliseconds.
/// playback.obey(&Event::JogAll(FramesPerSecond(Scaled(50_000)), FrameNumber(8)));
/// assert_eq!(playback.advance(19, &mut session), None);
/// assert_eq!(playback.advance(1, &mut session), Some(FrameNumber(9)));
/// assert_eq!(playback.advance(20, &mut session), Some(FrameNumber(8)));
/// assert!(!playback.is_playing());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Playback {
    at: FrameNumber,
    /// Parts of the way to the next frame.
    part: u32,
    pass: Option<Pass>,
    is_playing: bool,
    /// Whether the machine waits for the report that the pass has ended.
    owes_end: bool,
}

/// Pass of a run, or a jog, that is prepared or plays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Pass {
    /// Frame where it ends.
    to: FrameNumber,
    /// Parts of a frame in a millisecond.
    rate: u32,
    is_run: bool,
}

impl Pass {
    const fn new(to: FrameNumber, FramesPerSecond(rate): FramesPerSecond, is_run: bool) -> Self {
        Self { to, rate: rate.0, is_run }
    }
}

impl Playback {
    /// Obeys an event. Returns the frame to which all motors of the move go because of it.
    ///
    /// A stop of everything ends the playback. The rig has to stop the motors.
    pub fn obey(&mut self, event: &Event<'_>) -> Option<FrameNumber> {
        match *event {
            Event::Stop(StopKind::Motor(_) | StopKind::Virtual(_)) => None,
            Event::Stop(_) | Event::PostRoll => {
                *self = Self { at: self.at, ..Self::default() };
                None
            }
            Event::ToFrame(frame) => {
                *self = Self { at: frame, ..Self::default() };
                Some(frame)
            }
            Event::JogAll(rate, to) => {
                (self.pass, self.is_playing) = (Some(Pass::new(to, rate, false)), true);
                None
            }
            Event::Prepare(HostMessage::RtRunMove(run)) => {
                let pass = Some(Pass::new(run.end_frame, run.fps_x1000, true));
                *self = Self { at: run.start_frame, pass, ..Self::default() };
                Some(run.start_frame)
            }
            Event::Go => {
                self.is_playing = self.pass.is_some();
                None
            }
            Event::NextPass(from, to) => {
                let pass = self.pass.map(|pass| Pass { to, ..pass });
                *self = Self { at: from, pass, is_playing: true, ..Self::default() };
                Some(from)
            }
            _ => None,
        }
    }

    /// Lets time pass, in milliseconds, and reports a new frame and the end of a pass. Returns the frame to which all motors go now,
    /// if it is a new one.
    pub fn advance<const N: usize, const CAP: usize>(
        &mut self,
        millis: u32,
        session: &mut Session<N, CAP>,
    ) -> Option<FrameNumber> {
        let frame = self.play(millis);
        if let Some(frame) = frame {
            let _ = session.at_frame(frame);
        }
        if self.owes_end {
            self.owes_end = session.pass_end().is_err();
        }
        frame
    }

    /// Moves on by a time in milliseconds. Returns the new frame, if it is another one.
    fn play(&mut self, millis: u32) -> Option<FrameNumber> {
        let Pass { to, rate, is_run } = self.pass.filter(|_| self.is_playing)?;
        let part = self.part.saturating_add(rate.saturating_mul(millis));
        let left = to.0.abs_diff(self.at.0);
        let frames = left.min(part / PARTS);
        self.part = part % PARTS;
        self.at.0 = if to < self.at {
            self.at.0.saturating_sub_unsigned(frames)
        } else {
            self.at.0.saturating_add_unsigned(frames)
        };
        if frames == left {
            (self.is_playing, self.owes_end) = (false, is_run);
        }
        (frames > 0).then_some(self.at)
    }

    /// Reports which motors move now, if it is news, and that all motors rest, if the session waits for that.
    ///
    /// While more than that waits in the session, nothing is reported. Then the next call does it.
    pub fn report<const N: usize, const CAP: usize>(&self, moving: Motors, session: &mut Session<N, CAP>) {
        if !session.is_settled() {
            return;
        }
        let machine = session.machine();
        // A session without anything that waits has room.
        let _ = if moving == Motors::NONE && machine.awaits_rest() && !self.is_playing {
            session.at_rest()
        } else if moving != machine.moving() {
            session.moving(moving)
        } else {
            Ok(())
        };
    }

    /// Frame to which all motors of the move were sent last.
    #[must_use]
    pub const fn frame(&self) -> FrameNumber {
        self.at
    }

    /// Way to the next frame that is done, in millionths, for rigs that move between two frames.
    #[must_use]
    pub const fn part(&self) -> u32 {
        self.part
    }

    /// Whether a pass or a jog plays.
    #[must_use]
    pub const fn is_playing(&self) -> bool {
        self.is_playing
    }
}
