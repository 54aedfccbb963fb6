//! A simulated NMX: a node with three motors and a camera.
//!
//! Lines are the ports of the node: 0 is USB, 1 is Bluetooth, 2 is the bus. The node is a bridge: it forwards packets for
//! other receivers. It reads packets as firmware does: a wrong byte costs a packet. Of packets that arrive together, a mild node
//! reads the first one. A node that is named after firmware reads all of them, but blocks for some commands, and hangs when
//! packets pile up meanwhile ([`HootNode::is_hung`]). Positions are microsteps. Direction 1 counts up and direction 0 down, or the opposite if the motor
//! was set so by `MotorSetDirection`; positions always mean the same place.
//!
//! ```
//! use motion_core::time::Millis;
//! use motion_rigs::hoot_node::{HootNode, Setup};
//! use motion_rigs::{LineId, Outgoing, Party};
//!
//! let mut node = HootNode::new(Setup::default());
//! node.open(Millis(0), LineId(0));
//! node.receive(Millis(1), LineId(0), &[0, 0, 0, 0, 0, 0xFF, 3, 0, 2, 0]);
//! let ok = vec![0, 0, 0, 0, 0, 0xFF, 0, 0, 1, 0];
//! assert_eq!(node.poll(), Some(Outgoing::Bytes(LineId(0), ok)));
//! ```

mod camera;
mod devices;
mod lead;
mod main_loop;
mod motors;
mod setup;

use std::collections::VecDeque;

use hoot_proto::device::{
    Answer, Command, Contents, DeviceMachine, Effect, Event, Input, Port, ProgramState, Quirks, Transmit,
};
use hoot_proto::frame::{MAX_DATA, MAX_FRAME};
use hoot_proto::message::{Amperes, Level, Microstep, ProgramMode, RingTip, Scaled, Volts};
use hoot_proto::query::Profile;
use hoot_proto::{Address, Item, Strict};
use motion_core::stream::{self, Noise};
use motion_core::time::Millis;
use tracing::{debug, info, warn};

pub use camera::{Camera, PHOTOS, Photo};
use lead::Lead;
use main_loop::MainLoop;
pub use setup::Setup;

use crate::motor::Motor;
use crate::{LineId, Outgoing, Party, Rig, TICK};

/// Time of silence inside a packet after which it is dropped, in milliseconds: more than 100 (hoot, section 1.1).
const GAP: u64 = 101;

/// Ports, in the order of their lines.
const PORTS: [Port; 3] = [Port::Usb, Port::Bluetooth, Port::Bus];

/// Port, with the bytes that arrive at it.
#[derive(Debug)]
struct Wire {
    is_open: bool,
    frames: stream::Frames<Strict, { 2 * MAX_FRAME }>,
    /// Time after which the rest of a packet is not awaited any more.
    until: Option<Millis>,
    /// Bytes that arrived while the main loop did not read.
    waiting: Vec<u8>,
}

impl Wire {
    /// Drops the bytes of an incomplete packet.
    fn forget(&mut self) {
        self.frames.reset();
        self.until = None;
        self.waiting.clear();
    }
}

/// A simulated node.
#[derive(Debug)]
pub struct HootNode {
    machine: DeviceMachine,
    profile: Profile,
    quirks: Quirks,
    main_loop: MainLoop,
    wake: Option<Millis>,
    now: Millis,
    wires: [Wire; 3],
    motors: Vec<Motor>,
    /// Path that each motor follows, and the time at which it followed it last.
    leads: [Option<Lead>; 3],
    led_at: [Millis; 3],
    /// Direction in which each motor runs: 1 or -1.
    ways: [f64; 3],
    /// Position of each motor that the machine was told last.
    told: [i32; 3],
    microsteps: [Microstep; 3],
    camera: Camera,
    out_is_on: bool,
    pulses: u64,
    outgoing: VecDeque<Outgoing>,
}

impl HootNode {
    /// A node that is switched on at time 0.
    #[must_use]
    pub fn new(setup: Setup) -> Self {
        let wire = || Wire { is_open: false, frames: stream::Frames::new(), until: None, waiting: Vec::new() };
        let motor = Motor::new(setup.limits).within(setup.travel);
        let is_firmware = setup.options.quirks().contains(Quirks::FIRMWARE_SETTINGS);
        let mut node = Self {
            machine: DeviceMachine::new(setup.options),
            profile: setup.options.profile(),
            quirks: setup.options.quirks(),
            main_loop: MainLoop::Free,
            wake: None,
            now: Millis(0),
            wires: [wire(), wire(), wire()],
            motors: vec![motor; setup.motors.min(3).into()],
            leads: [None; 3],
            led_at: [Millis(0); 3],
            ways: [1.0; 3],
            told: [0; 3],
            microsteps: [Microstep::QUARTER; 3],
            camera: Camera::default(),
            out_is_on: false,
            pulses: 0,
            outgoing: VecDeque::new(),
        };
        node.take_first_microsteps();
        if is_firmware {
            node.step(Input::Supply { volts: Volts(Scaled(1199)), amperes: Amperes(Scaled(49)) });
            node.step(Input::Limits(RingTip { ring: Level::HIGH, tip: Level::HIGH }));
        }
        node
    }

    /// Machine of the node, with all its settings.
    #[must_use]
    pub const fn machine(&self) -> &DeviceMachine {
        &self.machine
    }

    /// Camera of the node.
    #[must_use]
    pub const fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Whether the auxiliary output is on.
    #[must_use]
    pub const fn out_is_on(&self) -> bool {
        self.out_is_on
    }

    /// Number of pulses on the common line, which tell other nodes that the next picture comes.
    #[must_use]
    pub const fn pulses(&self) -> u64 {
        self.pulses
    }

    /// Number of bytes that wait: for the rest of their packet, or to be taken by [`poll`](Party::poll).
    #[must_use]
    pub fn held(&self) -> usize {
        self.wires.iter().map(|wire| wire.frames.held()).sum::<usize>() + crate::waiting(&self.outgoing)
    }

    /// Gives an input of a person at the node: a button is pressed, or a contact is closed.
    pub fn touch(&mut self, now: Millis, input: Input<'_>) {
        self.advance(now);
        self.step(input);
    }

    /// Gives an input to the machine, and carries out its effects.
    fn step(&mut self, input: Input<'_>) {
        if self.is_hung() {
            return;
        }
        let output = self.machine.advance(self.now, input);
        self.wake = output.wake;
        for effect in output {
            match effect {
                Effect::Event(event) => self.event(&event),
                Effect::Transmit(transmit) => {
                    if let (Contents::Answer(Answer::Error), Input::Received { message, .. }) =
                        (transmit.contents, input)
                    {
                        let in_joystick_mode = self.machine.controller().joystick_mode;
                        info!("refused{}: {message}", if in_joystick_mode { ", in joystick mode" } else { "" });
                    }
                    self.transmit(&transmit);
                }
            }
        }
    }

    fn event(&mut self, event: &Event<'_>) {
        match *event {
            Event::Motor { motor, motion } => self.set_in_motion(motor, motion),
            Event::Camera { focus, shutter } => self.camera.lines(self.now, focus, shutter),
            Event::AltOut { on } => {
                info!("auxiliary output {}", if on { "on" } else { "off" });
                self.out_is_on = on;
            }
            Event::CommonLine => self.pulses += 1,
            Event::DebugLed => info!("the lamp for debugging is switched"),
            Event::Program(state) => info!("program: {state:?}"),
            Event::Set(part) => debug!("set: {part:?}"),
            Event::Address(Address(address)) => {
                info!("the address is {address} from now on, and on the USB port after the next power-up");
            }
            Event::Ignored { message, why, .. } => debug!("not answered ({why:?}): {message}"),
            _ => {}
        }
    }

    fn transmit(&mut self, transmit: &Transmit<'_>) {
        let port = transmit.port;
        match transmit.contents {
            Contents::Answer(answer) => {
                if let Ok(message) = answer.message(&mut [0; MAX_DATA]) {
                    debug!("{port:?} < {message}");
                }
            }
            Contents::Forward { to: Address(to), .. } => debug!("{port:?} < a packet for {to}, forwarded"),
            _ => {}
        }
        let mut bytes = [0; MAX_FRAME];
        if let Ok(len) = transmit.encode_into(&mut bytes) {
            self.put(port, &bytes[..len]);
        }
    }

    /// Sends a packet, if the port is open.
    fn put(&mut self, port: Port, bytes: &[u8]) {
        let line = line(port);
        if self.wires[line].is_open {
            self.outgoing.push_back(Outgoing::Bytes(LINES[line], bytes.to_vec()));
        }
    }

    /// Does everything that is due at a time.
    fn tick(&mut self, now: Millis) {
        self.now = self.now.max(now);
        self.move_motors();
        if self.blocked_until().is_some_and(|until| until <= self.now) {
            self.unblock();
        }
        if self.is_free() && self.wake.is_some_and(|wake| wake <= self.now) {
            self.step(Input::Wake);
        }
        self.drop_cut_off();
    }

    /// Drops the beginnings of packets whose rest does not come.
    fn drop_cut_off(&mut self) {
        for (line, port) in PORTS.into_iter().enumerate() {
            if self.wires[line].until.is_some_and(|until| self.now >= until) {
                warn!("{port:?}: the rest of a packet did not come");
                self.wires[line].forget();
                self.step(Input::Noise);
            }
        }
    }
}

/// Lines, in order.
const LINES: [LineId; 3] = [LineId(0), LineId(1), LineId(2)];

/// Number of the line of a port.
const fn line(port: Port) -> usize {
    match port {
        Port::Usb => 0,
        Port::Bluetooth => 1,
        Port::Bus => 2,
    }
}

impl Party for HootNode {
    fn open(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        let Some(wire) = self.wires.get_mut(usize::from(line.0)) else { return };
        wire.is_open = true;
        wire.forget();
        let port = PORTS[usize::from(line.0)];
        info!("{port:?}: a master is connected");
        self.step(Input::LinkUp(port));
    }

    fn close(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        let Some(wire) = self.wires.get_mut(usize::from(line.0)).filter(|wire| wire.is_open) else { return };
        wire.is_open = false;
        wire.forget();
        self.outgoing.retain(|out| !matches!(out, Outgoing::Bytes(of, _) if *of == line));
        let port = PORTS[usize::from(line.0)];
        info!("{port:?}: the master is gone");
        self.step(Input::LinkDown(port));
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        self.advance(now);
        let number = usize::from(line.0);
        let Some(wire) = self.wires.get_mut(number).filter(|wire| wire.is_open) else { return };
        if !matches!(self.main_loop, MainLoop::Free) {
            return self.pile_up(number, bytes);
        }
        wire.until = Some(now.after(GAP));
        for (at, byte) in bytes.iter().enumerate() {
            if !self.is_free() {
                return self.pile_up(number, &bytes[at..]);
            }
            let _ = self.wires[number].frames.push(&[*byte]);
            while let Some(item) = self.wires[number].frames.next() {
                let Item::Frame(frame) = item else {
                    warn!("{:?}: {} bytes that are no packet", PORTS[number], item.bytes().len());
                    let is_too_long = matches!(item, Item::Noise { why: Noise::TooLong { .. }, .. });
                    self.step(Input::Noise);
                    if is_too_long && self.copies_main_loop() {
                        self.hang("a packet was too long");
                    }
                    continue;
                };
                let packet = frame.bytes().to_vec();
                self.wires[number].forget();
                self.read(PORTS[number], packet);
                // A mild node drops bytes that came together with a packet.
                if !self.copies_main_loop() {
                    return;
                }
            }
        }
    }

    fn advance(&mut self, now: Millis) {
        while let Some(due) = self.wake().filter(|due| *due <= now) {
            self.tick(due);
        }
        self.now = self.now.max(now);
    }

    fn wake(&self) -> Option<Millis> {
        let cut_off = self.wires.iter().filter_map(|wire| wire.until);
        let tick = self.is_moving().then(|| self.now.after(TICK));
        let due = self.wake.filter(|_| self.is_free());
        cut_off.chain(due).chain(self.blocked_until()).chain(tick).min()
    }

    fn poll(&mut self) -> Option<Outgoing> {
        self.outgoing.pop_front()
    }
}

impl Rig for HootNode {
    const LINES: u8 = 3;

    fn motors(&self) -> &[Motor] {
        &self.motors
    }

    #[expect(clippy::cast_precision_loss, reason = "exact for 285,000 years")]
    fn moment(&self) -> Option<f64> {
        let program = self.machine.program();
        let controller = self.machine.controller();
        let delay = controller.start_delay;
        let delay = delay.milliseconds(self.profile).unwrap_or(delay.0.into());
        (program.state() == ProgramState::Running).then(|| match controller.program_mode {
            ProgramMode::VIDEO | ProgramMode::CONTINUOUS => program.run_time(self.now).saturating_sub(delay) as f64,
            _ => program.shots().into(),
        })
    }

    fn reset(&mut self, now: Millis) {
        self.advance(now);
        warn!("the power is interrupted for a moment");
        self.main_loop = MainLoop::Free;
        self.leads = [None; 3];
        for motor in &mut self.motors {
            motor.halt(now);
        }
        for (wire, port) in self.wires.iter_mut().zip(PORTS) {
            if std::mem::take(&mut wire.is_open) {
                debug!("{port:?}: closed");
            }
            wire.forget();
        }
        self.camera.lines(self.now, false, false);
        self.out_is_on = false;
        self.step(Input::Command(Command::PowerUp));
        self.outgoing.clear();
    }

    fn stall(&mut self, now: Millis) {
        self.advance(now);
        self.get_stuck();
    }
}
