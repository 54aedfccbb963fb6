//! The node as a whole: what is due, what arrived, and what waits.

use motion_core::machine;
use motion_core::machine::Effect;
use motion_core::time::Millis;
use motion_core::wire::Messages;

use super::request::{Reaction, Request};
use super::{
    CameraUnit, Command, Contact, Contents, Controller, Effects, Event, Input, MotorUnit, Options, Output, Port,
    Program, Quirks, StoredName, Transmit,
};
use crate::frame::Address;
use crate::message::{AltMode, Amperes, Direction, HostMessage, Level, Motor, MotorContinuousSpeed, RingTip, Volts};
use crate::query::AnyQuery;

/// Something that happened to a node.
pub(super) enum Happened<'a> {
    /// A request arrived on a port, for this receiver.
    Request(Port, Address, Request),
    /// Anything except a packet happened.
    Report(Input<'a>),
}

impl Happened<'_> {
    /// Whether something may move, or the shutter may open, because of what happened.
    pub(super) fn sets_in_motion(&self) -> bool {
        match self {
            Self::Request(.., request) => request.sets_in_motion(),
            Self::Report(Input::Command(Command::Start) | Input::Alt(_) | Input::CommonLine) => true,
            Self::Report(_) => false,
        }
    }
}

/// A node of a bus.
///
/// A simulator needs [`Quirks`], and a node with motors does not. `DeviceMachine<false>`, which
/// [`without_quirks`](DeviceMachine::without_quirks) makes, has none whatever its options are. It is the same node otherwise, and
/// its firmware does not contain the code of the quirks.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct DeviceMachine<const QUIRKS: bool = true> {
    pub(super) options: Options,
    pub(super) controller: Controller,
    pub(super) motors: [MotorUnit; 3],
    pub(super) camera: CameraUnit,
    pub(super) program: Program,
    pub(super) name: StoredName,
    /// Address on the bus and by Bluetooth.
    pub(super) address: Address,
    /// Address by USB, where a new address counts from the next power-up on.
    pub(super) usb_address: Address,
    /// Time until which the last command keeps the motors moving; `None` if it is over.
    pub(super) heard_until: Option<Millis>,
    /// Whether the power was off, and no master has asked for that yet.
    pub(super) power_cycled: bool,
    pub(super) limits: RingTip<Level>,
    pub(super) supply: (Volts, Amperes),
}

machine! { [impl<const QUIRKS: bool>] DeviceMachine<QUIRKS> }

motion_core::debug! { [impl<const QUIRKS: bool>] DeviceMachine<QUIRKS> { options controller motors camera program name address usb_address heard_until power_cycled limits supply } }

impl DeviceMachine {
    /// A node that has just been switched on.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self::switched_on(options)
    }
}

impl DeviceMachine<false> {
    /// A node that has just been switched on, and has no [`Quirks`], whatever its options are.
    #[must_use]
    pub fn without_quirks(options: Options) -> Self {
        Self::switched_on(options)
    }
}

impl<const QUIRKS: bool> DeviceMachine<QUIRKS> {
    fn switched_on(options: Options) -> Self {
        let mut machine = Self {
            options,
            controller: Controller::default(),
            motors: Motor::ALL.map(MotorUnit::new),
            camera: CameraUnit::default(),
            program: Program::default(),
            name: options.name(),
            address: options.address(),
            usb_address: options.address(),
            heard_until: None,
            power_cycled: true,
            limits: RingTip::default(),
            supply: <(Volts, Amperes)>::default(),
        };
        if machine.has_firmware_settings() {
            machine.take_first_settings();
        }
        if machine.has_quirk(Quirks::TAKES_UP_BACKLASH) {
            for motor in &mut machine.motors {
                motor.went_up = Some(false);
            }
        }
        machine
    }

    /// Whether the node copies a habit of firmware.
    pub(super) const fn has_quirk(&self, quirk: Quirks) -> bool {
        QUIRKS && self.options.quirks().contains(quirk)
    }

    /// The same node on a clock that was set back by so many milliseconds, to compare machines that differ only by their age.
    #[doc(hidden)]
    #[must_use]
    pub fn set_back(mut self, by: u64) -> Self {
        let by = Millis(by);
        self.program.set_back(by);
        self.camera.set_back(by);
        self.heard_until = self.heard_until.map(|moment| Millis(moment.since(by)));
        self
    }

    /// Options of the machine.
    #[must_use]
    pub const fn options(&self) -> &Options {
        &self.options
    }

    /// Address of the node at a port.
    #[must_use]
    pub const fn address(&self, port: Port) -> Address {
        match port {
            Port::Usb => self.usb_address,
            Port::Bus | Port::Bluetooth => self.address,
        }
    }

    /// Name of the node.
    #[must_use]
    pub const fn name(&self) -> StoredName {
        self.name
    }

    /// Settings of the controller.
    #[must_use]
    pub const fn controller(&self) -> &Controller {
        &self.controller
    }

    /// One of the motors.
    #[must_use]
    pub const fn motor(&self, motor: Motor) -> &MotorUnit {
        let [one, two, three] = &self.motors;
        match motor {
            Motor::One => one,
            Motor::Two => two,
            Motor::Three => three,
        }
    }

    pub(super) fn motor_mut(&mut self, motor: Motor) -> &mut MotorUnit {
        let [one, two, three] = &mut self.motors;
        match motor {
            Motor::One => one,
            Motor::Two => two,
            Motor::Three => three,
        }
    }

    /// The camera.
    #[must_use]
    pub const fn camera(&self) -> &CameraUnit {
        &self.camera
    }

    /// The planned move.
    #[must_use]
    pub const fn program(&self) -> &Program {
        &self.program
    }

    /// Whether anything may move because of what this device was told: a motor moves, the camera takes a picture, or the planned
    /// move runs or waits for its delay. A motor counts as at rest after its [`Motion::Stop`](super::Motion::Stop), which the
    /// rig carries out at once.
    #[must_use]
    pub fn may_move(&self) -> bool {
        self.program.is_going() || self.camera.is_busy() || self.motors.iter().any(MotorUnit::is_moving)
    }

    /// Whether a contact of the auxiliary connector has this purpose.
    pub(super) fn has_contact(&self, mode: AltMode) -> bool {
        let RingTip { ring, tip } = self.controller.alt_modes;
        ring == mode || tip == mode
    }

    /// Makes a request of a message, and messages of what follows. Inside, a node works without types, as firmware does.
    fn run<'a>(&mut self, now: Millis, output: &mut Output<'a>, input: Input<'a>) {
        let (happened, to, message) = match input {
            Input::Received { port, to, message } => (Happened::Request(port, to, Request::of(&message)), to, message),
            input => (Happened::Report(input), Address::MASTER, HostMessage::other(0, &[])),
        };
        let mut effects = Effects::default();
        self.act_into(now, &mut effects, happened);
        let mut is_second = false;
        output.take_over(&effects, |effect| match *effect {
            Effect::Event(event) => Effect::Event(event),
            Effect::Transmit(Reaction::Ignore(port, to, why)) => {
                Effect::Event(Event::Ignored { port, to, message: message.into(), why })
            }
            Effect::Transmit(Reaction::Forward(port)) => {
                Effect::Transmit(Transmit { port, contents: Contents::Forward { to, message } })
            }
            Effect::Transmit(Reaction::Answer(port, response)) => {
                let query = if core::mem::replace(&mut is_second, true) {
                    // A second value answers this query.
                    let motor = Motor::new(message.selector().sub_address).unwrap_or_default();
                    Some(AnyQuery::MotorContinuousSpeed(MotorContinuousSpeed { motor }))
                } else {
                    // A query has no data, whatever the request has.
                    HostMessage::decode_body(message.number(), &[]).ok().and_then(|message| message.query())
                };
                Effect::Transmit(Transmit { port, contents: Contents::Answer(response.answer(query)) })
            }
        });
    }

    /// Takes something that happened at a moment, and returns all that follows from it.
    pub(super) fn act(&mut self, now: Millis, happened: Happened<'_>) -> Effects {
        let mut effects = Effects::default();
        self.act_into(now, &mut effects, happened);
        effects
    }

    /// Takes something that happened at a moment, and adds all that follows from it to an empty output.
    // `run` calls this one, because the 2 KiB of a returned output are copied, which was a third of an idle wake. Firmware is
    // 436 bytes shorter with a returned one.
    #[expect(clippy::needless_pass_by_value, reason = "a reference makes the code of firmware longer")]
    fn act_into(&mut self, now: Millis, output: &mut Effects, happened: Happened<'_>) {
        // What stops comes first, and once more at the end: nothing that starts now may outlive its time.
        self.watch_master(now, output);
        self.limit_run_time(now, output);
        let reactions = match happened {
            Happened::Request(port, to, request) => self.received(now, output, port, to, &request),
            Happened::Report(input) => {
                self.report(now, output, input);
                [None; 2]
            }
        };
        self.go_on(now, output);
        self.watch_master(now, output);
        self.limit_run_time(now, output);
        // The rig does first what an answer acknowledges.
        for reaction in reactions.into_iter().flatten() {
            output.transmit(reaction);
        }
        // At rest, nothing waits for a time.
        if self.may_move() {
            self.wakes(output);
        }
        output.wake = output.wake.filter(|&wake| wake > now);
    }

    fn report(&mut self, now: Millis, output: &mut Effects, input: Input<'_>) {
        match input {
            Input::Noise => output.event(Event::Noise),
            Input::Command(command) => self.command(now, output, command),
            Input::Position { motor, position } => {
                let limits = self.limits_held();
                self.motor_mut(motor).moved(output, position, limits);
            }
            Input::Arrived(motor) => self.motor_mut(motor).rest(output),
            Input::Fault(motor) => {
                self.motor_mut(motor).stop(output);
                if self.program.is_going() {
                    self.pause(now, output);
                }
            }
            Input::Alt(contact) => self.alt(now, output, contact),
            Input::CommonLine => self.pulse(now, output),
            Input::Limits(levels) => self.limits = levels,
            Input::Supply { volts, amperes } => self.supply = (volts, amperes),
            Input::Received { .. } | Input::LinkUp(_) | Input::LinkDown(_) | Input::Wake => {}
        }
    }

    /// Stops the motors when the master has been silent for too long, and pauses the program, because it would move them
    /// again (safety decision 6; decision H-4).
    fn watch_master(&mut self, now: Millis, output: &mut Effects) {
        if self.heard_until.is_some_and(|until| now >= until) {
            self.heard_until = None;
        }
        let silent = self.controller.manual_move && self.heard_until.is_none();
        if silent && self.motors.iter().any(MotorUnit::is_moving) {
            self.pause(now, output);
        }
    }

    fn command(&mut self, now: Millis, output: &mut Effects, command: Command) {
        match command {
            Command::Start => self.start(now, output),
            Command::Pause | Command::EmergencyStop => self.pause(now, output),
            Command::Stop => self.stop(now, output),
            Command::PowerUp => {
                self.stop(now, output);
                self.usb_address = self.address;
                (self.power_cycled, self.heard_until) = (true, None);
                self.controller.joystick_mode = false;
                self.controller.manual_move = false;
            }
        }
    }

    /// Acts on an edge at the auxiliary connector. Source: hoot, section 2.1, command 13.
    fn alt(&mut self, now: Millis, output: &mut Effects, contact: Contact) {
        let RingTip { ring, tip } = self.controller.alt_modes;
        match if contact == Contact::Ring { ring } else { tip } {
            AltMode::TOGGLE if self.program.is_going() => self.stop(now, output),
            AltMode::START | AltMode::TOGGLE => self.start(now, output),
            AltMode::STOP => self.stop(now, output),
            AltMode::EXTERNAL_INTERVALOMETER => self.pulse(now, output),
            AltMode::REVERSE_DIRECTION => {
                self.stop_motors(output);
                for motor in &mut self.motors {
                    let forward = motor.settings.direction.0 == 0;
                    motor.settings.direction = Direction(forward.into());
                }
            }
            // A program would set the motors in motion again (decision H-6).
            AltMode::STOP_MOTORS => self.pause(now, output),
            AltMode::SET_HOME => self.motors.iter_mut().for_each(|motor| motor.set_home(output)),
            AltMode::SET_END => self.motors.iter_mut().for_each(|motor| motor.settings.end_limit = motor.position),
            _ => {}
        }
    }

    fn wakes(&self, output: &mut Effects) {
        self.program_wakes(output);
        let moves = self.motors.iter().any(MotorUnit::is_moving);
        let silence = self.heard_until.filter(|_| moves && self.controller.manual_move);
        if let Some(moment) = silence {
            output.wake_by(moment);
        }
    }
}
