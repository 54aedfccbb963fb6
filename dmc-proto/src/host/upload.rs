//! The upload of a move, section by section: DMC D5.

use super::io::{Event, Failure, Name, What};
use super::requests::{Owner, Request};
use super::sequence::{Next, Reply};
use crate::message::{HostMessage, RtUploadMoveAxis, RtUploadMoveDmx, RtUploadMoveTriggers, StartIndex, Triggers};
use crate::upload::{Section, Track};

/// How far an upload is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Upload {
    /// The begin is on its way.
    Begins,
    /// The application is asked for the section behind this one.
    Wants(Option<Section>),
    /// This section is on its way.
    Sends(Section),
    /// The end is on its way.
    Ends,
}

impl Upload {
    /// What follows from an answer.
    pub(super) fn answered(&mut self, reply: Reply) -> Next {
        if let Reply::Failed(failure) = reply {
            return Next::Failed(failure);
        }
        let behind = match *self {
            Self::Begins => None,
            Self::Sends(section) => Some(section),
            Self::Wants(_) => return Next::Wait,
            Self::Ends => return Next::Done,
        };
        *self = Self::Wants(behind);
        Next::Tell(Event::NextSection(behind))
    }

    /// What follows from the application's next section.
    pub(super) fn section(&mut self, section: Option<Section>) -> Next {
        if !matches!(self, Self::Wants(_)) {
            return Next::Tell(Event::Ignored);
        }
        let request = if let Some(section) = section {
            *self = Self::Sends(section);
            Some(Request::named(Owner::Sequence, Name::Section(section), &sample(section)))
        } else {
            *self = Self::Ends;
            Request::own(Owner::Sequence, What::UploadEnd)
        };
        request.map_or(Next::Failed(Failure::Sequence), Next::Ask)
    }
}

/// A message of the type of a section, without its values.
fn sample(section: Section) -> HostMessage<'static> {
    let (start_index, tail): (_, &[u8]) = (StartIndex::default(), &[]);
    match section.track() {
        Track::Axis(motor) => {
            HostMessage::RtUploadMoveAxis(RtUploadMoveAxis { motor, start_index, positions: &[], tail })
        }
        Track::Channel(channel) => {
            HostMessage::RtUploadMoveDmx(RtUploadMoveDmx { channel, start_index, levels: &[], tail })
        }
        Track::Triggers => {
            HostMessage::RtUploadMoveTriggers(RtUploadMoveTriggers { mask: Triggers::NONE, pairs: &[], tail })
        }
    }
}
