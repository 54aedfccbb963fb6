//! Motors of a device: position, range, and motion by hand (kOS 7.3).

use motion_core::states;

use super::clients::{SessionId, Sessions};
use super::transmit::Positions;
use crate::message::{MOTORS, MotorAddress, MotorPlace, MotorSet, Rotations};

states! {
    /// State of the range of a motor.
    #[derive(Default)]
    pub enum State {
        /// Neither end is known.
        #[default]
        Uncalibrated,
        /// The begin is known.
        BeginMarked,
        /// Both ends are known.
        Calibrated,
    }
}

/// Motion of a motor by hand, outside a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Motion {
    /// The motor rests.
    #[default]
    Resting,
    /// The motor goes where this client sent it.
    Moving(SessionId),
    /// The motor was told to stop and does not rest yet. These clients wait for it although they are locked.
    Stopping(Sessions),
}

impl Motion {
    /// Names of all motions.
    pub const NAMES: [&'static str; 3] = ["Resting", "Moving", "Stopping"];

    /// Name of the motion.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Resting => "Resting",
            Self::Moving(_) => "Moving",
            Self::Stopping(_) => "Stopping",
        }
    }
}

/// Motor of a device.
///
/// The rig counts positions from anywhere; `zero` is where the count that clients see begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Drive {
    place: Places,
    state: State,
    motion: Motion,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
struct Places {
    /// Position of the motor, as the rig counts.
    rig: Rotations,
    /// Begin of the clients' count, as the rig counts.
    zero: Rotations,
    /// Range of the motor, as clients count.
    begin: Rotations,
    end: Rotations,
}

impl Drive {
    /// State of the range.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state
    }

    /// Motion by hand.
    #[must_use]
    pub const fn motion(&self) -> Motion {
        self.motion
    }

    /// Position, as clients count.
    #[must_use]
    pub fn position(&self) -> Rotations {
        Rotations(self.place.rig.0 - self.place.zero.0)
    }

    /// Range, as clients are told: the end is 0 if it is not known.
    #[must_use]
    pub const fn range(&self) -> (Rotations, Rotations) {
        match self.state {
            State::Calibrated => (self.place.begin, self.place.end),
            State::Uncalibrated | State::BeginMarked => (Rotations(0.0), Rotations(0.0)),
        }
    }

    /// Notes the position that the rig reports.
    pub(super) fn is_at(&mut self, rig: Rotations) {
        self.place.rig = rig;
    }

    pub(super) fn set_motion(&mut self, motion: Motion) {
        self.motion = motion;
    }

    /// Position to which the rig shall send the motor for a position that a client asks for: within the range, if that
    /// is known and the device `clamps`.
    pub(super) fn target(&self, position: Rotations, clamps: bool) -> Rotations {
        let Places { zero, begin, end, .. } = self.place;
        if self.state != State::Calibrated {
            return Rotations(zero.0 + position.0);
        }
        let length = end.0 - begin.0;
        let inside = if clamps { position.0.min(length.max(0.0)).max(length.min(0.0)) } else { position.0 };
        Rotations(zero.0 + begin.0 + inside)
    }

    /// Position to which the rig shall send the motor for a distance from here.
    pub(super) fn target_by(&self, delta: Rotations, clamps: bool) -> Rotations {
        let begin = if self.state == State::Calibrated { self.place.begin.0 } else { 0.0 };
        self.target(Rotations(self.position().0 - begin + delta.0), clamps)
    }

    /// Marks the begin of the range here. The old end does not count any more.
    pub(super) fn mark_begin(&mut self) {
        self.state = State::BeginMarked;
        self.place.begin = self.position();
    }

    /// Marks the end of the range here; `false` if the range has no begin, or no length.
    ///
    /// The count begins anew with the range, unless the device is one that keeps it (decision K-M8).
    pub(super) fn mark_end(&mut self, keep_count: bool) -> bool {
        let (begin, end) = (self.place.begin, self.position());
        if self.state != State::BeginMarked || end.0 - begin.0 == 0.0 {
            self.reset();
            return false;
        }
        self.state = State::Calibrated;
        if keep_count {
            self.place.end = end;
        } else {
            self.place.zero = Rotations(self.place.zero.0 + begin.0);
            self.place.begin = Rotations(0.0);
            self.place.end = self.position();
        }
        true
    }

    /// Forgets the range, and begins the count here.
    pub(super) fn reset(&mut self) {
        let Places { rig, .. } = self.place;
        self.state = State::Uncalibrated;
        self.place = Places { rig, zero: rig, ..Places::default() };
    }
}

/// Motors of a rig, by their numbers; `None` if a motor is not there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Drives([Option<Drive>; MOTORS]);

impl Drives {
    pub(super) fn new(motors: MotorSet) -> Self {
        let mut drives = Self::default();
        motors.iter().for_each(|motor| drives.set_online(motor, true));
        drives
    }

    fn place(&mut self, motor: MotorAddress) -> Option<&mut Option<Drive>> {
        self.0.get_mut(usize::from(motor.number()).checked_sub(1)?)
    }

    pub(super) fn get(&self, motor: MotorAddress) -> Option<&Drive> {
        self.0.get(usize::from(motor.number()).checked_sub(1)?)?.as_ref()
    }

    pub(super) fn get_mut(&mut self, motor: MotorAddress) -> Option<&mut Drive> {
        self.place(motor)?.as_mut()
    }

    /// Notes that a motor came or went. A motor that comes back begins anew: nobody knows where it was moved to.
    pub(super) fn set_online(&mut self, motor: MotorAddress, online: bool) {
        if let Some(place) = self.place(motor) {
            *place = online.then(Drive::default);
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (MotorAddress, &Drive)> {
        (1..=10).map(MotorAddress).zip(&self.0).filter_map(|(motor, drive)| Some((motor, drive.as_ref()?)))
    }

    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = (MotorAddress, &mut Drive)> {
        (1..=10).map(MotorAddress).zip(&mut self.0).filter_map(|(motor, drive)| Some((motor, drive.as_mut()?)))
    }

    /// Motors that are there.
    pub(super) fn online(&self) -> MotorSet {
        MotorSet::of(self.iter().map(|(motor, _)| motor))
    }

    /// Motors that do not rest.
    pub(super) fn moving(&self) -> MotorSet {
        MotorSet::of(self.iter().filter(|(_, drive)| drive.motion() != Motion::Resting).map(|(motor, _)| motor))
    }

    /// Positions of these motors, as far as they are there.
    pub(super) fn positions(&self, motors: MotorSet) -> Positions {
        let mut positions = Positions::new();
        for (motor, drive) in self.iter().filter(|&(motor, _)| motors.contains(motor)) {
            // There is room: both lists hold as many motors.
            let _ = positions.try_push(MotorPlace::new(motor, drive.position()));
        }
        positions
    }
}
