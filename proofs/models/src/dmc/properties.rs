//! Rules that must hold, and states that must be reached.

use dmc_proto::device::State;
use dmc_proto::host;
use stateright::Property;

use super::{Dmc, Fault, World};

/// Whether nothing can follow. Then no request may be open.
fn is_end(model: &Dmc, world: &World) -> bool {
    let mut actions = vec![];
    model.enabled(world, &mut actions);
    actions.is_empty()
}

fn is_over(world: &World) -> bool {
    let host = world.host();
    host.state() == host::State::Ready
        && world.book.open == 0
        && host.pending().count() == 0
        && host.progress().is_none()
        && host.unconfirmed_stops().count() == 0
        && matches!(world.device().state(), State::Idle | State::Ready)
}

fn may_begin(world: &World) -> bool {
    matches!(world.device().state(), State::PreRoll | State::Ready | State::Running)
}

/// Whether both agree on what is loaded, once no message is in flight.
fn agrees(world: &World) -> bool {
    let host = world.host();
    let is_settled =
        world.is_line_empty() && host.progress().is_none() && host.pending().count() == 0 && !world.book.unheard_boot;
    !is_settled || host.is_loaded().is_none_or(|is_loaded| is_loaded == world.device().is_loaded())
}

/// All rules and states.
pub(super) fn all() -> Vec<Property<Dmc>> {
    type P = Property<Dmc>;
    vec![
        P::always("a stop is sent first in the step of its request", |_, w| w.is_without(Fault::StopWaits)),
        P::always("a stop is obeyed in the step of its arrival", |_, w| w.is_without(Fault::StopIgnored)),
        P::always("motors that are reported as stopped do not move", |_, w| w.is_without(Fault::NotStopped)),
        P::always("a stop that is not confirmed is reported", |_, w| w.is_without(Fault::StopUntold)),
        P::always("each stop on a closed line is reported", |_, w| {
            w.host().state() != host::State::Offline || w.book.tells(w.host().unconfirmed_stops())
        }),
        P::always("a request that must not be repeated is sent once", |_, w| w.is_without(Fault::Repeats)),
        P::always("a request that was called off is not sent", |_, w| w.is_without(Fault::CalledOff)),
        P::always("one coordinated move at a time", |_, w| w.is_without(Fault::MovesTwice)),
        P::always("one unanswered motion request at a time", |_, w| w.is_without(Fault::AsksTwice)),
        P::always("a token ends once", |_, w| w.is_without(Fault::EndsTwice)),
        P::always("every run ends with all answered", |m, w| w.book.fault.is_some() || !is_end(m, w) || is_over(w)),
        P::always("both agree on what is loaded", |_, w| agrees(w)),
        P::always("the host knows of every motion that may begin", |_, w| !may_begin(w) || w.host().is_armed()),
        P::always("the host knows whether anything may move", |_, w| !w.rig.moves() || w.host().may_move()),
        P::always("the device knows what its motors do", |_, w| {
            w.book.fault.is_some() || w.rig.is_as(w.device().state())
        }),
        P::sometimes("an end", is_end),
        P::sometimes("every request is done", |m, w| w.has_done_all(m)),
        P::sometimes("a stop is confirmed", |_, w| w.book.stopped),
        P::sometimes("a stop is not confirmed", |_, w| w.book.unconfirmed),
    ]
}

impl World {
    fn is_without(&self, fault: Fault) -> bool {
        self.book.fault != Some(fault)
    }

    fn has_done_all(&self, model: &Dmc) -> bool {
        let before = model.before.unwrap_or_default().len();
        let tokens = model.wants.iter().enumerate().filter(|(_, want)| want.message().is_some());
        let all = tokens.fold(0, |all, (at, _)| all | 1 << (at + before));
        all != 0 && self.book.done & all == all
    }
}
