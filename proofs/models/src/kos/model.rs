//! Possible events, and the properties.

use kos_proto::Millis;
use kos_proto::device::{self, Report, playback};
use kos_proto::host::{self, Command, Event, MoveState, Outcome};
use kos_proto::message::ErrorCode;
use laws::world::{Fate, Faults};
use stateright::{Model, Property};

use super::{Action, Breach, Conduct, Kos, Link, MOTOR, SESSION, State, Told, Wish};

type Holds = fn(&Kos, &State) -> bool;

impl State {
    fn due(&self) -> Option<Millis> {
        self.both.host.wake.into_iter().chain(self.both.device.wake).min().map(|due| due.max(self.both.now))
    }
}

impl Model for Kos {
    type State = State;
    type Action = Action;

    fn init_states(&self) -> Vec<State> {
        vec![self.begin()]
    }

    fn actions(&self, state: &State, actions: &mut Vec<Action>) {
        if state.ledger.breached().is_some() {
            return;
        }
        let wishes = (0..).zip(&state.wishes).filter(|(_, left)| **left > 0);
        actions.extend(wishes.map(|(place, _)| Action::Wish(place)));
        let host_hears = state.link == Link::Up || matches!(state.link, Link::Cut { host: false, .. });
        if state.link.is_open_for_device() {
            actions.extend(state.both.up.fates().map(Action::ToDevice));
        }
        if host_hears {
            actions.extend(state.both.down.fates().map(Action::ToHost));
        }
        let cuts = state.link == Link::Up && state.cuts > 0;
        let opening = state.link == Link::Opening;
        let quiet = !host_hears || state.both.down.is_empty();
        let quiet = quiet && (!state.link.is_open_for_device() || state.both.up.is_empty());
        let goes_on = state.jumps > 0 && (quiet || !self.prompt);
        let due = state.due().filter(|&due| due == state.both.now || goes_on);
        let wakes = |wake: Option<Millis>| due.is_some() && wake.map(|wake| wake.max(state.both.now)) == due;
        let possible = [
            (opening, Action::Opens),
            (opening && state.cuts > 0, Action::OpensNot),
            (cuts, Action::Cut),
            (matches!(state.link, Link::Cut { host: false, .. }), Action::HostSees),
            (matches!(state.link, Link::Cut { device: false, .. }), Action::DeviceSees),
            (state.rig.can_arrive(), Action::Arrives),
            (state.failures > 0, Action::Fails),
            (wakes(state.both.host.wake), Action::HostWakes),
            (wakes(state.both.device.wake), Action::DeviceWakes),
        ];
        actions.extend(possible.into_iter().filter(|(can, _)| *can).map(|(_, action)| action));
    }

    fn next_state(&self, last: &State, action: Action) -> Option<State> {
        let mut next = last.clone();
        let state = &mut next;
        state.told = Told::default();
        let harmed = |fate| fate != Fate::Arrives;
        state.ledger.harmed |= matches!(action, Action::ToDevice(fate) | Action::ToHost(fate) if harmed(fate));
        match action {
            Action::Wish(place) => {
                let (wish, _) = self.script.get(usize::from(place))?;
                let left = state.wishes.get_mut(usize::from(place))?;
                *left -= 1;
                let (token, command) = (Self::token(place, *left), self.command(*wish));
                let input = host::Input::Command(token, command);
                let output = state.both.host.machine.clone().advance(state.both.now, input);
                let refused = |event: &Event<'_>| matches!(event, Event::Ended { token: ended, outcome: Outcome::Refused(_) } if *ended == token);
                // A refused request changes nothing that is not reached otherwise, except a stop without a connection.
                if !matches!(command, Command::Stop | Command::StopMotor(_)) && output.events().any(refused) {
                    return None;
                }
                self.host(state, input);
            }
            Action::ToDevice(fate) => {
                if let Some((message, is_undamaged)) = state.both.up.meet(fate) {
                    self.arrives_at_device(state, &message, is_undamaged);
                }
            }
            Action::ToHost(fate) => {
                if let Some((message, is_undamaged)) = state.both.down.meet(fate) {
                    self.arrives_at_host(state, &message, is_undamaged);
                }
            }
            Action::HostWakes => {
                state.go_on();
                self.host(state, host::Input::Wake);
            }
            Action::DeviceWakes => {
                state.go_on();
                self.device(state, device::Input::Wake);
            }
            Action::Opens => self.open(state),
            Action::OpensNot => {
                state.cuts -= 1;
                self.host(state, host::Input::LinkDown);
            }
            Action::Cut => {
                state.cuts -= 1;
                state.link = Link::Cut { host: false, device: false };
            }
            Action::HostSees => {
                state.both.down.cut();
                self.host(state, host::Input::LinkDown);
            }
            Action::DeviceSees => {
                let Link::Cut { host, .. } = state.link else { return None };
                state.both.up.cut();
                state.link = if host { Link::Down } else { Link::Cut { host, device: true } };
                self.device(state, device::Input::LinkDown(SESSION));
                if state.rig.is_driven(state.both.now) && !state.both.device.machine.playback().runs() {
                    state.ledger.breach(Breach::StopNotObeyed);
                }
            }
            Action::Arrives => {
                let report = state.rig.arrive()?;
                self.device(state, device::Input::Rig(report));
            }
            Action::Fails => {
                state.failures -= 1;
                self.device(state, device::Input::Rig(Report::Fault(MOTOR, ErrorCode::RUNAWAY)));
            }
        }
        Some(next)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        fn never(breach: Breach) -> Holds {
            match breach {
                Breach::StopNotSent => |_, state| state.ledger.breached() != Some(Breach::StopNotSent),
                Breach::StopNotObeyed => |_, state| state.ledger.breached() != Some(Breach::StopNotObeyed),
                Breach::TwoMoves => |_, state| state.ledger.breached() != Some(Breach::TwoMoves),
                Breach::TwoRequests => |_, state| state.ledger.breached() != Some(Breach::TwoRequests),
                Breach::Repeated => |_, state| state.ledger.breached() != Some(Breach::Repeated),
                Breach::StopForgotten => |_, state| state.ledger.breached() != Some(Breach::StopForgotten),
                Breach::NotOver => |_, state| state.ledger.breached() != Some(Breach::NotOver),
                Breach::EndedTwice => |_, state| state.ledger.breached() != Some(Breach::EndedTwice),
                Breach::NotStopped => |_, state| state.ledger.breached() != Some(Breach::NotStopped),
            }
        }
        let mut properties = vec![
            Property::always("a stop is sent first, in its step", never(Breach::StopNotSent)),
            Property::always("a stop that comes is obeyed in its step", never(Breach::StopNotObeyed)),
            Property::always("never two moves at once", never(Breach::TwoMoves)),
            Property::always("never two unanswered motion requests", never(Breach::TwoRequests)),
            Property::always("nothing of the never-retry list is repeated", never(Breach::Repeated)),
            Property::always("no stop is given up silently", never(Breach::StopForgotten)),
            Property::always("a move that is reported as over is over", never(Breach::NotOver)),
            Property::always("every command ends once", never(Breach::EndedTwice)),
            Property::always("everything rests when a stop is reported as confirmed", never(Breach::NotStopped)),
            Property::always("no stop is confirmed before the motors are known", |kos: &Kos, state: &State| {
                kos.known == kos.password || !state.told.stopped
            }),
            // A doubled report that a motor rests may be taken for the next one.
            Property::always("the client knows that something may move", |kos: &Kos, state: &State| {
                let host = &state.both.host.machine;
                state.rig.rests(state.both.now) || host.may_move() || (kos.faults.doubled > 0 && state.ledger.harmed)
            }),
            Property::always("no command is open without a connection", |_: &Kos, state: &State| {
                state.both.host.machine.state().is_connected() || state.open == 0
            }),
            Property::always("every question and every stop ends in time", |_: &Kos, state: &State| {
                state.ends_in_time()
            }),
            Property::always("no move is played the other way once messages settle", |kos: &Kos, state: &State| {
                kos.conduct != Conduct::OtherWay
                    || !state.is_settled()
                    || state.both.device.machine.playback() != playback::State::Reverse
            }),
            Property::always("what the device does not know ends once messages settle", |kos: &Kos, state: &State| {
                let lacks = matches!(kos.conduct, Conduct::Lacks(_));
                !lacks || !state.is_settled() || state.open == 0
            }),
            Property::always("both agree on the move once messages settle", |_: &Kos, state: &State| {
                !state.is_settled() || state.agrees()
            }),
        ];
        // States that must be reached, so that the rules above mean something.
        let wants = |wishes: &[Wish]| self.script.iter().any(|(wish, _)| wishes.contains(wish));
        let plays =
            wants(&[Wish::Play, Wish::PlayDirect]) && matches!(self.conduct, Conduct::Mild | Conduct::DeafWhileLocked);
        let breaks = self.faults != Faults::default() || self.cuts > 0 || !self.prompt;
        let unlocks = self.known == self.password;
        let reached: [(bool, &'static str, Holds); 8] = [
            (unlocks, "a stop is confirmed", |_, state| state.told.stopped),
            (breaks, "a stop is not confirmed", |_, state| state.told.not_confirmed),
            (unlocks, "everything rests after a stop", |_, state| {
                let over = state.is_settled() && state.both.host.machine.move_state() == MoveState::NoMove;
                over && state.ledger.stopped && state.rig.rests(state.both.now)
            }),
            (plays, "a move is played to its end", |_, state| state.told.finished),
            (plays && self.cuts > 0, "a move is found again", |_, state| state.told.found),
            (wants(&[Wish::Ask]), "a question is answered", |_, state| state.told.answered),
            (wants(&[Wish::Ask]) && breaks, "a question is not answered", |_, state| state.told.failed),
            (self.cuts > 0, "a stop waits for a connection", |_, state| state.ledger.unstopped),
        ];
        let reached = reached.into_iter().filter(|(wanted, ..)| *wanted);
        properties.extend(reached.map(|(_, name, is_reached)| Property::sometimes(name, is_reached)));
        properties
    }
}

impl State {
    /// Advances time to the next deadline.
    fn go_on(&mut self) {
        if let Some(due) = self.due() {
            self.jumps -= u8::from(due > self.both.now);
            self.both.now = due;
        }
    }
}
