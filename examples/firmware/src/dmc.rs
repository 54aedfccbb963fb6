//! DMC device with four motors that count steps. It takes a move of up to 200 frames, and runs it.

use dmc_proto::device::{self, DeviceMachine, Event, Next, Options, Playback, SmallSession, StopKind};
use dmc_proto::message::{AckCode, Capabilities, FrameNumber, Hi, HostMessage, Motor, Steps};
use dmc_proto::upload::{Memory, Room, UploadBuffer};
use dmc_proto::{Millis, Patience};
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Ticker};
use embedded_io_async::{Read, Write};

const ROOM: Room = Room { motors: 4, channels: 0, frames: 200 };

/// Motor that makes a step in a millisecond at most.
#[derive(Clone, Copy, Default)]
struct Counter {
    at: i32,
    to: i32,
}

/// Motors of the device, and its move.
struct Rig<'m> {
    motors: [Counter; ROOM.motors as usize],
    moves: UploadBuffer<'m>,
    playback: Playback,
}

impl device::Rig for Rig<'_> {
    fn verdict(&self, _: &HostMessage<'_>) -> AckCode {
        AckCode::OK
    }

    fn position(&self, motor: Motor) -> Steps {
        Steps(self.motors[index(motor)].at)
    }
}

/// Index of a motor. The machine refuses messages for motors that the device does not have.
fn index(Motor(motor): Motor) -> usize {
    usize::from(motor - 1)
}

impl Rig<'_> {
    fn obey(&mut self, event: &Event<'_>) {
        let frame = self.playback.obey(event);
        self.go_to(frame);
        match *event {
            Event::Stop(StopKind::Motor(motor)) => self.motors[index(motor)].to = self.motors[index(motor)].at,
            Event::Stop(_) => self.motors.iter_mut().for_each(|motor| motor.to = motor.at),
            Event::Move(motor, to) | Event::Jog(motor, _, to) => self.motors[index(motor)].to = to.0,
            Event::Apply(HostMessage::MotorResetPosition(reset)) => {
                self.motors[index(reset.motor)] = Counter { at: reset.position.0, to: reset.position.0 };
            }
            _ => {}
        }
    }

    /// Sends all motors to a frame of the move, if there is one to go to.
    fn go_to(&mut self, frame: Option<FrameNumber>) {
        let Some(frame) = frame.and_then(|frame| self.moves.index(frame)) else { return };
        for (counter, motor) in self.motors.iter_mut().zip((1..).map(Motor)) {
            counter.to = self.moves.position(motor, frame).map_or(counter.to, |steps| steps.0);
        }
    }

    /// Lets a millisecond pass, and reports what happened.
    fn tick(&mut self, session: &mut SmallSession) {
        let frame = self.playback.advance(1, session);
        self.go_to(frame);
        for motor in &mut self.motors {
            motor.at += motor.to.wrapping_sub(motor.at).signum();
        }
        let moves = |motor: &Motor| self.motors[index(*motor)].at != self.motors[index(*motor)].to;
        self.playback.report((1..=ROOM.motors).map(Motor).filter(moves).collect(), session);
    }
}

/// Serves a host on a line, until the line has an error.
pub async fn serve<L: Read + Write>(line: &mut L) -> Result<(), L::Error> {
    let (mut positions, mut written) = ([0; ROOM.positions()], [0; ROOM.written()]);
    let memory = Memory { positions: &mut positions, levels: &mut [], triggers: &mut [], written: &mut written };
    let Ok(moves) = UploadBuffer::new(ROOM, memory) else { return Ok(()) };
    let mut rig = Rig { motors: Default::default(), moves, playback: Playback::default() };
    let hi = Hi {
        motor_count: ROOM.motors,
        upload_frame_count: ROOM.frames,
        capabilities: Capabilities::REAL_TIME,
        ..Options::default().hi()
    };
    let mut session = SmallSession::new(DeviceMachine::new(Options::of(hi)), Patience::default());
    let mut ticker = Ticker::every(Duration::from_millis(1));
    let (mut out, mut arrived) = ([0; 128], [0; SmallSession::PIECE]);
    session.link_up();
    let now = || Millis(Instant::now().as_millis());
    loop {
        match session.poll(now(), &rig, &mut out) {
            Ok(Next::Transmit(frame)) => line.write_all(frame).await?,
            Ok(Next::Event(Event::Store { store, message })) => {
                let code = rig.moves.receive(&message).unwrap_or(AckCode::ERR_UNSUPPORTED);
                let _ = session.stored(store, code);
            }
            Ok(Next::Event(event)) => rig.obey(&event),
            Ok(Next::Wait(_)) | Err(_) => match select(line.read(&mut arrived), ticker.next()).await {
                Either::First(len) => _ = session.receive(now(), &arrived[..len?]),
                Either::Second(()) => rig.tick(&mut session),
            },
        }
    }
}
