//! Effects of one call, and the clients that hear of them.

use super::Output;
use super::clients::Sessions;
use super::event::{Event, Ignored};
use super::transmit::{Contents, Destination, Positions, Transmit};
use crate::message::{ErrorCode, MotorAddress, Normalized, PlaybackState};

/// Effects of one call, and the clients that hear of them.
///
/// What the rig has to do is put in before the message that acknowledges it.
pub(super) struct Effects<'o, 'a> {
    pub(super) output: &'o mut Output<'a>,
    /// Clients that are told what happens: the unlocked ones.
    pub(super) told: Sessions,
    /// Client that sent the message.
    pub(super) asker: Sessions,
}

impl<'a> Effects<'_, 'a> {
    pub(super) fn event(&mut self, event: Event<'a>) {
        self.output.event(event);
    }

    // The code of the machine is made in the program, because the machine has a parameter. In firmware it has to be short.
    #[cfg_attr(not(target_os = "none"), inline)]
    pub(super) fn transmit(&mut self, destination: Destination, contents: Contents<'a>) {
        if destination != Destination::Sessions(Sessions::NONE) {
            self.output.transmit(Transmit { destination, contents });
        }
    }

    /// Answers the client that asked.
    pub(super) fn answer(&mut self, contents: Contents<'a>) {
        self.transmit(Destination::Sessions(self.asker), contents);
    }

    /// Tells all clients that are unlocked, and these.
    pub(super) fn tell(&mut self, others: Sessions, contents: Contents<'a>) {
        self.transmit(Destination::Sessions(self.told.with(others)), contents);
    }

    pub(super) fn answer_error(&mut self, code: ErrorCode, motor: MotorAddress) {
        self.answer(Contents::ErrorStatus { code, motor });
    }

    pub(super) fn tell_error(&mut self, code: ErrorCode, motor: MotorAddress) {
        self.tell(Sessions::NONE, Contents::ErrorStatus { code, motor });
    }

    /// Refuses what was asked. Only the client that asked hears of it, because nothing happened (decision K-S3).
    pub(super) fn refuse(&mut self, code: ErrorCode) {
        self.answer_error(code, MotorAddress::ALL);
    }

    /// Tells the state of the move.
    pub(super) fn status(&mut self, state: PlaybackState, elapsed: Normalized, photos: u32, positions: Positions) {
        // A stop is confirmed to the client that asked for it, locked or not.
        let also = if state == PlaybackState::FULL_STOP { self.asker } else { Sessions::NONE };
        self.tell(also, Contents::PlaybackStatus { state, elapsed, photos, positions });
    }

    pub(super) fn ignore(&mut self, why: Ignored) {
        self.event(Event::Ignored(why));
    }
}
