//! One motor: what it is set to, and what it does. The table of hoot, section 4.3.

use super::{Event, Motion, Output};
use crate::message::{
    Backlash, Direction, Easing, Microstep, Motor, Span, StepRate, Steps, StepsPerSecond, StepsPerSecondSquared,
};
use crate::program::Plan;
use crate::state::{debug, states};

states! {
    /// What a motor does. Source: hoot, section 4.3.
    pub enum MotorState {
        /// It does nothing, whatever it is told, and says OK.
        #[default]
        Disabled,
        /// It rests.
        Idle,
        /// It goes to a place.
        Moving,
        /// It runs until told otherwise.
        Continuous,
    }
}

/// What a master sets of a motor, and can ask for. Source: hoot, section 2.3.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct MotorSettings {
    /// Whether it has no current while it rests.
    pub sleep: bool,
    /// Steps that the rig adds when it turns the other way.
    pub backlash: Backlash,
    /// Into how many microsteps a step is divided.
    pub microstep: Microstep,
    /// Its greatest speed.
    pub max_step_speed: StepRate,
    /// Which way is forward.
    pub direction: Direction,
    /// Where its way ends; 0 for nowhere.
    pub end_limit: Steps,
    /// The speed of runs. A move by a number of steps needs one other than 0 too (safety decision 8).
    pub speed: StepsPerSecond,
    /// How quickly runs gain and lose speed.
    pub acceleration: StepsPerSecondSquared,
    /// How long it waits before its planned move: shots, or milliseconds in video mode.
    pub lead_in: Span,
    /// Its planned move.
    pub plan: Plan,
}

debug! { MotorSettings { sleep backlash microstep max_step_speed direction end_limit speed acceleration lead_in plan } }

impl Default for MotorSettings {
    /// Of a new node. The speed is 0, so that nothing moves before a master has said how fast (safety decision 8).
    fn default() -> Self {
        Self {
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

/// One motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct MotorUnit {
    pub(super) motor: Motor,
    pub(super) settings: MotorSettings,
    pub(super) state: MotorState,
    pub(super) position: Steps,
    /// How far the planned move is: shots, or in video mode 1 from the moment at which it was started.
    pub(super) done: u32,
}

impl MotorUnit {
    pub(super) fn new(motor: Motor) -> Self {
        let settings = MotorSettings::default();
        Self { motor, settings, state: MotorState::default(), position: Steps(0), done: 0 }
    }

    /// What it is set to.
    #[must_use]
    pub const fn settings(&self) -> &MotorSettings {
        &self.settings
    }

    /// What it does.
    #[must_use]
    pub const fn state(&self) -> MotorState {
        self.state
    }

    /// Where it was, when the rig said so last.
    #[must_use]
    pub const fn position(&self) -> Steps {
        self.position
    }

    /// Whether it moves, in any way.
    #[must_use]
    pub const fn is_moving(&self) -> bool {
        matches!(self.state, MotorState::Moving | MotorState::Continuous)
    }

    /// Whether it has a planned move that it can make.
    pub(super) fn has_plan(&self) -> bool {
        self.state != MotorState::Disabled && !self.settings.plan.is_empty()
    }

    /// Whether a move by steps or to a place does anything (safety decision 8).
    fn can_go(&self) -> bool {
        self.state != MotorState::Disabled && self.settings.speed.0 != 0.0
    }

    fn tell(&self, output: &mut Output, motion: Motion) {
        output.event(Event::Motor { motor: self.motor, motion });
    }

    /// Has the rig move, and wakes the driver first, if it sleeps.
    fn set_off(&mut self, output: &mut Output, state: MotorState, motion: Motion) {
        if self.settings.sleep && !self.is_moving() {
            self.tell(output, Motion::Power(true));
        }
        self.state = state;
        self.tell(output, motion);
    }

    /// A move that a master asked for, or nothing, if the motor cannot.
    pub(super) fn go(&mut self, output: &mut Output, motion: Motion) {
        if self.can_go() {
            self.set_off(output, MotorState::Moving, motion);
        }
    }

    /// A step of the planned move, whose speed is the rig's affair.
    pub(super) fn follow(&mut self, output: &mut Output, motion: Motion) {
        if self.state != MotorState::Disabled {
            self.set_off(output, MotorState::Moving, motion);
        }
    }

    /// Runs until told otherwise.
    pub(super) fn run(&mut self, output: &mut Output, direction: Direction) {
        if self.state != MotorState::Disabled {
            let speed = self.settings.speed;
            self.set_off(output, MotorState::Continuous, Motion::Run { direction, speed });
        }
    }

    /// The speed of runs. It is ignored beyond the greatest rate, and if it is no number.
    pub(super) fn set_speed(&mut self, output: &mut Output, speed: StepsPerSecond, max: StepRate) {
        if speed.0.abs() <= f32::from(max.0) {
            self.settings.speed = speed;
            if self.state == MotorState::Continuous {
                self.tell(output, Motion::Speed(speed));
            }
        }
    }

    /// Stops, if it moves. It comes to rest at once; the rig may take its time over the way.
    pub(super) fn stop(&mut self, output: &mut Output) {
        if self.is_moving() {
            self.tell(output, Motion::Stop);
            self.rest(output);
        }
    }

    /// The rig says that it rests.
    pub(super) fn rest(&mut self, output: &mut Output) {
        if self.is_moving() {
            self.state = MotorState::Idle;
            if self.settings.sleep {
                self.tell(output, Motion::Power(false));
            }
        }
    }

    /// Where it is. At its end limit it stops, if it has gone on.
    pub(super) fn moved(&mut self, output: &mut Output, position: Steps) {
        let (before, end) = (self.position.0, self.settings.end_limit.0);
        self.position = position;
        let beyond = match end {
            0 => false,
            1.. => position.0 >= end && position.0 > before,
            _ => position.0 <= end && position.0 < before,
        };
        if beyond {
            self.stop(output);
        }
    }

    pub(super) fn set_sleep(&mut self, output: &mut Output, sleep: bool) {
        let was = core::mem::replace(&mut self.settings.sleep, sleep);
        if was != sleep && !self.is_moving() {
            self.tell(output, Motion::Power(!sleep));
        }
    }

    pub(super) fn set_enable(&mut self, output: &mut Output, enable: bool) {
        if !enable {
            self.stop(output);
            self.state = MotorState::Disabled;
        } else if self.state == MotorState::Disabled {
            self.state = MotorState::Idle;
        }
    }

    /// Another division of a step: everything that is stored in steps is scaled. A move under way counts in the old
    /// ones, so it is stopped first (decision H-13).
    pub(super) fn set_microstep(&mut self, output: &mut Output, microstep: Microstep) {
        let old = self.settings.microstep;
        if microstep.name().is_none() || microstep == old {
            return;
        }
        self.stop(output);
        let scale = |steps: i32| {
            let scaled = i64::from(steps).saturating_mul(microstep.0.into()).checked_div(old.0.into()).unwrap_or(0);
            i32::try_from(scaled).unwrap_or(if scaled < 0 { i32::MIN } else { i32::MAX })
        };
        for place in self.places() {
            place.0 = scale(place.0);
        }
        self.position.0 = scale(self.position.0);
        self.settings.backlash.0 = u16::try_from(scale(self.settings.backlash.0.into())).unwrap_or(u16::MAX);
        self.settings.microstep = microstep;
        self.tell(output, Motion::Microstep(microstep));
    }

    /// Here is 0, and all that is stored keeps its place on the rig.
    pub(super) fn set_home(&mut self, output: &mut Output) {
        let by = self.position;
        for place in self.places() {
            place.0 = place.0.saturating_sub(by.0);
        }
        self.rebase(output);
    }

    /// Here is 0, without limits, and with a planned move from here to here.
    pub(super) fn reset_limits(&mut self, output: &mut Output) {
        for place in self.places() {
            place.0 = 0;
        }
        self.rebase(output);
    }

    fn rebase(&mut self, output: &mut Output) {
        let by = core::mem::take(&mut self.position);
        self.tell(output, Motion::Rebase { by });
    }

    /// What is stored in steps; 0 for no limit must stay 0, so a limit of 0 is not among it.
    fn places(&mut self) -> impl Iterator<Item = &mut Steps> {
        let end = (self.settings.end_limit.0 != 0).then_some(&mut self.settings.end_limit);
        end.into_iter().chain([&mut self.settings.plan.start, &mut self.settings.plan.stop])
    }

    /// Goes on by one step of the planned move, or back; `false` if there is none.
    pub(super) fn single_step(&mut self, output: &mut Output, forward: bool) -> bool {
        let has_plan = self.has_plan();
        if has_plan {
            let travel = self.settings.plan.travel.0;
            self.done = if forward { self.done.saturating_add(1).min(travel) } else { self.done.saturating_sub(1) };
            self.follow(output, Motion::To(self.settings.plan.at(self.done)));
        }
        has_plan
    }
}
