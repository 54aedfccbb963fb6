//! Whether something that was set in motion is not known to rest.

use std::collections::BTreeSet;

use dmc_proto::host::{Failure, Name, Send, Stop, Token, What};
use dmc_proto::message::{AckCode, CameraFlags, HostMessage, Motors};

use super::Answer;

/// What may move. It is only cleared by what proves that all is at rest, or stopping: the acknowledgement of a stop of
/// everything, a status without a motor that is not older than what moves, the end of what was followed to rest.
#[derive(Debug, Clone, Default)]
pub(super) struct Safety {
    /// What was asked, moves motors, and has not ended.
    asked: BTreeSet<Token>,
    /// Of these, what was sent.
    sent: BTreeSet<Token>,
    /// Whether something may move that is not asked any more.
    left: bool,
    shutter_open: bool,
}

impl Safety {
    pub(super) fn may_move(&self) -> bool {
        self.left || self.shutter_open || !self.sent.is_empty()
    }

    pub(super) const fn has_shutter_open(&self) -> bool {
        self.shutter_open
    }

    pub(super) fn asked(&mut self, token: Token, message: &HostMessage<'_>) {
        if message.starts_motion() {
            self.asked.insert(token);
        }
    }

    pub(super) fn sent(&mut self, send: &Send, message: &HostMessage<'_>) {
        if let HostMessage::GioCam(camera) = message {
            self.shutter_open |= camera.flags.contains(CameraFlags::SHUTTER);
        }
        match send.what {
            What::Named(Name::Message(token)) if self.asked.contains(&token) => {
                self.sent.insert(token);
            }
            // Of a sequence that is asked.
            What::ToFrame(_) | What::Go => self.left = true,
            _ => {}
        }
    }

    pub(super) fn done(&mut self, token: Token, message: Option<HostMessage<'_>>, answer: &Answer) {
        self.asked.remove(&token);
        let moves = self.sent.remove(&token);
        match message {
            // These are followed to rest.
            Some(
                HostMessage::RtPositionFrame(_)
                | HostMessage::RtJogAll(_)
                | HostMessage::RtRunMove(_)
                | HostMessage::RtShootFrame(_)
                | HostMessage::RtShootFrame2(_),
            ) => self.left = false,
            Some(HostMessage::GioCam(camera)) if !camera.flags.contains(CameraFlags::SHUTTER) => {
                self.shutter_open = false;
            }
            _ => self.left |= moves,
        }
        if let Answer::Moving(motors) = answer {
            self.status(*motors);
        }
    }

    pub(super) fn failed(&mut self, token: Token, message: Option<HostMessage<'_>>, failure: Failure) {
        self.asked.remove(&token);
        let was_sent = self.sent.remove(&token);
        match failure {
            _ if !was_sent => {}
            // Nobody knows what it was that arrived wrong, nor what moves.
            Failure::Refused(AckCode::ERR_CHECKSUM | AckCode::ERR_MOVING) => self.left = true,
            // It was only asked for once all stood on the first frame.
            Failure::Refused(_) if matches!(message, Some(HostMessage::RtRunMove(_))) => self.left = false,
            // What was refused moves nothing that did not move before.
            Failure::Refused(_) => {}
            _ => self.left = true,
        }
    }

    /// What is asked and sent later may be younger than this.
    pub(super) fn status(&mut self, moving: Motors) {
        if moving == Motors::NONE && self.sent.is_empty() {
            self.left = false;
        }
    }

    pub(super) fn stopped(&mut self, stop: Stop) {
        if matches!(stop, Stop::All | Stop::AllSilent) {
            (self.left, self.shutter_open) = (false, false);
        }
    }
}
