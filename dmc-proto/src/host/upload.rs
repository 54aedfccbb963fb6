//! The upload of a move, section by section: DMC D5.

use motion_core::machine::Token;

use super::event::{Event, Outcome, Refusal};
use super::progress::Next;
use super::requests::{Owner, Reply, Request};
use super::transmit::{Contents, Source};
use crate::message::{HostMessage, RtUploadMoveAxis, RtUploadMoveDmx, RtUploadMoveTriggers};
use crate::upload::{Section, Track};

/// Phase of an upload.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Upload {
    /// The begin is on its way.
    Begins,
    /// The application is asked for the section after this one.
    Wants(Option<Section>),
    /// This section is on its way.
    Sends(Section),
    /// The end is on its way.
    Ends,
}

impl Upload {
    /// Next step after an answer.
    pub(super) fn answered(&mut self, token: Token, reply: &Reply<'_>) -> Next {
        match reply {
            Reply::Refused(code) => return Next::End(Outcome::Refused(Refusal::Device(*code))),
            Reply::Unclear => return Next::End(Outcome::NotConfirmed),
            Reply::Acknowledged | Reply::Answered(_) => {}
        }
        let after = match *self {
            Self::Begins => None,
            Self::Sends(section) => Some(section),
            Self::Wants(_) => return Next::Wait,
            Self::Ends => return Next::End(Outcome::Done(None)),
        };
        *self = Self::Wants(after);
        Next::Tell(Event::NextSection { token, after })
    }

    /// Next step after the application gave its next section.
    pub(super) fn section(&mut self, section: Option<Section>) -> Next {
        if !matches!(self, Self::Wants(_)) {
            return Next::Tell(Event::SectionNotWanted);
        }
        Next::Ask(if let Some(section) = section {
            *self = Self::Sends(section);
            Request::of_application(Owner::Sequence, Source::Section(section), &sample(section))
        } else {
            *self = Self::Ends;
            Request::own(Owner::Sequence, Contents::UploadEnd)
        })
    }
}

/// A message of the type of a section, without its values.
fn sample(section: Section) -> HostMessage<'static> {
    match section.track() {
        Track::Axis(motor) => RtUploadMoveAxis { motor, ..Default::default() }.into(),
        Track::Channel(channel) => RtUploadMoveDmx { channel, ..Default::default() }.into(),
        Track::Triggers => RtUploadMoveTriggers::default().into(),
    }
}
