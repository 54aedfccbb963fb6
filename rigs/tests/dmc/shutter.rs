//! Shutter after a stop: a host closes it, also if the device does not answer for some time.

use std::collections::BTreeMap;

use dmc_proto::host::{Outcome, Refusal, StopTarget};
use dmc_proto::message::{
    Ack, AckCode, Bool, CameraFlags, Capabilities, DeviceMessage, FrameNumber, GioCam, Hi, MotorStatus, Motors,
    RtRunMove, RunFlags,
};
use dmc_proto::{Frame, HostMessage, Token};
use motion_core::time::Millis;
use motion_rigs::dmc_host::{Answer, Command, DmcHost, Event, Shot};
use motion_rigs::{Host as _, LineId, Outgoing, Party as _};

const LINE: LineId = LineId(0);

/// Host, and a device that answers everything at once, except requests for its camera if it is deaf to them.
struct Desk {
    host: DmcHost,
    now: Millis,
    is_deaf: bool,
    /// Number of requests that close the shutter.
    closed: usize,
    ended: BTreeMap<Token, Result<Answer, Outcome<'static>>>,
}

fn answer(message: &HostMessage<'_>) -> DeviceMessage<'static> {
    let capabilities = Capabilities::REAL_TIME | Capabilities::SHOOT_FRAME | Capabilities::CAMERA_TRIGGER;
    match message {
        HostMessage::Hi(_) => Hi { motor_count: 1, capabilities, ..Hi::default() }.into(),
        HostMessage::MotorStatus(_) => {
            MotorStatus { motor_status: Motors::NONE, dmx_status: Bool(0), tail: &[] }.into()
        }
        message => Ack::new(message.kind(), AckCode::OK).into(),
    }
}

impl Desk {
    /// Host that has stopped a shot, on a device that does not answer to the request to close the shutter.
    fn stopped() -> Self {
        let (host, now) = (DmcHost::default(), Millis(1000));
        let mut desk = Self { host, now, is_deaf: false, closed: 0, ended: BTreeMap::new() };
        desk.host.open(now, LINE);
        desk.pass(100);
        desk.host.command(desk.now, Command::Shoot(Token(1), Shot::of(FrameNumber(1), 100)));
        desk.pass(1000);
        desk.host.command(desk.now, Command::Go);
        desk.pass(10);
        desk.is_deaf = true;
        desk.host.command(desk.now, Command::Stop(StopTarget::All));
        desk.pass(10);
        assert_eq!((desk.closed, desk.host.may_move()), (1, true));
        desk
    }

    fn pass(&mut self, millis: u64) {
        for _ in 0..millis {
            self.now = self.now.after(1);
            self.host.advance(self.now);
            while let Some(Outgoing::Bytes(_, bytes)) = self.host.poll() {
                self.take(&bytes);
            }
            while let Some(event) = self.host.next_event() {
                if let Event::Ended(token, end) = event {
                    self.ended.insert(token, end);
                }
            }
        }
    }

    fn take(&mut self, bytes: &[u8]) {
        let frame = Frame::decode(bytes).unwrap();
        let message = HostMessage::decode(&frame).unwrap();
        if let HostMessage::GioCam(camera) = message {
            self.closed += usize::from(!camera.flags.contains(CameraFlags::SHUTTER));
            if self.is_deaf {
                return;
            }
        }
        let mut bytes = [0; 256];
        let len = answer(&message).encode_into(frame.id(), &mut bytes).unwrap();
        self.host.receive(self.now, LINE, &bytes[..len]);
    }

    /// Gives the commands that open the shutter, one after the other. Returns the number of those that are not refused as
    /// busy.
    fn photos(&mut self) -> usize {
        let camera = GioCam { flags: CameraFlags::SHUTTER, tail: &[] };
        let run = RtRunMove { flags: Some(RunFlags::CAMERA_EVERY_FRAME), ..RtRunMove::default() };
        let commands = [
            Command::Ask(Token(2), camera.into()),
            Command::Begin(Token(3), run.into()),
            Command::Shoot(Token(4), Shot { is_second_form: true, ..Shot::of(FrameNumber(1), 100) }),
            Command::Shoot(Token(5), Shot::of(FrameNumber(1), 100)),
        ];
        self.ended.clear();
        for command in commands {
            self.host.command(self.now, command);
        }
        self.pass(5);
        let busy = Err(Outcome::Refused(Refusal::Busy));
        (2..=5).filter(|token| self.ended.get(&Token(*token)) != Some(&busy)).count()
    }
}

/// The request that closes the shutter could end the new photo.
#[test]
fn no_photo_begins_while_the_shutter_is_closed_after_a_stop() {
    let mut desk = Desk::stopped();
    assert_eq!(desk.photos(), 0);
    desk.pass(3000);
    assert_eq!(desk.photos(), 0);
    desk.is_deaf = false;
    desk.pass(2000);
    assert!(!desk.host.may_move(), "the shutter is closed");
    assert!(desk.photos() > 0);
}

/// A device that never answers may have a camera all the same.
#[test]
fn a_host_gives_up_to_close_the_shutter_after_some_seconds() {
    let mut desk = Desk::stopped();
    desk.pass(9000);
    assert_eq!(desk.photos(), 0);
    desk.pass(3000);
    let closed = desk.closed;
    assert!(closed > 15, "{closed}");
    assert!(desk.host.may_move(), "the shutter may still be open");
    desk.pass(10_000);
    assert_eq!(desk.closed, closed);
    assert!(desk.photos() > 0);
}

#[test]
fn a_shutter_that_a_stop_left_open_is_closed_over_the_next_link() {
    let mut desk = Desk::stopped();
    desk.host.close(desk.now, LINE);
    desk.pass(5000);
    desk.is_deaf = false;
    desk.host.open(desk.now, LINE);
    desk.pass(2000);
    assert_eq!((desk.closed, desk.host.may_move()), (2, false));
}
