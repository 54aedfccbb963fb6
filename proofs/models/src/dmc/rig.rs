//! Rig as simple as possible: the motions of its motors, and the reports that it owes the device.

use dmc_proto::device::{self, Event, Input, State, StopKind};
use dmc_proto::message::{AckCode, FrameNumber, Motor, Motors};

use super::book::Fault;

/// Motion of the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Doing {
    Rest,
    /// Motors move independently of each other.
    Single,
    /// All motors go to a frame, or jog.
    Together,
    Preparing,
    Prepared,
    Running,
    PostRoll,
    Stopping,
    /// At rest, and the report after a stop is outstanding.
    Halted,
}

/// State of the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Rig {
    pub(super) doing: Doing,
    /// Motors that move independently.
    pub(super) driven: Motors,
    /// Whether the emergency stop is pressed.
    pub(super) pressed: bool,
}

/// Report of the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Report {
    /// One motor has arrived, others have not.
    Arrived(Motor),
    /// All motors stand still.
    AtRest,
    /// The pass is over.
    PassEnd,
    /// The emergency stop was released.
    Released,
}

fn only(motor: Motor) -> Motors {
    [motor].into_iter().collect()
}

impl Rig {
    pub(super) const NEW: Self = Self { doing: Doing::Rest, driven: Motors::NONE, pressed: false };

    /// Reports that the rig owes.
    pub(super) fn reports(&self) -> Vec<Report> {
        let mut reports = match self.doing {
            Doing::Rest | Doing::Prepared => vec![],
            Doing::Running => vec![Report::PassEnd],
            Doing::Single if self.driven.0.count_ones() > 1 => {
                [Motor(1), Motor(2)].into_iter().map(Report::Arrived).collect()
            }
            _ => vec![Report::AtRest],
        };
        if self.pressed {
            reports.push(Report::Released);
        }
        reports
    }

    /// Makes a report.
    pub(super) fn report(&mut self, report: Report) -> Input<'static> {
        match report {
            Report::Arrived(motor) => {
                self.driven.0 &= !only(motor).0;
                Input::Rig(device::Report::Moving(self.driven))
            }
            Report::AtRest => {
                self.doing = if self.doing == Doing::Preparing { Doing::Prepared } else { Doing::Rest };
                self.driven = Motors::NONE;
                Input::Rig(device::Report::AtRest)
            }
            Report::PassEnd => Input::Rig(device::Report::PassEnd),
            Report::Released => {
                self.pressed = false;
                Input::Rig(device::Report::EmergencyStop(false))
            }
        }
    }

    /// Whether a motor moves.
    pub(super) const fn moves(&self) -> bool {
        !matches!(self.doing, Doing::Rest | Doing::Prepared | Doing::Halted)
    }

    /// Whether something moves, or would move at a signal of the operator, and is not coming to rest because of a stop.
    pub(super) const fn is_driven(&self) -> bool {
        !matches!(self.doing, Doing::Rest | Doing::Stopping | Doing::Halted)
    }

    pub(super) fn drives(&self, motor: Motor) -> bool {
        match self.doing {
            Doing::Single => self.driven.contains(motor),
            _ => self.is_driven() && motor == Motor(1),
        }
    }

    /// Follows an event, and checks whether the motion is allowed.
    pub(super) fn obey(&mut self, event: Event<'_>) -> Option<Fault> {
        let was = self.doing;
        let fits = match event {
            Event::Stop(StopKind::Motor(motor)) => {
                self.driven.0 &= !only(motor).0;
                return None;
            }
            Event::Stop(stop) => {
                self.driven = Motors::NONE;
                self.doing = match was {
                    // A hard stop is answered even if nothing moved, because the lock waits for the answer.
                    Doing::Rest if stop == StopKind::Hard => Doing::Halted,
                    Doing::Prepared => Doing::Halted,
                    Doing::Rest | Doing::Halted => was,
                    _ => Doing::Stopping,
                };
                return None;
            }
            Event::Move(motor, _) | Event::Jog(motor, ..) => {
                self.driven.0 |= only(motor).0;
                self.doing = Doing::Single;
                return (!matches!(was, Doing::Rest | Doing::Single)).then_some(Fault::MovesTwice);
            }
            Event::ToFrame(FrameNumber(_)) => {
                self.doing = Doing::Together;
                !matches!(was, Doing::Running | Doing::Stopping)
            }
            Event::JogAll(..) => {
                self.doing = Doing::Together;
                matches!(was, Doing::Rest | Doing::Together)
            }
            Event::Prepare(_) => {
                self.doing = Doing::Preparing;
                was == Doing::Rest
            }
            Event::Go => {
                self.doing = Doing::Running;
                was == Doing::Prepared
            }
            Event::NextPass(..) => was == Doing::Running,
            Event::PostRoll => {
                self.doing = Doing::PostRoll;
                was == Doing::Running
            }
            _ => return None,
        };
        (!fits).then_some(Fault::MovesTwice)
    }

    /// Whether the state of the device matches the motion of the rig.
    pub(super) const fn is_as(&self, state: State) -> bool {
        match state {
            State::Idle => matches!(self.doing, Doing::Rest),
            State::Moving => matches!(self.doing, Doing::Single),
            State::Stopping => matches!(self.doing, Doing::Stopping | Doing::Halted),
            State::ToFrame | State::JogAll => matches!(self.doing, Doing::Together),
            State::PreRoll => matches!(self.doing, Doing::Preparing),
            State::Ready => matches!(self.doing, Doing::Prepared),
            State::Running => matches!(self.doing, Doing::Running),
            State::PostRoll => matches!(self.doing, Doing::PostRoll),
            State::Locked => matches!(self.doing, Doing::Rest | Doing::Stopping | Doing::Halted),
            _ => false,
        }
    }
}

impl device::Rig for Rig {
    fn verdict(&self, _: &dmc_proto::HostMessage<'_>) -> dmc_proto::message::AckCode {
        dmc_proto::message::AckCode::OK
    }

    fn position(&self, _: Motor) -> dmc_proto::message::Steps {
        dmc_proto::message::Steps(0)
    }
}

/// Verdict of this rig on every message.
pub(super) const ALLOWS: AckCode = AckCode::OK;
