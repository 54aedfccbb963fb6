//! One motor: its settings and its state. The table of hoot, section 4.3.

use motion_core::states;
use motion_core::wire::Bool;

use super::{Effects, Event, Motion};
use crate::message::{
    Backlash, Direction, Easing, Microstep, Motor, Span, StepRate, Steps, StepsPerSecond, StepsPerSecondSquared,
};
use crate::program::Plan;

states! {
    /// State of a motor. Source: hoot, section 4.3.
    #[derive(Default)]
    pub enum MotorState {
        /// The motor is not enabled: commands are acknowledged, and nothing moves.
        #[default]
        Disabled,
        /// The motor rests.
        Idle,
        /// The motor moves to a position.
        Moving,
        /// The motor runs until the next command.
        Continuous,
    }
}

/// Settings of a motor, which a master can write and ask for. Source: hoot, section 2.3.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct MotorSettings {
    /// Whether the motor is enabled, as it was set.
    pub enable: Bool,
    /// Whether the motor has no current while it rests.
    pub sleep: bool,
    /// Steps that the rig adds when the motor reverses.
    pub backlash: Backlash,
    /// Number of microsteps in a step.
    pub microstep: Microstep,
    /// Greatest speed of the motor.
    pub max_step_speed: StepRate,
    /// Direction that is forward.
    pub direction: Direction,
    /// Position of the end limit; 0 for no limit.
    pub end_limit: Steps,
    /// Speed of runs. A move by a number of steps needs a speed other than 0 too (safety decision 8).
    pub speed: StepsPerSecond,
    /// Acceleration of runs.
    pub acceleration: StepsPerSecondSquared,
    /// Wait before the planned move of the motor: shots, or milliseconds in video mode.
    pub lead_in: Span,
    /// Planned move of the motor.
    pub plan: Plan,
}

motion_core::debug! { MotorSettings { enable sleep backlash microstep max_step_speed direction end_limit speed acceleration lead_in plan } }

impl Default for MotorSettings {
    /// Settings of a new node. The speed is 0, so that nothing moves before a master has set a speed (safety decision 8).
    fn default() -> Self {
        Self {
            enable: Bool::FALSE,
            sleep: true,
            backlash: Backlash(0),
            microstep: Microstep::QUARTER,
            max_step_speed: StepRate(5000),
            direction: Direction(0),
            end_limit: Steps(0),
            speed: StepsPerSecond(0.0),
            acceleration: StepsPerSecondSquared(0.0),
            lead_in: Span(0),
            plan: Plan { easing: Easing::LINEAR, ..Plan::default() },
        }
    }
}

/// Limits that stop a motor.
#[derive(Clone, Copy)]
pub(super) enum Limits {
    /// The end limit, unless it is 0.
    End,
    /// The end limit and the home, unless the end limit is 0.
    EndAndHome,
    /// No limit.
    None,
}

/// One motor of a node.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct MotorUnit {
    pub(super) motor: Motor,
    pub(super) settings: MotorSettings,
    pub(super) state: MotorState,
    pub(super) position: Steps,
    /// Whether the last motion went upwards; `None` if the node takes up no backlash.
    pub(super) went_up: Option<bool>,
    /// Microsteps that are set again when the motor rests.
    pub(super) restores: Option<Microstep>,
    /// Whether a pause has stopped the planned move for good, as some firmware does.
    pub(super) is_stuck: bool,
    /// Run time at which the planned move began in a time lapse without stops.
    pub(super) began: Option<u64>,
    /// Progress of the planned move: shots, or 1 from its start on if it goes by the clock.
    pub(super) done: u32,
}

motion_core::debug! { MotorUnit { motor settings state position went_up restores is_stuck began done } }

impl MotorUnit {
    pub(super) fn new(motor: Motor) -> Self {
        let settings = MotorSettings::default();
        Self {
            motor,
            settings,
            state: MotorState::default(),
            position: Steps(0),
            went_up: None,
            restores: None,
            is_stuck: false,
            began: None,
            done: 0,
        }
    }

    /// Settings of the motor.
    #[must_use]
    pub const fn settings(&self) -> &MotorSettings {
        &self.settings
    }

    /// State of the motor.
    #[must_use]
    pub const fn state(&self) -> MotorState {
        self.state
    }

    /// Position of the motor, as the rig reported it last.
    #[must_use]
    pub const fn position(&self) -> Steps {
        self.position
    }

    /// Whether the motor moves.
    #[must_use]
    pub const fn is_moving(&self) -> bool {
        matches!(self.state, MotorState::Moving | MotorState::Continuous)
    }

    /// Whether the motor has a planned move that it can make.
    pub(super) fn has_plan(&self) -> bool {
        self.state != MotorState::Disabled && !self.settings.plan.is_empty()
    }

    /// Whether the motor is enabled, and its planned move has no travel to a stop that is elsewhere.
    pub(super) fn lacks_travel(&self) -> bool {
        let plan = self.settings.plan;
        self.state != MotorState::Disabled && plan.travel.0 == 0 && plan.stop != self.position
    }

    /// Whether a move by steps or to a position does anything (safety decision 8).
    fn can_go(&self) -> bool {
        self.state != MotorState::Disabled && self.settings.speed.0 != 0.0
    }

    fn tell(&self, output: &mut Effects, motion: Motion) {
        output.event(Event::Motor { motor: self.motor, motion });
    }

    /// Tells the rig to move the motor, after waking its driver if that sleeps.
    fn set_off(&mut self, output: &mut Effects, state: MotorState, motion: Motion) {
        if self.settings.sleep && !self.is_moving() {
            self.tell(output, Motion::Power(true));
        }
        self.state = state;
        let motion = self.take_up(output, motion);
        self.tell(output, motion);
    }

    /// Adds the backlash to a motion that does not go on in the direction of the last one: the position goes back by it.
    fn take_up(&mut self, output: &mut Effects, mut motion: Motion) -> Motion {
        let (backlash, here) = (self.settings.backlash.0, self.position);
        let up = match &motion {
            Motion::By { direction, .. } | Motion::Run { direction, .. } => direction.0 != 0,
            Motion::To(to) if *to != here => *to > here,
            Motion::Along { plan, .. } if plan.stop != here => plan.stop > here,
            _ => return motion,
        };
        let turns = self.went_up.as_mut().is_some_and(|went_up| core::mem::replace(went_up, up) != up);
        if !turns || backlash == 0 {
            return motion;
        }
        let by = Steps(if up { i32::from(backlash) } else { 0_i32.saturating_sub(backlash.into()) });
        self.rebase(output, by);
        match &mut motion {
            Motion::By { steps, .. } => steps.0 = steps.0.saturating_add(backlash.into()),
            Motion::Along { plan, .. } => plan.start.0 = plan.start.0.saturating_sub(by.0),
            _ => {}
        }
        motion
    }

    /// Makes a move that a master asked for, if the motor can.
    pub(super) fn go(&mut self, output: &mut Effects, motion: Motion) {
        if self.can_go() {
            self.set_off(output, MotorState::Moving, motion);
        }
    }

    /// Makes a step of the planned move, at a speed that the rig chooses.
    pub(super) fn follow(&mut self, output: &mut Effects, motion: Motion) {
        if self.state != MotorState::Disabled {
            self.set_off(output, MotorState::Moving, motion);
        }
    }

    /// Runs until the next command.
    pub(super) fn run(&mut self, output: &mut Effects, direction: Direction) {
        if self.state != MotorState::Disabled {
            let speed = self.settings.speed;
            self.set_off(output, MotorState::Continuous, Motion::Run { direction, speed });
        }
    }

    /// Sets the speed of runs.
    pub(super) fn set_speed(&mut self, output: &mut Effects, speed: StepsPerSecond) {
        self.settings.speed = speed;
        if self.state == MotorState::Continuous {
            self.tell(output, Motion::Speed(speed));
        }
    }

    /// Stops the motor, if it moves. Its state is at rest at once; the rig may need time to slow down.
    pub(super) fn stop(&mut self, output: &mut Effects) {
        if self.is_moving() {
            self.tell(output, Motion::Stop);
            self.rest(output);
        }
    }

    /// The motor rests, as the rig says.
    pub(super) fn rest(&mut self, output: &mut Effects) {
        if self.is_moving() {
            self.state = MotorState::Idle;
            if self.settings.sleep {
                self.tell(output, Motion::Power(false));
            }
            if let Some(microstep) = self.restores.take() {
                self.set_microstep(output, microstep);
            }
        }
    }

    /// The motor has a new position. It stops if it has moved on at or beyond a limit.
    pub(super) fn moved(&mut self, output: &mut Effects, position: Steps, limits: Limits) {
        let (before, end) = (self.position.0, self.settings.end_limit.0);
        self.position = position;
        let (low, high) = match limits {
            Limits::None => (None, None),
            _ if end == 0 => (None, None),
            Limits::End if end > 0 => (None, Some(end)),
            Limits::End => (Some(end), None),
            Limits::EndAndHome => (Some(end.min(0)), Some(end.max(0))),
        };
        let above = high.is_some_and(|high| position.0 >= high && position.0 > before);
        if above || low.is_some_and(|low| position.0 <= low && position.0 < before) {
            self.stop(output);
        }
    }

    pub(super) fn set_sleep(&mut self, output: &mut Effects, sleep: bool) {
        let was = core::mem::replace(&mut self.settings.sleep, sleep);
        if was != sleep && !self.is_moving() {
            self.tell(output, Motion::Power(!sleep));
        }
    }

    pub(super) fn set_enable(&mut self, output: &mut Effects, enable: Bool) {
        self.settings.enable = enable;
        if !enable.get() {
            self.stop(output);
            self.state = MotorState::Disabled;
        } else if self.state == MotorState::Disabled {
            self.state = MotorState::Idle;
        }
    }

    /// Sets the number of microsteps in a step, and scales everything that is stored in steps. A move under way is stopped
    /// first, because it counts in the old steps (decision H-13).
    pub(super) fn set_microstep(&mut self, output: &mut Effects, microstep: Microstep) {
        let old = self.settings.microstep;
        if microstep.name().is_none() || microstep == old {
            return;
        }
        self.stop(output);
        let scale = |steps: i32| {
            let scaled = u64::from(steps.unsigned_abs()).wrapping_mul(microstep.0.into()).checked_div(old.0.into());
            let scaled = u32::try_from(scaled.unwrap_or(0)).unwrap_or(u32::MAX);
            if steps < 0 { 0_i32.saturating_sub_unsigned(scaled) } else { 0_i32.saturating_add_unsigned(scaled) }
        };
        for place in self.places() {
            place.0 = scale(place.0);
        }
        self.position.0 = scale(self.position.0);
        self.settings.backlash.0 = u16::try_from(scale(self.settings.backlash.0.into())).unwrap_or(u16::MAX);
        self.settings.microstep = microstep;
        self.tell(output, Motion::Microstep(microstep));
    }

    /// Counts the planned move and the present position in whole steps; what is left over is forgotten.
    pub(super) fn cut_places(&mut self, output: &mut Effects) {
        let microsteps = i32::from(self.settings.microstep.0);
        let rest = |place: Steps| Steps(place.0.checked_rem(microsteps).unwrap_or(0));
        for place in [&mut self.settings.plan.start, &mut self.settings.plan.stop] {
            place.0 = place.0.saturating_sub(rest(*place).0);
        }
        let by = rest(self.position);
        if by.0 != 0 {
            self.rebase(output, by);
        }
    }

    /// Makes the present position 0; stored positions keep their place on the rig.
    pub(super) fn set_home(&mut self, output: &mut Effects) {
        let by = self.position;
        for place in self.places() {
            place.0 = place.0.saturating_sub(by.0);
        }
        self.rebase(output, by);
    }

    /// Makes the present position 0, without limits, and with a planned move that begins and ends here.
    pub(super) fn reset_limits(&mut self, output: &mut Effects) {
        for place in self.places() {
            place.0 = 0;
        }
        self.rebase(output, self.position);
    }

    /// Subtracts a number of steps from the present position, which stays where it is.
    fn rebase(&mut self, output: &mut Effects, by: Steps) {
        self.position.0 = self.position.0.saturating_sub(by.0);
        self.tell(output, Motion::Rebase { by });
    }

    /// Positions that are stored. An end limit of 0 means no limit and must stay 0, so it is left out.
    fn places(&mut self) -> impl Iterator<Item = &mut Steps> {
        let MotorSettings { plan, end_limit, .. } = &mut self.settings;
        let has_end = end_limit.0 != 0;
        [&mut plan.start, &mut plan.stop, end_limit].into_iter().take(if has_end { 3 } else { 2 })
    }

    /// Goes on or back by one step of the planned move; `false` if there is none.
    pub(super) fn single_step(&mut self, output: &mut Effects, forward: bool) -> bool {
        let has_plan = self.has_plan();
        if has_plan {
            let travel = self.settings.plan.travel.0;
            self.done = if forward { self.done.saturating_add(1).min(travel) } else { self.done.saturating_sub(1) };
            self.follow(output, Motion::To(self.settings.plan.at(self.done)));
        }
        has_plan
    }
}
