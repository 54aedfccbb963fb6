//! Tests of the commands with a simulated rig, over loopback and in real time.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use dmc_proto::device::State;
use dmc_proto::message::{Ack, AckCode, Capabilities, DeviceMessage, Hi, HostMessage, MotorStatus, Motors};
use dmc_proto::{DeviceReader, Item, Patience};
use motion_rigs::dmc_device::{DmcDevice, Setup};
use motion_rigs::{LineId, Outgoing, Party as _, Rig as _};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream, duplex};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};
use tokio::sync::oneshot;
use tokio::time::sleep;

use super::*;
use crate::session::Target;

/// Move of one and a half seconds.
const SHORT: &str = r#"{
    "move": 1, "name": "Short", "rate": 24, "duration": 1.5,
    "axes": [{
        "name": "Slide", "unit": "mm",
        "keys": [{ "time": 0, "position": 0 }, { "time": 1.5, "position": 100 }],
        "dmc": { "motor": 2, "steps_per_unit": 80 }
    }]
}"#;

/// Rig that listens, and a session with it.
struct Stand {
    rig: Arc<Mutex<DmcDevice>>,
    start: Instant,
    session: Session<DmcHost>,
    said: Vec<u8>,
    interrupt: UnboundedSender<()>,
    /// Sender whose message cuts the line.
    cut: Option<oneshot::Sender<()>>,
}

impl Stand {
    async fn new(setup: Setup) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let target = Target::Tcp(listener.local_addr().unwrap());
        let (rig, start) = (Arc::new(Mutex::new(DmcDevice::new(setup))), Instant::now());
        let (cut, is_cut) = oneshot::channel();
        let served = Arc::clone(&rig);
        tokio::spawn(async move {
            let (line, _) = listener.accept().await.unwrap();
            tokio::select! {
                () = serve(line, &served, start) => {}
                Ok(()) = is_cut => {}
            }
            served.lock().unwrap().close(now(start), LineId(0));
        });
        let (interrupt, interrupts) = unbounded_channel();
        let session = Session::connect(DmcHost::default(), target, interrupts).await.unwrap();
        Self { rig, start, session, said: Vec::new(), interrupt, cut: Some(cut) }
    }

    async fn drive(&mut self, command: Command) -> Result<(), Trouble> {
        drive(&mut self.session, &command, &mut self.said).await
    }

    /// Line that says why a command was refused.
    async fn refused(&mut self, command: Command) -> String {
        let line = self.drive(command).await.unwrap_err().to_string();
        assert!(!line.contains('\n'), "{line}");
        line
    }

    fn rig<T>(&self, look: impl FnOnce(&mut DmcDevice) -> T) -> T {
        let mut rig = self.rig.lock().unwrap();
        rig.advance(now(self.start));
        look(&mut rig)
    }

    fn at(&self, motor: usize) -> f64 {
        let now = now(self.start);
        self.rig(|rig| rig.motors()[motor - 1].at(now).position)
    }

    /// Whether a motor is at a whole step.
    fn stands(&self, motor: usize, steps: i32) -> bool {
        (self.at(motor) - f64::from(steps)).abs() < 1e-9
    }
}

fn now(start: Instant) -> Millis {
    Millis(u64::try_from(start.elapsed().as_millis()).unwrap())
}

async fn serve(mut line: TcpStream, rig: &Mutex<DmcDevice>, start: Instant) {
    rig.lock().unwrap().open(now(start), LineId(0));
    let mut buffer = [0; 1024];
    loop {
        let mut out = Vec::new();
        let wake = {
            let mut rig = rig.lock().unwrap();
            rig.advance(now(start));
            while let Some(outgoing) = rig.poll() {
                if let Outgoing::Bytes(_, bytes) = outgoing {
                    out.extend(bytes);
                }
            }
            rig.wake().map_or(Duration::from_secs(1), |wake| Duration::from_millis(wake.since(now(start))))
        };
        if line.write_all(&out).await.is_err() {
            return;
        }
        tokio::select! {
            read = line.read(&mut buffer) => match read {
                Ok(len) if len > 0 => rig.lock().unwrap().receive(now(start), LineId(0), &buffer[..len]),
                _ => return,
            },
            () = sleep(wake) => {}
        }
    }
}

fn file(name: &str, text: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("dmc-{}-{name}.json", std::process::id()));
    std::fs::write(&path, text).unwrap();
    path
}

#[tokio::test]
async fn motors_are_queried_moved_jogged_and_calibrated() {
    let to = |motor, position| Command::Move { motor, position, speed: Some(20_000.0) };
    let jog = |motor, speed, seconds| Command::Jog { motor, speed, seconds };
    let range = |motor, begin, end| Command::Calibrate { motor, begin, end };
    let mut stand = Stand::new(Setup::default()).await;
    for command in [Command::Info, to(2, 2000.0), jog(1, -50.0, 0.3), range(3, 500.0, -500.0)] {
        stand.drive(command).await.unwrap();
    }
    for (wrong, what) in [
        (to(3, 501.0), "the rig would refuse the move: that is beyond the upper limit of a motor: "),
        (to(5, 1.0), "there is no motor 5: this rig has motors 1 to 4"),
        (to(2, 3e9), "the position is 3000000000: give whole steps"),
        (jog(1, 101.0, 1.0), "the speed is 101 %: give one from"),
        (jog(1, 0.0, 1.0), "the speed is 0 %: give one from"),
        (jog(1, 1.0, f64::NAN), "the time is NaN s: give seconds"),
        (range(1, 1.0, 1.0), "the range is empty"),
    ] {
        let line = stand.refused(wrong).await;
        assert!(line.starts_with(what), "{line}");
    }
    assert!(stand.stands(2, 2000) && stand.stands(3, -500));
    assert!((-6000.0..-1000.0).contains(&stand.at(1)), "{}", stand.at(1));
    assert!(!stand.session.host().may_move());
    let said = String::from_utf8(stand.said).unwrap();
    for line in
        ["motor 4 rests at 0 steps\n", "motor 2 rests at 2000 steps\n", "limits of motor 3: -500 to 500 steps, until"]
    {
        assert!(said.contains(line), "{said}");
    }
}

#[tokio::test]
async fn a_move_file_is_run_in_both_directions_and_with_photos() {
    let file = file("short", SHORT);
    let mut stand = Stand::new(Setup::default()).await;
    for (reverse, end) in [(false, 8000), (true, 0)] {
        stand.drive(Command::Run { file: file.clone(), reverse }).await.unwrap();
        assert!(stand.stands(2, end), "{}", stand.at(2));
    }
    let shots = Shots { shots: 2, interval: 0.1, exposure: 0.1, continuous: true };
    stand.drive(Command::Program { file: file.clone(), shots }).await.unwrap();
    stand.drive(Command::Expose { seconds: 0.1 }).await.unwrap();
    assert_eq!(stand.rig(|rig| rig.photo_count()), 3);
    assert!(stand.stands(2, 8000), "the last shot is at the last frame");
    let line = stand.refused(Command::Upload { file: "no/such.json".into() }).await;
    assert!(line.starts_with("no/such.json: "), "{line}");
    assert!(!stand.session.host().may_move());
}

#[tokio::test]
async fn an_impossible_command_is_refused_before_anything_moves() {
    let setup = Setup::with_motors(1).with_frames(30).with_capabilities(Capabilities::REAL_TIME);
    let mut stand = Stand::new(setup).await;
    let run = |name: &str, text: &str| Command::Run { file: file(name, text), reverse: false };
    let own = SHORT.replace("\"motor\": 2", "\"motor\": 1");
    let shots = Shots { shots: 2, interval: 0.1, exposure: 0.1, continuous: false };
    for (command, what) in [
        (run("other", SHORT), "the move needs motor 2, but the last motor of this rig is 1: "),
        (run("long", &own), "the move has 37 frames, but the rig has room for 30: "),
        (run("none", &SHORT.replace("\"dmc\"", "\"hoot\"")), ": no axis has a DMC motor"),
        (
            run("fast", &own.replace("\"keys\"", "\"limits\": { \"velocity\": 50, \"acceleration\": 1000 }, \"keys\"")),
            ": make the move slower",
        ),
        (run("broken", "{"), "line 1, column 1"),
        (Command::Program { file: file("shots", &own), shots }, "this rig cannot shoot frames"),
    ] {
        let line = stand.refused(command).await;
        assert!(line.contains(what), "{line}");
    }
    assert!(stand.stands(1, 0));
    assert!(!stand.session.host().may_move());
}

#[tokio::test]
async fn an_interrupted_move_is_stopped() {
    let mut stand = Stand::new(Setup::default()).await;
    let interrupt = stand.interrupt.clone();
    tokio::spawn(async move {
        sleep(Duration::from_millis(700)).await;
        interrupt.send(()).unwrap();
    });
    let long = Command::Move { motor: 1, position: 150_000.0, speed: None };
    assert!(matches!(stand.drive(long).await, Err(Trouble::Interrupted)));
    assert!(stand.session.host().may_move());
    assert_eq!(stand.session.stop().await, Stopped::Confirmed);
    let stopped = Instant::now();
    while stand.session.host().may_move() && stopped.elapsed() < Duration::from_secs(5) {
        stand.session.next_within(Duration::from_millis(100)).await.unwrap();
    }
    assert!(!stand.session.host().may_move(), "the host asked until it knew that nothing moves");
    assert_eq!(stand.rig(|rig| rig.machine().state()), State::Idle);
    assert!((1000.0..100_000.0).contains(&stand.at(1)), "{}", stand.at(1));
}

#[tokio::test]
async fn a_lost_line_in_a_run_is_reported_and_the_rig_stops() {
    let mut stand = Stand::new(Setup::default()).await;
    let cut = stand.cut.take().unwrap();
    tokio::spawn(async move {
        sleep(Duration::from_millis(1500)).await;
        cut.send(()).unwrap();
    });
    let path = file("lost", SHORT);
    let line = stand.refused(Command::Run { file: path, reverse: false }).await;
    assert!(line.starts_with("the rig is gone: "), "{line}");
    assert!(stand.session.host().may_move(), "the host does not know whether the motors rest");
    assert_eq!(stand.session.stop().await, Stopped::NotConfirmed);
    sleep(Duration::from_millis(700)).await;
    assert!(
        stand.rig(
            |rig| rig.machine().state() == State::Idle && rig.motors().iter().all(motion_rigs::motor::Motor::rests)
        )
    );
}

#[tokio::test]
async fn a_stop_is_sent_before_the_greeting() {
    let mut stand = Stand::new(Setup::default()).await;
    stand.drive(Command::Stop).await.unwrap();
}

#[tokio::test]
async fn a_limit_switch_is_reported() {
    let mut setup = Setup::default();
    setup.motors[0] = setup.motors[0].clone().within(motion_core::trajectory::Range::new(-500.0, 500.0));
    let mut stand = Stand::new(setup).await;
    let line = stand.refused(Command::Move { motor: 1, position: 1000.0, speed: None }).await;
    assert_eq!(line, "motor 1 ran into its upper limit switch: jog it back, and stay below it");
}

/// Rig that acknowledges everything, except that it answers a request for its camera with this code. These motors move for ever.
async fn answer(mut line: DuplexStream, camera: AckCode, motor_status: Motors) {
    let (mut reader, mut buffer) = (DeviceReader::new(Patience::default()), [0; 64]);
    while let Ok(len @ 1..) = line.read(&mut buffer).await {
        assert_eq!(reader.push(Millis(0), &buffer[..len]), len);
        let mut out = Vec::new();
        while let Some(Item::Frame(frame)) = reader.next() {
            let answer = match HostMessage::decode(&frame).unwrap() {
                HostMessage::Hi(_) => Hi { motor_count: 1, ..Hi::default() }.into(),
                HostMessage::MotorStatus(_) => {
                    DeviceMessage::MotorStatus(MotorStatus { motor_status, ..MotorStatus::default() })
                }
                HostMessage::GioCam(_) => Ack::new(frame.kind(), camera).into(),
                _ => Ack::new(frame.kind(), AckCode::OK).into(),
            };
            let mut bytes = vec![0; answer.encoded_len()];
            answer.encode_into(frame.id(), &mut bytes).unwrap();
            out.extend(bytes);
        }
        line.write_all(&out).await.unwrap();
    }
}

#[tokio::test]
async fn a_stop_tells_if_the_rig_does_not_close_its_shutter() {
    for (code, end) in [
        (AckCode::OK, None),
        (AckCode::ERR_UNSUPPORTED, None),
        (AckCode::ERR_GENERAL, Some("the rig refuses the end of the photo: it cannot do that now")),
    ] {
        let (line, rig) = duplex(4096);
        tokio::spawn(answer(rig, code, Motors::NONE));
        let (_interrupt, interrupts) = unbounded_channel();
        let mut session = Session::over(DmcHost::default(), line, interrupts);
        let done = drive(&mut session, &Command::Stop, &mut Vec::new()).await;
        let line = done.err().map(|trouble| trouble.to_string());
        let is_right = line.as_deref().map_or(end.is_none(), |line| end.is_some_and(|end| line.starts_with(end)));
        assert!(is_right, "{code:?}: {line:?}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_stop_tells_if_motors_of_an_earlier_session_do_not_rest() {
    let (line, rig) = duplex(4096);
    tokio::spawn(answer(rig, AckCode::OK, Motors(2)));
    let (_interrupt, interrupts) = unbounded_channel();
    let mut session = Session::over(DmcHost::default(), line, interrupts);
    let mut said = Vec::new();
    let done = drive(&mut session, &Command::Stop, &mut said).await;
    assert!(matches!(&done, Err(Trouble::MayMove(why)) if why == OBEYED) && said.is_empty(), "{done:?} {said:?}");
}

#[tokio::test(start_paused = true)]
async fn a_stop_of_a_session_that_moved_nothing_waits_for_motors_of_an_earlier_session() {
    for (moving, end) in [(Motors::NONE, Stopped::Confirmed), (Motors(2), Stopped::Obeyed)] {
        let (line, rig) = duplex(4096);
        tokio::spawn(answer(rig, AckCode::OK, moving));
        let (_interrupt, interrupts) = unbounded_channel();
        let mut session = Session::over(DmcHost::default(), line, interrupts);
        while session.host().machine().device().is_none() {
            session.next().await.unwrap();
        }
        assert!(!session.host().may_move());
        assert_eq!(session.stop().await, end);
    }
}
