//! DMC device with four motors that count steps. It takes a move of up to 200 frames, and runs it.

use dmc_proto::device::{self, DeviceMachine, Event, Next, Options, SmallSession, StopKind};
use dmc_proto::message::{AckCode, Capabilities, FrameNumber, FramesPerSecond, Hi, HostMessage, Motor, Motors, Steps};
use dmc_proto::upload::{Memory, Room, UploadBuffer};
use dmc_proto::{Millis, Patience};
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Ticker};
use embedded_io_async::{Read, Write};

const MOTORS: usize = 4;
const ROOM: Room = Room { motors: MOTORS as u8, channels: 0, frames: 200 };

/// Parts of a frame: a thousand for each thousandth of a frame per second and each millisecond.
const PARTS: u32 = 1_000_000;

/// Motors of the device, and its move.
struct Rig<'m> {
    at: [i32; MOTORS],
    to: [i32; MOTORS],
    moves: UploadBuffer<'m>,
    /// Frame of the film on which the motors are, and parts of the way to the next one.
    film: (i32, u32),
    /// Run that is prepared, and then under way.
    run: Option<Run>,
    runs: bool,
    /// Whether the machine waits for the news that all motors rest.
    owes_rest: bool,
}

/// Run or jog of all motors along the uploaded move.
#[derive(Clone, Copy)]
struct Run {
    /// Frame where it ends.
    to: i32,
    /// Parts of a frame in a millisecond.
    rate: u32,
    is_jog: bool,
}

impl device::Rig for Rig<'_> {
    fn verdict(&self, _: &HostMessage<'_>) -> AckCode {
        AckCode::OK
    }

    fn position(&self, motor: Motor) -> Steps {
        Steps(index(motor).map_or(0, |index| self.at[index]))
    }
}

/// Index of a motor of this device.
fn index(Motor(motor): Motor) -> Option<usize> {
    usize::from(motor).checked_sub(1).filter(|&index| index < MOTORS)
}

impl Rig<'_> {
    fn obey(&mut self, event: &Event<'_>) {
        match *event {
            Event::Stop(StopKind::Motor(motor)) if !self.runs => {
                index(motor).inspect(|&index| self.to[index] = self.at[index]);
            }
            Event::Stop(_) => {
                self.to = self.at;
                (self.run, self.runs) = (None, false);
            }
            Event::Move(motor, to) | Event::Jog(motor, _, to) => {
                index(motor).inspect(|&index| self.to[index] = to.0);
            }
            Event::ToFrame(frame) => self.go_to(frame),
            Event::JogAll(FramesPerSecond(rate), to) => {
                self.run = Some(Run { to: to.0, rate: rate.0, is_jog: true });
                self.runs = true;
            }
            Event::Prepare(HostMessage::RtRunMove(run)) => {
                self.go_to(run.start_frame);
                self.run = Some(Run { to: run.end_frame.0, rate: run.fps_x1000.0.0, is_jog: false });
            }
            Event::Go => return self.runs = true,
            Event::NextPass(from, to) => {
                self.go_to(from);
                return self.run.iter_mut().for_each(|run| run.to = to.0);
            }
            Event::Apply(HostMessage::MotorResetPosition(reset)) => {
                index(reset.motor).inspect(|&index| {
                    (self.at[index], self.to[index]) = (reset.position.0, reset.position.0);
                });
                return;
            }
            Event::PostRoll => (self.run, self.runs) = (None, false),
            _ => return,
        }
        self.owes_rest = true;
    }

    /// Sends all motors to a frame of the move.
    fn go_to(&mut self, frame: FrameNumber) {
        self.film = (frame.0, 0);
        let Some(frame) = self.moves.index(frame) else { return };
        for (to, motor) in self.to.iter_mut().zip((1..).map(Motor)) {
            *to = self.moves.position(motor, frame).map_or(*to, |steps| steps.0);
        }
    }

    /// Lets a millisecond pass, and reports what happened.
    fn tick(&mut self, session: &mut SmallSession) {
        if let Some(Run { to, rate, is_jog }) = self.run.filter(|_| self.runs) {
            let (frame, parts) = (self.film.0, self.film.1.saturating_add(rate));
            let frames = (parts / PARTS).min(to.abs_diff(frame));
            if frames > 0 {
                let way = to.wrapping_sub(frame).signum();
                let frame = FrameNumber(frame.wrapping_add(way.wrapping_mul(frames.cast_signed())));
                self.go_to(frame);
                let _ = session.at_frame(frame);
            }
            self.film.1 = parts % PARTS;
            if self.film.0 == to {
                self.runs = false;
                if !is_jog {
                    let _ = session.pass_end();
                }
            }
        }
        let moving: Motors = (1..=MOTORS as u8).map(Motor).filter(|&motor| self.step(motor)).collect();
        if moving != session.machine().moving() {
            let _ = session.moving(moving);
        }
        if self.owes_rest && !self.runs && moving == Motors::NONE {
            self.owes_rest = session.at_rest().is_err();
        }
    }

    /// Moves a motor by a step. Returns whether it is on its way.
    fn step(&mut self, motor: Motor) -> bool {
        let Some((at, to)) = index(motor).map(|index| (&mut self.at[index], self.to[index])) else { return false };
        *at += to.wrapping_sub(*at).signum();
        *at != to
    }
}

/// Serves a host on a line, until the line has an error.
pub async fn serve<L: Read + Write>(line: &mut L) -> Result<(), L::Error> {
    let (mut positions, mut written) = ([0; ROOM.positions()], [0; ROOM.written()]);
    let memory = Memory { positions: &mut positions, levels: &mut [], triggers: &mut [], written: &mut written };
    let Ok(moves) = UploadBuffer::new(ROOM, memory) else { return Ok(()) };
    let mut rig =
        Rig { at: [0; MOTORS], to: [0; MOTORS], moves, film: (0, 0), run: None, runs: false, owes_rest: false };
    let hi = Hi {
        motor_count: ROOM.motors,
        upload_frame_count: ROOM.frames,
        capabilities: Capabilities::REAL_TIME,
        ..Options::default().hi()
    };
    let mut session = SmallSession::new(DeviceMachine::new(Options::of(hi)), Patience::default());
    let mut ticker = Ticker::every(Duration::from_millis(1));
    let (mut out, mut arrived) = ([0; 256], [0; 64]);
    session.link_up();
    loop {
        let now = Millis(Instant::now().as_millis());
        match session.poll(now, &rig, &mut out) {
            Ok(Next::Transmit(frame)) => line.write_all(frame).await?,
            Ok(Next::Event(Event::Store { store, message })) => {
                let code = rig.moves.receive(&message).unwrap_or(AckCode::ERR_UNSUPPORTED);
                let _ = session.stored(store, code);
            }
            Ok(Next::Event(event)) => rig.obey(&event),
            Ok(Next::Wait(_)) | Err(_) => match select(line.read(&mut arrived), ticker.next()).await {
                Either::First(read) => {
                    let bytes = &arrived[..read?];
                    let taken = session.receive(Millis(Instant::now().as_millis()), bytes);
                    debug_assert_eq!(taken, bytes.len(), "the session waits, and takes a piece");
                }
                Either::Second(()) => rig.tick(&mut session),
            },
        }
    }
}
