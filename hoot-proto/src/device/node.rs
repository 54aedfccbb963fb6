//! The node as a whole: what is due, what arrived, and what waits.

use motion_core::machine::Machine;
use motion_core::time::Millis;

use super::{
    CameraUnit, Command, Contact, Controller, Event, Ignored, Input, MotorUnit, Options, Output, Port, Program,
    StoredName,
};
use crate::frame::Address;
use crate::message::{AltMode, Amperes, Direction, Level, Motor, RingTip, Volts};
use crate::state::{debug, set_back};

/// A node. [`Options`] say what it is; [`Machine::step`] takes what happened.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct DeviceMachine {
    pub(super) options: Options,
    pub(super) controller: Controller,
    pub(super) motors: [MotorUnit; 3],
    pub(super) camera: CameraUnit,
    pub(super) program: Program,
    pub(super) name: StoredName,
    /// On the bus and by Bluetooth.
    pub(super) address: Address,
    /// By USB, where a new address counts from the next power-up on.
    pub(super) usb_address: Address,
    /// Until when a command keeps the motors moving; none if that is over.
    pub(super) heard_until: Option<Millis>,
    pub(super) deaf_until: Option<Millis>,
    /// Whether nobody has asked for it yet.
    pub(super) power_cycled: bool,
    pub(super) limits: RingTip<Level>,
    pub(super) supply: (Volts, Amperes),
}

debug! { DeviceMachine { options controller motors camera program name address usb_address heard_until deaf_until power_cycled limits supply } }

impl DeviceMachine {
    /// A node that has just been switched on.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self {
            options,
            controller: Controller::default(),
            motors: Motor::ALL.map(MotorUnit::new),
            camera: CameraUnit::default(),
            program: Program::default(),
            name: options.name,
            address: options.address,
            usb_address: options.address,
            heard_until: None,
            deaf_until: None,
            power_cycled: true,
            limits: RingTip::default(),
            supply: <(Volts, Amperes)>::default(),
        }
    }

    /// The same node, on a clock that was set back by so many milliseconds: for clocks that do not last, and to compare
    /// what differs by its age alone. What was due before the clock begins is due when it begins.
    #[must_use]
    pub fn set_back(mut self, by: u64) -> Self {
        self.program.set_back(by);
        self.camera.set_back(by);
        for moment in [&mut self.heard_until, &mut self.deaf_until] {
            *moment = moment.map(|moment| set_back(moment, by));
        }
        self
    }

    /// Its address at a port.
    #[must_use]
    pub const fn address(&self, port: Port) -> Address {
        match port {
            Port::Usb => self.usb_address,
            Port::Bus | Port::Bluetooth => self.address,
        }
    }

    /// What it is called.
    #[must_use]
    pub const fn name(&self) -> StoredName {
        self.name
    }

    /// What the controller is set to.
    #[must_use]
    pub const fn controller(&self) -> &Controller {
        &self.controller
    }

    /// One of its motors.
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

    /// Its camera.
    #[must_use]
    pub const fn camera(&self) -> &CameraUnit {
        &self.camera
    }

    /// Its planned move.
    #[must_use]
    pub const fn program(&self) -> &Program {
        &self.program
    }

    /// Whether a contact of the auxiliary connector is for this.
    pub(super) fn has_contact(&self, mode: AltMode) -> bool {
        let RingTip { ring, tip } = self.controller.alt_modes;
        ring == mode || tip == mode
    }

    /// Stops the motors when the master has been silent for too long, and pauses the program, which would move them
    /// again (safety decision 6; decision H-4).
    fn watch_master(&mut self, now: Millis, output: &mut Output) {
        if self.heard_until.is_some_and(|until| now >= until) {
            self.heard_until = None;
        }
        let silent = self.controller.manual_move && self.heard_until.is_none();
        if silent && self.motors.iter().any(MotorUnit::is_moving) {
            self.pause(now, output);
        }
    }

    fn command(&mut self, now: Millis, output: &mut Output, command: Command) {
        match command {
            Command::Start => self.start(now, output),
            Command::Pause | Command::EmergencyStop => self.pause(now, output),
            Command::Stop => self.stop(output),
            Command::PowerUp => {
                self.stop(output);
                self.usb_address = self.address;
                (self.power_cycled, self.deaf_until, self.heard_until) = (true, None, None);
                self.controller.joystick_mode = false;
                self.controller.manual_move = false;
            }
        }
    }

    /// An edge at the auxiliary connector. Source: hoot, section 2.1, command 13.
    fn alt(&mut self, now: Millis, output: &mut Output, contact: Contact) {
        let RingTip { ring, tip } = self.controller.alt_modes;
        match if contact == Contact::Ring { ring } else { tip } {
            AltMode::TOGGLE if self.program.is_going() => self.stop(output),
            AltMode::START | AltMode::TOGGLE => self.start(now, output),
            AltMode::STOP => self.stop(output),
            AltMode::EXTERNAL_INTERVALOMETER => self.pulse(now, output),
            AltMode::REVERSE_DIRECTION => {
                self.stop_motors(output);
                for motor in &mut self.motors {
                    let forward = motor.settings.direction.0 == 0;
                    motor.settings.direction = Direction(forward.into());
                }
            }
            // A program would set them in motion again (decision H-6).
            AltMode::STOP_MOTORS => self.pause(now, output),
            AltMode::SET_HOME => self.motors.iter_mut().for_each(|motor| motor.set_home(output)),
            AltMode::SET_END => self.motors.iter_mut().for_each(|motor| motor.settings.end_limit = motor.position),
            _ => {}
        }
    }

    fn wakes(&self, output: &mut Output) {
        self.program_wakes(output);
        let moves = self.motors.iter().any(MotorUnit::is_moving);
        let silence = self.heard_until.filter(|_| moves && self.controller.manual_move);
        for moment in silence.into_iter().chain(self.deaf_until) {
            output.wake_by(moment);
        }
    }
}

impl Machine for DeviceMachine {
    type Input<'a> = Input<'a>;
    type Output = Output;

    fn step(mut self, now: Millis, input: Input<'_>) -> (Self, Output) {
        let mut output = Output::default();
        let out = &mut output;
        // What stops comes before all else, and again behind it: nothing that starts now may outlive its time.
        self.watch_master(now, out);
        self.limit_run_time(now, out);
        if self.deaf_until.is_some_and(|until| now >= until) {
            self.deaf_until = None;
        }
        match input {
            Input::Received { port, to, message } => self.received(now, out, port, to, &message),
            Input::Noise => out.event(Event::Ignored(Ignored::Noise)),
            Input::Command(command) => self.command(now, out, command),
            Input::Position { motor, position } => self.motor_mut(motor).moved(out, position),
            Input::Arrived(motor) => self.motor_mut(motor).rest(out),
            Input::Fault(motor) => {
                self.motor_mut(motor).stop(out);
                if self.program.is_going() {
                    self.pause(now, out);
                }
            }
            Input::Alt(contact) => self.alt(now, out, contact),
            Input::CommonLine => self.pulse(now, out),
            Input::Limits(levels) => self.limits = levels,
            Input::Supply { volts, amperes } => self.supply = (volts, amperes),
            Input::LinkUp(_) | Input::LinkDown(_) | Input::Wake => {}
        }
        self.advance(now, out);
        self.watch_master(now, out);
        self.limit_run_time(now, out);
        self.wakes(out);
        (self, output)
    }
}
