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

use hoot_proto::device::{Command, DeviceMachine, Event, NotTaken, Port, ProgramState, Quirks, Session};
use hoot_proto::frame::MAX_FRAME;
use hoot_proto::message::{Amperes, Level, Microstep, ProgramMode, RingTip, Scaled, Volts};
use hoot_proto::{Address, DeviceMessage, Frame};
use motion_core::session::{Session as _, Turn};
use motion_core::time::Millis;
use tracing::{debug, info, warn};

pub use camera::{Camera, PHOTOS, Photo};
use lead::Lead;
use main_loop::{MainLoop, Wire};
pub use setup::Setup;

use crate::motor::Motor;
use crate::{LineId, Outgoing, Party, Rig, TICK};

/// Ports, in the order of their lines.
const PORTS: [Port; 3] = [Port::Usb, Port::Bluetooth, Port::Bus];

/// A simulated node.
#[derive(Debug)]
pub struct HootNode {
    session: Session,
    main_loop: MainLoop,
    /// Time until which the session waits.
    until: Option<Millis>,
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
        let motor = Motor::new(setup.limits).within(setup.travel);
        let mut node = Self {
            session: Session::new(DeviceMachine::new(setup.options)),
            main_loop: MainLoop::Free,
            until: None,
            now: Millis(0),
            wires: [Wire::new(), Wire::new(), Wire::new()],
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
        if node.copies(Quirks::FIRMWARE_SETTINGS) {
            node.tell(|session| session.supply(Volts(Scaled(1199)), Amperes(Scaled(49))));
            node.tell(|session| session.limits(RingTip { ring: Level::HIGH, tip: Level::HIGH }));
        }
        node
    }

    /// Machine of the node, with all its settings.
    #[must_use]
    pub const fn machine(&self) -> &DeviceMachine {
        self.session.machine()
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
        self.wires.iter().map(Wire::held).sum::<usize>() + self.session.held() + crate::waiting(&self.outgoing)
    }

    /// Tells the node what a person at it does: the person stops everything, presses a button, or closes a contact.
    pub fn touch(&mut self, now: Millis, report: impl FnOnce(&mut Session) -> Result<(), NotTaken>) {
        self.advance(now);
        self.tell(report);
    }

    /// Whether the node has a habit of firmware.
    const fn copies(&self, quirk: Quirks) -> bool {
        self.machine().options().quirks().contains(quirk)
    }

    /// Tells the session something, and carries out what follows.
    fn tell(&mut self, report: impl FnOnce(&mut Session) -> Result<(), NotTaken>) {
        if self.is_hung() {
            return;
        }
        if let Err(error) = report(&mut self.session) {
            warn!("{error}");
        }
        self.settle();
    }

    /// Carries out what the session wants, until it waits.
    fn settle(&mut self) {
        let mut packet = [0; MAX_FRAME];
        loop {
            match self.session.turn(self.now, &(), &mut packet) {
                Ok(Turn::Transmit(port, len)) => self.transmit(port, &packet[..len]),
                Ok(Turn::Event(held)) => match self.session.event(held) {
                    Event::Ignored { message, why, .. } => debug!("not answered ({why:?}): {message}"),
                    event => self.event(event.to_static()),
                },
                Ok(Turn::Wait(until)) => return self.until = until,
                Err(error) => return warn!("{error}"),
            }
        }
    }

    fn event(&mut self, event: Option<Event<'static>>) {
        match event {
            Some(Event::Motor { motor, motion }) => self.set_in_motion(motor, motion),
            Some(Event::Camera { focus, shutter }) => self.camera.lines(self.now, focus, shutter),
            Some(Event::AltOut { on }) => {
                info!("auxiliary output {}", if on { "on" } else { "off" });
                self.out_is_on = on;
            }
            Some(Event::CommonLine) => self.pulses += 1,
            Some(Event::DebugLed) => info!("the lamp for debugging is switched"),
            Some(Event::Program(state)) => info!("program: {state:?}"),
            Some(Event::Set(part)) => debug!("set: {part:?}"),
            Some(Event::Address(Address(address))) => {
                info!("the address is {address} from now on, and on the USB port after the next power-up");
            }
            _ => {}
        }
    }

    /// Sends a packet, if the port is open.
    fn transmit(&mut self, port: Port, packet: &[u8]) {
        if let Ok(frame) = Frame::decode(packet) {
            let message = DeviceMessage::decode(&frame);
            match message {
                _ if frame.address() != Address::MASTER => {
                    debug!("{port:?} < a packet for {}, forwarded", frame.address().0);
                }
                DeviceMessage::Reply(reply) if !reply.is_ok() => info!("{port:?} < {message}"),
                _ => debug!("{port:?} < {message}"),
            }
        }
        let line = line(port);
        if self.wires[line].is_open {
            self.outgoing.push_back(Outgoing::Bytes(LINES[line], packet.to_vec()));
        }
    }

    /// Does everything that is due at a time.
    fn tick(&mut self, now: Millis) {
        self.now = self.now.max(now);
        self.move_motors();
        if self.blocked_until().is_some_and(|until| until <= self.now) {
            self.unblock();
        }
        if self.is_free() && self.until.is_some_and(|until| until <= self.now) {
            self.settle();
        }
        self.drop_cut_off();
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
        self.tell(|session| session.link_up(port));
    }

    fn close(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        let Some(wire) = self.wires.get_mut(usize::from(line.0)).filter(|wire| wire.is_open) else { return };
        wire.is_open = false;
        wire.forget();
        self.outgoing.retain(|out| !matches!(out, Outgoing::Bytes(of, _) if *of == line));
        let port = PORTS[usize::from(line.0)];
        info!("{port:?}: the master is gone");
        self.tell(|session| session.link_down(port));
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        self.advance(now);
        let number = usize::from(line.0);
        if self.wires.get(number).is_some_and(|wire| wire.is_open) {
            self.listen(number, bytes);
        }
    }

    fn advance(&mut self, now: Millis) {
        while let Some(due) = self.wake().filter(|due| *due <= now) {
            self.tick(due);
        }
        self.now = self.now.max(now);
    }

    fn wake(&self) -> Option<Millis> {
        let cut_off = self.wires.iter().filter_map(Wire::until);
        let tick = self.is_moving().then(|| self.now.after(TICK));
        let due = self.until.filter(|_| self.is_free());
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
        let (program, controller) = (self.machine().program(), self.machine().controller());
        let delay = controller.start_delay;
        let delay = delay.milliseconds(self.machine().options().profile()).unwrap_or(delay.0.into());
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
        self.tell(|session| session.command(Command::PowerUp));
        self.outgoing.clear();
    }

    fn stall(&mut self, now: Millis) {
        self.advance(now);
        self.get_stuck();
    }
}
